//! One scene at many speeds, loads and roads.
//!
//! 1. [`mod@variants`]: the scenes, checked before anything runs;
//! 2. [`mod@run`]: what is finished is left alone, what was interrupted goes on, the rest is run, several at a time;
//! 3. [`table`]: levels side by side, and how they grow with the speed;
//! 4. [`tasks`]: the same as tasks in a folder, for batch systems.

pub mod run;
pub mod table;
pub mod tasks;
pub mod variants;

pub use run::{Done, Outcome, sweep};
pub use table::{SweepBlock, blocks};
pub use variants::{Axes, SweepError, Variant, variants};
