//! Judgement on two records or programs.
//!
//! Counters: any unexplained difference counts against the second one. Physical values: a wrong one does.
//! Between two programs also, for every stage:
//!
//! - instructions, if they can be counted: exact, so that an increase of more than [`INSTRUCTIONS_MARGIN`] in any
//!   workload is too much;
//! - times: of each workload, and of all workloads that have the stage pooled. A stage is slower or faster if the
//!   intervals of two batches of pairs, one after the other, both lie beyond [`MARGIN`]; the second batch is only run
//!   if the first is suspicious.
//!
//! [`INSTRUCTIONS_MARGIN`]: super::verdict::INSTRUCTIONS_MARGIN
//! [`MARGIN`]: super::verdict::MARGIN

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::changes::{AcceptedChanges, differences};
use super::error::PerformanceError;
use super::instructions;
use super::measure::Measurement;
use super::program::{Program, in_turn};
use super::ratio::{Ratio, are_enough, stage_times};
use super::record::{Record, RecordedWorkload};
use super::verdict::{Change, DOUBT, LEAST_SHARE, StageVerdict, Verdict, WorkloadVerdict};
use super::workload::Work;

/// One of the two that are compared.
#[derive(Debug)]
pub(crate) enum Side {
    /// A record and its file.
    Record(PathBuf, Box<Record>),
    /// A program that can measure.
    Program(Program),
}

impl Side {
    /// A file that ends in `.json` is a record, any other a program.
    ///
    /// # Errors
    /// Errors of [`Record::read`]; [`PerformanceError::File`] for a program that does not exist.
    pub(crate) fn of(path: PathBuf) -> Result<Self, PerformanceError> {
        std::fs::metadata(&path).map_err(PerformanceError::reading(&path))?;
        if path.extension().is_some_and(|extension| extension == "json") {
            let record = Box::new(Record::read(&path)?);
            return Ok(Self::Record(path, record));
        }
        Ok(Self::Program(Program::new(path)))
    }

    /// Path of the record or program.
    pub(crate) fn path(&self) -> &PathBuf {
        match self {
            Self::Record(path, _) | Self::Program(Program { path, .. }) => path,
        }
    }
}

/// Effort for the comparison of two programs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Most pairs of runs in a batch.
    pub pairs: usize,
    /// True if instructions are counted.
    pub instructions: bool,
    /// Time for everything: pairs and counts that do not fit into it are left out.
    pub budget: Duration,
}

/// Share of the time for pairs if instructions are counted in the remainder.
const FOR_PAIRS: f64 = 0.7;
/// Typical time of counting instructions over that of the work alone.
const COUNTING: f64 = 80.0;

/// Judges `second` by `first`. `watch` is called at every step with the work that is done. Records do not include
/// scenes.
///
/// # Errors
/// [`PerformanceError`].
pub(crate) fn judge(
    first: &Side,
    second: &Side,
    works: &[Work],
    accepted: &AcceptedChanges,
    effort: Effort,
    stop: &AtomicBool,
    watch: &mut dyn FnMut(&Work),
) -> Result<Verdict, PerformanceError> {
    let mut verdict = Verdict {
        first: first.path().clone(),
        second: second.path().clone(),
        evidence: "results and counters; times and instructions are compared between two programs only".to_owned(),
        times_judged: false,
        is_undecided: false,
        workloads: Vec::new(),
        stages: Vec::new(),
    };
    if let (Side::Program(a), Side::Program(b)) = (first, second) {
        let programs = [a, b];
        let begin = Instant::now();
        let for_pairs = if effort.instructions { effort.budget.mul_f64(FOR_PAIRS) } else { effort.budget };
        let mut batch = |pairs: usize, until: Duration| -> Result<Vec<Timed>, PerformanceError> {
            let until = begin + until;
            let runs = in_turn(programs, works, pairs, until, stop, watch)?;
            Ok(works.iter().zip(&runs).map(|(work, runs)| Timed::new(work, runs)).collect())
        };
        // 1. One pair beforehand, so that files are read and the tyre is fitted.
        batch(1, Duration::ZERO)?;
        let before = begin.elapsed();
        // 2. A batch of pairs gives ratios of times.
        let first = batch(effort.pairs, for_pairs / 2)?;
        let mut pairs = vec![fewest_pairs(&first)];
        // Wall time for a second of work, with starts of programs and the load of the machine.
        let work: f64 = first.iter().map(|timed| 2.0 * pairs[0] as f64 * timed.whole().seconds).sum();
        let slowness = (begin.elapsed() - before).as_secs_f64() / work;
        verdict.workloads = first.iter().map(|timed| timed.verdict(accepted)).collect();
        verdict.stages = pooled(&first);
        if verdict.rows().any(|row| row.change != Change::None && row.change != Change::NotJudged) {
            // 3. If a stage seems changed, a second batch has to confirm it.
            let second = batch(effort.pairs, for_pairs)?;
            pairs.push(fewest_pairs(&second));
            for (found, again) in verdict.workloads.iter_mut().zip(&second) {
                confirm(&mut found.stages, &again.stages());
            }
            confirm(&mut verdict.stages, &pooled(&second));
        }
        if effort.instructions {
            // 4. Count instructions as far as the time allows.
            for (work, found) in works.iter().zip(&mut verdict.workloads) {
                watch(work);
                if stop.load(Ordering::Relaxed) {
                    return Err(PerformanceError::Interrupted);
                }
                let expected = found.whole.map_or(0.0, |whole| COUNTING * slowness * whole.seconds);
                if begin.elapsed().as_secs_f64() + expected > effort.budget.as_secs_f64() {
                    continue;
                }
                // Counts do not disturb each other: they run side by side if there are two processors.
                let count = |program: &Program| instructions::count(program, work);
                if let (Some((a, _)), Some((b, _))) = rayon::join(|| count(programs[0]), || count(programs[1])) {
                    found.instructions = Some((a.all, b.all));
                    for row in &mut found.stages {
                        row.instructions = a.of(&row.stage).zip(b.of(&row.stage));
                    }
                }
            }
        }
        let counted = verdict.workloads.iter().filter(|found| found.instructions.is_some()).count();
        verdict.times_judged = pairs.iter().all(|&pairs| are_enough(pairs, DOUBT));
        verdict.is_undecided = !verdict.times_judged && counted < works.len();
        verdict.evidence = format!(
            "results, counters, times of every stage in {} pairs of runs{}, and the instructions (exact) of {counted} \
             of {} workloads",
            pairs.iter().map(usize::to_string).collect::<Vec<_>>().join(" and "),
            if verdict.times_judged { "" } else { " (too few to judge by)" },
            works.len()
        );
        return Ok(verdict);
    }
    for work in works {
        watch(work);
        if stop.load(Ordering::Relaxed) {
            return Err(PerformanceError::Interrupted);
        }
        verdict.workloads.extend(by_counters(first, second, work, accepted)?);
    }
    Ok(verdict)
}

/// Counters of a side's workload, its instruction set and compiler; `None` if a record does not have the workload.
fn taken(side: &Side, work: &Work) -> Result<Option<(RecordedWorkload, String, String)>, PerformanceError> {
    Ok(match side {
        Side::Record(_, record) => record
            .workloads
            .get(&work.to_string())
            .map(|found| (found.clone(), record.stamp.instruction_set.clone(), record.stamp.compiler.clone())),
        Side::Program(program) => {
            let measurement = program.measure(work)?;
            let set = measurement.instruction_set.clone();
            Some((RecordedWorkload::new(&[measurement], None), set, String::new()))
        }
    })
}

fn by_counters(
    first: &Side,
    second: &Side,
    work: &Work,
    accepted: &AcceptedChanges,
) -> Result<Option<WorkloadVerdict>, PerformanceError> {
    let (Some((a, set_a, compiler_a)), Some((b, set_b, compiler_b))) = (taken(first, work)?, taken(second, work)?)
    else {
        return Ok(None);
    };
    let instructions = a.instructions.zip(b.instructions).filter(|_| compiler_a == compiler_b);
    let differences = differences(&work.to_string(), &a, &b, accepted, set_a != set_b);
    Ok(Some(WorkloadVerdict { instructions, ..WorkloadVerdict::new(work, differences, b.found) }))
}

/// Runs of some work by both programs, pair by pair: the first measurement of each, and the times \[s\] of the stages
/// that both have.
struct Timed {
    work: Work,
    first: [Measurement; 2],
    stages: Vec<(String, [Vec<f64>; 2])>,
}

impl Timed {
    fn new(work: &Work, runs: &[Vec<Measurement>; 2]) -> Self {
        let mut first = runs.each_ref().map(|runs| runs[0].clone());
        if matches!(work, Work::Scene(_)) {
            // The first program's result is the only reference for the second.
            first[1].found.expected = first[0].found.value;
        }
        let names = first[0].blocks.keys().filter(|stage| first[1].blocks.contains_key(*stage));
        let stages = names.map(|stage| {
            let [a, b] = runs.each_ref().map(|runs| -> Vec<&[Option<u64>]> {
                runs.iter().map(|run| run.blocks.get(stage).map_or(&[][..], Vec::as_slice)).collect()
            });
            let (a, b) = stage_times(&a, &b);
            (stage.clone(), [a, b])
        });
        Self { work: work.clone(), stages: stages.collect(), first }
    }

    /// Ratio of the sums over all stages.
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
        let differences = differences(&self.work.to_string(), &a, &b, accepted, false);
        let stages = self.stages();
        WorkloadVerdict { whole: Some(self.whole()), stages, ..WorkloadVerdict::new(&self.work, differences, b.found) }
    }
}

fn fewest_pairs(workloads: &[Timed]) -> usize {
    workloads.iter().map(|timed| timed.whole().pairs).min().unwrap_or(0)
}

/// Every stage pooled over all workloads in which its share is worth judging, if there are several.
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

/// Keeps only the changes that another batch confirms.
fn confirm(rows: &mut [StageVerdict], again: &[StageVerdict]) {
    for row in rows.iter_mut().filter(|row| row.change != Change::NotJudged) {
        if again.iter().all(|other| other.stage != row.stage || other.change != row.change) {
            row.change = Change::None;
        }
    }
}
