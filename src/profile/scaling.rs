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
use std::time::{Duration, Instant};

use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::error::ProfileError;
use crate::counters::{Counter, Stage, Watch};
use crate::numeric::StraightLine;
use crate::plan::Plan;
use crate::road::slices::{SliceBuilder, SliceScratch};
use crate::run::{Run, RunError, RunOptions, Unwatched, run};
use crate::scene::{Axle, DEFAULT, LoadedScene, Outputs, Road, Scene, Switch};
use crate::tyre::influence::{Field, InfluenceSum, Projection, Truncation};
use crate::tyre::rational::scaling::cut;

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
    /// What is doubled.
    pub axis: &'static str,
    /// What is timed, and for which unit.
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
    /// [`ProfileError`].
    pub fn measure(
        scratch: &std::path::Path,
        stop: &AtomicBool,
        watch: &mut (dyn FnMut(&'static str) + Send),
    ) -> Result<Self, ProfileError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|_| ProfileError::Interrupted)?;
        let mut ladders = Vec::new();
        pool.install(|| {
            watch("elements");
            ladders.extend(elements(stop)?);
            watch("poles");
            ladders.push(poles(stop)?);
            watch("window");
            ladders.extend(window(stop)?);
            watch("steps");
            ladders.push(steps(stop)?);
            watch("slices");
            ladders.extend(slices());
            watch("layers");
            ladders.push(layers()?);
            Ok::<(), ProfileError>(())
        })?;
        let mut threads = Vec::new();
        for elements in [1024, 4096] {
            watch("threads");
            threads.push(on_threads(elements, scratch, stop)?);
        }
        Ok(Self { ladders, threads })
    }
}

/// The default scene on a road without texture across, at a fixed height, for so many steps.
fn scene(elements: usize, steps: u64) -> Result<LoadedScene, ProfileError> {
    let mut loaded = Scene::from_str(DEFAULT, "scaling")?;
    let scene = &mut loaded.scene;
    scene.numerics.elements = elements;
    scene.effects.texture = Switch::Off;
    let step = scene.tyre.circumference / (elements as f64 * scene.rolling.speed());
    // The height is reached in the first quarter.
    scene.rolling.axle = Axle::Indentation { indentation: 0.012, ramp: 0.25 * steps as f64 * step };
    (scene.rolling.warm_up, scene.rolling.duration) = (0.0, steps as f64 * step);
    scene.outputs = Outputs { arrays: false, spectra: false, plots: false, ..Outputs::default() };
    Ok(loaded)
}

fn failed(source: RunError) -> ProfileError {
    match source {
        RunError::Interrupted { .. } => ProfileError::Interrupted,
        source => ProfileError::Run { workload: "scaling", source: Box::new(source) },
    }
}

/// Times and work of the stages for one step, after the first half; poles and columns.
struct Rolled {
    seconds: [f64; Stage::OF_A_STEP.len()],
    work: [f64; Stage::OF_A_STEP.len()],
    poles: f64,
    columns: f64,
    whole: f64,
}

fn rolled(loaded: &LoadedScene, stop: &AtomicBool) -> Result<Rolled, ProfileError> {
    let plan = Plan::of(loaded);
    let mut run = Run::begin_watched(loaded, &plan, stop, Watch::EVERY).map_err(failed)?;
    let begin = Instant::now();
    let (mut half, half_steps) = ([Duration::ZERO; Stage::OF_A_STEP.len()], plan.steps / 2);
    while run.step().map_err(failed)?.is_some() {
        if run.next_step() == half_steps {
            half = run.spent();
        }
    }
    let (whole, end) = (begin.elapsed().as_secs_f64(), run.spent());
    let meter = run.finish().meter;
    let all = plan.steps as f64;
    let counted = (plan.steps - half_steps) as f64;
    Ok(Rolled {
        seconds: std::array::from_fn(|stage| (end[stage] - half[stage]).as_secs_f64() / counted),
        work: Stage::OF_A_STEP.map(|stage| meter.cost(stage).work.multiply_adds as f64 / all),
        poles: meter.counted(Counter::Poles) as f64,
        // Four multiply-adds for each column.
        columns: meter.cost(Stage::Penetration).work.multiply_adds as f64 / (4.0 * all),
        whole,
    })
}

impl Rolled {
    fn rung(&self, size: f64, stage: Stage) -> Rung {
        let place = Stage::OF_A_STEP.iter().position(|&other| other == stage).unwrap_or_default();
        let work = Some(self.work[place]).filter(|&work| work > 0.0);
        Rung { size, seconds: self.seconds[place], work }
    }
}

/// One ladder for each of several stages of the same runs.
fn of_stages(
    axis: &'static str,
    stages: &[(Stage, &'static str, f64, &'static str)],
    rolled: &[(f64, Rolled)],
) -> Vec<Ladder> {
    let ladder = |&(stage, cost, expected, reason): &(Stage, &'static str, f64, &'static str)| {
        let rungs = rolled.iter().map(|(size, rolled)| rolled.rung(*size, stage)).collect();
        Ladder { axis, cost, expected, reason, rungs }
    };
    stages.iter().map(ladder).collect()
}

fn elements(stop: &AtomicBool) -> Result<Vec<Ladder>, ProfileError> {
    let mut found = Vec::new();
    for elements in [256, 512, 1024, 2048] {
        found.push((elements as f64, rolled(&scene(elements, 1600)?, stop)?));
    }
    let stages = [
        (Stage::History, "history, a step", 1.0, "as many poles for each wavenumber"),
        (Stage::Transforms, "transforms, a step", 1.0, "N log N"),
        (Stage::Penetration, "penetration, a step", 1.0, "columns of the window"),
        (Stage::ActiveSet, "search, a step", 2.0, "points in contact squared"),
    ];
    Ok(of_stages("elements", &stages, &found))
}

fn poles(stop: &AtomicBool) -> Result<Ladder, ProfileError> {
    let mut rungs = Vec::new();
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        let mut loaded = scene(512, 1600)?;
        loaded.scene.numerics.pole_tolerance = tolerance;
        let rolled = rolled(&loaded, stop)?;
        rungs.push(rolled.rung(rolled.poles, Stage::History));
    }
    Ok(Ladder { axis: "poles", cost: "history, a step", expected: 1.0, reason: "each pole a recursion", rungs })
}

fn window(stop: &AtomicBool) -> Result<Vec<Ladder>, ProfileError> {
    let mut found = Vec::new();
    for indentation in [0.003, 0.006, 0.012, 0.024] {
        let mut loaded = scene(1024, 1600)?;
        if let Axle::Indentation { indentation: height, .. } = &mut loaded.scene.rolling.axle {
            *height = indentation;
        }
        let rolled = rolled(&loaded, stop)?;
        found.push((rolled.columns, rolled));
    }
    let stages = [
        (Stage::Penetration, "penetration, a step", 1.0, "each column once"),
        (Stage::ActiveSet, "search, a step", 2.0, "points in contact squared"),
    ];
    Ok(of_stages("columns of the window", &stages, &found))
}

fn steps(stop: &AtomicBool) -> Result<Ladder, ProfileError> {
    let mut rungs = Vec::new();
    for steps in [4000_u64, 8000, 16_000, 32_000] {
        let mut loaded = scene(128, steps)?;
        // A road that has to be made makes a start; here is none.
        loaded.scene.road = Road::Smooth;
        loaded.scene.effects.texture = Switch::Auto;
        let rolled = rolled(&loaded, stop)?;
        rungs.push(Rung { size: steps as f64, seconds: rolled.whole, work: None });
    }
    Ok(Ladder { axis: "steps", cost: "march, whole", expected: 1.0, reason: "nothing is remembered for longer", rungs })
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
    let sizes = [32_usize, 64, 128, 256];
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let heights: Vec<f64> = (0..64 * 256).map(|_| 2e-3 * rng.random::<f64>()).collect();
    let mut rungs = [Vec::new(), Vec::new()];
    for points in sizes {
        let builders = [SliceBuilder::winkler(points), SliceBuilder::half_space(points, 4e-3, WIDTH / points as f64)];
        for (builder, rungs) in builders.into_iter().zip(&mut rungs) {
            let Ok(builder) = builder else { continue };
            let mut scratch = SliceScratch::default();
            let rows = 16 * 256 / points;
            let seconds = shortest(|| {
                for row in heights.chunks_exact(points).take(rows) {
                    let _ = std::hint::black_box(builder.build(row, &mut scratch));
                }
            });
            rungs.push(Rung { size: points as f64, seconds: seconds / rows as f64, work: None });
        }
    }
    let [springs, half_space] = rungs;
    vec![
        Ladder {
            axis: "points of a slice",
            cost: "springs, a slice",
            expected: 1.0,
            reason: "sorted: n log n",
            rungs: springs,
        },
        Ladder {
            axis: "points of a slice",
            cost: "half-space, a slice",
            expected: 3.0,
            reason: "a factor that grows point by point",
            rungs: half_space,
        },
    ]
}

fn layers() -> Result<Ladder, ProfileError> {
    let tyre = Scene::from_str(DEFAULT, "scaling")?.scene.tyre;
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
    Ok(Ladder {
        axis: "layers",
        cost: "compliance, an evaluation",
        expected: 1.0,
        reason: "one impedance after the other",
        rungs,
    })
}

fn on_threads(elements: usize, scratch: &std::path::Path, stop: &AtomicBool) -> Result<ThreadLadder, ProfileError> {
    let mut loaded = scene(elements, (2_000_000 / elements as u64).max(600))?;
    loaded.scene.effects.texture = Switch::Auto;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut threads: Vec<usize> =
        std::iter::successors(Some(1), |&count| Some(2 * count)).take_while(|&count| count < cores).collect();
    threads.push(cores);
    let mut found = ThreadLadder { elements, rungs: Vec::new(), serial: f64::NAN };
    for threads in threads {
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|_| ProfileError::Interrupted)?;
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            let options = RunOptions { target: scratch.join("threads"), threads, watch: Watch::default() };
            let report = pool.install(|| run(&loaded, &options, stop, &mut Unwatched)).map_err(failed)?;
            let before: Duration =
                [Stage::Influence, Stage::Fit, Stage::Axle].iter().map(|&stage| report.meter.cost(stage).wall).sum();
            let seconds = (report.wall - before).as_secs_f64();
            if seconds < best {
                best = seconds;
                if threads == 1 {
                    let beside = [Stage::Road, Stage::Slices, Stage::History, Stage::Transforms];
                    let parallel: f64 = beside.iter().map(|&stage| report.meter.cost(stage).wall.as_secs_f64()).sum();
                    found.serial = 1.0 - parallel / seconds;
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
            let rolled = rolled(&loaded, &stop).unwrap();
            assert!(rolled.poles > 0.0 && rolled.columns > 0.0 && rolled.whole > 0.0);
            [Stage::History, Stage::Transforms, Stage::Penetration].map(|stage| rolled.rung(1.0, stage).work.unwrap())
        };
        for (few, many) in of(400).into_iter().zip(of(1600)) {
            assert!((few / many - 1.0).abs() < 0.02, "{few} {many}");
        }
    }
}
