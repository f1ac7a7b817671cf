//! Accuracy against time: every knob of a scene that trades one for the other, against one converged reference.
//!
//! 1. The axle is held at the height at which it carries its load; the reference ([`knobs::reference`]) is rolled, and
//!    the same with its elements, its steps and its cells halved and doubled: what [`Richardson`] makes of the
//!    differences is the doubt of all that follows.
//! 2. Every knob ([`knobs::knobs`]) is swept with the rest at the reference.
//! 3. Combinations ([`joint`]) are chosen, rolled, and their expectation corrected, one after the other.
//! 4. Where there are receivers, how finely the sound's way is solved ([`sound`]), with the same forces.
//! 5. The Pareto front ([`front()`]) of all of them, by exact work.
//!
//! Runs follow one another, so that none disturbs the time of another.

pub mod front;
pub mod joint;
pub mod knobs;
pub mod lab;
pub mod presets;
pub mod richardson;
pub mod settings;
pub mod sound;
pub mod verdict;

use std::sync::atomic::AtomicBool;

use serde::Serialize;

pub use front::front;
pub use joint::{Candidate, Joint};
pub use knobs::{Kind, Knob};
pub use lab::{Cost, Point};
pub use richardson::Richardson;
pub use settings::Settings;
pub use sound::{SoundDifference, SoundPoint, SoundStudy};

use crate::plan::{Plan, UnitCosts, unit_record};
use crate::run::error::RunError;
use crate::run::progress::Progress;
use crate::scene::{LoadedScene, Radiation, Road, Scene, SceneError, Switch, Zone};
use crate::study::trial::{Difference, SETTLING, Trials, least_rate};
use lab::Lab;

/// Errors below this share of the doubt are not worth a combination.
const FLOOR: f64 = 0.25;

/// What a study rolls beside the reference and the presets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sweep {
    /// Every knob, and the scene's own settings.
    Knobs,
    /// The presets with one setting turned.
    Neighbours,
    /// Nothing.
    Nothing,
}

/// What a study is to do.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyOptions {
    /// Highest frequency compared \[Hz\].
    pub highest: f64,
    /// Time compared \[s\].
    pub duration: f64,
    /// Combinations rolled.
    pub runs: usize,
    /// What is rolled beside the reference and the presets.
    pub sweep: Sweep,
    /// Elements of the reference; default: twice the scene's, or a quarter more than the finest preset's.
    pub elements: Option<usize>,
    /// Steps per element of the reference; default: 48 steps in a period of `highest`.
    pub substeps: Option<usize>,
}

impl StudyOptions {
    /// Highest frequency compared where a scene has none \[Hz\].
    pub const HIGHEST: f64 = 1000.0;
    /// Time compared unless asked for \[s\].
    pub const DURATION: f64 = 1.0;
    /// Combinations rolled unless asked for.
    pub const RUNS: usize = 12;

    /// The defaults for a scene.
    pub fn of(scene: &Scene) -> Self {
        Self {
            highest: scene.numerics.fmax.unwrap_or(Self::HIGHEST),
            duration: scene.rolling.duration.min(Self::DURATION),
            runs: Self::RUNS,
            sweep: Sweep::Knobs,
            elements: None,
            substeps: None,
        }
    }
}

/// How sure the reference is in one of its knobs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Refined {
    /// The knob that was halved and doubled.
    pub knob: &'static str,
    /// Largest difference of a level \[dB\].
    pub worst: Richardson,
    /// Rms difference of the levels \[dB\].
    pub rms: Richardson,
    /// Difference of the force.
    pub force: Richardson,
    /// Of the mean force.
    pub mean_force: Richardson,
    /// Of the patch's length.
    pub contact_length: Richardson,
    /// Of the rolling resistance.
    pub rolling_resistance: Richardson,
}

/// All of a study.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// What was asked for.
    pub options: StudyOptions,
    /// The reference.
    pub reference: Point,
    /// How sure it is.
    pub refined: Vec<Refined>,
    /// Errors below these cannot be told from those of the reference.
    pub doubt: Difference,
    /// The knobs.
    pub knobs: Vec<Knob>,
    /// The scene's own settings, and others with a name.
    pub named: Vec<Point>,
    /// The combinations.
    pub joint: Vec<Joint>,
    /// The front by exact work, cheapest first: settings that nothing with less work is closer to the reference than.
    pub front: Vec<Point>,
    /// How finely the sound's way is solved, where there are receivers and knobs are swept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sound: Option<SoundStudy>,
    /// Threads.
    pub threads: usize,
}

impl Study {
    /// Everything on one model: named points, combinations, and swept knobs that are no other model and were compared
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

/// Studies a scene; the presets are rolled and marked, too.
///
/// # Errors
/// A scene that has no levels to compare; a study that would take longer than the scene's time limit; of any of the
/// runs; [`RunError::Interrupted`].
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
    // Presets are derived for slices.
    let mut named = if of_cells { Vec::new() } else { presets::named(&loaded.scene, options.highest) };
    let scene = &loaded.scene;
    // Finer than the finest preset.
    let finest = named.iter().map(|(_, settings)| settings.numerics.elements).max().unwrap_or_default();
    let elements = options
        .elements
        .or_else(|| (5 * finest > 8 * own.numerics.elements).then_some((5 * finest / 4).div_ceil(16) * 16));
    let reference = knobs::reference(scene, options.highest, elements, options.substeps);
    let mut shorter = scene.clone();
    (shorter.rolling.warm_up, shorter.rolling.duration) = (SETTLING, options.duration);
    // Nobody hears the runs that are compared by their forces.
    (shorter.receivers, shorter.radiation) = (Vec::new(), Radiation::default());
    shorter.effects.radiation = Switch::Auto;
    let knobs = match options.sweep {
        Sweep::Knobs => knobs::knobs(&shorter, &reference, options.highest),
        Sweep::Neighbours => presets::neighbours(&named),
        Sweep::Nothing => Vec::new(),
    };
    if options.sweep == Sweep::Knobs && 1.0 / own.time_step(scene) >= least_rate(options.highest) {
        named.insert(0, ("the scene".to_owned(), own));
    }
    let refinements = refinements(&reference);
    let planned: Vec<&Settings> = [&reference]
        .into_iter()
        .chain(refinements.iter().flat_map(|(_, coarse, fine)| [coarse, fine]))
        .chain(named.iter().map(|(_, settings)| settings))
        .chain(knobs.iter().flat_map(|knob| &knob.steps).map(|(_, settings)| settings))
        .collect();
    let seconds = check(loaded, &shorter, &planned, options.runs)?;
    let runs = planned.len() + options.runs;
    progress.note(&format!("about {runs} runs, {seconds:.0} s on this machine"));

    let time = runs as f64 * (SETTLING + options.duration) + scene.rolling.warm_up;
    let mut trials = Trials::new(time, stop, progress);
    let held = trials.held(scene, options.duration)?;
    let mut lab = Lab::new(held.clone(), options.highest, &mut trials);
    let mut found = carry_out(&mut lab, options, reference, &refinements, knobs, &named)?;
    if options.sweep == Sweep::Knobs {
        found.sound = sound::study(scene, &held, options.highest, &trials)?;
    }
    trials.finish();
    Ok(found)
}

fn carry_out(
    lab: &mut Lab<'_, '_>,
    options: &StudyOptions,
    reference: Settings,
    refinements: &[(&'static str, Settings, Settings)],
    mut knobs: Vec<Knob>,
    named: &[(String, Settings)],
) -> Result<Study, RunError> {
    let of_reference = lab.point("reference", &reference, &reference)?;
    let mut refined = Vec::new();
    for (knob, coarse, fine) in refinements {
        let [coarse, fine] = [coarse, fine].map(|settings| lab.point(knob, settings, &reference));
        refined.push(Refined::new(knob, &coarse?.difference, &fine?.difference));
    }
    let doubt = doubt(&refined);
    for knob in &mut knobs {
        let other = knob.anchor.as_ref().unwrap_or(&reference);
        for (label, settings) in &knob.steps {
            match lab.point(label, settings, other) {
                Ok(found) => knob.points.push(found),
                // Such as a model that cannot be fitted: the others can be all the same.
                Err(RunError::Scene(error)) => knob.missing = Some(format!("{label}: {}", error.problem())),
                Err(error) => return Err(error),
            }
        }
    }
    let mut of_named = Vec::new();
    for (label, settings) in named {
        of_named.push(lab.point(label, settings, &reference)?);
    }

    let all =
        if options.runs > 0 { joint::candidates(&lab.scene, &reference, &knobs, options.highest) } else { Vec::new() };
    let mut joint: Vec<Joint> = Vec::new();
    while joint.len() < options.runs {
        let known: Vec<(f64, f64)> = points(&knobs, &of_named, &joint).map(Point::coordinates).collect();
        let Some(expected) = joint::next(&all, &joint, &known, FLOOR * doubt.worst) else { break };
        let point = lab.point(&format!("combination {}", joint.len() + 1), &expected.settings, &reference)?;
        let plain = all.iter().find(|candidate| candidate.settings == expected.settings);
        let plain = plain.map_or((expected.error, expected.multiply_adds), |plain| (plain.error, plain.multiply_adds));
        joint.push(Joint { point, expected, plain });
    }

    let mut study = Study {
        options: options.clone(),
        reference: of_reference,
        refined,
        doubt,
        knobs,
        named: of_named,
        joint,
        front: Vec::new(),
        sound: None,
        threads: rayon::current_num_threads(),
    };
    let coordinates: Vec<(f64, f64)> = study.points().map(Point::coordinates).collect();
    let on = front(&coordinates);
    let all: Vec<&Point> = study.points().collect();
    study.front = on.into_iter().map(|index| all[index].clone()).collect();
    Ok(study)
}

/// The reference with each of its knobs twice as coarse and twice as fine.
fn refinements(reference: &Settings) -> Vec<(&'static str, Settings, Settings)> {
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
    all
}

impl Refined {
    fn new(knob: &'static str, coarse: &Difference, fine: &Difference) -> Self {
        let of = |value: fn(&Difference) -> f64| Richardson::new(value(coarse), value(fine));
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

/// Errors of the knobs of the reference together: independent ones.
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

/// Checks every run that is known beforehand, and the time of all \[s\].
fn check(loaded: &LoadedScene, scene: &Scene, planned: &[&Settings], runs: usize) -> Result<f64, RunError> {
    let costs: UnitCosts = unit_record::known();
    let threads = rayon::current_num_threads();
    let mut scene = scene.clone();
    scene.numerics.forget_wishes();
    let (own, mut seconds) = (Plan::new(&scene), 0.0);
    for settings in planned {
        let variant = LoadedScene::from_scene(&settings.on(&scene), "variant")?;
        let plan = Plan::new(&variant.scene).standing_as(&own);
        plan.check(&variant)?;
        seconds += plan.forecast(&costs, threads, 0.0).wall_seconds;
    }
    // Combinations are coarser than the reference and finer than the scene.
    let all = seconds * (1.0 + 0.3 * runs as f64 / planned.len().max(1) as f64);
    let hours = all / 3600.0;
    let limit = loaded.scene.numerics.time_limit;
    if hours > limit {
        let wrong =
            format!("the runs of the study would take about {hours:.1e} h, more than numerics.time_limit = {limit} h");
        let right = "a shorter --duration, a coarser reference (--elements, --substeps), or a larger time_limit";
        return Err(SceneError::from(loaded.complain("numerics.time_limit", wrong, right)).into());
    }
    Ok(all)
}
