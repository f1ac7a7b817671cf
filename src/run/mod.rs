//! From a plan to results: the only place that knows the whole sequence.
//!
//! 1. `prepare`: tyre -> road -> contact, ready to take the first step; `cells` (with tangential forces `friction`) or
//!    `slices` make the contact, `history` the history of slices, `road` opens the road;
//! 2. `simulation`: step by step, over a road that is made ahead of its use; effects observe each step;
//! 3. `meshes`: short runs over two meshes that correct the levels, where a scene wants those of the finer one;
//! 4. `to_folder` and `in_memory`: the same with arrays, tables, pictures and summary, `end` after the last step;
//!    `checkpoint` lets a folder's run continue after a stop.

mod cells;
pub(crate) mod checkpoint;
pub(crate) mod end;
mod friction;
pub(crate) mod history;
pub(crate) mod in_memory;
pub(crate) mod meshes;
pub(crate) mod prepare;
pub(crate) mod road;
mod section_table;
pub(crate) mod simulation;
pub(crate) mod slices;
pub(crate) mod to_folder;
mod zone_maker;

#[cfg(test)]
mod tests;

pub use crate::contact::error::ContactError;
pub use crate::contact::footprint::Footprint;
pub use crate::contact::geometry::Geometry;
pub use crate::contact::march::StepResult;
pub use crate::counters::{Job, Progress, Unwatched};
pub use crate::effects::RunError;
pub use crate::effects::channel::{ArrayNumbers, KeptArray};
pub use crate::effects::sound::SoundResults;
pub use crate::effects::vibration::results::VibrationResults;
pub use crate::storage::state::StateError;
pub use in_memory::{RunInMemory, run_in_memory};
pub use simulation::{Results, Simulation};
pub use to_folder::{RunOptions, RunReport, resume, run};
