//! The exact functions of one wavenumber, sampled where a fit wants them, and the errors of a model there.
//!
//! Samples on the *grid* are what fits may use; *fresh* ones, half-way between them, and every other one on the real
//! axis only check.
//!
//! Errors of the driven face are relative to its *local scale*, |H_n(s)| but no less than 0.003 of its largest value
//! over the band, and for the carcass under a bedding no less than the whole tyre's at rest; those of the belt to the
//! largest |D_n|.

use num_complex::Complex64;

use super::ladder::{Ladder, REAL_RUNGS, RUNGS};
use crate::numeric::rational::partial_fractions::is_pair;
use crate::numeric::rational::{PartialFractions, Parts, Samples};
use crate::tyre::influence_batch::FaceValues;

/// Smallest local scale of the driven face's errors, as a share of the largest |H_n|. The contact feels G0, H_n at
/// large s, where H_n is a hundredth of its resonances: with errors that are relative to those alone, forces are ten
/// times as wrong as the model. Measured on a rough road at N = 1024: 1e-5 with this floor takes as many poles as 1e-6
/// of the largest value, and the error of the force is a fifth; with 0.01 it is four times, with 0.0003 a fifth of that
/// with this one, for 2 % fewer and 3 % more poles.
const LEAST_SCALE: f64 = 3e-3;
/// Rungs that join the grid in one round.
const MOST_JOINING: usize = 12;

/// A rung of one of the ladders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rung {
    /// On the imaginary axis.
    Axis(usize),
    /// On the positive real axis.
    Real(usize),
}

/// Evaluates the exact functions on a list of rungs, in their order.
pub type Sample<'s> = dyn FnMut(&[Rung], &mut Vec<FaceValues>) + 's;

/// What is known of one wavenumber.
pub struct Sampled<'a> {
    pub ladder: &'a Ladder,
    /// Samples by rung of the axis: driven and innermost face.
    axis: Vec<Option<[Complex64; 2]>>,
    real: Vec<[Complex64; 2]>,
    /// Rungs that fits may use, rising.
    pub grid: Vec<usize>,
    /// Rungs that only check, rising.
    pub fresh: Vec<usize>,
    /// Further fresh rungs, where a model has a peak that is narrower than the samples are apart.
    probes: Vec<usize>,
    /// Largest |H_n| and |D_n| so far.
    pub scales: [f64; 2],
    /// The second scale, where it is given.
    bottom_scale: f64,
    /// Least local scale of the driven face.
    least_scale: f64,
    pub evaluations: u64,
}

/// Errors of a model, each relative to its scale (see the module).
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Worst of both faces on the grid and the odd real rungs.
    pub fitted: f64,
    /// Worst of both faces on the fresh rungs and the even real rungs.
    pub fresh: f64,
    /// Worst of both faces on the fresh rungs of the axis.
    pub between: f64,
    /// Fresh on the axis, driven face.
    pub axis: f64,
    /// Real axis, driven face.
    pub real: f64,
    /// Belt.
    pub bottom: f64,
    /// s where the error on the grid, or on the real axis if that is the worst of all, is largest.
    pub worst: Complex64,
}

impl Errors {
    pub fn largest(&self) -> f64 {
        self.fitted.max(self.fresh)
    }
}

impl<'a> Sampled<'a> {
    /// Nothing sampled yet. `bottom_scale` 0: the largest |D_n| of this wavenumber.
    pub fn new(ladder: &'a Ladder, grid: Vec<usize>, bottom_scale: f64, least_scale: f64) -> Self {
        Self {
            ladder,
            axis: vec![None; RUNGS + 1],
            real: Vec::new(),
            grid,
            fresh: Vec::new(),
            probes: Vec::new(),
            scales: [0.0; 2],
            bottom_scale,
            least_scale,
            evaluations: 0,
        }
    }

    /// Whether the belt moves more than a share of its scale anywhere.
    pub fn bottom_exceeds(&self, share: f64) -> bool {
        self.axis.iter().flatten().any(|value| value[1].norm_sqr() > (share * self.scales[1]).powi(2))
    }

    /// Brings `fresh` up to date with the grid and evaluates what is missing.
    pub fn refresh(&mut self, sample: &mut Sample<'_>) {
        self.fresh =
            self.grid.windows(2).filter(|pair| pair[1] - pair[0] > 1).map(|pair| (pair[0] + pair[1]) / 2).collect();
        let probes = self.probes.iter().filter(|probe| self.grid.binary_search(probe).is_err());
        self.fresh.extend(probes);
        self.fresh.sort_unstable();
        self.fresh.dedup();
        let mut wanted: Vec<Rung> = self
            .grid
            .iter()
            .chain(&self.fresh)
            .filter(|&&rung| self.axis[rung].is_none())
            .map(|&rung| Rung::Axis(rung))
            .collect();
        if self.real.is_empty() {
            self.real = vec![[Complex64::ZERO; 2]; REAL_RUNGS];
            wanted.extend((0..REAL_RUNGS).map(Rung::Real));
        }
        // Neighbouring rungs side by side.
        wanted.sort_unstable();
        let mut values = Vec::with_capacity(wanted.len());
        sample(&wanted, &mut values);
        for (rung, faces) in wanted.into_iter().zip(values) {
            self.evaluations += faces.evaluations;
            let value = [faces.driven, faces.bottom];
            match rung {
                Rung::Axis(rung) => self.axis[rung] = Some(value),
                Rung::Real(rung) => self.real[rung] = value,
            }
        }
        let mut scales = [0.0_f64; 2];
        for value in self.axis.iter().flatten() {
            scales[0] = scales[0].max(value[0].norm_sqr());
            scales[1] = scales[1].max(value[1].norm_sqr());
        }
        scales = scales.map(f64::sqrt);
        self.scales = [scales[0], if self.bottom_scale > 0.0 { self.bottom_scale } else { scales[1] }];
    }

    pub fn value(&self, rung: usize) -> [Complex64; 2] {
        self.axis[rung].unwrap_or_default()
    }

    /// The samples that fits may use. The belt only has a say in the poles where it is not negligible.
    pub fn samples(&self, with_bottom: bool) -> Samples {
        let fitted_real = || (1..REAL_RUNGS).step_by(2);
        let points: Vec<_> = self
            .grid
            .iter()
            .map(|&rung| self.ladder.axis[rung])
            .chain(fitted_real().map(|rung| self.ladder.real[rung]))
            .collect();
        let response = |face: usize| {
            let axis = self.grid.iter().map(move |&rung| self.value(rung)[face]);
            axis.chain(fitted_real().map(move |rung| self.real[rung][face])).collect()
        };
        let responses: Vec<Vec<Complex64>> = (0..if with_bottom { 2 } else { 1 }).map(response).collect();
        let scales = &self.scales[..responses.len()];
        Samples {
            weights: scales.iter().map(|scale| scale.max(f64::MIN_POSITIVE).recip()).collect(),
            point_weights: responses[0].iter().map(|&value| self.point_weight(value)).collect(),
            points,
            responses,
        }
    }

    /// What an error of the driven face is relative to where its value is `value`.
    pub fn local_scale(&self, value: Complex64) -> f64 {
        let largest = self.scales[0];
        let scale = value.norm_sqr().sqrt().max(LEAST_SCALE * largest).min(largest);
        scale.max(self.least_scale).max(f64::MIN_POSITIVE)
    }

    /// How much more an error counts where the driven face's value is `value` than where it is largest.
    pub fn point_weight(&self, value: Complex64) -> f64 {
        self.scales[0].max(f64::MIN_POSITIVE) / self.local_scale(value)
    }

    /// Errors of both faces at rungs, in their order.
    fn errors_at(&self, models: &[PartialFractions], rungs: &[Rung]) -> Vec<[f64; 2]> {
        let points = Parts::new(rungs.iter().map(|&rung| self.point(rung)), 1.0);
        let modelled: Vec<Parts> = models.iter().map(|model| model.evaluate_all(&points)).collect();
        let at = |(k, &rung): (usize, &Rung)| {
            let values = match rung {
                Rung::Axis(rung) => self.value(rung),
                Rung::Real(rung) => self.real[rung],
            };
            let scales = [self.local_scale(values[0]), self.scales[1].max(f64::MIN_POSITIVE)];
            std::array::from_fn(|face| {
                let error = (modelled[face].get(k) - values[face]).norm_sqr().sqrt() / scales[face];
                // Not a number would lose every comparison and pass for no error.
                if error.is_finite() { error } else { f64::INFINITY }
            })
        };
        rungs.iter().enumerate().map(at).collect()
    }

    fn point(&self, rung: Rung) -> Complex64 {
        match rung {
            Rung::Axis(rung) => self.ladder.axis[rung],
            Rung::Real(rung) => self.ladder.real[rung],
        }
    }

    pub fn errors(&self, models: &[PartialFractions]) -> Errors {
        let worst = self.ladder.axis[0];
        let mut errors = Errors { fitted: 0.0, fresh: 0.0, between: 0.0, axis: 0.0, real: 0.0, bottom: 0.0, worst };
        let axis = self.grid.iter().chain(&self.fresh).map(|&rung| Rung::Axis(rung));
        let rungs: Vec<Rung> = axis.chain((0..REAL_RUNGS).map(Rung::Real)).collect();
        let all = self.errors_at(models, &rungs);
        let (on_grid, others) = all.split_at(self.grid.len());
        let (between, real) = others.split_at(self.fresh.len());
        for (&rung, [driven, bottom]) in self.grid.iter().zip(on_grid) {
            let error = driven.max(*bottom);
            if error > errors.fitted {
                (errors.fitted, errors.worst) = (error, self.ladder.axis[rung]);
            }
        }
        for both in between {
            errors.axis = errors.axis.max(both[0]);
            errors.bottom = errors.bottom.max(both[1]);
            errors.between = errors.between.max(both[0]).max(both[1]);
        }
        errors.fresh = errors.between;
        for (rung, both) in real.iter().enumerate() {
            errors.real = errors.real.max(both[0]);
            errors.bottom = errors.bottom.max(both[1]);
            let error = both[0].max(both[1]);
            if error > errors.fitted.max(errors.fresh) {
                errors.worst = self.ladder.real[rung];
            }
            let kind = if rung % 2 == 1 { &mut errors.fitted } else { &mut errors.fresh };
            *kind = kind.max(error);
        }
        errors
    }

    /// Moves fresh rungs with a large error into the grid. `false` if there is nothing left to halve.
    pub fn refine(&mut self, models: &[PartialFractions], tolerance: f64, sample: &mut Sample<'_>) -> bool {
        let limit = 0.5 * tolerance;
        let rungs: Vec<Rung> = self.fresh.iter().map(|&rung| Rung::Axis(rung)).collect();
        let errors = self.errors_at(models, &rungs).into_iter().map(|[driven, bottom]| driven.max(bottom));
        let mut joining: Vec<(f64, usize)> =
            errors.zip(self.fresh.iter().copied()).filter(|&(error, _)| error > limit).collect();
        joining.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        joining.truncate(MOST_JOINING);
        if joining.is_empty() {
            return false;
        }
        let joining = joining.into_iter().map(|(_, rung)| rung);
        self.grid.extend(joining);
        self.grid.sort_unstable();
        self.refresh(sample);
        true
    }

    /// Samples the exact function where the model has a peak that would fit between two samples: nothing else would
    /// notice if it were not real. Returns whether there was one.
    pub fn probe(
        &mut self,
        poles: &[Complex64],
        models: &[PartialFractions],
        tolerance: f64,
        sample: &mut Sample<'_>,
    ) -> bool {
        let mut sampled: Vec<usize> = self.grid.iter().chain(&self.fresh).copied().collect();
        sampled.sort_unstable();
        let before = self.probes.len();
        for (pole, residue) in poles.iter().zip(&models[0].residues).filter(|(pole, _)| is_pair(**pole)) {
            let scale = self.local_scale(models[0].evaluate(Complex64::new(0.0, pole.im)));
            let height = residue.norm() / (pole.re.abs() * scale);
            let rung = self.ladder.axis.partition_point(|s| s.im < pole.im).min(RUNGS);
            let next = sampled.partition_point(|&other| other < rung);
            let at = |index: usize| sampled.get(index).map_or(0.0, |&other| self.ladder.axis[other].im);
            let apart = at(next) - at(next.saturating_sub(1));
            let narrow = apart > 0.0 && pole.re.abs() < apart;
            let known = sampled.get(next) == Some(&rung) || self.probes.contains(&rung);
            if narrow && !known && height > 0.3 * tolerance {
                self.probes.push(rung);
            }
        }
        let found = self.probes.len() > before;
        if found {
            self.refresh(sample);
        }
        found
    }

    /// Takes fresh rungs into the grid until it determines the unknowns with a margin.
    pub fn enough_samples(&mut self, order: usize, sample: &mut Sample<'_>) {
        while self.grid.len() < order + 12 && !self.fresh.is_empty() {
            self.grid.extend(self.fresh.iter().copied());
            self.grid.sort_unstable();
            self.refresh(sample);
        }
    }
}
