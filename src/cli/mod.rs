//! The command line: one file per command, a folder for `paper`.
//!
//! [`command_line`] is the whole program: it reads the arguments, listens for Ctrl-C, starts the threads, executes the
//! command on them, and turns its error into a message on standard error and an exit code.

mod cache;
mod check;
mod compliance;
mod context;
mod effects;
mod emission;
mod error;
mod export;
mod fit_tyre;
mod indent;
mod init;
mod interrupt;
mod keys;
mod mobility;
mod options;
mod output_file;
mod paper;
mod plan;
mod profile;
mod progress;
mod progress_log;
mod radiation;
mod report;
mod resume;
mod road;
mod run;
mod shell;
mod side;
mod slices;
mod study;
mod sweep;
mod sweep_tasks;
mod tyre;
mod tyre_size;
mod tyre_views;
mod validate;

use std::process::ExitCode;

use crate::counters::AllocationProbe;
use clap::{CommandFactory, Parser, Subcommand};

use context::Context;
use error::{CliError, write_message};
use interrupt::Interrupt;
use options::GlobalOptions;

/// Text of the whole program's `--help` after the list of commands.
const AFTER_HELP: &str = "\
Exit codes:
  0    done
  1    the run failed
  2    the command line, the scene or an input file is invalid, or an existing file or folder must not be replaced; \
nothing was written
  3    the results, or standard output, could not be written; there is no results folder, but a run is kept up to its \
last checkpoint as <results>.partial
  4    done, and the results are complete in their folder, but standard output could not be written
  5    a comparison of performance is undecided: times scatter too much, or there were too few runs
  130  interrupted (Ctrl-C, SIGTERM); a run that had begun to roll is kept as <results>.partial, and tyrewave resume \
continues it

Examples:
  tyrewave run scenes/default.toml
  tyrewave run scenes/default.toml --out /tmp/trial --threads 1 --profile
  tyrewave help run";

/// The sound of a tyre rolling on a rough road.
///
/// A scene (a TOML file) describes the tyre, the road, the speed and the load. tyrewave computes the tyre's response
/// functions and the road's texture under the patch, and solves for the contact forces in the time domain, step by
/// step.
#[derive(Debug, Parser)]
#[command(name = "tyrewave", version, arg_required_else_help = true, after_help = AFTER_HELP)]
pub(crate) struct CommandLine {
    #[command(flatten)]
    options: GlobalOptions,
    /// Command to execute.
    #[command(subcommand)]
    pub command: Command,
}

/// Declares the commands, each carried out by the `execute` of its arguments.
macro_rules! commands {
    ($($(#[$help:meta])* $name:ident($arguments:ty),)*) => {
        /// Commands of tyrewave.
        #[derive(Clone, Debug, Subcommand)]
        pub(crate) enum Command {
            $($(#[$help])* $name($arguments),)*
        }

        impl Command {
            fn execute(self, context: &Context) -> Result<(), CliError> {
                match self {
                    $(Self::$name(arguments) => arguments.execute(context),)*
                }
            }
        }
    };
}

commands! {
    /// Simulate a rolling tyre: contact forces, spectra, vibration, sound.
    Run(run::RunArguments),
    /// Show the settings of a run with their reasons, its work, time and memory; nothing is simulated.
    Plan(plan::PlanArguments),
    /// Write a commented scene with its tyre to begin with, and a schema for editors.
    Init(init::InitArguments),
    /// Check scenes for mistakes without running them.
    Check(check::CheckArguments),
    /// List every key of a scene with its default, bounds and meaning, or print the JSON Schema.
    Keys(keys::KeysArguments),
    /// Show the contribution of each effect: levels, force, patch, time and memory with and without it.
    Effects(effects::EffectsArguments),
    /// Show accuracy against computing time for each numerical setting: errors, work, and the most efficient settings.
    Study(study::StudyArguments),
    /// Continue a run that was interrupted or killed; its results are the same bytes.
    Resume(resume::ResumeArguments),
    /// Run a scene at many speeds, loads and roads: one table of levels and of their growth with speed.
    Sweep(sweep::SweepArguments),
    /// Fit levels of a sweep against speed, for traffic noise models: CNOSSOS-EU, Nord2000, UN R117.
    Emission(emission::EmissionArguments),
    /// Make one HTML page of results: pictures, tables, sound.
    Report(report::ReportArguments),
    /// Compare results: settings, figures, third octaves.
    Compare(report::CompareArguments),
    /// Compare a tyre with published values: levels, shapes, growth, roads, rolling resistance, modes.
    Validate(validate::ValidateArguments),
    /// Reproduce the figures and statements of the paper that the model is based on, and compare them with it.
    Paper(paper::PaperArguments),
    /// Export results to other programs: MATLAB, universal files, VTK.
    Export(export::ExportArguments),
    /// Analyse a scene's tyre: modes, stiffness and patch under loads, mobility.
    Tyre(tyre::TyreArguments),
    /// Compute the driving-point mobility of the tread surface, as CSV and as a plot.
    Mobility(mobility::MobilityArguments),
    /// Identify a tyre from measured driving-point mobilities.
    FitTyre(fit_tyre::FitTyreArguments),
    /// Analyse the sound radiation of a scene's tyre: horn effect, transfer functions, directivity, cost.
    Radiation(radiation::RadiationArguments),
    /// Compute pressures around spheres and tyres by boundary elements, case by case.
    RadiationCases(radiation::RadiationCasesArguments),
    /// Describe and draw a scene's road.
    Road(road::RoadArguments),
    /// Record the cost of fixed workloads, and compare two records or programs.
    Profile(profile::ProfileArguments),
    /// Compute the surface compliance and belt transfer of layered tyres, case by case.
    Compliance(compliance::ComplianceArguments),
    /// List or clear the cache on disk: influence functions, surface waves, radiation transfers, pressed roads.
    Cache(cache::CacheArguments),
    /// Draw a slice of a scene's road and its stiffness by both contact laws, with statistics over the road.
    Slices(slices::SlicesArguments),
    /// Press a rough height map into an elastic half-space: load, penetration, contact area, pressure.
    Indent(indent::IndentArguments),
    /// Print completions for a shell.
    Completions(shell::CompletionsArguments),
    /// Write man pages.
    Man(shell::ManArguments),
}

type Execute = fn(Command, &Context) -> Result<(), CliError>;

/// Executes the command line of this process on a thread pool, and returns the exit code for `main`. `allocations`
/// reads the counters of the program's allocator, if it counts.
pub fn command_line(allocations: Option<AllocationProbe>) -> ExitCode {
    interrupt::outlive_file_limits();
    let line = match CommandLine::try_parse() {
        Ok(line) => line,
        Err(answer) => return options::answered(&answer),
    };
    let colour = options::allows_colour(line.options.color);
    match carry_out(line, colour, allocations, Command::execute) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            write_message(&options::error_line(&error.render(colour), colour));
            ExitCode::from(error.exit_code())
        }
    }
}

fn carry_out(
    line: CommandLine,
    colour: bool,
    allocations: Option<AllocationProbe>,
    execute: Execute,
) -> Result<(), CliError> {
    let CommandLine { options, command } = line;
    let wanted = options.threads()?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(wanted)
        .build()
        .map_err(|error| CliError::Failed(format!("cannot start {wanted} threads: {error}")))?;
    let interrupt = Interrupt::listen()?;
    let threads = pool.current_num_threads();
    let context = Context { options, threads, colour, interrupt, allocations, program: CommandLine::command };
    pool.install(|| execute(command, &context))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_sound_and_documents_its_exit_codes() {
        CommandLine::command().debug_assert();
        let help = CommandLine::command().render_long_help().to_string();
        for code in
            [error::FAILED, error::USAGE, error::NOT_WRITABLE, error::UNPRINTED, error::UNDECIDED, error::INTERRUPTED]
        {
            assert!(help.lines().any(|line| line.trim_start().starts_with(&format!("{code} "))), "{code}: {help}");
        }
    }

    #[test]
    fn every_command_teaches_by_example() {
        let mut command = CommandLine::command();
        let names: Vec<String> = command.get_subcommands().map(|command| command.get_name().to_owned()).collect();
        assert_eq!(names.len(), 28);
        for name in names {
            let help = command.find_subcommand_mut(&name).unwrap().render_long_help().to_string();
            assert!(help.contains("Examples:") && help.contains(&format!("tyrewave {name} ")), "{help}");
        }
    }

    #[test]
    fn a_command_runs_on_its_threads_and_returns_its_error() {
        let line = CommandLine::try_parse_from(["tyrewave", "run", "a.toml", "--threads", "2", "-q"]).unwrap();
        let outcome = carry_out(line, false, None, |command, context| {
            assert_eq!((context.threads, rayon::current_num_threads()), (2, 2));
            assert!(context.options.quiet && matches!(command, Command::Run(_)));
            Err(CliError::Interrupted { partial: None })
        });
        assert_eq!(outcome.unwrap_err().exit_code(), 130);
    }

    #[test]
    fn mistakes_on_the_line_are_usage_errors() {
        for line in [&["tyrewave", "walk"][..], &["tyrewave", "run"], &["tyrewave", "run", "a.toml", "--threads", "0"]]
        {
            let error = CommandLine::try_parse_from(line).unwrap_err();
            assert_eq!(error.exit_code(), i32::from(error::USAGE), "{line:?}");
        }
    }
}
