//! `tyrewave profile`: performance recorded and compared.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;

use crate::counters::peak::instruction_set;
use crate::performance::changes::read_accepted;
use crate::performance::compare::{ComparedSide, PerformanceError, compare};
use crate::performance::measure::{measure, measure_scene};
use crate::performance::record::PerformanceRecord;
use crate::performance::verdict::{Change, StageVerdict, TOLERATED, Verdict};
use crate::performance::workload::{SharedWork, Workload};
use crate::results::ResultsError;
use crate::results::table::aligned;
use clap::{Args, Subcommand};

use super::context::{Context, print};
use super::error::CliError;
use super::options::by_name;
use super::output_file::begin_both;

/// Folder of the committed records.
const RECORDS: &str = "profiles/record";
/// File of the accepted changes.
const ACCEPTED: &str = "profiles/accepted.toml";

/// Begin of a verdict in Markdown, by which an earlier one is recognised.
const MARKDOWN_HEAD: &str = "# Performance\n\n";
/// Begin of a verdict in JSON, by which an earlier one is recognised.
const JSON_HEAD: &str = "{\n  \"first\": \"";

const EXAMPLES: &str = "\
A fixed set of workloads (smooth, rough, high_speed, long_rollout, half_space_slices, direct_history, cells, sound, \
influence), each with exact counters and a physical result that is checked. Counters are compared exactly; times only \
between two programs that are run in turn, A B B A, on one thread: a ratio for every stage, with the 99.9 % confidence \
interval of the median ratio. A stage is slower, and the comparison fails, if the interval lies above 1.01; it is \
undecided if the loss may be 5 % of the workload's time. More --pairs make intervals narrower.

Examples:
  tyrewave profile record                              writes profiles/record/INSTRUCTIONS.json
  tyrewave profile compare                             this program against the committed record: results and counters
  tyrewave profile compare old/tyrewave new/tyrewave   two programs: results, counters and the time of every stage
  tyrewave profile compare old/tyrewave --scene my.toml   the same on a scene of your own that runs for about a second
  tyrewave profile compare old/tyrewave --markdown performance.md --json-file performance.json
  tyrewave profile measure rough                       one workload, as JSON";

/// Arguments of `tyrewave profile`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ProfileArguments {
    /// Removed: `cargo bench --bench instructions` counts instructions.
    #[arg(long, global = true, hide = true)]
    no_instructions: bool,
    /// Action on performance.
    #[command(subcommand)]
    pub action: ProfileAction,
}

/// Actions on performance.
#[derive(Clone, Debug, Subcommand)]
pub(crate) enum ProfileAction {
    /// Run all workloads and write their cost, with commit, compiler and machine.
    Record(RecordArguments),
    /// Compare a program or record with another one; exit code 1 if it is worse, 5 if that is undecided.
    Compare(CompareArguments),
    /// Removed: `cargo bench` and `tyrewave study` show costs against sizes.
    #[command(hide = true)]
    Scaling,
    /// Run one workload or a scene and print its cost as JSON; `compare` calls this command of each program.
    Measure {
        /// The workload.
        #[arg(value_parser = workload, required_unless_present = "scene")]
        workload: Option<Workload>,
        /// The scene, instead.
        #[arg(long, value_name = "SCENE", conflicts_with = "workload")]
        scene: Option<PathBuf>,
    },
}

/// Arguments of `tyrewave profile record`.
#[derive(Clone, Debug, Args)]
pub(crate) struct RecordArguments {
    /// Folder of the records.
    #[arg(long, value_name = "FOLDER", default_value = RECORDS)]
    pub out: PathBuf,
}

/// Arguments of `tyrewave profile compare`.
#[derive(Clone, Debug, Args)]
pub(crate) struct CompareArguments {
    /// A record (.json) or a program to compare with; default: the record of this processor's instructions in
    /// profiles/record.
    pub first: Option<PathBuf>,
    /// A record (.json) or a program to judge; default: this program.
    pub second: Option<PathBuf>,
    /// Pairs of runs at most, when two programs are compared.
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(12..=1000))]
    pub pairs: u32,
    /// Seconds after which no further pairs of runs begin; the verdict says how many there were.
    #[arg(long, value_name = "SECONDS", default_value_t = 180)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..90_000))]
    pub budget: u32,
    /// Only these workloads.
    #[arg(long = "workload", value_name = "NAME", value_parser = workload)]
    pub workloads: Vec<Workload>,
    /// Roll this scene, with two programs, beside the workloads that are named or instead of all of them. Their mean
    /// forces must agree within 0.1 %.
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// File of the accepted changes of counters.
    #[arg(long, value_name = "FILE", default_value = ACCEPTED)]
    pub accepted: PathBuf,
    /// Write the verdict as Markdown, too. An earlier one is replaced, any other file is refused.
    #[arg(long, value_name = "FILE")]
    pub markdown: Option<PathBuf>,
    /// Write the verdict as JSON, too. An earlier one is replaced, any other file is refused.
    #[arg(long, value_name = "FILE")]
    pub json_file: Option<PathBuf>,
}

impl ProfileArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        if self.no_instructions {
            let gone = "`--no-instructions` has been removed: instructions are counted by `cargo bench --features \
                        count-instructions --bench instructions`";
            return Err(CliError::Usage(gone.to_owned()));
        }
        match self.action {
            ProfileAction::Record(arguments) => arguments.execute(context),
            ProfileAction::Compare(arguments) => arguments.execute(context),
            ProfileAction::Scaling => Err(CliError::Usage(
                "`profile scaling` has been removed: `tyrewave study SCENE` shows cost against accuracy, `cargo bench` \
                 cost against sizes"
                    .to_owned(),
            )),
            ProfileAction::Measure { workload, scene } => {
                let stop = context.interrupt.flag();
                let scene = scene.unwrap_or_default();
                let measurement = workload.map_or_else(|| measure_scene(&scene, stop), |work| measure(work, stop))?;
                print(&format!("{}\n", serde_json::to_string(&measurement).unwrap_or_default()))
            }
        }
    }
}

/// Parses the name of a workload.
fn workload(text: &str) -> Result<Workload, String> {
    match text {
        "compliance" => Err("it has been removed: `influence` evaluates the compliance, too".to_owned()),
        name => by_name(Workload::ALL, Workload::name)(name),
    }
}

/// A record or program; default: this program.
fn side(path: Option<PathBuf>) -> Result<ComparedSide, CliError> {
    let path = path.map_or_else(std::env::current_exe, Ok);
    let path = path.map_err(|source| CliError::Read { path: "this program".into(), source })?;
    ComparedSide::of(path.clone()).map_err(|source| CliError::Read { path, source })
}

fn fixed(workload: Workload) -> SharedWork {
    SharedWork { name: workload.name().to_owned(), is_scene: false }
}

impl RecordArguments {
    fn execute(self, context: &Context) -> Result<(), CliError> {
        let program = side(None)?;
        let progress = context.bar("recording", Workload::ALL.len() as u64);
        let mut measured = Vec::new();
        for workload in Workload::ALL {
            progress.set_message(workload.name());
            if context.interrupt.flag().load(Ordering::Relaxed) {
                return Err(PerformanceError::Interrupted.into());
            }
            let measurement = program.measure(&fixed(workload))?;
            if let Some(complaint) = measurement.iter().find_map(|measurement| measurement.found.complaint()) {
                return Err(CliError::Failed(format!("nothing was recorded; {}: {complaint}", workload.name())));
            }
            measured.extend(measurement);
            progress.inc(1);
        }
        progress.finish_and_clear();
        let place = PerformanceRecord::place(&self.out, instruction_set());
        PerformanceRecord::new(measured).write(&place).map_err(ResultsError::writing(&place))?;
        print(&format!("{}\n", place.display()))
    }
}

/// The committed record that suits this processor best.
fn committed() -> PathBuf {
    let places =
        [instruction_set(), "x86-64-v3", "x86-64-v4"].map(|set| PerformanceRecord::place(Path::new(RECORDS), set));
    places.iter().find(|place| place.exists()).unwrap_or(&places[0]).clone()
}

impl CompareArguments {
    fn execute(self, context: &Context) -> Result<(), CliError> {
        let [markdown, json] = begin_both([(self.markdown, MARKDOWN_HEAD), (self.json_file, JSON_HEAD)])?;
        let (first, second) = (side(Some(self.first.unwrap_or_else(committed)))?, side(self.second)?);
        let accepted =
            read_accepted(&self.accepted).map_err(|source| CliError::Read { path: self.accepted, source })?;
        let are_programs = first.record.is_none() && second.record.is_none();
        if self.scene.is_some() && !are_programs {
            let wrong =
                "a record contains no scenes: `--scene` takes two programs, `profile compare OLD NEW --scene SCENE`";
            return Err(CliError::Usage(wrong.to_owned()));
        }
        let all = self.workloads.is_empty() && self.scene.is_none();
        let workloads = if all { Workload::ALL.to_vec() } else { self.workloads };
        let mut works: Vec<SharedWork> = workloads.into_iter().map(fixed).collect();
        works.extend(self.scene.map(|scene| SharedWork { name: scene.display().to_string(), is_scene: true }));
        let effort = (self.pairs as usize, Duration::from_secs(self.budget.into()));
        let rounds = if are_programs { 1 + effort.0 } else { 1 };
        let progress = context.bar("comparing", (works.len() * rounds) as u64);
        let mut watch = |work: &SharedWork| {
            progress.set_message(work.name.clone());
            progress.inc(1);
        };
        let stop = context.interrupt.flag();
        let verdict = compare([&first, &second], &works, &accepted, effort, stop, &mut watch)?;
        progress.finish_and_clear();
        let as_json = serde_json::to_string_pretty(&verdict).unwrap_or_default() + "\n";
        if let Some(file) = markdown {
            file.complete(&format!("{MARKDOWN_HEAD}```text\n{}```\n", text(&verdict)))?;
        }
        if let Some(file) = json {
            file.complete(&as_json)?;
        }
        print(&if context.options.json { as_json } else { text(&verdict) })?;
        if !verdict.passes() {
            Err(CliError::Worse)
        } else if verdict.is_undecided {
            Err(CliError::Undecided)
        } else {
            Ok(())
        }
    }
}

/// A verdict in words: times of the stages, complaints, outcome.
fn text(verdict: &Verdict) -> String {
    let Verdict { first, second, evidence, is_undecided, workloads } = verdict;
    let (first, second, count) = (first.display(), second.display(), workloads.len());
    let rows: Vec<_> =
        workloads.iter().flat_map(|found| found.stages.iter().map(|row| cells(&found.workload, row))).collect();
    let table = if rows.is_empty() {
        String::new()
    } else {
        let header = ["workload", "stage", "share", "time, first", "ratio", "interval", "verdict"];
        let undecided = 100.0 * TOLERATED;
        format!("{}\nundecided: may have cost {undecided:.0} % of the workload's time\n\n", aligned(header, rows))
    };
    let complaints = workloads.iter().flat_map(|found| found.complaints.iter().map(|words| (&found.workload, words)));
    let complaints: String = complaints.map(|(workload, words)| format!("{workload}: {words}\n")).collect();
    let outcome = match (verdict.passes(), is_undecided) {
        (false, _) => "the second is worse",
        (true, true) => "results correct, counters as expected; times undecided",
        (true, false) => "results correct, counters as expected; no stage slower",
    };
    format!("{second} compared with {first}\n\n{table}{complaints}{count} workloads: {outcome}\nbased on {evidence}\n")
}

fn cells(workload: &str, StageVerdict { stage, share, ratio, change }: &StageVerdict) -> [String; 7] {
    let change = match change {
        Change::Same => "same",
        Change::Slower => "SLOWER",
        Change::Faster => "faster",
        Change::Undecided => "undecided",
    };
    let [share, time] = [format!("{:.0} %", 100.0 * share), format!("{:.1} ms", 1e3 * ratio.seconds)];
    let [median, interval] = [format!("{:.3}", ratio.median), format!("{:.3} - {:.3}", ratio.low, ratio.high)];
    [workload.to_owned(), stage.clone(), share, time, median, interval, change.to_owned()]
}
