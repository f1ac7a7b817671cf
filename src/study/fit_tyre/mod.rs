//! A tyre identified from measured driving-point mobilities (docs/theory.md 3.3).
//!
//! Residuals are differences of level and phase over their uncertainties; unknowns are logarithms of chosen parameters
//! within a factor [`BOUND`] of the start. A single descent ends in a wrong local minimum from about half of the
//! starts, where a computed mode lies on a measured neighbour; so:
//! 1. the start and [`TRIALS`] - 1 more points, spread evenly over tension and foundation, are evaluated on the
//!    frequencies up to [`LOW`];
//! 2. bounded least squares from the best [`BEST`] of them on these frequencies, until one explains them;
//! 3. the same from the best of these on all frequencies.
//!
//! Values that are no driving-point mobility are refused first.
//!
//! With J at the end, (J^T J)^-1 holds the variances and correlations of the logarithms. Where the residuals are larger
//! than their uncertainties explain, the model or the uncertainties are wrong, and intervals grow by sqrt(chi^2/N).

pub mod measured;
mod misfit;
mod parameters;
mod passivity;
mod quantity;
pub(crate) mod universal_file;

pub use misfit::Uncertainty;
pub use parameters::{BOUND, Parameter};

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use faer::Mat;
use num_complex::Complex64;
use thiserror::Error;

use crate::numeric::bounded_least_squares::{IterationLimits, jacobian, minimise, squares};
use crate::numeric::in_parallel;
use crate::scene::Tyre;
use measured::MeasuredPoint;
use misfit::Misfit;
use parameters::Space;
use passivity::{NoMobility, judge};

/// Up to this frequency only the lowest modes show \[Hz\].
pub(crate) const LOW: f64 = 260.0;
/// Number of points that are evaluated at first; descents begin from the best [`BEST`] of them.
pub(crate) const TRIALS: usize = 40;
/// Number of descents on low frequencies, see [`TRIALS`].
const BEST: usize = 4;
/// Parts of the work that progress counts: the trials, the descents on low frequencies, the one on all.
pub(crate) const PIECES: u64 = BEST as u64 + 2;

/// chi^2/N of a descent after which no other minimum is looked for: a neighbouring mode gives far more.
const EXPLAINED: f64 = 1.5;
/// Trials lie within this factor of the start, to both sides.
const REACH: f64 = 2.0;
/// Descents on low frequencies end early: the one on all frequencies does the rest. A decrease of 1 corresponds to one
/// standard deviation of a parameter.
const ON_LOW: IterationLimits = IterationLimits { steps: 20, decrease: 0.1 };
const ON_ALL: IterationLimits = IterationLimits { steps: 60, decrease: 1e-3 };
/// A normal variable lies within this many standard deviations of its mean at 95 %.
const SURE: f64 = 1.96;

/// Reasons why nothing was fitted.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FitTyreError {
    /// Fewer numbers than unknowns.
    #[error(
        "{values} measured values ({} numbers) cannot determine {unknowns} parameters: measure at more frequencies, or \
         fix parameters", 2 * values
    )]
    TooFew {
        /// Measured values.
        values: usize,
        /// Free parameters.
        unknowns: usize,
    },
    /// The starting tyre has no mobility.
    #[error("the starting tyre has no finite mobility at the measured frequencies")]
    NotFinite,
    /// Values that no driving-point mobility has.
    #[error(transparent)]
    NoMobility(#[from] NoMobility),
    /// `stop` was set.
    #[error("interrupted")]
    Interrupted,
}

/// A parameter after the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Which.
    pub parameter: Parameter,
    /// Its value in the starting tyre.
    pub start: f64,
    /// Its value in the fitted tyre.
    pub value: f64,
    /// Standard deviation of its logarithm, from the given uncertainties; infinite where the measurement does not
    /// determine it.
    pub deviation: f64,
    /// 95 % interval, wider by sqrt(chi^2/N) where that is above 1.
    pub interval: [f64; 2],
    /// True if it ended at a bound: the start was too far away, or the measurement does not determine it.
    pub at_bound: bool,
}

/// A fitted tyre.
#[derive(Clone, Debug)]
pub struct TyreFit {
    /// Tyre with the fitted values.
    pub tyre: Tyre,
    /// The free parameters, in the order given.
    pub estimates: Vec<Estimate>,
    /// Correlations of the free parameters.
    pub correlations: Vec<Vec<f64>>,
    /// Condition number of the Jacobian: largest over smallest singular value.
    pub condition: f64,
    /// chi^2/N of the starting tyre and of the fitted one, N = residuals less unknowns.
    pub chi_squared: [f64; 2],
    /// Mobilities of the fitted tyre at the measured points \[m/(N s)\].
    pub mobilities: Vec<Complex64>,
    /// Differences of level and phase over their uncertainties, computed less measured; two for each measured value.
    pub residuals: Vec<f64>,
    /// True if the last descent converged before its limit of steps.
    pub converged: bool,
}

/// Fits the free parameters. `watch` is given the number of `PIECES` done and a description of the present one.
///
/// # Errors
/// [`FitTyreError`]. Free parameters without a positive value in the starting tyre keep what they are: see
/// [`Parameter::value`].
pub fn fit(
    start: &Tyre,
    free: &[Parameter],
    points: &[MeasuredPoint],
    uncertainty: Uncertainty,
    stop: &AtomicBool,
    watch: &mut dyn FnMut(u64, &str),
) -> Result<TyreFit, FitTyreError> {
    // 1. Refuse what cannot be fitted: too few values, a start without finite mobility, values that are no mobility.
    if 2 * points.len() <= free.len() {
        return Err(FitTyreError::TooFew { values: points.len(), unknowns: free.len() });
    }
    let space = Space { start, free };
    let misfit = Misfit::new(points, uncertainty);
    let of_all = |point: &[f64]| misfit.residuals_unless(stop, &space.tyre(point));
    let freedom = (2 * points.len() - free.len()) as f64;
    let origin = vec![0.0; free.len()];
    asked(stop)?;
    let computed = misfit.mobilities(&space.tyre(&origin));
    let at_start = squares(&misfit.residuals(&computed));
    if at_start.is_infinite() {
        return Err(FitTyreError::NotFinite);
    }
    judge(points, uncertainty, &computed)?;
    // 2. Find the right minimum from the low frequencies.
    let from = low_point(&space, points, uncertainty, stop, watch)?;
    // 3. Least squares on all frequencies.
    let mut report = |steps: usize, squares: f64| {
        watch(PIECES - 1, &format!("all frequencies, step {steps}: chi^2/N = {:.3}", squares / freedom));
        going_on(stop)
    };
    let found = minimise(&of_all, &from, &space.bounds(), ON_ALL, &mut report);
    asked(stop)?;
    let tyre = space.tyre(&found.point);
    let chi_squared = [at_start, found.squares()].map(|squares| squares / freedom);
    // 4. Intervals and correlations from the Jacobian at the end.
    let slopes = jacobian(&of_all, &found.point, &found.residuals, &space.bounds());
    asked(stop)?;
    let (covariance, condition) = covariance(&slopes);
    let deviations: Vec<f64> = (0..free.len()).map(|index| covariance[(index, index)].sqrt()).collect();
    let wider = SURE * chi_squared[1].max(1.0).sqrt();
    let estimate = |(index, &parameter): (usize, &Parameter)| {
        let [before, value] = [start, &tyre].map(|tyre| parameter.value(tyre).unwrap_or_default());
        let factor = (wider * deviations[index]).exp();
        Estimate {
            parameter,
            start: before,
            value,
            deviation: deviations[index],
            interval: [value / factor, value * factor],
            at_bound: found.point[index].abs() >= BOUND.ln(),
        }
    };
    let correlation = |i: usize, j: usize| covariance[(i, j)] / (deviations[i] * deviations[j]);
    Ok(TyreFit {
        estimates: free.iter().enumerate().map(estimate).collect(),
        correlations: (0..free.len()).map(|i| (0..free.len()).map(|j| correlation(i, j)).collect()).collect(),
        condition,
        chi_squared,
        mobilities: misfit.mobilities(&tyre),
        residuals: found.residuals,
        converged: found.converged,
        tyre,
    })
}

/// `Err` once `stop` is set.
fn asked(stop: &AtomicBool) -> Result<(), FitTyreError> {
    if stop.load(Ordering::Relaxed) { Err(FitTyreError::Interrupted) } else { Ok(()) }
}

fn going_on(stop: &AtomicBool) -> ControlFlow<()> {
    if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
}

/// Start of the descent on all frequencies. The origin if there are too few low frequencies.
fn low_point(
    space: &Space<'_>,
    points: &[MeasuredPoint],
    uncertainty: Uncertainty,
    stop: &AtomicBool,
    watch: &mut dyn FnMut(u64, &str),
) -> Result<Vec<f64>, FitTyreError> {
    let low: Vec<MeasuredPoint> = points.iter().filter(|point| point.frequency <= LOW).copied().collect();
    let unknowns = space.free.len();
    let varied: Vec<usize> =
        (0..unknowns).filter(|&index| Parameter::OF_LOW_MODES.contains(&space.free[index])).collect();
    let origin = vec![0.0; unknowns];
    if 2 * low.len() <= unknowns || varied.is_empty() {
        return Ok(origin);
    }
    let misfit = Misfit::new(&low, uncertainty);
    let of_low = |point: &[f64]| misfit.residuals_unless(stop, &space.tyre(point));
    // 1. Evaluate points spread over the parameters of the lowest modes.
    watch(0, &format!("{TRIALS} starts on low frequencies"));
    let tried = |trial: usize| {
        let mut point = origin.clone();
        for (&index, place) in varied.iter().zip(spread(trial)) {
            point[index] = (2.0 * place - 1.0) * REACH.ln();
        }
        (squares(&of_low(&point)), point)
    };
    let mut trials = in_parallel::made(TRIALS, tried);
    asked(stop)?;
    trials.sort_by(|a, b| a.0.total_cmp(&b.0));
    trials.truncate(BEST);
    // 2. Descend from the best of them, until one explains the values.
    let freedom = (2 * low.len() - unknowns) as f64;
    let mut ends = Vec::with_capacity(BEST);
    for ((_, trial), number) in trials.into_iter().zip(1..) {
        let mut report = |steps: usize, squares: f64| {
            let chi = squares / freedom;
            watch(number, &format!("low frequencies, start {number} of {BEST}, step {steps}: chi^2/N = {chi:.3}"));
            going_on(stop)
        };
        let end = minimise(&of_low, &trial, &space.bounds(), ON_LOW, &mut report);
        let explained = end.squares() < EXPLAINED * freedom;
        ends.push((end.squares(), end.point));
        if explained {
            break;
        }
    }
    asked(stop)?;
    Ok(ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(origin, |end| end.1))
}

/// Point `index` of a low-discrepancy sequence in the unit cube, its middle first: multiples of the powers of 1/g, g
/// the root of g^4 = g + 1 (M. Roberts' R sequence).
fn spread(index: usize) -> [f64; 3] {
    const ROOT: f64 = 1.220_744_084_605_759_5;
    [1, 2, 3].map(|power| (0.5 + index as f64 / ROOT.powi(power)).fract())
}

/// (J^T J)^-1 and the condition number of J, from its singular values; both infinite if the decomposition fails.
fn covariance(slopes: &Mat<f64>) -> (Mat<f64>, f64) {
    let unknowns = slopes.ncols();
    let Ok(svd) = slopes.thin_svd() else {
        return (Mat::from_fn(unknowns, unknowns, |_, _| f64::INFINITY), f64::INFINITY);
    };
    let values: Vec<f64> = (0..unknowns).map(|index| svd.S()[index]).collect();
    let vectors = svd.V();
    let entry =
        |i: usize, j: usize| (0..unknowns).map(|k| vectors[(i, k)] * vectors[(j, k)] / values[k].powi(2)).sum::<f64>();
    let condition = values.first().zip(values.last()).map_or(1.0, |(largest, smallest)| largest / smallest);
    (Mat::from_fn(unknowns, unknowns, entry), condition)
}
