//! White Gaussian noise, addressable by sample, and weighted sums of it: the inner loops of a drawn road, over vectors.

use std::f64::consts::PI;

use pulp::{Arch, Simd, WithSimd};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::numeric::MOST_LANES;
use crate::numeric::lanes::{cos_sin, load, natural_logarithm, store};

/// Random words (32 bit) per pair: two 64-bit numbers.
const WORDS_PER_SAMPLE: u128 = 4;
/// Sample 0's place in its stream: far enough in for any negative coordinate.
const ORIGIN: i128 = 1 << 60;

/// Independent standard normal numbers (Box and Muller), `real[i]` and `imaginary[i]` from exactly two 64-bit random numbers of sample `first + i` of a stream: the same numbers
/// whenever and by whomever they are asked for.
pub fn normal_pairs(seed: u64, stream: u64, first: i64, real: &mut [f64], imaginary: &mut [f64]) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    random.set_word_pos((ORIGIN + i128::from(first)) as u128 * WORDS_PER_SAMPLE);
    let unit = 1.0 / (1_u64 << 53) as f64;
    for (radius, angle) in real.iter_mut().zip(imaginary.iter_mut()) {
        // In (0, 1], so that the logarithm is finite.
        *radius = ((random.next_u64() >> 11) + 1) as f64 * unit;
        *angle = 2.0 * PI * (random.next_u64() >> 11) as f64 * unit;
    }
    Arch::new().dispatch(BoxMuller { real, imaginary });
}

/// Turns uniform numbers and angles into normal ones, in place.
struct BoxMuller<'a> {
    real: &'a mut [f64],
    imaginary: &'a mut [f64],
}

impl WithSimd for BoxMuller<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (real, real_rest) = S::as_mut_simd_f64s(self.real);
        let (imaginary, imaginary_rest) = S::as_mut_simd_f64s(self.imaginary);
        for (re, im) in real.iter_mut().zip(imaginary) {
            (*re, *im) = normal_pair(simd, *re, *im);
        }
        if !real_rest.is_empty() {
            let (mut uniform, mut angle) = ([1.0; MOST_LANES], [0.0; MOST_LANES]);
            uniform[..real_rest.len()].copy_from_slice(real_rest);
            angle[..real_rest.len()].copy_from_slice(imaginary_rest);
            let (re, im) = normal_pair(simd, load(simd, &uniform), load(simd, &angle));
            real_rest.copy_from_slice(&store(simd, re)[..real_rest.len()]);
            imaginary_rest.copy_from_slice(&store(simd, im)[..imaginary_rest.len()]);
        }
    }
}

/// Two normal numbers from one in (0, 1] and an angle.
#[inline(always)]
fn normal_pair<S: Simd>(simd: S, uniform: S::f64s, angle: S::f64s) -> (S::f64s, S::f64s) {
    let radius = simd.sqrt_f64s(simd.mul_f64s(simd.splat_f64s(-2.0), natural_logarithm(simd, uniform)));
    let (cosine, sine) = cos_sin(simd, angle);
    (simd.mul_f64s(radius, cosine), simd.mul_f64s(radius, sine))
}

/// Weights of one row: where its samples begin, and where its weights end in the list of all.
#[derive(Clone, Copy, Debug)]
pub struct Taps {
    /// First sample.
    pub start: usize,
    /// One past the last weight; they begin where the row before ends.
    pub end: usize,
}

/// For every row the weighted sums of real and imaginary parts. `values[2 row]`, `values[2 row + 1]`.
pub struct Interpolation<'a> {
    /// Rows, in order.
    pub rows: &'a [Taps],
    /// Weights of all rows.
    pub weights: &'a [f64],
    /// Samples.
    pub real: &'a [f64],
    /// Samples.
    pub imaginary: &'a [f64],
}

impl WithSimd for Interpolation<'_> {
    type Output = Vec<[f64; 2]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; 2]> {
        let mut begin = 0;
        let mut values = Vec::with_capacity(self.rows.len());
        for &Taps { start, end } in self.rows {
            let weights = &self.weights[begin..end];
            begin = end;
            let samples = start..start + weights.len();
            values.push([
                weighted_sum(simd, weights, &self.real[samples.clone()]),
                weighted_sum(simd, weights, &self.imaginary[samples]),
            ]);
        }
        values
    }
}

#[inline(always)]
fn weighted_sum<S: Simd>(simd: S, weights: &[f64], samples: &[f64]) -> f64 {
    let (weights, weights_rest) = S::as_simd_f64s(weights);
    let (samples, samples_rest) = S::as_simd_f64s(samples);
    let mut sum = simd.splat_f64s(0.0);
    for (&sample, &weight) in samples.iter().zip(weights) {
        sum = simd.mul_add_e_f64s(sample, weight, sum);
    }
    let mut total = simd.reduce_sum_f64s(sum);
    for (sample, weight) in samples_rest.iter().zip(weights_rest) {
        total += sample * weight;
    }
    total
}

/// Adds the lateral shapes of all streams to some rows of heights.
pub struct LateralSum<'a> {
    /// Heights, rows by columns.
    pub heights: &'a mut [f64],
    /// Columns.
    pub columns: usize,
    /// First of the rows.
    pub first: usize,
    /// Amplitudes of cosine and sine by stream and row.
    pub components: &'a [Vec<[f64; 2]>],
    /// Cosines, then sines at the columns by stream.
    pub shapes: &'a [Vec<f64>],
}

impl WithSimd for LateralSum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (component, shape) in self.components.iter().zip(self.shapes) {
            let (cosines, sines) = shape.split_at(self.columns);
            let ((cosine_lanes, cosine_rest), (sine_lanes, sine_rest)) =
                (S::as_simd_f64s(cosines), S::as_simd_f64s(sines));
            for (row, &[a, b]) in self.heights.chunks_exact_mut(self.columns).zip(&component[self.first..]) {
                let (lanes, rest) = S::as_mut_simd_f64s(row);
                let (a_lanes, b_lanes) = (simd.splat_f64s(a), simd.splat_f64s(b));
                for ((height, &cosine), &sine) in lanes.iter_mut().zip(cosine_lanes).zip(sine_lanes) {
                    *height = simd.mul_add_e_f64s(a_lanes, cosine, simd.mul_add_e_f64s(b_lanes, sine, *height));
                }
                for ((height, cosine), sine) in rest.iter_mut().zip(cosine_rest).zip(sine_rest) {
                    *height += a * cosine + b * sine;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_belong_to_their_samples_and_are_standard_normal() {
        let draw = |first: i64, count: usize| {
            let (mut real, mut imaginary) = (vec![0.0; count], vec![0.0; count]);
            normal_pairs(7, 3, first, &mut real, &mut imaginary);
            (real, imaginary)
        };
        let (real, imaginary) = draw(-1000, 40_001);
        // Elsewhere in the vectors, and at the rest of a list.
        let (other, _) = draw(-997, 6);
        assert!(other.iter().zip(&real[3..]).all(|(a, b)| a.to_bits() == b.to_bits()));
        let count = real.len() as f64;
        let mean = |power: i32| real.iter().chain(&imaginary).map(|x| x.powi(power)).sum::<f64>() / (2.0 * count);
        // Five standard errors of 80 000 numbers.
        assert!(mean(1).abs() < 5.0 * (1.0 / 8e4_f64).sqrt());
        assert!((mean(2) - 1.0).abs() < 5.0 * (2.0 / 8e4_f64).sqrt());
        assert!((mean(4) - 3.0).abs() < 5.0 * (96.0 / 8e4_f64).sqrt());
        let cross: f64 = real.iter().zip(&imaginary).map(|(a, b)| a * b).sum::<f64>() / count;
        assert!(cross.abs() < 5.0 / count.sqrt());
    }
}
