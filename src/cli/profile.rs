//! `tyrewave profile`: performance recorded and compared.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;

use crate::counters::machine::instruction_set;
use crate::performance::changes::AcceptedChanges;
use crate::performance::judge::{Effort, Side, judge};
use crate::performance::program::Program;
use crate::performance::record::RecordedWorkload;
use crate::performance::report::{JSON_HEAD, MARKDOWN_HEAD};
use crate::performance::{Measurement, PerformanceError, Record, Work, Workload, instructions, measure, measure_scene};
use clap::{Args, Subcommand};

use super::context::{Context, print};
use super::error::CliError;
use super::options::by_name;
use super::output_file::{OutputFile, Replaces, check_apart};

/// Folder of the committed records.
const RECORDS: &str = "profiles/record";
/// File of the accepted changes.
const ACCEPTED: &str = "profiles/accepted.toml";

const EXAMPLES: &str = "\
A fixed set of workloads (smooth, rough, high_speed, long_rollout, half_space_slices, direct_history, cells, sound, \
compliance, influence), each with exact counters and a physical value that it must find. Counters are compared \
exactly; times only between two programs that are run in turn, A B B A, on one thread, with the ratio of every stage \
and its interval, of each workload and of all pooled; so are instructions of every stage, exactly, where valgrind is \
installed. The verdict says how many pairs of runs and counts of instructions it rests on: as many as fit into \
--budget.

Examples:
  tyrewave profile record                              writes profiles/record/INSTRUCTIONS.json
  tyrewave profile compare                             this program against the committed record: results and counters
  tyrewave profile compare old/tyrewave new/tyrewave   two programs: results, counters and the time of every stage
  tyrewave profile compare old/tyrewave --scene my.toml   the same on a scene of your own, of a second or so
  tyrewave profile compare old/tyrewave --markdown performance.md --json-file performance.json
  tyrewave profile measure rough                       one workload, as JSON";

/// Arguments of `tyrewave profile`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ProfileArguments {
    /// Action on performance.
    #[command(subcommand)]
    pub action: ProfileAction,
}

/// Actions on performance.
#[derive(Clone, Debug, Subcommand)]
pub enum ProfileAction {
    /// Do all workloads and write what they took, stamped with commit, compiler and machine.
    Record(RecordArguments),
    /// Hold a program or record against another one; exit code 1 if it is worse, 5 if that cannot
    /// be said.
    Compare(CompareArguments),
    /// Gone: `cargo bench` and `tyrewave study` show costs against sizes.
    #[command(hide = true)]
    Scaling,
    /// Do one workload, or roll a scene, and print what it took as JSON: what `compare` asks of each program.
    Measure {
        /// The workload.
        #[arg(value_parser = by_name(Workload::ALL, Workload::name), required_unless_present = "scene")]
        workload: Option<Workload>,
        /// The scene, instead.
        #[arg(long, value_name = "SCENE", conflicts_with = "workload")]
        scene: Option<PathBuf>,
    },
}

/// Arguments of `tyrewave profile record`.
#[derive(Clone, Debug, Args)]
pub struct RecordArguments {
    /// Folder of the records.
    #[arg(long, value_name = "FOLDER", default_value = RECORDS)]
    pub out: PathBuf,
    /// Do not count instructions, even if valgrind is there (it takes some minutes).
    #[arg(long)]
    pub no_instructions: bool,
}

/// Arguments of `tyrewave profile compare`.
#[derive(Clone, Debug, Args)]
pub struct CompareArguments {
    /// A record (.json) or a program to hold against; default: the record of this processor's instructions in
    /// profiles/record.
    pub first: Option<PathBuf>,
    /// A record (.json) or a program to judge; default: this program.
    pub second: Option<PathBuf>,
    /// Pairs of runs in a batch at most, when two programs are compared.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(12..=1000))]
    pub pairs: u32,
    /// Seconds that it may take to compare two programs; pairs of runs and counts of instructions for which that is too
    /// short are left out, and the verdict says what it rests on.
    #[arg(long, value_name = "SECONDS", default_value_t = 180)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..90_000))]
    pub budget: u32,
    /// Do not count instructions of two programs, even if valgrind is there (it takes some minutes).
    #[arg(long)]
    pub no_instructions: bool,
    /// Only these workloads.
    #[arg(long = "workload", value_name = "NAME", value_parser = by_name(Workload::ALL, Workload::name))]
    pub workloads: Vec<Workload>,
    /// Roll this scene, with two programs, beside the workloads that are named or instead of all of them. Their mean
    /// forces must agree within 0.1 %.
    #[arg(long, value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// File of the changes of counters that are wanted.
    #[arg(long, value_name = "FILE", default_value = ACCEPTED)]
    pub accepted: PathBuf,
    /// Write the verdict as Markdown, too. An earlier one is replaced, any other file refused.
    #[arg(long, value_name = "FILE")]
    pub markdown: Option<PathBuf>,
    /// Write the verdict as JSON, too. An earlier one is replaced, any other file refused.
    #[arg(long, value_name = "FILE")]
    pub json_file: Option<PathBuf>,
}

impl ProfileArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        match self.action {
            ProfileAction::Record(arguments) => arguments.execute(context),
            ProfileAction::Compare(arguments) => arguments.execute(context),
            ProfileAction::Scaling => Err(CliError::Usage(
                "`profile scaling` is gone: `tyrewave study SCENE` shows cost against accuracy, `cargo bench` \
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

fn this_program() -> Result<PathBuf, CliError> {
    std::env::current_exe().map_err(|source| CliError::Read { path: "this program".into(), source })
}

impl RecordArguments {
    /// Runs per workload: the record has medians of their shares of the time.
    const RUNS: usize = 5;

    fn execute(self, context: &Context) -> Result<(), CliError> {
        let program = Program::new(this_program()?);
        let counts = !self.no_instructions && instructions::can_count();
        let progress = context.bar("recording", Workload::ALL.len() as u64);
        let mut native = BTreeMap::new();
        // Instructions may have been counted on another (emulated) processor: they are recorded by its instruction set.
        let mut counted: BTreeMap<String, BTreeMap<String, RecordedWorkload>> = BTreeMap::new();
        for workload in Workload::ALL {
            progress.set_message(workload.name());
            let mut measured: Vec<Measurement> = Vec::new();
            for _ in 0..Self::RUNS {
                if context.interrupt.flag().load(Ordering::Relaxed) {
                    return Err(PerformanceError::Interrupted.into());
                }
                measured.push(program.measure(&Work::Fixed(workload))?);
            }
            let found = &measured[0].found;
            if !found.is_right() {
                let name = workload.name();
                return Err(CliError::Failed(format!("workload {name} is wrong and was not recorded: {found}")));
            }
            let recorded = RecordedWorkload::new(&measured, None);
            native.insert(workload.name().to_owned(), recorded.clone());
            let by_tool = if counts { instructions::count(&program, &Work::Fixed(workload)) } else { None };
            if context.interrupt.flag().load(Ordering::Relaxed) {
                return Err(PerformanceError::Interrupted.into());
            }
            if let Some((count, by_tool)) = by_tool {
                let set = by_tool.instruction_set.clone();
                let shares = recorded.shares.clone();
                let recorded = RecordedWorkload { shares, ..RecordedWorkload::new(&[by_tool], Some(count.all)) };
                counted.entry(set).or_default().insert(workload.name().to_owned(), recorded);
            }
            progress.inc(1);
        }
        progress.finish_and_clear();
        counted.entry(instruction_set().to_owned()).or_insert(native);
        for (set, workloads) in counted {
            let place = Record::place(&self.out, &set);
            Record::new(&set, workloads).write(&place)?;
            print(&format!("{}\n", place.display()))?;
        }
        Ok(())
    }
}

/// The committed record that suits this processor best.
fn committed() -> Result<PathBuf, CliError> {
    let folder = Path::new(RECORDS);
    let own = Record::place(folder, instruction_set());
    if own.exists() {
        return Ok(own);
    }
    let listed = std::fs::read_dir(folder).map_err(|source| CliError::Read { path: folder.to_owned(), source })?;
    let mut records: Vec<PathBuf> = listed.flatten().map(|entry| entry.path()).collect();
    records.sort();
    let record = records.into_iter().find(|path| path.extension().is_some_and(|extension| extension == "json"));
    Ok(record.unwrap_or(own))
}

impl CompareArguments {
    fn execute(self, context: &Context) -> Result<(), CliError> {
        check_apart(self.markdown.as_deref(), self.json_file.as_deref())?;
        let begin = |path: Option<PathBuf>, head: &'static str| {
            path.map(|path| OutputFile::begin(&path, Replaces::Beginning(head))).transpose()
        };
        let (markdown, json) = (begin(self.markdown, MARKDOWN_HEAD)?, begin(self.json_file, JSON_HEAD)?);
        let first = Side::of(self.first.map_or_else(committed, Ok)?)?;
        let second = Side::of(self.second.map_or_else(this_program, Ok)?)?;
        let accepted = AcceptedChanges::read(&self.accepted)?;
        let programs = matches!((&first, &second), (Side::Program(_), Side::Program(_)));
        if self.scene.is_some() && !programs {
            let wrong =
                "a record knows no scenes: `--scene` takes two programs, `profile compare OLD NEW --scene SCENE`";
            return Err(CliError::Usage(wrong.to_owned()));
        }
        let all = self.workloads.is_empty() && self.scene.is_none();
        let mut works = Work::fixed(if all { &Workload::ALL } else { &self.workloads });
        works.extend(self.scene.map(Work::Scene));
        let instructions = !self.no_instructions && instructions::can_count();
        let effort =
            Effort { pairs: self.pairs as usize, instructions, budget: Duration::from_secs(self.budget.into()) };
        // The second batch runs only if it is needed: the bar may end early.
        let steps = if programs { 2 * effort.pairs + 1 + usize::from(instructions) } else { 1 };
        let progress = context.bar("comparing", (works.len() * steps) as u64);
        let mut watch = |work: &Work| {
            progress.set_message(work.to_string());
            progress.inc(1);
        };
        let stop = context.interrupt.flag();
        let verdict = judge(&first, &second, &works, &accepted, effort, stop, &mut watch)?;
        progress.finish_and_clear();
        if let Some(file) = markdown {
            file.complete(&verdict.markdown())?;
        }
        if let Some(file) = json {
            file.complete(&verdict.json())?;
        }
        print(&if context.options.json { verdict.json() } else { verdict.text() })?;
        if !verdict.passes() {
            Err(CliError::Worse)
        } else if verdict.is_undecided {
            Err(CliError::Undecided)
        } else {
            Ok(())
        }
    }
}
