//! Runs of a study, each rolled once: what they gave and what they cost.

use std::ops::Range;
use std::time::Instant;

use serde::Serialize;

use crate::counters::{Counter, Stage};
use crate::plan::models::fetch;
use crate::plan::{Amounts, Place, Plan, Unit};
use crate::run::RunError;
use crate::scene::{History, Scene};
use crate::study::accuracy::settings::Settings;
use crate::study::trial::{Common, Difference, Trial, Trials};

/// Cost of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Multiply-adds in a second rolled: those counted in the march, and those planned for the road, whose cells and
    /// heights count as many as take the same time. Exact: the same for any number of threads.
    pub multiply_adds: f64,
    /// Evaluations of the layered compliance for the model or the weights of the direct history.
    pub compliance_evaluations: u64,
    /// Time of the march for a second rolled \[s\].
    pub march: f64,
    /// Time of making road and slices for a second rolled \[s\]; it runs beside the march where there is another
    /// thread.
    pub road: f64,
    /// Time of the fit \[s\]; `None` where the cache had it.
    pub fit: Option<f64>,
}

/// Settings that were rolled: how far from others, and at what cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Label of the run.
    pub label: String,
    /// Scene that was rolled.
    pub settings: Settings,
    /// Difference from the run that it is compared with.
    pub difference: Difference,
    /// Work and time taken.
    pub cost: Cost,
}

impl Point {
    /// Work (multiply-adds in a second rolled) and error (largest difference of a level, dB), as the front takes them.
    pub fn coordinates(&self) -> (f64, f64) {
        (self.cost.multiply_adds, self.difference.worst)
    }
}

struct Measured {
    settings: Settings,
    common: Common,
    cost: Cost,
}

/// Forecast time of the runs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Expected {
    /// Settings that will be rolled, and the time of each \[s\].
    pub planned: Vec<(Settings, f64)>,
}

impl Expected {
    /// Assumed time of a combination over the mean of the planned runs: coarser than the reference, finer than the
    /// scene.
    const OF_COMBINATION: f64 = 0.3;

    /// Time of a run \[s\]: of a planned one as forecast, otherwise of a combination.
    fn of(&self, settings: &Settings) -> f64 {
        let planned = self.planned.iter().find(|(planned, _)| planned == settings);
        planned.map_or_else(|| Self::OF_COMBINATION * self.mean(), |(_, seconds)| *seconds)
    }

    /// Time of all planned runs and of `combinations` more \[s\].
    pub(crate) fn seconds(&self, combinations: usize) -> f64 {
        (self.planned.len() as f64 + Self::OF_COMBINATION * combinations as f64) * self.mean()
    }

    fn mean(&self) -> f64 {
        self.planned.iter().map(|(_, seconds)| seconds).sum::<f64>() / self.planned.len().max(1) as f64
    }
}

/// Rolls settings of one scene, each once.
pub(crate) struct Lab<'a, 'b> {
    /// The scene, its axle held.
    pub scene: Scene,
    /// Highest frequency compared \[Hz\].
    pub highest: f64,
    expected: Expected,
    trials: &'a mut Trials<'b>,
    known: Vec<Measured>,
}

impl<'a, 'b> Lab<'a, 'b> {
    pub(crate) fn new(scene: Scene, highest: f64, expected: Expected, trials: &'a mut Trials<'b>) -> Self {
        Self { scene, highest, expected, trials, known: Vec::new() }
    }

    pub(crate) fn rolled(&self) -> usize {
        self.known.len()
    }

    /// Settings compared with others; each of the two is rolled unless it was before.
    pub(crate) fn point(&mut self, label: &str, settings: &Settings, other: &Settings) -> Result<Point, RunError> {
        self.named(label, label, settings, other)
    }

    /// As [`Self::point`], with another name for the run in progress messages.
    pub(crate) fn named(
        &mut self,
        label: &str,
        name: &str,
        settings: &Settings,
        other: &Settings,
    ) -> Result<Point, RunError> {
        let (this, other) = (self.measure(name, settings)?, self.measure(name, other)?);
        let Measured { common, cost, .. } = &self.known[this];
        let difference = common.difference(&self.known[other].common);
        Ok(Point { label: label.to_owned(), settings: settings.clone(), difference, cost: *cost })
    }

    /// Index of the known run with these settings; it is rolled unless it was before.
    fn measure(&mut self, name: &str, settings: &Settings) -> Result<usize, RunError> {
        if let Some(known) = self.known.iter().position(|known| known.settings == *settings) {
            return Ok(known);
        }
        let scene = settings.on(&self.scene);
        self.trials.announce(name, self.expected.of(settings));
        let (evaluations, fit) = self.fit(&Plan::new(&scene));
        let trial = self.trials.roll(&scene)?;
        let within = self.within();
        let cost = cost(&trial, within.end, evaluations, fit);
        let common = Common::of(&trial, within, self.highest);
        self.known.push(Measured { settings: settings.clone(), common, cost });
        Ok(self.known.len() - 1)
    }

    fn within(&self) -> Range<f64> {
        self.scene.rolling.warm_up..self.scene.rolling.warm_up + self.scene.rolling.duration
    }

    /// Fits the model that a run will need, so that its time is known separately: evaluations, and the time \[s\]
    /// unless the cache had it.
    fn fit(&self, plan: &Plan) -> (Option<u64>, Option<f64>) {
        if plan.scene.numerics.history == History::Direct {
            return (None, None);
        }
        let begin = Instant::now();
        // The run reports a refusal itself, with its place in the scene.
        let Ok(fetched) = fetch(&plan.decisions.tyre, &plan.fit, self.trials.stop()) else {
            return (None, None);
        };
        (Some(fetched.model.evaluations()), (!fetched.warm).then(|| begin.elapsed().as_secs_f64()))
    }
}

fn cost(trial: &Trial, rolled: f64, evaluations: Option<u64>, fit: Option<f64>) -> Cost {
    let meter = &trial.results.meter;
    let march = [Stage::History, Stage::Transforms, Stage::Penetration, Stage::ActiveSet];
    let counted: u64 = march.iter().map(|&stage| meter.whole(stage).work.multiply_adds).sum();
    let seconds = |stages: &[Stage]| -> f64 { stages.iter().map(|&stage| meter.whole(stage).seconds()).sum() };
    Cost {
        multiply_adds: (counted as f64 + planned_road(&trial.plan.amounts())) / rolled,
        compliance_evaluations: evaluations.unwrap_or_else(|| meter.counted(Counter::ComplianceEvaluations)),
        march: seconds(&march) / rolled,
        road: seconds(&[Stage::Road, Stage::Slices]) / rolled,
        fit,
    }
}

/// Planned multiply-adds for making the road.
pub(crate) fn planned_road(amounts: &Amounts) -> f64 {
    let road = |stage: Stage| matches!(stage, Stage::Road | Stage::Slices);
    let behind = amounts.work.iter().filter(|amount| amount.place == Place::Behind && road(amount.stage));
    behind.map(|amount| amount.amount * amount.unit.typical() / Unit::TextureMultiplyAdd.typical()).sum()
}

/// Planned multiply-adds of the march, and of the history behind it.
pub(crate) fn planned_march(amounts: &Amounts) -> f64 {
    let counts = |unit: Unit| {
        matches!(
            unit,
            Unit::DirectMultiplyAdd | Unit::PoleMultiplyAdd | Unit::TransformMultiplyAdd | Unit::SearchMultiplyAdd
        )
    };
    amounts.work.iter().filter(|amount| counts(amount.unit)).map(|amount| amount.amount).sum()
}
