//! Timeline of a run: when it did what.
//!
//! 1. Two rows: the run's thread, and background work.
//! 2. Outside of the steps every stage is one span. Steps are bundled into blocks: within a block's span the time of
//!    each stage is one span, laid end to end from the begin of the block.
//! 3. Spans nest: run, phase, (block of steps,) stage. All memory is reserved when the steps begin; spans that find no
//!    room later are not recorded, but counted.
//!
//! The time of every stage by phase is stored beside the spans: exact, however many spans fit.

use std::time::{Duration, Instant};

use super::stage::{Phase, Stage};

/// Most blocks that the steps are bundled into.
const MOST_BLOCKS: u64 = 1000;
/// Fewest steps of a block.
const SHORTEST_BLOCK: u64 = 64;
/// Room for spans outside of the steps.
const OUTSIDE: usize = 4000;
/// Room for spans of background work.
const BACKGROUND: usize = 20_000;

/// Row of a timeline: the thread that did the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Row {
    /// The run's thread.
    March,
    /// A background thread.
    Background,
}

/// Kind of a span.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// The whole run.
    Run,
    /// A phase of the run.
    Phase(Phase),
    /// A block of steps: the first, and the one after the last.
    Steps(u64, u64),
    /// A stage, or all its calls in a block of steps.
    Stage(Stage),
}

/// A span of time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    /// Row of the timeline.
    pub row: Row,
    /// Kind of the span.
    pub what: What,
    /// When it began, since the begin of the run.
    pub begin: Duration,
    /// How long it took.
    pub length: Duration,
}

/// Recorded spans of a run, and times by stage and phase.
#[derive(Clone, Debug)]
pub struct Trace {
    pub(crate) began: Instant,
    /// All spans, in the order in which they ended.
    pub(crate) spans: Vec<Span>,
    /// Spans that did not fit.
    dropped: u64,
    pub(crate) phase: Phase,
    phase_began: Instant,
    /// Time in each phase so far.
    phases: [Duration; Phase::ALL.len()],
    /// Time of every stage in every phase, on the run's thread.
    staged: [[Duration; Stage::ALL.len()]; Phase::ALL.len()],
    /// At the end of the last block of steps: instant, step, times of the stages; then the steps of a block.
    block_began: Instant,
    block_first: u64,
    block_staged: [Duration; Stage::ALL.len()],
    block_steps: u64,
    background: usize,
    /// Time of the whole run; zero before it has ended.
    pub(crate) wall: Duration,
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
            background: 0,
            wall: Duration::ZERO,
        }
    }
}

impl Trace {
    /// Reserves room for the steps `first..end`, before the first of them, and sets the length of their blocks.
    pub fn expect_steps(&mut self, first: u64, end: u64) {
        let steps = end.saturating_sub(first);
        self.block_steps = steps.div_ceil(MOST_BLOCKS).max(SHORTEST_BLOCK).next_multiple_of(SHORTEST_BLOCK);
        self.block_first = first;
        let blocks = (steps / self.block_steps + 2) as usize;
        self.spans.reserve_exact(OUTSIDE + BACKGROUND + blocks * (1 + Stage::ALL.len()));
    }

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

    /// Ends the run at a moment; returns its whole time.
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

    /// Adds to the time of a stage in the current phase.
    pub(super) fn add_staged(&mut self, stage: Stage, wall: Duration) {
        self.staged[self.phase as usize][stage as usize] += wall;
    }

    /// Records a stage outside of the steps.
    pub(super) fn add_stage(&mut self, stage: Stage, began: Instant, length: Duration) {
        self.push(Row::March, What::Stage(stage), began, length);
    }

    pub(super) fn add_background(&mut self, stage: Stage, began: Instant, length: Duration) {
        self.background += 1;
        if self.background > BACKGROUND {
            self.dropped += 1;
        } else {
            self.push(Row::Background, What::Stage(stage), began, length);
        }
    }

    /// Records the steps from the end of the last block to `step`, and the stages within them.
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

    /// Number of recorded spans.
    pub fn span_count(&self) -> usize {
        self.spans.len()
    }

    /// Number of spans for which there was no room.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    pub(crate) fn phase_time(&self, phase: Phase) -> Duration {
        self.phases[phase as usize]
    }

    /// Time of a stage in a phase, on the run's thread.
    pub(crate) fn stage_time(&self, phase: Phase, stage: Stage) -> Duration {
        self.staged[phase as usize][stage as usize]
    }
}
