//! Models of the tyre that a planned run needs, from the user's cache or fitted.

use std::borrow::Cow;
use std::convert::Infallible;
use std::sync::atomic::AtomicBool;

use super::Plan;
use crate::contact::cells::history::{FewerPoles, STEPS, fewer_poles};
use crate::counters::{Counter, Job, Meter, Stage, Work};
use crate::scene::{History, LoadedScene, SceneError, SetUpError, Tyre, Zone};
use crate::storage::cache::key;
use crate::storage::{Cache, Cached};
use crate::tyre::influence::{CellGrid, CellRow, CellSums, WaveBand};
use crate::tyre::layers::operations;
use crate::tyre::poles::cache::{self, Fetched};
use crate::tyre::poles::pole_model::PoleModel;
use crate::tyre::poles::traction_model::TractionModel;
use crate::tyre::poles::{FitError, FitOptions, FitTimes, RationalModel, fit_timed};

/// Bytes of a wave on cells with its terms, at most (about).
const WAVE_BYTES: f64 = 300.0;

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

/// The model of a band of waves on cells that a planned run needs, from the user's cache or fitted; `evaluations` are
/// those that a fit took.
///
/// # Errors
/// A fit that was [`refused`]; [`SetUpError::Stopped`].
pub(crate) fn planned_cell_model<M: Cached>(
    loaded: &LoadedScene,
    plan: &Plan,
    (band, rows): (WaveBand, &[CellRow]),
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
    match (Cache::open(), cell_key(plan, band, rows)) {
        (Ok(cache), Ok(key)) => cache.fetch(&key, &mut job.warnings, fitted),
        _ => fitted(),
    }
}

/// Fewer poles that predict the history of a band of waves, from the user's cache or found; `None`: all of them do.
pub(crate) fn planned_fewer_poles(
    plan: &Plan,
    (band, rows): (WaveBand, &[CellRow]),
    model: &PoleModel,
    job: &mut Job<'_>,
) -> Option<FewerPoles> {
    let (rule, time_step, tolerance) = (plan.scene.numerics.time_rule, plan.time_step, plan.fewer_poles()?);
    let make = || Ok::<_, Infallible>(fewer_poles(model, rule, time_step, tolerance));
    let key =
        cell_key(plan, band, rows).and_then(|key| self::key::<FewerPoles>(&(key, rule, time_step, STEPS, tolerance)));
    let Ok(fewer) = match (Cache::open(), key) {
        (Ok(cache), Ok(key)) => cache.fetch(&key, &mut job.warnings, make),
        _ => make(),
    };
    Some(fewer)
}

/// Key of the cached model of a band of waves on cells.
fn cell_key(plan: &Plan, band: WaveBand, rows: &[CellRow]) -> serde_json::Result<[u8; 32]> {
    let numerics = &plan.scene.numerics;
    let content = (plan.tyre_of(band).levelled(), band.ring, rows, plan.cell_fit(), numerics.influence_tolerance);
    if plan.scene.has_tractions() { key::<TractionModel>(&content) } else { key::<PoleModel>(&content) }
}

/// Number of poles of the models of cells that a cache holds for a plan; `None` if one is missing, or none is needed.
pub(crate) fn cached_cell_poles(plan: &Plan, cache: &Cache) -> Option<usize> {
    let scene = &plan.scene;
    if plan.decisions.zone != Zone::Cells || scene.numerics.history != History::Modal {
        return None;
    }
    let columns = plan.expected().columns;
    // As many waves as a plan that will be refused may have are not listed.
    if WAVE_BYTES * plan.expected_waves(columns)[0] > scene.numerics.memory_bytes() as f64 {
        return None;
    }
    let order = |band: WaveBand| -> Option<usize> {
        let grid = plan.grid_of(band);
        if scene.has_tractions() {
            let key = cell_key(plan, band, &band.traction_rows(&grid, plan.cell_truncation())).ok()?;
            return Some(cache.load::<TractionModel>(&key).ok()??.ok()?.order());
        }
        let key = cell_key(plan, band, &band.rows(&grid, plan.cell_truncation())).ok()?;
        Some(cache.load::<PoleModel>(&key).ok()??.ok()?.order())
    };
    plan.wave_bands(columns as usize).into_iter().map(order).sum()
}

/// Sums over the waves of a band on the cells of a planned scene.
pub(crate) fn cell_sums(plan: &Plan, band: WaveBand) -> CellSums {
    cell_sums_of(plan, &plan.tyre_of(band), plan.grid_of(band))
}

/// Sums of a tyre on some cells, as exact as a plan wants them.
pub(crate) fn cell_sums_of(plan: &Plan, tyre: &Tyre, grid: CellGrid) -> CellSums {
    let numerics = &plan.scene.numerics;
    let largest = numerics.time_rule.resolved_symbol() / plan.time_step;
    CellSums::new(tyre, grid, plan.cell_truncation(), numerics.influence_tolerance, largest)
}

/// Sums that carry a band of waves: those of the tyre as a `whole`, or of its own ring, or with its sides moved.
pub(crate) fn band_sums<'a>(plan: &Plan, band: WaveBand, whole: &'a CellSums) -> Cow<'a, CellSums> {
    if band.ring.is_some() || band.folded { Cow::Owned(cell_sums(plan, band)) } else { Cow::Borrowed(whole) }
}

/// Counts evaluations of the compliance of a planned scene's tyre, and their arithmetic, two flops per multiply-add.
pub(crate) fn count_evaluations(plan: &Plan, evaluations: u64, meter: &mut Meter) {
    let flop = evaluations * operations(plan.decisions.tyre.layers.len() as u64);
    meter.count(Counter::ComplianceEvaluations, evaluations);
    meter.add_work(Stage::Influence, Work { multiply_adds: flop / 2, bytes: 0 });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::scene::tests::edited;
    use crate::test_models::replaced;
    use crate::tyre::poles::cells::fit_cells;

    #[test]
    fn a_fit_of_cells_that_is_cached_is_not_planned_again() {
        let cells = ("tread = \"elastic\"", "zone = \"cells\"\ncells_across = 2");
        let text = replaced(&edited("elements = 512", "elements = 32"), &[cells]);
        let mut plan = Plan::new(&Scene::from_str(&text, "test.toml").unwrap().scene);
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::at(folder.path().to_owned(), u64::MAX);
        let has_fit = |plan: &Plan| plan.amounts().work.iter().any(|work| work.stage == Stage::Fit);
        assert!(cached_cell_poles(&plan, &cache).is_none() && has_fit(&plan));
        let (whole, mut poles, mut stored) = (cell_sums(&plan, WaveBand::WHOLE), 0, 0);
        for band in plan.wave_bands(plan.expected().columns as usize) {
            let sums = band_sums(&plan, band, &whole);
            let rows = sums.waves(band);
            let model = fit_cells(&sums, &rows, &plan.cell_fit(), &AtomicBool::new(false)).unwrap();
            cache.store(&cell_key(&plan, band, &rows).unwrap(), &model).unwrap();
            poles += model.order();
            stored += model.stored();
        }
        plan.cached_cell_poles = cached_cell_poles(&plan, &cache);
        assert!(plan.cached_cell_poles == Some(poles) && !has_fit(&plan));
        assert!((plan.amounts().poles - poles as f64).abs() < 0.5);
        let found: u64 = cache.list(&[PoleModel::KIND]).unwrap().iter().map(|entry| entry.bytes).sum();
        let planned = poles as f64 * PoleModel::bytes_of_pole(1, plan.decisions.tyre.turns());
        assert!((0.7..1.0).contains(&(planned / found as f64)), "{planned} for {found}");
        // A plan does not know how many poles are real, which are stored whole.
        let planned = (2 * stored) as f64 * PoleModel::bytes_of_pole(1, plan.decisions.tyre.turns());
        assert!(
            (0.95..1.0).contains(&(planned / found as f64)),
            "{planned} of {poles} poles, {stored} stored, for {found}"
        );
    }
}
