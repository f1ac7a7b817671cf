//! What a run's cost is shown as: options of `run` and `resume`.

use std::path::PathBuf;

use clap::Args;
use tyrewave::counters::{Timing, Watch};
use tyrewave::results::ResultsError;
use tyrewave::results::profile_table::cost_table;
use tyrewave::results::table::Report;
use tyrewave::results::trace::{chrome_trace, folded_stacks};
use tyrewave::run::RunReport;
use tyrewave::storage::PendingFile;

use super::context::Context;
use super::error::CliError;

/// How closely the cost of a run is watched, and where it is shown. The results are the same bytes.
#[derive(Clone, Debug, Default, Args)]
pub struct ProfileOptions {
    /// Print what every stage took, with rates and work counters, at the end; the numbers are also in summary.json.
    #[arg(long)]
    pub profile: bool,
    /// Also write when what happened, as Chrome trace events (for ui.perfetto.dev or chrome://tracing); outside of the
    /// results folder.
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Also write folded stacks in microseconds, for flame graphs; outside of the results folder.
    #[arg(long, value_name = "FILE")]
    pub folded: Option<PathBuf>,
}

/// Files that are written when the run is done.
#[derive(Debug)]
pub struct PendingProfile {
    profile: bool,
    trace: Option<PendingFile>,
    folded: Option<PendingFile>,
}

impl ProfileOptions {
    /// How the run is to be watched.
    pub fn watch(&self, context: &Context) -> Watch {
        let trace = self.trace.is_some() || self.folded.is_some();
        let timing = match (trace, self.profile) {
            (true, _) => Timing::Every,
            (false, true) => Timing::Closely,
            (false, false) => Timing::Sampled,
        };
        Watch { timing, trace, allocations: context.allocations }
    }

    /// Begins the files, before the run: a place that cannot be written to is refused now.
    ///
    /// # Errors
    /// As [`PendingFile::create`].
    pub fn begin(self) -> Result<PendingProfile, CliError> {
        let begin = |path: Option<PathBuf>| {
            path.map(|path| PendingFile::create(&path).map_err(ResultsError::creating(&path))).transpose()
        };
        Ok(PendingProfile { profile: self.profile, trace: begin(self.trace)?, folded: begin(self.folded)? })
    }
}

impl PendingProfile {
    /// Completes the files; returns the tables, where they are wanted.
    ///
    /// # Errors
    /// Of the files.
    pub fn complete(self, report: &RunReport) -> Result<Option<Report>, CliError> {
        if let Some(trace) = report.meter.trace() {
            let complete = |file: PendingFile, text: String| {
                let path = file.path().to_owned();
                file.complete(text).map_err(ResultsError::writing(&path))
            };
            if let Some(file) = self.trace {
                complete(file, chrome_trace(trace, &report.summary.title))?;
            }
            if let Some(file) = self.folded {
                complete(file, folded_stacks(trace))?;
            }
        }
        Ok(self.profile.then(|| cost_table(&report.summary.cost)))
    }
}
