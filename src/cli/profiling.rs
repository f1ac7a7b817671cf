//! Views of a run's cost: options of `run` and `resume`.

use std::path::PathBuf;

use crate::counters::{Timing, Watch};
use crate::results::profile_table::cost_table;
use crate::results::table::Report;
use crate::results::trace::{FOLDED_HEAD, TRACE_HEAD, chrome_trace, folded_stacks};
use crate::run::RunReport;
use clap::Args;

use super::context::Context;
use super::error::CliError;
use super::output_file::{OutputFile, Replaces, check_apart};

/// How closely the cost of a run is watched, and where it is shown. The results are the same bytes.
#[derive(Clone, Debug, Default, Args)]
pub(super) struct ProfileOptions {
    /// Print the time of every stage, with rates and work counters, at the end; the numbers are also in summary.json.
    #[arg(long)]
    pub profile: bool,
    /// Also write a time line, as Chrome trace events (for ui.perfetto.dev or chrome://tracing), outside of the results
    /// folder. An earlier trace is replaced, any other file is refused.
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Also write folded stacks in microseconds, for flame graphs; outside of the results folder. Earlier
    /// ones are replaced, any other file is refused.
    #[arg(long, value_name = "FILE")]
    pub folded: Option<PathBuf>,
}

/// Files that are written when the run is done.
#[derive(Debug)]
pub(super) struct PendingProfile {
    profile: bool,
    trace: Option<OutputFile<'static>>,
    folded: Option<OutputFile<'static>>,
}

impl ProfileOptions {
    /// Extent of the measurements that the requested views need.
    pub(super) fn watch(&self, context: &Context) -> Watch {
        let trace = self.trace.is_some() || self.folded.is_some();
        let timing = match (trace, self.profile) {
            (true, _) => Timing::Every,
            (false, true) => Timing::Closely,
            (false, false) => Timing::Sampled,
        };
        Watch { timing, trace, allocations: context.allocations }
    }

    /// Creates the files before the run: a path that cannot be written to is refused now.
    ///
    /// # Errors
    /// As [`OutputFile::begin`].
    pub(super) fn begin(self) -> Result<PendingProfile, CliError> {
        let Self { profile, trace, folded } = self;
        check_apart(trace.as_deref(), folded.as_deref())?;
        let begin = |path: Option<PathBuf>, head: &'static str| {
            path.map(|path| OutputFile::begin(&path, Replaces::Beginning(head))).transpose()
        };
        Ok(PendingProfile { profile, trace: begin(trace, TRACE_HEAD)?, folded: begin(folded, FOLDED_HEAD)? })
    }
}

impl PendingProfile {
    /// Completes the files; returns the tables if they are wanted.
    ///
    /// # Errors
    /// Errors of the files.
    pub(super) fn complete(self, report: &RunReport) -> Result<Option<Report>, CliError> {
        if let Some(trace) = report.meter.trace() {
            if let Some(file) = self.trace {
                file.complete(&chrome_trace(trace, &report.summary.title))?;
            }
            if let Some(file) = self.folded {
                file.complete(&folded_stacks(trace))?;
            }
        }
        Ok(self.profile.then(|| cost_table(&report.summary.cost)))
    }
}
