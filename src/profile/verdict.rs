//! Two records or programs judged.
//!
//! Counters: any difference that nobody has explained is against the second one. Physical values: a wrong one is.
//! Times, between programs only: a stage is slower or faster if the intervals of two batches of pairs, one after the
//! other, both lie beyond [`MARGIN`]; the second batch is only run where the first is suspicious.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::changes::{AcceptedChanges, Difference, differences};
use super::error::ProfileError;
use super::interleave::{Pairs, Program, measured_by};
use super::measure::Found;
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
    /// Of [`Record::read`]; [`ProfileError::File`] for a program that is not there.
    pub fn of(path: PathBuf) -> Result<Self, ProfileError> {
        std::fs::metadata(&path).map_err(ProfileError::reading(&path))?;
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

/// One stage of a workload.
#[derive(Clone, Debug, Serialize)]
pub struct StageVerdict {
    /// Its name.
    pub stage: String,
    /// Its share in the workload's time.
    pub share: f64,
    /// Second over first.
    pub ratio: Ratio,
    /// Smallest change that could have been seen.
    pub resolution: f64,
    /// What that means.
    pub change: Change,
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
    /// Workloads that both know.
    pub workloads: Vec<WorkloadVerdict>,
}

/// How much is done for times.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Pairs of a batch.
    pub pairs: usize,
}

/// Judges `second` by `first`. `watch` is called with the workload at every step of the work.
///
/// # Errors
/// [`ProfileError`].
pub fn judge(
    first: &Side,
    second: &Side,
    workloads: &[Workload],
    accepted: &AcceptedChanges,
    effort: Effort,
    stop: &AtomicBool,
    watch: &mut dyn FnMut(Workload),
) -> Result<Verdict, ProfileError> {
    let mut verdicts = Vec::new();
    for &workload in workloads {
        watch(workload);
        if stop.load(std::sync::atomic::Ordering::Relaxed) {
            return Err(ProfileError::Interrupted);
        }
        let verdict = match (first, second) {
            (Side::Program(a), Side::Program(b)) => by_time([a, b], workload, accepted, effort, stop, watch)?,
            (a, b) => {
                let Some(verdict) = by_counters(a, b, workload, accepted)? else { continue };
                verdict
            }
        };
        verdicts.push(verdict);
    }
    Ok(Verdict { first: first.path().clone(), second: second.path().clone(), workloads: verdicts })
}

/// What a side took for a workload, and with which instructions; `None` for a record that does not know it.
fn taken(side: &Side, workload: Workload) -> Result<Option<(RecordedWorkload, String, String)>, ProfileError> {
    Ok(match side {
        Side::Record(_, record) => record
            .workloads
            .get(workload.name())
            .map(|found| (found.clone(), record.stamp.instruction_set.clone(), record.stamp.compiler.clone())),
        Side::Program(program) => {
            let measurement = measured_by(program, workload)?;
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
) -> Result<Option<WorkloadVerdict>, ProfileError> {
    let (Some((a, set_a, compiler_a)), Some((b, set_b, compiler_b))) =
        (taken(first, workload)?, taken(second, workload)?)
    else {
        return Ok(None);
    };
    let instructions = a.instructions.zip(b.instructions).filter(|_| compiler_a == compiler_b);
    let differences = differences(workload.name(), &a, &b, accepted, set_a != set_b);
    Ok(Some(WorkloadVerdict { instructions, ..WorkloadVerdict::new(workload, differences, b.found) }))
}

fn by_time(
    programs: [&Program; 2],
    workload: Workload,
    accepted: &AcceptedChanges,
    effort: Effort,
    stop: &AtomicBool,
    watch: &mut dyn FnMut(Workload),
) -> Result<WorkloadVerdict, ProfileError> {
    let batch = |watch: &mut dyn FnMut(Workload)| {
        Pairs::measure(programs, workload, effort.pairs, stop, &mut || watch(workload))
    };
    // One of each beforehand: files are read and the tyre is fitted.
    Pairs::measure(programs, workload, 1, stop, &mut || watch(workload))?;
    let pairs = batch(watch)?;
    let (whole, mut stages) = times(&pairs);
    if stages.iter().any(|stage| suspicious(stage).is_some()) {
        let (_, again) = times(&batch(watch)?);
        for stage in &mut stages {
            let confirmed = again.iter().find(|other| other.stage == stage.stage).and_then(suspicious);
            if confirmed.is_some() && confirmed == suspicious(stage) {
                stage.change = confirmed.unwrap_or(Change::None);
            }
        }
    }
    let [a, b] = [&pairs.first, &pairs.second].map(|runs| RecordedWorkload::new(&runs[..1], None));
    let differences = differences(workload.name(), &a, &b, accepted, false);
    Ok(WorkloadVerdict { whole: Some(whole), stages, ..WorkloadVerdict::new(workload, differences, b.found) })
}

/// The change that one batch alone speaks for.
fn suspicious(stage: &StageVerdict) -> Option<Change> {
    match stage {
        _ if stage.share < LEAST_SHARE => None,
        _ if stage.ratio.low > 1.0 + MARGIN => Some(Change::Slower),
        _ if stage.ratio.high < 1.0 - MARGIN => Some(Change::Faster),
        _ => None,
    }
}

/// Ratios of the whole and of every stage that both programs have, the largest first.
fn times(pairs: &Pairs) -> (Ratio, Vec<StageVerdict>) {
    let names = pairs.first[0].blocks.keys().filter(|stage| pairs.second[0].blocks.contains_key(*stage));
    let stages: Vec<(String, Vec<f64>, Vec<f64>)> = names
        .map(|stage| {
            let [first, second] = pairs.blocks(stage);
            let (first, second) = stage_times(&first, &second);
            (stage.clone(), first, second)
        })
        .collect();
    let sum = |times: Vec<&Vec<f64>>| -> Vec<f64> {
        (0..pairs.first.len()).map(|run| times.iter().map(|times| times[run]).sum()).collect()
    };
    let first = sum(stages.iter().map(|(_, first, _)| first).collect());
    let whole = Ratio::new(&first, &sum(stages.iter().map(|(.., second)| second).collect()), DOUBT);
    let mut verdicts: Vec<StageVerdict> = stages
        .iter()
        .map(|(stage, first, second)| {
            let ratio = Ratio::new(first, second, DOUBT);
            let share = ratio.seconds / whole.seconds;
            let change = if share < LEAST_SHARE { Change::NotJudged } else { Change::None };
            StageVerdict { stage: stage.clone(), share, ratio, resolution: ratio.resolution(), change }
        })
        .collect();
    verdicts.sort_by(|a, b| b.share.total_cmp(&a.share));
    (whole, verdicts)
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
        for stage in self.stages.iter().filter(|stage| stage.change == Change::Slower) {
            complaints.push(format!("stage {} is slower: {}", stage.stage, self.in_words(stage)));
        }
        complaints
    }

    /// Stages that became faster, in words.
    pub fn praise(&self) -> Vec<String> {
        let faster = self.stages.iter().filter(|stage| stage.change == Change::Faster);
        faster.map(|stage| format!("stage {} is faster: {}", stage.stage, self.in_words(stage))).collect()
    }

    fn in_words(&self, stage: &StageVerdict) -> String {
        let Ratio { median, low, high, .. } = stage.ratio;
        let percent = |ratio: f64| 100.0 * (ratio - 1.0);
        let part = self.whole.map_or(String::new(), |whole| {
            format!(
                ", which makes {:+.1} % of the workload's {:+.1} %",
                100.0 * stage.share * (median - 1.0),
                percent(whole.median)
            )
        });
        format!("{:+.1} % ({:+.1} to {:+.1}){part}", percent(median), percent(low), percent(high))
    }
}

impl Verdict {
    /// Whether nothing speaks against the second one.
    pub fn passes(&self) -> bool {
        self.workloads.iter().all(|workload| workload.complaints().is_empty())
    }
}
