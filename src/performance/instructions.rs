//! Instructions counted by Valgrind's callgrind, if it is installed: repeatable to a few in a million, whatever the
//! load of the machine.
//!
//! The program's line tables give the source file of every instruction, however much was inlined: the file determines
//! the stage. Instructions from a library's file (vectors, numbers) belong to the stage that most of the rest of their
//! function belongs to; a function entirely from a library belongs to none, except for the transforms'.

use std::collections::BTreeMap;
use std::process::{Command, Stdio};

use super::measure::{Measurement, name};
use super::program::Program;
use super::workload::Work;
use crate::counters::Stage;

/// Paths of the sources and their stages, more specific ones first.
const PLACES: [(&str, Stage); 16] = [
    ("src/contact/history/", Stage::History),
    ("src/contact/march.rs", Stage::Penetration),
    ("src/contact/footprint.rs", Stage::Penetration),
    ("src/contact/slices.rs", Stage::Penetration),
    ("src/road/strip.rs", Stage::Penetration),
    ("src/contact/geometry.rs", Stage::Penetration),
    ("src/contact/", Stage::ActiveSet),
    ("src/road/slices/", Stage::Slices),
    ("src/road/", Stage::Road),
    ("src/tyre/poles/", Stage::Fit),
    ("src/numeric/rational/", Stage::Fit),
    ("src/tyre/", Stage::Influence),
    ("src/response/pressure/", Stage::Sound),
    ("src/response/", Stage::Vibration),
    ("src/radiation/", Stage::Radiation),
    ("src/results/", Stage::Output),
];
/// Libraries whose only use is transforms.
const OF_TRANSFORMS: [&str; 2] = ["/rustfft-", "/realfft-"];

/// Instructions that a program executes for a workload on one thread.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Instructions {
    /// Number of all instructions, the program's start included.
    pub all: u64,
    /// Numbers by the names of stages; empty for a program without line tables.
    pub stages: BTreeMap<String, u64>,
}

impl Instructions {
    /// Number for a stage; `None` if there are none.
    pub(crate) fn of(&self, stage: &str) -> Option<u64> {
        self.stages.get(stage).copied()
    }
}

/// True if Valgrind can be executed.
pub(crate) fn can_count() -> bool {
    let version = Command::new("valgrind").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    version.is_ok_and(|status| status.success())
}

/// Instructions of some work, and the program's measurement during the count: its times mean nothing, and its vectors
/// are those of the emulated processor. `None` if they could not be counted.
pub(crate) fn count(program: &Program, work: &Work) -> Option<(Instructions, Measurement)> {
    let file = program.scratch().ok()?.join("callgrind.out");
    let out = format!("--callgrind-out-file={}", file.display());
    let output = program.run(&["valgrind", "--tool=callgrind", "--dump-line=yes", &out], work).ok()?;
    let counted = std::fs::read_to_string(&file).ok();
    let _ = std::fs::remove_file(&file);
    if !output.status.success() {
        return None;
    }
    let measurement = serde_json::from_slice(&output.stdout).ok()?;
    let all = collected(&String::from_utf8_lossy(&output.stderr))?;
    Some((Instructions { all, stages: by_stage(&counted?) }, measurement))
}

/// Count in the tool's final message.
fn collected(text: &str) -> Option<u64> {
    let line = text.lines().rev().find_map(|line| line.split_once("Collected :"))?;
    line.1.trim().parse().ok()
}

/// Stage of a source file.
fn stage_of(file: &str) -> Option<Stage> {
    if OF_TRANSFORMS.iter().any(|library| file.contains(library)) {
        return Some(Stage::Transforms);
    }
    let library = file.contains("/registry/") || file.contains("/rustc/");
    PLACES.iter().find(|(place, _)| !library && file.contains(place)).map(|place| place.1)
}

/// Self costs in callgrind's output format (Valgrind manual, "Callgrind Format Specification"), by the names of stages.
fn by_stage(text: &str) -> BTreeMap<String, u64> {
    // Costs of the present function: by stage, and of files without a stage.
    let mut function: ([u64; Stage::ALL.len()], u64) = Default::default();
    let mut stages = [0; Stage::ALL.len()];
    let mut end = |function: &mut ([u64; Stage::ALL.len()], u64)| {
        let (own, others) = std::mem::take(function);
        stages.iter_mut().zip(own).for_each(|(all, own)| *all += own);
        if let Some(most) = (0..own.len()).max_by_key(|&stage| own[stage]).filter(|&most| own[most] > 0) {
            stages[most] += others;
        }
    };
    // Names are written in full once, as `(number) name`.
    let mut files: BTreeMap<&str, Option<Stage>> = BTreeMap::new();
    let (mut now, mut called) = (None, false);
    for line in text.lines() {
        if let Some((key, value)) = line.split_once('=').filter(|(key, _)| key.chars().all(char::is_alphabetic)) {
            let (number, file) = value.split_once(' ').unwrap_or((value, ""));
            match key {
                "fl" | "fi" | "fe" | "cfi" | "cfl" => {
                    if !file.is_empty() {
                        files.insert(number, stage_of(file));
                    }
                    if !key.starts_with('c') {
                        now = files.get(number).copied().flatten();
                    }
                }
                "fn" => end(&mut function),
                // The next line is the inclusive cost of the call.
                "calls" => called = true,
                _ => {}
            }
        } else if line.starts_with(|first: char| first.is_ascii_digit() || "+-*".contains(first))
            && !std::mem::take(&mut called)
        {
            let cost = line.split(' ').nth(1).and_then(|cost| cost.parse::<u64>().ok()).unwrap_or(0);
            match now {
                Some(stage) => function.0[stage as usize] += cost,
                None => function.1 += cost,
            }
        }
    }
    end(&mut function);
    let found = Stage::ALL.into_iter().zip(stages).filter(|(_, count)| *count > 0);
    found.map(|(stage, count)| (name(&stage), count)).collect()
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

    #[test]
    fn every_line_goes_to_the_stage_of_its_file_and_calls_to_none() {
        let text = "events: Ir\n\n\
             fl=(1) /home/a/src/contact/march.rs\nfn=(1) march\n10 5\n\
             fi=(2) /home/a/src/contact/history/far.rs\n+2 70\n\
             fi=(3) /rustc/abc/library/core/src/iter.rs\n* 30\nfe=(1)\n-3 2\n\
             cfi=(4) /home/r/registry/src/x/rustfft-6/a.rs\ncfn=(2) transform\ncalls=3 7\n11 1000\n12 1\n\n\
             fl=(4)\nfn=(2)\n7 1000\n\n\
             fl=(5) /home/r/registry/src/x/pulp-1/src/road/a.rs\nfn=(3) other\n1 9\n\ntotals: 1117\n";
        let found = by_stage(text);
        let expected = [("history", 100), ("penetration", 8), ("transforms", 1000)];
        assert_eq!(found, expected.map(|(stage, count)| (stage.to_owned(), count)).into());
    }
}
