//! Plan and run: the only place that knows the whole order.
//!
//! 1. [`plan`]: effects, sizes, work and memory of a scene, decided and checked before anything is allocated;
//! 2. [`prepare`]: tyre -> road -> contact, ready to take the first step;
//! 3. [`mod@run`]: step by step, in memory; [`to_folder`]: with arrays, spectra, plots and summary in a folder;
//!    [`checkpoint`] lets it go on where it was stopped;
//! 4. [`sweep`]: the same at many speeds, loads and roads.
//!
//! [`vibration`] follows the tyre's motion from the forces of a run that wants it. [`rules`] does the first two for
//! several time rules and compares them.

pub mod checkpoint;
pub mod compare;
pub mod error;
pub mod local_compliance;
pub mod past;
pub mod plan;
pub mod prepare;
pub mod progress;
pub mod record;
pub mod road_ahead;
mod road_maker;
pub mod rolling_resistance;
pub mod rules;
pub mod run;
pub mod study;
pub mod sweep;
pub mod to_folder;
pub mod trial;
pub mod vibration;
pub mod worth;

pub use error::RunError;
pub use plan::Plan;
pub use progress::{Progress, Unwatched};
pub use run::{Results, Run};
pub use to_folder::{RunOptions, RunReport, resume, resume_watched, run, run_watched};
