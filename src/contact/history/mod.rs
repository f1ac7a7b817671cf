//! Displacement left over from past forces.
//!
//! - [`direct`]: the convolution sum in the contact frame, over a memory of stated length: the reference;
//! - [`modes`]: one recursion per pole of the rational model: exact for the time rule, without a memory to choose;
//! - `far`: the pass over all of them, `behind` the march where there is another thread;
//! - [`recursion`]: that recursion for one pole and each time rule;
//! - [`scaled`]: another history with its influence functions scaled;
//! - `state`: what evolves of a history;
//! - `wavenumber_group`: the poles of neighbouring wavenumbers, side by side in vectors;
//! - [`transfer`]: the transfer function that such a recursion is.
//!
//! A third way, convolution by FFT in partitions (Gardner 1995, *J. Audio Eng. Soc.* 43, 127), has been weighed and is
//! not built, because it wins nowhere. In wavenumber space, with two partitions each of B = 16, 32, ... instants, it
//! takes sum over B of (20 log2(2B) + 32) flops and 256 bytes for each wavenumber and instant, and what [`modes`] does
//! within its blocks besides. For N = 1024 and the default tyre at 80 km/h, per step, transforms over the elements left
//! out on both sides:
//!
//! | way | memory | flops | bytes | left out of H_n |
//! |---|---|---|---|---|
//! | partitions, counted | 1024 lags | 0.44 M | 0.66 MB | more than 1e-2 |
//! | partitions, counted | 4096 lags | 0.69 M | 0.92 MB | 1.2e-2 |
//! | partitions, counted | 16384 lags | 0.98 M | 1.2 MB | 4e-6 |
//! | poles, from a run | all | 0.55 M | 0.72 MB | 1e-5, the fit's tolerance |
//! | direct, from a run | 8192 lags | 150 M | | |
//!
//! Only where a memory of less than about 0.1 s would do are its flops fewer, and its weights need the sums over
//! wavenumbers that the fit avoids.

mod behind;
pub mod direct;
mod far;
pub mod modes;
pub mod recursion;
pub mod scaled;
mod state;
pub mod transfer;
mod wavenumber_group;

pub use direct::DirectHistory;
pub use modes::ModalHistory;
pub use scaled::ScaledHistory;
pub use state::HistoryState;

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::counters::{Clocks, Spent, Work};
use crate::storage::StateError;

/// What a history has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct HistoryWork {
    /// Sums and recursions.
    pub sums: Work,
    /// Transforms between elements and wavenumbers.
    pub transforms: Work,
    /// Times that transforms were gone through.
    pub passes: u64,
    /// Not a part of the state.
    #[serde(skip)]
    pub times: HistoryTimes,
}

/// Times that a history knows of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HistoryTimes {
    /// The transforms where the march waited for them, where clocks are read.
    pub transforms: Spent,
    /// Sums and transforms behind the march, whether clocks are read or not.
    pub behind: [Spent; 2],
}

impl AddAssign for HistoryWork {
    fn add_assign(&mut self, other: Self) {
        self.sums += other.sums;
        self.transforms += other.transforms;
        self.passes += other.passes;
        self.times += other.times;
    }
}

impl AddAssign for HistoryTimes {
    fn add_assign(&mut self, other: Self) {
        self.transforms += other.transforms;
        for (time, other) in self.behind.iter_mut().zip(other.behind) {
            *time += other;
        }
    }
}

/// A way to carry the past along.
pub trait PastForces: Send {
    /// u_old \[m\] at the step about to be done, for the elements from `first_element` on, into `out`; returns the work
    /// it took. Called once a stage of a step.
    fn displacement(&mut self, first_element: i64, out: &mut [f64]) -> HistoryWork;

    /// Takes note of the stage's forces \[N\], from element `first_element` on.
    fn push(&mut self, first_element: i64, forces: &[f64]);

    /// Which clocks are read from now on; none at first.
    fn set_clocks(&mut self, _clocks: Clocks) {}

    /// Takes the state down; the same for any number of threads.
    fn save(&self) -> HistoryState;

    /// Goes on from the state of an equal history, on any number of threads.
    ///
    /// # Errors
    /// [`StateError`].
    fn restore(&mut self, state: HistoryState) -> Result<(), StateError>;
}
