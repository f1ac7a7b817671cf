//! Every call that a run makes of the system about files fails once, in its turn: with an error of the disk, for want
//! of room, or because the process is killed there. Results under their name are whole and right at any moment, or the
//! older ones; and what is left is gone on with to the same bytes.
//!
//! strace lets calls fail, call by call, in each thread.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

use tyrewave::internals::{edit, scene_text};

use crate::common::{self, names, read_summary, skipped};

const KILLED: i32 = 9;

/// Calls on files, by the names that they have on one architecture or another.
const CALLS: [&str; 15] = [
    "?open,?openat",
    "read,pread64",
    "write,pwrite64",
    "lseek",
    "close",
    "fsync",
    "fdatasync",
    "ftruncate",
    "?rename,?renameat",
    "renameat2",
    "?mkdir,?mkdirat",
    "?unlink,?unlinkat,?rmdir",
    "getdents64",
    "?stat,?newfstatat,statx",
    "flock,fcntl",
];

/// Faults of a call.
const FAULTS: [&str; 3] = ["error=EIO", "error=ENOSPC", "signal=KILL"];

/// Arguments of the run.
const RUN: [&str; 6] = ["run", "scene.toml", "--out", "out", "--threads", "1"];
const RESUME: [&str; 4] = ["resume", "out", "--threads", "1"];

/// Where names cannot be exchanged: what is different then is between two renames and behind them.
const WITHOUT_EXCHANGE: &str = "inject=renameat2:error=EINVAL";

/// All files of a results folder.
type Content = BTreeMap<String, Vec<u8>>;

/// Content of a results folder; of its summary only what was found, as it states times, too.
fn content(folder: &Path) -> Option<Content> {
    let mut files = Content::new();
    for name in folder.is_dir().then(|| names(folder))? {
        let bytes = match name.as_str() {
            "summary.json" => {
                let summary = read_summary(folder);
                serde_json::to_vec(&(&summary["complete"], &summary["outcome"], &summary["files"])).unwrap()
            }
            _ => fs::read(folder.join(&name)).unwrap(),
        };
        files.insert(name, bytes);
    }
    Some(files)
}

/// A folder as it is before every fault, and what must come of it.
struct Trials {
    /// Holds `run` and `resume`, each with the scene, older results and the fitted tyre, the latter with an unfinished
    /// run, too.
    templates: TempDir,
    older: Content,
    whole: Content,
    /// Calls that failed.
    injected: usize,
    wrong: Vec<String>,
}

/// Memory in place of a disk where there is some: nothing waits for it.
fn fast_folder() -> TempDir {
    let memory = Path::new("/dev/shm");
    if memory.is_dir() { tempfile::tempdir_in(memory).unwrap() } else { tempfile::tempdir().unwrap() }
}

fn program(place: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(common::program());
    command.args(arguments).current_dir(place).env("TYREWAVE_CACHE_DIR", place.join("cache")).output().unwrap()
}

/// The same with faults; whether any call met one, those apart that `always` asks for.
fn with_faults(
    place: &Path,
    arguments: &[&str],
    always: Option<&str>,
    [calls, fault, when]: [&str; 3],
) -> (Output, bool) {
    let log = place.join("log");
    let output = Command::new("strace")
        .args(["-f", "-o", log.to_str().unwrap(), "-e", &format!("trace={calls},renameat2")])
        .args(always.into_iter().flat_map(|always| ["-e", always]))
        .args(["-e", &format!("inject={calls}:{fault}:when={when}")])
        .arg(common::program())
        .args(arguments)
        .current_dir(place)
        .env("TYREWAVE_CACHE_DIR", place.join("cache"))
        .output()
        .unwrap();
    let lines = fs::read_to_string(&log).unwrap();
    fs::remove_file(&log).unwrap();
    let counts = |line: &str| {
        let asked_for = always.is_some() && line.contains("renameat2(");
        line.contains("(INJECTED)") && !asked_for || line.contains("killed by SIGKILL")
    };
    (output, lines.lines().any(counts))
}

fn copy(from: &Path, to: &Path) {
    assert!(Command::new("cp").arg("-r").args([from, to]).status().unwrap().success());
}

impl Trials {
    /// `None`, with a printed line, where strace cannot be had.
    fn prepare() -> Option<Self> {
        let can = Command::new("strace").args(["-f", "-e", "inject=fsync:error=EIO:when=1", "true"]).output();
        if !can.is_ok_and(|output| output.status.success()) {
            skipped("no strace that may let calls fail here");
            return None;
        }
        let rolling = "speed_kmh = 80.0\nwarm_up = 0.02\nduration = 0.04\naxle = { indentation = 0.012, ramp = 0.02 }";
        let outputs = "[outputs]\nplots = false\ncheckpoint_interval = 1e-6";
        let scene = scene_text(64, "kind = \"smooth\"", rolling, "memory = 0.05\nhistory = \"modal\"", outputs);
        let templates = fast_folder();
        let [run, resume] = ["run", "resume"].map(|name| templates.path().join(name));
        fs::create_dir(&run).unwrap();
        fs::write(run.join("scene.toml"), edit(&scene, &[("rolling.axle.indentation", "0.011")])).unwrap();
        assert!(program(&run, &RUN).status.success());
        let older = content(&run.join("out")).unwrap();
        fs::write(run.join("scene.toml"), scene).unwrap();
        copy(&run, &resume);
        // Killed at its second checkpoint.
        let (output, _) = with_faults(&resume, &RUN, None, ["?rename,?renameat", "signal=KILL", "2"]);
        assert_eq!(output.status.signal(), Some(KILLED));
        let whole = templates.path().join("whole");
        copy(&run, &whole);
        assert!(program(&whole, &RUN).status.success());
        let whole = content(&whole.join("out")).unwrap();
        assert!(whole != older && whole.len() == older.len());
        Some(Self { templates, older, whole, injected: 0, wrong: Vec::new() })
    }

    /// One fault; whether any call met it.
    fn fault(&mut self, arguments: &[&str], always: Option<&str>, calls: &str, fault: &str, when: usize) -> bool {
        let folder = fast_folder();
        let place = folder.path().join("place");
        copy(&self.templates.path().join(arguments[0]), &place);
        let (output, met) = with_faults(&place, arguments, always, [calls, fault, &when.to_string()]);
        if met {
            self.injected += 1;
            if let Err(wrong) = self.judge(&place, &output, always.is_some()) {
                let printed = String::from_utf8_lossy(&output.stderr).into_owned();
                let without = always.unwrap_or_default();
                self.wrong.push(format!("{} {without} {calls}:{fault}:when={when}: {wrong}; {printed}", arguments[0]));
            }
        }
        met
    }

    /// A fault of every call that is met, one by one.
    fn every_call(&mut self, arguments: &[&str], always: Option<&str>, calls: &str, fault: &str) {
        let met = (1..).take_while(|&when| self.fault(arguments, always, calls, fault, when)).count();
        let (command, always, wrong) = (arguments[0], always.unwrap_or_default(), self.wrong.len());
        println!("{command} {always} {calls} {fault}: {met} calls, {wrong} wrong so far");
    }

    /// Judges the state after a fault, and after a user has gone on with it.
    fn judge(&self, place: &Path, output: &Output, in_two_moves: bool) -> Result<(), String> {
        let found = content(&place.join("out"));
        let is_whole = found.as_ref() == Some(&self.whole);
        // Killed between whole results and their tidying up: what only an unfinished run needs is still there.
        let whole_at_least =
            found.as_ref().is_some_and(|found| self.whole.iter().all(|(name, bytes)| found.get(name) == Some(bytes)));
        let is_older = found.as_ref() == Some(&self.older);
        let code = output.status.code();
        match (code, output.status.signal()) {
            (Some(0), _) if !whole_at_least => return Err("success without the results".to_owned()),
            // 127: not yet the program, its libraries cannot be loaded.
            (Some(0..=3 | 127), _) | (_, Some(KILLED)) if is_older || whole_at_least => {}
            // Between the two moves nothing has the name.
            (_, Some(KILLED)) if in_two_moves && found.is_none() => {}
            (Some(0..=3 | 127), _) | (_, Some(KILLED)) => return Err("neither older nor new results".to_owned()),
            (code, signal) => return Err(format!("ended with {code:?}, {signal:?}")),
        }
        let mut remaining = names(place);
        remaining.retain(|name| name != "cache");
        if code == Some(0) && is_whole && remaining == ["out", "scene.toml"] {
            return Ok(());
        }
        let mut again = program(place, &RESUME);
        if !again.status.success() {
            again = program(place, &RUN);
        }
        if !again.status.success() {
            return Err(format!("does not go on: {}", String::from_utf8_lossy(&again.stderr)));
        }
        if content(&place.join("out")).as_ref() != Some(&self.whole) {
            return Err("goes on to other results".to_owned());
        }
        Ok(())
    }

    /// Prints and fails for whatever was wrong.
    fn end(self) {
        println!("{} calls failed, {} times something was wrong", self.injected, self.wrong.len());
        assert!(self.wrong.is_empty(), "{:#?}", self.wrong);
    }
}

#[test]
fn calls_that_fail_leave_older_or_whole_results() {
    let Some(mut trials) = Trials::prepare() else { return };
    for (arguments, always, calls, fault, when) in [
        (&RUN[..], None, "renameat2", "signal=KILL", 1),
        (&RUN, Some(WITHOUT_EXCHANGE), "?rename,?renameat", "signal=KILL", 5),
        (&RUN, None, "fdatasync", "error=EIO", 5),
        (&RESUME, None, "write", "error=ENOSPC", 9),
    ] {
        assert!(trials.fault(arguments, always, calls, fault, when), "{calls} was not met");
    }
    trials.end();
}

#[test]
#[ignore = "every call of a run and of one that goes on, each with three faults: minutes"]
fn every_call_that_fails_leaves_older_or_whole_results() {
    let Some(mut trials) = Trials::prepare() else { return };
    for arguments in [&RUN[..], &RESUME] {
        for calls in CALLS {
            FAULTS.iter().for_each(|fault| trials.every_call(arguments, None, calls, fault));
        }
        for calls in ["?rename,?renameat", "?unlink,?unlinkat,?rmdir", "fsync", "getdents64"] {
            FAULTS.iter().for_each(|fault| trials.every_call(arguments, Some(WITHOUT_EXCHANGE), calls, fault));
        }
    }
    trials.end();
}
