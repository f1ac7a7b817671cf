//! Instructions counted by Valgrind, where it is installed: repeatable to a few in a million, whatever else the machine
//! does.

use std::process::{Command, Stdio};

use super::interleave::Program;
use super::measure::Measurement;
use super::workload::Workload;

/// Whether instructions can be counted here.
pub fn can_count() -> bool {
    let version = Command::new("valgrind").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    version.is_ok_and(|status| status.success())
}

/// Instructions that `program` executes for a workload on one thread, start included, and what it measured meanwhile:
/// its times mean nothing, and its vectors are those of the processor that the tool imitates. `None` if they could not
/// be counted.
pub fn count(program: &Program, workload: Workload) -> Option<(u64, Measurement)> {
    let tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"];
    let output = program.command(&tool, workload).output().ok()?;
    if !output.status.success() {
        return None;
    }
    let measurement = serde_json::from_slice(&output.stdout).ok()?;
    Some((collected(&String::from_utf8_lossy(&output.stderr))?, measurement))
}

/// The count in the tool's last words.
fn collected(text: &str) -> Option<u64> {
    let line = text.lines().rev().find_map(|line| line.split_once("Collected :"))?;
    line.1.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_count_is_read_from_the_last_words() {
        assert_eq!(collected("==7== Events    : Ir\n==7== Collected : 1234567\n==7== \n"), Some(1_234_567));
        assert_eq!(collected("==7== Collected : many"), None);
        assert_eq!(collected("valgrind: failed"), None);
    }
}
