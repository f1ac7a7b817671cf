//! Accuracy against time: every knob of a scene that trades one for the other, against one converged reference.
//!
//! 1. The axle is held at the height at which it carries its load; the reference ([`knobs::reference`]) is rolled, and
//!    the same with its elements, its steps and its cells halved and doubled: [`Richardson`] turns the differences into
//!    the uncertainty of all that follows.
//! 2. Every knob ([`knobs::knobs`]) is swept with the rest at the reference.
//! 3. Combinations ([`joint`]) are chosen, rolled, and their expectation corrected, one after the other.
//! 4. Where there are receivers, the discretisation of the sound's transfer paths ([`sound`]), with the same forces.
//! 5. The Pareto front ([`front()`]) of all of them, by exact work.
//!
//! An outline ([`Sweep::Outline`]) does less of 1 and 2, and leaves out 3 and 4. Runs follow one another, so that none
//! disturbs the time of another; a study that is stopped keeps those that were rolled.

pub(crate) mod front;
pub(crate) mod joint;
pub(crate) mod knobs;
pub(crate) mod lab;
pub(crate) mod options;
pub(crate) mod presets;
pub(crate) mod richardson;
pub(crate) mod settings;
pub mod sound;
pub(crate) mod verdict;

use std::sync::atomic::AtomicBool;

use serde::Serialize;

pub(crate) use front::front;
pub(crate) use joint::Joint;
pub use knobs::Kind;
pub(crate) use knobs::Knob;
pub(crate) use lab::Cost;
pub use lab::Point;
pub use options::StudyOptions;
pub use options::Sweep;
pub(crate) use richardson::Richardson;
pub(crate) use settings::Settings;
pub(crate) use sound::{SoundDifference, SoundPoint, SoundStudy};

use crate::counters::Progress;
use crate::plan::{Plan, UnitCosts, unit_record};
use crate::run::RunError;
use crate::scene::{LoadedScene, Numerics, Radiation, Road, Scene, SceneError, Switch, Zone};
use crate::study::trial::{Difference, SETTLING, Trials, least_rate};
use crate::tyre::poles::expected_fit;
use lab::{Expected, Lab};

/// Errors below this share of the reference's uncertainty do not justify a run of a combination.
const FLOOR: f64 = 0.25;

/// Convergence of the reference in one of its knobs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Refined {
    /// The knob that was halved and doubled.
    pub knob: &'static str,
    /// Largest difference of a level \[dB\].
    pub worst: Richardson,
    /// Rms difference of the levels \[dB\].
    pub rms: Richardson,
    /// Relative difference of the force.
    pub force: Richardson,
    /// Uncertainty of the mean force.
    pub mean_force: Richardson,
    /// Uncertainty of the patch's length.
    pub contact_length: Richardson,
    /// Uncertainty of the rolling resistance.
    pub rolling_resistance: Richardson,
}

/// Findings of a study.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Options asked for.
    pub options: StudyOptions,
    /// The converged run that all others are compared with.
    pub reference: Point,
    /// Its convergence, by knob.
    pub refined: Vec<Refined>,
    /// Uncertainty of the reference: smaller differences from it say nothing.
    pub doubt: Difference,
    /// The swept knobs, with their runs.
    pub knobs: Vec<Knob>,
    /// The scene's own settings, and others with a name.
    pub named: Vec<Point>,
    /// The combinations that were rolled, in that order.
    pub joint: Vec<Joint>,
    /// The front by exact work, cheapest first: nothing with less work is closer to the reference.
    pub front: Vec<Point>,
    /// Discretisation of the sound's transfer paths, where there are receivers and knobs are swept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sound: Option<SoundStudy>,
    /// Threads of the pool.
    pub threads: usize,
    /// Number of runs that were rolled.
    pub rolled: usize,
    /// False if the user stopped the study: it holds the runs up to there.
    pub complete: bool,
}

impl Study {
    /// All points on the same model: named points, combinations, and swept knobs that change no model and were compared
    /// with the reference.
    pub fn points(&self) -> impl Iterator<Item = &Point> {
        points(&self.knobs, &self.named, &self.joint)
    }
}

fn points<'a>(knobs: &'a [Knob], named: &'a [Point], joint: &'a [Joint]) -> impl Iterator<Item = &'a Point> {
    let swept = knobs.iter().filter(|knob| knob.kind != Kind::Model && knob.anchor.is_none());
    let swept = swept.flat_map(|knob| &knob.points);
    named.iter().chain(joint.iter().map(|joint| &joint.point)).chain(swept)
}

/// Studies a scene. Stopped after its reference was rolled, it returns what there is.
///
/// # Errors
/// A scene that has no levels to compare; a study that would take longer than the scene's time limit; of any of the
/// runs; [`RunError::Interrupted`] before there is anything.
pub fn study(
    loaded: &LoadedScene,
    options: &StudyOptions,
    stop: &AtomicBool,
    progress: &mut dyn Progress,
) -> Result<Study, RunError> {
    if matches!(loaded.scene.road, Road::Smooth) {
        let wrong = "the force on a smooth road has no levels to compare";
        return Err(SceneError::from(loaded.complain("road.kind", wrong, "a rough road")).into());
    }
    let own = Settings::of(&loaded.scene);
    let of_cells = loaded.scene.contact.zone == Zone::Cells;
    let has_presets = match options.sweep {
        Sweep::Outline => false,
        // The runs of its knobs take long enough.
        Sweep::Knobs => !of_cells,
        _ => true,
    };
    let mut named = if has_presets { presets::named(&loaded.scene, options.highest) } else { Vec::new() };
    let scene = &loaded.scene;
    // Finer than the finest preset.
    let finest = named.iter().map(|(_, settings)| settings.numerics.elements).max().unwrap_or_default();
    let elements = options
        .elements
        .or_else(|| (5 * finest > 8 * own.numerics.elements).then_some((5 * finest / 4).div_ceil(16) * 16));
    let reference = knobs::reference(scene, &StudyOptions { elements, ..options.clone() });
    let mut shorter = scene.clone();
    (shorter.rolling.warm_up, shorter.rolling.duration) = (SETTLING, options.duration);
    // Runs that are compared by their forces need no receivers.
    (shorter.receivers, shorter.radiation) = (Vec::new(), Radiation::default());
    shorter.effects.radiation = Switch::Auto;
    let knobs = match options.sweep {
        Sweep::Outline => knobs::outline(&shorter, &reference, options.highest),
        Sweep::Knobs => knobs::knobs(&shorter, &reference, options.highest),
        Sweep::Neighbours => presets::neighbours(&named),
        Sweep::Nothing => Vec::new(),
    };
    if matches!(options.sweep, Sweep::Outline | Sweep::Knobs)
        && 1.0 / own.time_step(scene) >= least_rate(options.highest)
    {
        named.insert(0, ("the scene".to_owned(), own));
    }
    let refinements = refinements(&reference, options.sweep != Sweep::Outline);
    let planned: Vec<&Settings> = [&reference]
        .into_iter()
        .chain(refinements.iter().flat_map(|(_, coarse, fine)| [Some(coarse), fine.as_ref()]).flatten())
        .chain(named.iter().map(|(_, settings)| settings))
        .chain(knobs.iter().flat_map(|knob| &knob.steps).map(|(_, settings)| settings))
        .collect();
    let costs = unit_record::known();
    let expected = check(loaded, &shorter, &planned, options.runs, &costs)?;
    let (runs, seconds) = (expected.planned.len() + options.runs, expected.seconds(options.runs));
    progress.note(&format!("about {runs} runs, {seconds:.0} s on this machine"));

    let mut trials = Trials::shared(seconds, stop, progress);
    trials.announce("the height of the axle", 0.0);
    let held = trials.held(scene, options.duration)?;
    let mut lab = Lab::new(held.clone(), options.highest, expected, &mut trials);
    let of_reference = lab.point("reference", &reference, &reference)?;
    let mut study = Study {
        options: options.clone(),
        reference: of_reference,
        refined: Vec::new(),
        doubt: Difference::default(),
        knobs,
        named: Vec::new(),
        joint: Vec::new(),
        front: Vec::new(),
        sound: None,
        threads: rayon::current_num_threads(),
        rolled: 0,
        complete: false,
    };
    let mut carried_out = study.carry_out(&mut lab, &reference, &refinements, &named);
    study.rolled = lab.rolled();
    if options.sweep == Sweep::Knobs && carried_out.is_ok() {
        trials.announce("ways of the sound", 0.0);
        carried_out = sound::study(scene, &held, options.highest, &trials).map(|found| study.sound = found);
    }
    match carried_out {
        Ok(()) => study.complete = true,
        Err(RunError::Interrupted { .. }) => {}
        Err(error) => return Err(error),
    }
    let coordinates: Vec<(f64, f64)> = study.points().map(Point::coordinates).collect();
    let all: Vec<&Point> = study.points().collect();
    study.front = front(&coordinates).into_iter().map(|index| all[index].clone()).collect();
    trials.finish();
    Ok(study)
}

impl Study {
    /// Rolls all runs that are compared by their forces, and keeps each result as soon as it is there.
    fn carry_out(
        &mut self,
        lab: &mut Lab<'_, '_>,
        reference: &Settings,
        refinements: &[Refinement],
        named: &[(String, Settings)],
    ) -> Result<(), RunError> {
        for (knob, coarse, fine) in refinements {
            let coarse = lab.point(&format!("{knob}, half"), coarse, reference)?.difference;
            let fine = fine.as_ref().map(|fine| lab.point(&format!("{knob}, twice"), fine, reference)).transpose()?;
            self.refined.push(Refined::new(knob, &coarse, fine.map(|point| point.difference).as_ref()));
            self.doubt = doubt(&self.refined);
        }
        for (label, settings) in named {
            self.named.push(lab.point(label, settings, reference)?);
        }
        for knob in &mut self.knobs {
            let other = knob.anchor.as_ref().unwrap_or(reference);
            for (label, settings) in &knob.steps {
                match lab.named(label, &format!("{} {label}", knob.name), settings, other) {
                    Ok(found) => knob.points.push(found),
                    // Such as a model that cannot be fitted: the other settings may still run.
                    Err(RunError::Scene(error)) => knob.missing = Some(format!("{label}: {}", error.problem())),
                    Err(error) => return Err(error),
                }
            }
        }
        let StudyOptions { runs, highest, .. } = self.options;
        let all = if runs > 0 { joint::candidates(&lab.scene, reference, &self.knobs, highest) } else { Vec::new() };
        while self.joint.len() < runs {
            let known: Vec<(f64, f64)> = self.points().map(Point::coordinates).collect();
            let Some(expected) = joint::next(&all, &self.joint, &known, FLOOR * self.doubt.worst) else { break };
            let label = format!("combination {}", self.joint.len() + 1);
            let point = lab.point(&label, &expected.settings, reference)?;
            let plain = all.iter().find(|candidate| candidate.settings == expected.settings);
            let plain =
                plain.map_or((expected.error, expected.multiply_adds), |plain| (plain.error, plain.multiply_adds));
            self.joint.push(Joint { point, expected, plain });
        }
        Ok(())
    }
}

/// A knob of the reference; the reference with it twice as coarse and, unless that is left out, twice as fine.
type Refinement = (&'static str, Settings, Option<Settings>);

fn refinements(reference: &Settings, are_finer: bool) -> Vec<Refinement> {
    let with = |elements: usize, steps: usize| {
        let substeps = (steps as f64 / elements as f64).round().max(1.0) as usize;
        reference.with(|settings| {
            (settings.numerics.elements, settings.numerics.substeps) = (elements, substeps);
        })
    };
    let (elements, substeps, steps) = (reference.numerics.elements, reference.numerics.substeps, reference.steps());
    let mut all = vec![
        ("elements", with(elements / 2, steps), with(2 * elements, steps)),
        ("substeps", with(elements, elements * (substeps / 2).max(1)), with(elements, 2 * steps)),
    ];
    if let Some(points) = reference.contact.cells_across.filter(|&points| points > 1) {
        let cells = |cells_across: usize| {
            reference.with(|settings| {
                settings.contact.cells_across = Some(cells_across);
                settings.cell_length = settings.cell_length * points as f64 / cells_across as f64;
            })
        };
        all.push(("cells", cells(points / 2), cells(2 * points)));
    }
    all.into_iter().map(|(knob, coarse, fine)| (knob, coarse, are_finer.then_some(fine))).collect()
}

impl Refined {
    fn new(knob: &'static str, coarse: &Difference, fine: Option<&Difference>) -> Self {
        let of = |value: fn(&Difference) -> f64| match fine {
            Some(fine) => Richardson::new(value(coarse), value(fine)),
            None => Richardson::first_order(value(coarse)),
        };
        Self {
            knob,
            worst: of(|difference| difference.worst),
            rms: of(|difference| difference.rms),
            force: of(|difference| difference.force),
            mean_force: of(|difference| difference.mean_force),
            contact_length: of(|difference| difference.contact_length),
            rolling_resistance: of(|difference| difference.rolling_resistance),
        }
    }
}

/// Errors of the reference's knobs together, as independent ones: root of the sum of squares.
fn doubt(refined: &[Refined]) -> Difference {
    let of = |value: fn(&Refined) -> Richardson| {
        refined.iter().map(|refined| value(refined).error.powi(2)).sum::<f64>().sqrt()
    };
    Difference {
        worst: of(|refined| refined.worst),
        worst_band: 0.0,
        rms: of(|refined| refined.rms),
        force: of(|refined| refined.force),
        mean_force: of(|refined| refined.mean_force),
        contact_length: of(|refined| refined.contact_length),
        rolling_resistance: of(|refined| refined.rolling_resistance),
    }
}

/// Checks every run that is known beforehand, and the forecast time of all of them against the scene's limit.
fn check(
    loaded: &LoadedScene,
    scene: &Scene,
    planned: &[&Settings],
    combinations: usize,
    costs: &UnitCosts,
) -> Result<Expected, RunError> {
    let threads = rayon::current_num_threads();
    let mut scene = scene.clone();
    scene.numerics.forget_wishes();
    let own = Plan::new(&scene);
    let (mut expected, mut fitted) = (Expected::default(), Vec::new());
    for &settings in planned {
        // Rolled once, however often it is compared.
        if expected.planned.iter().any(|(rolled, _)| rolled == settings) {
            continue;
        }
        let variant = LoadedScene::from_scene(&settings.on(&scene), "variant")?;
        let mut plan = Plan::new(&variant.scene).standing_as(&own).with_kept_model();
        plan.check(&variant)?;
        let Numerics { elements, pole_tolerance, .. } = plan.scene.numerics;
        if fitted.contains(&plan.fit) {
            plan.kept_poles = plan.kept_poles.or(Some(expected_fit::poles(elements as f64, pole_tolerance) as usize));
        }
        fitted.push(plan.fit);
        expected.planned.push((settings.clone(), plan.forecast(costs, threads, 0.0).wall_seconds));
    }
    let hours = expected.seconds(combinations) / 3600.0;
    let limit = loaded.scene.numerics.time_limit;
    if hours > limit {
        let wrong =
            format!("the runs of the study would take about {hours:.1e} h, more than numerics.time_limit = {limit} h");
        let right = "a shorter --duration, a coarser reference (--elements, --substeps), or a larger time_limit";
        return Err(SceneError::from(loaded.complain("numerics.time_limit", wrong, right)).into());
    }
    Ok(expected)
}
