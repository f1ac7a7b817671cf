//! The meter of a run: it counts, and reads the clocks as closely as its watch says.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::clock::{Clock, CpuClock, Spent};
use super::cost::{Allocations, StageCost, Work};
use super::process;
use super::stage::{Counter, Phase, Stage};
use super::trace::Trace;
use super::watch::{BLOCK, BLOCKS, Timing, WATCHED_EVERY, Watch};

/// Cost of a run so far, as plain numbers.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(crate) struct Counters {
    /// By [`Stage`]; without the steps since they were last settled.
    pub stages: [StageCost; Stage::ALL.len()],
    /// By [`Counter`].
    pub counts: [u64; Counter::ALL.len()],
    /// Time of stages in the timed steps since the last settlement, by [`Stage`].
    pub in_steps: [Spent; Stage::ALL.len()],
    /// How many steps were timed since the last settlement.
    pub timed_steps: u64,
    /// All steps together, with the processor time of all threads.
    pub steps: Spent,
}

/// Counters of one run and the clocks that fill them: handed down by `&mut` to whatever is counted and timed. Its size
/// is fixed: metering within the steps never allocates.
#[derive(Clone, Debug, Default)]
pub struct Meter {
    counters: Counters,
    watch: Watch,
    steps_clock: Option<Clock>,
    /// True if the current step is timed, and if its processor time is read.
    timed: bool,
    watched: bool,
    /// All stages on the run's thread so far: its growth during a stage is the time of stages nested in it.
    staged: Spent,
    staged_allocations: Allocations,
    trace: Option<Box<Trace>>,
}

/// A stage that has begun outside of the steps, see [`Meter::open`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Open {
    clock: Clock,
    allocations: Option<Allocations>,
    staged: Spent,
    staged_allocations: Allocations,
}

/// Successive stages of a step, see [`Meter::laps`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Laps {
    clock: Option<Clock>,
    staged: Spent,
}

impl Meter {
    /// A meter of nothing so far; it records a timeline only if every step is timed.
    pub fn new(watch: Watch) -> Self {
        let trace = (watch.timing == Timing::Every && watch.trace).then(Box::default);
        Self { watch, trace, ..Self::default() }
    }

    pub(crate) fn timing(&self) -> Timing {
        self.watch.timing
    }

    pub(crate) fn set_timing(&mut self, timing: Timing) {
        self.watch.timing = timing;
    }

    /// True if processor time and memory are read.
    pub(crate) fn watches_closely(&self) -> bool {
        matches!(self.watch.timing, Timing::Closely | Timing::Every)
    }

    /// Runs `work` as (part of) a stage, outside of the steps or rarely within them.
    pub(crate) fn time<T>(&mut self, stage: Stage, work: impl FnOnce() -> T) -> T {
        let open = self.open();
        let result = work();
        self.close(open, stage);
        result
    }

    /// Begins (part of) a stage that is not known yet, or that has other stages within it.
    pub(crate) fn open(&self) -> Open {
        let closely = self.watches_closely();
        Open {
            allocations: self.watch.allocations.filter(|_| closely).map(|probe| probe()),
            staged: self.staged,
            staged_allocations: self.staged_allocations,
            clock: Clock::start(closely.then_some(process::cpu_time)),
        }
    }

    /// Ends it: the time since it was opened that no nested stage has taken is charged to this stage.
    pub(crate) fn close(&mut self, open: Open, stage: Stage) {
        self.close_shared(open, &[(stage, 1.0)]);
    }

    /// Closes stages as [`Self::close`] that went on together, or in turns too short to be timed: each gets its share
    /// of the time (0 to 1), and the last one the memory.
    pub(crate) fn close_shared(&mut self, mut open: Open, shares: &[(Stage, f64)]) {
        let mut began = open.clock.began;
        let spent = open.clock.lap();
        let elapsed = spent.wall;
        let spent = spent - (self.staged - open.staged);
        let mut allocations = open.allocations.zip(self.watch.allocations).map(|(before, probe)| probe() - before);
        if let Some(allocations) = &mut allocations {
            *allocations = *allocations - (self.staged_allocations - open.staged_allocations);
            self.staged_allocations += *allocations;
        }
        self.staged += spent;
        let among_steps = self.trace.as_ref().is_some_and(|trace| trace.phase == Phase::Contact);
        // Reading the peak means parsing a text of the system: too slow among the steps.
        let is_due = self.watches_closely() && self.counters.timed_steps == 0;
        let peak_memory = if is_due { process::peak_memory() } else { None };
        for (index, &(stage, share)) in shares.iter().enumerate() {
            let spent = if shares.len() > 1 { spent.share(share) } else { spent };
            let last = index + 1 == shares.len();
            self.counters.stages[stage as usize].add(&StageCost {
                calls: 1,
                spent,
                watched_all: spent.watched,
                peak_memory,
                allocations: allocations.filter(|_| last),
                ..StageCost::default()
            });
            let span = elapsed.mul_f64(share);
            if let Some(trace) = &mut self.trace {
                trace.add_staged(stage, spent.wall);
                if !among_steps {
                    trace.add_stage(stage, began, span);
                }
            }
            began += span;
        }
    }

    /// Begins step number `step` of the run and decides whether it is timed.
    pub fn begin_step(&mut self, step: u64) {
        let block = step / BLOCK;
        self.timed = match self.watch.timing {
            Timing::Outside => false,
            Timing::Sampled => block.is_multiple_of(BLOCKS),
            Timing::Closely => block.is_multiple_of(2),
            Timing::Every => true,
        };
        self.watched = self.timed && self.watches_closely() && step.is_multiple_of(WATCHED_EVERY);
        self.counters.timed_steps += u64::from(self.timed);
    }

    /// Clock of processor time in the current step; most steps have none.
    pub(crate) fn cpu_clock(&self) -> Option<CpuClock> {
        self.watched.then_some(process::thread_cpu_time)
    }

    /// Begins stages of the current step; in a step that is not timed no clock is read.
    pub(crate) fn laps(&self) -> Laps {
        Laps { clock: self.timed.then(|| Clock::start(self.cpu_clock())), staged: self.staged }
    }

    /// Ends a call of a stage, and begins the next: the time since the last one ended that no nested stage has taken is
    /// charged to this stage.
    pub(crate) fn lap(&mut self, laps: &mut Laps, stage: Stage) {
        self.counters.stages[stage as usize].calls += 1;
        if let Some(clock) = &mut laps.clock {
            let spent = clock.lap() - (self.staged - laps.staged);
            self.add_in_steps(stage, spent);
            laps.staged = self.staged;
        }
    }

    /// Adds the time that a stage took within another in the current step, known from other clocks, as one call.
    pub(crate) fn lap_within(&mut self, stage: Stage, spent: Spent) {
        self.counters.stages[stage as usize].calls += 1;
        if self.timed {
            self.add_in_steps(stage, spent);
        }
    }

    /// Runs `work` as (part of) a stage of the current step.
    pub(crate) fn time_in_step<T>(&mut self, stage: Stage, work: impl FnOnce() -> T) -> T {
        let mut laps = self.laps();
        let result = work();
        self.lap(&mut laps, stage);
        result
    }

    /// Adds the time that a stage took in timed steps; it is extrapolated to all steps when they are settled.
    pub fn add_in_steps(&mut self, stage: Stage, spent: Spent) {
        self.counters.in_steps[stage as usize] += spent;
        self.staged += spent;
        if let Some(trace) = &mut self.trace {
            trace.add_staged(stage, spent.wall);
        }
    }

    /// Settles `steps` steps: the timed ones are taken as representative of all.
    pub(crate) fn settle_steps(&mut self, steps: u64) {
        let Counters { stages, in_steps, timed_steps, .. } = &mut self.counters;
        let factor = steps as f64 / (*timed_steps).max(1) as f64;
        for (cost, spent) in stages.iter_mut().zip(in_steps) {
            cost.spent += std::mem::take(spent).extrapolated(factor);
        }
        *timed_steps = 0;
    }

    /// Adds one call of a stage that was timed elsewhere.
    pub(crate) fn add_time(&mut self, stage: Stage, wall: Duration) {
        self.staged.wall += wall;
        let cost = &mut self.counters.stages[stage as usize];
        cost.calls += 1;
        cost.spent.wall += wall;
        if let Some(trace) = &mut self.trace {
            trace.add_staged(stage, wall);
        }
    }

    /// Adds time that a stage worked in the background.
    pub(crate) fn add_background(&mut self, stage: Stage, busy: Duration) {
        self.counters.stages[stage as usize].background += busy;
    }

    /// Adds time as [`Self::add_background`], as one call that began at a given instant.
    pub(crate) fn add_background_since(&mut self, stage: Stage, began: Instant, busy: Duration) {
        self.add_background(stage, busy);
        self.counters.stages[stage as usize].calls += 1;
        if let Some(trace) = &mut self.trace {
            trace.add_background(stage, began, busy);
        }
    }

    /// Adds arithmetic and memory traffic of a stage.
    pub(crate) fn add_work(&mut self, stage: Stage, work: Work) {
        self.counters.stages[stage as usize].work += work;
    }

    pub(crate) fn count(&mut self, counter: Counter, amount: u64) {
        self.counters.counts[counter as usize] += amount;
    }

    /// Cost of a stage so far, without the steps since the last settlement.
    pub fn cost(&self, stage: Stage) -> StageCost {
        self.counters.stages[stage as usize]
    }

    /// The cost as [`Self::cost`], the parts of the stage included.
    pub(crate) fn whole(&self, stage: Stage) -> StageCost {
        let mut whole = self.cost(stage);
        for part in Stage::ALL.into_iter().filter(|part| part.part_of() == Some(stage)) {
            whole.add(&self.cost(part));
        }
        whole
    }

    /// The counter's value so far.
    pub fn counted(&self, counter: Counter) -> u64 {
        self.counters.counts[counter as usize]
    }

    /// All that was counted and timed so far, the current phase of steps included.
    pub(crate) fn counters(&self) -> Counters {
        Counters { steps: self.steps(), ..self.counters }
    }

    /// Continues an earlier part of the same run: its times are added to the present ones, its counts replace them.
    pub(crate) fn resume(&mut self, earlier: &Counters) {
        let counters = &mut self.counters;
        counters.stages.iter_mut().zip(&earlier.stages).for_each(|(stage, earlier)| stage.add(earlier));
        counters.in_steps.iter_mut().zip(earlier.in_steps).for_each(|(spent, earlier)| *spent += earlier);
        counters.counts = earlier.counts;
        counters.timed_steps += earlier.timed_steps;
        counters.steps += earlier.steps;
    }

    /// Wall time of a stage so far on the run's thread, including the timed steps not yet settled.
    pub fn spent(&self, stage: Stage) -> Duration {
        self.cost(stage).spent.wall + self.counters.in_steps[stage as usize].wall
    }

    /// Time of all steps together so far, with the processor time of all threads.
    pub fn steps(&self) -> Spent {
        let mut steps = self.counters.steps;
        if let Some(mut clock) = self.steps_clock {
            steps += clock.lap();
        }
        steps
    }

    /// Enters another phase of the run; the clock of the steps runs in the contact phase only.
    pub fn enter(&mut self, phase: Phase) {
        self.counters.steps = self.steps();
        self.steps_clock = (phase == Phase::Contact).then(|| Clock::start(Some(process::cpu_time)));
        if let Some(trace) = &mut self.trace {
            trace.enter(phase);
        }
    }

    /// Notes that `steps` steps are done: where a block of them ends, the trace, if any, records it.
    pub fn end_step(&mut self, steps: u64) {
        if let Some(trace) = self.trace.as_mut().filter(|trace| trace.ends_block(steps)) {
            trace.end_block(steps);
        }
    }

    /// The timeline, if one is recorded.
    pub fn trace(&self) -> Option<&Trace> {
        self.trace.as_deref()
    }

    /// The timeline as [`Self::trace`], to be changed.
    pub fn trace_mut(&mut self) -> Option<&mut Trace> {
        self.trace.as_deref_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::super::cost::AllocationProbe;
    use super::*;

    #[test]
    fn blocks_that_are_timed_stand_for_all_steps() {
        let millisecond = Duration::from_millis(1);
        let spent = Spent { wall: millisecond, ..Spent::default() };
        for (timing, timed) in
            [(Timing::Outside, 0), (Timing::Sampled, 3 * BLOCK), (Timing::Closely, 20 * BLOCK), (Timing::Every, 2500)]
        {
            let mut meter = Meter::new(Watch { timing, ..Watch::default() });
            let mut clocked = 0;
            for step in 0..2500 {
                meter.begin_step(step);
                if meter.timed {
                    clocked += 1;
                    meter.add_in_steps(Stage::History, spent);
                }
            }
            assert_eq!(clocked, timed, "{timing:?}");
            // A whole call beside the steps is not extrapolated.
            meter.add_time(Stage::Output, 5 * millisecond);
            meter.settle_steps(2500);
            let expected = if timed > 0 { 2.5 } else { 0.0 };
            let found = meter.cost(Stage::History).spent.wall.as_secs_f64();
            assert!((found - expected).abs() < 1e-6, "{timing:?}: {found}");
            assert_eq!(meter.cost(Stage::Output).spent.wall, 5 * millisecond);
        }
    }

    #[test]
    fn the_whole_of_a_stage_has_its_parts() {
        let mut meter = Meter::default();
        for (stage, multiply_adds) in [(Stage::ActiveSet, 5), (Stage::Factorisation, 3), (Stage::History, 7)] {
            meter.add_time(stage, Duration::from_millis(multiply_adds));
            meter.add_work(stage, Work { multiply_adds, bytes: 0 });
        }
        let whole = meter.whole(Stage::ActiveSet);
        assert_eq!((whole.work.multiply_adds, whole.spent.wall), (8, Duration::from_millis(8)));
        assert_eq!(meter.whole(Stage::History), meter.cost(Stage::History));
    }

    #[test]
    fn a_stage_within_another_is_counted_separately() {
        let mut meter = Meter::new(Watch::CLOSELY);
        let begin = Instant::now();
        let open = meter.open();
        let inner = meter.open();
        while inner.clock.began.elapsed() < Duration::from_millis(4) {}
        meter.close(inner, Stage::Output);
        let after = Instant::now();
        while after.elapsed() < Duration::from_millis(2) {}
        meter.close_shared(open, &[(Stage::Influence, 0.25), (Stage::Fit, 0.75)]);
        let all = begin.elapsed();
        let wall = |stage| meter.cost(stage).spent.wall;
        assert!(wall(Stage::Output) >= Duration::from_millis(4));
        let outer = wall(Stage::Influence) + wall(Stage::Fit);
        assert!(outer + wall(Stage::Output) <= all && outer >= Duration::from_millis(1), "{outer:?} of {all:?}");
        let ratio = wall(Stage::Fit).as_secs_f64() / wall(Stage::Influence).as_secs_f64();
        assert!((ratio - 3.0).abs() < 1e-3, "{ratio}");
        // Processor time and peak memory are there where the system reports them.
        let cost = meter.cost(Stage::Output);
        assert_eq!(cost.spent.cpu_seconds().is_some(), process::cpu_time().is_some());
        assert_eq!(cost.peak_memory.is_some(), process::peak_memory().is_some());
        assert_eq!(cost.allocations, None);
    }

    #[test]
    fn memory_asked_for_in_a_stage_is_counted_once() {
        // A probe that finds one allocation of 10 bytes more whenever it is asked.
        static COUNT: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
        let probe: AllocationProbe = || {
            let count = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            Allocations { count, bytes: 10 * count }
        };
        let mut meter = Meter::new(Watch { allocations: Some(probe), ..Watch::CLOSELY });
        let open = meter.open();
        meter.time(Stage::Output, || ());
        meter.close(open, Stage::Response);
        // Asked at 0, 1, 2 and 3: one within the inner stage, two more within the outer.
        assert_eq!(meter.cost(Stage::Output).allocations, Some(Allocations { count: 1, bytes: 10 }));
        assert_eq!(meter.cost(Stage::Response).allocations, Some(Allocations { count: 2, bytes: 20 }));
        let mut light = Meter::new(Watch { allocations: Some(probe), ..Watch::default() });
        light.time(Stage::Output, || ());
        assert_eq!(
            (light.cost(Stage::Output).allocations, COUNT.load(std::sync::atomic::Ordering::Relaxed)),
            (None, 4)
        );
    }
}
