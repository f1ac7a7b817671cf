//! From influence functions to what the contact needs: the first weight G0, and the kernels of the history.
//!
//! w_(p)(j) = sum over n = -N/2 ... N/2 - 1 of w_(n,p) exp(2 pi i n j/N): displacement of the element j further on, p steps after a unit force.
//!
//! Tread laws:
//! - `elastic`: influence functions of the tread surface;
//! - `uncoupled`: the same history, but within a step each point only feels itself (the diagonal of G0);
//! - `bedding`: influence functions of the carcass with the tread as mass on it, and one independent spring per element in series.

use realfft::RealFftPlanner;

use super::error::ContactError;
use crate::scene::Tread;
use crate::tyre::convolution_quadrature::Weights;

/// Influence functions in the contact frame.
#[derive(Clone, Debug)]
pub struct ContactKernel {
    /// The tread law.
    pub law: Tread,
    /// G0 of the element j further on, j = 0..N (periodic) \[m/N\]; springs not included.
    pub instant: Vec<f64>,
    /// Static influence of the element j further on, j = 0..N \[m/N\]; springs not included.
    pub at_rest: Vec<f64>,
    /// Spring compliance per element \[m/N\]; 0 without springs.
    pub spring: f64,
    /// Kernels by lag p = 1..lags: see [`ContactKernel::lag`].
    lags: Vec<f64>,
    /// Entries per lag.
    row: usize,
}

impl ContactKernel {
    /// Transforms the weights of all wavenumbers to the elements a window of `columns` can see of itself, `substeps` steps per element.
    pub fn new(
        law: Tread,
        weights: &Weights,
        elements: usize,
        columns: usize,
        substeps: usize,
        spring: f64,
    ) -> Result<Self, ContactError> {
        let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(elements);
        let (mut spectrum, mut ring) = (inverse.make_input_vec(), inverse.make_output_vec());
        let mut scratch = inverse.make_scratch_vec();
        let mut transform = |value: &dyn Fn(usize) -> f64, ring: &mut Vec<f64>| {
            for (n, entry) in spectrum.iter_mut().enumerate() {
                *entry = value(n).into();
            }
            // Real spectra of the planned length: nothing to refuse.
            let _ = inverse.process_with_scratch(&mut spectrum, ring, &mut scratch);
        };
        transform(&|n| weights.of(n)[0], &mut ring);
        let instant = ring.clone();
        let eigenvalues = (0..=elements / 2).map(|n| elements as f64 * weights.of(n)[0] + spring);
        let (smallest, largest) = eigenvalues.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        if !(smallest > 0.0 && largest.is_finite()) {
            return Err(ContactError::NotPositive { smallest, largest });
        }
        transform(&|n| weights.at_rest[n], &mut ring);
        let at_rest = ring.clone();
        let row = padded(columns) + columns + 1;
        let mut lags = vec![0.0; row * weights.lags];
        for (p, kernel) in lags.chunks_exact_mut(row).enumerate().skip(1) {
            transform(&|n| weights.of(n)[p], &mut ring);
            let first = (p / substeps) as i64 - (columns as i64 - 1);
            for (i, value) in kernel.iter_mut().enumerate() {
                *value = ring[(first + i as i64).rem_euclid(elements as i64) as usize];
            }
        }
        Ok(Self { law, instant, at_rest, spring, lags, row })
    }

    /// Number of lags, lag 0 included.
    pub fn lags(&self) -> usize {
        self.lags.len() / self.row
    }

    /// Kernel of lag p: entry r is the influence on the element r - (columns - 1) + floor(p/q) further on.
    pub fn lag(&self, p: usize) -> &[f64] {
        &self.lags[p * self.row..(p + 1) * self.row]
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        8 * (self.lags.len() + self.instant.len() + self.at_rest.len())
    }
}

/// Columns rounded up to whole vectors of eight.
pub fn padded(columns: usize) -> usize {
    columns.div_ceil(8) * 8
}
