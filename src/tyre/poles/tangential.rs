//! Tangential motion of the tread surface under normal forces.
//!
//! ```text
//! T_n(s) = (1/L) sum_p sinc^2(kx_p dx/2) sum_(m odd) (2/B) a_m^2 C_xz(kx_p, ky_m, s),   kx_p that of n + p N
//! ```
//!
//! in the same mean over the element and the contact width as H_n ([`crate::tyre::influence`]). It is odd in n and i
//! times a transfer function with real coefficients, which has the poles of H_n: the same waves, observed along x. So
//! only residues are fitted, over the model's poles up to a few times the band's top, and a constant for the others.
//!
//! With rotation, T_n has a part that is even in n, too: Coriolis forces twist it where it moves outwards. With
//! real functions P and Q of s, n >= 0,
//!
//! ```text
//! T_n = i (P_n + i Q_n),   T_-n = -i (P_n - i Q_n)
//! ```
//!
//! so that T_n/i is to P and Q what H_n is to its even and odd part. P is 0 for n = 0 and n = N/2, Q is not; at rest Q
//! is 0.
//!
//! Above the cut-off the tread is a half-space, whose surface moves sideways by (1 - 2 nu)/(2 mu k) at most: nearly
//! nothing for rubber. The error of the sum is bounded by that times the remaining weight.
//!
//! Cost: some hundred compliances for each sample, 40 of them and two for each resonance in the band, for each n;
//! several samples in lockstep.

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::model::RationalModel;
use super::modes::WaveModes;
use crate::numeric::lanes::{dispatch, store};
use crate::numeric::rational::vector_fitting::regularised_residues;
use crate::numeric::rational::{PartialFractions, RationalError, Samples};
use crate::numeric::{Lanes, MOST_LANES, in_parallel, largest_or_zero};
use crate::scene::Tyre;
use crate::tyre::influence::Projection;
use crate::tyre::influence::kernel::{Kernel, KernelAt, LaneKernel};
use crate::tyre::influence::lane_sum::Below;
use crate::tyre::influence::parts::Parts;
use crate::tyre::influence::projection::Lateral;

/// Samples evenly over the logarithm of the frequency; half as many again, in the gaps, check the fit.
const SAMPLES: usize = 40;
/// Lowest sample \[rad/s\].
const LOWEST: f64 = 10.0;
/// Poles up to this many times the top of the band are fitted.
const REACH: f64 = 3.0;
/// Penalty in the fit of a pole's peak as large as the largest value, as an error: the poles of the normal motion
/// include some that the tangential one does not resolve.
const RIDGE: f64 = 1e-5;
/// k h from which on the tread is a half-space: exp(-2 k h) is negligible.
const DEEP: f64 = 18.0;
/// The same for the shear waves: k over their wavenumber.
const SLOW: f64 = 4.0;

/// Residues of T_n/i over the poles of a model, n = 0..=N/2: of a tyre that turns those of P_n and Q_n.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TangentialModel {
    /// By n, in the order of the model's poles \[m/(N s)\].
    pub residues: Vec<Vec<Complex64>>,
    /// Constants by n \[m/N\].
    pub constants: Vec<f64>,
    /// Residues of Q_n, in the same order; empty at rest.
    pub odd_residues: Vec<Vec<Complex64>>,
    /// Constants of Q_n by n; empty at rest.
    pub odd_constants: Vec<f64>,
    /// Largest error on fresh samples, relative to the largest |T_n| of all n.
    pub error: f64,
    /// Largest bound on the omitted part of the sums, relative to the same.
    pub omitted: f64,
    /// Evaluations of the compliance used.
    pub evaluations: u64,
}

impl TangentialModel {
    /// Modes of the tangential motion, from those of the normal motion of the same wavenumber n.
    pub(crate) fn modes<'a>(&'a self, n: usize, normal: WaveModes<'a>) -> WaveModes<'a> {
        let odd = self.odd_residues.get(n).map_or(&[][..], Vec::as_slice);
        WaveModes { residues: &self.residues[n], odd, constant: self.constants[n], ..normal }
    }
}

/// Fit of one wavenumber: of P_n and, of a tyre that turns, of Q_n.
struct FittedTangential {
    residues: Vec<Vec<Complex64>>,
    constants: Vec<f64>,
    largest: f64,
    error: f64,
    omitted: f64,
    evaluations: u64,
}

/// Fits T_n up to `top` \[rad/s\] over a model's poles.
pub(crate) fn tangential_model(tyre: &Tyre, model: &RationalModel, top: f64) -> Result<TangentialModel, RationalError> {
    fit_all(&TangentialSum::new(tyre, model.elements, top), model, top)
}

/// As [`tangential_model`] for the waves of one lateral number, without a strip's shapes.
pub(crate) fn lateral_tangential_model(
    tyre: &Tyre,
    model: &RationalModel,
    top: f64,
    m: usize,
) -> Result<TangentialModel, RationalError> {
    fit_all(&TangentialSum { only: Some(m), ..TangentialSum::new(tyre, model.elements, top) }, model, top)
}

fn fit_all(sums: &TangentialSum, model: &RationalModel, top: f64) -> Result<TangentialModel, RationalError> {
    let fitted = in_parallel::made(model.largest_wavenumber() + 1, |n| fit(sums, model, n, top));
    let mut all = TangentialModel::default();
    let mut largest = f64::MIN_POSITIVE;
    for wavenumber in fitted {
        let wavenumber = wavenumber?;
        largest = largest.max(wavenumber.largest);
        all.error = all.error.max(wavenumber.error);
        all.omitted = all.omitted.max(wavenumber.omitted);
        all.evaluations += wavenumber.evaluations;
        let places = [(&mut all.residues, &mut all.constants), (&mut all.odd_residues, &mut all.odd_constants)];
        for ((residues, constants), part) in
            places.into_iter().zip(wavenumber.residues.into_iter().zip(wavenumber.constants))
        {
            residues.push(part.0);
            constants.push(part.1);
        }
    }
    all.error /= largest;
    all.omitted /= largest;
    Ok(all)
}

fn fit(sums: &TangentialSum, model: &RationalModel, n: usize, top: f64) -> Result<FittedTangential, RationalError> {
    let Some(modes) = model.modes(n, model.driven) else {
        return Err(RationalError::NotFinite { stage: "the tangential motion" });
    };
    // 1. The poles that are fitted.
    let within_reach: Vec<usize> =
        (0..modes.poles.len()).filter(|&index| modes.poles[index].norm() < REACH * top).collect();
    let poles: Vec<Complex64> = within_reach.iter().map(|&index| modes.poles[index]).collect();
    let spread = |part: f64| Complex64::new(0.0, LOWEST * (top / LOWEST).powf(part));
    let mut resonances: Vec<f64> = poles.iter().map(|pole| pole.im).filter(|im| (LOWEST..top).contains(im)).collect();
    resonances.sort_by(f64::total_cmp);
    // 2. Samples at the resonances and between them, since the sharpest would slip through an even spread, and evenly.
    let between = resonances.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let mut points: Vec<Complex64> =
        resonances.iter().copied().chain(between).map(|frequency| Complex64::new(0.0, frequency)).collect();
    points.extend((0..SAMPLES).map(|k| spread(k as f64 / (SAMPLES - 1) as f64)));
    let checks: Vec<Complex64> =
        (0..SAMPLES / 2).map(|k| spread((2.0 * k as f64 + 0.5) / (SAMPLES - 1) as f64)).collect();
    // 3. The sums, and residues of all parts by regularised least squares.
    let (values, exact) = (sums.values(n, &points), sums.values(n, &checks));
    let omitted = values.iter().chain(&exact).fold(0.0_f64, |omitted, value| omitted.max(value.omitted));
    let evaluations = values.iter().chain(&exact).map(|value| value.evaluations).sum();
    let parts = if sums.turns { 2 } else { 1 };
    let responses: Vec<Vec<Complex64>> =
        (0..parts).map(|part| values.iter().map(|value| value.over_i[part]).collect()).collect();
    let size = |part: &Vec<Complex64>| part.iter().fold(0.0_f64, |largest, value| largest.max(value.norm()));
    let largest: f64 = responses.iter().map(size).sum();
    let weight = |part: &Vec<Complex64>| if size(part) > 0.0 { size(part).recip() } else { 1.0 };
    let weights = responses.iter().map(weight).collect();
    let samples = Samples { point_weights: vec![1.0; points.len()], points, responses, weights };
    let fractions = regularised_residues(&samples, &poles, true, RIDGE)?;
    // 4. The error: of either wave no more than the sum of the parts' errors.
    let deviations = checks.iter().zip(exact).map(|(&s, exact)| {
        fractions.iter().zip(exact.over_i).map(|(part, exact)| (exact - part.evaluate(s)).norm()).sum::<f64>()
    });
    let error = deviations.fold(0.0_f64, f64::max);
    let constants = fractions.iter().map(|part| part.constant).collect();
    let of_all = |part: PartialFractions| {
        let mut all = vec![Complex64::ZERO; modes.poles.len()];
        within_reach.iter().zip(part.residues).for_each(|(&index, residue)| all[index] = residue);
        all
    };
    let residues = fractions.into_iter().map(of_all).collect();
    Ok(FittedTangential { residues, constants, largest, error, omitted, evaluations })
}

/// Relative accuracy of the compliance.
const KERNEL_TOLERANCE: f64 = 1e-6;

/// The sums T_n of a tyre.
#[derive(Clone, Debug)]
struct TangentialSum {
    kernel: Kernel,
    projection: Projection,
    /// The only lateral number, for one wave across in place of a strip's sum.
    only: Option<usize>,
    turns: bool,
}

/// A value of T_n and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TangentialValue {
    /// P_n, which at rest is T_n/i, and Q_n \[m/N\]: functions with real coefficients.
    over_i: [Complex64; 2],
    /// Bound on the omitted part \[m/N\].
    omitted: f64,
    /// Evaluations of the compliance used.
    evaluations: u64,
}

impl TangentialSum {
    /// N = `elements`, for |s| up to `top` \[rad/s\].
    fn new(tyre: &Tyre, elements: usize, top: f64) -> Self {
        let (kernel, projection) = (Kernel::new(tyre, top, KERNEL_TOLERANCE), Projection::new(tyre, elements));
        Self { kernel, projection, only: None, turns: tyre.turns() }
    }

    /// Wavenumber above which the tread is a half-space \[1/m\].
    fn cut_off(at: &KernelAt) -> f64 {
        let tread = at.tread();
        (DEEP / tread.thickness).max(SLOW * tread.inertia_over_shear().norm().sqrt())
    }

    /// Sign of an alias in the part that is odd in it; 0 for n = 0 and n = N/2.
    fn sign_of_odd(&self, n: usize, alias: i64) -> f64 {
        if n == 0 || 2 * n == self.projection.elements { 0.0 } else { alias.signum() as f64 }
    }

    /// T_n at each s of a list, n from 0 to N/2.
    fn values(&self, n: usize, points: &[Complex64]) -> Vec<TangentialValue> {
        let at: Vec<KernelAt> = points.iter().map(|&s| self.kernel.at(s)).collect();
        let largest = at.iter().map(Self::cut_off).fold(0.0_f64, f64::max);
        let waves = self.projection.waves;
        let lateral = match self.only {
            Some(m) => vec![Lateral { m, ky: waves.ky(m), weight: waves.lateral_norm(m) }],
            None => self.projection.lateral_below(largest),
        };
        let mut values = Vec::with_capacity(points.len());
        dispatch(LaneValues { sums: self, n, lateral: &lateral, at: &at, values: &mut values });
        values
    }

    /// A value from its sum over waves, with their weights and number: adds the bound.
    fn value(&self, at: &KernelAt, over_i: [Complex64; 2], weights: f64, evaluations: u64) -> TangentialValue {
        // The half-space at rest; with the ratio r = mu/(lambda + 2 mu), 1 - 2 nu = r/(1 - r).
        let (tread, waves) = (at.tread(), self.projection.waves);
        let ratio = tread.modulus_ratio / (1.0 - tread.modulus_ratio);
        let compliance = 0.5 * ratio * tread.inverse_shear.norm() / Self::cut_off(at);
        let total = self.only.map_or(self.projection.total_weight(), |m| waves.lateral_norm(m) / waves.circumference);
        TangentialValue { over_i, omitted: compliance * (total - weights).max(0.0), evaluations }
    }
}

/// Values at several s in lockstep. A type, not a closure: see `lane_sum`.
struct LaneValues<'a> {
    sums: &'a TangentialSum,
    n: usize,
    lateral: &'a [Lateral],
    at: &'a [KernelAt],
    values: &'a mut Vec<TangentialValue>,
}

impl WithSimd for LaneValues<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { sums, n, lateral, at, values } = self;
        for group in at.chunks(S::F64_LANES) {
            // Lanes without a member repeat the last one.
            let members: [_; MOST_LANES] = std::array::from_fn(|lane| &group[lane.min(group.len() - 1)]);
            let kernel = LaneKernel::new(simd, members);
            let cut_offs = members.map(TangentialSum::cut_off);
            let around: Vec<i64> = sums.projection.aliases_below(n, largest_or_zero(&cut_offs)).collect();
            let mut parts = [Lanes::zero(simd); 2];
            let below = Below { projection: &sums.projection, around: &around, lateral, cut_offs: &cut_offs };
            let (weights, evaluations) = if sums.turns {
                below.visit(
                    simd,
                    #[inline(always)]
                    |alias, m, _, weight| {
                        // C_xz = even + i odd of a wave, i (P + i Q) of all.
                        let Parts { even, odd } = kernel.tangential_parts(alias.abs(), m);
                        let signed = |sign: f64| simd.mul_f64s(weight, simd.splat_f64s(sign));
                        parts[0] = parts[0].plus_weighted(signed(sums.sign_of_odd(n, alias)), odd);
                        parts[1] = parts[1].plus_weighted(signed(-1.0), even);
                    },
                )
            } else {
                below.visit(
                    simd,
                    #[inline(always)]
                    |alias, m, _, weight| {
                        parts[0] = parts[0].plus_weighted(weight, kernel.tangential_over_i(alias, m));
                    },
                )
            };
            let [p, q] = parts.map(Lanes::to_array);
            let weights = store(simd, weights);
            let done = group.iter().zip(p.into_iter().zip(q)).zip(weights).zip(evaluations);
            values.extend(done.map(|(((at, (p, q)), weights), number)| sums.value(at, [p, q], weights, number)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::tyre;
    use crate::tyre::poles::{FitOptions, fit as fit_model};

    #[test]
    fn the_normal_modes_poles_carry_the_tangential_motion() {
        let tyre = tyre(0.25);
        let model = fit_model(&tyre, &FitOptions::new(&tyre, 32, 20.0).with_tolerance(1e-4)).unwrap();
        let tangential = tangential_model(&tyre, &model, 2e4).unwrap();
        println!(
            "error {:.1e}, omitted {:.1e}, {} evaluations",
            tangential.error, tangential.omitted, tangential.evaluations
        );
        assert!(tangential.error < 1e-2 && tangential.omitted < 1e-2);
        assert!(tangential.residues[0].iter().all(|residue| residue.norm() < 1e-20), "the mean has no direction");
    }

    #[test]
    fn a_turning_tyres_tangential_motion_is_carried_both_ways_round() {
        let tyre = Tyre { curvature: true, angular_velocity: -100.0, ..tyre(0.25) };
        let model = fit_model(&tyre, &FitOptions::new(&tyre, 32, 20.0).with_tolerance(1e-4)).unwrap();
        let tangential = tangential_model(&tyre, &model, 2e4).unwrap();
        println!("error {:.1e}, omitted {:.1e}", tangential.error, tangential.omitted);
        assert!(tangential.error < 1e-2 && tangential.omitted < 1e-2);
        let sums = TangentialSum::new(&tyre, 32, 2e4);
        let (mut largest, mut worst, mut twist) = (0.0_f64, 0.0_f64, 0.0_f64);
        for n in 0..=16 {
            let modes = tangential.modes(n, model.modes(n, model.driven).unwrap());
            for frequency in [97.0, 640.0, 3100.0, 15e3] {
                let s = Complex64::new(0.0, frequency);
                let q = modes.evaluate_odd(s) + tangential.odd_constants[n];
                for (sign, i) in [(1, Complex64::i()), (-1, -Complex64::i())] {
                    let found = i * (modes.evaluate(s) + i * q);
                    let exact = of_full_kernel(&sums, sign * n as i64, s);
                    worst = worst.max((found - exact).norm());
                    largest = largest.max(exact.norm());
                }
                twist = if n == 0 { twist.max(q.norm()) } else { twist };
            }
        }
        assert!(worst < 1e-2 * largest, "{worst:e} of {largest:e}");
        assert!(twist > 1e-2 * largest, "what moves all of it outwards twists it: {twist:e} of {largest:e}");
    }

    /// Sum of the full kernel's C_xz over signed waves; n = N/2 and -N/2 are one on the ring: half of each.
    fn of_full_kernel(sums: &TangentialSum, n: i64, s: Complex64) -> Complex64 {
        let (at, projection) = (sums.kernel.at(s), &sums.projection);
        let cut_off = TangentialSum::cut_off(&at);
        let of = |sign: i64| {
            let mut sum = Complex64::ZERO;
            for alias in projection.aliases_below(n.unsigned_abs() as usize, cut_off).map(|alias| sign * alias) {
                for Lateral { m, ky, weight } in projection.lateral_below(cut_off) {
                    if projection.waves.kx(alias).hypot(ky) < cut_off {
                        sum += at.full(alias, m)[0][2] * (weight * projection.longitudinal_weight(alias));
                    }
                }
            }
            sum
        };
        if 2 * n.unsigned_abs() as usize == projection.elements { 0.5 * (of(1) + of(-1)) } else { of(n.signum() | 1) }
    }

    #[test]
    fn values_in_lockstep_are_those_of_the_full_kernel() {
        for (curvature, angular_velocity) in [(false, 0.0), (true, 0.0), (true, -100.0)] {
            let tyre = Tyre { curvature, angular_velocity, ..tyre(0.25) };
            let sums = TangentialSum::new(&tyre, 64, 2e4);
            let points: Vec<Complex64> = (0..11).map(|k| Complex64::new(0.0, 10.0 * 2f64.powi(k))).collect();
            let i = Complex64::i();
            // At rest the longest and the shortest wave have nothing but rounding.
            for n in if tyre.turns() { vec![0, 7, 32] } else { vec![7] } {
                for (&s, value) in points.iter().zip(sums.values(n, &points)) {
                    let [p, q] = value.over_i;
                    assert!(tyre.turns() || q == Complex64::ZERO);
                    for (sign, found) in [(1, i * (p + i * q)), (-1, -i * (p - i * q))] {
                        let sum = of_full_kernel(&sums, sign * n as i64, s);
                        let error = (found - sum).norm() / (sum.norm() + 1e-20);
                        assert!(error < 1e-9, "{curvature}, {angular_velocity}/s, n {n}, s {s}: {error:.1e}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_sum_is_odd_in_the_wavenumber_and_ends_within_its_bound() {
        let tyre = tyre(0.25);
        let sums = TangentialSum::new(&tyre, 32, 2e4);
        let s = Complex64::new(0.0, 3000.0);
        // N - n is the alias -n: the other direction.
        let [one, other] = [5, 32 - 5].map(|n| sums.values(n, &[s])[0]);
        let [p, of_other] = [one, other].map(|value| value.over_i[0]);
        assert!((p + of_other).norm() < 1e-10 * p.norm() + one.omitted + other.omitted);
        assert!(p.norm() > 100.0 * one.omitted);
    }
}
