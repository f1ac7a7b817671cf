//! The adaptive fit of one wavenumber.
//!
//! 1. sample H_n on a grid of rungs, and on *fresh* rungs half-way between them that no fit uses;
//! 2. poles: from a neighbour where there is one, from AAA where not; relocate them by vector fitting, refit the
//!    residues by least squares;
//! 3. where the fresh error exceeds the tolerance and the error on the grid does not explain it, the worst fresh rungs
//!    join the grid and new ones check it; where the grid itself is not met, a pole is added where the error is
//!    largest; where it is met far too well, or where a model within the tolerance generates energy, there are
//!    superfluous poles, and the one that contributes least is removed;
//! 4. once the tolerance is met, remove poles, the one that contributes least first, as long as relocation can make up
//!    for it.
//!
//! A fit that does not get there is an error with the accuracy reached, never a worse model.

use num_complex::Complex64;

use super::error::{FitError, RefusalReason};
use super::ladder::{Ladder, REAL, RUNGS};
use super::model::{Entry, FitStatistics};
use super::passivity::{least_power, passive};
use super::sampled::{Candidate, Sample, Sampled, Target, largest_residue};
use crate::numeric::rational::partial_fractions::{fold_conjugates, order, sort, stabilise};
use crate::numeric::rational::vector_fitting::{Elimination, relocate};
use crate::numeric::rational::{RationalError, aaa};

/// Intervals of the first grid.
const FIRST_INTERVALS: usize = 64;
/// Relocations without progress before samples or poles are added.
const IDLE_RELOCATIONS: usize = 2;
/// Samples per pole beyond which more samples are no remedy.
const MOST_SAMPLES: usize = 4;
/// A model that generates energy has superfluous poles where its error is below this fraction of the tolerance.
const THINNED_BELOW: f64 = 0.9;
/// So has a model whose error on the grid alone is below this fraction.
const SPARE_BELOW: f64 = 1e-2;
/// Bound of the poles, in tops of the band.
const FARTHEST: f64 = 30.0;
/// A start whose poles have multiplied by this is given up.
const MOST_GROWTH: usize = 2;
/// Most rounds of adding rungs or poles.
const ROUNDS: usize = 120;
/// Tolerance from which on relocations may use products instead of reflections: below, most of them lose their digits.
const PRODUCTS_FROM: f64 = 1e-6;
/// Motion of the belt, in tolerances, from which on it takes part in moving the poles.
const BELT_FROM: f64 = 1e4;
/// Odd parts, in tolerances, from which on they take part in moving the poles of a tyre that turns.
const ODD_FROM: f64 = 1.0;

/// Start of a fit: poles of a neighbour and its last rungs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Start {
    /// Poles; empty: from scratch.
    pub poles: Vec<Complex64>,
    /// Rungs of the grid, rising; empty: the first grid.
    pub grid: Vec<usize>,
}

/// A fit, and the grid for the next one.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    /// Poles, residues, statistics.
    pub entry: Entry,
    /// Rungs that the fit used.
    pub grid: Vec<usize>,
}

struct Attempt<'a> {
    target: &'a Target,
    sampled: Sampled<'a>,
    relocations: usize,
    /// True without poles to start from.
    from_scratch: bool,
}

/// Fits one wavenumber. `sample` evaluates the exact functions on a list of rungs, in their order. Where a start fails
/// the function is fitted again from scratch.
pub(super) fn fit_wavenumber(
    ladder: &Ladder,
    target: &Target,
    start: &Start,
    sample: &mut Sample<'_>,
) -> Result<Fitted, FitError> {
    fit_from(ladder, target, start, sample).or_else(|error| {
        if start.poles.is_empty() { Err(error) } else { fit_from(ladder, target, &Start::default(), sample) }
    })
}

fn fit_from(ladder: &Ladder, target: &Target, start: &Start, sample: &mut Sample<'_>) -> Result<Fitted, FitError> {
    let grid = if start.grid.is_empty() {
        (0..=FIRST_INTERVALS).map(|i| i * (RUNGS / FIRST_INTERVALS)).collect()
    } else {
        start.grid.clone()
    };
    let sampled = Sampled::new(ladder, target, grid, sample);
    let mut attempt = Attempt { target, sampled, relocations: 0, from_scratch: start.poles.is_empty() };
    let accepted = attempt.run(start, sample)?;
    let reduced = attempt.reduce(accepted);
    Ok(attempt.finish(reduced))
}

impl Attempt<'_> {
    fn refuse(&self, error: f64, order: usize, reason: RefusalReason) -> FitError {
        let Target { wavenumber, tolerance, .. } = *self.target;
        FitError::Refused { wavenumber, error, tolerance, order, reason }
    }

    fn broken(&self, _: RationalError) -> FitError {
        self.refuse(f64::INFINITY, 0, RefusalReason::NotATransferFunction)
    }

    /// Elimination of residues in relocations: by reflections where poles are yet to be found, since fewer of them
    /// result.
    fn elimination(&self) -> Elimination {
        if self.from_scratch { Elimination::Reflections } else { elimination(self.target.tolerance) }
    }

    /// Relocates once and refits.
    fn improve(&mut self, poles: &[Complex64], elimination: Elimination) -> Result<Candidate, RationalError> {
        // Poles that follow the driven face alone follow the belt to about a hundredth: enough for a belt that hardly
        // moves.
        let with_bottom = self.sampled.bottom_exceeds((BELT_FROM * self.target.tolerance).min(0.05));
        let odd_from = ODD_FROM * self.target.tolerance;
        let with_odd = [self.sampled.odd_exceeds(0, odd_from), with_bottom && self.sampled.odd_exceeds(1, odd_from)];
        let chosen = [true, with_bottom, with_odd[0], with_odd[1]];
        let samples = self.sampled.samples();
        let some = (samples.responses.len() > chosen.iter().filter(|&&chosen| chosen).count())
            .then(|| self.sampled.samples_of(|part| chosen[part]));
        let pole_samples = some.as_ref().unwrap_or(&samples);
        let mut poles = relocate(pole_samples, poles, self.target.constant, elimination)?;
        bound(&mut poles, self.sampled.ladder.top);
        self.relocations += 1;
        self.sampled.candidate(&samples, poles)
    }

    fn first_poles(&self) -> Result<Vec<Complex64>, RationalError> {
        let points: Vec<_> = self.sampled.grid.iter().map(|&rung| self.sampled.ladder.points[rung]).collect();
        let values: Vec<_> = self.sampled.grid.iter().map(|&rung| self.sampled.value(rung)[0]).collect();
        let most = (self.target.most_poles / 2).min(points.len() / 3).max(2);
        let barycentric = aaa::approximate(&points, &values, 0.3 * self.target.tolerance, [most; 2])?;
        let mut poles = fold_conjugates(&barycentric.poles()?);
        stabilise(&mut poles);
        bound(&mut poles, self.sampled.ladder.top);
        Ok(poles)
    }

    /// A model within the tolerance that generates no energy.
    fn run(&mut self, start: &Start, sample: &mut Sample<'_>) -> Result<Candidate, FitError> {
        let Target { tolerance, most_poles, .. } = *self.target;
        let mut poles = if start.poles.is_empty() {
            self.first_poles().map_err(|error| self.broken(error))?
        } else {
            start.poles.clone()
        };
        let (mut best, mut reason) = (f64::INFINITY, RefusalReason::Rounds);
        // Error when samples or poles were last changed or relocation last made progress, and relocations since.
        let (mut before, mut idle) = (f64::INFINITY, 0);
        // Whether a model that generates energy may try with fewer poles; no longer once more were needed.
        let mut may_thin = true;
        for _ in 0..ROUNDS {
            // 1. Relocation and errors; a narrow peak between samples is sampled.
            self.sampled.enough_samples(order(&poles), sample);
            let elimination = self.elimination();
            let mut candidate = self.improve(&poles, elimination).map_err(|error| self.broken(error))?;
            best = best.min(candidate.errors.largest());
            if candidate.errors.largest() <= tolerance && self.sampled.probe(&candidate, sample) {
                candidate.errors = self.sampled.errors(&candidate.models);
            }
            // 2. Within the tolerance: done if passive, else fewer poles or one where the energy comes from.
            if candidate.errors.largest() <= tolerance {
                let candidate = passive(&self.sampled, candidate);
                let (least, s) = least_power(&self.sampled, &candidate.models);
                if least >= -tolerance {
                    return Ok(candidate);
                }
                poles = candidate.poles.clone();
                // Superfluous poles generate energy beyond the band, where nothing determines them.
                if may_thin
                    && candidate.errors.largest() < THINNED_BELOW * tolerance
                    && let Some(least) = self.least(&candidate)
                {
                    poles.remove(least);
                } else if order(&poles) < most_poles {
                    may_thin = false;
                    // Freedom where the energy comes from.
                    poles.push(Complex64::new(-s.im, 0.0));
                } else {
                    return Err(self.refuse(best, order(&poles), RefusalReason::Passivity));
                }
                reason = RefusalReason::Passivity;
                continue;
            }
            poles.clone_from(&candidate.poles);
            let errors = candidate.errors;
            // 3. Far within the tolerance on the grid: superfluous poles, which oscillate between the samples.
            if may_thin
                && errors.fitted < SPARE_BELOW * tolerance
                && let Some(least) = self.least(&candidate)
            {
                poles.remove(least);
                (before, idle) = (f64::INFINITY, 0);
                continue;
            }
            // 4. Without progress: more samples, or a further pole.
            idle += 1;
            if idle < IDLE_RELOCATIONS || errors.largest() < 0.6 * before {
                before = before.min(errors.largest());
                continue;
            }
            (before, idle) = (f64::INFINITY, 0);
            let dense = self.sampled.grid.len() > MOST_SAMPLES * order(&poles) + FIRST_INTERVALS;
            if errors.between > tolerance && errors.between > 2.0 * errors.fitted && !dense {
                if self.sampled.refine(&candidate.models, sample) {
                    continue;
                }
                reason = RefusalReason::Resolution;
            }
            if order(&poles) + 2 > most_poles {
                reason = RefusalReason::Poles;
                break;
            }
            if !start.poles.is_empty() && order(&poles) > MOST_GROWTH * order(&start.poles) {
                break;
            }
            may_thin = false;
            poles.push(new_pole(errors.worst, self.sampled.ladder.points[1].im));
            sort(&mut poles);
        }
        Err(self.refuse(best, order(&poles), reason))
    }

    /// The pole that contributes least, if it is not the only one.
    fn least(&self, Candidate { poles, models, .. }: &Candidate) -> Option<usize> {
        let share = |index: usize| {
            let size = |face: usize| largest_residue(models, face, index) / self.sampled.scales[face];
            size(0).max(size(1)) / poles[index].re.abs()
        };
        (0..poles.len()).min_by(|&i, &j| share(i).total_cmp(&share(j))).filter(|_| poles.len() > 1)
    }

    /// Removes poles as long as the tolerance holds.
    fn reduce(&mut self, mut accepted: Candidate) -> Candidate {
        for _ in 0..self.target.removals {
            if accepted.errors.largest() > self.target.removal_below * self.target.tolerance {
                break;
            }
            let Some(fewer) = self.with_one_less(&accepted) else { break };
            accepted = fewer;
        }
        accepted
    }

    /// A passive model within the tolerance without the pole that contributes least; `None` where there is none.
    fn with_one_less(&mut self, accepted: &Candidate) -> Option<Candidate> {
        let mut fewer = accepted.poles.clone();
        fewer.remove(self.least(accepted)?);
        for elimination in [self.elimination(), Elimination::Reflections] {
            let candidate = self.improve(&fewer, elimination).ok()?;
            fewer.clone_from(&candidate.poles);
            if candidate.errors.largest() <= self.target.tolerance {
                let candidate = passive(&self.sampled, candidate);
                if least_power(&self.sampled, &candidate.models).0 >= -self.target.tolerance {
                    return Some(candidate);
                }
            }
        }
        None
    }

    fn finish(&self, Candidate { poles, models, errors }: Candidate) -> Fitted {
        let passivity = least_power(&self.sampled, &models).0;
        let statistics = FitStatistics {
            order: order(&poles),
            samples: self.sampled.grid.len() + REAL.len() / 2,
            fresh_samples: self.sampled.fresh.len() + REAL.len() / 2,
            evaluations: self.sampled.evaluations,
            relocations: self.relocations,
            error: errors.axis,
            real_axis_error: errors.real,
            bottom_error: errors.bottom,
            passivity,
        };
        let mut models = models.into_iter();
        let mut next = || models.next().unwrap_or_default();
        let [driven, bottom, odd_driven, odd_bottom] = [next(), next(), next(), next()];
        let entry = Entry {
            poles,
            residues: [driven.residues, bottom.residues],
            odd: [odd_driven.residues, odd_bottom.residues],
            constants: [driven.constant, bottom.constant],
            statistics,
        };
        Fitted { entry, grid: self.sampled.grid.clone() }
    }
}

/// Elimination of residues in relocations that begin with the poles of a neighbour.
pub(super) fn elimination(tolerance: f64) -> Elimination {
    if tolerance < PRODUCTS_FROM { Elimination::Reflections } else { Elimination::Products }
}

/// Replaces all poles far beyond the band, which ends at `top`, by one on the real axis: within the band they are all
/// the same constant, relocation drives them further with every round, until they overflow, and between the band and
/// there they only threaten passivity.
pub(super) fn bound(poles: &mut Vec<Complex64>, top: f64) {
    let (farthest, before) = (FARTHEST * top, poles.len());
    poles.retain(|pole| pole.norm() < farthest);
    if poles.len() < before {
        poles.push(Complex64::new(-farthest, 0.0));
        sort(poles);
    }
}

/// A pole that can reduce an error at s: a pair with a tenth of critical damping there, or a real one close to s = 0.
pub(super) fn new_pole(s: Complex64, lowest: f64) -> Complex64 {
    let frequency = s.norm().max(lowest);
    if s.im > 4.0 * lowest && s.im > s.re {
        Complex64::new(-0.1 * frequency, frequency)
    } else {
        Complex64::new(-frequency, 0.0)
    }
}

#[cfg(test)]
#[path = "rotating_tests.rs"]
mod tests;
