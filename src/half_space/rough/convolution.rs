//! Two-dimensional real convolution on a zero-padded grid, for kernels even in both directions.
//!
//! output = K * input on nx x ny cells, through transforms of mx x my:
//!
//! 1. Real transforms of the nx input rows, padded to my; rows of zeros only are skipped.
//! 2. For eight columns of the half-spectrum at a time: gather, complex transform of length mx, product with the real
//!    spectrum of the even kernel, inverse transform, first nx values retained. A padded column is never stored.
//! 3. Inverse real transforms of the rows that are wanted.
//!
//! Rows and columns are independent and rayon shares them out; every value is computed the same way by whichever
//! thread. Eight columns (rows) at a time turn the transposition into whole cache lines.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftNum, FftPlanner};

use crate::numeric::transform_length;

/// Columns or rows that are transposed together.
const BLOCK: usize = 8;

/// Floating-point types of the transforms: single or double precision.
pub trait Precision: FftNum + Default + Into<f64> {}

impl<T: FftNum + Default + Into<f64>> Precision for T {}

fn rounded<T: Precision>(value: f64) -> T {
    // Every f64 has a nearest number of either precision.
    T::from_f64(value).unwrap_or_default()
}

/// Size of a row-major grid: rows along x, columns along y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Rows, along x.
    pub nx: usize,
    /// Columns, along y.
    pub ny: usize,
}

impl Extent {
    /// nx ny.
    pub fn cells(self) -> usize {
        self.nx * self.ny
    }
}

/// A convolution with one kernel on one grid, with its transforms and work arrays.
pub struct Convolution<T: Precision> {
    extent: Extent,
    padded: Extent,
    row_forward: Arc<dyn RealToComplex<T>>,
    row_inverse: Arc<dyn ComplexToReal<T>>,
    column_forward: Arc<dyn Fft<T>>,
    column_inverse: Arc<dyn Fft<T>>,
    /// Spectrum of the kernel over mx my, column by column: columns 0..=my/2 of rows 0..=mx/2.
    symbol: Vec<T>,
    rows: Vec<Complex<T>>,
    columns: Vec<Complex<T>>,
    /// True if a row has a number other than zero.
    live: Vec<bool>,
}

impl<T: Precision> Convolution<T> {
    /// From the spectrum of the kernel on the `padded` grid (even numbers of rows and columns, at least `extent`):
    /// `spectrum(i, j)` for wavenumbers 2 pi i/mx, 2 pi j/my per cell, i <= mx/2, j <= my/2. Periodic where `padded`
    /// is `extent`.
    pub fn from_spectrum(extent: Extent, padded: Extent, spectrum: impl Fn(usize, usize) -> f64 + Sync) -> Self {
        let mut this = Self::plan(extent, padded);
        let scale = 1.0 / padded.cells() as f64;
        let half = padded.nx / 2 + 1;
        this.symbol.par_chunks_mut(half).enumerate().for_each(|(j, column)| {
            for (i, value) in column.iter_mut().enumerate() {
                *value = rounded(spectrum(i, j) * scale);
            }
        });
        this
    }

    /// From the kernel itself, without wrap-around: `kernel(i, j)` at distances i, j >= 0 in cells.
    pub fn from_kernel(extent: Extent, kernel: impl Fn(usize, usize) -> f64 + Sync) -> Self {
        let padded = Extent { nx: transform_length(2 * extent.nx - 1), ny: transform_length(2 * extent.ny - 1) };
        let mut this = Self::plan(extent, padded);
        let (nc, half) = (padded.ny / 2 + 1, padded.nx / 2 + 1);
        // Even rows have real spectra; beyond the extent the kernel is never used.
        let forward = &this.row_forward;
        let mut rows = vec![T::default(); extent.nx * nc];
        rows.par_chunks_mut(nc).enumerate().for_each_init(
            || (forward.make_input_vec(), forward.make_output_vec(), forward.make_scratch_vec()),
            |(input, output, scratch), (i, row)| {
                input.fill(T::default());
                for j in 0..extent.ny {
                    let value = rounded(kernel(i, j));
                    input[j] = value;
                    input[(padded.ny - j) % padded.ny] = value;
                }
                let done = forward.process_with_scratch(input, output, scratch);
                debug_assert!(done.is_ok());
                for (value, complex) in row.iter_mut().zip(output) {
                    *value = complex.re;
                }
            },
        );
        let forward = &this.column_forward;
        let scale: T = rounded(1.0 / padded.cells() as f64);
        this.symbol.par_chunks_mut(half).enumerate().for_each_init(
            || (vec![Complex::default(); padded.nx], vec![Complex::default(); forward.get_inplace_scratch_len()]),
            |(line, scratch), (j, column)| {
                line.fill(Complex::default());
                for i in 0..extent.nx {
                    let value = Complex::from(rows[i * nc + j]);
                    line[i] = value;
                    line[(padded.nx - i) % padded.nx] = value;
                }
                forward.process_with_scratch(line, scratch);
                for (value, complex) in column.iter_mut().zip(line) {
                    *value = complex.re * scale;
                }
            },
        );
        this
    }

    fn plan(extent: Extent, padded: Extent) -> Self {
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        let nc = padded.ny / 2 + 1;
        Self {
            extent,
            padded,
            row_forward: real.plan_fft_forward(padded.ny),
            row_inverse: real.plan_fft_inverse(padded.ny),
            column_forward: complex.plan_fft_forward(padded.nx),
            column_inverse: complex.plan_fft_inverse(padded.nx),
            symbol: vec![T::default(); nc * (padded.nx / 2 + 1)],
            rows: vec![Complex::default(); extent.nx * nc],
            columns: vec![Complex::default(); extent.nx * nc],
            live: vec![false; extent.nx],
        }
    }

    /// output = K * input, both nx x ny row-major; rows for which `wanted` is false are left as they are.
    pub fn apply(&mut self, input: &[f64], output: &mut [f64], wanted: impl Fn(usize) -> bool + Sync) {
        debug_assert_eq!((input.len(), output.len()), (self.extent.cells(), self.extent.cells()));
        self.transform_rows(input);
        self.multiply_columns();
        self.restore_rows(output, wanted);
    }

    fn transform_rows(&mut self, input: &[f64]) {
        let ny = self.extent.ny;
        let nc = self.padded.ny / 2 + 1;
        let forward = &self.row_forward;
        self.rows.par_chunks_mut(nc).zip(&mut self.live).zip(input.par_chunks(ny)).with_min_len(BLOCK).for_each_init(
            || (forward.make_input_vec(), forward.make_scratch_vec()),
            |(line, scratch), ((row, live), input)| {
                *live = input.iter().any(|&value| value.abs() > 0.0);
                if *live {
                    for (value, &input) in line.iter_mut().zip(input) {
                        *value = rounded(input);
                    }
                    line[ny..].fill(T::default());
                    let done = forward.process_with_scratch(line, row, scratch);
                    debug_assert!(done.is_ok());
                }
            },
        );
    }

    fn multiply_columns(&mut self) {
        let (nx, mx) = (self.extent.nx, self.padded.nx);
        let nc = self.padded.ny / 2 + 1;
        let (rows, live, symbol) = (&self.rows, &self.live, &self.symbol);
        let (forward, inverse) = (&self.column_forward, &self.column_inverse);
        let half = mx / 2 + 1;
        // A stride that is not a power of two keeps the columns of a block out of each other's cache sets.
        let stride = mx + BLOCK;
        let scratch_length = forward.get_inplace_scratch_len().max(inverse.get_inplace_scratch_len());
        self.columns.par_chunks_mut(BLOCK * nx).enumerate().for_each_init(
            || (vec![Complex::default(); BLOCK * stride], vec![Complex::default(); scratch_length]),
            |(lines, scratch), (block, columns)| {
                let first = block * BLOCK;
                let width = columns.len() / nx;
                for line in lines.chunks_exact_mut(stride).take(width) {
                    line[..mx].fill(Complex::default());
                }
                for i in (0..nx).filter(|&i| live[i]) {
                    for (c, &value) in rows[i * nc + first..i * nc + first + width].iter().enumerate() {
                        lines[c * stride + i] = value;
                    }
                }
                for (c, (line, column)) in lines.chunks_exact_mut(stride).zip(columns.chunks_exact_mut(nx)).enumerate()
                {
                    let line = &mut line[..mx];
                    let symbol = &symbol[(first + c) * half..(first + c + 1) * half];
                    forward.process_with_scratch(line, scratch);
                    for (value, &factor) in line[..half].iter_mut().zip(symbol) {
                        *value = *value * factor;
                    }
                    for (value, &factor) in line[half..].iter_mut().rev().zip(&symbol[1..]) {
                        *value = *value * factor;
                    }
                    inverse.process_with_scratch(line, scratch);
                    column.copy_from_slice(&line[..nx]);
                }
            },
        );
    }

    fn restore_rows(&self, output: &mut [f64], wanted: impl Fn(usize) -> bool + Sync) {
        let Extent { nx, ny } = self.extent;
        let nc = self.padded.ny / 2 + 1;
        let (columns, inverse) = (&self.columns, &self.row_inverse);
        output.par_chunks_mut(BLOCK * ny).enumerate().for_each_init(
            || (vec![Complex::default(); BLOCK * nc], inverse.make_output_vec(), inverse.make_scratch_vec()),
            |(spectra, line, scratch), (block, output)| {
                let first = block * BLOCK;
                let height = output.len() / ny;
                if !(first..first + height).any(&wanted) {
                    return;
                }
                for c in 0..nc {
                    for (i, &value) in columns[c * nx + first..c * nx + first + height].iter().enumerate() {
                        spectra[i * nc + c] = value;
                    }
                }
                for (i, (spectrum, output)) in spectra.chunks_exact_mut(nc).zip(output.chunks_exact_mut(ny)).enumerate()
                {
                    if wanted(first + i) {
                        // Rounding may leave imaginary parts where a real signal has none.
                        spectrum[0].im = T::default();
                        spectrum[nc - 1].im = T::default();
                        let done = inverse.process_with_scratch(spectrum, line, scratch);
                        debug_assert!(done.is_ok());
                        for (output, &value) in output.iter_mut().zip(line.iter()) {
                            *output = value.into();
                        }
                    }
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn kernel(i: usize, j: usize) -> f64 {
        1.0 / (1.0 + 2.0 * i as f64 + (j as f64).powi(2))
    }

    #[test]
    fn agrees_with_the_double_sum_on_any_extent() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for (nx, ny) in [(1, 1), (1, 9), (9, 1), (7, 12), (17, 16), (30, 41)] {
            let extent = Extent { nx, ny };
            let mut convolution = Convolution::<f64>::from_kernel(extent, kernel);
            let input: Vec<f64> =
                (0..nx * ny).map(|k| if k / ny % 3 == 1 { 0.0 } else { rng.random::<f64>() - 0.5 }).collect();
            let mut output = vec![7.0; nx * ny];
            convolution.apply(&input, &mut output, |row| row != 2);
            for i in 0..nx {
                for j in 0..ny {
                    let sum: f64 =
                        (0..nx * ny).map(|k| kernel(i.abs_diff(k / ny), j.abs_diff(k % ny)) * input[k]).sum();
                    let expected = if i == 2 { 7.0 } else { sum };
                    assert!((output[i * ny + j] - expected).abs() < 1e-13, "{nx} x {ny} at ({i}, {j})");
                }
            }
        }
    }

    #[test]
    fn single_precision_rounds_but_agrees() {
        let extent = Extent { nx: 20, ny: 30 };
        let input: Vec<f64> = (0..600).map(|k| f64::from(k).sin()).collect();
        let (mut double, mut single) = (vec![0.0; 600], vec![0.0; 600]);
        Convolution::<f64>::from_kernel(extent, kernel).apply(&input, &mut double, |_| true);
        Convolution::<f32>::from_kernel(extent, kernel).apply(&input, &mut single, |_| true);
        let largest = double.iter().zip(&single).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest < 1e-5 && largest > 1e-12, "{largest:.1e}");
    }
}
