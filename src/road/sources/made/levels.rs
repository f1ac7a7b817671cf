//! One level of a drawn road: waves of some octaves, in blocks that fade into each other.
//!
//! A patch of block length L and lateral period P is a Fourier series with independent random coefficients,
//!
//! ```text
//! z(x, y) = Re sum over m >= 0 and n of c_mn exp(2 pi i (n x/L + m y/P)),
//! ```
//!
//! real and imaginary part of c_mn of variance s_m S_mn/(L P), s_0 = 1, s_m = 2, S_mn the mean of S(n/L, ky) over the
//! m-th cell of ky, 1/P wide: the profile spectrum along x is then exact whatever P.
//!
//! 1. Coefficients: random numbers addressed by level, m, block and n, so that a patch is the same whenever and by
//!    whichever thread it is drawn, and however many of its waves a run resolves.
//! 2. A transform along for each m gives the amplitudes of cos(2 pi m y/P) and sin(2 pi m y/P) at the samples.
//! 3. Columns that mirror each other share the even sum and differ by the sign of the odd one: two matrix products,
//!    half as large each.
//!
//! Patches overlap by a sixteenth, eight longest wavelengths. There the old one is weighted by cos, the new one by sin
//! of an angle that turns smoothly from 0 to pi/2: the variance is the same everywhere, and the covariance at a lag r
//! is less by the factor cos of the angle's change over r.
//!
//! Single precision: rounding is 1e-6 of the height, less than a grain of dust.

use std::f64::consts::PI;
use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner, num_complex::Complex32};

use super::rings::RingSpectrum;
use super::rows::LANES;
use super::sizes::{FADE, LevelSizes, resolved};
use crate::numeric::in_parallel;
use crate::numeric::windowed_sinc::{Phases, WindowedSinc};
use crate::road::lattice::Lattice;

/// Sub-cells of a lateral cell over which S is averaged.
const SUBCELLS: usize = 16;
/// Part of the Nyquist wavenumber below which the low-pass is flat; a raised cosine from there to it.
const PASS: f64 = 0.8;
/// Random numbers reserved in a line's stream for each block: more than any line has waves.
const STRIDE: i64 = 1 << 20;
/// Phases of the interpolation between two samples; linear between them, the error some 1e-5 of the height.
const PLACES: usize = 256;
/// Samples along that one thread sums across at a time.
const ROWS: usize = 96;

/// Heights \[m\] of a block: rows of samples, with margins, in vectors.
pub(super) type Patch = Vec<[f32; LANES]>;

/// Waves of one range of wavenumbers.
pub(super) struct WaveLevel {
    sizes: LevelSizes,
    /// Number of the level among all levels of the spectrum, counted from the longest waves.
    number: u64,
    seed: u64,
    /// Root-mean-square real and imaginary parts of the coefficients, for |n| = 0, 1, ..., line by line.
    gains: Vec<Vec<f32>>,
    transform: Arc<dyn Fft<f32>>,
    columns: usize,
    /// Cosines and negative sines at the first half of the columns, line by line.
    shapes: [Vec<f32>; 2],
    /// Number of vectors in a row of samples.
    vectors: usize,
    interpolation: Phases<f32>,
}

/// Position of a row in a block, and its weights there and in the block before.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowPlace {
    /// Number of the block.
    pub block: i64,
    /// Position in the block, in samples.
    pub sample: f64,
    /// Weights of this block and the one before; their squares sum to 1.
    pub weights: [f64; 2],
}

impl WaveLevel {
    /// Prepares a level: coefficients' sizes, shapes across, and interpolation.
    pub(super) fn new(spectrum: &RingSpectrum, sizes: LevelSizes, number: u64, seed: u64, lattice: Lattice) -> Self {
        let [along, across] = resolved(lattice);
        let gains = in_parallel::made(sizes.lines, |m| gains(spectrum, &sizes, m, along, across));
        let half = lattice.columns.div_ceil(2);
        let phase = |m: usize, column: usize| 2.0 * PI * m as f64 * lattice.y(column) / sizes.period;
        let shape = |value: fn(f64) -> f64| -> Vec<f32> {
            (0..sizes.lines).flat_map(|m| (0..half).map(move |column| value(phase(m, column)) as f32)).collect()
        };
        let shapes = [shape(f64::cos), shape(|phase| -phase.sin())];
        let share = sizes.upper.min(along) * sizes.spacing();
        Self {
            number,
            seed,
            gains,
            transform: FftPlanner::new().plan_fft_inverse(sizes.samples),
            columns: lattice.columns,
            shapes,
            vectors: lattice.columns.div_ceil(LANES),
            interpolation: Phases::new(&WindowedSinc::new(share, 1.0 - share, 70.0), PLACES, |weight| weight as f32),
            sizes,
        }
    }

    /// Position of a row.
    pub(super) fn place(&self, lattice: &Lattice, row: i64) -> RowPlace {
        let fading = (self.sizes.samples / FADE) as f64;
        let pitch = self.sizes.samples as f64 - fading;
        let position = lattice.place(row, self.sizes.spacing());
        let block = (position / pitch).floor();
        let sample = position - block * pitch;
        let part = (sample / fading).clamp(0.0, 1.0);
        let weights = if part < 1.0 {
            let (sine, cosine) = (0.5 * PI * (0.5 * PI * part).sin().powi(2)).sin_cos();
            [sine, cosine]
        } else {
            [1.0, 0.0]
        };
        RowPlace { block: block as i64, sample, weights }
    }

    /// The samples of a patch from which a position is interpolated, from the first of them on, and their weights times
    /// `factor`.
    pub(super) fn samples<'a>(
        &self,
        patch: &'a Patch,
        sample: f64,
        factor: f64,
        weights: &mut Vec<f32>,
    ) -> &'a [[f32; LANES]] {
        weights.clear();
        weights.extend(self.interpolation.weights(sample).map(|weight| factor as f32 * weight));
        // The margin is as wide as the interpolation reaches.
        &patch[(sample.floor() as usize + 1) * self.vectors..]
    }

    /// Distance of successive blocks, in samples.
    pub(super) fn pitch(&self) -> f64 {
        (self.sizes.samples - self.sizes.samples / FADE) as f64
    }

    /// Draws a block; `amplitudes` is scratch: real parts, then imaginary ones, line by line.
    pub(super) fn patch(&self, block: i64, amplitudes: &mut Vec<f32>, heights: &mut Patch) {
        let (samples, vectors) = (self.sizes.samples, self.vectors);
        let parts = samples * self.sizes.lines;
        amplitudes.resize(2 * parts, 0.0);
        let (real, imaginary) = amplitudes.split_at_mut(parts);
        let lines = real.par_chunks_mut(samples).zip(imaginary.par_chunks_mut(samples)).enumerate();
        lines.for_each_init(Space::default, |space, (m, (re, im))| self.line(m, block, space, re, im));
        // As many rows of samples on either side as the interpolation reaches, continued with the period of the block.
        let (margin, length) = (self.interpolation.reach() * vectors, samples * vectors);
        heights.resize(length + 2 * margin, [0.0; LANES]);
        let inner = &mut heights[margin..margin + length];
        inner.par_chunks_mut(ROWS * vectors).enumerate().for_each_init(Vec::new, |halves, (number, rows)| {
            self.sum_across([real, imaginary], number * ROWS, halves, rows);
        });
        heights.copy_within(length..length + margin, 0);
        heights.copy_within(margin..2 * margin, length + margin);
    }

    /// Draws the amplitudes of a lateral wave's cosine and sine at the samples of a block.
    fn line(&self, m: usize, block: i64, space: &mut Space, real: &mut [f32], imaginary: &mut [f32]) {
        let Space { line, scratch, bytes, numbers } = space;
        let gains = &self.gains[m];
        line.clear();
        line.resize(self.sizes.samples, Complex32::default());
        scratch.resize(self.transform.get_inplace_scratch_len(), Complex32::default());
        // 1. A pair of random numbers for each n = -last ..= last.
        let last = gains.len().saturating_sub(1);
        numbers.resize(2 * (2 * last + 1), 0.0);
        let stream = (self.number << 32) | m as u64;
        pairs(self.seed, stream, block * STRIDE - last as i64, bytes, numbers);
        let (falling, rising) = numbers.as_chunks::<2>().0.split_at(last);
        // 2. Coefficients in the order of the transform: n = 0 ..= last at the begin, n = -1, -2, ... from the end.
        for ((wave, [re, im]), gain) in line.iter_mut().zip(rising).zip(gains) {
            *wave = Complex32::new(gain * re, gain * im);
        }
        for ((wave, [re, im]), gain) in line.iter_mut().rev().zip(falling.iter().rev()).zip(gains.iter().skip(1)) {
            *wave = Complex32::new(gain * re, gain * im);
        }
        // 3. Summed over n.
        self.transform.process_with_scratch(line, scratch);
        for ((value, re), im) in line.iter().zip(real).zip(imaginary) {
            (*re, *im) = (value.re, value.im);
        }
    }

    /// Sums the lateral waves to the heights at some samples along, from `first` on.
    fn sum_across(
        &self,
        [real, imaginary]: [&[f32]; 2],
        first: usize,
        halves: &mut Vec<f32>,
        rows: &mut [[f32; LANES]],
    ) {
        let (columns, samples, lines) = (self.columns, self.sizes.samples, self.sizes.lines);
        let (half, count) = (columns.div_ceil(2), rows.len() / self.vectors);
        halves.resize(2 * count * half, 0.0);
        let (even, odd) = halves.split_at_mut(count * half);
        for (parts, shapes, sums) in [(real, &self.shapes[0], &mut *even), (imaginary, &self.shapes[1], &mut *odd)] {
            let parts = MatRef::from_column_major_slice(parts, samples, lines).subrows(first, count);
            let shapes = MatRef::from_row_major_slice(shapes, lines, half);
            let sums = MatMut::from_row_major_slice_mut(sums, count, half);
            matmul(sums, Accum::Replace, parts, shapes, 1.0_f32, Par::Seq);
        }
        let rows = rows.as_flattened_mut().chunks_exact_mut(self.vectors * LANES);
        for ((row, even), odd) in rows.zip(even.chunks_exact(half)).zip(odd.chunks_exact(half)) {
            let row = &mut row[..columns];
            for (height, (even, odd)) in row.iter_mut().zip(even.iter().zip(odd)) {
                *height = even + odd;
            }
            for (height, (even, odd)) in row.iter_mut().rev().zip(even.iter().zip(odd)).take(columns / 2) {
                *height = even - odd;
            }
        }
    }
}

/// Work arrays for drawing one line.
#[derive(Default)]
struct Space {
    line: Vec<Complex32>,
    scratch: Vec<Complex32>,
    bytes: Vec<u8>,
    numbers: Vec<f32>,
}

/// Root-mean-square real and imaginary parts of c_mn for n = 0, 1, ..., as far as the level and the run's lattice go.
fn gains(spectrum: &RingSpectrum, sizes: &LevelSizes, m: usize, along: f64, across: f64) -> Vec<f32> {
    let cell = 1.0 / sizes.period;
    let sides = if m == 0 { 1.0 } else { 2.0 };
    let density = |kx: f64| {
        let sum: f64 = (0..SUBCELLS)
            .map(|sub| (m as f64 - 0.5 + (sub as f64 + 0.5) / SUBCELLS as f64) * cell)
            .map(|ky| kx * kx + ky * ky)
            .filter(|square| (sizes.lower * sizes.lower..sizes.upper * sizes.upper).contains(square))
            .map(|square| spectrum.density(square))
            .sum();
        sum / SUBCELLS as f64
    };
    let ky = m as f64 * cell;
    // Nothing beyond the circle of the highest wavenumber, as seen from the nearer side of the cell.
    let nearest = (ky - 0.5 * cell).max(0.0);
    let last = (sizes.upper * sizes.upper - nearest * nearest).max(0.0).sqrt().min(along);
    (0..)
        .map(|n| f64::from(n) / sizes.block)
        .take_while(|&kx| kx < last)
        .map(|kx| {
            let mean_square = sides * density(kx) * cell / sizes.block;
            (mean_square.sqrt() * low_pass(kx, along) * low_pass(ky, across)) as f32
        })
        .collect()
}

/// Gain of the low-pass: 1 up to `PASS` of the Nyquist wavenumber, 0 from that on.
fn low_pass(wavenumber: f64, nyquist: f64) -> f64 {
    let ratio = wavenumber / nyquist;
    if ratio <= PASS {
        1.0
    } else if ratio >= 1.0 {
        0.0
    } else {
        0.5 + 0.5 * (PI * (ratio - PASS) / (1.0 - PASS)).cos()
    }
}

/// Words of 32 bits that a pair takes.
const WORDS: u128 = 2;
/// Position of pair 0 in its stream: far enough in for any negative one.
const ORIGIN: i128 = 1 << 60;

/// Draws independent random numbers of mean 0 and variance 1 for the pairs `first` and following of a stream, the two
/// of a pair in succession: every call for the same pairs gives the same numbers. `bytes` is scratch.
///
/// A number is the sum of four random bytes: its kurtosis is 2.7, and that of a sum of n such numbers 3 - 0.3/n. They
/// are the parts of Fourier coefficients, of which each height sums some thousand, so that heights are Gaussian; and
/// they cost a tenth of the logarithm, root and cosine of the Box-Muller method.
fn pairs(seed: u64, stream: u64, first: i64, bytes: &mut Vec<u8>, numbers: &mut [f32]) {
    /// Variance of a sum of four bytes, (256^2 - 1)/12 each.
    const VARIANCE: f32 = 4.0 * 65_535.0 / 12.0;
    /// Mean of a sum of four bytes.
    const MEAN: f32 = 4.0 * 127.5;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    random.set_word_pos((ORIGIN + i128::from(first)) as u128 * WORDS);
    bytes.resize(4 * numbers.len(), 0);
    random.fill_bytes(bytes);
    let scale = VARIANCE.sqrt().recip();
    for (number, bytes) in numbers.iter_mut().zip(bytes.as_chunks::<4>().0) {
        let word = u32::from_le_bytes(*bytes);
        let pairs = (word & 0x00ff_00ff) + ((word >> 8) & 0x00ff_00ff);
        let sum = (pairs & 0xffff) + (pairs >> 16);
        *number = scale * (sum as i32 as f32 - MEAN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_belong_to_their_places_and_are_of_unit_variance() {
        let draw = |first: i64, count: usize| {
            let mut numbers = vec![0.0; 2 * count];
            pairs(7, 3, first, &mut Vec::new(), &mut numbers);
            numbers
        };
        let numbers = draw(-1000, 40_001);
        assert!(draw(-997, 6).iter().zip(&numbers[6..]).all(|(a, b)| a.to_bits() == b.to_bits()));
        let count = numbers.len() as f64;
        let mean = |power: i32| numbers.iter().map(|&x| f64::from(x).powi(power)).sum::<f64>() / count;
        // Five standard errors of 80 000 numbers.
        assert!(mean(1).abs() < 5.0 * (1.0 / 8e4_f64).sqrt());
        assert!((mean(2) - 1.0).abs() < 5.0 * (1.7 / 8e4_f64).sqrt());
        assert!((mean(4) - 2.7).abs() < 5.0 * (70.0 / 8e4_f64).sqrt());
        let cross: f64 = numbers.as_chunks::<2>().0.iter().map(|[a, b]| f64::from(a * b)).sum::<f64>() / (0.5 * count);
        assert!(cross.abs() < 5.0 / (0.5 * count).sqrt());
    }
}
