//! All workloads as a file: committed, and compared with later programs.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde::{Deserialize, Serialize};

use super::measure::{Counts, Measurement};
use super::workload::MeasuredValue;
use crate::counters::peak::{instruction_set, processor};
use crate::storage::PendingFile;
use crate::storage::input::{self, TABLE_BYTES};

/// Value of `format` in a record.
const FORMAT: &str = "tyrewave profile";
/// Incremented when the layout changes incompatibly.
const FORMAT_VERSION: u32 = 1;

/// Entry of the stamp for the instruction set.
const SET: &str = "instruction_set";

/// Costs of the workloads on one machine.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct PerformanceRecord {
    /// Constant `tyrewave profile`.
    pub format: String,
    /// Version of the layout.
    pub format_version: u32,
    /// Program, compiler and machine, by name.
    pub stamp: BTreeMap<String, String>,
    /// Costs by the names of the workloads.
    pub workloads: BTreeMap<String, RecordedWorkload>,
}

/// Origin of a record: version, commit of the sources in the present folder (followed by `-modified` if they differ;
/// empty without a repository), compiler, machine, and instruction set of the vectors, see [`instruction_set`]:
/// rounding, and with it discrete counters, may depend on it.
fn stamp() -> BTreeMap<String, String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let processor = processor().unwrap_or_else(|| std::env::consts::ARCH.to_owned());
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // Records and pictures do not change the program.
    let changed = git(&["status", "--porcelain", "--", "src", "Cargo.toml", "Cargo.lock"]);
    let modified = if changed.is_some_and(|files| !files.is_empty()) { "-modified" } else { "" };
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).map_or_else(String::new, |commit| commit + modified);
    let entries = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("commit", commit),
        ("compiler", concat!(env!("TYREWAVE_COMPILER"), ", optimisation ", env!("TYREWAVE_OPTIMISATION")).to_owned()),
        ("machine", format!("{processor}, {cores} cores")),
        ("system", std::env::consts::OS.to_owned()),
        (SET, instruction_set().to_owned()),
    ];
    entries.map(|(name, value)| (name.to_owned(), value)).into()
}

/// Costs of one workload.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct RecordedWorkload {
    /// Physical value that was computed.
    pub found: MeasuredValue,
    /// Exact counters by name.
    pub counters: Counts,
    /// Share of every stage in the time of all of them: for people, never compared.
    #[serde(default)]
    pub shares: BTreeMap<String, f64>,
}

impl From<Measurement> for RecordedWorkload {
    fn from(Measurement { found, counters, blocks, .. }: Measurement) -> Self {
        let time = |blocks: &Vec<Option<u64>>| blocks.iter().flatten().sum::<u64>() as f64;
        let all: f64 = blocks.values().map(time).sum();
        // Three digits: further ones are noise.
        let shares = blocks.iter().map(|(stage, blocks)| (stage.clone(), (1e3 * time(blocks) / all).round() / 1e3));
        Self { shares: shares.collect(), found, counters }
    }
}

impl PerformanceRecord {
    /// Record of measurements by this program on this machine.
    pub(crate) fn new(measured: Vec<Measurement>) -> Self {
        let workloads = measured.into_iter().map(|found| (found.workload.clone(), found.into())).collect();
        Self { format: FORMAT.to_owned(), format_version: FORMAT_VERSION, stamp: stamp(), workloads }
    }

    /// Path of the record of an instruction set in a folder of records.
    pub fn place(folder: &Path, instruction_set: &str) -> PathBuf {
        folder.join(format!("{instruction_set}.json"))
    }

    /// Reads the file of a record.
    ///
    /// # Errors
    /// A file that cannot be read, or is no record of this release.
    pub fn read(path: &Path) -> io::Result<Self> {
        let text = input::read_text(path, TABLE_BYTES)?;
        let invalid = |wrong: String| {
            io::Error::other(format!("not a record of this release: {wrong}; `tyrewave profile record` makes one"))
        };
        let record: Self = serde_json::from_str(&text).map_err(|error| invalid(error.to_string()))?;
        if record.format != FORMAT || record.format_version != FORMAT_VERSION {
            return Err(invalid(format!("\"{}\", version {}", record.format, record.format_version)));
        }
        Ok(record)
    }

    /// Writes the file atomically.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let text = serde_json::to_string_pretty(self)? + "\n";
        path.parent().map_or(Ok(()), fs::create_dir_all)?;
        PendingFile::create(path)?.complete(text)
    }

    /// A workload of the record, without times.
    pub(super) fn measurement(&self, workload: &str) -> Option<Measurement> {
        let RecordedWorkload { found, counters, .. } = self.workloads.get(workload)?.clone();
        let (workload, instruction_set) = (workload.to_owned(), self.stamp.get(SET).cloned().unwrap_or_default());
        Some(Measurement { workload, instruction_set, counters, found, ..Measurement::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_comes_back_and_nonsense_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/record.json");
        let blocks = BTreeMap::from([
            ("history".to_owned(), vec![Some(30), Some(45), None]),
            ("road".to_owned(), vec![Some(20), Some(5), None]),
        ]);
        let counters = BTreeMap::from([("steps".to_owned(), 7)]);
        let found = MeasuredValue { what: "force".into(), value: 1.5, expected: 1.5, tolerance: 1e-6 };
        let measurement = Measurement { workload: "rough".into(), counters, found, blocks, ..Measurement::default() };
        let record = PerformanceRecord::new(vec![measurement.clone()]);
        assert!((record.workloads["rough"].shares["history"] - 0.75).abs() < 1e-12);
        record.write(&path).unwrap();
        assert_eq!(PerformanceRecord::read(&path).unwrap(), record);
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        assert!(record.stamp["machine"].contains(" cores") && record.stamp["compiler"].starts_with("rustc"));
        assert_eq!(record.measurement("rough").unwrap().instruction_set, instruction_set());
        let again = record.measurement("rough").unwrap();
        assert_eq!((again.counters, again.found), (measurement.counters, measurement.found));
        assert!(again.blocks.is_empty() && record.measurement("smooth").is_none());
        // Records of earlier versions have instructions, too.
        let text = serde_json::to_string(&record).unwrap();
        std::fs::write(&path, text.replace("\"shares\"", "\"instructions\": 7, \"shares\"")).unwrap();
        assert_eq!(PerformanceRecord::read(&path).unwrap(), record);
        for text in
            ["", "{}", "[1]", &serde_json::to_string(&PerformanceRecord { format_version: 9, ..record }).unwrap()]
        {
            std::fs::write(&path, text).unwrap();
            assert!(
                PerformanceRecord::read(&path).is_err_and(|error| error.to_string().starts_with("not a record")),
                "{text}"
            );
        }
    }
}
