//! Tangential motion of the tread surface under normal forces.
//!
//! ```text
//! T_n(s) = (1/L) sum_p sinc^2(kx_p dx/2) sum_(m odd) (2/B) a_m^2 C_xz(kx_p, ky_m, s),   kx_p that of n + p N
//! ```
//!
//! in the same mean over the element and the contact width as H_n ([`crate::tyre::influence`]). It is odd in n and i
//! times a transfer function with real coefficients, which has the poles of H_n: the same waves, seen along x. So only
//! residues are fitted, over the model's poles that the band can feel, and a constant for the rest.
//!
//! Above the cut-off the tread is a half-space, whose surface moves sideways by (1 - 2 nu)/(2 mu k) at most: nearly
//! nothing for rubber. What is left out is bounded by that times the weight that is left.
//!
//! Cost: some hundred compliances for each sample, 40 of them and two for each resonance in the band, for each n.

use num_complex::Complex64;
use rayon::prelude::*;

use super::model::RationalModel;
use crate::numeric::rational::vector_fitting::regularised_residues;
use crate::numeric::rational::{RationalError, Samples};
use crate::scene::Tyre;
use crate::tyre::influence::Projection;
use crate::tyre::influence::kernel::Kernel;

/// Samples between the poles, evenly over the logarithm of the frequency; half of them again, in the gaps, check the
/// fit.
const SAMPLES: usize = 40;
/// Lowest sample \[rad/s\].
const LOWEST: f64 = 10.0;
/// Poles up to this many times the top of the band are fitted.
const REACH: f64 = 3.0;
/// What a pole's peak as large as the largest value costs in the fit, as an error: the poles of the normal motion
/// include some that the tangential one does not tell apart.
const RIDGE: f64 = 1e-5;
/// k h from which the tread is a half-space: exp(-2 k h) is nothing.
const DEEP: f64 = 18.0;
/// The same beside the shear waves: k over their wavenumber.
const SLOW: f64 = 4.0;

/// Residues of T_n/i over the poles of a model, n = 0..=N/2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TangentialModel {
    /// By n, in the order of the model's poles \[m/(N s)\].
    pub residues: Vec<Vec<Complex64>>,
    /// By n \[m/N\].
    pub constants: Vec<f64>,
    /// Largest error on fresh samples, relative to the largest |T_n| of all n.
    pub error: f64,
    /// Largest bound on what the sums leave out, likewise.
    pub omitted: f64,
    /// Evaluations of the compliance.
    pub evaluations: u64,
}

/// One wavenumber.
struct Fitted {
    residues: Vec<Complex64>,
    constant: f64,
    largest: f64,
    error: f64,
    omitted: f64,
    evaluations: u64,
}

/// Fits T_n up to `top` \[rad/s\] over a model's poles.
///
/// # Errors
/// [`RationalError`].
pub fn tangential_model(tyre: &Tyre, model: &RationalModel, top: f64) -> Result<TangentialModel, RationalError> {
    fit_all(&TangentialSum::new(tyre, model.elements, top), model, top)
}

/// The same for the waves of one lateral number, without a strip's shapes.
///
/// # Errors
/// [`RationalError`].
pub fn lateral_tangential_model(
    tyre: &Tyre,
    model: &RationalModel,
    top: f64,
    m: usize,
) -> Result<TangentialModel, RationalError> {
    fit_all(&TangentialSum { only: Some(m), ..TangentialSum::new(tyre, model.elements, top) }, model, top)
}

fn fit_all(sums: &TangentialSum, model: &RationalModel, top: f64) -> Result<TangentialModel, RationalError> {
    let fitted: Result<Vec<Fitted>, RationalError> =
        (0..=model.largest_wavenumber()).into_par_iter().map(|n| fit(sums, model, n, top)).collect();
    let mut all = TangentialModel::default();
    let mut largest = f64::MIN_POSITIVE;
    for wavenumber in fitted? {
        largest = largest.max(wavenumber.largest);
        all.error = all.error.max(wavenumber.error);
        all.omitted = all.omitted.max(wavenumber.omitted);
        all.evaluations += wavenumber.evaluations;
        all.residues.push(wavenumber.residues);
        all.constants.push(wavenumber.constant);
    }
    all.error /= largest;
    all.omitted /= largest;
    Ok(all)
}

fn fit(sums: &TangentialSum, model: &RationalModel, n: usize, top: f64) -> Result<Fitted, RationalError> {
    let Some(modes) = model.modes(n, model.driven) else {
        return Err(RationalError::NotFinite { stage: "the tangential motion" });
    };
    let felt: Vec<usize> = (0..modes.poles.len()).filter(|&index| modes.poles[index].norm() < REACH * top).collect();
    let poles: Vec<Complex64> = felt.iter().map(|&index| modes.poles[index]).collect();
    let spread = |part: f64| Complex64::new(0.0, LOWEST * (top / LOWEST).powf(part));
    let mut resonances: Vec<f64> = poles.iter().map(|pole| pole.im).filter(|im| (LOWEST..top).contains(im)).collect();
    resonances.sort_by(f64::total_cmp);
    // At the resonances and between them: the sharpest of them would slip through an even spread.
    let between = resonances.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let mut points: Vec<Complex64> =
        resonances.iter().copied().chain(between).map(|frequency| Complex64::new(0.0, frequency)).collect();
    points.extend((0..SAMPLES).map(|k| spread(k as f64 / (SAMPLES - 1) as f64)));
    let (mut evaluations, mut omitted) = (0, 0.0_f64);
    let mut sample = |s: &Complex64| {
        let value = sums.value(n, *s);
        evaluations += value.evaluations;
        omitted = omitted.max(value.omitted);
        // Without the factor i: real coefficients.
        value.value * -Complex64::i()
    };
    let responses: Vec<Complex64> = points.iter().map(&mut sample).collect();
    let largest = responses.iter().fold(0.0_f64, |largest, value| largest.max(value.norm()));
    let weight = if largest > 0.0 { largest.recip() } else { 1.0 };
    let samples =
        Samples { point_weights: vec![1.0; points.len()], points, responses: vec![responses], weights: vec![weight] };
    let fractions = regularised_residues(&samples, &poles, true, RIDGE)?.remove(0);
    let error = (0..SAMPLES / 2).fold(0.0_f64, |error, k| {
        let s = spread((2.0 * k as f64 + 0.5) / (SAMPLES - 1) as f64);
        error.max((sample(&s) - fractions.evaluate(s)).norm())
    });
    let mut all = vec![Complex64::ZERO; modes.poles.len()];
    for (index, residue) in felt.into_iter().zip(fractions.residues) {
        all[index] = residue;
    }
    Ok(Fitted { residues: all, constant: fractions.constant, largest, error, omitted, evaluations })
}

/// Relative accuracy of the compliance itself.
const KERNEL_TOLERANCE: f64 = 1e-6;

/// The sums T_n of a tyre.
#[derive(Clone, Debug)]
struct TangentialSum {
    kernel: Kernel,
    projection: Projection,
    /// The only lateral number, if it is one wave across and not a strip's sum.
    only: Option<usize>,
}

/// A value with what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TangentialValue {
    /// T_n \[m/N\].
    value: Complex64,
    /// Bound on what was left out \[m/N\].
    omitted: f64,
    /// Evaluations of the compliance.
    evaluations: u64,
}

impl TangentialSum {
    /// The sums of a tyre of N elements.
    fn new(tyre: &Tyre, elements: usize, top: f64) -> Self {
        let (kernel, projection) = (Kernel::new(tyre, top, KERNEL_TOLERANCE), Projection::new(tyre, elements));
        Self { kernel, projection, only: None }
    }

    /// Lateral numbers with their weights \[1/m\].
    fn numbers(&self) -> impl Iterator<Item = (usize, f64)> {
        let Projection { waves, .. } = self.projection;
        let strip = waves.lateral_numbers().take_while(|_| self.only.is_none());
        let strip = strip.map(|m| (m, self.projection.lateral_weight(m)));
        strip.chain(self.only.map(|m| (m, waves.lateral_norm(m))))
    }

    /// T_n(s), n from 0 to N/2.
    fn value(&self, n: usize, s: Complex64) -> TangentialValue {
        let at = self.kernel.at(s);
        let tread = at.tread();
        let slowest = tread.inertia_over_shear().norm().sqrt();
        let cut_off = (DEEP / tread.thickness).max(SLOW * slowest);
        let Projection { waves, .. } = self.projection;
        let (mut value, mut evaluations, mut weights) = (Complex64::ZERO, 0, 0.0);
        for alias in self.projection.aliases_below(n, cut_off) {
            let (kx, longitudinal) = (waves.kx(alias), self.projection.longitudinal_weight(alias));
            let below = |&(m, _): &(usize, f64)| kx * kx + waves.ky(m) * waves.ky(m) < cut_off * cut_off;
            for (m, lateral) in self.numbers().take_while(below) {
                let weight = longitudinal * lateral;
                value += weight * at.tangential(alias, m);
                weights += weight;
                evaluations += 1;
            }
        }
        // The half-space at rest; with the ratio r = mu/(lambda + 2 mu), 1 - 2 nu = r/(1 - r).
        let ratio = tread.modulus_ratio / (1.0 - tread.modulus_ratio);
        let compliance = 0.5 * ratio * tread.inverse_shear.norm() / cut_off;
        let total = self.only.map_or(self.projection.total_weight(), |m| waves.lateral_norm(m) / waves.circumference);
        let omitted = compliance * (total - weights).max(0.0);
        TangentialValue { value, omitted, evaluations }
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
    fn the_sum_is_odd_in_the_wavenumber_and_ends_within_its_bound() {
        let tyre = tyre(0.25);
        let sums = TangentialSum::new(&tyre, 32, 2e4);
        let s = Complex64::new(0.0, 3000.0);
        // N - n is the alias -n: the other direction.
        let (one, other) = (sums.value(5, s), sums.value(32 - 5, s));
        assert!((one.value + other.value).norm() < 1e-10 * one.value.norm() + one.omitted + other.omitted);
        assert!(one.value.norm() > 100.0 * one.omitted);
    }
}
