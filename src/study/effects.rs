//! Contribution of each effect: the scene with one effect after the other switched, beside two bases.
//!
//! 1. the base without any effect that can be taken away, and the scene with all of them;
//! 2. each effect alone added to the base, and alone taken away from all;
//! 3. what that changes: third-octave levels, mean force, length of the patch, rolling resistance, time of the
//!    steps, planned memory; where there are receivers the levels there.
//!
//! Before the first run the time of all of them is forecast. Fits and boundary elements that several runs need are made
//! once, and counted once.
//!
//! An effect that the scene cannot have (texture on a smooth road, ...) is listed with the reason, and so is one that
//! it cannot be without (rotation at 250 km/h).

use std::collections::HashSet;

use crate::contact::ContactError;
use crate::contact::local_compliance::{UNCERTAINTY, formula_for};
use crate::counters::{Job, Stage};
use crate::plan::decisions::DecisionRow;
use crate::plan::{Forecast, Plan, UnitCosts, WorkUnit};
use crate::planning::rows;
use crate::response::BandLevel;
use crate::results::summary::RollingResistance;
use crate::results::table::{csv, optional, row};
use crate::run::RunError;
use crate::scene::{AirMotion, LoadedScene, Scene, SliceCoupling, Slices, Zone};
use crate::sound::TotalLevel;
use crate::study::trial::{Trial, Trials};

pub(crate) const LONGEST: f64 = 3.0;
/// Assumed motions of the air at the tread, and the names under which the uncertainty that they cause is listed.
const AIRS: [(AirMotion, &str); 3] = [
    (AirMotion::Road, "air over the road"),
    (AirMotion::Axle, "air with the axle"),
    (AirMotion::WithTread, "air with the tread"),
];

/// Effect that can be taken away: a row of the plan's table.
pub(crate) type Effect = &'static DecisionRow;

/// All effects that can be switched; contact over cells, which is compared with slices as a whole, is the last.
pub(crate) fn effects() -> Vec<Effect> {
    let (cells, others): (Vec<_>, Vec<_>) = rows().filter(|row| row.switch.is_some()).partition(|row| is_cells(row));
    others.into_iter().chain(cells).collect()
}

fn same(one: Effect, other: Effect) -> bool {
    one.title == other.title
}

fn is_cells(effect: Effect) -> bool {
    effect.short == "cells"
}

fn set(effect: Effect, scene: &mut Scene, on: bool) {
    if let Some(switch) = effect.switch {
        switch(scene, on);
    }
}

/// Plan of the same scene over cells instead of slices, rolled for `duration` \[s\]; `None` if the scene has cells
/// already, or cannot have them.
pub(crate) fn over_cells(loaded: &LoadedScene, duration: f64) -> Option<Plan> {
    let mut scene = loaded.scene.clone();
    let cells = effects().into_iter().find(|effect| is_cells(effect) && scene.contact.zone == Zone::Slices)?;
    set(cells, &mut scene, true);
    scene.contact.slices = Slices::default();
    (scene.contact.cells_along, scene.contact.local_compliance) = (None, None);
    scene.rolling.duration = duration;
    let loaded = LoadedScene::from_scene(&scene, "cells").ok()?;
    Plan::of(&loaded).ok().map(Plan::with_cached_model)
}

/// Why an effect is not compared in a scene of slices, or of cells; `None` if it is.
fn beside_cells(scene: &Scene, effect: Effect) -> Option<String> {
    let reason = match scene.contact.zone {
        Zone::Cells if !effect.of_cells => "cells are compared with slices alone",
        Zone::Slices if is_cells(effect) => "contact.zone = \"slices\"",
        Zone::Cells | Zone::Slices => return None,
    };
    Some(reason.to_owned())
}

/// Contribution of one effect.
#[derive(Clone)]
pub(crate) struct Contribution {
    /// The switched row of the plan's table.
    pub effect: Effect,
    /// Runs with it alone, and with all but it; or why the scene cannot have it, or cannot be without it.
    pub found: Result<[Trial; 2], String>,
}

/// Contributions of all effects of a scene.
#[derive(Clone)]
pub(crate) struct EffectComparison {
    /// Without any effect that can be taken away; an effect without which the motion grows without bound stays.
    pub base: Trial,
    /// With all that the scene can have.
    pub all: Trial,
    /// Each effect with its two runs.
    pub effects: Vec<Contribution>,
    /// All effects, with half and twice the compliance of the local law, and with each other motion of the air where
    /// there are receivers: the uncertainty of the model itself.
    pub uncertainties: Vec<(String, Trial)>,
}

/// Forecasts of runs that follow one another.
struct Forecasts<'a> {
    costs: &'a UnitCosts,
    threads: usize,
    /// Set-ups that an earlier run has made: stage, and bits of their time.
    made: HashSet<(Stage, u64)>,
}

impl Forecasts<'_> {
    /// Wall time of the next run \[s\]; 0 for a scene that is refused.
    fn next(&mut self, scene: &Scene) -> f64 {
        let planned = LoadedScene::from_scene(scene, "variant").and_then(|loaded| Plan::of(&loaded));
        let Ok(plan) = planned.map(Plan::with_cached_model) else { return 0.0 };
        let mut amounts = plan.amounts();
        amounts.work.retain(|work| {
            let seconds = work.amount * self.costs.of(work.stage, work.unit);
            let is_cached = work.unit == WorkUnit::Fit || work.stage == Stage::Radiation;
            !is_cached || self.made.insert((work.stage, seconds.to_bits()))
        });
        Forecast::new(&amounts, plan.steps, self.costs, self.threads, 0.0).wall_seconds
    }
}

/// Rolls a scene with its effects switched one by one. `duration` \[s\] replaces the scene's; the time is forecast from
/// the costs of this machine and the present number of threads.
///
/// # Errors
/// Errors of any of the runs; [`RunError::Interrupted`].
pub(crate) fn compare(
    loaded: &LoadedScene,
    duration: f64,
    costs: &UnitCosts,
    job: Job<'_>,
) -> Result<EffectComparison, RunError> {
    let mut scene = loaded.scene.clone();
    scene.rolling.duration = duration;
    let possible: Vec<(Effect, Option<String>)> = effects()
        .into_iter()
        .map(|effect| {
            let refusal = beside_cells(&scene, effect).or_else(|| {
                let mut with = scene.clone();
                set(effect, &mut with, true);
                LoadedScene::from_scene(&with, "effects").err().map(|error| error.problem())
            });
            (effect, refusal)
        })
        .collect();
    // A refused effect stays as the scene has it.
    let with = |chosen: &dyn Fn(Effect) -> bool| {
        let mut scene = scene.clone();
        for (effect, _) in possible.iter().filter(|(_, refusal)| refusal.is_none()) {
            set(effect, &mut scene, chosen(effect));
        }
        scene
    };
    let complete = with(&|_| true);
    let kappa = match complete.contact.slice_coupling {
        _ if complete.contact.zone == Zone::Cells || complete.contact.slices == Slices::Pressed => None,
        SliceCoupling::Local => complete.contact.local_compliance.or_else(|| formula_for(&complete)),
        SliceCoupling::Explicit => None,
    };
    let airs = AIRS.into_iter().filter(|(air, _)| !complete.receivers.is_empty() && *air != complete.radiation.air);
    let varied: Vec<(String, Scene)> = {
        let factors = UNCERTAINTY.into_iter().filter_map(|(name, factor)| Some((name, factor * kappa?)));
        let compliances = factors.map(|(name, kappa)| {
            let mut scene = complete.clone();
            scene.contact.local_compliance = Some(kappa);
            (format!("{name} the local compliance"), scene)
        });
        let motions = airs.map(|(air, name)| {
            let mut scene = complete.clone();
            scene.radiation.air = air;
            (name.to_owned(), scene)
        });
        compliances.chain(motions).collect()
    };
    let possible_only = || possible.iter().filter(|(_, refusal)| refusal.is_none()).map(|(effect, _)| *effect);
    // In the order in which they are rolled; which effects must stay in every run is not known yet.
    let mut planned = vec![("all".to_owned(), complete.clone())];
    let named = |direction: ComparisonDirection, effect: Effect| format!("{} {}", direction.sign(), effect.title);
    planned.extend(
        possible_only()
            .map(|effect| (named(ComparisonDirection::TakenAway, effect), with(&|other| !same(other, effect)))),
    );
    planned.push(("none".to_owned(), with(&|_| false)));
    planned.extend(
        possible_only().map(|effect| (named(ComparisonDirection::Added, effect), with(&|other| same(other, effect)))),
    );
    planned.extend(varied.iter().cloned());
    let threads = rayon::current_num_threads();
    let mut forecasts = Forecasts { costs, threads, made: HashSet::new() };
    let expected: Vec<(String, f64)> =
        planned.into_iter().map(|(name, scene)| (name, forecasts.next(&scene))).collect();
    let seconds: f64 = expected.iter().map(|(_, seconds)| seconds).sum();
    job.progress.note(&format!("{} runs, about {seconds:.0} s on {threads} threads as planned", expected.len()));
    let mut trials = Trials::shared(seconds, job).with_sound();
    let mut roll = |name: &str, scene: &Scene| {
        let seconds = expected.iter().find(|(known, _)| known == name).map_or(0.0, |(_, seconds)| *seconds);
        trials.announce(name, seconds);
        trials.roll(scene)
    };
    let all = roll("all", &complete)?;
    // The runs without one effect come first: an effect without which the motion is unstable becomes part of the base.
    let without: Vec<Result<Trial, String>> = possible
        .iter()
        .map(|(effect, refusal)| match refusal {
            Some(refusal) => Ok(Err(format!("not in this scene: {refusal}"))),
            None => match roll(&named(ComparisonDirection::TakenAway, *effect), &with(&|other| !same(other, effect))) {
                Err(RunError::Contact(error @ ContactError::Unbounded { .. })) => {
                    Ok(Err(format!("stays in every run; without it {error}")))
                }
                rolled => rolled.map(Ok),
            },
        })
        .collect::<Result<_, RunError>>()?;
    let must_stay =
        |other| possible.iter().zip(&without).any(|((effect, _), found)| same(effect, other) && found.is_err());
    let base = roll("none", &with(&|other| must_stay(other)))?;
    let mut effects = Vec::new();
    for ((effect, _), found) in possible.iter().zip(&without) {
        let found = match found {
            Err(reason) => Err(reason.clone()),
            Ok(without) => {
                let name = named(ComparisonDirection::Added, *effect);
                let alone = roll(&name, &with(&|other| same(other, effect) || must_stay(other)))?;
                Ok([alone, without.clone()])
            }
        };
        effects.push(Contribution { effect, found });
    }
    let rolled = varied.into_iter().map(|(name, scene)| Ok((name.clone(), roll(&name, &scene)?)));
    let uncertainties = rolled.collect::<Result<_, RunError>>()?;
    trials.finish();
    Ok(EffectComparison { base, all, effects, uncertainties })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ComparisonDirection {
    /// Alone, compared with none.
    Added,
    /// All but this, compared with all.
    TakenAway,
}

impl ComparisonDirection {
    /// Both, in the order of the tables.
    pub(crate) const ALL: [Self; 2] = [Self::Added, Self::TakenAway];

    /// Heading of the table.
    pub(crate) const fn title(self) -> &'static str {
        match self {
            Self::Added => "each effect alone",
            Self::TakenAway => "all effects but one",
        }
    }

    /// Prefix of the runs' names.
    pub(crate) const fn sign(self) -> char {
        match self {
            Self::Added => '+',
            Self::TakenAway => '-',
        }
    }
}

impl EffectComparison {
    /// The effects that the scene can have, each with its run and the run that it is compared with.
    pub(crate) fn runs(&self, direction: ComparisonDirection) -> Vec<(Effect, &Trial, &Trial)> {
        let Self { base, all, effects, .. } = self;
        let run = |contribution| match contribution {
            &Contribution { effect, found: Ok([ref alone, ref without]) } => Some(match direction {
                ComparisonDirection::Added => (effect, alone, base),
                ComparisonDirection::TakenAway => (effect, without, all),
            }),
            Contribution { found: Err(_), .. } => None,
        };
        effects.iter().filter_map(run).collect()
    }

    /// Every run with its name and the run that it is compared with, in the order of the tables.
    pub(crate) fn rolled(&self) -> Vec<(String, &Trial, Option<&Trial>)> {
        let Self { base, all, uncertainties, .. } = self;
        let mut rolled = vec![("none".to_owned(), base, None), ("all".to_owned(), all, Some(base))];
        for direction in ComparisonDirection::ALL {
            let name = |effect: Effect| format!("{} {}", direction.sign(), effect.title);
            let runs = self.runs(direction).into_iter();
            rolled.extend(runs.map(|(effect, found, reference)| (name(effect), found, Some(reference))));
        }
        rolled.extend(uncertainties.iter().map(|(name, found)| (name.clone(), found, Some(all))));
        rolled
    }

    /// Every run as a row of numbers.
    pub(crate) fn csv(&self) -> String {
        let level = |band: &BandLevel| format!("level_db_re_1n_{}hz", band.band.nominal_frequency());
        let header = ["effects", "mean_force_n", "contact_length_m", "steps_s", "memory_bytes", "valid_to_hz"];
        let receivers: Vec<String> = self.all.receiver_levels().into_iter().map(|(rated, _)| rated.name).collect();
        let sounds = receivers.iter().flat_map(|name| {
            ["level_db_a", "level_error_db", "highest_hz", "lower_bound"].map(|column| format!("{column}_{name}"))
        });
        let header = header.into_iter().chain(RollingResistance::COLUMNS).map(str::to_owned);
        let header = header.chain(self.base.levels.iter().map(level)).chain(sounds);
        let rows = self.rolled().into_iter().map(|(name, found, _)| {
            let valid = found.levels.iter().rfind(|band| band.valid);
            let valid = valid.map_or(0.0, |band| band.band.nominal_frequency());
            let [force, length, memory] = [found.mean_force(), found.contact_length(), found.memory()];
            let mut cells = row([&name, &force, &length, &found.seconds, &memory, &valid]);
            cells.extend(RollingResistance::cells(found.resistance()));
            cells.extend(found.levels.iter().map(|band| band.level.to_string()));
            let receiver_levels = found.receiver_levels();
            // Empty in a run without sound.
            cells.extend(receivers.iter().flat_map(|receiver| {
                let rated = receiver_levels.iter().map(|(rated, _)| rated).find(|rated| rated.name == *receiver);
                let level = rated.and_then(|rated| rated.level.as_ref());
                let bands = level.and_then(TotalLevel::covered);
                [
                    optional(level.map(|level| level.level)),
                    optional(level.and_then(|level| level.error)),
                    optional(bands.map(|bands| bands.highest)),
                    optional(bands.map(|bands| u8::from(bands.lower_bound))),
                ]
            }));
            cells
        });
        csv(header, rows)
    }
}
