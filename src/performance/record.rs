//! All workloads as a file: committed, and compared with later programs.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::PerformanceError;
use super::measure::{Found, Measurement};
use super::stamp::Stamp;
use crate::storage::PendingFile;
use crate::storage::input::{self, TABLE_BYTES};

/// Value of `format` in a record.
const FORMAT: &str = "tyrewave profile";
/// Incremented when the layout changes incompatibly.
const FORMAT_VERSION: u32 = 1;

/// Costs of the workloads on one machine.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Record {
    /// Constant `tyrewave profile`.
    pub format: String,
    /// Version of the layout.
    pub format_version: u32,
    /// Program, compiler and machine.
    pub stamp: Stamp,
    /// Costs by the names of the workloads.
    pub workloads: BTreeMap<String, RecordedWorkload>,
}

/// Costs of one workload.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct RecordedWorkload {
    /// Physical value that was computed.
    pub found: Found,
    /// Exact counters by name.
    pub counters: BTreeMap<String, u64>,
    /// Instructions executed, where a tool counted them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instructions: Option<u64>,
    /// Share of every stage in the time of all of them: for people, never compared.
    #[serde(default)]
    pub shares: BTreeMap<String, f64>,
}

impl RecordedWorkload {
    /// Entry from measurements of one workload; shares are medians.
    pub fn new(measured: &[Measurement], instructions: Option<u64>) -> Self {
        let Some(first) = measured.first() else { return Self::default() };
        let stages = first.blocks.keys();
        let share = |stage: &String, measurement: &Measurement| {
            let of = |blocks: &Vec<Option<u64>>| blocks.iter().flatten().sum::<u64>() as f64;
            measurement.blocks.get(stage).map_or(0.0, of) / measurement.blocks.values().map(of).sum::<f64>()
        };
        let shares = stages.map(|stage| {
            let mut shares: Vec<f64> = measured.iter().map(|measurement| share(stage, measurement)).collect();
            // Three digits: further ones are noise.
            (stage.clone(), (1e3 * super::ratio::median(&mut shares)).round() / 1e3)
        });
        Self { found: first.found.clone(), counters: first.counters.clone(), instructions, shares: shares.collect() }
    }
}

impl Record {
    /// Record of this program on this machine.
    pub(crate) fn new(instruction_set: &str, workloads: BTreeMap<String, RecordedWorkload>) -> Self {
        let stamp = Stamp { instruction_set: instruction_set.to_owned(), ..Stamp::here() };
        Self { format: FORMAT.to_owned(), format_version: FORMAT_VERSION, stamp, workloads }
    }

    /// Path of the record of an instruction set in a folder of records.
    pub fn place(folder: &Path, instruction_set: &str) -> PathBuf {
        folder.join(format!("{instruction_set}.json"))
    }

    /// A record from its file.
    pub fn read(path: &Path) -> Result<Self, PerformanceError> {
        let text =
            input::read_text(path, TABLE_BYTES).map_err(|error| PerformanceError::reading(path)(error.into()))?;
        let nonsense = |wrong: String, right| PerformanceError::Nonsense { path: path.to_owned(), wrong, right };
        let record: Self = serde_json::from_str(&text)
            .map_err(|error| nonsense(format!("not a record: {error}"), "`tyrewave profile record` makes them"))?;
        if record.format != FORMAT || record.format_version != FORMAT_VERSION {
            let wrong = format!("\"{}\", version {}", record.format, record.format_version);
            return Err(nonsense(wrong, "a record of this release; `tyrewave profile record` makes one"));
        }
        Ok(record)
    }

    /// Writes the file atomically.
    ///
    /// # Errors
    /// [`PerformanceError::File`].
    pub fn write(&self, path: &Path) -> Result<(), PerformanceError> {
        let write = || {
            let text = serde_json::to_string_pretty(self)? + "\n";
            path.parent().map_or(Ok(()), fs::create_dir_all)?;
            PendingFile::create(path)?.complete(text)
        };
        write().map_err(PerformanceError::writing(path))
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
        let found = Found { what: "force".into(), value: 1.5, expected: 1.5, tolerance: 1e-6 };
        let measurement = Measurement { workload: "rough".into(), counters, found, blocks, ..Measurement::default() };
        let workload = RecordedWorkload::new(&[measurement], Some(12));
        assert!((workload.shares["history"] - 0.75).abs() < 1e-12);
        let record = Record::new("x86-64-v3", [("rough".to_owned(), workload)].into());
        record.write(&path).unwrap();
        assert_eq!(Record::read(&path).unwrap(), record);
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        assert!(!record.stamp.machine.is_empty() && record.stamp.compiler.starts_with("rustc"), "{:?}", record.stamp);
        for text in ["", "{}", "[1]", &serde_json::to_string(&Record { format_version: 9, ..record }).unwrap()] {
            std::fs::write(&path, text).unwrap();
            assert!(matches!(Record::read(&path), Err(PerformanceError::Nonsense { .. })), "{text}");
        }
    }
}
