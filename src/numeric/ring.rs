//! Between the wavenumbers round a ring and its elements.

use std::sync::Arc;

use num_complex::Complex64;
use realfft::{ComplexToReal, RealFftPlanner};

/// Transforms real, even wavenumber sequences to the elements of the ring.
pub struct Ring {
    inverse: Arc<dyn ComplexToReal<f64>>,
    spectrum: Vec<Complex64>,
    elements: Vec<f64>,
    scratch: Vec<Complex64>,
}

impl Ring {
    /// A ring of N elements, N even.
    pub fn new(elements: usize) -> Self {
        let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(elements);
        let (spectrum, scratch) = (inverse.make_input_vec(), inverse.make_scratch_vec());
        Self { elements: inverse.make_output_vec(), inverse, spectrum, scratch }
    }

    /// sum over n = -N/2 ... N/2 - 1 of value(|n|) exp(2 pi i n j/N), j = 0..N.
    pub fn elements_of(&mut self, value: impl Fn(usize) -> f64) -> &[f64] {
        for (n, entry) in self.spectrum.iter_mut().enumerate() {
            *entry = value(n).into();
        }
        // Planned lengths and a real spectrum: nothing to refuse.
        let _ = self.inverse.process_with_scratch(&mut self.spectrum, &mut self.elements, &mut self.scratch);
        &self.elements
    }
}
