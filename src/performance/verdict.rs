//! Verdict on two records or programs.
//!
//! A stage is slower, and the comparison fails, if the interval of its ratio lies beyond [`MARGIN`]. It is the same if
//! the upper end of the interval, as a part of the whole workload, is below [`TOLERATED`]; otherwise it is undecided.

use std::path::PathBuf;

use serde::Serialize;

use super::changes::{AcceptedChange, CounterDifference, differences};
use super::measure::Measurement;
use super::ratio::{Ratio, stage_times};
use super::workload::{MeasuredValue, SharedWork};

/// Smaller changes of time are not reported.
const MARGIN: f64 = 0.01;
/// A stage that may have cost its workload this share of its time is not called the same.
pub(crate) const TOLERATED: f64 = 0.05;
/// Stages with a smaller share in the time of their workload are not judged.
const LEAST_SHARE: f64 = 0.02;

/// Change of a stage's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Change {
    /// Not slower, as far as the workload is concerned.
    Same,
    /// The comparison fails.
    Slower,
    /// Passes as [`Self::Same`] does.
    Faster,
    /// The times scatter too much, or there are too few.
    Undecided,
}

/// Judgement on one stage of a workload, or on all of them together.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StageVerdict {
    /// Name of the stage, or `all`.
    pub stage: String,
    /// Share in the time of the workload, by the first program.
    pub share: f64,
    /// Time of the second program over that of the first.
    pub ratio: Ratio,
    /// Judgement on the ratio.
    pub change: Change,
}

/// Judgement on one workload.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct WorkloadVerdict {
    /// Name of the workload.
    pub workload: String,
    /// Counters that differ.
    pub differences: Vec<CounterDifference>,
    /// Physical value of the second program.
    pub found: MeasuredValue,
    /// True if that value is right.
    pub right: bool,
    /// `all`, then the stages by falling share; none if times cannot be compared.
    pub stages: Vec<StageVerdict>,
    /// Complaints about the second one, in words; empty if it is as good.
    pub complaints: Vec<String>,
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
    /// True if a stage is undecided, or a side lacks some of the work.
    pub is_undecided: bool,
    /// Workloads that both have.
    pub workloads: Vec<WorkloadVerdict>,
}

/// Judges the stages that all runs of both programs have.
fn stages(runs: [&[Measurement]; 2]) -> Vec<StageVerdict> {
    let Some(first) = runs[0].first() else { return Vec::new() };
    let has = |stage: &&String| runs.iter().copied().flatten().all(|run| run.blocks.contains_key(*stage));
    let names: Vec<&String> = first.blocks.keys().filter(has).collect();
    let blocks = |stage: &String| runs.map(|runs| runs.iter().map(|run| run.blocks[stage].as_slice()).collect());
    let times: Vec<[Vec<f64>; 2]> = names.iter().map(|stage| stage_times(blocks(stage))).collect();
    let sum = |side: usize, pair: usize| times.iter().map(|times| times[side][pair]).sum();
    let whole = Ratio::new(&[0, 1].map(|side| (0..runs[side].len()).map(|pair| sum(side, pair)).collect()));
    let judge = |stage: &str, ratio: Ratio| {
        let share = ratio.seconds / whole.seconds;
        let change = match ratio {
            Ratio { low, .. } if low > 1.0 + MARGIN => Change::Slower,
            Ratio { high, .. } if high < 1.0 - MARGIN => Change::Faster,
            Ratio { high, .. } if share * (high - 1.0) < TOLERATED => Change::Same,
            _ => Change::Undecided,
        };
        StageVerdict { stage: stage.to_owned(), share, ratio, change }
    };
    let rows = names.iter().zip(&times).map(|(stage, times)| judge(stage, Ratio::new(times)));
    let mut rows: Vec<StageVerdict> = rows.filter(|row| row.share >= LEAST_SHARE).collect();
    rows.sort_by(|a, b| b.share.total_cmp(&a.share));
    rows.insert(0, judge("all", whole));
    rows
}

impl WorkloadVerdict {
    /// Judges some work by measurements of both sides, of which the first gives result and counters and the others the
    /// times; `None` if a side has none.
    pub(super) fn new(work: &SharedWork, runs: &[Vec<Measurement>; 2], accepted: &[AcceptedChange]) -> Option<Self> {
        let [(first, first_timed), (second, second_timed)] = [runs[0].split_first()?, runs[1].split_first()?];
        let mut found = second.found.clone();
        if work.is_scene {
            // The first program's result is the only reference for the second.
            found.expected = first.found.value;
        }
        let other_set = first.instruction_set != second.instruction_set;
        let differences = differences(&work.name, &first.counters, &second.counters, accepted, other_set);
        let stages = stages([first_timed, second_timed]);
        let mut complaints: Vec<String> = found.complaint().into_iter().collect();
        let unexplained = differences.iter().filter(|difference| difference.explained.is_none());
        complaints.extend(unexplained.map(|CounterDifference { counter, from, to, .. }| {
            format!("counter {counter} was {from} and is {to}, and no accepted change says why")
        }));
        let slower = stages.iter().filter(|row| row.change == Change::Slower);
        complaints.extend(slower.map(|StageVerdict { stage, ratio, .. }| {
            let [median, low, high] = [ratio.median, ratio.low, ratio.high].map(|ratio| 100.0 * (ratio - 1.0));
            format!("stage {stage} is slower: {median:+.1} % ({low:+.1} to {high:+.1})")
        }));
        let (workload, right) = (work.name.clone(), found.complaint().is_none());
        Some(Self { workload, differences, found, right, stages, complaints })
    }
}

impl Verdict {
    /// All work, each with its verdict; `None` where a record lacks it.
    pub(super) fn new([first, second]: [PathBuf; 2], judged: Vec<(&SharedWork, Option<WorkloadVerdict>)>) -> Self {
        let missing = judged.iter().filter(|(_, found)| found.is_none()).map(|(work, _)| work.name.as_str());
        let missing: Vec<&str> = missing.collect();
        let workloads: Vec<WorkloadVerdict> = judged.into_iter().filter_map(|(_, found)| found).collect();
        let rows = || workloads.iter().flat_map(|workload| &workload.stages);
        let mut evidence = match rows().map(|row| row.ratio.pairs).min() {
            Some(pairs) => format!("results, counters, and times of every stage in {pairs} pairs of runs"),
            None => "results and counters; times are compared between two programs only".to_owned(),
        };
        let is_undecided = !missing.is_empty() || rows().any(|row| row.change == Change::Undecided);
        if !missing.is_empty() {
            evidence += &format!("; a record lacks {}", missing.join(", "));
        }
        Self { first, second, evidence, is_undecided, workloads }
    }

    /// True if there is no complaint about the second one.
    pub(crate) fn passes(&self) -> bool {
        self.workloads.iter().all(|workload| workload.complaints.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Measurements of stages with these times \[us\], pair by pair a percent apart.
    fn runs(pairs: u64, times: [u64; 4]) -> Vec<Measurement> {
        let names = ["history", "road", "sound", "output"];
        let run = |pair: u64| {
            let block = |time| vec![Some(1000 * time + 10 * time * (pair % 2)); 3];
            let blocks = names.iter().zip(times).map(|(&name, time)| (name.to_owned(), block(time))).collect();
            let found = MeasuredValue { value: 2.0, expected: 1.0, tolerance: 0.01, ..MeasuredValue::default() };
            Measurement { workload: "a.toml".to_owned(), found, blocks, ..Measurement::default() }
        };
        (0..=pairs).map(run).collect()
    }

    fn verdict(pairs: u64, second: [u64; 4]) -> Verdict {
        let work = SharedWork { name: "a.toml".to_owned(), is_scene: true };
        let found = WorkloadVerdict::new(&work, &[runs(pairs, [600, 300, 100, 1]), runs(pairs, second)], &[]);
        Verdict::new(["old".into(), "new".into()], vec![(&work, found)])
    }

    fn changes(verdict: &Verdict) -> Vec<(&str, Change)> {
        verdict.workloads[0].stages.iter().map(|row| (row.stage.as_str(), row.change)).collect()
    }

    #[test]
    fn a_slower_stage_fails_and_too_few_pairs_are_undecided() {
        use Change::{Faster, Same, Slower, Undecided};
        // The mean force of a scene is held against that of the first program; a stage of a thousandth is left out.
        let same = verdict(12, [600, 300, 100, 9]);
        assert_eq!(changes(&same), [("all", Same), ("history", Same), ("road", Same), ("sound", Same)]);
        assert!(same.passes() && !same.is_undecided, "{same:?}");
        let slower = verdict(12, [600, 330, 90, 1]);
        assert_eq!(changes(&slower), [("all", Slower), ("history", Same), ("road", Slower), ("sound", Faster)]);
        assert!(!slower.passes() && slower.workloads[0].complaints[1].starts_with("stage road is slower: +10.0 %"));
        let few = verdict(10, [600, 330, 90, 1]);
        assert!(changes(&few).iter().all(|(_, change)| *change == Undecided) && few.passes() && few.is_undecided);
        assert!(few.evidence.contains("10 pairs"));
    }

    #[test]
    fn a_wrong_value_and_a_counter_without_a_reason_fail() {
        let work = SharedWork { name: "rough".to_owned(), is_scene: false };
        let [mut first, mut second] = [1.0, 1.1].map(|value| Measurement {
            found: MeasuredValue { value, expected: 1.0, tolerance: 0.01, ..MeasuredValue::default() },
            ..Measurement::default()
        });
        first.counters.insert("steps".to_owned(), 7);
        second.counters.insert("steps".to_owned(), 8);
        let found = WorkloadVerdict::new(&work, &[vec![first.clone()], vec![second]], &[]).unwrap();
        assert!(!found.right && found.stages.is_empty() && found.complaints.len() == 2, "{found:?}");
        assert!(found.complaints[1].starts_with("counter steps was 7 and is 8"));
        assert!(WorkloadVerdict::new(&work, &[vec![first], Vec::new()], &[]).is_none());
        let lacking = Verdict::new(["old".into(), "new".into()], vec![(&work, None)]);
        assert!(lacking.passes() && lacking.is_undecided && lacking.evidence.ends_with("a record lacks rough"));
    }
}
