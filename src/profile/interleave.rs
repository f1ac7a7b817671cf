//! Two programs run in turn.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::error::ProfileError;
use super::measure::Measurement;
use super::workload::Workload;

/// How a program is asked for one measurement, before the workload's name. One thread: what is made beside the march on
/// more of them would be in nobody's time.
const ARGUMENTS: [&str; 5] = ["--quiet", "--threads", "1", "profile", "measure"];

/// A program that can measure, with fitted models of its own: what another build has kept might be another model.
#[derive(Debug)]
pub struct Program {
    /// Its file.
    pub path: PathBuf,
    models: PathBuf,
}

impl Program {
    /// Of a file; its models are gone when this is dropped.
    pub fn new(path: PathBuf) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("tyrewave-profile-{}-{number}", std::process::id());
        Self { path, models: std::env::temp_dir().join(name) }
    }

    /// A command that begins with `words` and ends with the measurement of a workload.
    pub(super) fn command(&self, words: &[&str], workload: Workload) -> Command {
        let begin = words.iter().map(OsStr::new);
        let mut all =
            begin.chain([self.path.as_os_str()]).chain(ARGUMENTS.map(OsStr::new)).chain([workload.name().as_ref()]);
        let mut command = Command::new(all.next().unwrap_or_default());
        command.args(all).env("TYREWAVE_CACHE_DIR", &self.models).stdin(Stdio::null());
        command
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.models);
    }
}

/// Has a program measure a workload, with times.
///
/// # Errors
/// [`ProfileError::Program`].
pub fn measured_by(program: &Program, workload: Workload) -> Result<Measurement, ProfileError> {
    let failed = |wrong: String| ProfileError::Program {
        program: program.path.clone(),
        workload: workload.name().to_owned(),
        wrong,
    };
    let output = program.command(&[], workload).output().map_err(|error| failed(error.to_string()))?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        return Err(failed(format!("{}: {}", output.status, text.lines().next().unwrap_or_default())));
    }
    let measurement: Measurement =
        serde_json::from_slice(&output.stdout).map_err(|error| failed(format!("no measurement: {error}")))?;
    if measurement.workload == workload.name() {
        Ok(measurement)
    } else {
        Err(failed(format!("a measurement of \"{}\"", measurement.workload)))
    }
}

/// Measurements of one workload by two programs, pair by pair.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    /// By the first program.
    pub first: Vec<Measurement>,
    /// By the second.
    pub second: Vec<Measurement>,
}

impl Pairs {
    /// So many pairs, in the order A B, B A, A B, ...: neither program always comes first, and a steady drift cancels.
    ///
    /// # Errors
    /// [`ProfileError::Program`], [`ProfileError::Interrupted`].
    pub fn measure(
        programs: [&Program; 2],
        workload: Workload,
        pairs: usize,
        stop: &AtomicBool,
        watch: &mut dyn FnMut(),
    ) -> Result<Self, ProfileError> {
        let mut found = Self::default();
        for pair in 0..pairs {
            if stop.load(Ordering::Relaxed) {
                return Err(ProfileError::Interrupted);
            }
            let [a, b] = programs;
            if pair % 2 == 0 {
                found.first.push(measured_by(a, workload)?);
                found.second.push(measured_by(b, workload)?);
            } else {
                found.second.push(measured_by(b, workload)?);
                found.first.push(measured_by(a, workload)?);
            }
            watch();
        }
        Ok(found)
    }

    /// Blocks of a stage, run by run, of both.
    pub fn blocks<'a>(&'a self, stage: &str) -> [Vec<&'a [Option<u64>]>; 2] {
        let of = |runs: &'a [Measurement]| -> Vec<&'a [Option<u64>]> {
            runs.iter().map(|run| run.blocks.get(stage).map_or(&[][..], Vec::as_slice)).collect()
        };
        [of(&self.first), of(&self.second)]
    }
}
