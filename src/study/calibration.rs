//! Calibration of the costs of work on this machine: measured once by short runs of the program itself, stored beside
//! the fitted models.
//!
//! 1. a fit of a small model;
//! 2. some hundred steps on a smooth and on a rough road, on one thread: each stage's time over what a plan of typical
//!    costs expects of it;
//! 3. what these runs do not touch is taken to differ from its typical cost as all that they measure does.
//!
//! The record belongs to one build of the program on one kind of processor; any other is measured anew.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::counters::process::cpu_time;
use crate::counters::{Stage, Watch};
use crate::plan::unit::{keep, known};
use crate::plan::{Forecast, Plan, UnitCosts, WorkUnit};
use crate::run::{RunError, Simulation};
use crate::scene::{LoadedScene, PLATE, Road, Scene};
use crate::tyre::poles::{FitOptions, expected_fit, fit_unless_stopped};

/// Tolerance of the models that are rolled with.
const TOLERANCE: f64 = 1e-3;
/// Elements, and the numbers of steps of warm-up and of those that are timed.
const PROBE: (usize, u64, u64) = (512, 400, 1500);
/// Stages that the probes measure; the others do too little in them, or their work depends on what is cached.
const MEASURED: [Stage; 7] =
    [Stage::Road, Stage::Slices, Stage::Axle, Stage::History, Stage::Transforms, Stage::Penetration, Stage::ActiveSet];

/// The costs measured before, or measured and stored now; a record that cannot be stored is no error.
///
/// # Errors
/// [`RunError::Interrupted`] once `stop` is set; any other is a defect of the probes.
pub(crate) fn calibrated(stop: &AtomicBool) -> Result<UnitCosts, RunError> {
    let known = known();
    if known.measured { Ok(known) } else { calibrate(stop) }
}

/// Measures costs as [`calibrated`], whatever was measured before.
///
/// # Errors
/// As [`calibrated`].
pub(crate) fn calibrate(stop: &AtomicBool) -> Result<UnitCosts, RunError> {
    let interrupted = || RunError::Interrupted { partial: None };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|_| interrupted())?;
    let costs = pool.install(|| measure(stop))?;
    keep(costs);
    Ok(costs)
}

fn measure(stop: &AtomicBool) -> Result<UnitCosts, RunError> {
    let base = Scene::from_str(PLATE, "calibration")?;
    let (elements, ..) = PROBE;
    let tyre = &base.scene.tyre;
    let options = FitOptions::new(tyre, elements, base.scene.rolling.speed()).with_tolerance(TOLERANCE);
    let begin = Begin::now();
    fit_unless_stopped(tyre, &options, stop).map_err(|_| RunError::Interrupted { partial: None })?;
    let fit = expected_fit::share(elements as f64, TOLERANCE, tyre) * WorkUnit::Fit.typical();

    let mut probes = Probes { fit: begin.ran() * begin.wall.elapsed().as_secs_f64() / fit, ..Probes::default() };
    probes.roll(base.clone(), stop)?;
    let mut smooth = base;
    smooth.scene.road = Road::Smooth;
    probes.roll(smooth, stop)?;
    Ok(probes.costs())
}

/// Begin of a measurement on one thread.
struct Begin {
    wall: Instant,
    cpu: Option<Duration>,
}

impl Begin {
    fn now() -> Self {
        Self { wall: Instant::now(), cpu: cpu_time() }
    }

    /// Part of the time since then for which the thread ran, at most 1: other programs must not make work expensive. 1
    /// where processor times are not known.
    fn ran(&self) -> f64 {
        let cpu = self.cpu.zip(cpu_time()).map(|(then, now)| now.saturating_sub(then));
        cpu.map_or(1.0, |cpu| (cpu.as_secs_f64() / self.wall.elapsed().as_secs_f64()).min(1.0))
    }
}

/// Sums over the short runs, times in s that the thread ran.
#[derive(Default)]
struct Probes {
    /// Time of the fit over the expected time.
    fit: f64,
    /// Expected and measured time by stage.
    stages: [[f64; 2]; Stage::ALL.len()],
    /// Number of steps, and their time outside all stages.
    steps: f64,
    rest: f64,
}

impl Probes {
    fn roll(&mut self, mut loaded: LoadedScene, stop: &AtomicBool) -> Result<(), RunError> {
        let scene = &mut loaded.scene;
        let (elements, before, watched) = PROBE;
        (scene.numerics.elements, scene.numerics.pole_tolerance) = (elements, TOLERANCE);
        let step = scene.tyre.circumference / (elements as f64 * scene.rolling.speed());
        (scene.rolling.warm_up, scene.rolling.duration) = (before as f64 * step, watched as f64 * step);
        let plan = Plan::new(scene);
        let all = Begin::now();
        let mut run = Simulation::begin_watched(&loaded, &plan, stop, Watch::EVERY)?;
        let begin = Instant::now();
        while run.step()?.is_some() {
            if stop.load(Ordering::Relaxed) {
                return Err(RunError::Interrupted { partial: None });
            }
        }
        let (rolled, ran) = (begin.elapsed(), all.ran());
        let in_stages = run.spent().iter().sum();
        let meter = run.finish().meter;
        self.steps += plan.steps as f64;
        self.rest += ran * rolled.saturating_sub(in_stages).as_secs_f64();
        let Forecast { stages, .. } = plan.forecast(&UnitCosts::default(), 1, 0.0);
        for expected in stages {
            let [planned, taken] = &mut self.stages[expected.stage as usize];
            *planned += expected.seconds;
            // In a plan a stage includes its parts.
            *taken += ran * meter.whole(expected.stage).spent.wall.as_secs_f64();
        }
        Ok(())
    }

    fn costs(&self) -> UnitCosts {
        let measured = MEASURED.map(|stage| self.stages[stage as usize]);
        let [planned, taken] = measured.into_iter().fold([0.0; 2], |[a, b], [planned, taken]| [a + planned, b + taken]);
        let mut stages = [taken / planned; Stage::ALL.len()];
        for (stage, [planned, taken]) in MEASURED.into_iter().zip(measured) {
            stages[stage as usize] = taken / planned;
        }
        // Compliances and poles are the same arithmetic as that of a fit.
        (stages[Stage::Fit as usize], stages[Stage::Influence as usize]) = (self.fit, self.fit);
        UnitCosts { stages, step: self.rest / self.steps, measured: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_waits_costs_nothing() {
        let later = |cpu: Duration| cpu + Duration::from_secs(3600);
        let waited = Begin { wall: Instant::now(), cpu: cpu_time().map(later) };
        let unknown = Begin { wall: Instant::now(), cpu: None };
        assert!((unknown.ran() - 1.0).abs() < 1e-12 && (0.0..=1.0).contains(&Begin::now().ran()));
        assert!(waited.cpu.is_none() || waited.ran().abs() < 1e-12);
    }

    #[test]
    fn what_is_measured_scales_its_stage_and_all_of_it_the_others() {
        let mut probes = Probes { fit: 3.0, steps: 100.0, rest: 2e-4, ..Probes::default() };
        for stage in MEASURED {
            probes.stages[stage as usize] = [1.0, if stage == Stage::History { 9.0 } else { 2.0 }];
        }
        let costs = probes.costs();
        assert!(costs.measured && (costs.step - 2e-6).abs() < 1e-15);
        let of = |stage, unit: WorkUnit| costs.of(stage, unit) / unit.typical();
        for (stage, unit, factor) in [
            (Stage::Fit, WorkUnit::Fit, 3.0),
            (Stage::History, WorkUnit::PoleMultiplyAdd, 9.0),
            (Stage::Slices, WorkUnit::SpringCell, 2.0),
            (Stage::Output, WorkUnit::OutputByte, 3.0),
        ] {
            assert!((of(stage, unit) - factor).abs() < 1e-12, "{stage:?}");
        }
        assert!(matches!(measure(&AtomicBool::new(true)), Err(RunError::Interrupted { partial: None })));
        let text = serde_json::to_string(&costs).unwrap();
        assert_eq!(serde_json::from_str::<UnitCosts>(&text).unwrap(), costs);
    }
}
