//! Comparison of two records or programs.
//!
//! Counters: any unexplained difference counts against the second one. Physical values: a wrong one does. Between two
//! programs also the times of every stage, from pairs of runs one after the other.

use std::io;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use thiserror::Error;

use super::changes::AcceptedChange;
use super::measure::Measurement;
use super::record::PerformanceRecord;
use super::verdict::{Verdict, WorkloadVerdict};
use super::workload::SharedWork;

/// Reasons why there is no measurement by another program.
#[derive(Debug, Error)]
pub(crate) enum PerformanceError {
    /// The user stopped the work.
    #[error("interrupted")]
    Interrupted,
    /// Program, work and fault.
    #[error("{0}")]
    Program(String),
}

/// A record, or a program that can measure.
#[derive(Debug)]
pub(crate) struct ComparedSide {
    path: PathBuf,
    /// `None` for a program.
    pub record: Option<PerformanceRecord>,
    /// Cache of this program alone: a model stored by another build might differ. It is deleted with this.
    cache: PathBuf,
}

impl ComparedSide {
    /// A file that ends in `.json` is a record, any other a program.
    ///
    /// # Errors
    /// Errors of [`PerformanceRecord::read`]; a program that does not exist.
    pub(crate) fn of(path: PathBuf) -> io::Result<Self> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        std::fs::metadata(&path)?;
        let is_record = path.extension().is_some_and(|extension| extension == "json");
        let record = is_record.then(|| PerformanceRecord::read(&path)).transpose()?;
        let cache = format!("tyrewave-profile-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        Ok(Self { path, record, cache: std::env::temp_dir().join(cache) })
    }

    /// A measurement of some work; `None` if a record does not have it.
    ///
    /// # Errors
    /// [`PerformanceError::Program`].
    pub(crate) fn measure(&self, work: &SharedWork) -> Result<Option<Measurement>, PerformanceError> {
        if let Some(record) = &self.record {
            return Ok(record.measurement(&work.name));
        }
        let failed = |wrong: String| {
            PerformanceError::Program(format!("{} profile measure {}: {wrong}", self.path.display(), work.name))
        };
        // One thread: with more, the time of work beside the march would not be counted.
        let mut command = Command::new(&self.path);
        command.args(["--quiet", "--threads", "1", "profile", "measure"]).args(work.is_scene.then_some("--scene"));
        command.arg(&work.name).env("TYREWAVE_CACHE_DIR", &self.cache).stdin(Stdio::null());
        let output = command.output().map_err(|error| failed(error.to_string()))?;
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            return Err(failed(format!("{}: {}", output.status, text.lines().next().unwrap_or_default())));
        }
        let found: Measurement =
            serde_json::from_slice(&output.stdout).map_err(|error| failed(format!("no measurement: {error}")))?;
        if found.workload != work.name {
            return Err(failed(format!("a measurement of \"{}\"", found.workload)));
        }
        Ok(Some(found))
    }
}

impl Drop for ComparedSide {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.cache);
    }
}

/// Compares the second side with the first one: two programs by at most `pairs` pairs of runs, none of which begins
/// once `budget` is over. `watch` is called before each piece of work is done. Records do not include scenes.
///
/// # Errors
/// [`PerformanceError`].
pub(crate) fn compare(
    sides: [&ComparedSide; 2],
    works: &[SharedWork],
    accepted: &[AcceptedChange],
    (pairs, budget): (usize, Duration),
    stop: &AtomicBool,
    watch: &mut dyn FnMut(&SharedWork),
) -> Result<Verdict, PerformanceError> {
    let begin = Instant::now();
    let rounds = if sides.iter().all(|side| side.record.is_none()) { 1 + pairs } else { 1 };
    let mut runs = vec![[Vec::new(), Vec::new()]; works.len()];
    // Round 0 gives results and counters; it also reads files and fits tyres, so that its times do not count.
    for round in (0..rounds).take_while(|&round| round < 2 || begin.elapsed() < budget) {
        for (runs, work) in runs.iter_mut().zip(works) {
            if stop.load(Ordering::Relaxed) {
                return Err(PerformanceError::Interrupted);
            }
            watch(work);
            // A B, B A, A B, ...: neither always comes first, and a steady drift cancels.
            for side in if round % 2 == 0 { [0, 1] } else { [1, 0] } {
                runs[side].extend(sides[side].measure(work)?);
            }
        }
    }
    let judged = works.iter().zip(&runs).map(|(work, runs)| (work, WorkloadVerdict::new(work, runs, accepted)));
    Ok(Verdict::new(sides.map(|side| side.path.clone()), judged.collect()))
}
