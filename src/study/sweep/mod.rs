//! One scene at many speeds, loads, roads and settings.
//!
//! 1. [`factor`]: what is varied, and which of its values are tried together;
//! 2. [`mod@variants`]: the scenes, checked before anything runs;
//! 3. [`mod@run`]: what is finished is left alone, what was interrupted continues, the rest is run, several at a time;
//! 4. [`table`]: levels side by side, and how they grow with the speed; [`repeated`]: means over seeds, with their
//!    confidence, and pictures of what they depend on; [`road_uncertainty`]: what is not known about a road, and the
//!    spread that it causes; [`friction_curves`]: tangential forces; [`record`]: what
//!    finds the variants again;
//! 5. [`tasks`]: the same as tasks in a folder, for batch systems.

pub(crate) mod factor;
pub(crate) mod friction_curves;
pub(crate) mod record;
pub(crate) mod repeated;
pub(crate) mod road_uncertainty;
pub(crate) mod run;
pub(crate) mod table;
pub(crate) mod tasks;
pub(crate) mod variants;

pub(crate) use factor::{Design, Factor, Range};
pub(crate) use record::{StoredSweep, share_full_scale};
pub(crate) use repeated::RepeatedTable;
pub(crate) use road_uncertainty::{RoadUncertainty, corner_values};
pub(crate) use run::{Done, VariantOutcome, sweep};
pub(crate) use table::blocks;
pub(crate) use variants::{Axes, LOAD_KEY, Label, SPEED_KEY, SweepError, Variant, variants};
