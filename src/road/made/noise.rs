//! White Gaussian noise, addressable by sample, and weighted sums of its rows: the inner loops of a drawn road, over vectors.

use std::f64::consts::PI;
use std::ops::Range;

use pulp::{Arch, NullaryFnOnce, Simd, WithSimd};
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

/// What one row is interpolated from.
#[derive(Clone, Debug)]
pub struct Taps {
    /// First sample.
    pub start: usize,
    /// Place of the weights of this sample and the following ones in the list of all.
    pub weights: Range<usize>,
}

/// Rows as weighted sums of rows of samples.
pub struct Interpolation<'a> {
    /// Heights, rows by columns, overwritten.
    pub heights: &'a mut [f64],
    /// The rows.
    pub rows: &'a [Taps],
    /// Weights of all rows.
    pub weights: &'a [f64],
    /// Samples by columns.
    pub samples: &'a [f64],
    /// Columns.
    pub columns: usize,
}

impl NullaryFnOnce for Interpolation<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { heights, rows, weights, samples, columns } = self;
        for (heights, row) in heights.chunks_exact_mut(columns).zip(rows) {
            heights.fill(0.0);
            let samples = samples[row.start * columns..].chunks_exact(columns);
            for (&weight, sample) in weights[row.weights.clone()].iter().zip(samples) {
                for (height, sample) in heights.iter_mut().zip(sample) {
                    *height += weight * sample;
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
