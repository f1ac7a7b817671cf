//! Two records or programs judged.
//!
//! Counters: any difference that nobody has explained is against the second one. Physical values: a wrong one is.
//! Between two programs also, for every stage:
//!
//! - instructions, where they can be counted: exact, so that more than [`INSTRUCTIONS_MARGIN`] more of them in any
//!   workload are too many;
//! - times: of each workload, and of all workloads that have the stage pooled. A stage is slower or faster if the
//!   intervals of two batches of pairs, one after the other, both lie beyond [`MARGIN`]; the second batch is only run
//!   where the first is suspicious.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

use super::changes::{AcceptedChanges, Difference, differences};
use super::error::PerformanceError;
use super::instructions;
use super::measure::{Found, Measurement};
use super::program::{Program, in_turn};
use super::ratio::{Ratio, stage_times};
use super::record::{Record, RecordedWorkload};
use super::workload::Workload;

/// Probability that the interval of one batch misses its median: a stage that is called changed has passed it twice.
pub const DOUBT: f64 = 1e-3;
/// Changes of time that nobody wants to hear of.
pub const MARGIN: f64 = 0.01;
/// Stages with a smaller share in the time of their workload are not judged by time.
pub const LEAST_SHARE: f64 = 0.02;
/// Changes of the number of instructions that nobody wants to hear of.
pub const INSTRUCTIONS_MARGIN: f64 = 0.01;

/// One of the two.
#[derive(Debug)]
pub enum Side {
    /// A recorded file.
    Record(PathBuf, Box<Record>),
    /// A program that can measure.
    Program(Program),
}

impl Side {
    /// A file that ends in `.json` is a record, any other a program.
    ///
    /// # Errors
    /// Of [`Record::read`]; [`PerformanceError::File`] for a program that is not there.
    pub fn of(path: PathBuf) -> Result<Self, PerformanceError> {
        std::fs::metadata(&path).map_err(PerformanceError::reading(&path))?;
        if path.extension().is_some_and(|extension| extension == "json") {
            let record = Box::new(Record::read(&path)?);
            return Ok(Self::Record(path, record));
        }
        Ok(Self::Program(Program::new(path)))
    }

    /// Its file.
    pub fn path(&self) -> &PathBuf {
        match self {
            Self::Record(path, _) | Self::Program(Program { path, .. }) => path,
        }
    }
}

/// How a stage's time came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// No change was seen.
    None,
    /// Slower, in both batches.
    Slower,
    /// Faster, in both batches.
    Faster,
    /// Too little of the workload's time to be judged.
    NotJudged,
}

/// Time of one stage, of a workload or of all that have it.
#[derive(Clone, Debug, Serialize)]
pub struct StageVerdict {
    /// Its name.
    pub stage: String,
    /// Its share in the time of the workload, or of all.
    pub share: f64,
    /// Second over first.
    pub ratio: Ratio,
    /// Smallest change that could have been seen.
    pub resolution: f64,
    /// What that means.
    pub change: Change,
    /// Workloads that have told it.
    pub workloads: usize,
    /// Instructions of both, where they were counted; exact.
    pub instructions: Option<(u64, u64)>,
}

/// One workload.
#[derive(Clone, Debug, Serialize)]
pub struct WorkloadVerdict {
    /// Its name.
    pub workload: String,
    /// Counters that differ.
    pub differences: Vec<Difference>,
    /// Physical value of the second.
    pub found: Found,
    /// Whether it is right.
    pub right: bool,
    /// Instructions of both, where both were counted with one compiler.
    pub instructions: Option<(u64, u64)>,
    /// All stages together; `None` where times cannot be compared.
    pub whole: Option<Ratio>,
    /// Stages in the order of their shares.
    pub stages: Vec<StageVerdict>,
}

/// All of them.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// The first one's file.
    pub first: PathBuf,
    /// The second one's.
    pub second: PathBuf,
    /// What it rests on, in words.
    pub evidence: String,
    /// Workloads that both know.
    pub workloads: Vec<WorkloadVerdict>,
    /// Stages that several workloads have, their times pooled, in the order of their shares.
    pub stages: Vec<StageVerdict>,
}

/// How much is done to judge programs.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Pairs of a batch.
    pub pairs: usize,
    /// Whether instructions are counted.
    pub instructions: bool,
}

/// Judges `second` by `first`. `watch` is called with the workload at every step of the work.
///
/// # Errors
/// [`PerformanceError`].
pub fn judge(
    first: &Side,
    second: &Side,
    workloads: &[Workload],
    accepted: &AcceptedChanges,
    effort: Effort,
    stop: &AtomicBool,
    watch: &mut dyn FnMut(Workload),
) -> Result<Verdict, PerformanceError> {
    let mut verdict = Verdict {
        first: first.path().clone(),
        second: second.path().clone(),
        evidence: "results and counters; times and instructions are compared between two programs only".to_owned(),
        workloads: Vec::new(),
        stages: Vec::new(),
    };
    if let (Side::Program(a), Side::Program(b)) = (first, second) {
        let programs = [a, b];
        let mut batch = |pairs: usize| -> Result<Vec<Timed>, PerformanceError> {
            workloads.iter().map(|&workload| Timed::measure(programs, workload, pairs, stop, watch)).collect()
        };
        // One of each beforehand: files are read and the tyre is fitted.
        batch(1)?;
        let first = batch(effort.pairs)?;
        verdict.workloads = first.iter().map(|timed| timed.verdict(accepted)).collect();
        verdict.stages = pooled(&first);
        if verdict.rows().any(|row| row.change != Change::None && row.change != Change::NotJudged) {
            let second = batch(effort.pairs)?;
            for (found, again) in verdict.workloads.iter_mut().zip(&second) {
                confirm(&mut found.stages, &again.stages());
            }
            confirm(&mut verdict.stages, &pooled(&second));
        }
        if effort.instructions {
            for (&workload, found) in workloads.iter().zip(&mut verdict.workloads) {
                watch(workload);
                if stop.load(Ordering::Relaxed) {
                    return Err(PerformanceError::Interrupted);
                }
                let [a, b] = programs.map(|program| instructions::count(program, workload));
                if let (Some((a, _)), Some((b, _))) = (a, b) {
                    found.instructions = Some((a.all, b.all));
                    for row in &mut found.stages {
                        row.instructions = a.of(&row.stage).zip(b.of(&row.stage));
                    }
                }
            }
        }
        let counted = verdict.workloads.iter().filter(|found| found.instructions.is_some()).count();
        verdict.evidence = format!(
            "results, counters and times of every stage, and the instructions (exact) of {counted} of {} workloads",
            workloads.len()
        );
        return Ok(verdict);
    }
    for &workload in workloads {
        watch(workload);
        if stop.load(Ordering::Relaxed) {
            return Err(PerformanceError::Interrupted);
        }
        verdict.workloads.extend(by_counters(first, second, workload, accepted)?);
    }
    Ok(verdict)
}

/// What a side took for a workload, and with which instructions and compiler; `None` for a record that does not know
/// it.
fn taken(side: &Side, workload: Workload) -> Result<Option<(RecordedWorkload, String, String)>, PerformanceError> {
    Ok(match side {
        Side::Record(_, record) => record
            .workloads
            .get(workload.name())
            .map(|found| (found.clone(), record.stamp.instruction_set.clone(), record.stamp.compiler.clone())),
        Side::Program(program) => {
            let measurement = program.measure(workload)?;
            let set = measurement.instruction_set.clone();
            Some((RecordedWorkload::new(&[measurement], None), set, String::new()))
        }
    })
}

fn by_counters(
    first: &Side,
    second: &Side,
    workload: Workload,
    accepted: &AcceptedChanges,
) -> Result<Option<WorkloadVerdict>, PerformanceError> {
    let (Some((a, set_a, compiler_a)), Some((b, set_b, compiler_b))) =
        (taken(first, workload)?, taken(second, workload)?)
    else {
        return Ok(None);
    };
    let instructions = a.instructions.zip(b.instructions).filter(|_| compiler_a == compiler_b);
    let differences = differences(workload.name(), &a, &b, accepted, set_a != set_b);
    Ok(Some(WorkloadVerdict { instructions, ..WorkloadVerdict::new(workload, differences, b.found) }))
}

/// A workload by both programs, pair by pair: what they measured first, and the times \[s\] of the stages that both
/// have.
struct Timed {
    workload: Workload,
    first: [Measurement; 2],
    stages: Vec<(String, [Vec<f64>; 2])>,
}

impl Timed {
    fn measure(
        programs: [&Program; 2],
        workload: Workload,
        pairs: usize,
        stop: &AtomicBool,
        watch: &mut dyn FnMut(Workload),
    ) -> Result<Self, PerformanceError> {
        let runs = in_turn(programs, workload, pairs, stop, watch)?;
        let first = runs.each_ref().map(|runs| runs[0].clone());
        let names = first[0].blocks.keys().filter(|stage| first[1].blocks.contains_key(*stage));
        let stages = names.map(|stage| {
            let [a, b] = runs.each_ref().map(|runs| -> Vec<&[Option<u64>]> {
                runs.iter().map(|run| run.blocks.get(stage).map_or(&[][..], Vec::as_slice)).collect()
            });
            let (a, b) = stage_times(&a, &b);
            (stage.clone(), [a, b])
        });
        Ok(Self { workload, stages: stages.collect(), first })
    }

    /// All stages together.
    fn whole(&self) -> Ratio {
        let [first, second] = [0, 1].map(|which| -> Vec<f64> {
            let runs = self.stages.first().map_or(0, |(_, times)| times[which].len());
            (0..runs).map(|run| self.stages.iter().map(|(_, times)| times[which][run]).sum()).collect()
        });
        Ratio::new(&first, &second, DOUBT)
    }

    fn stages(&self) -> Vec<StageVerdict> {
        let whole = self.whole().seconds;
        let rows = self
            .stages
            .iter()
            .map(|(stage, [first, second])| StageVerdict::new(stage, Ratio::new(first, second, DOUBT), whole, 1));
        by_share(rows.collect())
    }

    fn verdict(&self, accepted: &AcceptedChanges) -> WorkloadVerdict {
        let [a, b] = self.first.each_ref().map(|run| RecordedWorkload::new(std::slice::from_ref(run), None));
        let differences = differences(self.workload.name(), &a, &b, accepted, false);
        let stages = self.stages();
        WorkloadVerdict {
            whole: Some(self.whole()),
            stages,
            ..WorkloadVerdict::new(self.workload, differences, b.found)
        }
    }
}

/// Every stage over all workloads in whose time it has a share worth judging, if there are several.
fn pooled(workloads: &[Timed]) -> Vec<StageVerdict> {
    let all: f64 = workloads.iter().map(|timed| timed.whole().seconds).sum();
    let names: BTreeSet<&String> = workloads.iter().flat_map(|timed| &timed.stages).map(|(stage, _)| stage).collect();
    let rows = names.into_iter().filter_map(|name| {
        let judged = |timed: &Timed| timed.stages().iter().any(|row| row.stage == *name && row.share >= LEAST_SHARE);
        let times: Vec<(&[f64], &[f64])> = workloads
            .iter()
            .filter(|timed| judged(timed))
            .flat_map(|timed| &timed.stages)
            .filter(|(stage, _)| stage == name)
            .map(|(_, [first, second])| (first.as_slice(), second.as_slice()))
            .collect();
        (times.len() > 1).then(|| StageVerdict::new(name, Ratio::pooled(&times, DOUBT), all, times.len()))
    });
    by_share(rows.collect())
}

fn by_share(mut rows: Vec<StageVerdict>) -> Vec<StageVerdict> {
    rows.sort_by(|a, b| b.share.total_cmp(&a.share));
    rows
}

/// Leaves the changes that another batch has, too.
fn confirm(rows: &mut [StageVerdict], again: &[StageVerdict]) {
    for row in rows.iter_mut().filter(|row| row.change != Change::NotJudged) {
        if again.iter().all(|other| other.stage != row.stage || other.change != row.change) {
            row.change = Change::None;
        }
    }
}

impl StageVerdict {
    /// As one batch alone speaks for it.
    fn new(stage: &str, ratio: Ratio, whole: f64, workloads: usize) -> Self {
        let share = ratio.seconds / whole;
        let change = match ratio {
            _ if share < LEAST_SHARE => Change::NotJudged,
            Ratio { low, .. } if low > 1.0 + MARGIN => Change::Slower,
            Ratio { high, .. } if high < 1.0 - MARGIN => Change::Faster,
            _ => Change::None,
        };
        Self {
            stage: stage.to_owned(),
            share,
            ratio,
            resolution: ratio.resolution(),
            change,
            workloads,
            instructions: None,
        }
    }

    /// What the instructions say.
    fn change_of_instructions(&self) -> Change {
        match self.instructions.map(|(from, to)| to as f64 / from as f64) {
            None => Change::NotJudged,
            _ if self.share < LEAST_SHARE => Change::NotJudged,
            Some(ratio) if ratio > 1.0 + INSTRUCTIONS_MARGIN => Change::Slower,
            Some(ratio) if ratio < 1.0 - INSTRUCTIONS_MARGIN => Change::Faster,
            Some(_) => Change::None,
        }
    }

    /// Its change in words; `whole`: the ratio of all stages of its workload.
    fn in_words(&self, whole: Option<Ratio>) -> String {
        let Ratio { median, low, high, .. } = self.ratio;
        let percent = |ratio: f64| 100.0 * (ratio - 1.0);
        let faster = if self.change == Change::Faster { "faster" } else { "slower" };
        let part = match whole {
            Some(whole) => format!(
                ", which makes {:+.1} % of the workload's {:+.1} %",
                100.0 * self.share * (median - 1.0),
                percent(whole.median)
            ),
            None => format!(", {} workloads together", self.workloads),
        };
        let (median, low, high) = (percent(median), percent(low), percent(high));
        format!("stage {} is {faster}: {median:+.1} % ({low:+.1} to {high:+.1}){part}, by times", self.stage)
    }
}

impl WorkloadVerdict {
    fn new(workload: Workload, differences: Vec<Difference>, found: Found) -> Self {
        let (workload, right) = (workload.name().to_owned(), found.is_right());
        Self { workload, differences, right, found, instructions: None, whole: None, stages: Vec::new() }
    }

    /// Complaints about the second one, in words; none for one that is as good.
    pub fn complaints(&self) -> Vec<String> {
        let mut complaints = Vec::new();
        let Found { what, value, expected, tolerance } = &self.found;
        if !self.right {
            complaints.push(format!("wrong result: {what} is {value}, not {expected} within {tolerance:e}"));
        }
        for Difference { counter, from, to, explained } in &self.differences {
            if explained.is_none() {
                complaints.push(format!("counter {counter} was {from} and is {to}, and no accepted change says why"));
            }
        }
        if let Some((from, to)) = self.instructions
            && to as f64 > (1.0 + INSTRUCTIONS_MARGIN) * from as f64
        {
            complaints.push(format!("{to} instructions instead of {from}"));
        }
        complaints.extend(self.changed(Change::Slower));
        complaints
    }

    /// Stages that became faster, in words.
    pub fn praise(&self) -> Vec<String> {
        self.changed(Change::Faster).collect()
    }

    fn changed(&self, change: Change) -> impl Iterator<Item = String> {
        let by_times = self.stages.iter().filter(move |row| row.change == change).map(|row| row.in_words(self.whole));
        by_times.chain(self.stages.iter().filter_map(move |row| {
            let (from, to) = row.instructions.filter(|_| row.change_of_instructions() == change)?;
            let percent = 100.0 * (to as f64 / from as f64 - 1.0);
            Some(format!("stage {} executes {to} instructions instead of {from}: {percent:+.1} %, exact", row.stage))
        }))
    }
}

impl Verdict {
    /// Whether nothing speaks against the second one.
    pub fn passes(&self) -> bool {
        self.pooled(Change::Slower).next().is_none()
            && self.workloads.iter().all(|workload| workload.complaints().is_empty())
    }

    /// Times of all stages of all workloads, and those pooled.
    pub(super) fn rows(&self) -> impl Iterator<Item = &StageVerdict> {
        self.workloads.iter().flat_map(|workload| &workload.stages).chain(&self.stages)
    }

    /// Stages that all workloads together say have changed, in words.
    pub(super) fn pooled(&self, change: Change) -> impl Iterator<Item = String> {
        self.stages.iter().filter(move |row| row.change == change).map(|row| row.in_words(None))
    }
}
