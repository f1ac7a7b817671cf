//! Verdict on two records or programs, in values and in words.

use std::path::PathBuf;

use serde::Serialize;

use super::changes::Difference;
use super::measure::Found;
use super::ratio::Ratio;
use super::workload::Work;

/// Probability that the interval of one batch misses its median; a stage reported as changed has passed twice.
pub(crate) const DOUBT: f64 = 1e-3;
/// Smaller changes of time are not reported.
pub(crate) const MARGIN: f64 = 0.01;
/// Stages with a smaller share in the time of their workload are not judged by time.
pub(crate) const LEAST_SHARE: f64 = 0.02;
/// Smaller changes of the number of instructions are not reported.
pub(crate) const INSTRUCTIONS_MARGIN: f64 = 0.01;

/// Change of a stage's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Change {
    /// No significant change.
    None,
    /// Slower, in both batches.
    Slower,
    /// Faster, in both batches.
    Faster,
    /// Too small a share of the workload's time to be judged.
    NotJudged,
}

/// Judgement on one stage, of a workload or pooled.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StageVerdict {
    /// Name of the stage.
    pub stage: String,
    /// Share in the time of the workload, or of all workloads.
    pub share: f64,
    /// Time of the second program over that of the first.
    pub ratio: Ratio,
    /// Smallest change that could have been detected.
    pub resolution: f64,
    /// Judgement on the ratio.
    pub change: Change,
    /// Number of workloads behind it.
    pub workloads: usize,
    /// Instructions of both programs, if they were counted; exact.
    pub instructions: Option<(u64, u64)>,
}

/// Judgement on one workload.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct WorkloadVerdict {
    /// Name of the workload.
    pub workload: String,
    /// Counters that differ.
    pub differences: Vec<Difference>,
    /// Physical value of the second program.
    pub found: Found,
    /// True if that value is right.
    pub right: bool,
    /// Instructions of both, if both were counted with the same compiler.
    pub instructions: Option<(u64, u64)>,
    /// Ratio over all stages; `None` if times cannot be compared.
    pub whole: Option<Ratio>,
    /// Stages by falling share.
    pub stages: Vec<StageVerdict>,
}

/// Judgement on all workloads.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Verdict {
    /// Path of the first program or record.
    pub first: PathBuf,
    /// Path of the second program or record.
    pub second: PathBuf,
    /// Extent of the evidence, in words.
    pub evidence: String,
    /// True if there were enough pairs of runs to judge by.
    pub times_judged: bool,
    /// True if neither the times nor the counts of instructions of all workloads suffice for a judgement, where those
    /// are compared.
    pub is_undecided: bool,
    /// Workloads that both have.
    pub workloads: Vec<WorkloadVerdict>,
    /// Stages of several workloads, their times pooled, by falling share.
    pub stages: Vec<StageVerdict>,
}

impl StageVerdict {
    /// Judges a stage by one batch alone.
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

    /// Judges the change of the number of instructions.
    fn change_of_instructions(&self) -> Change {
        match self.instructions.map(|(from, to)| to as f64 / from as f64) {
            None => Change::NotJudged,
            _ if self.share < LEAST_SHARE => Change::NotJudged,
            Some(ratio) if ratio > 1.0 + INSTRUCTIONS_MARGIN => Change::Slower,
            Some(ratio) if ratio < 1.0 - INSTRUCTIONS_MARGIN => Change::Faster,
            Some(_) => Change::None,
        }
    }

    /// Change in words; `whole` is the ratio of all stages of its workload.
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

    /// Complaints about the second one, in words; empty if it is as good.
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

    /// Stages that became faster, in words.
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
    /// True if there is no complaint about the second one.
    pub(crate) fn passes(&self) -> bool {
        self.pooled(Change::Slower).next().is_none()
            && self.workloads.iter().all(|workload| workload.complaints().is_empty())
    }

    /// Stages of all workloads, and the pooled ones.
    pub(super) fn rows(&self) -> impl Iterator<Item = &StageVerdict> {
        self.workloads.iter().flat_map(|workload| &workload.stages).chain(&self.stages)
    }

    /// Pooled stages with this change, in words.
    pub(super) fn pooled(&self, change: Change) -> impl Iterator<Item = String> {
        self.stages.iter().filter(move |row| row.change == change).map(|row| row.in_words(None))
    }
}
