//! Measured costs of units of work on this machine, stored beside the fitted models.

use std::fs;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::unit::UnitCosts;
use crate::counters::machine::{instruction_set, processor};
use crate::numeric::digest::sha256;
use crate::storage::input::{self, TABLE_BYTES};
use crate::storage::{Cache, PendingFile};

/// Name of the record in the cache folder.
const FILE: &str = "calibration.json";

#[derive(Deserialize, Serialize)]
struct Record {
    /// Build of the program and kind of processor.
    machine: String,
    costs: UnitCosts,
}

/// Costs measured before, by this build on this kind of processor; otherwise typical ones.
pub(crate) fn known() -> UnitCosts {
    let read = || {
        let record: Record = serde_json::from_slice(&input::read(&file()?, TABLE_BYTES).ok()?).ok()?;
        (record.machine == machine()).then_some(record.costs)
    };
    read().unwrap_or_default()
}

/// Keeps costs for [`known`]; a failure is ignored, they are measured again.
pub(crate) fn keep(costs: UnitCosts) {
    let record = Record { machine: machine(), costs };
    if let Some(path) = file()
        && let Ok(text) = serde_json::to_string_pretty(&record)
        && path.parent().map_or(Ok(()), fs::create_dir_all).is_ok()
    {
        // Another process may do the same: each has a temporary file until it is complete.
        let _ = PendingFile::create(&path).and_then(|file| file.complete(&text));
    }
}

fn file() -> Option<PathBuf> {
    Cache::open().ok().map(|cache| cache.folder().join(FILE))
}

/// Build (size and time of the program's file) and processor.
fn machine() -> String {
    let program = std::env::current_exe().and_then(fs::metadata).ok();
    let size = program.as_ref().map_or(0, fs::Metadata::len);
    let time = program.and_then(|file| file.modified().ok()).map(|time| format!("{time:?}")).unwrap_or_default();
    let model = processor().unwrap_or_default();
    sha256(&[env!("CARGO_PKG_VERSION"), &size.to_string(), &time, &model, instruction_set()])
}
