//! From a plan to results: the only place that knows the whole order.
//!
//! 1. [`prepare`]: tyre -> road -> contact, ready to take the first step; [`past`] makes what carries the past along,
//!    `cells` the whole contact where it is one of cells;
//! 2. [`in_memory`]: step by step, over a road that is made in time; [`record`]
//!    keeps what each step gave, with the power of [`rolling_resistance`], the motion that [`vibration`] follows and
//!    the [`sound`] that is heard of it;
//! 3. [`to_folder`]: the same with arrays, spectra, plots and summary in a folder, what is left to do at the end by
//!    `look_back`, told to a [`progress`]; [`checkpoint`] lets it go on where it was stopped.

mod cell_record;
mod cells;
pub mod checkpoint;
pub mod error;
pub mod in_memory;
pub(crate) mod look_back;
pub mod past;
pub mod prepare;
pub mod progress;
pub mod record;
pub mod rolling_resistance;
pub mod sound;
pub mod to_folder;
pub mod vibration;

pub use error::RunError;
pub use in_memory::{Results, Run};
pub use progress::{Progress, Unwatched};
pub use to_folder::{RunOptions, RunReport, resume, run};

use crate::plan::Plan;

/// Lists the results that a run of a plan will not give, known without running it: the user should act on them.
pub fn foreseen(plan: &Plan) -> Vec<String> {
    let mut warnings = plan.warnings();
    warnings.extend(sound::unheard(plan));
    warnings
}
