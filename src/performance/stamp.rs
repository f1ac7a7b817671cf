//! Program and machine of a record.

use std::path::Path;
use std::process::Command;

use serde::{Deserialize, Serialize};

use crate::counters::machine::{instruction_set, processor};

/// Program, compiler and machine.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Stamp {
    /// Version of tyrewave.
    pub version: String,
    /// Commit of the sources in the present folder, followed by `-modified` if they differ from it; empty without a
    /// repository.
    pub commit: String,
    /// Compiler, and its level of optimisation.
    pub compiler: String,
    /// Processor and number of cores.
    pub machine: String,
    /// Operating system.
    pub system: String,
    /// Instruction set of the vectors, see [`instruction_set`]: rounding, and with it discrete counters, may depend on
    /// it.
    pub instruction_set: String,
}

impl Stamp {
    /// Stamp of this program on this machine.
    pub(crate) fn here() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: commit(Path::new(".")).unwrap_or_default(),
            compiler: format!("{}, optimisation {}", env!("TYREWAVE_COMPILER"), env!("TYREWAVE_OPTIMISATION")),
            machine: format!("{}, {cores} cores", processor().unwrap_or_else(|| std::env::consts::ARCH.to_owned())),
            system: std::env::consts::OS.to_owned(),
            instruction_set: instruction_set().to_owned(),
        }
    }
}

fn commit(folder: &Path) -> Option<String> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(folder).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    // Records and pictures do not change the program.
    let modified = !git(&["status", "--porcelain", "--", "src", "Cargo.toml", "Cargo.lock"])?.is_empty();
    Some(if modified { format!("{commit}-modified") } else { commit })
}
