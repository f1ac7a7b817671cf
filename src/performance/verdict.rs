//! Verdict on two records or programs, in values and in words.

use std::path::PathBuf;

use serde::Serialize;

use super::changes::Difference;
use super::measure::Found;
use super::ratio::Ratio;
use super::workload::Work;

/// Probability that the interval of one batch misses its median: a stage that is called changed has passed it twice.
pub(crate) const DOUBT: f64 = 1e-3;
/// Smaller changes of time are not reported.
pub(crate) const MARGIN: f64 = 0.01;
/// Stages with a smaller share in the time of their workload are not judged by time.
pub(crate) const LEAST_SHARE: f64 = 0.02;
/// Smaller changes of the number of instructions are not reported.
pub(crate) const INSTRUCTIONS_MARGIN: f64 = 0.01;

/// How a stage's time came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Change {
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
pub(crate) struct StageVerdict {
    /// Its name.
    pub stage: String,
    /// Its share in the time of the workload, or of all.
    pub share: f64,
    /// Second over first.
    pub ratio: Ratio,
    /// Smallest change that could have been seen.
    pub resolution: f64,
    /// Meaning of the difference.
    pub change: Change,
    /// Workloads that have told it.
    pub workloads: usize,
    /// Instructions of both, where they were counted; exact.
    pub instructions: Option<(u64, u64)>,
}

/// One workload.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct WorkloadVerdict {
    /// Its name.
    pub workload: String,
    /// Counters that differ.
    pub differences: Vec<Difference>,
    /// Physical value of the second.
    pub found: Found,
    /// True if it is right.
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
pub(crate) struct Verdict {
    /// The first one's file.
    pub first: PathBuf,
    /// The second one's.
    pub second: PathBuf,
    /// Evidence, in words.
    pub evidence: String,
    /// True if there were enough times to judge by.
    pub times_judged: bool,
    /// True if neither times nor counts of instructions of all workloads suffice to judge by, where those are compared.
    pub is_undecided: bool,
    /// Workloads that both know.
    pub workloads: Vec<WorkloadVerdict>,
    /// Stages that several workloads have, their times pooled, in the order of their shares.
    pub stages: Vec<StageVerdict>,
}

impl StageVerdict {
    /// Judges a stage as one batch alone speaks for it.
    pub(super) fn new(stage: &str, ratio: Ratio, whole: f64, workloads: usize) -> Self {
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

    /// Judges the change of the instructions.
    fn change_of_instructions(&self) -> Change {
        match self.instructions.map(|(from, to)| to as f64 / from as f64) {
            None => Change::NotJudged,
            _ if self.share < LEAST_SHARE => Change::NotJudged,
            Some(ratio) if ratio > 1.0 + INSTRUCTIONS_MARGIN => Change::Slower,
            Some(ratio) if ratio < 1.0 - INSTRUCTIONS_MARGIN => Change::Faster,
            Some(_) => Change::None,
        }
    }

    /// Returns its change in words; `whole`: the ratio of all stages of its workload.
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
    /// Judges some work by results and counters alone.
    pub(super) fn new(work: &Work, differences: Vec<Difference>, found: Found) -> Self {
        let (workload, right) = (work.to_string(), found.is_right());
        Self { workload, differences, right, found, instructions: None, whole: None, stages: Vec::new() }
    }

    /// Returns the complaints about the second one, in words; none for one that is as good.
    pub(crate) fn complaints(&self) -> Vec<String> {
        let mut complaints = Vec::new();
        if !self.right {
            complaints.push(format!("wrong result: {}", self.found));
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

    /// Returns the stages that became faster, in words.
    pub(crate) fn praise(&self) -> Vec<String> {
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
    /// Tells whether nothing speaks against the second one.
    pub(crate) fn passes(&self) -> bool {
        self.pooled(Change::Slower).next().is_none()
            && self.workloads.iter().all(|workload| workload.complaints().is_empty())
    }

    /// Returns the times of all stages of all workloads, and those pooled.
    pub(super) fn rows(&self) -> impl Iterator<Item = &StageVerdict> {
        self.workloads.iter().flat_map(|workload| &workload.stages).chain(&self.stages)
    }

    /// Returns the stages that all workloads together say have changed, in words.
    pub(super) fn pooled(&self, change: Change) -> impl Iterator<Item = String> {
        self.stages.iter().filter(move |row| row.change == change).map(|row| row.in_words(None))
    }
}
