//! `tyrewave resume`: continues an unfinished run.

use std::path::PathBuf;

use crate::results::ResultsFolder;
use crate::run;
use clap::Args;

use super::context::{Context, print};
use super::error::CliError;
use super::profiling::ProfileOptions;
use super::run::end;

const EXAMPLES: &str = "\
While a run goes on it stands in RESULTS.partial-NUMBER, with a checkpoint of its state every minute \
(outputs.checkpoint_interval in the scene, in seconds; 0 for none but at an interruption). Ctrl-C and SIGTERM write \
one more and keep everything as RESULTS.partial; a killed process, a power cut or a full disk leaves the last one. The \
results are the same bytes as if the run had never stopped, on any number of threads.

RESULTS is the folder that the run would have written to, or the unfinished one itself where there are several. The \
scene is kept with it: its file is not needed, but those of a measured road and of a tread's map are. Refused are a \
checkpoint of another version of tyrewave or another scene, a damaged one, arrays that do not hold what was written to \
them, a road or a map \
that has changed, and a run that is still going on.

Examples:
  tyrewave resume results/default
  tyrewave resume results/default.partial --threads 1";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ResumeArguments {
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
            let told = format!(
                "the run had reached its end, and its results have their name now\nresults in {}\n",
                place.display()
            );
            return if context.options.quiet { Ok(()) } else { print(&told) };
        }
        let (watch, profile) = (self.profile.watch(context), self.profile.begin()?);
        let (stop, mut progress) = (context.interrupt.flag(), context.progress());
        let report = run::resume(&self.results, context.threads, watch, stop, &mut progress)?;
        drop(progress);
        end(&report, context, profile.complete(&report)?)
    }
}
