//! From a plan to results: the only place that knows the whole order.
//!
//! 1. [`prepare`]: tyre -> road -> contact, ready to take the first step;
//! 2. [`in_memory`]: step by step; [`to_folder`]: with arrays, spectra, plots and summary in a folder; [`checkpoint`]
//!    lets it go on where it was stopped.
//!
//! [`vibration`] follows the tyre's motion from the forces of a run that wants it.

pub mod checkpoint;
pub mod error;
pub mod in_memory;
mod look_back;
pub mod past;
pub mod prepare;
pub mod progress;
pub mod record;
pub mod road_ahead;
mod road_maker;
pub mod rolling_resistance;
pub mod to_folder;
pub mod vibration;

pub use error::RunError;
pub use in_memory::{Results, Run};
pub use progress::{Progress, Unwatched};
pub use to_folder::{RunOptions, RunReport, resume, run};
