//! `tyrewave resume`: continues an unfinished run.

use std::path::PathBuf;

use crate::results::ResultsFolder;
use crate::run;
use clap::Args;

use super::context::{Context, print};
use super::error::CliError;
use super::run::{ProfileOptions, end};

const EXAMPLES: &str = "\
A run that is not complete is in the folder RESULTS.partial-NUMBER, with a checkpoint of its state every minute \
(outputs.checkpoint_interval in the scene, in seconds; 0: only when it is interrupted). Ctrl-C and SIGTERM write a \
last checkpoint and keep everything as RESULTS.partial; after a killed process, a power cut or a full disk the last \
checkpoint remains. The results are the same bytes as those of a run without interruption, on any number of threads.

RESULTS is the results folder of the run or, if several runs of that name are unfinished, one of the unfinished \
folders. The scene is stored in it: its file is not needed, but the files of a measured road and of a tread pattern \
are. Refused are a damaged checkpoint, one of another version of tyrewave or of another scene, arrays that have \
changed since they were written, a road or a tread pattern that has changed, and a run that is still in progress.

Examples:
  tyrewave resume results/default
  tyrewave resume results/default.partial --threads 1";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ResumeArguments {
    /// Results folder of the run, or the folder of the unfinished run itself.
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    #[command(flatten)]
    profile: ProfileOptions,
}

impl ResumeArguments {
    /// Continues the run and prints where the results are.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        if let Some(place) = ResultsFolder::put_in_order(&self.results)? {
            let reported =
                format!("the run was complete, and its folder has been renamed\nresults in {}\n", place.display());
            return if context.options.quiet { Ok(()) } else { print(&reported) };
        }
        let (watch, profile) = (self.profile.watch(context), self.profile.begin()?);
        let report = run::resume(&self.results, context.threads, context.job(&mut context.progress()).watched(watch))?;
        end(&report, context, profile.complete(&report)?)
    }
}
