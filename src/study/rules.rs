//! Time rules side by side for one scene: accuracy of modes, stability of the inverse, work against precision.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::contact::ContactError;
use crate::contact::stability::Stability;
use crate::counters::Unwatched;
use crate::counters::{Counter, Stage};
use crate::plan::Plan;
use crate::plan::models::{fetch, refused};
use crate::run::RunError;
use crate::scene::{History, LoadedScene, Rolling, Scene, TimeRule};
use crate::study::trial::{Common, Trials};

/// Properties of a rule for a scene's tyre and time step.
#[derive(Clone, Debug)]
pub(crate) struct RuleReport {
    /// The compared rule.
    pub rule: TimeRule,
    /// Diagnosis of the inverse.
    pub stability: Stability,
}

/// Diagnosis of every rule at the scene's time step.
///
/// # Errors
/// A fit that was refused, or stopped by `stop`.
pub(crate) fn compare(loaded: &LoadedScene, stop: &AtomicBool) -> Result<Vec<RuleReport>, RunError> {
    let plan = Plan::new(&loaded.scene);
    let model =
        fetch(&plan.decisions.tyre, &plan.fit, stop).map_err(|error| refused(loaded, error, "another tolerance"))?;
    let (field, time_step) = (plan.field, plan.time_step);
    TimeRule::ALL
        .into_iter()
        .map(|rule| {
            let stability =
                Stability::of(&model.model, field, rule, time_step, 0.0).ok_or(ContactError::NoSuchField)?;
            Ok(RuleReport { rule, stability })
        })
        .collect()
}

/// One run of a comparison.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WorkPoint {
    /// Rule of the run.
    pub rule: TimeRule,
    /// Steps per element.
    pub substeps: usize,
    /// Error of the total force up to the highest frequency, relative to its root mean square there.
    pub error: f64,
    /// Multiply-adds of the history.
    pub multiply_adds: u64,
    /// Linear solves.
    pub solves: u64,
    /// Wall time of history, transforms and search.
    pub wall: Duration,
}

/// Work and precision of several rules.
#[derive(Clone, Debug)]
pub(crate) struct WorkPrecision {
    /// Runs, by rule and then by substeps.
    pub points: Vec<WorkPoint>,
    /// Difference of the two references (`sdirk2` and `bdf2` at `finest` substeps), relative as [`WorkPoint::error`]:
    /// smaller errors say nothing.
    pub doubt: f64,
    /// Time compared \[s\].
    pub time: f64,
}

/// Rolls the scene at a fixed height with each rule and number of substeps and compares the forces up to `highest`
/// \[Hz\] with those at `finest` substeps, over `duration` \[s\]. The history is modal throughout. `stop` is polled
/// during runs and fits.
///
/// # Errors
/// Errors of a run.
pub(crate) fn work_precision(
    loaded: &LoadedScene,
    rules: &[TimeRule],
    substeps: &[usize],
    finest: usize,
    highest: f64,
    duration: f64,
    stop: &AtomicBool,
) -> Result<WorkPrecision, RunError> {
    let mut watch = Unwatched;
    let mut trials = Trials::new(0.0, stop, &mut watch);
    let mut scene = loaded.scene.clone();
    scene.numerics.history = History::Modal;
    let scene = trials.held(&scene, duration)?;
    let reference = rolled(&mut trials, &scene, TimeRule::Sdirk2, finest, highest)?.0;
    let other = rolled(&mut trials, &scene, TimeRule::Bdf2, finest, highest)?.0;
    let mut points = Vec::new();
    for &rule in rules {
        for &substeps in substeps {
            let (force, point) = rolled(&mut trials, &scene, rule, substeps, highest)?;
            points.push(WorkPoint { error: force.difference(&reference).force, ..point });
        }
    }
    Ok(WorkPrecision { points, doubt: other.difference(&reference).force, time: duration })
}

/// Force up to `highest` \[Hz\], and its cost; the point's error is still 0.
fn rolled(
    trials: &mut Trials<'_>,
    scene: &Scene,
    rule: TimeRule,
    substeps: usize,
    highest: f64,
) -> Result<(Common, WorkPoint), RunError> {
    let mut scene = scene.clone();
    (scene.numerics.time_rule, scene.numerics.substeps) = (rule, substeps);
    let trial = trials.roll(&scene)?;
    let meter = &trial.results.meter;
    let point = WorkPoint {
        rule,
        substeps,
        error: 0.0,
        multiply_adds: meter.counted(Counter::HistoryMultiplyAdds),
        solves: meter.counted(Counter::Solves),
        wall: [Stage::History, Stage::Transforms, Stage::ActiveSet]
            .map(|stage| meter.whole(stage).spent.wall)
            .iter()
            .sum(),
    };
    let Rolling { warm_up, duration, .. } = scene.rolling;
    Ok((Common::of(&trial, warm_up..warm_up + duration, highest), point))
}
