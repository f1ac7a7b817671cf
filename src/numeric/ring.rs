//! Between the wavenumbers round a ring and its elements.
//!
//! A real row g of a ring that turns is not even: its values at n and -n are conjugate, H_n = E_n + i O_n with real E
//! and O, and g_j = sum of E_n cos(2 pi n j/N) - O_n sin(2 pi n j/N) over n = -N/2 ... N/2 - 1.

use std::sync::Arc;

use num_complex::Complex64;
use realfft::{ComplexToReal, RealFftPlanner};

/// Transforms real, even wavenumber sequences to the elements of the ring; keeps its plan and buffers.
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

    /// Sum over n = -N/2 ... N/2 - 1 of value(|n|) exp(2 pi i n j/N), j = 0..N.
    pub fn elements_of(&mut self, value: impl Fn(usize) -> f64) -> &[f64] {
        self.transformed(|n| value(n).into())
    }

    /// Odd part of a row, sum over n = -N/2 ... N/2 - 1 of i sign(n) odd(|n|) exp(2 pi i n j/N), j = 0..N. `odd` of 0
    /// and of N/2, where both signs are one wave, does not count.
    pub fn odd_elements_of(&mut self, odd: impl Fn(usize) -> f64) -> &[f64] {
        let ends = [0, self.spectrum.len() - 1];
        self.transformed(|n| Complex64::new(0.0, if ends.contains(&n) { 0.0 } else { odd(n) }))
    }

    fn transformed(&mut self, value: impl Fn(usize) -> Complex64) -> &[f64] {
        for (n, entry) in self.spectrum.iter_mut().enumerate() {
            *entry = value(n);
        }
        // Refuses only wrong lengths and ends that are not real: neither occurs.
        let _ = self.inverse.process_with_scratch(&mut self.spectrum, &mut self.elements, &mut self.scratch);
        &self.elements
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn odd_rows_are_sums_of_sines() {
        let odd = |n: usize| (1.0 + n as f64).recip();
        let row = Ring::new(12).odd_elements_of(odd).to_vec();
        for (j, value) in row.iter().enumerate() {
            let sine = |n: usize| -2.0 * odd(n) * (TAU * (n * j) as f64 / 12.0).sin();
            assert!((value - (1..6).map(sine).sum::<f64>()).abs() < 1e-14, "{j}: {value}");
        }
    }
}
