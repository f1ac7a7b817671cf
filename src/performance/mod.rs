//! Performance from commit to commit: cost of fixed pieces of work, recorded and compared.
//!
//! 1. [`mod@workload`]: the pieces of work, each with a physical value that it must find, and scenes of the user;
//! 2. [`mod@measure`]: execution of one of them in this process: exact counters, time of every stage in short blocks;
//! 3. [`mod@record`]: all of them as a file, with a stamp of program and machine;
//! 4. [`changes`]: counters of two records side by side; every difference needs a documented reason;
//! 5. [`mod@compare`]: two programs that measure in turn, or records;
//! 6. [`verdict`]: all of that, as values, with statistics of paired times.
//!
//! Counters decide exact questions; times are compared only between two programs run side by side on one machine: a
//! recorded time depends on the conditions of its hour.

pub(crate) mod changes;
pub(crate) mod compare;
pub(crate) mod measure;
pub(crate) mod record;
pub(crate) mod verdict;
pub(crate) mod workload;
