//! Cost against size: measured exponents beside those that the algorithms promise, and what more threads give.
//!
//! Every ladder doubles one size and keeps the others. Exponents of exact work belong to the algorithm, those of time
//! to the machine as well: caches, vectors that are not filled by small sizes, calls. One thread, except for the ladder
//! of threads.
//!
//! # On a workstation with 64 cores
//!
//! A time step is a chain: history, transforms, penetration, search, and the next step needs its forces. What can go
//! side by side is
//!
//! * the fit: a graph of tasks, one for each wavenumber, whose longest chain has log2 N links; N/2 tasks keep 64 cores
//!   busy from N = 512 on;
//! * the road and its slices, made ahead of the march on one other core;
//! * the history by poles with its transforms, a block ahead of the march on one other core; direct sums on all;
//! * runs: a sweep keeps as many cores busy as it has variants, which is what such a machine is best at.
//!
//! The search for the points in contact stays on one core. By Amdahl's law ([`ThreadLadder::limit`]) it, the
//! penetration and what is written bound the march however many cores there are. Beside that, 64 cores share their
//! memory: the poles' states and tables that every step goes through (at N = 4096 some 3 MB) fit into the caches of a
//! few cores, and the bandwidth that a step needs grows with its speed.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::error::PerformanceError;
use crate::counters::{Counter, Meter, Stage, Watch};
use crate::numeric::StraightLine;
use crate::plan::Plan;
use crate::road::slices::{SliceBuilder, SliceError, SliceScratch};
use crate::run::{RunError, RunOptions, Simulation, Unwatched, run};
use crate::scene::{Axle, LoadedScene, Outputs, PLATE, Road, Scene, Switch};
use crate::tyre::influence::{Field, InfluenceSum, Projection, Truncation};
use crate::tyre::poles::scaling::cut;

/// Cost at one size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rung {
    /// Size.
    pub size: f64,
    /// Time for one unit \[s\].
    pub seconds: f64,
    /// Exact work for one unit, where it is counted.
    pub work: Option<f64>,
}

/// One size doubled, one cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ladder {
    /// Quantity that is doubled.
    pub axis: &'static str,
    /// Cost that is timed, and its unit.
    pub cost: &'static str,
    /// Exponent that the algorithm promises.
    pub expected: f64,
    /// Why.
    pub reason: &'static str,
    /// From the smallest size on.
    pub rungs: Vec<Rung>,
}

impl Ladder {
    fn exponent(&self, of: impl Fn(&Rung) -> Option<f64>) -> Option<f64> {
        let points: Option<Vec<(f64, f64)>> =
            self.rungs.iter().map(|rung| of(rung).filter(|&cost| cost > 0.0).map(|cost| (rung.size, cost))).collect();
        StraightLine::power_law(&points?).map(|line| line.slope)
    }

    /// Exponent of the time, over all sizes.
    pub fn of_time(&self) -> Option<f64> {
        self.exponent(|rung| Some(rung.seconds))
    }

    /// Exponent of the work.
    pub fn of_work(&self) -> Option<f64> {
        self.exponent(|rung| rung.work)
    }
}

/// A run on more and more threads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ThreadLadder {
    /// Elements round the tyre.
    pub elements: usize,
    /// Threads and wall time of the steps \[s\].
    pub rungs: Vec<(usize, f64)>,
    /// Share of the time on one thread that stays on one: penetration, search, output and what is in no stage.
    pub serial: f64,
}

impl ThreadLadder {
    /// How many times faster so many threads can be at most, by Amdahl's law with the measured serial share.
    pub fn limit(&self, threads: usize) -> f64 {
        1.0 / (self.serial + (1.0 - self.serial) / threads as f64)
    }

    /// How many times faster than one thread each rung is.
    pub fn speedups(&self) -> Vec<f64> {
        let alone = self.rungs.first().map_or(f64::NAN, |rung| rung.1);
        self.rungs.iter().map(|rung| alone / rung.1).collect()
    }
}

/// Everything that was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scaling {
    /// Costs against sizes.
    pub ladders: Vec<Ladder>,
    /// Runs against threads.
    pub threads: Vec<ThreadLadder>,
}

/// How many pieces [`Scaling::measure`] watches.
pub const PIECES: u64 = 8;

impl Scaling {
    /// Measures all ladders; `watch` is told what comes next. `scratch` is a folder that may be written to and removed.
    ///
    /// # Errors
    /// [`PerformanceError`].
    pub fn measure(
        scratch: &std::path::Path,
        stop: &AtomicBool,
        watch: &mut (dyn FnMut(&'static str) + Send),
    ) -> Result<Self, PerformanceError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|_| PerformanceError::Interrupted)?;
        let mut ladders = Vec::new();
        pool.install(|| {
            for family in FAMILIES {
                watch(family.axis);
                ladders.extend(family.measure(stop)?);
            }
            watch("slices");
            ladders.extend(slices());
            watch("layers");
            ladders.push(layers()?);
            Ok::<(), PerformanceError>(())
        })?;
        let mut threads = Vec::new();
        for elements in [1024, 4096] {
            watch("threads");
            threads.push(on_threads(elements, scratch, stop)?);
        }
        Ok(Self { ladders, threads })
    }
}

/// A cost that grows with a size: of a stage in a step, or of all steps; its name, the exponent that the algorithm
/// promises, and why.
type Growth = (Option<Stage>, &'static str, f64, &'static str);

const PENETRATION: (Option<Stage>, &str) = (Some(Stage::Penetration), "penetration, a step");
const SEARCH: Growth = (Some(Stage::ActiveSet), "search, a step", 2.0, "points in contact squared");

/// Runs of growing size on one thread.
struct Family {
    axis: &'static str,
    /// Settings, value by value.
    values: &'static [f64],
    /// Sets it in the scene of the smallest.
    set: fn(&mut LoadedScene, f64),
    /// The size that a run turns out to have.
    size: fn(&Rolled, f64) -> f64,
    costs: &'static [Growth],
}

const FAMILIES: [Family; 4] = [
    Family {
        axis: "elements",
        values: &[256.0, 512.0, 1024.0, 2048.0],
        set: |loaded, value| set_size(&mut loaded.scene, value as usize, 1600),
        size: |_, value| value,
        costs: &[
            (Some(Stage::History), "history, a step", 1.0, "as many poles for each wavenumber"),
            (Some(Stage::Transforms), "transforms, a step", 1.0, "N log N"),
            (PENETRATION.0, PENETRATION.1, 1.0, "columns of the window"),
            SEARCH,
        ],
    },
    Family {
        axis: "poles",
        values: &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6],
        set: |loaded, value| loaded.scene.numerics.pole_tolerance = value,
        size: |rolled, _| rolled.meter.counted(Counter::Poles) as f64,
        costs: &[(Some(Stage::History), "history, a step", 1.0, "each pole a recursion")],
    },
    Family {
        axis: "columns of the window",
        values: &[0.003, 0.006, 0.012, 0.024],
        set: |loaded, value| {
            set_size(&mut loaded.scene, 1024, 1600);
            if let Axle::Indentation { indentation, .. } = &mut loaded.scene.rolling.axle {
                *indentation = value;
            }
        },
        size: |rolled, _| rolled.columns as f64,
        costs: &[(PENETRATION.0, PENETRATION.1, 1.0, "each column once"), SEARCH],
    },
    Family {
        axis: "steps",
        values: &[4000.0, 8000.0, 16_000.0, 32_000.0],
        set: |loaded, value| {
            set_size(&mut loaded.scene, 128, value as u64);
            // A road that has to be made makes a start; here is none.
            loaded.scene.road = Road::Smooth;
            loaded.scene.effects.texture = Switch::Auto;
        },
        size: |_, value| value,
        costs: &[(None, "march, whole", 1.0, "nothing is remembered for longer")],
    },
];

impl Family {
    fn measure(&self, stop: &AtomicBool) -> Result<Vec<Ladder>, PerformanceError> {
        let ladder = |&(_, cost, expected, reason): &Growth| {
            let (axis, rungs) = (self.axis, Vec::new());
            Ladder { axis, cost, expected, reason, rungs }
        };
        let mut ladders: Vec<Ladder> = self.costs.iter().map(ladder).collect();
        for &value in self.values {
            let mut loaded = scene(512, 1600)?;
            (self.set)(&mut loaded, value);
            let rolled = Rolled::new(&loaded, stop)?;
            for (ladder, growth) in ladders.iter_mut().zip(self.costs) {
                ladder.rungs.push(rolled.rung((self.size)(&rolled, value), growth.0));
            }
        }
        Ok(ladders)
    }
}

/// The default scene on a road without texture across, at a fixed height, for so many steps.
fn scene(elements: usize, steps: u64) -> Result<LoadedScene, PerformanceError> {
    let mut loaded = Scene::from_str(PLATE, "scaling")?;
    loaded.scene.effects.texture = Switch::Off;
    loaded.scene.outputs = Outputs { arrays: false, spectra: false, plots: false, ..Outputs::default() };
    set_size(&mut loaded.scene, elements, steps);
    Ok(loaded)
}

fn set_size(scene: &mut Scene, elements: usize, steps: u64) {
    scene.numerics.elements = elements;
    let step = scene.tyre.circumference / (elements as f64 * scene.rolling.speed());
    // The height is reached in the first quarter.
    scene.rolling.axle = Axle::Indentation { indentation: 0.012, ramp: 0.25 * steps as f64 * step };
    (scene.rolling.warm_up, scene.rolling.duration) = (0.0, steps as f64 * step);
}

fn failed(source: RunError) -> PerformanceError {
    match source {
        RunError::Interrupted { .. } => PerformanceError::Interrupted,
        source => PerformanceError::Run { workload: "scaling", source: Box::new(source) },
    }
}

/// A run that has ended.
struct Rolled {
    /// Times of the stages for one step \[s\], after the first half.
    seconds: [f64; Stage::OF_A_STEP.len()],
    meter: Meter,
    steps: f64,
    columns: usize,
    /// Time of all steps \[s\].
    whole: f64,
}

impl Rolled {
    fn new(loaded: &LoadedScene, stop: &AtomicBool) -> Result<Self, PerformanceError> {
        let plan = Plan::of(loaded)?;
        let mut run = Simulation::begin_watched(loaded, &plan, stop, Watch::EVERY).map_err(failed)?;
        let begin = Instant::now();
        let (mut half, half_steps) = (run.spent(), plan.steps / 2);
        while run.step().map_err(failed)?.is_some() {
            if run.next_step() == half_steps {
                half = run.spent();
            }
        }
        let (whole, end, columns) = (begin.elapsed().as_secs_f64(), run.spent(), run.forces().len());
        let counted = (plan.steps - half_steps) as f64;
        let seconds = std::array::from_fn(|stage| (end[stage] - half[stage]).as_secs_f64() / counted);
        Ok(Self { seconds, meter: run.finish().meter, steps: plan.steps as f64, columns, whole })
    }

    /// Cost of a stage for one step, or of all steps.
    fn rung(&self, size: f64, stage: Option<Stage>) -> Rung {
        let Some(stage) = stage else { return Rung { size, seconds: self.whole, work: None } };
        let place = Stage::OF_A_STEP.iter().position(|&other| other == stage).unwrap_or_default();
        let work = self.meter.cost(stage).work.multiply_adds as f64 / self.steps;
        Rung { size, seconds: self.seconds[place], work: Some(work).filter(|&work| work > 0.0) }
    }
}

/// Shortest of several repeats \[s\]: what disturbs only ever adds.
fn shortest(mut work: impl FnMut()) -> f64 {
    (0..7).fold(f64::INFINITY, |best, _| {
        let begin = Instant::now();
        work();
        best.min(begin.elapsed().as_secs_f64())
    })
}

fn slices() -> Vec<Ladder> {
    const WIDTH: f64 = 0.12;
    type Law = fn(usize) -> Result<SliceBuilder, SliceError>;
    let laws: [(&str, f64, &str, Law); 2] = [
        ("springs, a slice", 1.0, "sorted: n log n", SliceBuilder::winkler),
        ("half-space, a slice", 3.0, "a factor that grows point by point", |points| {
            SliceBuilder::half_space(points, 4e-3, WIDTH / points as f64)
        }),
    ];
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let heights: Vec<f64> = (0..64 * 256).map(|_| 2e-3 * rng.random::<f64>()).collect();
    let ladder = |(cost, expected, reason, law): (&'static str, f64, &'static str, Law)| {
        let rung = |points: usize| {
            let builder = law(points).ok()?;
            let (mut scratch, rows) = (SliceScratch::default(), 16 * 256 / points);
            let seconds = shortest(|| {
                for row in heights.chunks_exact(points).take(rows) {
                    let _ = std::hint::black_box(builder.build(row, &mut scratch));
                }
            });
            Some(Rung { size: points as f64, seconds: seconds / rows as f64, work: None })
        };
        let rungs = [32, 64, 128, 256].into_iter().filter_map(rung).collect();
        Ladder { axis: "points of a slice", cost, expected, reason, rungs }
    };
    laws.map(ladder).into()
}

fn layers() -> Result<Ladder, PerformanceError> {
    let tyre = Scene::from_str(PLATE, "scaling")?.scene.tyre;
    let mut rungs = Vec::new();
    for parts in [1, 2, 4, 8, 16] {
        let tyre = cut(&tyre, parts);
        let top = 2e4 * 2.0 * std::f64::consts::PI;
        let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, 512), Truncation::Tail, 1e-8, top);
        let at: Vec<_> = (0..64).map(|k| sum.at(Complex64::new(0.0, 1e3 * 1.05f64.powi(k)))).collect();
        let mut values = Vec::new();
        let seconds = shortest(|| {
            values.clear();
            sum.faces(40, &at, Field::Surface, &mut values);
        });
        let evaluations: u64 = values.iter().map(|value| value.evaluations).sum();
        rungs.push(Rung { size: tyre.layers.len() as f64, seconds: seconds / evaluations as f64, work: None });
    }
    let (cost, reason) = ("compliance, an evaluation", "one impedance after the other");
    Ok(Ladder { axis: "layers", cost, expected: 1.0, reason, rungs })
}

fn on_threads(elements: usize, scratch: &std::path::Path, stop: &AtomicBool) -> Result<ThreadLadder, PerformanceError> {
    let mut loaded = scene(elements, (2_000_000 / elements as u64).max(600))?;
    loaded.scene.effects.texture = Switch::Auto;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let doubled = std::iter::successors(Some(1), |&count| Some(2 * count)).take_while(|&count| count < cores);
    let mut found = ThreadLadder { elements, rungs: Vec::new(), serial: f64::NAN };
    for threads in doubled.chain([cores]) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|_| PerformanceError::Interrupted)?;
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            let options = RunOptions { target: scratch.join("threads"), threads, watch: Watch::default() };
            let report = pool.install(|| run(&loaded, &options, stop, &mut Unwatched)).map_err(failed)?;
            let of = |stages: &[Stage]| -> f64 {
                stages.iter().map(|&stage| report.meter.cost(stage).spent.wall.as_secs_f64()).sum()
            };
            let seconds = report.wall.as_secs_f64() - of(&[Stage::Influence, Stage::Fit, Stage::Axle]);
            if seconds < best {
                best = seconds;
                if threads == 1 {
                    let beside = of(&[Stage::Road, Stage::Slices, Stage::History, Stage::Transforms]);
                    found.serial = 1.0 - beside / seconds;
                }
            }
        }
        found.rungs.push((threads, best));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_and_limits_are_those_of_the_numbers() {
        let rungs: Vec<Rung> =
            [1.0, 2.0, 4.0].iter().map(|&size: &f64| Rung { size, seconds: 3.0 * size.powi(2), work: None }).collect();
        let ladder = Ladder { axis: "a", cost: "b", expected: 2.0, reason: "", rungs };
        assert!((ladder.of_time().unwrap() - 2.0).abs() < 1e-12 && ladder.of_work().is_none());
        let threads = ThreadLadder { elements: 8, rungs: vec![(1, 4.0), (2, 2.5)], serial: 0.25 };
        assert!((threads.limit(2) - 1.6).abs() < 1e-12 && (threads.limit(1) - 1.0).abs() < 1e-12);
        assert!((threads.speedups()[1] - 1.6).abs() < 1e-12);
    }

    #[test]
    fn a_step_takes_the_same_work_however_many_there_are() {
        let stop = AtomicBool::new(false);
        let of = |steps| {
            let mut loaded = scene(64, steps).unwrap();
            loaded.scene.numerics.pole_tolerance = 1e-3;
            let rolled = Rolled::new(&loaded, &stop).unwrap();
            assert!(rolled.meter.counted(Counter::Poles) > 0 && rolled.columns > 0 && rolled.whole > 0.0);
            [Stage::History, Stage::Transforms, Stage::Penetration]
                .map(|stage| rolled.rung(1.0, Some(stage)).work.unwrap())
        };
        for (few, many) in of(400).into_iter().zip(of(1600)) {
            assert!((few / many - 1.0).abs() < 0.02, "{few} {many}");
        }
    }
}
