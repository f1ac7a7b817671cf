//! When what happened in a run.
//!
//! 1. Two rows: the run's own thread, and what is made behind it.
//! 2. Outside of the steps every stage is a span of its own. Steps are bundled into blocks: within a block's span the
//!    time of each stage is one span, laid end to end from the block's begin.
//! 3. Spans nest: run, phase, (block of steps,) stage. All room is taken when the steps begin; what finds none later is
//!    not noted, and counted.
//!
//! Beside the spans stands the time of every stage by phase: exact, however many spans there was room for.

use std::time::{Duration, Instant};

use super::stage::{Phase, Stage};

/// Blocks that the steps are bundled into, at most.
const MOST_BLOCKS: u64 = 1000;
/// Steps of a block at least.
const SHORTEST_BLOCK: u64 = 64;
/// Spans outside of the steps that there is room for.
const OUTSIDE: usize = 4000;
/// Spans of the row behind.
const BEHIND: usize = 20_000;

/// Row of a timeline: the thread that did the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Row {
    /// The run's own thread.
    March,
    /// A background thread.
    Behind,
}

/// Kind of a span.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// The whole run.
    Run,
    /// A phase of it.
    Phase(Phase),
    /// Steps, the first and the one after the last.
    Steps(u64, u64),
    /// A stage.
    Stage(Stage),
}

/// A span of time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    /// Row of the timeline.
    pub row: Row,
    /// Kind of the span.
    pub what: What,
    /// When it began, since the run did.
    pub begin: Duration,
    /// How long it took.
    pub length: Duration,
}

/// All that was noted.
#[derive(Clone, Debug)]
pub struct Trace {
    began: Instant,
    spans: Vec<Span>,
    /// Spans that found no room.
    dropped: u64,
    phase: Phase,
    phase_began: Instant,
    /// Time of every phase so far.
    phases: [Duration; Phase::ALL.len()],
    /// Time of every stage in every phase, on the run's own thread.
    staged: [[Duration; Stage::ALL.len()]; Phase::ALL.len()],
    /// End of the last block of steps: time, step, time of the stages until then, steps of a block.
    block_began: Instant,
    block_first: u64,
    block_staged: [Duration; Stage::ALL.len()],
    block_steps: u64,
    behind: usize,
    /// Time of the whole run, once it has ended.
    wall: Duration,
}

impl Default for Trace {
    fn default() -> Self {
        let now = Instant::now();
        Self {
            began: now,
            spans: Vec::with_capacity(OUTSIDE),
            dropped: 0,
            phase: Phase::Prepare,
            phase_began: now,
            phases: [Duration::ZERO; Phase::ALL.len()],
            staged: [[Duration::ZERO; Stage::ALL.len()]; Phase::ALL.len()],
            block_began: now,
            block_first: 0,
            block_staged: [Duration::ZERO; Stage::ALL.len()],
            block_steps: SHORTEST_BLOCK,
            behind: 0,
            wall: Duration::ZERO,
        }
    }
}

impl Trace {
    /// Returns the phase under way.
    pub(crate) fn phase(&self) -> Phase {
        self.phase
    }

    /// Makes room for the steps `first..end`, before the first of them.
    pub fn expect_steps(&mut self, first: u64, end: u64) {
        let steps = end.saturating_sub(first);
        self.block_steps = steps.div_ceil(MOST_BLOCKS).max(SHORTEST_BLOCK).next_multiple_of(SHORTEST_BLOCK);
        self.block_first = first;
        let blocks = (steps / self.block_steps + 2) as usize;
        self.spans.reserve_exact(OUTSIDE + BEHIND + blocks * (1 + Stage::ALL.len()));
    }

    /// Tells whether a block of steps ends before `step`.
    pub(crate) fn ends_block(&self, step: u64) -> bool {
        step >= self.block_first + self.block_steps
    }

    /// Ends the phase under way and enters another.
    pub(crate) fn enter(&mut self, phase: Phase) {
        let now = Instant::now();
        self.end_phase(now);
        (self.phase, self.phase_began) = (phase, now);
        self.block_began = now;
        self.block_staged = self.staged[phase as usize];
    }

    /// Returns the beginning of the run.
    pub(crate) fn began(&self) -> Instant {
        self.began
    }

    /// Ends the run at a moment; returns its time.
    pub(crate) fn end(&mut self, now: Instant) -> Duration {
        self.end_phase(now);
        self.phase_began = now;
        self.wall = now - self.began;
        self.push(Row::March, What::Run, self.began, self.wall);
        self.wall
    }

    fn end_phase(&mut self, now: Instant) {
        let length = now - self.phase_began;
        self.phases[self.phase as usize] += length;
        self.push(Row::March, What::Phase(self.phase), self.phase_began, length);
    }

    /// Adds to the time of a stage in the phase under way.
    pub(super) fn add_staged(&mut self, stage: Stage, wall: Duration) {
        self.staged[self.phase as usize][stage as usize] += wall;
    }

    /// Notes a stage outside of the steps.
    pub(super) fn add_stage(&mut self, stage: Stage, began: Instant, length: Duration) {
        self.push(Row::March, What::Stage(stage), began, length);
    }

    /// Notes a stage in the background.
    pub(super) fn add_background(&mut self, stage: Stage, began: Instant, length: Duration) {
        self.behind += 1;
        if self.behind > BEHIND {
            self.dropped += 1;
        } else {
            self.push(Row::Behind, What::Stage(stage), began, length);
        }
    }

    /// Notes the steps from the last block's end to `step`, and the stages within them.
    pub(crate) fn end_block(&mut self, step: u64) {
        if step == self.block_first {
            return;
        }
        let now = Instant::now();
        self.push(Row::March, What::Steps(self.block_first, step), self.block_began, now - self.block_began);
        let staged = self.staged[self.phase as usize];
        let mut began = self.block_began;
        for stage in Stage::ALL {
            let taken = staged[stage as usize] - self.block_staged[stage as usize];
            if !taken.is_zero() {
                self.push(Row::March, What::Stage(stage), began, taken);
                began += taken;
            }
        }
        (self.block_began, self.block_first, self.block_staged) = (now, step, staged);
    }

    fn push(&mut self, row: Row, what: What, began: Instant, length: Duration) {
        if self.spans.len() < self.spans.capacity() {
            self.spans.push(Span { row, what, begin: began.saturating_duration_since(self.began), length });
        } else {
            self.dropped += 1;
        }
    }

    /// Returns all spans, in the order in which they ended.
    pub(crate) fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// Returns the number of its spans.
    pub fn span_count(&self) -> usize {
        self.spans.len()
    }

    /// Returns the spans that found no room.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Returns the time of the whole run; zero before it has ended.
    pub(crate) fn wall(&self) -> Duration {
        self.wall
    }

    /// Returns the time of a phase.
    pub(crate) fn phase_time(&self, phase: Phase) -> Duration {
        self.phases[phase as usize]
    }

    /// Returns the time of a stage in a phase, on the run's own thread.
    pub(crate) fn stage_time(&self, phase: Phase, stage: Stage) -> Duration {
        self.staged[phase as usize][stage as usize]
    }
}
