//! Accuracy against time: every knob of a scene that trades one for the other, against one converged reference.
//!
//! 1. The axle is held at the height at which it carries its load; the reference is rolled, and the same half
//!    as fine. For first order or better, their difference is a bound for the error of the reference.
//! 2. The presets and the scene's settings are rolled.
//! 3. Every knob ([`knobs::knobs`]) is swept with the rest at the reference.
//! 4. The Pareto front ([`front()`]) of all of them, by exact work.
//!
//! An outline ([`Sweep::Outline`]) has a coarser reference, leaves out the presets, and does half of 3. Runs follow one
//! another, so that none disturbs the time of another; a study that is stopped keeps those that were rolled.

pub(crate) mod knobs;
pub(crate) mod runs;
pub(crate) mod settings;

use serde::Serialize;

pub(crate) use knobs::Knob;
pub(crate) use runs::StudyCost;
pub use runs::{StudyPoint, front};
pub(crate) use settings::Settings;
pub use settings::{StudyOptions, Sweep};

use crate::counters::Job;
use crate::plan::front::FrontRow;
use crate::plan::{Plan, unit};
use crate::run::RunError;
use crate::scene::{Contact, LoadedScene, Numerics, Road, Scene, SceneError, Zone};
use crate::study::trial::{RunDifference, SETTLING, Trials, least_rate};
use crate::tyre::poles::expected_fit;
use runs::StudyRuns;

/// Findings of a study.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Options of the study.
    pub options: StudyOptions,
    /// The converged run that all others are compared with.
    pub reference: StudyPoint,
    /// Difference of a reference half as fine, and so the uncertainty of the reference: smaller differences from it
    /// say nothing.
    #[serde(rename = "doubt")]
    pub uncertainty: RunDifference,
    /// The swept knobs, with their runs.
    pub knobs: Vec<Knob>,
    /// The scene's settings, and the presets.
    pub named: Vec<StudyPoint>,
    /// The front by exact work, cheapest first: nothing with less work is closer to the reference.
    pub front: Vec<StudyPoint>,
    /// False if the user stopped the study: it holds the runs up to there.
    pub complete: bool,
    /// Number of runs; settings that several points have were rolled once.
    #[serde(skip)]
    pub(crate) runs: usize,
}

/// Studies a scene. Stopped after its reference was rolled, it returns what there is.
///
/// # Errors
/// A scene that has no levels to compare; a study that would take longer than the scene's time limit; of any of the
/// runs; [`RunError::Interrupted`] before there is anything.
pub fn study(loaded: &LoadedScene, options: &StudyOptions, job: Job<'_>) -> Result<Study, RunError> {
    let (scene, StudyOptions { highest, sweep, .. }) = (&loaded.scene, *options);
    if matches!(scene.road, Road::Smooth) {
        let wrong = "the force on a smooth road has no levels to compare";
        return Err(SceneError::from(loaded.complain("road.kind", wrong, "a rough road")).into());
    }
    // 1. What will be rolled. Over cells the knobs of a whole study take long enough without presets.
    let has_presets = sweep == Sweep::Presets || sweep == Sweep::Knobs && scene.contact.zone == Zone::Slices;
    let rows = FrontRow::all(scene).iter().filter(|_| has_presets);
    let mut named: Vec<(&str, Settings)> =
        rows.map(|row| (row.preset.name(), Settings::of_row(scene, row, highest))).collect();
    let of_scene = Settings::of(scene);
    // The reference is finer than the finest preset.
    let finest = named.iter().map(|(_, settings)| settings.numerics.elements).max().unwrap_or_default();
    let finer = (5 * finest > 8 * of_scene.numerics.elements).then_some(5 * finest / 4);
    let reference = Settings::reference(scene, &StudyOptions { elements: options.elements.or(finer), ..*options });
    let mut shorter = scene.clone();
    (shorter.rolling.warm_up, shorter.rolling.duration) = (SETTLING, options.duration);
    // Runs that are compared by their forces need no receivers.
    (shorter.receivers, shorter.radiation, shorter.effects.radiation) = Default::default();
    let mut knobs = Vec::new();
    if sweep != Sweep::Presets {
        knobs = knobs::knobs(&shorter, &reference, highest, sweep == Sweep::Outline);
        if of_scene.rate(scene) >= least_rate(highest) {
            named.insert(0, ("the scene", of_scene));
        }
    }
    let half = knobs::half(&reference, &shorter);
    // 2. Each of these runs is checked and forecast.
    let all = [&reference, &half]
        .into_iter()
        .chain(named.iter().map(|(_, settings)| settings))
        .chain(knobs.iter().flat_map(|knob| &knob.steps).map(|(_, settings)| settings));
    let planned = forecast(loaded, &shorter, all)?;
    let seconds = planned.iter().map(|(_, seconds)| seconds).sum::<f64>();
    job.progress.note(&format!("about {} runs, {seconds:.0} s on this machine", planned.len()));
    // 3. They are rolled, as far as the user waits.
    let mut trials = Trials::shared(seconds, job);
    trials.announce("the height of the axle", 0.0);
    let held = trials.held(scene, options.duration)?;
    let mut runs = StudyRuns { scene: held, highest, planned, trials: &mut trials, known: Vec::new() };
    let mut study = Study {
        options: *options,
        reference: runs.point("reference", &reference)?,
        uncertainty: RunDifference::default(),
        knobs,
        named: Vec::new(),
        front: Vec::new(),
        complete: false,
        runs: 0,
    };
    let carried_out = study.carry_out(&mut runs, &half, &named);
    study.runs = runs.known.len();
    match carried_out {
        Ok(()) => study.complete = true,
        Err(RunError::Interrupted { .. }) => {}
        Err(error) => return Err(error),
    }
    // 4. The front of all of them.
    let coordinates: Vec<(f64, f64)> = study.points().map(StudyPoint::coordinates).collect();
    study.front = front(&coordinates).into_iter().filter_map(|index| study.points().nth(index).cloned()).collect();
    trials.finish();
    Ok(study)
}

impl Study {
    /// All points but the reference, each with its knob, if it has one.
    pub(crate) fn groups(&self) -> impl Iterator<Item = (Option<&'static str>, &StudyPoint)> {
        let knobs = self.knobs.iter().flat_map(|knob| knob.points.iter().map(move |point| (Some(knob.name), point)));
        self.named.iter().map(|point| (None, point)).chain(knobs)
    }

    /// All points, those of the knobs last.
    pub fn points(&self) -> impl Iterator<Item = &StudyPoint> {
        self.groups().map(|(_, point)| point)
    }

    /// The presets that were rolled, with their stated errors \[dB\].
    pub fn presets(&self) -> impl Iterator<Item = (&StudyPoint, f64)> {
        self.named.iter().filter_map(|point| {
            let Contact { zone, sub_cells, .. } = point.settings.contact;
            let mut rows = FrontRow::table(zone, sub_cells > Some(1)).iter();
            let row = rows.find(|row| row.preset.name() == point.label)?;
            Some((point, row.error(self.options.highest)?))
        })
    }

    /// Rolls all runs, and keeps each result as soon as it is there.
    fn carry_out(
        &mut self,
        runs: &mut StudyRuns<'_, '_>,
        half: &Settings,
        named: &[(&str, Settings)],
    ) -> Result<(), RunError> {
        self.uncertainty = runs.point("half as fine", half)?.difference;
        for (label, settings) in named {
            self.named.push(runs.point(label, settings)?);
        }
        for knob in &mut self.knobs {
            for (label, settings) in &knob.steps {
                match runs.point(&format!("{} {label}", knob.name), settings) {
                    Ok(found) => knob.points.push(StudyPoint { label: label.clone(), ..found }),
                    // Such as a model that cannot be fitted: the other settings may still run.
                    Err(RunError::Scene(error)) => knob.missing = Some(format!("{label}: {}", error.problem())),
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(())
    }
}

/// Checks every run, each once, and the forecast time of all of them \[s\] against the scene's limit.
fn forecast<'a>(
    loaded: &LoadedScene,
    scene: &Scene,
    all: impl Iterator<Item = &'a Settings>,
) -> Result<Vec<(Settings, f64)>, RunError> {
    let (costs, threads) = (unit::known(), rayon::current_num_threads());
    let mut scene = scene.clone();
    scene.numerics.forget_wishes();
    let resting = Plan::new(&scene);
    let (mut planned, mut fitted): (Vec<(Settings, f64)>, _) = (Vec::new(), Vec::new());
    for settings in all {
        if planned.iter().any(|(other, _)| other == settings) {
            continue;
        }
        let variant = LoadedScene::from_scene(&settings.on(&scene), "variant")?;
        let mut plan = Plan::new(&variant.scene).standing_as(&resting).with_cached_model();
        plan.check(&variant)?;
        let Numerics { elements, pole_tolerance, .. } = plan.scene.numerics;
        if fitted.contains(&plan.fit) {
            plan.cached_poles =
                plan.cached_poles.or(Some(expected_fit::poles(elements as f64, pole_tolerance) as usize));
        }
        fitted.push(plan.fit);
        planned.push((settings.clone(), plan.forecast(&costs, threads, 0.0).wall_seconds));
    }
    let hours = planned.iter().map(|(_, seconds)| seconds).sum::<f64>() / 3600.0;
    let limit = loaded.scene.numerics.time_limit;
    if hours > limit {
        let wrong =
            format!("the runs of the study would take about {hours:.1e} h, more than numerics.time_limit = {limit} h");
        let right = "a shorter --duration, a coarser reference (--elements, --substeps), or a larger time_limit";
        return Err(SceneError::from(loaded.complain("numerics.time_limit", wrong, right)).into());
    }
    Ok(planned)
}
