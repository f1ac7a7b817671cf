//! How the waves of sub-cells remember forces: by the tread's modulus alone, as a sum of exponentials.
//!
//! Short waves have no inertia, and their compliance follows 1/mu(s). Relative to the rule's first rate s0,
//!
//! ```text
//! mu(s0)/mu(s) = kappa_0 + sum_r kappa_r/(1 + s tau_r),   c = kappa_0 f + sum_r kappa_r e_r,   e_r + tau_r e_r' = f
//! ```
//!
//! A force acts on its instant with the weight 1, and c without it is what is remembered. For mu ~ (s + corner)^a the
//! integral x^-a = sin(pi a)/pi int t^(1 - a)/(t + x) d ln t is summed at rates e^2 apart, which is exact to 1 %
//! between the slowest of them and s0 (a test).

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use crate::scene::{Law, Material};
use crate::storage::state::evolving;
use crate::time_rule::TimeRule;

/// Distance of the rates, as logarithms.
const SPACING: f64 = 2.0;
/// Fastest rate relative to s0.
const FASTEST: f64 = 15.0;
/// Slowest rate \[1/s\]: a cell is in contact for 5 ms.
const SLOWEST: f64 = 5.0;

/// kappa_r and tau_r \[s\] of a material; kappa_0 is what their sum at the first rate \[1/s\] lacks to 1.
fn parts(material: &Material, first_rate: f64) -> Vec<[f64; 2]> {
    let mut parts = Vec::new();
    if material.law == Law::PowerLaw {
        let (exponent, corner) = (2.0 * material.loss_factor.atan() / PI, TAU * material.corner_frequency);
        let scale = (first_rate + corner).powf(exponent) * (PI * exponent).sin() / PI * SPACING;
        let mut rate = FASTEST * first_rate;
        while rate > SLOWEST {
            let pole = rate + corner;
            parts.push([scale * rate.powf(1.0 - exponent) / pole, pole.recip()]);
            rate *= (-SPACING).exp();
        }
    }
    parts
}

/// e_r of one part, by cell, to single precision.
#[derive(Clone, Debug)]
struct Part {
    kappa: f32,
    /// Weight of a force in e_r at its own instant; that of what the rule knows from before is the rest to 1.
    of_force: f32,
    /// e_r at the step's beginning and at its stages before this one by a Runge-Kutta rule, else at the steps before.
    known: Vec<Vec<f32>>,
    /// e_r at the instant if it carried no force, but for the weight.
    base: Vec<f32>,
}

evolving!(Part: known);

/// Creep of the cells of a window.
#[derive(Clone, Debug)]
pub(super) struct Creep {
    parts: Vec<Part>,
    rule: TimeRule,
}

evolving!(Creep: parts);

impl Creep {
    /// Creep of cells that have never carried force, under a tread of a `material`.
    pub(super) fn new(material: Option<&Material>, rule: TimeRule, time_step: f64, cells: usize) -> Self {
        let first_rate = rule.first_rate(time_step);
        let zeros = || vec![0.0; cells];
        let part = |[kappa, tau]: [f64; 2]| Part {
            kappa: kappa as f32,
            of_force: (1.0 + first_rate * tau).recip() as f32,
            known: vec![zeros(); rule.stages().max(2)],
            base: zeros(),
        };
        let parts = material.map_or_else(Vec::new, |material| parts(material, first_rate));
        Self { parts: parts.into_iter().map(part).collect(), rule }
    }

    /// Moves on by some cells, which enter the window without force.
    pub(super) fn advance(&mut self, by: usize) {
        for known in self.parts.iter_mut().flat_map(|part| &mut part.known) {
            let rest = known.len() - by;
            known.copy_within(by.., 0);
            known[rest..].fill(0.0);
        }
    }

    /// Forgets the forces on some cells.
    pub(super) fn forget(&mut self, cells: Range<usize>) {
        self.parts.iter_mut().flat_map(|part| &mut part.known).for_each(|known| known[cells.clone()].fill(0.0));
    }

    /// Sets c without the forces of a stage, for some cells of the window.
    pub(super) fn remember(&mut self, stage: usize, cells: Range<usize>, out: &mut [f32]) {
        let [_, one, two] = self.rule.backward_difference();
        let weights = match self.rule.runge_kutta() {
            Some(method) => method.bases()[stage],
            None => [-one / (-one - two), -two / (-one - two), 0.0],
        };
        out.fill(0.0);
        for Part { kappa, of_force, known, base } in &mut self.parts {
            let base = &mut base[cells.clone()];
            base.fill(0.0);
            for (known, weight) in known.iter().zip(weights).filter(|(_, weight)| *weight != 0.0) {
                let weight = weight as f32;
                base.iter_mut().zip(&known[cells.clone()]).for_each(|(base, known)| *base += weight * known);
            }
            let carried = *kappa * (1.0 - *of_force);
            out.iter_mut().zip(&*base).for_each(|(out, base)| *out += carried * base);
        }
    }

    /// Takes the forces of a stage on the same cells.
    pub(super) fn push(&mut self, stage: usize, cells: Range<usize>, forces: &[f64]) {
        /// Forces below which a sum is forgotten, before it gets denormal \[N\].
        const FORGOTTEN: f32 = 1e-12;
        let is_last = stage + 1 == self.rule.stages();
        let is_backward = self.rule.runge_kutta().is_none();
        for Part { of_force, known, base, .. } in &mut self.parts {
            if is_backward {
                known.swap(0, 1);
            }
            let now = &mut known[if is_last { 0 } else { stage + 1 }][cells.clone()];
            for ((now, base), force) in now.iter_mut().zip(&base[cells.clone()]).zip(forces) {
                let value = base + *of_force * (*force as f32 - base);
                *now = if value.abs() > FORGOTTEN { value } else { 0.0 };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::tyre::layers::material::modulus;

    fn rubber() -> Material {
        Material {
            law: Law::PowerLaw,
            modulus: 8e6,
            loss_factor: 0.25,
            poisson: 0.49,
            density: 1150.0,
            reference_frequency: 1000.0,
            corner_frequency: 1.0,
            weights: Vec::new(),
            times: Vec::new(),
        }
    }

    const FIRST_RATE: f64 = 8e4;

    /// kappa_0 + sum_r kappa_r/(1 + s tau_r).
    fn sum(parts: &[[f64; 2]], s: Complex64) -> Complex64 {
        let of = |s: Complex64| parts.iter().map(|[kappa, tau]| kappa / (1.0 + s * tau)).sum::<Complex64>();
        1.0 + of(s) - of(FIRST_RATE.into())
    }

    #[test]
    fn the_sum_follows_the_modulus() {
        let parts = parts(&rubber(), FIRST_RATE);
        assert!(parts.len() < 8 && parts.iter().all(|[kappa, tau]| *kappa > 0.0 && *tau > 0.0));
        for frequency in [30.0, 100.0, 300.0, 1000.0, 3000.0] {
            let s = Complex64::new(0.0, TAU * frequency);
            let expected = modulus(&rubber(), FIRST_RATE.into()) / modulus(&rubber(), s);
            let found = sum(&parts, s);
            assert!((found - expected).norm() < 0.01 * expected.norm(), "{frequency} Hz: {found} {expected}");
        }
    }

    #[test]
    fn every_rule_remembers_a_held_force_as_the_sum_does() {
        let held = 0.01;
        for rule in TimeRule::ALL {
            let time_step = 1e-5;
            let mut creep = Creep::new(Some(&rubber()), rule, time_step, 3);
            let mut out = [0.0; 1];
            for _ in 0..(held / time_step) as usize {
                for stage in 0..rule.stages() {
                    creep.remember(stage, 1..2, &mut out);
                    creep.push(stage, 1..2, &[2.0]);
                }
            }
            creep.remember(0, 1..2, &mut out);
            let first_rate = rule.first_rate(time_step);
            let expected: f64 = parts(&rubber(), first_rate)
                .into_iter()
                .map(|[kappa, tau]| {
                    2.0 * kappa * (1.0 - (-held / tau).exp()) * (1.0 - (1.0 + first_rate * tau).recip())
                })
                .sum();
            assert!((f64::from(out[0]) - expected).abs() < 3e-3 * expected, "{}: {out:?} {expected}", rule.name());
        }
    }

    #[test]
    fn an_elastic_tread_has_no_memory() {
        assert!(parts(&Material { law: Law::Elastic, ..rubber() }, FIRST_RATE).is_empty());
    }
}
