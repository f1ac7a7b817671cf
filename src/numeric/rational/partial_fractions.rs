//! H(s) = constant + sum_r R_r/(s - lambda_r) with real coefficients in the time domain.
//!
//! A complex pole is stored once, Im lambda > 0, and stands for itself and its conjugate:
//! R/(s - lambda) + conj(R)/(s - conj(lambda)). A real pole has Im lambda = 0 and a real residue.
//! Pairs come first, in the order of rising |lambda|, then the real poles, likewise.

use num_complex::Complex64;

/// A sum of partial fractions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PartialFractions {
    /// Poles lambda \[1/s\]: pairs (Im > 0), then real ones (Im = 0).
    pub poles: Vec<Complex64>,
    /// Residues, in the order of the poles \[unit of H / s\].
    pub residues: Vec<Complex64>,
    /// Constant, the value for s -> infinity \[unit of H\].
    pub constant: f64,
}

impl PartialFractions {
    pub(crate) fn evaluate(&self, s: Complex64) -> Complex64 {
        evaluate(&self.poles, &self.residues, self.constant, s)
    }
}

/// Value at s; see the module for the convention.
pub(crate) fn evaluate(poles: &[Complex64], residues: &[Complex64], constant: f64, s: Complex64) -> Complex64 {
    poles
        .iter()
        .zip(residues)
        .fold(Complex64::new(constant, 0.0), |sum, (&pole, &residue)| sum + term(pole, residue, s))
}

/// One pole's contribution: that of the pair, or of the real pole.
pub(crate) fn term(pole: Complex64, residue: Complex64, s: Complex64) -> Complex64 {
    if is_pair(pole) {
        // (R (s - conj p) + conj R (s - p))/((s - p)(s - conj p)), with one division.
        let numerator = s * (2.0 * residue.re) - 2.0 * (residue * pole.conj()).re;
        numerator / ((s - pole) * (s - pole.conj()))
    } else {
        residue / (s - pole)
    }
}

pub(crate) fn is_pair(pole: Complex64) -> bool {
    pole.im > 0.0
}

/// Number of poles, conjugates counted: the real state variables that a time step has to move.
pub(crate) fn order(poles: &[Complex64]) -> usize {
    poles.iter().map(|&pole| if is_pair(pole) { 2 } else { 1 }).sum()
}

/// Brings poles into the stored order: pairs by rising |lambda|, then real ones by rising |lambda|.
pub(crate) fn sort(poles: &mut [Complex64]) {
    poles.sort_by(|a, b| is_pair(*b).cmp(&is_pair(*a)).then(a.norm_sqr().total_cmp(&b.norm_sqr())));
}

/// One pole (Im >= 0) of each conjugate pair of roots of a real polynomial, and its real roots, sorted.
pub(crate) fn fold_conjugates(roots: &[Complex64]) -> Vec<Complex64> {
    let mut poles: Vec<Complex64> = roots
        .iter()
        .filter(|root| root.im >= 0.0)
        .map(|&root| if root.im > 0.0 { root } else { Complex64::new(root.re, 0.0) })
        .collect();
    sort(&mut poles);
    poles
}

/// Mirrors unstable poles into the left half plane and keeps every pole off the axis by 1e-9 of its size.
pub(crate) fn stabilise(poles: &mut [Complex64]) {
    for pole in poles {
        let least = 1e-9 * pole.norm().max(f64::MIN_POSITIVE);
        pole.re = -pole.re.abs().max(least);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_is_its_two_conjugate_terms_and_real_on_the_real_axis() {
        let (pole, residue) = (Complex64::new(-3.0, 40.0), Complex64::new(2.0, -5.0));
        let model =
            PartialFractions { poles: vec![pole, (-7.0).into()], residues: vec![residue, 1.5.into()], constant: 0.25 };
        for s in [Complex64::new(0.0, 39.0), Complex64::new(5.0, -2.0), Complex64::new(12.0, 0.0)] {
            let direct = residue / (s - pole) + residue.conj() / (s - pole.conj()) + 1.5 / (s + 7.0) + 0.25;
            assert!((model.evaluate(s) - direct).norm() < 1e-14 * direct.norm());
            assert!((model.evaluate(s.conj()) - direct.conj()).norm() < 1e-14 * direct.norm());
        }
        assert!(model.evaluate(Complex64::new(4.0, 0.0)).im.abs() < 1e-16);
        assert_eq!(order(&model.poles), 3);
    }

    #[test]
    fn unstable_and_axis_poles_end_up_in_the_left_half_plane() {
        let mut poles = [Complex64::new(2.0, 1.0), Complex64::new(0.0, 5.0), Complex64::new(-1.0, 0.0)];
        stabilise(&mut poles);
        assert!(poles.iter().all(|pole| pole.re < 0.0));
        assert_eq!(poles[0], Complex64::new(-2.0, 1.0));
    }
}
