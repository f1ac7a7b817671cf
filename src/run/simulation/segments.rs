//! Segments of a run: pieces of its road that are rolled side by side, each after a warm-up of its own.
//!
//! Segments are joined in the order of the road, as if one run had rolled them: totals of their steps are given to
//! the run's observers, and blocks of the sound's forces, which overlap from one segment to the next, to its sound.
//! So levels differ from those of a run in one piece by what a warm-up leaves, and have its bytes on any number of
//! threads.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use super::{CHECK_EVERY, Named, Simulation};
use crate::contact::axle::AxleHeight;
use crate::contact::complementarity::SearchCounts;
use crate::contact::march::MarchTotals;
use crate::counters::{Counter, Job, Meter, Stage, Unwatched};
use crate::effects::{EFFECTS, Observer, RunError, Step};
use crate::plan::{Plan, Segments};
use crate::scene::LoadedScene;

/// Time between two looks at the progress, and for an interruption.
const LOOK: Duration = Duration::from_millis(100);

/// Totals of a step.
#[derive(Clone, Copy)]
struct StepTotals {
    total_force: f64,
    contact_length: f64,
    indentation: f64,
    power: Option<f64>,
}

/// Observer that keeps the totals of the first `most` steps after the warm-up.
struct Recorder {
    most: usize,
    needs_power: bool,
    steps: Vec<StepTotals>,
}

impl Observer for Recorder {
    fn needs_power(&self) -> bool {
        self.needs_power
    }

    fn observe(&mut self, step: &Step<'_>, _: &mut Meter) -> Result<(), RunError> {
        if step.counts && self.steps.len() < self.most {
            let Step { total_force, contact_length, indentation, power, .. } = *step;
            self.steps.push(StepTotals { total_force, contact_length, indentation, power });
        }
        Ok(())
    }
}

/// A segment to be rolled.
struct Segment {
    number: usize,
    plan: Plan,
    observers: Vec<Named>,
    recorder: Recorder,
}

/// A segment that has been rolled.
struct Rolled {
    /// All steps, those of the warm-up included.
    all: u64,
    steps: Vec<StepTotals>,
    observers: Vec<Named>,
    totals: MarchTotals,
    searches: SearchCounts,
    meter: Meter,
}

impl Segment {
    /// Rolls the segment; `done` counts its steps.
    fn roll(self, loaded: &LoadedScene, stop: &AtomicBool, done: &AtomicU64) -> Result<Rolled, RunError> {
        let mut unwatched = Unwatched;
        let mut job = Job::new(stop, &mut unwatched);
        let without = EFFECTS.map(|effect| effect.name());
        let mut run = Simulation::prepare(loaded, &self.plan, true, &without, &mut job)?.with(self.recorder);
        run.observers = self.observers;
        run.enter_steps();
        let complete = run.roll(&mut |_| {
            done.fetch_add(CHECK_EVERY, Ordering::Relaxed);
            Ok(!job.is_stopped())
        })?;
        run.meter.settle_steps(run.next_step);
        let steps = run.observer::<Recorder>().map(|recorder| recorder.steps.clone()).unwrap_or_default();
        let march = &run.prepared.march;
        let (totals, searches) = (march.totals().clone(), march.search_counts());
        let Simulation { next_step: all, observers, meter, .. } = run;
        let rolled = Rolled { all, steps, observers, totals, searches, meter };
        if complete { Ok(rolled) } else { Err(RunError::Interrupted { partial: None }) }
    }
}

impl Simulation {
    /// Rolls all segments, as many at once as there are threads.
    pub(super) fn roll_segments(&mut self, segments: Segments, job: &mut Job<'_>) -> Result<(), RunError> {
        job.progress.march(0, segments.rolled(self.plan.warm_up_steps), self.plan.time_step);
        self.enter_steps();
        let geometry = self.prepared.march.geometry().clone();
        let segment = |number: usize| {
            let from = number as u64 * segments.steps;
            let observers = self.observers.iter().filter_map(|(name, of)| Some((*name, of.of_segment(from)?)));
            Segment {
                number,
                plan: self.plan.segment(segments, number, &geometry),
                observers: observers.collect(),
                recorder: Recorder {
                    most: segments.steps as usize,
                    needs_power: self.power.is_some(),
                    steps: Vec::new(),
                },
            }
        };
        let waiting: Mutex<VecDeque<Segment>> = Mutex::new((0..segments.count).map(segment).collect());
        let (loaded, stop, done) = (self.loaded.clone(), AtomicBool::new(false), AtomicU64::new(0));
        let threads = rayon::current_num_threads();
        let workers = threads.min(segments.count);
        let (sender, receiver) = mpsc::channel();
        let work = |sender: Sender<(usize, Result<Rolled, RunError>)>| {
            let next = || waiting.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
            while let Some(segment) = next() {
                let number = segment.number;
                if sender.send((number, segment.roll(&loaded, &stop, &done))).is_err() {
                    break;
                }
            }
        };
        thread::scope(|scope| {
            for _ in 0..workers {
                let (sender, work) = (sender.clone(), &work);
                scope.spawn(move || {
                    // A pool of its own: a thread that waits for another one begins no further segment.
                    match rayon::ThreadPoolBuilder::new().num_threads(threads / workers).build() {
                        Ok(pool) => pool.install(|| work(sender)),
                        Err(_) => work(sender),
                    }
                });
            }
            drop(sender);
            let (mut early, mut next, mut outcome) = (BTreeMap::new(), 0, Ok(()));
            loop {
                match receiver.recv_timeout(LOOK) {
                    Ok((number, Ok(rolled))) => {
                        early.insert(number, rolled);
                    }
                    Ok((_, Err(error))) => outcome = outcome.and(Err(error)),
                    Err(RecvTimeoutError::Timeout) => job.progress.step(done.load(Ordering::Relaxed)),
                    Err(RecvTimeoutError::Disconnected) => break outcome,
                }
                while let Some(rolled) = early.remove(&next) {
                    outcome = outcome.and(self.join(rolled));
                    next += 1;
                }
                if outcome.is_err() || job.is_stopped() {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        })
    }

    /// Takes the next segment.
    fn join(&mut self, rolled: Rolled) -> Result<(), RunError> {
        let Self { plan, next_step, prepared, observers, meter, .. } = self;
        let first = (*next_step).max(plan.warm_up_steps);
        let end = first + rolled.steps.len() as u64;
        // 1. Work, all done in the background; steps of warm-ups and overlaps, which the run does not count itself.
        meter.count(Counter::Steps, rolled.all - (end - *next_step));
        meter.count(Counter::Slices, rolled.meter.counters().counts[Counter::Slices as usize]);
        for stage in Stage::ALL {
            let cost = rolled.meter.cost(stage);
            meter.add_background(stage, cost.spent.wall + cost.background);
            meter.add_work(stage, cost.work);
        }
        prepared.march.join(&rolled.totals, &rolled.searches);
        if let Some(last) = rolled.steps.last() {
            let indentation = last.indentation + plan.decisions.growth;
            prepared.axle = AxleHeight::Fixed { indentation, ramp: 0.0 };
        }
        // 2. Observers, by their own in the segment or by the totals of its steps.
        let mut own: BTreeMap<_, _> = rolled.observers.into_iter().collect();
        for (name, observer) in observers {
            if let Some(segment) = own.remove(name) {
                observer.join(segment, meter);
                continue;
            }
            for (number, totals) in (first..).zip(&rolled.steps) {
                let StepTotals { total_force, contact_length, indentation, power } = *totals;
                let step = Step {
                    number,
                    time: number as f64 * plan.time_step,
                    counts: true,
                    indentation,
                    total_force,
                    power,
                    contact_length,
                    point_size: prepared.contact.point_size,
                    footprint: prepared.march.footprint(),
                    geometry: prepared.march.geometry(),
                };
                observer.observe(&step, meter)?;
            }
        }
        *next_step = end;
        Ok(())
    }
}
