//! Execution of one workload in this process.
//!
//! Times are taken in short blocks, the same ones in every run: a block that the machine disturbed stands out against
//! the same block of other runs, and the stage around it is not lost with it. See `super::ratio`.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::error::PerformanceError;
use super::workload::{Truth, Workload};
use crate::counters::machine::instruction_set;
use crate::counters::process::thread_cpu_time;
use crate::counters::{Counter, Meter, Stage, Watch};
use crate::plan::Plan;
use crate::run::{Results, RunError, Simulation};
use crate::scene::{History, LoadedScene, PLATE, Scene, Tyre};
use crate::tyre::influence::{Field, InfluenceSum, Projection, Truncation};
use crate::tyre::poles::{FitOptions, fit_unless_stopped};

/// Steps of a block: about a millisecond, and a multiple of the steps that the recursion takes at once.
const STEPS_OF_A_BLOCK: u64 = 32;

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
    pub counters: BTreeMap<String, u64>,
    /// Physical value that was computed.
    pub found: Found,
    /// Time of every block by stage \[ns\]; `None` if other processes had the processor and the stage that lost the
    /// time is unknown.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub blocks: Blocks,
}

/// A physical value and its reference.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Found {
    /// Name of the value.
    pub what: String,
    /// Computed value.
    pub value: f64,
    /// Reference value.
    pub expected: f64,
    /// Largest relative difference from the reference.
    pub tolerance: f64,
}

impl Measurement {
    /// Measurement of a workload that was executed here and gave `value`.
    fn new(workload: Workload, counters: BTreeMap<String, u64>, value: f64, blocks: Blocks) -> Self {
        let Truth { what, expected, tolerance } = workload.truth();
        Self {
            workload: workload.name().to_owned(),
            instruction_set: instruction_set().to_owned(),
            counters,
            found: Found { what: what.to_owned(), value, expected, tolerance },
            blocks,
        }
    }
}

impl Found {
    /// Relative error |value - expected|/|expected|.
    pub fn error(&self) -> f64 {
        (self.value - self.expected).abs() / self.expected.abs()
    }

    /// True if the error is within the tolerance.
    pub fn is_right(&self) -> bool {
        self.error() <= self.tolerance
    }
}

/// Message on a wrong value.
impl fmt::Display for Found {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, value, expected, tolerance } = self;
        write!(formatter, "{what} is {value}, not {expected} within {tolerance:e}")
    }
}

/// Wall and processor time since the begin of a block.
struct BlockClock {
    wall: Instant,
    processor: Option<Duration>,
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl BlockClock {
    fn start() -> Self {
        Self { wall: Instant::now(), processor: thread_cpu_time() }
    }

    /// Time that other processes took \[ns\]; 0 if the system does not report it.
    fn taken(&self) -> u64 {
        let used = self.processor.zip(thread_cpu_time()).map(|(begin, end)| end.saturating_sub(begin));
        used.map_or(0, |used| nanoseconds(self.wall.elapsed().saturating_sub(used)))
    }

    /// Wall time of the block without that of other processes \[ns\].
    fn nanoseconds(&self) -> u64 {
        let taken = self.taken();
        nanoseconds(self.wall.elapsed()).saturating_sub(taken)
    }
}

/// Largest share of a block that other processes may take without disturbing it.
const LITTLE: f64 = 0.02;

/// Blocks at least this long \[ns\] are interrupted many times, each stage in proportion to its length.
const LONG: u64 = 5_000_000;

/// Times of the stages of a block without what other processes took of it, all in ns. That is subtracted from the stage
/// that makes up nearly all of the block, or from all stages of a long block in proportion; `None` if the stage is
/// unknown.
fn undisturbed(mut times: Vec<u64>, taken: u64) -> Option<Vec<u64>> {
    let all: u64 = times.iter().sum();
    if taken as f64 <= LITTLE * all as f64 {
        return Some(times);
    }
    let longest = times.iter_mut().max()?;
    let rest = all - *longest;
    if rest as f64 <= LITTLE * longest.saturating_sub(taken) as f64 {
        *longest = longest.saturating_sub(taken);
        return Some(times);
    }
    let left = all.saturating_sub(taken);
    (left >= LONG).then(|| times.iter().map(|&time| (time as f64 * left as f64 / all as f64) as u64).collect())
}

/// Executes a workload on this thread: times are this thread's, so the pool should have no other.
///
/// # Errors
/// Errors of the run or the fit; [`PerformanceError::Interrupted`].
pub fn measure(workload: Workload, stop: &AtomicBool) -> Result<Measurement, PerformanceError> {
    match workload.scene()? {
        Some(loaded) => {
            let Rolled { counters, results, blocks } = Rolled::of(workload.name(), &loaded, stop)?;
            Ok(Measurement::new(workload, counters, value(workload, &results), blocks))
        }
        None if workload == Workload::Compliance => compliance(),
        None => influence(stop),
    }
}

/// Largest relative difference between the mean forces of two programs for a scene of the user.
const OF_SCENES: f64 = 1e-3;

/// Rolls the scene of a file on this thread. It has no reference value: another program's mean force is one.
///
/// # Errors
/// As [`measure`]; [`PerformanceError::Nonsense`] for a scene too short for a mean force.
pub(crate) fn measure_scene(path: &Path, stop: &AtomicBool) -> Result<Measurement, PerformanceError> {
    let (name, mut loaded) = (path.display().to_string(), Scene::load(path)?);
    loaded.scene.outputs.plots = false;
    let Rolled { counters, results, blocks } = Rolled::of(&name, &loaded, stop)?;
    let value = results.mean_force.ok_or_else(|| PerformanceError::Nonsense {
        path: path.to_owned(),
        wrong: "it rolls too shortly for a mean force".to_owned(),
        right: "a longer rolling.duration",
    })?;
    let found = Found { what: "mean force [N]".to_owned(), value, expected: value, tolerance: OF_SCENES };
    Ok(Measurement { workload: name, instruction_set: instruction_set().to_owned(), counters, found, blocks })
}

/// Name of a stage or counter in results.
pub(super) fn name<T: Serialize>(value: &T) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    }
}

/// Value by which a rolling workload is judged: the mean force on a smooth road, the pressure where there is a
/// receiver, otherwise the root mean square of the force about its mean.
pub fn value(workload: Workload, results: &Results) -> f64 {
    let value = match workload {
        Workload::Smooth => results.mean_force,
        Workload::Sound => {
            let heard = results.sound.as_ref().and_then(|sound| sound.receivers.first());
            heard.map(|receiver| receiver.spectrum.mean_square().sqrt())
        }
        _ => results.rms_force_variation,
    };
    value.unwrap_or(f64::NAN)
}

/// Results of a scene that was rolled.
struct Rolled {
    counters: BTreeMap<String, u64>,
    results: Results,
    blocks: Blocks,
}

impl Rolled {
    fn of(title: &str, loaded: &LoadedScene, stop: &AtomicBool) -> Result<Self, PerformanceError> {
        let failed = |source: RunError| match source {
            RunError::Interrupted { .. } => PerformanceError::Interrupted,
            source => PerformanceError::Run { workload: title.to_owned(), source: Box::new(source) },
        };
        let plan = Plan::of(loaded).map_err(|error| failed(error.into()))?;
        let mut run = Simulation::begin_watched(loaded, &plan, stop, Watch::EVERY).map_err(failed)?;
        let mut blocks = Stage::OF_A_STEP.map(|stage| (name(&stage), Vec::new()));
        let (mut before, mut clock) = (run.spent(), BlockClock::start());
        while run.step().map_err(failed)?.is_some() {
            if run.next_step().is_multiple_of(STEPS_OF_A_BLOCK) {
                let now = run.spent();
                let times = now.iter().zip(before).map(|(now, before)| nanoseconds(*now - before)).collect();
                let times = undisturbed(times, clock.taken());
                for (block, (_, blocks)) in blocks.iter_mut().enumerate() {
                    blocks.push(times.as_ref().map(|times| times[block]));
                }
                (before, clock) = (run.spent(), BlockClock::start());
                if stop.load(Ordering::Relaxed) {
                    return Err(PerformanceError::Interrupted);
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
        Ok(Self { counters, blocks: blocks.collect(), results })
    }
}

/// All counters of a meter, and the work of the stages of a step.
fn counters(meter: &Meter) -> BTreeMap<String, u64> {
    let counted = Counter::ALL.into_iter().map(|counter| (name(&counter), meter.counted(counter)));
    let works = Stage::OF_A_STEP.into_iter().flat_map(|stage| {
        let (work, stage) = (meter.cost(stage).work, name(&stage));
        [(format!("{stage}.multiply_adds"), work.multiply_adds), (format!("{stage}.bytes"), work.bytes)]
    });
    counted.chain(works).filter(|(_, amount)| *amount > 0).collect()
}

fn plate_tyre() -> Result<Tyre, PerformanceError> {
    Ok(Scene::from_str(PLATE, "workload")?.scene.tyre)
}

/// Batches of frequencies for wavenumbers all over the spectrum, in vectors, checked against the scalar path.
fn compliance() -> Result<Measurement, PerformanceError> {
    const ELEMENTS: usize = 512;
    const ROUNDS: usize = 12;
    let tyre = plate_tyre()?;
    let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, ELEMENTS), Truncation::Tail, 1e-8, 2.0 * PI * 20e3);
    let at: Vec<_> = (0..64).map(|k| sum.at(Complex64::new(0.0, 1e3 * 1.05f64.powi(k)))).collect();
    let (mut blocks, mut evaluations, mut ratio, mut values) = (Vec::new(), 0, 0.0, Vec::new());
    for round in 0..ROUNDS {
        for n in (0..=ELEMENTS / 2).step_by(16) {
            values.clear();
            let clock = BlockClock::start();
            sum.faces(n, &at, Field::Surface, &mut values);
            blocks.push(Some(clock.nanoseconds()));
            evaluations += values.iter().map(|value| value.evaluations).sum::<u64>();
            if round == 0 {
                // The value farthest from 1.
                for (value, at) in values.iter().zip(&at).step_by(7) {
                    let scalar = sum.value(n, at, Field::Surface).value;
                    let found = 1.0 + (value.driven - scalar).norm() / scalar.norm();
                    ratio = f64::max(ratio, found);
                }
            }
        }
    }
    let counters = [(name(&Counter::ComplianceEvaluations), evaluations)].into();
    Ok(Measurement::new(Workload::Compliance, counters, ratio, [(name(&Stage::Influence), blocks)].into()))
}

/// A fit from scratch, checked between the fitted points.
fn influence(stop: &AtomicBool) -> Result<Measurement, PerformanceError> {
    const ELEMENTS: usize = 32;
    let tyre = plate_tyre()?;
    let options = FitOptions::new(&tyre, ELEMENTS, 80.0 / 3.6).with_tolerance(1e-4);
    let clock = BlockClock::start();
    let model = fit_unless_stopped(&tyre, &options, stop)?;
    let blocks = vec![Some(clock.nanoseconds())];
    let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, ELEMENTS), Truncation::Tail, 1e-8, options.top);
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
    let blocks = [(name(&Stage::Fit), blocks)].into();
    Ok(Measurement::new(Workload::Influence, counters.into(), 1.0 + worst, blocks))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_others_took_is_taken_off_where_it_is_known_from_which_stage() {
        assert_eq!(undisturbed(vec![100, 0, 900], 10), Some(vec![100, 0, 900]));
        assert_eq!(undisturbed(vec![100, 0, 900], 300), None);
        assert_eq!(undisturbed(vec![10, 0, 990], 300), Some(vec![10, 0, 690]));
        assert_eq!(undisturbed(vec![10, 0, 990], 800), None);
        assert_eq!(undisturbed(vec![2 * LONG, 0, 6 * LONG], 4 * LONG), Some(vec![LONG, 0, 3 * LONG]));
        assert_eq!(undisturbed(vec![2 * LONG, 0, 6 * LONG], 8 * LONG), None);
        assert_eq!(undisturbed(Vec::new(), 5), None);
    }
}
