//! Programs that measure, and two of them run in turn.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use super::error::PerformanceError;
use super::measure::Measurement;
use super::workload::Work;

/// Arguments that ask a program for one measurement, before the workload's name. One thread: the time of work beside
/// the march on more of them would not be counted.
const ARGUMENTS: [&str; 5] = ["--quiet", "--threads", "1", "profile", "measure"];

/// A program that can measure, with fitted models of its own: what another build has kept might be another model.
#[derive(Debug)]
pub(crate) struct Program {
    /// Its file.
    pub path: PathBuf,
    models: PathBuf,
}

impl Program {
    /// Makes a program of a file; its models are gone when this is dropped.
    pub(crate) fn new(path: PathBuf) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("tyrewave-profile-{}-{number}", std::process::id());
        Self { path, models: std::env::temp_dir().join(name) }
    }

    /// Returns a folder that is gone when this is dropped.
    ///
    /// # Errors
    /// Errors of the system.
    pub(super) fn scratch(&self) -> std::io::Result<&std::path::Path> {
        std::fs::create_dir_all(&self.models)?;
        Ok(&self.models)
    }

    /// Does the measurement of some work by a command that begins with `words`.
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

    /// Has it measure some work, with times.
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

/// Measurements of all work by two programs, one after the other.
pub(crate) type Runs = Vec<[Vec<Measurement>; 2]>;

/// Takes so many pairs of measurements of every piece of work, or as many as begin before the time is up, one at least. All
/// of them have one pair before any has the next, in the order A B, B A, A B, ...: neither program always comes
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
