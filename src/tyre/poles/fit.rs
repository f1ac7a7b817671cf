//! Fits of all wavenumbers of a tyre.
//!
//! 1. the sums are prepared and the ladder of sampling points is built;
//! 2. the scale of the belt's errors is taken from samples of n = 0;
//! 3. the wavenumbers are fitted in the order of a `Tree`, each as soon as the one that it starts from is done, on all
//!    threads; starts do not depend on the number of threads: same bits for any number of them.

use std::f64::consts::PI;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use rayon::Scope;
use serde::Serialize;

pub(crate) use super::error::FitError;
use super::ladder::{Ladder, REAL, RUNGS};
use super::model::RationalModel;
use super::sampled::Target;
use super::tree::{Tree, Visit};
use super::wavenumber::{Fitted, Start, fit_wavenumber};
use crate::numeric::in_parallel;
use crate::numeric::rational::partial_fractions::order;
use crate::scene::{Law, Tyre};
use crate::tyre::influence::{FaceValues, Field, InfluenceSum, Projection, SumAt, Truncation};

/// Samples in excess of the number of poles from which a fit starts.
const SPARE_SAMPLES: usize = 16;

/// Requirements on a model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FitOptions {
    /// Elements N round the tyre; even.
    pub elements: usize,
    /// Where the force acts: [`Field::Surface`], or [`Field::UnderTread`] for a bedding.
    pub driven: Field,
    /// Top of the band \[rad/s\].
    pub top: f64,
    /// Largest error relative to |H_n(s)|, or to 0.003 of its largest value over the band where that is more.
    pub tolerance: f64,
    /// Relative tolerance of the sums over m and over aliases.
    pub influence_tolerance: f64,
    /// Most poles of one wavenumber, conjugates counted.
    pub most_poles: usize,
    /// True if a constant is fitted. Measured: it does not save a pole, and without it H_n vanishes at infinity as it
    /// should.
    pub constant: bool,
}

impl FitOptions {
    /// With another tolerance; the sums' tolerance is a hundredth of it, so that the fit sees no noise.
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, influence_tolerance: (0.01 * tolerance).clamp(1e-12, 1e-4), ..self }
    }

    /// Defaults for N elements: 1e-5 up to 20 kHz, or as far as a second-order rule reaches (|s| <= 4/dt) at
    /// `highest_speed` \[m/s\] with one step per element.
    pub fn new(tyre: &Tyre, elements: usize, highest_speed: f64) -> Self {
        let reach = 4.0 * highest_speed * elements as f64 / tyre.circumference;
        Self {
            elements,
            driven: Field::Surface,
            top: reach.max(2.0 * PI * 20e3),
            tolerance: 1e-5,
            influence_tolerance: 1e-8,
            most_poles: 160,
            constant: false,
        }
    }
}

fn check(options: &FitOptions) -> Result<(), FitError> {
    let range = |what, value, wanted, ok| if ok { Ok(()) } else { Err(FitError::Options { what, value, wanted }) };
    let n = options.elements;
    range("elements", n as f64, "an even number of at least 4", n >= 4 && n.is_multiple_of(2))?;
    range("top", options.top, "positive and finite", options.top > 0.0 && options.top.is_finite())?;
    let tolerance = options.tolerance;
    range("tolerance", tolerance, "from 1e-10 to 0.1", (1e-10..=0.1).contains(&tolerance))?;
    range("most_poles", options.most_poles as f64, "at least 4", options.most_poles >= 4)
}

/// Fits all wavenumbers n = 0..=N/2.
///
/// # Errors
/// `FitError`; of several refused wavenumbers that of the first one in the order of the `Tree`.
pub fn fit(tyre: &Tyre, options: &FitOptions) -> Result<RationalModel, FitError> {
    fit_unless_stopped(tyre, options, &AtomicBool::new(false))
}

/// As [`fit`], but checks `stop` before every wavenumber, and ends early with [`FitError::Stopped`] once it is set.
pub fn fit_unless_stopped(tyre: &Tyre, options: &FitOptions, stop: &AtomicBool) -> Result<RationalModel, FitError> {
    fit_timed(tyre, options, stop).map(|(model, _)| model)
}

/// Wall time of a fit in two parts; threads work on both by turns, so that the parts are in proportion to all threads'
/// time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FitTimes {
    /// Time of the influence functions' sums at the sampling points.
    pub sums: Duration,
    /// Time of the fit of poles to them.
    pub poles: Duration,
}

/// As [`fit_unless_stopped`], with the times.
pub(crate) fn fit_timed(
    tyre: &Tyre,
    options: &FitOptions,
    stop: &AtomicBool,
) -> Result<(RationalModel, FitTimes), FitError> {
    // 1. Options and materials, then the sums on the ladder.
    let begin = Instant::now();
    check(options)?;
    if let Some(layer) = tyre.layers.iter().find(|layer| layer.material.law == Law::Hysteretic) {
        return Err(FitError::NotCausal { layer: layer.name.clone() });
    }
    let stopped = || stop.load(Ordering::Relaxed);
    if stopped() {
        return Err(FitError::Stopped);
    }
    let projection = Projection::new(tyre, options.elements);
    let sum = InfluenceSum::with(tyre, projection, Truncation::Tail, options.influence_tolerance, options.top);
    let ladder = Ladder::new(options.top);
    // Moduli, cut-offs and asymptotes depend on s only: once for all wavenumbers.
    let at = sum.at_all(&ladder.points);
    let rungs = Rungs { sum, at };
    if stopped() {
        return Err(FitError::Stopped);
    }
    // 2. The belt's scale.
    let tree = Tree::new(options.elements / 2);
    let (bottom_scale, evaluations) = bottom_scale(&rungs, options.driven);
    // 3. All wavenumbers.
    let clock = FitClock::default();
    let work = Work { rungs, ladder, tree, options, bottom_scale, stop, clock };
    let prepared = begin.elapsed();
    let mut done = work.carry_out()?;
    // n = 0 has the samples of the scale, too.
    done[0].entry.statistics.evaluations += evaluations;
    let entries = done.into_iter().map(|fitted| fitted.entry);
    let model = RationalModel::assemble(options.elements, options.driven, options.top, options.tolerance, entries);
    let fitted = begin.elapsed() - prepared;
    let sums = fitted.mul_f64(work.clock.share_of_sums());
    Ok((model, FitTimes { sums: prepared + sums, poles: fitted - sums }))
}

/// Time of all threads \[ns\], in sums and in all: two reads of a clock for some hundred evaluations.
#[derive(Debug, Default)]
struct FitClock {
    sums: AtomicU64,
    all: AtomicU64,
}

impl FitClock {
    fn add(total: &AtomicU64, begin: Instant) {
        total.fetch_add(u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    fn share_of_sums(&self) -> f64 {
        let [sums, all] = [&self.sums, &self.all].map(|total| total.load(Ordering::Relaxed) as f64);
        if all > 0.0 { (sums / all).min(1.0) } else { 0.0 }
    }
}

/// Distance on the axis, in rungs, of the samples for the belt's scale; a resonance is many times wider.
const SCALE_STRIDE: usize = 8;
/// Number of rungs that are evaluated together.
const SCALE_BATCH: usize = 32;

/// Largest |D_0| on the axis, and the evaluations used: the belt moves most at n = 0, and its errors are relative to
/// that.
fn bottom_scale(sums: &Rungs, driven: Field) -> (f64, u64) {
    let rungs: Vec<usize> = (0..=RUNGS).step_by(SCALE_STRIDE).collect();
    let batches: Vec<&[usize]> = rungs.chunks(SCALE_BATCH).collect();
    let of = |rungs: &&[usize]| {
        let mut values = Vec::with_capacity(rungs.len());
        sums.sample(driven, 0, rungs, &mut values);
        let largest = values.iter().fold(0.0_f64, |largest, faces| largest.max(faces.bottom.norm()));
        (largest, values.iter().map(|faces| faces.evaluations).sum::<u64>())
    };
    in_parallel::map(&batches, of)
        .into_iter()
        .fold((0.0, 0), |(largest, sum), (scale, evaluations)| (largest.max(scale), sum + evaluations))
}

/// The sums, and the kernel on the rungs of a ladder.
struct Rungs {
    sum: InfluenceSum,
    at: Vec<SumAt>,
}

impl Rungs {
    /// Appends the exact values of both faces on rungs to `values`.
    fn sample(&self, driven: Field, n: usize, rungs: &[usize], values: &mut Vec<FaceValues>) {
        self.sum.faces(n, rungs.iter().map(|&rung| &self.at[rung]), driven, values);
    }
}

struct Work<'a> {
    rungs: Rungs,
    ladder: Ladder,
    tree: Tree,
    options: &'a FitOptions,
    bottom_scale: f64,
    stop: &'a AtomicBool,
    clock: FitClock,
}

struct Progress {
    /// By rank.
    done: Vec<OnceLock<Result<Fitted, FitError>>>,
    /// Lowest rank that was refused: later ranks are not begun any more, earlier ones still are, so that the same one
    /// is reported whatever the order of the threads.
    refused: AtomicUsize,
}

impl Work<'_> {
    /// Fits every wavenumber as soon as the one from which it starts is done; results by n.
    fn carry_out(&self) -> Result<Vec<Fitted>, FitError> {
        let progress = Progress {
            done: (0..self.tree.len()).map(|_| OnceLock::new()).collect(),
            refused: AtomicUsize::new(usize::MAX),
        };
        rayon::scope(|scope| {
            for root in self.tree.roots() {
                let progress = &progress;
                scope.spawn(move |scope| self.visit(root, progress, scope));
            }
        });
        if self.stop.load(Ordering::Relaxed) {
            return Err(FitError::Stopped);
        }
        let mut by_rank = Vec::with_capacity(self.tree.len());
        for fitted in progress.done {
            // Only what comes after a refused one is missing.
            by_rank.push(fitted.into_inner().unwrap_or(Err(FitError::Stopped))?);
        }
        let mut by_wavenumber: Vec<(usize, Fitted)> =
            by_rank.into_iter().enumerate().map(|(rank, fitted)| (self.tree.visit(rank).wavenumber, fitted)).collect();
        by_wavenumber.sort_unstable_by_key(|(n, _)| *n);
        Ok(by_wavenumber.into_iter().map(|(_, fitted)| fitted).collect())
    }

    /// Fits one wavenumber, then leaves those that start from it to free threads.
    fn visit<'scope>(&'scope self, rank: usize, progress: &'scope Progress, scope: &Scope<'scope>) {
        if self.stop.load(Ordering::Relaxed) || rank > progress.refused.load(Ordering::Relaxed) {
            return;
        }
        let start = self.tree.start(rank).and_then(|start| progress.done[start].get()?.as_ref().ok());
        let begin = Instant::now();
        let fitted = self.fitted(rank, start.map(start_of).unwrap_or_default());
        FitClock::add(&self.clock.all, begin);
        if fitted.is_err() {
            progress.refused.fetch_min(rank, Ordering::Relaxed);
        }
        let is_fitted = fitted.is_ok();
        // Each rank is visited once: the cell is empty.
        let _ = progress.done[rank].set(fitted);
        if is_fitted {
            // The last one spawned is taken first: coarse strides, since most follow from them.
            for &follower in self.tree.followers(rank).iter().rev() {
                scope.spawn(move |scope| self.visit(follower, progress, scope));
            }
        }
    }

    /// Least scale of the errors for a carcass under a bedding: the whole tyre at rest. Beside the springs of the
    /// bedding on it, short waves of the carcass are negligible.
    fn least_scale(&self, wavenumber: usize) -> f64 {
        match self.options.driven {
            Field::UnderTread => {
                self.rungs.sum.value(wavenumber, &self.rungs.at[REAL.start], Field::Surface).value.norm()
            }
            _ => 0.0,
        }
    }

    fn fitted(&self, rank: usize, start: Start) -> Result<Fitted, FitError> {
        let Visit { wavenumber, stride } = self.tree.visit(rank);
        // Far from its start a fit may hold superfluous poles; close to it, its start had none.
        let (removals, removal_below) = match stride {
            0 => (8, 1.0),
            1..=4 => (2, 0.6),
            _ => (6, 0.7),
        };
        let target = Target {
            wavenumber,
            least_scale: self.least_scale(wavenumber),
            tolerance: self.options.tolerance,
            most_poles: self.options.most_poles,
            constant: self.options.constant,
            bottom_scale: self.bottom_scale,
            removals,
            removal_below,
        };
        let mut sample = |rungs: &[usize], values: &mut Vec<FaceValues>| {
            let begin = Instant::now();
            self.rungs.sample(self.options.driven, wavenumber, rungs, values);
            FitClock::add(&self.clock.sums, begin);
        };
        fit_wavenumber(&self.ladder, &target, &start, &mut sample)
    }
}

/// Poles and rungs of a finished neighbour.
pub(super) fn start_of(fitted: &Fitted) -> Start {
    let poles = fitted.entry.poles.clone();
    Start { grid: thinned(&fitted.grid, order(&poles) + SPARE_SAMPLES), poles }
}

/// A grid of at most `most` rungs, distributed as the given one: the neighbour's intermediate fits need not be
/// repeated.
fn thinned(grid: &[usize], most: usize) -> Vec<usize> {
    if grid.len() <= most || most < 2 {
        return grid.to_vec();
    }
    (0..most).map(|i| grid[i * (grid.len() - 1) / (most - 1)]).collect()
}
