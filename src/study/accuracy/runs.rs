//! Runs of a study, each rolled once: what they gave and what they cost.

use serde::Serialize;

use crate::counters::Stage;
use crate::plan::{WorkPlace, WorkUnit};
use crate::run::RunError;
use crate::scene::Scene;
use crate::study::accuracy::settings::Settings;
use crate::study::trial::{Common, RunDifference, Trial, Trials};

/// Cost of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StudyCost {
    /// Multiply-adds in a second rolled: those counted in the march, and those planned for the road, whose cells and
    /// heights count as many as take the same time. Exact: the same for any number of threads.
    pub multiply_adds: f64,
    /// Time of the march for a second rolled \[s\].
    pub march: f64,
    /// Time of making road and slices for a second rolled \[s\]; it runs beside the march where there is another
    /// thread.
    pub road: f64,
    /// Time of the fit \[s\]; `None` where the cache had it, or nothing was fitted.
    pub fit: Option<f64>,
}

/// Settings that were rolled: how far from the reference, and at what cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyPoint {
    /// Name in tables.
    pub label: String,
    /// Settings of the run.
    pub settings: Settings,
    /// From the reference.
    pub difference: RunDifference,
    /// Cost of the run.
    pub cost: StudyCost,
}

impl StudyPoint {
    /// Work (multiply-adds in a second rolled) and error (largest difference of a level, dB), as the front takes them.
    pub fn coordinates(&self) -> (f64, f64) {
        (self.cost.multiply_adds, self.difference.worst)
    }
}

/// Rolls settings of one scene, each once, and compares them with the reference.
pub(crate) struct StudyRuns<'a, 'b> {
    /// The scene, its axle held.
    pub scene: Scene,
    /// Highest frequency compared \[Hz\].
    pub highest: f64,
    /// Settings that will be rolled, the reference first, and the forecast time of each \[s\].
    pub planned: Vec<(Settings, f64)>,
    pub trials: &'a mut Trials<'b>,
    /// Runs so far.
    pub known: Vec<(Settings, Common, StudyCost)>,
}

impl StudyRuns<'_, '_> {
    /// Settings compared with the reference, rolled unless they were before.
    pub(crate) fn point(&mut self, label: &str, settings: &Settings) -> Result<StudyPoint, RunError> {
        let mut place = self.known.iter().position(|(known, ..)| known == settings);
        if place.is_none() {
            let expected = self.planned.iter().find(|(planned, _)| planned == settings);
            self.trials.announce(label, expected.map_or(0.0, |(_, seconds)| *seconds));
            let trial = self.trials.roll(&settings.on(&self.scene))?;
            let rolling = &self.scene.rolling;
            let within = rolling.warm_up..rolling.warm_up + rolling.duration;
            let cost = cost(&trial, within.end);
            place = Some(self.known.len());
            self.known.push((settings.clone(), Common::of(&trial, within, self.highest), cost));
        }
        let (_, common, cost) = &self.known[place.unwrap_or_default()];
        let difference = common.difference(&self.known[0].1);
        Ok(StudyPoint { label: label.to_owned(), settings: settings.clone(), difference, cost: *cost })
    }
}

fn cost(trial: &Trial, rolled: f64) -> StudyCost {
    let meter = &trial.results.meter;
    let march = [Stage::History, Stage::Transforms, Stage::Penetration, Stage::ActiveSet];
    let counted: u64 = march.iter().map(|&stage| meter.whole(stage).work.multiply_adds).sum();
    let amounts = trial.plan.amounts();
    let is_road = |stage: Stage| matches!(stage, Stage::Road | Stage::Slices);
    let road = amounts.work.iter().filter(|amount| amount.place == WorkPlace::Background && is_road(amount.stage));
    let road = road.map(|amount| amount.amount * amount.unit.typical() / WorkUnit::TextureMultiplyAdd.typical());
    let seconds = |stages: &[Stage]| -> f64 { stages.iter().map(|&stage| meter.whole(stage).seconds()).sum() };
    StudyCost {
        multiply_adds: (counted as f64 + road.sum::<f64>()) / rolled,
        march: seconds(&march) / rolled,
        road: seconds(&[Stage::Road, Stage::Slices]) / rolled,
        fit: (seconds(&[Stage::Fit]) > 0.0).then(|| seconds(&[Stage::Influence, Stage::Fit])),
    }
}
