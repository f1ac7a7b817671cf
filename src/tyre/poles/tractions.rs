//! Fit of the waves that carry the history of tractions: all components over common poles.
//!
//! With phases D = diag(1, i, i) taken into forces and displacements, C' = D C D^-1 of a tyre at rest is real at real s
//! and symmetric; of one that turns it is E + i O with such functions E and O. For each wave:
//! 1. it starts from the poles of its neighbour, or from those of its trace, components relative to their largest
//!    values (module `wavenumber`);
//! 2. residues of all components follow by least squares; where an error exceeds the tolerance, samples are added,
//!    poles are relocated with all components, and some are added;
//! 3. poles that contribute least are removed, as long as relocation makes up for them;
//! 4. the residues at a pole, a matrix, are split into products of an output and an input: a resonance has one such
//!    *channel*, a pole of relaxation may have three.
//!
//! Errors of C'_ab / sqrt(C_aa C_bb), with the largest values of C_aa and C_bb, are relative to the norm of that
//! matrix at s, or to 0.003 of its largest where that is more.

use std::sync::atomic::{AtomicBool, Ordering};

use num_complex::Complex64;

use super::cells::CellFitOptions;
use super::error::{FitError, RefusalReason};
use super::ladder::{Ladder, REAL, RUNGS};
use super::pole_model::PoleModel;
use super::row::{RowTarget, fit_row};
use super::traction_model::{PoleChannel, TractionModel};
use super::wavenumber::{bound, elimination, new_pole};
use crate::numeric::in_parallel;
use crate::numeric::rational::partial_fractions::{is_pair, order, sort};
use crate::numeric::rational::vector_fitting::{relocate, residues};
use crate::numeric::rational::{ComplexParts, PartialFractions, RationalError, Samples};
use crate::scene::Sides;
use crate::tyre::influence::{COMPONENTS, CellRow, CellSums, CellSumsAt, CellWave, FaceValues, PAIRS, TractionParts};

/// Least scale of errors, relative to the largest norm.
const LEAST_SCALE: f64 = 3e-3;
/// Most rounds of relocation.
const ROUNDS: usize = 40;
/// Ratio of errors below which relocations count as progress.
const PAYS: f64 = 0.6;
/// Relocations without progress before a pole is added.
const IDLE_RELOCATIONS: usize = 2;
/// Most poles removed from the first wave of a row, and from each other one.
const FIRST_REMOVALS: usize = 12;
const REMOVALS: usize = 1;
/// Distance of the rungs of the first grid.
const FIRST_STRIDE: usize = 32;
/// Most rungs that join the grid at a time, and number from which on it is thinned for the next wave.
const MOST_JOINING: usize = 16;
const MOST_RUNGS: usize = 140;
/// A start whose poles have multiplied by the first, and by the second more of them, is given up.
const MOST_GROWTH: usize = 2;
const SPARE: usize = 12;
/// Relocations that may make up for a pole.
const RELOCATIONS: usize = 2;
/// Distance of the rungs by which scales are found.
const SCALE_STRIDE: usize = 256;
/// Error, in tolerances, up to which a model that cannot be improved is accepted.
const REFUSED_FROM: f64 = 10.0;

/// Exact functions of the waves at the rungs.
struct Exact<'a> {
    sums: &'a CellSums,
    at: &'a [CellSumsAt],
    ladder: &'a Ladder,
}

/// C' of a wave by pair: even parts, odd parts.
type Parts = [[Complex64; PAIRS]; 2];

impl Exact<'_> {
    /// C' of a wave at a rung.
    fn parts(&self, wave: &CellWave, rung: usize) -> Parts {
        let TractionParts { mut even, mut odd } = self.sums.traction_parts(wave, &self.at[rung]);
        // Pairs of x with y or z: times -i or i.
        for (pair, sign) in [(1, 1.0), (2, 1.0), (3, -1.0), (6, -1.0)] {
            (even[pair], odd[pair]) = (sign * odd[pair], -sign * even[pair]);
        }
        // A uniform lateral motion has no other components.
        let is_uniform = wave.terms.iter().all(|&(_, m, _)| m == 0);
        if is_uniform && self.sums.grid().waves().sides == Sides::Supported {
            let lateral = |pair: usize, value: Complex64| if pair == 4 { value } else { Complex64::ZERO };
            return [even, odd].map(|part| std::array::from_fn(|pair| lateral(pair, part[pair])));
        }
        [even, odd]
    }

    /// Largest values of C_xx, C_yy and C_zz of a wave on the axis.
    fn scales(&self, wave: &CellWave) -> [f64; COMPONENTS] {
        let mut scales = [0.0_f64; COMPONENTS];
        for rung in (0..=RUNGS).step_by(SCALE_STRIDE) {
            let [even, _] = self.parts(wave, rung);
            for (component, scale) in scales.iter_mut().enumerate() {
                *scale = scale.max(even[component * (COMPONENTS + 1)].norm());
            }
        }
        scales
    }
}

/// Trace of parts, each component over its scale.
fn trace(parts: &[Complex64; PAIRS], scales: &[f64; COMPONENTS]) -> Complex64 {
    let diagonal = |component: usize| parts[component * (COMPONENTS + 1)] / scales[component].max(f64::MIN_POSITIVE);
    (0..COMPONENTS).map(diagonal).sum()
}

/// Samples of a wave: at rungs that fits use, and at rungs that only check.
struct SampledTractions {
    fitted: Vec<usize>,
    checked: Vec<usize>,
    /// Part, pair and scale of what is not 0 throughout; of a symmetric matrix the upper triangle.
    kinds: Vec<(usize, usize, f64)>,
    /// Scaled parts at a rung, in the order of the kinds, and the scale of errors there.
    values: Vec<Option<(Vec<Complex64>, f64)>>,
    points: Vec<Complex64>,
}

impl SampledTractions {
    /// Samples of a wave on a grid of rungs, which rise; `None` for a wave without response.
    fn new(exact: &Exact<'_>, wave: &CellWave, grid: &[usize]) -> Option<Self> {
        let scales = exact.scales(wave);
        let of_pair = |pair: usize| (scales[pair / COMPONENTS] * scales[pair % COMPONENTS]).sqrt();
        let turns = exact.sums.turns();
        let is_known = |pair: usize| !turns && pair / COMPONENTS > pair % COMPONENTS;
        let some = [grid.len() / 3, 2 * grid.len() / 3].map(|place| exact.parts(wave, grid[place]));
        let is_there = |part: usize, pair: usize| some.iter().any(|parts| parts[part][pair].norm() > 0.0);
        let all = (0..2).flat_map(|part| (0..PAIRS).map(move |pair| (part, pair)));
        let kinds: Vec<(usize, usize, f64)> = all
            .filter(|&(part, pair)| of_pair(pair) > 0.0 && !is_known(pair) && is_there(part, pair))
            .map(|(part, pair)| (part, pair, of_pair(pair)))
            .collect();
        let points = exact.ladder.points.clone();
        let mut this =
            Self { fitted: grid.to_vec(), checked: Vec::new(), kinds, values: vec![None; points.len()], points };
        if this.kinds.is_empty() {
            return None;
        }
        this.fitted.extend(REAL.skip(1).step_by(2));
        this.refresh(exact, wave);
        Some(this)
    }

    /// Takes missing samples; rungs half-way between those of fits check.
    fn refresh(&mut self, exact: &Exact<'_>, wave: &CellWave) {
        self.fitted.sort_unstable();
        let on_axis: Vec<usize> = self.fitted.iter().copied().filter(|rung| *rung <= RUNGS).collect();
        let between = on_axis.windows(2).filter(|pair| pair[1] - pair[0] > 1).map(|pair| (pair[0] + pair[1]) / 2);
        self.checked = between.chain(REAL.step_by(2)).collect();
        for &rung in self.fitted.iter().chain(&self.checked) {
            if self.values[rung].is_none() {
                let parts = exact.parts(wave, rung);
                let scaled = self.kinds.iter().map(|&(part, pair, scale)| parts[part][pair] / scale);
                let scaled: Vec<Complex64> = scaled.collect();
                let size = scaled.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
                self.values[rung] = Some((scaled, size));
            }
        }
        let sizes = self.values.iter().flatten().map(|(_, size)| *size);
        let least = LEAST_SCALE * sizes.fold(f64::MIN_POSITIVE, f64::max);
        self.values.iter_mut().flatten().for_each(|(_, size)| *size = size.max(least));
    }

    /// Moves checks with errors above `limit` into the fit; returns whether there are any.
    fn refine(&mut self, exact: &Exact<'_>, wave: &CellWave, errors: &[(f64, usize)], limit: f64) -> bool {
        let mut joining: Vec<(f64, usize)> = errors.iter().copied().filter(|(error, _)| *error > limit).collect();
        joining.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        joining.truncate(MOST_JOINING);
        self.fitted.extend(joining.iter().map(|(_, rung)| *rung));
        self.refresh(exact, wave);
        !joining.is_empty()
    }

    /// Scale of errors at the sample nearest to a pole's frequency.
    fn size_near(&self, pole: Complex64) -> f64 {
        let frequency = if is_pair(pole) { pole.im } else { pole.norm() };
        let near = self.fitted.iter().map(|&rung| ((self.points[rung].norm() - frequency).abs(), self.at(rung).1));
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(1.0, |(_, size)| size)
    }

    /// Residues over given poles, and their error.
    fn fractions(&self, samples: &Samples, poles: Vec<Complex64>) -> Result<Fractions, RationalError> {
        let all = residues(samples, &poles, false)?;
        let of = |rungs: &[usize]| largest(&self.errors(rungs, &all)).0;
        let error = of(&self.fitted).max(of(&self.checked));
        Ok(Fractions { poles, all, error })
    }

    fn at(&self, rung: usize) -> (&[Complex64], f64) {
        self.values[rung].as_ref().map_or((&[], 1.0), |(values, size)| (values, *size))
    }

    /// Samples that fits use.
    fn samples(&self) -> Samples {
        let of_kind = |kind: usize| self.fitted.iter().map(|&rung| self.at(rung).0[kind]).collect();
        Samples {
            points: self.fitted.iter().map(|&rung| self.points[rung]).collect(),
            responses: (0..self.kinds.len()).map(of_kind).collect(),
            weights: vec![1.0; self.kinds.len()],
            point_weights: self.fitted.iter().map(|&rung| self.at(rung).1.recip()).collect(),
        }
    }

    /// Largest errors at rungs, of fractions in the order of the kinds.
    fn errors(&self, rungs: &[usize], fractions: &[PartialFractions]) -> Vec<(f64, usize)> {
        let points = ComplexParts::new(rungs.iter().map(|&rung| self.points[rung]), 1.0);
        let modelled: Vec<_> = fractions.iter().map(|fraction| fraction.evaluate_all(&points)).collect();
        let at = |(place, &rung): (usize, &usize)| {
            let (values, size) = self.at(rung);
            let errors = values.iter().zip(&modelled).map(|(exact, model)| (model.get(place) - exact).norm_sqr());
            // NaN would lose every comparison.
            let worst =
                errors.fold(0.0, |worst: f64, error| if error > worst || error.is_nan() { error } else { worst });
            (if worst.is_finite() { worst.sqrt() / size } else { f64::INFINITY }, rung)
        };
        rungs.iter().enumerate().map(at).collect()
    }
}

/// Largest error, and its rung.
fn largest(errors: &[(f64, usize)]) -> (f64, usize) {
    errors.iter().copied().fold((0.0, 0), |worst, error| if error.0 > worst.0 { error } else { worst })
}

/// Fit of a wave.
struct Wave {
    poles: Vec<Complex64>,
    channels: Vec<PoleChannel>,
    error: f64,
    /// Poles and rungs from which the next wave starts.
    next: Vec<Complex64>,
    grid: Vec<usize>,
    evaluations: u64,
}

/// Poles and the fractions of all kinds over them.
struct Fractions {
    poles: Vec<Complex64>,
    all: Vec<PartialFractions>,
    error: f64,
}

/// Poles and residues of all components from the poles of a start; the best found, within the tolerance or not.
fn common_poles(
    exact: &Exact<'_>,
    wave: &CellWave,
    sampled: &mut SampledTractions,
    first: &[Complex64],
    options: &CellFitOptions,
) -> Result<Fractions, RationalError> {
    let tolerance = options.tolerance;
    let elimination = elimination(options.tolerance);
    let mut poles = first.to_vec();
    let mut best: Option<Fractions> = None;
    let (mut before, mut idle) = (f64::INFINITY, 0);
    for _ in 0..ROUNDS {
        // 1. Residues over the poles, and their errors.
        let samples = sampled.samples();
        let all = residues(&samples, &poles, false)?;
        let of = |rungs: &[usize]| sampled.errors(rungs, &all);
        let (fitted, between) = (of(&sampled.fitted), of(&sampled.checked));
        let (on_grid, off_grid) = (largest(&fitted), largest(&between));
        let error = on_grid.0.max(off_grid.0);
        if best.as_ref().is_none_or(|best| error < best.error) {
            best = Some(Fractions { poles: poles.clone(), all, error });
        }
        if error <= tolerance {
            break;
        }
        // 2. More samples where errors at samples do not explain those between them.
        if off_grid.0 > tolerance && off_grid.0 > 2.0 * on_grid.0 {
            sampled.refine(exact, wave, &between, 0.5 * tolerance);
            (before, idle) = (f64::INFINITY, 0);
        }
        // 3. A further pole where relocation makes no progress.
        idle += 1;
        if error < PAYS * before {
            (before, idle) = (error, 0);
        } else if idle >= IDLE_RELOCATIONS {
            if order(&poles) + 2 > options.most_poles || order(&poles) > MOST_GROWTH * order(first) + SPARE {
                break;
            }
            let worst = if on_grid.0 > tolerance { on_grid } else { off_grid };
            poles.push(new_pole(sampled.points[worst.1], sampled.points[1].im));
            (before, idle) = (f64::INFINITY, 0);
        }
        // 4. Relocation.
        sort(&mut poles);
        poles = relocate(&sampled.samples(), &poles, false, elimination)?;
        bound(&mut poles, exact.ladder.top);
        sort(&mut poles);
    }
    best.ok_or(RationalError::NotFinite { stage: "tractions" })
}

/// Removes poles, the one that contributes least first, as long as relocation can make up for it.
fn fewer_poles(
    sampled: &SampledTractions,
    mut fractions: Fractions,
    removals: usize,
    options: &CellFitOptions,
    top: f64,
) -> Result<Fractions, RationalError> {
    let samples = sampled.samples();
    let elimination = elimination(options.tolerance);
    for _ in 0..removals {
        let share = |index: usize| {
            let pole = fractions.poles[index];
            let residues = fractions.all.iter().map(|fraction| fraction.residues[index].norm_sqr()).sum::<f64>();
            residues.sqrt() / (pole.re.abs() * sampled.size_near(pole))
        };
        let Some(least) = (0..fractions.poles.len()).min_by(|&a, &b| share(a).total_cmp(&share(b))) else { break };
        let mut poles = fractions.poles.clone();
        poles.remove(least);
        if poles.is_empty() {
            break;
        }
        let mut better = None;
        for _ in 0..RELOCATIONS {
            poles = relocate(&samples, &poles, false, elimination)?;
            bound(&mut poles, top);
            sort(&mut poles);
            let fewer = sampled.fractions(&samples, poles.clone())?;
            if fewer.error <= options.tolerance {
                better = Some(fewer);
                break;
            }
        }
        let Some(fewer) = better else { break };
        fractions = fewer;
    }
    Ok(fractions)
}

/// Splits a matrix of outputs by inputs into products of rank one by full pivoting, the largest first.
fn products(matrix: &mut [[Complex64; COMPONENTS]; 2 * COMPONENTS]) -> Vec<PoleChannel> {
    let mut channels = Vec::new();
    for _ in 0..COMPONENTS {
        let places = (0..2 * COMPONENTS).flat_map(|row| (0..COMPONENTS).map(move |column| (row, column)));
        let size = |&(row, column): &(usize, usize)| matrix[row][column].norm_sqr();
        let Some((row, column)) = places.max_by(|a, b| size(a).total_cmp(&size(b))) else { break };
        let pivot = matrix[row][column];
        if pivot.norm() <= 0.0 {
            break;
        }
        let input = matrix[row].map(|value| value / pivot);
        let output: [Complex64; 2 * COMPONENTS] = std::array::from_fn(|row| matrix[row][column]);
        for (row, output) in matrix.iter_mut().zip(output) {
            row.iter_mut().zip(input).for_each(|(value, input)| *value -= output * input);
        }
        channels.push(PoleChannel {
            input,
            output: std::array::from_fn(|a| output[a]),
            odd: std::array::from_fn(|a| output[COMPONENTS + a]),
        });
    }
    channels
}

/// Poles and channels from residues, in scaled components.
fn channels_of(sampled: &SampledTractions, fractions: &Fractions) -> (Vec<Complex64>, Vec<PoleChannel>) {
    let is_symmetric = sampled.kinds.iter().all(|(_, pair, _)| pair / COMPONENTS <= pair % COMPONENTS);
    let (mut poles, mut channels) = (Vec::new(), Vec::new());
    for (index, &pole) in fractions.poles.iter().enumerate() {
        let mut matrix = [[Complex64::ZERO; COMPONENTS]; 2 * COMPONENTS];
        for (&(part, pair, _), fraction) in sampled.kinds.iter().zip(&fractions.all) {
            let (a, b) = (pair / COMPONENTS, pair % COMPONENTS);
            matrix[part * COMPONENTS + a][b] = fraction.residues[index];
            if is_symmetric {
                matrix[part * COMPONENTS + b][a] = fraction.residues[index];
            }
        }
        let pole_channels = products(&mut matrix);
        poles.extend(pole_channels.iter().map(|_| pole));
        channels.extend(pole_channels);
    }
    (poles, channels)
}

impl Exact<'_> {
    /// Fits a wave from the one before, or from the poles of its trace.
    fn fit(
        &self,
        wave: &CellWave,
        before: Option<&Wave>,
        options: &CellFitOptions,
        stop: &AtomicBool,
    ) -> Result<Wave, FitError> {
        let number = wave.terms.first().map_or(0, |(n, ..)| n.unsigned_abs() as usize);
        let CellFitOptions { tolerance, most_poles, .. } = *options;
        let refused = |error: f64, order: usize, reason: RefusalReason| FitError::Refused {
            wavenumber: number,
            error,
            tolerance,
            order,
            reason,
        };
        // 1. Samples, on the grid of the wave before; a wave without response hands the start on.
        let first: Vec<usize> = (0..=RUNGS).step_by(FIRST_STRIDE).collect();
        let grid = before.filter(|before| !before.grid.is_empty()).map_or(&first, |before| &before.grid);
        let Some(mut sampled) = SampledTractions::new(self, wave, grid) else {
            let (next, grid) =
                before.map_or_else(Default::default, |before| (before.next.clone(), before.grid.clone()));
            return Ok(Wave { poles: Vec::new(), channels: Vec::new(), error: 0.0, next, grid, evaluations: 0 });
        };
        let broken = |_: RationalError| refused(f64::INFINITY, 0, RefusalReason::NotATransferFunction);
        // 2. From the poles of the wave before.
        let mut fractions = None;
        if let Some(before) = before.filter(|before| !before.next.is_empty()) {
            fractions = common_poles(self, wave, &mut sampled, &before.next, options).ok();
        }
        // 3. Where that does not do, from the poles of the trace.
        if fractions.as_ref().is_none_or(|fractions| fractions.error > tolerance) {
            let target = RowTarget { tolerance, most_poles, bottom_scale: 1.0 };
            let scales = self.scales(wave);
            let sample = |wave: &CellWave, rungs: &[usize], faces: &mut Vec<FaceValues>| {
                faces.extend(rungs.iter().map(|&rung| {
                    let [driven, odd] = self.parts(wave, rung).map(|part| trace(&part, &scales));
                    let evaluations = wave.terms.len() as u64;
                    FaceValues { driven, bottom: Complex64::ZERO, odd: [odd, Complex64::ZERO], evaluations }
                }));
            };
            let traces = fit_row(self.ladder, [(number, wave)], &target, sample, stop)?;
            let start = traces.first().map_or(&[][..], |fitted| &fitted.entry.poles);
            let again = common_poles(self, wave, &mut sampled, start, options).map_err(broken)?;
            if fractions.as_ref().is_none_or(|fractions| again.error < fractions.error) {
                fractions = Some(again);
            }
        }
        let fractions = fractions.ok_or_else(|| broken(RationalError::NotFinite { stage: "tractions" }))?;
        // 4. Fewer poles.
        let is_first = before.is_none();
        let fractions = if fractions.error <= tolerance {
            // From scratch a fit may hold superfluous poles; its neighbours inherit the rest.
            let removals = if is_first { FIRST_REMOVALS } else { REMOVALS };
            fewer_poles(&sampled, fractions, removals, options, self.ladder.top).map_err(broken)?
        } else {
            fractions
        };
        let error = fractions.error;
        if error > REFUSED_FROM * tolerance {
            return Err(refused(error, order(&fractions.poles), RefusalReason::Rounds));
        }
        // 5. Channels, in unscaled components.
        let (poles, mut channels) = channels_of(&sampled, &fractions);
        let root = self.scales(wave).map(f64::sqrt);
        for PoleChannel { input, output, odd } in &mut channels {
            for component in 0..COMPONENTS {
                input[component] *= root[component];
                output[component] *= root[component];
                odd[component] *= root[component];
            }
        }
        let next = fractions.poles;
        let grid = sampled.fitted.iter().copied().filter(|rung| *rung <= RUNGS).collect();
        let evaluations = (sampled.values.iter().flatten().count() * wave.terms.len()) as u64;
        Ok(Wave { poles, channels, error, next, grid: thinned(grid), evaluations })
    }
}

/// Every second rung of a grid that has grown too dense.
fn thinned(grid: Vec<usize>) -> Vec<usize> {
    if grid.len() < MOST_RUNGS { grid } else { grid.into_iter().step_by(2).collect() }
}

/// Fits the waves of a list of rows, each row with n rising, in their order; checks `stop` before every wave. Of
/// several refused waves the error is that of the first in the order of the list.
pub(crate) fn fit_tractions(
    sums: &CellSums,
    rows: &[CellRow],
    options: &CellFitOptions,
    stop: &AtomicBool,
) -> Result<TractionModel, FitError> {
    let ladder = Ladder::new(options.top);
    let at = in_parallel::map(&ladder.points, |&s| sums.at(s));
    let exact = Exact { sums, at: &at, ladder: &ladder };
    let fit = |row: &CellRow| -> Result<Vec<Wave>, FitError> {
        let mut done: Vec<Wave> = Vec::new();
        for wave in &row.waves {
            if stop.load(Ordering::Relaxed) {
                return Err(FitError::Stopped);
            }
            let fitted = exact.fit(wave, done.last(), options, stop)?;
            done.push(fitted);
        }
        Ok(done)
    };
    let fitted: Vec<Result<Vec<Wave>, FitError>> = in_parallel::map(rows, fit);
    let mut model = TractionModel { poles: PoleModel::new(0), channels: Vec::new(), turns: sums.turns(), error: 0.0 };
    for row in fitted {
        for wave in row? {
            model.poles.push(&wave.poles, [&[], &[]], wave.evaluations);
            model.channels.extend(wave.channels);
            model.error = model.error.max(wave.error);
        }
    }
    Ok(model)
}
