//! What units of work cost on this machine: measured once by short runs of the program itself, kept beside the fitted
//! models.
//!
//! 1. a fit of a small model;
//! 2. some hundred steps on a smooth and on a rough road, coarse and fine, on one thread: each stage's time over its
//!    work; cost for a point in contact and for a multiply-add of the search are told apart by the two resolutions;
//! 3. what these runs do not touch is taken to differ from its typical cost as its next of kin does.
//!
//! The record belongs to one build of the program on one kind of processor; any other is measured anew.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::counters::{Meter, Stage, Watch};
use crate::plan::Plan;
use crate::plan::amounts::{Amount, fit_share};
use crate::plan::unit::{Unit, UnitCosts};
use crate::plan::unit_record::{keep, known};
use crate::run::error::RunError;
use crate::run::in_memory::Run;
use crate::scene::{DEFAULT, LoadedScene, Road, Scene};
use crate::tyre::rational::{FitOptions, fit_unless_stopped};

/// Tolerance of the models that are rolled with.
const TOLERANCE: f64 = 1e-3;
/// Resolutions, each with the steps before and while it is watched.
const PROBES: [(usize, u64, u64); 2] = [(256, 300, 1500), (1024, 500, 1500)];
/// Units that are not measured, and those whose ratio to the typical cost they share.
const KIN: [(Unit, Unit); 13] = [
    (Unit::Pole, Unit::Fit),
    (Unit::Evaluation, Unit::Fit),
    (Unit::ResampledHeight, Unit::TextureMultiplyAdd),
    (Unit::HalfSpacePair, Unit::SpringCell),
    (Unit::DirectMultiplyAdd, Unit::Bdf2MultiplyAdd),
    (Unit::Bdf1MultiplyAdd, Unit::Bdf2MultiplyAdd),
    (Unit::TrapezoidalMultiplyAdd, Unit::Bdf2MultiplyAdd),
    (Unit::Sdirk2MultiplyAdd, Unit::Bdf2MultiplyAdd),
    (Unit::Sdirk3MultiplyAdd, Unit::Bdf2MultiplyAdd),
    (Unit::HoldMultiplyAdd, Unit::Bdf2MultiplyAdd),
    (Unit::VibrationMultiplyAdd, Unit::TransformMultiplyAdd),
    (Unit::VibrationPole, Unit::Bdf2MultiplyAdd),
    (Unit::TangentialPole, Unit::Fit),
];

/// Costs measured before, or now and kept; a record that cannot be kept is no error.
///
/// # Errors
/// [`RunError::Interrupted`] once `stop` is set; any other is a defect of the probes.
pub fn calibrated(stop: &AtomicBool) -> Result<UnitCosts, RunError> {
    let known = known();
    if known.measured { Ok(known) } else { calibrate(stop) }
}

/// As [`calibrated`], whatever was measured before.
///
/// # Errors
/// As [`calibrated`].
pub fn calibrate(stop: &AtomicBool) -> Result<UnitCosts, RunError> {
    let costs = measure(stop)?;
    keep(costs.clone());
    Ok(costs)
}

fn measure(stop: &AtomicBool) -> Result<UnitCosts, RunError> {
    let mut costs = UnitCosts::default();
    let typical = UnitCosts::default();
    let pool =
        rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|_| RunError::Interrupted { kept: None })?;
    pool.install(|| {
        let base = Scene::from_str(DEFAULT, "calibration")?;
        let (elements, ..) = PROBES[0];
        let options = FitOptions::new(&base.scene.tyre, elements, base.scene.rolling.speed()).with_tolerance(TOLERANCE);
        let begin = Instant::now();
        fit_unless_stopped(&base.scene.tyre, &options, stop).map_err(|_| RunError::Interrupted { kept: None })?;
        costs.set(Unit::Fit, begin.elapsed().as_secs_f64() / fit_share(elements as f64, TOLERANCE, 2));

        let mut probes = Vec::new();
        for (elements, before, watched) in PROBES {
            for smooth in [true, false] {
                probes.push(Probe::new(&base, elements, smooth, before, watched, stop)?);
            }
        }
        let [coarse_smooth, coarse_rough, fine_smooth, fine_rough] = &probes[..] else { return Ok(()) };
        costs.set(Unit::Bdf2MultiplyAdd, fine_smooth.of_work(Stage::History));
        costs.set(Unit::TransformMultiplyAdd, fine_smooth.of_work(Stage::Transforms));
        costs.set(Unit::LevelColumn, fine_smooth.of(Stage::Penetration, Unit::LevelColumn));
        costs.set(Unit::RoughColumn, fine_rough.of(Stage::Penetration, Unit::RoughColumn));
        costs.set(Unit::StaticPair, fine_smooth.of(Stage::Axle, Unit::StaticPair));
        costs.set(Unit::SpringCell, fine_rough.of(Stage::Slices, Unit::SpringCell));
        costs.set(Unit::TextureMultiplyAdd, coarse_rough.of(Stage::Road, Unit::TextureMultiplyAdd));
        costs.set(Unit::Step, coarse_smooth.rest / coarse_smooth.steps);
        for (unit, coarse, fine) in
            [(Unit::SmoothPoint, coarse_smooth, fine_smooth), (Unit::RoughPoint, coarse_rough, fine_rough)]
        {
            let (point, multiply_add) = coarse.search_costs(fine, unit);
            costs.set(unit, point);
            // The rough road's, where both are there: more of the time is spent there.
            costs.set(Unit::SearchMultiplyAdd, multiply_add);
        }
        Ok::<(), RunError>(())
    })?;
    for (unit, kin) in KIN {
        costs.set(unit, typical.of(unit) * costs.of(kin) / typical.of(kin));
    }
    for unit in [Unit::OutputByte, Unit::Plot] {
        costs.set(
            unit,
            typical.of(unit) * costs.of(Unit::TransformMultiplyAdd) / typical.of(Unit::TransformMultiplyAdd),
        );
    }
    costs.measured = true;
    Ok(costs)
}

/// A short run: what was planned, and what its stages have cost.
struct Probe {
    work: Vec<Amount>,
    meter: Meter,
    steps: f64,
    /// Time in no stage \[s\].
    rest: f64,
}

impl Probe {
    fn new(
        base: &LoadedScene,
        elements: usize,
        smooth: bool,
        before: u64,
        watched: u64,
        stop: &AtomicBool,
    ) -> Result<Self, RunError> {
        let mut loaded = base.clone();
        let scene = &mut loaded.scene;
        (scene.numerics.elements, scene.numerics.pole_tolerance) = (elements, TOLERANCE);
        if smooth {
            scene.road = Road::Smooth;
        }
        let step = scene.tyre.circumference / (elements as f64 * scene.rolling.speed());
        (scene.rolling.warm_up, scene.rolling.duration) = (before as f64 * step, watched as f64 * step);
        let plan = Plan::new(scene);
        let mut run = Run::begin_watched(&loaded, &plan, stop, Watch::EVERY)?;
        let begin = Instant::now();
        while run.step()?.is_some() {
            if stop.load(Ordering::Relaxed) {
                return Err(RunError::Interrupted { kept: None });
            }
        }
        let rolled = begin.elapsed();
        let steps = plan.steps as f64;
        let meter = run.finish().meter;
        let in_stages: Duration = Stage::OF_A_STEP.iter().map(|&stage| meter.cost(stage).spent.wall).sum();
        let rest = rolled.saturating_sub(in_stages).as_secs_f64();
        Ok(Self { work: plan.amounts.work, meter, steps, rest })
    }

    /// Time of a stage with its parts: a plan has them together.
    fn seconds(&self, stage: Stage) -> f64 {
        self.meter.whole(stage).spent.wall.as_secs_f64()
    }

    fn planned(&self, unit: Unit) -> f64 {
        self.work.iter().filter(|amount| amount.unit == unit).map(|amount| amount.amount).sum()
    }

    /// Time of a stage over its multiply-adds as counted.
    fn of_work(&self, stage: Stage) -> f64 {
        self.seconds(stage) / self.meter.cost(stage).work.multiply_adds as f64
    }

    /// Time of a stage over its planned units.
    fn of(&self, stage: Stage, unit: Unit) -> f64 {
        self.seconds(stage) / self.planned(unit)
    }

    /// Time = points x a + multiply-adds x b, from this and a finer probe: a and b.
    fn search_costs(&self, fine: &Self, point: Unit) -> (f64, f64) {
        let of = |probe: &Self| {
            (probe.planned(point), probe.planned(Unit::SearchMultiplyAdd), probe.seconds(Stage::ActiveSet))
        };
        let ((p, m, t), (p_fine, m_fine, t_fine)) = (of(self), of(fine));
        let determinant = p * m_fine - p_fine * m;
        ((t * m_fine - t_fine * m) / determinant, (p * t_fine - p_fine * t) / determinant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cost_is_measured_or_has_a_kin_that_is() {
        let measured = [
            Unit::Fit,
            Unit::StaticPair,
            Unit::TextureMultiplyAdd,
            Unit::SpringCell,
            Unit::Bdf2MultiplyAdd,
            Unit::TransformMultiplyAdd,
            Unit::LevelColumn,
            Unit::RoughColumn,
            Unit::SmoothPoint,
            Unit::RoughPoint,
            Unit::SearchMultiplyAdd,
            Unit::Step,
        ];
        assert!(KIN.iter().all(|(unit, kin)| !measured.contains(unit) && measured.contains(kin)));
        assert!(calibrate_stopped_at_once());
    }

    fn calibrate_stopped_at_once() -> bool {
        matches!(measure(&AtomicBool::new(true)), Err(RunError::Interrupted { kept: None }))
    }
}
