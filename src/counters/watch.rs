//! How closely a run is watched.

use super::cost::AllocationProbe;

/// Length of a timed block of steps where not all are timed: that of the history's blocks.
pub(crate) const BLOCK: u64 = 64;
/// One block of so many is timed.
pub(crate) const BLOCKS: u64 = 16;
/// One step of so many has its processor time read, if it is timed at all; prime, so that every place in the history's
/// blocks gets its turn.
pub(crate) const WATCHED_EVERY: u64 = 251;

/// How closely stages are timed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// No clock is read within the steps: the reference for the cost of timing.
    Outside,
    /// One block of 64 steps in 16 represents the others.
    #[default]
    Sampled,
    /// Every second block of steps; processor time and memory are read, too.
    Closely,
    /// As [`Self::Closely`], but every step.
    Every,
}

impl Timing {
    /// Share of the steps that are timed, 0 to 1.
    pub const fn share_of_steps(self) -> f64 {
        match self {
            Self::Outside => 0.0,
            Self::Sampled => 1.0 / BLOCKS as f64,
            Self::Closely => 0.5,
            Self::Every => 1.0,
        }
    }
}

/// Settings for what is measured of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    /// How closely stages are timed.
    pub timing: Timing,
    /// Records a timeline; only with [`Timing::Every`].
    pub trace: bool,
    /// Reads the counts of the program's allocator, if it counts.
    pub allocations: Option<AllocationProbe>,
}

impl Watch {
    /// Closely, without a trace.
    pub const CLOSELY: Self = Self { timing: Timing::Closely, trace: false, allocations: None };
    /// Every step, without a trace.
    pub const EVERY: Self = Self { timing: Timing::Every, trace: false, allocations: None };
}
