//! How closely a run is watched.

use super::cost::AllocationProbe;

/// Steps that are timed one after the other where not all are: whole blocks of the history.
pub(crate) const BLOCK: u64 = 64;
/// Blocks of which one is timed.
pub(crate) const BLOCKS: u64 = 16;
/// Steps of which one has its processor time read, if it is timed at all; prime, so that every step of the history's
/// blocks has its turn.
pub(crate) const WATCHED_EVERY: u64 = 251;

/// How closely stages are timed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// No clock is read within the steps: what the other ways are measured against.
    Outside,
    /// One block of 64 steps in 16 stands for the others.
    #[default]
    Sampled,
    /// Every second block of steps; processor time and memory are looked at, too.
    Closely,
    /// As closely, but every step.
    Every,
}

impl Timing {
    /// Returns the share of the steps that are timed.
    pub const fn share_of_steps(self) -> f64 {
        match self {
            Self::Outside => 0.0,
            Self::Sampled => 1.0 / BLOCKS as f64,
            Self::Closely => 0.5,
            Self::Every => 1.0,
        }
    }
}

/// How closely a run is watched.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    /// How closely stages are timed.
    pub timing: Timing,
    /// Records a timeline; only where every step is timed.
    pub trace: bool,
    /// Counts of the program's allocator.
    pub allocations: Option<AllocationProbe>,
}

impl Watch {
    /// Closely, without a trace.
    pub const CLOSELY: Self = Self { timing: Timing::Closely, trace: false, allocations: None };
    /// Every step, without a trace.
    pub const EVERY: Self = Self { timing: Timing::Every, trace: false, allocations: None };
}
