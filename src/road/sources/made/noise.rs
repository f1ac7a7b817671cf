//! Random numbers, addressable by position: the inner loop of a drawn road.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

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
pub(super) fn pairs(seed: u64, stream: u64, first: i64, bytes: &mut Vec<u8>, numbers: &mut [f32]) {
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
