//! Programs that measure, and two of them run in turn.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use super::error::PerformanceError;
use super::measure::Measurement;
use super::workload::Work;

/// Arguments for one measurement, before the workload's name. One thread: with more, the time of work beside the march
/// would not be counted.
const ARGUMENTS: [&str; 5] = ["--quiet", "--threads", "1", "profile", "measure"];

/// A program that can measure, with a cache of its own: a model kept by another build might differ.
#[derive(Debug)]
pub(crate) struct Program {
    /// The executable.
    pub path: PathBuf,
    models: PathBuf,
}

impl Program {
    /// A program from its executable; its cache is deleted when this is dropped.
    pub(crate) fn new(path: PathBuf) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("tyrewave-profile-{}-{number}", std::process::id());
        Self { path, models: std::env::temp_dir().join(name) }
    }

    /// A folder that is deleted when this is dropped.
    pub(super) fn scratch(&self) -> std::io::Result<&std::path::Path> {
        std::fs::create_dir_all(&self.models)?;
        Ok(&self.models)
    }

    /// Executes the measurement of some work, with a command that begins with `words`.
    pub(super) fn run(&self, words: &[&str], work: &Work) -> std::io::Result<Output> {
        let begin = words.iter().map(OsStr::new);
        let work: Vec<&OsStr> = match work {
            Work::Fixed(workload) => vec![workload.name().as_ref()],
            Work::Scene(path) => vec!["--scene".as_ref(), path.as_os_str()],
        };
        let mut all = begin.chain([self.path.as_os_str()]).chain(ARGUMENTS.map(OsStr::new)).chain(work);
        let mut command = Command::new(all.next().unwrap_or_default());
        command.args(all).env("TYREWAVE_CACHE_DIR", &self.models).stdin(Stdio::null()).output()
    }

    /// Measures some work, with times.
    ///
    /// # Errors
    /// [`PerformanceError::Program`].
    pub(crate) fn measure(&self, work: &Work) -> Result<Measurement, PerformanceError> {
        let failed =
            |wrong: String| PerformanceError::Program { program: self.path.clone(), workload: work.to_string(), wrong };
        let output = self.run(&[], work).map_err(|error| failed(error.to_string()))?;
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr);
            return Err(failed(format!("{}: {}", output.status, text.lines().next().unwrap_or_default())));
        }
        let measurement: Measurement =
            serde_json::from_slice(&output.stdout).map_err(|error| failed(format!("no measurement: {error}")))?;
        if measurement.workload == work.to_string() {
            Ok(measurement)
        } else {
            Err(failed(format!("a measurement of \"{}\"", measurement.workload)))
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.models);
    }
}

/// Measurements by both programs, for each piece of work.
pub(crate) type Runs = Vec<[Vec<Measurement>; 2]>;

/// Takes up to `pairs` pairs of measurements of every piece of work, as many as begin before `until`, one at least.
/// Every piece has one pair before any has the next, in the order A B, B A, A B, ...: neither program always comes
/// first, and a steady drift cancels.
///
/// # Errors
/// [`PerformanceError::Program`], [`PerformanceError::Interrupted`].
pub(crate) fn in_turn(
    programs: [&Program; 2],
    works: &[Work],
    pairs: usize,
    until: Instant,
    stop: &AtomicBool,
    watch: &mut dyn FnMut(&Work),
) -> Result<Runs, PerformanceError> {
    let mut found = vec![[Vec::new(), Vec::new()]; works.len()];
    for pair in (0..pairs).take_while(|&pair| pair == 0 || Instant::now() < until) {
        for (found, work) in found.iter_mut().zip(works) {
            if stop.load(Ordering::Relaxed) {
                return Err(PerformanceError::Interrupted);
            }
            for which in if pair % 2 == 0 { [0, 1] } else { [1, 0] } {
                found[which].push(programs[which].measure(work)?);
            }
            watch(work);
        }
    }
    Ok(found)
}
