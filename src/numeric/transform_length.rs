//! Lengths that suit a mixed-radix Fourier transform, and the cost of one.

/// Smallest even number >= `least` without prime factors above 5; at least 2.
pub fn transform_length(least: usize) -> usize {
    let smooth = |mut n: usize| {
        for prime in [2, 3, 5] {
            while n.is_multiple_of(prime) {
                n /= prime;
            }
        }
        n == 1
    };
    let mut length = least.max(2).next_multiple_of(2);
    while !smooth(length) {
        length += 2;
    }
    length
}

/// Multiply-adds of a complex transform: about 5/2 N log2 N, the logarithm rounded down. A real one takes half.
pub(crate) fn transform_multiply_adds(length: usize) -> f64 {
    2.5 * length as f64 * f64::from(length.max(2).ilog2())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_smooth_even_and_tight() {
        let lengths: Vec<usize> = [0, 1, 3, 7, 127, 255, 257, 703, 1023, 1999].map(transform_length).into();
        assert_eq!(lengths, [2, 2, 4, 8, 128, 256, 270, 720, 1024, 2000]);
    }
}
