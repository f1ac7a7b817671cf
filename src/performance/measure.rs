//! One workload done in this process.
//!
//! Times are taken in short blocks, the same ones in every run: a block that the machine disturbed is told by its
//! length from the same block of other runs, and the stage around it is not lost with it. See `super::ratio`.

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

/// Steps of a block: a millisecond or so, and a multiple of the steps that the recursion takes at once.
const STEPS_OF_A_BLOCK: u64 = 32;

/// Times of blocks by the names of their stages.
type Blocks = BTreeMap<String, Vec<Option<u64>>>;

/// Cost and findings of a workload. Maps are by the names of stages and counters, so that programs of different
/// releases understand each other.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct Measurement {
    /// Name of the workload.
    pub workload: String,
    /// Instructions that its vectors were computed with.
    #[serde(default)]
    pub instruction_set: String,
    /// Exact counters that are not zero: of the run, and of its stages as `stage.multiply_adds`, `stage.bytes`,
    /// `stage.calls`.
    pub counters: BTreeMap<String, u64>,
    /// The physical value.
    pub found: Found,
    /// Time of every block by stage \[ns\]; `None` where others had the processor and it cannot be said in which stage.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub blocks: Blocks,
}

/// A physical value beside what it must be.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct Found {
    /// Name of the value.
    pub what: String,
    /// Its value.
    pub value: f64,
    /// Value expected.
    pub expected: f64,
    /// Largest relative difference.
    pub tolerance: f64,
}

impl Measurement {
    /// Makes the measurement of a workload that was done here and found a value.
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
    /// Returns |value - expected|/|expected|.
    pub(crate) fn error(&self) -> f64 {
        (self.value - self.expected).abs() / self.expected.abs()
    }

    /// Tells whether the workload found what it must.
    pub(crate) fn is_right(&self) -> bool {
        self.error() <= self.tolerance
    }
}

/// For one that is wrong.
impl fmt::Display for Found {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, value, expected, tolerance } = self;
        write!(formatter, "{what} is {value}, not {expected} within {tolerance:e}")
    }
}

/// Wall time of a block, and the part of it that this thread had no processor for.
struct BlockClock {
    wall: Instant,
    processor: Option<Duration>,
}

/// Returns a time in whole nanoseconds.
fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl BlockClock {
    fn start() -> Self {
        Self { wall: Instant::now(), processor: thread_cpu_time() }
    }

    /// Returns the time that others took \[ns\]; 0 where the system does not tell.
    fn taken(&self) -> u64 {
        let used = self.processor.zip(thread_cpu_time()).map(|(begin, end)| end.saturating_sub(begin));
        used.map_or(0, |used| nanoseconds(self.wall.elapsed().saturating_sub(used)))
    }

    /// Returns the time of the block without it \[ns\].
    fn nanoseconds(&self) -> u64 {
        let taken = self.taken();
        nanoseconds(self.wall.elapsed()).saturating_sub(taken)
    }
}

/// Part of a block that others may have taken without disturbing it.
const LITTLE: f64 = 0.02;

/// Blocks so long \[ns\] are disturbed many times over, each stage in proportion to its length.
const LONG: u64 = 5_000_000;

/// Returns the times of the stages of a block less what others took of it, all \[ns\]. The time that they took was
/// taken from the stage that makes nearly all of the block, or from all stages of a long block alike; if it cannot be
/// said, the block is of no use.
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

/// Does a workload on this thread: times are this thread's, so the pool should have no other.
///
/// # Errors
/// Errors of the run or the fit; [`PerformanceError::Interrupted`].
pub(crate) fn measure(workload: Workload, stop: &AtomicBool) -> Result<Measurement, PerformanceError> {
    match workload.scene()? {
        Some(loaded) => {
            let Rolled { counters, results, blocks } = Rolled::of(workload.name(), &loaded, stop)?;
            Ok(Measurement::new(workload, counters, value(workload, &results), blocks))
        }
        None if workload == Workload::Compliance => compliance(),
        None => influence(stop),
    }
}

/// Largest relative difference between the mean forces that two programs find for a scene of the user's.
const OF_SCENES: f64 = 1e-3;

/// Rolls the scene of a file on this thread. Nothing says what it must find: another program's mean force does.
///
/// # Errors
/// As [`measure`]; [`PerformanceError::Nonsense`] for a scene that rolls too shortly for a mean force.
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

/// Returns the name that results use for a stage or a counter.
pub(super) fn name<T: Serialize>(value: &T) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(name)) => name,
        _ => String::new(),
    }
}

/// Returns the value by which a rolling workload is judged: its mean force where it stands still or is controlled, the
/// pressure where it is heard, the variation of the force elsewhere.
pub(crate) fn value(workload: Workload, results: &Results) -> f64 {
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

/// A scene that was rolled.
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
            // A kept model takes none.
            counters.remove(&name(&Counter::ComplianceEvaluations));
        }
        let blocks = blocks.into_iter().filter(|(_, blocks)| blocks.iter().flatten().any(|&time| time > 0));
        Ok(Self { counters, blocks: blocks.collect(), results })
    }
}

/// Returns all that a meter counted and the work of the stages of a step.
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

/// Returns the batches of frequencies for wavenumbers all over the spectrum; in vectors, checked against the scalar
/// path.
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
                // The farthest from one.
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

/// Returns a fit from nothing, checked between the points that were fitted.
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
