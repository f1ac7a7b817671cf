//! The adaptive fit of one wavenumber.
//!
//! 1. sample H_n on a grid of rungs, and on *fresh* rungs half-way between them that no fit will see;
//! 2. poles: from a neighbour where there is one, from AAA where not; relocate them by vector fitting, refit the residues by least squares;
//! 3. where the fresh error exceeds the tolerance and the error on the grid does not explain it, the worst fresh rungs join the grid and new ones check it;
//!    where the grid itself is not met, a pole is added where the error is largest;
//! 4. once the tolerance is met, take poles away, the least contributing first, as long as relocation can make up for it.
//!
//! A fit that does not get there is an error with what was reached, never a worse model.

use num_complex::Complex64;

use super::ladder::{Ladder, REAL_RUNGS, RUNGS};
use super::model::{Entry, FitStatistics};
use crate::numeric::rational::partial_fractions::{fold_conjugates, is_pair, order, sort, stabilise};
use crate::numeric::rational::vector_fitting::{Samples, relocate, residues};
use crate::numeric::rational::{PartialFractions, RationalError, aaa};
use crate::tyre::influence_batch::FaceValues;

/// Intervals of the first grid.
const FIRST_INTERVALS: usize = 64;
/// Relocations that have to fail before samples or poles are added.
const IDLE_RELOCATIONS: usize = 2;
/// Relocations that may make up for a pole that was taken away.
const REMOVAL_RELOCATIONS: usize = 2;
/// Rungs that join the grid in one round.
const MOST_JOINING: usize = 12;
/// Samples per pole past which more samples are no remedy.
const MOST_SAMPLES: usize = 4;
/// Rounds of adding rungs or poles.
const ROUNDS: usize = 120;
/// The belt has a say in the poles from this many tolerances on.
const BELT_FROM: f64 = 1e4;
/// Points beyond the band where passivity is checked: factors of sqrt(2) above the top.
const BEYOND: usize = 20;
/// Rounds of mending passivity.
const MENDING_ROUNDS: usize = 8;

/// What a fit has to reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Largest error relative to the largest |H_n| over the band.
    pub tolerance: f64,
    /// Most poles, conjugates counted.
    pub most_poles: usize,
    /// Whether a constant is fitted.
    pub constant: bool,
    /// Largest |D_n| of all wavenumbers: what the error of the belt is relative to. 0: of this wavenumber.
    pub bottom_scale: f64,
    /// How many times poles may be taken away.
    pub removals: usize,
    /// Poles are only taken away where the error is below this fraction of the tolerance.
    pub removal_below: f64,
}

/// Where a fit starts: poles of a neighbour and the rungs it ended with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Start {
    /// Poles; empty: from scratch.
    pub poles: Vec<Complex64>,
    /// Rungs of the grid, rising; empty: the first grid.
    pub grid: Vec<usize>,
    /// Whether the first grid is twice as dense.
    pub dense: bool,
}

/// A fit, what the next one can start from, and its scale.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Poles, residues, statistics.
    pub entry: Entry,
    /// Rungs that the fit used.
    pub grid: Vec<usize>,
    /// Largest |H_n| and |D_n| on the samples \[m/N\].
    pub scales: [f64; 2],
}

/// Why a fit was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refusal {
    /// Smallest error reached.
    pub error: f64,
    /// Poles in use then, conjugates counted.
    pub order: usize,
    /// What ended the attempt.
    pub reason: RefusalReason,
}

/// What ended an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RefusalReason {
    /// The largest number of poles was reached.
    Poles,
    /// The finest rungs were reached: resonances sharper than the ladder.
    Resolution,
    /// Neither more poles nor more samples helped.
    Rounds,
    /// The fit generates energy at some frequency.
    Passivity,
    /// The function does not take real values on the real axis or is not finite: not a transfer function.
    NotATransferFunction,
}

/// A rung of one of the ladders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rung {
    /// On the imaginary axis.
    Axis(usize),
    /// On the positive real axis.
    Real(usize),
}

struct Attempt<'a> {
    ladder: &'a Ladder,
    target: &'a Target,
    /// Samples by rung of the axis.
    axis: Vec<Option<[Complex64; 2]>>,
    real: Vec<[Complex64; 2]>,
    grid: Vec<usize>,
    fresh: Vec<usize>,
    /// Further fresh rungs, where a model has a peak that is narrower than the samples are apart.
    probes: Vec<usize>,
    scales: [f64; 2],
    evaluations: u64,
    relocations: usize,
}

/// Errors of a model, each relative to its scale.
#[derive(Clone, Copy, Debug)]
struct Errors {
    /// Worst of both faces on the grid and the even real rungs.
    fitted: f64,
    /// Worst of both faces on the fresh rungs and the odd real rungs.
    fresh: f64,
    /// Fresh on the axis, driven face.
    axis: f64,
    /// Real axis, driven face.
    real: f64,
    /// Belt.
    bottom: f64,
    /// s where the error on the grid, or on the real axis if that is the worst of all, is largest.
    worst: Complex64,
}

impl Errors {
    fn largest(&self) -> f64 {
        self.fitted.max(self.fresh)
    }
}

/// Fits one wavenumber. `sample` evaluates the exact functions on a list of rungs, in their order.
pub fn fit_wavenumber(
    ladder: &Ladder,
    target: &Target,
    start: &Start,
    sample: &mut dyn FnMut(&[Rung], &mut Vec<FaceValues>),
) -> Result<Fitted, Refusal> {
    let grid = if start.grid.is_empty() {
        let intervals = FIRST_INTERVALS * if start.dense { 2 } else { 1 };
        (0..=intervals).map(|i| i * (RUNGS / intervals)).collect()
    } else {
        start.grid.clone()
    };
    let mut attempt = Attempt {
        ladder,
        target,
        axis: vec![None; RUNGS + 1],
        real: Vec::new(),
        fresh: Vec::new(),
        probes: Vec::new(),
        grid,
        scales: [0.0; 2],
        evaluations: 0,
        relocations: 0,
    };
    attempt.refresh(sample);
    attempt.run(start, sample)
}

impl Attempt<'_> {
    /// Brings `fresh` up to date with the grid and evaluates what is missing.
    fn refresh(&mut self, sample: &mut dyn FnMut(&[Rung], &mut Vec<FaceValues>)) {
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
            scales[0] = scales[0].max(value[0].norm());
            scales[1] = scales[1].max(value[1].norm());
        }
        self.scales = [scales[0], if self.target.bottom_scale > 0.0 { self.target.bottom_scale } else { scales[1] }];
    }

    fn value(&self, rung: usize) -> [Complex64; 2] {
        self.axis[rung].unwrap_or_default()
    }

    /// The samples that fits may use. The belt only has a say in the poles where it is not negligible.
    fn samples(&self, with_bottom: bool) -> Samples {
        let even_real = || (0..REAL_RUNGS).step_by(2);
        let points = self
            .grid
            .iter()
            .map(|&rung| self.ladder.axis[rung])
            .chain(even_real().map(|rung| self.ladder.real[rung]))
            .collect();
        let response = |face: usize| {
            let axis = self.grid.iter().map(move |&rung| self.value(rung)[face]);
            axis.chain(even_real().map(move |rung| self.real[rung][face])).collect()
        };
        let faces = if with_bottom { 2 } else { 1 };
        Samples {
            points,
            responses: (0..faces).map(response).collect(),
            weights: self.scales[..faces].iter().map(|scale| scale.max(f64::MIN_POSITIVE).recip()).collect(),
        }
    }

    fn errors(&self, models: &[PartialFractions]) -> Errors {
        let mut errors =
            Errors { fitted: 0.0, fresh: 0.0, axis: 0.0, real: 0.0, bottom: 0.0, worst: self.ladder.axis[0] };
        let of = |s: Complex64, values: [Complex64; 2], face: usize| {
            (models[face].evaluate(s) - values[face]).norm() / self.scales[face].max(f64::MIN_POSITIVE)
        };
        for &rung in &self.grid {
            let (s, values) = (self.ladder.axis[rung], self.value(rung));
            let error = of(s, values, 0).max(of(s, values, 1));
            if error > errors.fitted {
                (errors.fitted, errors.worst) = (error, s);
            }
        }
        for &rung in &self.fresh {
            let (s, values) = (self.ladder.axis[rung], self.value(rung));
            let both = [of(s, values, 0), of(s, values, 1)];
            errors.axis = errors.axis.max(both[0]);
            errors.bottom = errors.bottom.max(both[1]);
            errors.fresh = errors.fresh.max(both[0]).max(both[1]);
        }
        for rung in 0..REAL_RUNGS {
            let (s, values) = (self.ladder.real[rung], self.real[rung]);
            let both = [of(s, values, 0), of(s, values, 1)];
            errors.real = errors.real.max(both[0]);
            errors.bottom = errors.bottom.max(both[1]);
            let error = both[0].max(both[1]);
            if error > errors.fitted.max(errors.fresh) {
                errors.worst = s;
            }
            let kind = if rung % 2 == 0 { &mut errors.fitted } else { &mut errors.fresh };
            *kind = kind.max(error);
        }
        errors
    }

    /// Relocates and refits.
    fn improve(
        &mut self,
        poles: &[Complex64],
        relocations: usize,
    ) -> Result<(Vec<Complex64>, Vec<PartialFractions>, Errors), RationalError> {
        // Poles that follow the driven face alone follow the belt to about a hundredth; a belt that hardly moves needs no more.
        let limit = (BELT_FROM * self.target.tolerance).min(0.05) * self.scales[1];
        let with_bottom = self.axis.iter().flatten().any(|value| value[1].norm() > limit);
        let samples = self.samples(true);
        let mut poles = poles.to_vec();
        if relocations > 0 {
            let pole_samples = if with_bottom { &samples } else { &self.samples(false) };
            for _ in 0..relocations {
                poles = relocate(pole_samples, &poles, self.target.constant)?;
            }
            self.relocations += relocations;
        }
        let models = residues(&samples, &poles, self.target.constant)?;
        let errors = self.errors(&models);
        Ok((poles, models, errors))
    }

    /// Moves fresh rungs with a large error into the grid. `false` if there is nothing left to halve.
    fn refine(&mut self, models: &[PartialFractions], sample: &mut dyn FnMut(&[Rung], &mut Vec<FaceValues>)) -> bool {
        let limit = 0.5 * self.target.tolerance;
        let errors = |rung: usize| {
            let (s, values) = (self.ladder.axis[rung], self.value(rung));
            (0..2).map(|face| (models[face].evaluate(s) - values[face]).norm() / self.scales[face]).fold(0.0, f64::max)
        };
        let mut joining: Vec<(f64, usize)> =
            self.fresh.iter().map(|&rung| (errors(rung), rung)).filter(|&(error, _)| error > limit).collect();
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

    fn first_poles(&self) -> Result<Vec<Complex64>, RationalError> {
        let points: Vec<_> = self.grid.iter().map(|&rung| self.ladder.axis[rung]).collect();
        let values: Vec<_> = self.grid.iter().map(|&rung| self.value(rung)[0]).collect();
        let most = (self.target.most_poles / 2).min(points.len() / 3).max(2);
        let barycentric = aaa::approximate(&points, &values, 0.3 * self.target.tolerance, most)?;
        let mut poles = fold_conjugates(&barycentric.poles()?);
        stabilise(&mut poles);
        // Poles far beyond the band say nothing.
        poles.retain(|pole| pole.norm() < 30.0 * self.ladder.real[REAL_RUNGS - 1].re);
        Ok(poles)
    }

    fn run(&mut self, start: &Start, sample: &mut dyn FnMut(&[Rung], &mut Vec<FaceValues>)) -> Result<Fitted, Refusal> {
        let refuse = |error: f64, poles: &[Complex64], reason| Refusal { error, order: order(poles), reason };
        let broken =
            |_: RationalError| Refusal { error: f64::INFINITY, order: 0, reason: RefusalReason::NotATransferFunction };
        let mut poles = if start.poles.is_empty() { self.first_poles().map_err(broken)? } else { start.poles.clone() };
        let mut best = f64::INFINITY;
        let (mut accepted, mut reason) = (None, RefusalReason::Rounds);
        // Error when samples or poles were last changed or relocation last paid, and relocations since.
        let (mut before, mut idle) = (f64::INFINITY, 0);
        for _ in 0..ROUNDS {
            self.enough_samples(order(&poles), sample);
            let (moved, models, errors) = self.improve(&poles, 1).map_err(broken)?;
            poles = moved;
            best = best.min(errors.largest());
            let errors = if errors.largest() <= self.target.tolerance && self.probe(&poles, &models, sample) {
                self.errors(&models)
            } else {
                errors
            };
            if errors.largest() <= self.target.tolerance {
                let (models, errors) = self.passive(&poles, models, errors);
                let (least, s) = self.passivity(&models[0]);
                if least >= -self.target.tolerance {
                    accepted = Some((poles.clone(), models, errors));
                    break;
                }
                if order(&poles) < self.target.most_poles {
                    // Freedom where the energy comes from.
                    poles.push(Complex64::new(-s.im, 0.0));
                    reason = RefusalReason::Passivity;
                    continue;
                }
                return Err(refuse(best, &poles, RefusalReason::Passivity));
            }
            idle += 1;
            if idle < IDLE_RELOCATIONS || errors.largest() < 0.6 * before {
                before = before.min(errors.largest());
                continue;
            }
            (before, idle) = (f64::INFINITY, 0);
            let dense = self.grid.len() > MOST_SAMPLES * order(&poles) + FIRST_INTERVALS;
            if errors.fresh > self.target.tolerance && errors.fresh > 2.0 * errors.fitted && !dense {
                if self.refine(&models, sample) {
                    continue;
                }
                reason = RefusalReason::Resolution;
            }
            if order(&poles) + 2 > self.target.most_poles {
                reason = RefusalReason::Poles;
                break;
            }
            poles.push(new_pole(errors.worst, self.ladder.axis[1].im));
            sort(&mut poles);
        }
        let Some((poles, models, errors)) = accepted else { return Err(refuse(best, &poles, reason)) };
        let (poles, models, errors) = self.reduce(poles, models, errors);
        Ok(self.finish(poles, models, errors))
    }

    /// Samples the exact function where the model has a peak that would fit between two samples: nothing else would notice if it were not real. Returns whether
    /// there was one.
    fn probe(
        &mut self,
        poles: &[Complex64],
        models: &[PartialFractions],
        sample: &mut dyn FnMut(&[Rung], &mut Vec<FaceValues>),
    ) -> bool {
        let mut sampled: Vec<usize> = self.grid.iter().chain(&self.fresh).copied().collect();
        sampled.sort_unstable();
        let before = self.probes.len();
        for (pole, residue) in poles.iter().zip(&models[0].residues).filter(|(pole, _)| is_pair(**pole)) {
            let height = residue.norm() / (pole.re.abs() * self.scales[0]);
            let rung = self.ladder.axis.partition_point(|s| s.im < pole.im).min(RUNGS);
            let next = sampled.partition_point(|&other| other < rung);
            let at = |index: usize| sampled.get(index).map_or(0.0, |&other| self.ladder.axis[other].im);
            let apart = at(next) - at(next.saturating_sub(1));
            let narrow = apart > 0.0 && pole.re.abs() < apart;
            let known = sampled.get(next) == Some(&rung) || self.probes.contains(&rung);
            if narrow && !known && height > 0.3 * self.target.tolerance {
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
    fn enough_samples(&mut self, order: usize, sample: &mut dyn FnMut(&[Rung], &mut Vec<FaceValues>)) {
        while self.grid.len() < order + 12 && !self.fresh.is_empty() {
            self.grid.extend(self.fresh.iter().copied());
            self.grid.sort_unstable();
            self.refresh(sample);
        }
    }

    /// Takes poles away as long as the tolerance holds.
    fn reduce(
        &mut self,
        mut poles: Vec<Complex64>,
        mut models: Vec<PartialFractions>,
        mut errors: Errors,
    ) -> (Vec<Complex64>, Vec<PartialFractions>, Errors) {
        for _ in 0..self.target.removals {
            let share = |index: usize| {
                let size = |face: usize| models[face].residues[index].norm() / self.scales[face];
                size(0).max(size(1)) / poles[index].re.abs()
            };
            let Some(least) = (0..poles.len()).min_by(|&i, &j| share(i).total_cmp(&share(j))) else { break };
            if poles.len() < 2 {
                break;
            }
            if errors.largest() > self.target.removal_below * self.target.tolerance {
                break;
            }
            let mut fewer = poles.clone();
            fewer.remove(least);
            let mut found = false;
            for _ in 0..REMOVAL_RELOCATIONS {
                let Ok((moved, refitted, new)) = self.improve(&fewer, 1) else { break };
                fewer = moved;
                if new.largest() <= self.target.tolerance {
                    let (refitted, new) = self.passive(&fewer, refitted, new);
                    if self.passivity(&refitted[0]).0 < -self.target.tolerance {
                        continue;
                    }
                    (poles, models, errors) = (fewer.clone(), refitted, new);
                    found = true;
                    break;
                }
            }
            if !found {
                break;
            }
        }
        (poles, models, errors)
    }

    fn finish(&self, poles: Vec<Complex64>, models: Vec<PartialFractions>, errors: Errors) -> Fitted {
        let passivity = self.passivity(&models[0]).0;
        let statistics = FitStatistics {
            order: order(&poles),
            samples: self.grid.len() + REAL_RUNGS / 2,
            fresh_samples: self.fresh.len() + REAL_RUNGS / 2,
            evaluations: self.evaluations,
            relocations: self.relocations,
            error: errors.axis,
            real_axis_error: errors.real,
            bottom_error: errors.bottom,
            passivity,
        };
        let mut models = models.into_iter();
        let (driven, bottom) = (models.next().unwrap_or_default(), models.next().unwrap_or_default());
        let entry = Entry {
            poles,
            residues: [driven.residues, bottom.residues],
            constants: [driven.constant, bottom.constant],
            statistics,
        };
        Fitted { entry, grid: self.grid.clone(), scales: self.scales }
    }

    /// Mends a model that generates energy: its residues are refitted with the offending points as further samples, where the model is asked for its own real part and no
    /// energy. Most offences lie beyond the band, where nothing else determines it. Only what stays within the tolerance is taken.
    fn passive(
        &self,
        poles: &[Complex64],
        mut models: Vec<PartialFractions>,
        mut errors: Errors,
    ) -> (Vec<PartialFractions>, Errors) {
        let mut samples = self.samples(true);
        for _ in 0..MENDING_ROUNDS {
            let (least, s) = self.passivity(&models[0]);
            if least >= 0.0 {
                break;
            }
            for s in [s * 0.93, s, s * 1.07] {
                samples.points.push(s);
                for (face, (response, model)) in samples.responses.iter_mut().zip(&models).enumerate() {
                    let value = model.evaluate(s);
                    let margin = -0.5 * self.target.tolerance * self.scales[0];
                    response.push(if face == 0 { Complex64::new(value.re, margin) } else { value });
                }
            }
            let Ok(mended) = residues(&samples, poles, self.target.constant) else { break };
            let new = self.errors(&mended);
            if new.largest() > self.target.tolerance {
                break;
            }
            (models, errors) = (mended, new);
        }
        (models, errors)
    }

    /// Smallest Re(s H)/(|s| max |H|) on every eighth rung and beyond the band, and where.
    fn passivity(&self, model: &PartialFractions) -> (f64, Complex64) {
        let top = self.ladder.axis[RUNGS].im;
        let beyond = (1..=BEYOND).map(|i| Complex64::new(0.0, top * 2f64.powf(0.5 * i as f64)));
        let inside = self.ladder.axis.iter().skip(4).step_by(8).copied();
        inside
            .chain(beyond)
            .map(|s| (-model.evaluate(s).im / self.scales[0], s))
            .fold((f64::INFINITY, Complex64::ZERO), |least, next| if next.0 < least.0 { next } else { least })
    }
}

/// A pole that can do something about an error at s: a pair with a tenth of critical damping there, or a real one close to s = 0.
fn new_pole(s: Complex64, lowest: f64) -> Complex64 {
    let frequency = s.norm().max(lowest);
    if s.im > 4.0 * lowest && s.im > s.re {
        Complex64::new(-0.1 * frequency, frequency)
    } else {
        Complex64::new(-frequency, 0.0)
    }
}

/// Stored poles that are pairs.
pub fn pairs(poles: &[Complex64]) -> usize {
    poles.iter().filter(|&&pole| is_pair(pole)).count()
}
