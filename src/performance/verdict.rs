//! Verdict on two records or programs.
//!
//! A stage is slower, and the comparison fails, if the interval of its ratio lies beyond [`MARGIN`]. It is the same if
//! the upper end of the interval, as a part of the whole workload, is below [`TOLERATED`]; otherwise it is undecided.
//!
//! Ratios of paired times of two programs, with their confidence.
//!
//! 1. A stage's time in a run is the sum over its blocks, each cut at [`CUT`] times its usual time, the median of the
//!    same block over all runs of both programs. Blocks that other processes disturbed are left out and represented by
//!    the others: the sum is scaled by the usual times of all blocks over those of the blocks that count.
//! 2. Consecutive runs of both programs are a pair; slower drifts cancel in their ratio.
//! 3. The median of the ratios has an interval of order statistics: x_(k) ... x_(n+1-k) holds it with probability 1 - 2
//!    P(B(n, 1/2) < k), whatever the distribution (W. J. Conover, *Practical Nonparametric Statistics*, section 3.2).
//!    The only assumption is that pairs are independent.

use std::path::PathBuf;

use serde::Serialize;

use super::changes::{AcceptedChange, CounterDifference, differences};
use super::measure::Measurement;
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

/// Blocks longer than this many medians count as disturbed.
const CUT: f64 = 1.3;
/// Probability that an interval misses its median.
const MISS_PROBABILITY: f64 = 1e-3;

/// A ratio of times with its confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Ratio {
    /// Median of the pairs' ratios, second program over first.
    pub median: f64,
    /// Lower end of the interval; 0 for too few pairs.
    pub low: f64,
    /// Upper end of the interval; infinite for too few pairs.
    pub high: f64,
    /// Number of pairs.
    pub pairs: usize,
    /// Median time of the first program \[s\].
    pub seconds: f64,
}

impl Ratio {
    /// Ratio of times \[s\], one of each program per pair.
    pub(super) fn new([first, second]: &[Vec<f64>; 2]) -> Self {
        let mut ratios: Vec<f64> = first.iter().zip(second).map(|(a, b)| b / a).filter(|x| x.is_finite()).collect();
        ratios.sort_by(f64::total_cmp);
        let pairs = ratios.len();
        let (low, high) = match rank(pairs) {
            0 => (0.0, f64::INFINITY),
            k => (ratios[k - 1], ratios[pairs - k]),
        };
        Self { median: median(ratios), low, high, pairs, seconds: median(first.clone()) }
    }
}

/// Largest k for which x_(k) ... x_(n+1-k) misses the median of n pairs with a probability of at most
/// [`MISS_PROBABILITY`]; 0 if none does.
fn rank(pairs: usize) -> usize {
    // P(B(n, 1/2) < k), summed from below.
    let (mut term, mut below, mut k) = (0.5_f64.powf(pairs as f64), 0.0, 0);
    loop {
        below += term;
        if 2.0 * below > MISS_PROBABILITY {
            return k;
        }
        term *= (pairs - k) as f64 / (k + 1) as f64;
        k += 1;
    }
}

/// Median; NaN for no values.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        length => 0.5 * (values[(length - 1) / 2] + values[length / 2]),
    }
}

/// Times of a stage \[s\], one for each run of the first and of the second program, from the times of its blocks \[ns\]
/// (runs x blocks; `None`: disturbed).
fn stage_times(runs: [Vec<&[Option<u64>]>; 2]) -> [Vec<f64>; 2] {
    let blocks = runs.iter().flatten().map(|run| run.len()).min().unwrap_or(0);
    // 1. Usual time of each block: the median over all runs.
    let times = |block: usize| runs.iter().flatten().filter_map(move |run| run[block]).map(|time| time as f64);
    let usual: Vec<f64> = (0..blocks).map(|block| median(times(block).collect()).max(0.0)).collect();
    // 2. Sum of the blocks that count, each cut, scaled to all blocks.
    let seconds = |run: &&[Option<u64>]| {
        let known = || run.iter().zip(&usual).filter_map(|(time, usual)| Some(((*time)? as f64, usual)));
        let found: f64 = known().map(|(time, usual)| time.min(CUT * usual)).sum();
        1e-9 * found * usual.iter().sum::<f64>() / known().map(|(_, usual)| usual).sum::<f64>()
    };
    runs.each_ref().map(|runs| runs.iter().map(seconds).collect())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

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

    #[test]
    fn ranks_are_those_of_the_binomial_distribution() {
        // 2^-9 for n = 10, 2^-10 for n = 11; 2 (1 + 20 + 190)/2^20 = 4.0e-4 for n = 20 and k = 3, 2.6e-3 for k = 4.
        assert_eq!([0, 10, 11, 20].map(rank), [0, 0, 1, 3]);
        // The normal distribution's n/2 - 3.29 sqrt(n)/2 for many.
        assert!(rank(1000).abs_diff(448) <= 1, "{}", rank(1000));
    }

    /// A run of 100 blocks that takes about `factor`, drifts as a whole, and is interrupted now and then for much
    /// longer than a block.
    fn run(rng: &mut ChaCha8Rng, factor: f64, drift: f64) -> Vec<Option<u64>> {
        (0..100)
            .map(|block| {
                let usual = 1e6 * (1.0 + f64::from(block % 7)) * factor * drift;
                let interrupted = if rng.random::<f64>() < 0.1 { 4e6 } else { 0.0 };
                let known = rng.random::<f64>() < 0.2;
                (!known).then_some((usual * (1.0 + 0.05 * rng.random::<f64>()) + interrupted) as u64)
            })
            .collect()
    }

    fn compared(rng: &mut ChaCha8Rng, factor: f64) -> Ratio {
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for _ in 0..30 {
            let drift = 1.0 + 0.3 * rng.random::<f64>();
            let mut of = |factor: f64| {
                let pace = drift * (1.0 + 0.02 * rng.random::<f64>());
                run(rng, factor, pace)
            };
            first.push(of(1.0));
            second.push(of(factor));
        }
        Ratio::new(&stage_times([&first, &second].map(|runs| runs.iter().map(Vec::as_slice).collect())))
    }

    #[test]
    fn five_percent_are_seen_through_interruptions() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..5 {
            let slower = compared(&mut rng, 1.05);
            assert!(slower.low > 1.01 && (slower.median - 1.05).abs() < 0.015, "{slower:?}");
            let same = compared(&mut rng, 1.0);
            assert!(same.low < 1.0 && same.high > 1.0 && same.high - same.low < 0.08, "{same:?}");
        }
    }

    #[test]
    fn few_pairs_say_nothing() {
        let ratio = Ratio::new(&[vec![1.0; 4], vec![2.0; 4]]);
        assert!(ratio.low <= 0.0 && ratio.high.is_infinite() && (ratio.median - 2.0).abs() < 1e-15);
        assert!(Ratio::new(&[vec![], vec![]]).median.is_nan());
    }
}
