//! Zeros of sigma(s) = 1 + sum_r c_r/(s - p_r): the poles to which vector fitting moves.
//!
//! Eigenvalues of diag(p) - 1 c^T, 25 P^3 flops without knowledge; but near the end of a fit every zero is close to a
//! pole. Simultaneous iteration (Ehrlich 1967; Aberth 1973, *Math. Comp.* 27, 339) on the polynomial sigma(s) prod (s -
//! p_r), started from
//!
//! ```text
//! z_r = p_r - c_r/(1 + sum_(k != r) c_k/(p_r - p_k)),
//! ```
//!
//! takes some three rounds of P^2. Real zeros stay real and pairs pairs by symmetry: two that do not settle are tried
//! as the other kind. Where that does not converge either, the caller takes the eigenvalues.

use num_complex::Complex64;

use super::partial_fractions::is_pair;

/// Rounds after which what has not settled is tried as the other kind.
const ROUNDS_OF_A_KIND: usize = 8;
/// Rounds after which it has not converged.
const ROUNDS: usize = 4 * ROUNDS_OF_A_KIND;
/// Relative change of a zero that ends its iteration; convergence is cubic, so that the error is below rounding then.
const CHANGE: f64 = 1e-7;

/// A zero under iteration.
#[derive(Clone, Copy, Debug)]
struct Zero {
    /// Position; of a pair that above the axis.
    at: Complex64,
    pair: bool,
    settled: bool,
}

impl Zero {
    fn new(at: Complex64, pair: bool) -> Self {
        let at = if pair { Complex64::new(at.re, at.im.abs()) } else { at.re.into() };
        Self { at, pair, settled: false }
    }
}

/// The zeros, one of each pair (upper half plane) and all real ones, unsorted. `poles` and `residues` hold one of each
/// pair as well. `None`: no convergence.
pub(super) fn zeros(poles: &[Complex64], residues: &[Complex64]) -> Option<Vec<Complex64>> {
    // Conjugates included.
    let mut all: Vec<[Complex64; 2]> = Vec::with_capacity(2 * poles.len());
    for (&pole, &residue) in poles.iter().zip(residues) {
        all.push([pole, residue]);
        if is_pair(pole) {
            all.push([pole.conj(), residue.conj()]);
        }
    }
    // 1. Starting values near the poles.
    let mut zeros: Vec<Zero> = poles
        .iter()
        .zip(residues)
        .map(|(&pole, &residue)| {
            let others: Complex64 =
                all.iter().filter(|[other, _]| *other != pole).map(|&[other, c]| c / (pole - other)).sum();
            Zero::new(pole - residue / (1.0 + others), is_pair(pole))
        })
        .collect();
    // 2. Rounds over the zeros; each uses those that the round has already moved.
    for round in 1..=ROUNDS {
        for j in 0..zeros.len() {
            if !zeros[j].settled {
                zeros[j] = advanced(&all, &zeros, j)?;
            }
        }
        if zeros.iter().all(|zero| zero.settled) {
            return accepted(poles, residues, &zeros);
        }
        if round % ROUNDS_OF_A_KIND == 0 {
            regroup(&mut zeros);
        }
    }
    None
}

/// One step of the zero j. `None` where it is not finite.
fn advanced(all: &[[Complex64; 2]], zeros: &[Zero], j: usize) -> Option<Zero> {
    let Zero { at: z, pair, .. } = zeros[j];
    let Some(newton) = newton_step(all, z) else {
        // On a pole of residue 0: the zero cancels it.
        return Some(Zero { settled: true, ..zeros[j] });
    };
    let mut repulsion = Complex64::ZERO;
    for (k, other) in zeros.iter().enumerate() {
        if other.pair {
            repulsion += (z - other.at.conj()).inv();
        }
        if k != j {
            repulsion += (z - other.at).inv();
        }
    }
    let step = newton / (1.0 - newton * repulsion);
    let settled = step.norm() <= CHANGE * z.norm();
    step.is_finite().then(|| Zero { settled, ..Zero::new(z - step, pair) })
}

/// Tries what has not settled as the other kind: neighbouring real zeros as a pair, a pair close to the axis as two
/// real zeros.
fn regroup(zeros: &mut Vec<Zero>) {
    let (mut open, mut regrouped): (Vec<Zero>, Vec<Zero>) = zeros.iter().partition(|zero| !zero.settled);
    open.sort_by(|a, b| a.pair.cmp(&b.pair).then(a.at.re.total_cmp(&b.at.re)));
    let real = open.partition_point(|zero| !zero.pair);
    for two in open[..real].chunks(2) {
        match two {
            [a, b] => {
                let middle = 0.5 * (a.at.re + b.at.re);
                let apart = 0.5 * (a.at.re - b.at.re).abs().max(0.2 * middle.abs());
                regrouped.push(Zero::new(Complex64::new(middle, apart), true));
            }
            alone => regrouped.extend_from_slice(alone),
        }
    }
    for zero in &open[real..] {
        if zero.at.im < 0.2 * zero.at.re.abs() {
            regrouped.extend([0.8, 1.2].map(|factor| Zero::new(zero.at * factor, false)));
        } else {
            regrouped.push(*zero);
        }
    }
    *zeros = regrouped;
}

/// 1/(P'/P) of P = sigma prod (s - p_r). `None` on a pole.
fn newton_step(all: &[[Complex64; 2]], z: Complex64) -> Option<Complex64> {
    let (mut sigma, mut slope, mut logarithmic) = (Complex64::ONE, Complex64::ZERO, Complex64::ZERO);
    for &[pole, residue] in all {
        let difference = z - pole;
        if difference == Complex64::ZERO {
            return None;
        }
        let inverse = difference.inv();
        let term = residue * inverse;
        sigma += term;
        slope -= term * inverse;
        logarithmic += inverse;
    }
    // sigma = 0: z is a zero.
    if sigma == Complex64::ZERO { Some(Complex64::ZERO) } else { Some(sigma / (slope + logarithmic * sigma)) }
}

/// The zeros, if they are distinct and their sum is right: sum z = sum p - sum c.
fn accepted(poles: &[Complex64], residues: &[Complex64], zeros: &[Zero]) -> Option<Vec<Complex64>> {
    let (mut sum, mut size) = (0.0, 0.0);
    let mut add = |value: Complex64, pair: bool, sign: f64| {
        let count = if pair { 2.0 } else { 1.0 };
        sum += sign * count * value.re;
        size += count * value.norm();
    };
    for (&pole, &residue) in poles.iter().zip(residues) {
        add(pole, is_pair(pole), -1.0);
        add(residue, is_pair(pole), 1.0);
    }
    zeros.iter().for_each(|zero| add(zero.at, zero.pair, 1.0));
    let apart = |(i, a): (usize, &Zero)| zeros[..i].iter().all(|b| (a.at - b.at).norm() > CHANGE * a.at.norm());
    // A pair that has come to lie on the axis would be a double zero.
    let kinds = zeros.iter().all(|zero| !zero.pair || zero.at.im > CHANGE * zero.at.norm());
    (sum.abs() <= CHANGE * size && kinds && zeros.iter().enumerate().all(apart))
        .then(|| zeros.iter().map(|zero| zero.at).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sigma(poles: &[Complex64], residues: &[Complex64], s: Complex64) -> Complex64 {
        let terms = poles.iter().zip(residues).map(|(&p, &c)| {
            let term = c / (s - p);
            if is_pair(p) { term + c.conj() / (s - p.conj()) } else { term }
        });
        terms.sum::<Complex64>() + 1.0
    }

    #[test]
    fn zeros_are_zeros_and_all_of_them() {
        let pole = |k: f64| Complex64::new(-20.0 * k, 300.0 * k * k);
        let mut poles: Vec<_> = (1..12).map(|k| pole(f64::from(k))).collect();
        poles.push((-5.0).into());
        poles.push((-4e4).into());
        for size in [1e-3, 0.1, 0.5] {
            let residues: Vec<_> = poles
                .iter()
                .enumerate()
                .map(|(i, p)| {
                    let c = Complex64::new((i as f64).sin(), (3.0 * i as f64).cos()) * p.re.abs() * size;
                    if is_pair(*p) { c } else { c.re.into() }
                })
                .collect();
            let found = zeros(&poles, &residues).expect("converges");
            assert_eq!(super::super::partial_fractions::order(&found), 24);
            for (i, &zero) in found.iter().enumerate() {
                // Compared with the size of its terms.
                let terms: f64 = poles.iter().zip(&residues).map(|(p, c)| (c / (zero - p)).norm()).sum();
                assert!(sigma(&poles, &residues, zero).norm() < 1e-9 * (1.0 + terms), "size {size}, zero {i}");
                assert!(found[..i].iter().all(|other| (other - zero).norm() > 1e-3 * zero.norm()));
            }
        }
    }

    #[test]
    fn a_pole_without_a_share_stays() {
        let poles = [Complex64::new(-3.0, 40.0), Complex64::new(-7.0, 90.0)];
        let found = zeros(&poles, &[Complex64::ZERO, Complex64::new(0.1, 0.2)]).expect("converges");
        assert!(found.contains(&poles[0]));
    }

    #[test]
    fn zeros_may_change_their_kind() {
        // 1 + c/(s + 1) - c/(s + 2) = 0: s^2 + 3 s + 2 + c = 0, a pair for c > 1/4.
        let found = zeros(&[Complex64::new(-1.0, 0.0), Complex64::new(-2.0, 0.0)], &[5.0.into(), (-5.0).into()]);
        let found = found.expect("converges");
        assert_eq!(found.len(), 1);
        assert!((found[0] - Complex64::new(-1.5, 4.75_f64.sqrt())).norm() < 1e-12, "{}", found[0]);
        // 1 + (a s + b)/(s^2 + 2 s + 2) = (s + 1)(s + 3)/(...) with a = 2, b = 1: residue 1 + i/2 at -1 + i.
        let mut found = zeros(&[Complex64::new(-1.0, 1.0)], &[Complex64::new(1.0, 0.5)]).expect("converges");
        found.sort_by(|a, b| a.re.total_cmp(&b.re));
        assert_eq!(found.len(), 2);
        assert!((found[0] + 3.0).norm() < 1e-12 && (found[1] + 1.0).norm() < 1e-12, "{found:?}");
    }
}
