//! Performance from commit to commit: cost of fixed pieces of work, recorded and compared.
//!
//! 1. [`mod@workload`]: the pieces of work, each with a physical value that it must find, and scenes of the user;
//! 2. [`mod@measure`]: execution of one of them in this process: exact counters, time of every stage in short blocks;
//! 3. [`mod@record`]: all of them as a file, with a stamp of program and machine; [`instructions`] counted if Valgrind
//!    is installed;
//! 4. [`changes`]: counters of two records side by side; every difference needs a documented reason, or the comparison
//!    fails;
//! 5. [`program`]: two programs run in turn, repeatedly; `ratio`: statistics of their times, of a workload and of all
//!    pooled; [`instructions`] of every stage of both;
//! 6. [`mod@judge`]: all of that put together to a [`verdict`], in words, Markdown and JSON.
//!
//! Counters decide exact questions; times are compared only between two programs run side by side on one machine: a
//! recorded time depends on the conditions of its hour.

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
pub use record::Record;
pub(crate) use workload::Work;
pub use workload::Workload;
