//! Cost of a run: time and calls per stage, exact work counters.
//!
//! Stages are timed, kernels are counted. Counters are exact and independent of the machine and of the number of
//! threads; times are neither.
//!
//! How closely is set by a [`Watch`]:
//!
//! - by default every stage outside of the time steps is timed, and of the steps one block of 64 in 16, taken as
//!   representative of the others. The rare long work within the steps (road made there, segments of the vibration
//!   completed, checkpoints) is timed whenever it comes;
//! - [closely](Timing::Closely), every second block of steps is timed. Outside of the steps a stage also has its
//!   processor time, the memory it allocated (where the program's allocator counts), and the peak of the resident
//!   memory at its end; within them processor time, a system call, is read in one step of 251, if that is timed, and
//!   represents the others. There it is that of the run's thread; that of all threads, and with it their idle share, is
//!   known for all steps together;
//! - for a trace, [every](Timing::Every) step is timed, and the time at which things happened is recorded.
//!
//! A clock read takes 23 ns; a step at N = 512 that is timed has about six. Measured on the default scene with a smooth
//! road, where a step is shortest (test `overhead` of `tests/suite/profile.rs`, one thread of a two-core AMD EPYC),
//! against steps without any clock read:
//!
//! | N | a step | sampled | closely | every |
//! |---|---|---|---|---|
//! | 512 | 10.3 us | 0 ns | 15 ns, 0.15 % | 48 ns, 0.47 % |
//! | 1024 | 21.3 us | 14 ns, 0.06 % | 90 ns, 0.42 % | 177 ns, 0.83 % |

mod amounts;
pub(crate) mod catalogue;
pub(crate) mod clock;
mod cost;
mod meter;
pub(crate) mod peak;
pub(crate) mod process;
mod progress;
mod stage;
pub(crate) mod trace;
pub(crate) mod watch;

pub use clock::Spent;
pub(crate) use clock::{Clock, CpuClock};
pub(crate) use cost::{AllocationProbe, idle_share};
pub use cost::{Allocations, StageCost, Work};
pub(crate) use meter::Counters;
pub use meter::Meter;
pub(crate) use peak::MachinePeak;
pub use progress::{Job, Progress, Unwatched};
pub use stage::{Counter, Phase, Stage};
pub use trace::Trace;
pub use watch::{Timing, Watch};
