//! Transforms for integration tests, which would compile the whole of rustfft once more if they planned others.

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

/// Plans the transform of x_k into sum_k x_k exp(-2 pi i j k/n).
pub fn forward(length: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_forward(length)
}

/// Plans the transform of x_k into sum_k x_k exp(2 pi i j k/n).
pub fn inverse(length: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_inverse(length)
}

/// Plans a transform as [`forward`], to the first half of a real sequence's.
pub fn real_forward(length: usize) -> Arc<dyn RealToComplex<f64>> {
    RealFftPlanner::new().plan_fft_forward(length)
}

/// Plans a transform as [`inverse`], from the first half to a real sequence.
pub fn real_inverse(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    RealFftPlanner::new().plan_fft_inverse(length)
}
