//! Entire functions of a squared argument and their divided differences, by power series.
//!
//! cosh sqrt(z) = sum z^j/(2j)! and sinh sqrt(z)/sqrt(z) = sum z^j/(2j+1)! have no branch points, and their first
//! divided differences f\[a, b\] = (f(a) - f(b))/(a - b) = sum h_(j-1)(a, b)/(2j)!, with the complete homogeneous
//! polynomials h_j(a, b) = a h_(j-1) + b^j, need no subtraction: they stay exact when a and b coincide.

use crate::numeric::ComplexField;

/// Largest |z| for which [`hyperbolic_pair`] reaches full double precision.
pub(super) const SERIES_LIMIT: f64 = 4.0;

/// First omitted term, relative to 1: 4^16/32! = 2e-26.
const TERMS: usize = 15;

/// 1/(2j)! and 1/(2j+1)!, j = 0..=TERMS.
const fn inverse_factorials() -> ([f64; TERMS + 1], [f64; TERMS + 1]) {
    let mut even = [1.0; TERMS + 1];
    let mut odd = [1.0; TERMS + 1];
    let mut j = 1;
    while j <= TERMS {
        even[j] = odd[j - 1] / (2 * j) as f64;
        odd[j] = even[j] / (2 * j + 1) as f64;
        j += 1;
    }
    (even, odd)
}

const EVEN: [f64; TERMS + 1] = inverse_factorials().0;
const ODD: [f64; TERMS + 1] = inverse_factorials().1;

/// Values at `a` and divided differences over `a`, `b` of c(z) = cosh sqrt(z) and s(z) = sinh sqrt(z)/sqrt(z).
#[derive(Clone, Copy, Debug)]
pub(super) struct HyperbolicPair<T> {
    /// c(a).
    pub cosh: T,
    /// s(a).
    pub sinhc: T,
    /// c\[a, b\].
    pub cosh_difference: T,
    /// s\[a, b\].
    pub sinhc_difference: T,
}

/// By series, for |a|, |b| <= [`SERIES_LIMIT`].
#[inline(always)]
pub(super) fn hyperbolic_pair<T: ComplexField>(a: T, b: T) -> HyperbolicPair<T> {
    let one = a.like(1.0);
    let (mut power_a, mut power_b, mut homogeneous) = (one, one, one);
    let mut pair =
        HyperbolicPair { cosh: one, sinhc: one, cosh_difference: a.like(EVEN[1]), sinhc_difference: a.like(ODD[1]) };
    for j in 1..=TERMS {
        power_a = power_a * a;
        pair.cosh = pair.cosh + power_a * EVEN[j];
        pair.sinhc = pair.sinhc + power_a * ODD[j];
        if j < TERMS {
            power_b = power_b * b;
            homogeneous = homogeneous * a + power_b;
            pair.cosh_difference = pair.cosh_difference + homogeneous * EVEN[j + 1];
            pair.sinhc_difference = pair.sinhc_difference + homogeneous * ODD[j + 1];
        }
    }
    pair
}

/// (exp(z) - 1)/z for |z| < 1/2 by series.
#[inline(always)]
pub(super) fn exponential_quotient<T: ComplexField>(z: T) -> T {
    // Horner from z^13/14!; the first omitted term, 0.5^14/15! = 5e-17, is below rounding.
    let mut sum = z.like(1.0);
    let mut j = 14.0;
    while j > 1.5 {
        sum = z * sum * (1.0 / j) + 1.0;
        j -= 1.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;

    #[test]
    fn series_agree_with_closed_forms_and_with_the_derivative() {
        for (re, im) in [(3.9, 0.0), (-3.9, 0.1), (1e-9, 2.0), (-0.5, -3.0)] {
            let a = Complex64::new(re, im);
            let b = Complex64::new(0.3, -im);
            let pair = hyperbolic_pair(a, b);
            let (ra, rb) = (a.sqrt(), b.sqrt());
            let close = |x: Complex64, y: Complex64| assert!((x - y).norm() < 1e-14 * y.norm().max(1.0), "{x} {y}");
            close(pair.cosh, ra.cosh());
            close(pair.sinhc, ra.sinh() / ra);
            close(pair.cosh_difference, (ra.cosh() - rb.cosh()) / (a - b));
            close(pair.sinhc_difference, (ra.sinh() / ra - rb.sinh() / rb) / (a - b));
            let same = hyperbolic_pair(a, a);
            close(same.cosh_difference, ra.sinh() / ra * 0.5);
        }
    }

    #[test]
    fn exponential_quotient_keeps_all_digits() {
        for z in [Complex64::new(0.49, 0.0), Complex64::new(-0.3, 0.35), Complex64::new(1e-12, 0.0)] {
            let reference = if z.norm() < 1e-6 { Complex64::new(1.0, 0.0) + z * 0.5 } else { (z.exp() - 1.0) / z };
            assert!((exponential_quotient(z) - reference).norm() < 3e-15);
        }
    }
}
