//! A sweep as tasks in a folder, for systems that start processes on many machines: batch systems, a loop in a shell.
//!
//! 1. [`task`]: one scene with all that is needed to run it, identified by its content;
//! 2. [`folder`]: the tasks on disk, many to a file, and the manifest, whose presence means that they are complete;
//! 3. [`outcomes`]: results of tasks, a small file for each until all tasks of a shard are done, then one file for the
//!    shard;
//! 4. [`work`]: runs some of the tasks; leaves out those that are done or under way elsewhere, and resumes interrupted
//!    ones;
//! 5. [`collect`]: outcomes for the sweep's tables, and numbers of the missing tasks, listed as batch systems read
//!    them;
//! 6. [`jobs`]: files to submit.
//!
//! ```text
//! DIR/manifest              written last: format, version, how many tasks, which
//! DIR/shard-0007/tasks      the tasks 7000 to 7999
//! DIR/shard-0007/outcome-N  what task N has found; failed-N: why it has not
//! DIR/shard-0007/outcomes-* what some of them have found
//! DIR/shard-0007/outcomes   what all of them have found, instead of those
//! DIR/shard-0007/results    runs under way with their checkpoints; with `keep_results` all that have ended
//! DIR/shard-0007/lock-N     held by the process that does task N
//! ```
//!
//! Correctness does not rest on the locks, which not every shared disk has: files get their names when they are
//! complete, and any process that does a task finds the same bytes. The locks keep two processes from doing the same
//! work.

pub(crate) mod collect;
pub(crate) mod folder;
pub(crate) mod jobs;
pub(crate) mod outcomes;
pub(crate) mod task;
pub(crate) mod work;

pub(crate) use collect::{Collection, Numbers};
pub(crate) use folder::{TaskFolder, Written};
pub(crate) use jobs::Jobs;
pub(crate) use task::TaskError;
pub(crate) use work::{Ended, Event, TaskWork};
