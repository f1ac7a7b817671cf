//! Models of the tyre that a planned run needs, from the user's cache or fitted.

use std::borrow::Cow;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::Plan;
use crate::counters::{Counter, Job, Meter, Stage, Work};
use crate::scene::{LoadedScene, SceneError, SetUpError, Tyre};
use crate::storage::cache::key;
use crate::storage::{Cache, Cached};
use crate::tyre::influence::{CellGrid, CellSums, WaveBand};
use crate::tyre::layers::operations;
use crate::tyre::poles::cache::{self, Fetched};
use crate::tyre::poles::{FitError, FitOptions, FitTimes, RationalModel, fit_timed};

/// A model from the user's cache, or fitted if there is none; without a usable cache a warning is returned with it.
///
/// # Errors
/// `FitError` for a fit that is refused, or stopped by `stop`.
pub fn fetch(tyre: &Tyre, options: &FitOptions, stop: &AtomicBool) -> Result<Fetched, FitError> {
    match Cache::open() {
        Ok(cache) => cache::fetch(&cache, tyre, options, stop),
        Err(error) => {
            let (model, times) = fit_timed(tyre, options, stop)?;
            let warnings = vec![format!("no cache of influence models: {error}")];
            Ok(Fetched { model, warm: false, times: Some(times), warnings })
        }
    }
}

/// Translates an error of a fit: the user's stop, or a complaint about the scene's tolerance, with the remedy `right`.
pub(crate) fn refused(loaded: &LoadedScene, error: FitError, right: &str) -> SetUpError {
    match error {
        FitError::Stopped => SetUpError::Stopped,
        error => SceneError::from(loaded.complain("numerics.pole_tolerance", error.to_string(), right)).into(),
    }
}

/// The model that a planned run needs, metered; `right` is the remedy for a user whose fit is refused.
///
/// # Errors
/// A fit that was [`refused`]; [`SetUpError::Stopped`].
pub(crate) fn planned_model(
    loaded: &LoadedScene,
    plan: &Plan,
    right: &str,
    job: &mut Job<'_>,
) -> Result<RationalModel, SetUpError> {
    let open = job.meter.open();
    let fetched = fetch(&plan.decisions.tyre, &plan.fit, job.stop).map_err(|error| refused(loaded, error, right))?;
    match fetched.times {
        None => job.meter.close(open, Stage::Influence),
        Some(FitTimes { sums, poles }) => {
            let share = poles.as_secs_f64() / (sums + poles).as_secs_f64();
            job.meter.close_shared(open, &[(Stage::Influence, 1.0 - share), (Stage::Fit, share)]);
        }
    }
    job.warnings.extend(fetched.warnings);
    // The evaluations of a cached model belong to an earlier run.
    let evaluations = if fetched.warm { 0 } else { fetched.model.evaluations() };
    count_evaluations(plan, evaluations, &mut job.meter);
    Ok(fetched.model)
}

/// The model of the waves on cells that a planned run needs, from the user's cache or fitted; `evaluations` are those
/// that a fit took.
///
/// # Errors
/// A fit that was [`refused`]; [`SetUpError::Stopped`].
pub(crate) fn planned_cell_model<M: Cached>(
    loaded: &LoadedScene,
    plan: &Plan,
    content: &impl Serialize,
    fit: impl Fn() -> Result<M, FitError>,
    evaluations: fn(&M) -> u64,
    job: &mut Job<'_>,
) -> Result<M, SetUpError> {
    let mut fitted = || -> Result<M, SetUpError> {
        let right = "another tolerance, or history = \"direct\"";
        let model = job.meter.time(Stage::Fit, &fit).map_err(|error| refused(loaded, error, right))?;
        count_evaluations(plan, evaluations(&model), &mut job.meter);
        Ok(model)
    };
    match (Cache::open(), key::<M>(content)) {
        (Ok(cache), Ok(key)) => cache.fetch(&key, &mut job.warnings, fitted),
        _ => fitted(),
    }
}

/// Sums over the waves of a tyre on the cells of a planned scene.
pub(crate) fn cell_sums(plan: &Plan, tyre: &Tyre) -> CellSums {
    let numerics = &plan.scene.numerics;
    let grid = CellGrid::new(tyre, numerics.elements, plan.cell_grid().across);
    let largest = numerics.time_rule.resolved_symbol() / plan.time_step;
    CellSums::new(tyre, grid, plan.cell_truncation(), numerics.influence_tolerance, largest)
}

/// Sums that carry a band of waves: those of the tyre as a `whole`, or, for a folded band, of the tyre with its sides
/// moved.
pub(crate) fn band_sums<'a>(plan: &Plan, band: WaveBand, whole: &'a CellSums) -> Cow<'a, CellSums> {
    if band.folded { Cow::Owned(cell_sums(plan, &plan.tyre_of(band))) } else { Cow::Borrowed(whole) }
}

/// Counts evaluations of the compliance of a planned scene's tyre, and their arithmetic, two flops per multiply-add.
pub(crate) fn count_evaluations(plan: &Plan, evaluations: u64, meter: &mut Meter) {
    let flop = evaluations * operations(plan.decisions.tyre.layers.len() as u64);
    meter.count(Counter::ComplianceEvaluations, evaluations);
    meter.add_work(Stage::Influence, Work { multiply_adds: flop / 2, bytes: 0 });
}
