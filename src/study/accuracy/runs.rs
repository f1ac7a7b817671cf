//! Runs of a study, each rolled once: what they gave and what they cost. The Pareto front of points with a cost and an
//! error.

use crate::counters::Stage;
use crate::plan::{WorkPlace, WorkUnit};
use crate::run::RunError;
use crate::scene::Scene;
use crate::study::accuracy::settings::Settings;
use crate::study::trial::{Common, RunDifference, Trial, Trials};
use serde::Serialize;

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

/// Indices of the non-dominated points (cost, error), by rising cost: no other point has both a lower cost and a lower
/// error; of equal points the first. Points that are not finite are left out.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&i| points[i].0.is_finite() && points[i].1.is_finite()).collect();
    order.sort_by(|&i, &j| points[i].0.total_cmp(&points[j].0).then(points[i].1.total_cmp(&points[j].1)));
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i].1 < least;
        least = least.min(points[i].1);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1.0, 5.0), (2.0, 3.0), (3.0, 4.0), (4.0, 1.0), (4.0, 2.0), (2.0, 3.0), (0.5, f64::NAN)];
        assert_eq!(front(&points), [0, 1, 3]);
        assert_eq!(front(&[]), [0; 0]);
    }

    proptest! {
        #[test]
        fn everything_is_on_the_front_or_beaten_by_it(
            points in prop::collection::vec((0.0..9.0_f64, 0.0..9.0_f64), 1..40),
        ) {
            let on = front(&points);
            for pair in on.windows(2) {
                prop_assert!(points[pair[0]].0 < points[pair[1]].0 && points[pair[0]].1 > points[pair[1]].1);
            }
            for (index, point) in points.iter().enumerate() {
                let is_dominated = on.iter().any(|&i| i != index && points[i].0 <= point.0 && points[i].1 <= point.1);
                prop_assert!(is_dominated || on.contains(&index));
            }
        }
    }
}
