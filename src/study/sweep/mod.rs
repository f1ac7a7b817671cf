//! One scene at many speeds, loads, roads and settings.
//!
//! 1. [`factor`] and [`mod@design`]: what is varied, and which of its values are tried together;
//! 2. [`mod@variants`]: the scenes, checked before anything runs;
//! 3. [`mod@run`]: what is finished is left alone, what was interrupted goes on, the rest is run, several at a time;
//! 4. [`table`]: levels side by side, and how they grow with the speed; [`repeated`]: means over seeds, with their
//!    confidence, and pictures of what they depend on;
//! 5. [`tasks`]: the same as tasks in a folder, for batch systems.

pub mod design;
pub mod factor;
pub mod full_scale;
pub mod repeated;
pub mod run;
pub mod table;
pub mod tasks;
pub mod variants;

pub use design::Design;
pub use factor::{Factor, Range};
pub use full_scale::share_full_scale;
pub use repeated::RepeatedTable;
pub use run::{Done, Outcome, sweep};
pub use table::{SweepBlock, blocks};
pub use variants::{Axes, Choice, Label, SPEED_KEY, SweepError, Variant, variants};
