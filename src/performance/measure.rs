//! Execution of one workload in this process.
//!
//! Times are taken in short blocks, the same ones in every run: a block that the machine disturbed stands out against
//! the same block of other runs, and the stage around it is not lost with it. See `super::verdict`.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::workload::{MeasuredValue, Workload};
use crate::counters::clock::Clock;
use crate::counters::peak::instruction_set;
use crate::counters::process::thread_cpu_time;
use crate::counters::{Counter, Meter, Spent, Stage, Watch};
use crate::plan::Plan;
use crate::plan::models::refused;
use crate::run::{Results, RunError, Simulation};
use crate::scene::{History, LoadedScene, PLATE, Scene, SceneError};
use crate::tyre::influence::{Field, InfluenceSum, Projection, Truncation};
use crate::tyre::poles::{FitOptions, fit_unless_stopped};

/// Steps of a block: about a millisecond, and a multiple of the steps that the recursion takes at once.
const STEPS_OF_A_BLOCK: u64 = 32;
/// Processor time from which a block is interrupted many times, each stage in proportion to its length.
const LONG: Duration = Duration::from_millis(5);
/// Largest share of a short block that other processes may take.
const LITTLE: f64 = 0.02;

/// Values of the counters by name.
pub(super) type Counts = BTreeMap<String, u64>;
/// Times of blocks \[ns\] by the names of their stages.
type Blocks = BTreeMap<String, Vec<Option<u64>>>;

/// Cost and result of a workload. Maps are keyed by the names of stages and counters, so that programs of different
/// releases understand each other.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Measurement {
    /// Name of the workload.
    pub workload: String,
    /// Instruction set of its vectors.
    #[serde(default)]
    pub instruction_set: String,
    /// Exact counters that are not zero: of the run, and of its stages as `stage.multiply_adds`, `stage.bytes`,
    /// `stage.calls`.
    pub counters: Counts,
    /// Physical value that was computed.
    pub found: MeasuredValue,
    /// Time of every block by stage \[ns\]; `None` if other processes had the processor and the stage that lost the
    /// time is unknown.
    #[serde(default)]
    pub blocks: Blocks,
}

/// Executes a workload on this thread: times are this thread's, so the pool should have no other.
///
/// # Errors
/// Errors of the run or the fit; [`RunError::Interrupted`].
pub fn measure(workload: Workload, stop: &AtomicBool) -> Result<Measurement, RunError> {
    let (value, counters, blocks) = match workload.scene()? {
        Some(loaded) => {
            let (results, counters, blocks) = roll(&loaded, stop)?;
            (value(workload, &results), counters, blocks)
        }
        None => influence(stop)?,
    };
    let (workload, found) = (workload.name().to_owned(), MeasuredValue { value, ..workload.truth() });
    Ok(Measurement { workload, instruction_set: instruction_set().to_owned(), counters, found, blocks })
}

/// Rolls the scene of a file on this thread. It has no reference value: another program's mean force is one,
/// within a thousandth.
///
/// # Errors
/// As [`measure`]; [`RunError::Scene`] for a scene too short for a mean force.
pub(crate) fn measure_scene(path: &Path, stop: &AtomicBool) -> Result<Measurement, RunError> {
    let (workload, mut loaded) = (path.display().to_string(), Scene::load(path)?);
    loaded.scene.outputs.plots = false;
    let (results, counters, blocks) = roll(&loaded, stop)?;
    let too_short = || loaded.complain("rolling.duration", "too short for a mean force", "a longer one");
    let value = results.mean_force.ok_or_else(|| SceneError::from(too_short()))?;
    let found = MeasuredValue { what: "mean force [N]".to_owned(), value, expected: value, tolerance: 1e-3 };
    Ok(Measurement { workload, instruction_set: instruction_set().to_owned(), counters, found, blocks })
}

/// Name of a stage or counter in results.
fn name(value: &impl Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|name| Some(name.as_str()?.to_owned())).unwrap_or_default()
}

/// Value by which a rolling workload is judged: the mean force on a smooth road, the pressure where there is a
/// receiver, otherwise the root mean square of the force about its mean.
pub fn value(workload: Workload, results: &Results) -> f64 {
    let value = match workload {
        Workload::Smooth => results.mean_force,
        Workload::Sound => {
            let receiver = results.sound.as_ref().and_then(|sound| sound.receivers.first());
            receiver.map(|receiver| receiver.spectrum.mean_square().sqrt())
        }
        _ => results.rms_force_variation,
    };
    value.unwrap_or(f64::NAN)
}

/// Time of a stage \[ns\] without what other processes took of its block: off all stages of a long block in
/// proportion; `None` in a short one, which a single, unknown stage has lost.
fn undisturbed(stage: Duration, block: Spent) -> Option<u64> {
    let share = block.cpu_seconds().map_or(1.0, |cpu| (cpu / block.wall.as_secs_f64()).min(1.0));
    (share >= 1.0 - LITTLE || block.cpu >= LONG).then_some((share * stage.as_nanos() as f64) as u64)
}

/// Rolls a scene and takes the times of its steps, block by block.
fn roll(loaded: &LoadedScene, stop: &AtomicBool) -> Result<(Results, Counts, Blocks), RunError> {
    let plan = Plan::of(loaded)?;
    let mut run = Simulation::begin_watched(loaded, &plan, stop, Watch::EVERY)?;
    let mut blocks = Stage::OF_A_STEP.map(|stage| (name(&stage), Vec::new()));
    let (mut before, mut clock) = (run.spent(), Clock::start(Some(thread_cpu_time)));
    while run.step()?.is_some() {
        if run.next_step().is_multiple_of(STEPS_OF_A_BLOCK) {
            let (now, block) = (run.spent(), clock.lap());
            for ((_, blocks), (now, before)) in blocks.iter_mut().zip(now.iter().zip(before)) {
                blocks.push(undisturbed(*now - before, block));
            }
            before = now;
            if stop.load(Ordering::Relaxed) {
                return Err(RunError::Interrupted { partial: None });
            }
        }
    }
    let results = run.finish();
    let mut counters = counters(&results.meter);
    if loaded.scene.numerics.history == History::Modal {
        // A cached model takes none.
        counters.remove(&name(&Counter::ComplianceEvaluations));
    }
    let blocks = blocks.into_iter().filter(|(_, blocks)| blocks.iter().flatten().any(|&time| time > 0));
    Ok((results, counters, blocks.collect()))
}

/// All counters of a meter, and the work of the stages of a step.
fn counters(meter: &Meter) -> Counts {
    let counted = Counter::ALL.into_iter().map(|counter| (name(&counter), meter.counted(counter)));
    let works = Stage::OF_A_STEP.into_iter().flat_map(|stage| {
        let (work, stage) = (meter.cost(stage).work, name(&stage));
        [(format!("{stage}.multiply_adds"), work.multiply_adds), (format!("{stage}.bytes"), work.bytes)]
    });
    counted.chain(works).filter(|(_, amount)| *amount > 0).collect()
}

/// A fit from scratch, checked between the fitted points.
fn influence(stop: &AtomicBool) -> Result<(f64, Counts, Blocks), RunError> {
    const ELEMENTS: usize = 32;
    let loaded = Scene::from_str(PLATE, "influence")?;
    let tyre = &loaded.scene.tyre;
    let options = FitOptions::new(tyre, ELEMENTS, 80.0 / 3.6).with_tolerance(1e-4);
    let mut clock = Clock::start(Some(thread_cpu_time));
    let model = fit_unless_stopped(tyre, &options, stop)
        .map_err(|error| refused(&loaded, error, "a layered tyre whose influence functions can be fitted"))?;
    let spent = clock.lap();
    // A single stage: its processor time, else its wall time.
    let blocks = vec![Some((1e9 * spent.cpu_seconds().unwrap_or(spent.wall.as_secs_f64())) as u64)];
    let sum = InfluenceSum::with(tyre, Projection::new(tyre, ELEMENTS), Truncation::Tail, 1e-8, options.top);
    let mut worst = 0.0_f64;
    for n in 0..=ELEMENTS / 2 {
        let samples: Vec<(Complex64, Complex64)> = (0..40)
            .filter_map(|k| {
                let s = Complex64::new(0.0, 2.0 * PI * 20.0 * 1.19f64.powi(k));
                Some((sum.value(n, &sum.at(s), Field::Surface).value, model.evaluate(n, s, Field::Surface)?))
            })
            .collect();
        let peak = samples.iter().fold(0.0_f64, |peak, (exact, _)| peak.max(exact.norm()));
        let error = |(exact, fitted): &(Complex64, Complex64)| (exact - fitted).norm() / peak;
        worst = samples.iter().map(error).fold(worst, f64::max);
    }
    let counters =
        [(name(&Counter::ComplianceEvaluations), model.evaluations()), (name(&Counter::Poles), model.order() as u64)];
    Ok((1.0 + worst, counters.into(), [(name(&Stage::Fit), blocks)].into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_of_other_processes_is_subtracted_or_its_block_left_out() {
        let ms = Duration::from_millis;
        let block = |wall, cpu| Spent { wall: ms(wall), watched: ms(wall), cpu: ms(cpu) };
        assert_eq!(undisturbed(ms(1), block(2, 2)), Some(1_000_000));
        assert_eq!(undisturbed(ms(1), block(4, 3)), None);
        assert_eq!(undisturbed(ms(6), block(16, 8)), Some(3_000_000));
        // Where the system does not report processor time, wall time must do.
        assert_eq!(undisturbed(ms(1), Spent { wall: ms(4), ..Spent::default() }), Some(1_000_000));
    }
}
