//! Performance from commit to commit: what fixed pieces of work cost, recorded and compared.
//!
//! 1. [`mod@workload`]: the pieces of work, each with a physical value that it must find, and scenes of the user's;
//! 2. [`mod@measure`]: one of them done in this process: exact counters, time of every stage in short blocks;
//! 3. [`mod@record`]: all of them as a file, stamped with what they were measured on; [`instructions`] counted where a
//!    counting tool is there;
//! 4. [`changes`]: counters of two records side by side; every difference needs a reason that is written
//!    down, or it fails;
//! 5. [`program`]: two programs run in turn, again and again; `ratio`: what their times say, of a workload and of all
//!    pooled; [`instructions`] of every stage of both;
//! 6. [`mod@judge`]: all of that put together to a [`verdict`], in words, Markdown and JSON.
//!
//! Counters decide what is exact, and times only what two programs did side by side on one machine: a recorded time is
//! of another hour.

pub(crate) mod changes;
pub(crate) mod instructions;
pub(crate) mod judge;
pub(crate) mod measure;
pub(crate) mod program;
mod ratio;
pub(crate) mod record;
pub(crate) mod report;
mod stamp;
pub(crate) mod verdict;
pub(crate) mod workload;

mod error;

pub(crate) use error::PerformanceError;
pub(crate) use measure::{Measurement, measure, measure_scene};
pub(crate) use record::Record;
pub(crate) use workload::{Work, Workload};
