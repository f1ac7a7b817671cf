//! `tyrewave cache`: what is stored on disk for the next run.

use crate::contact::pressed::CachedBlock;
use crate::radiation::stored::StoredReceiver;
use crate::results::table::{Report, row, words};
use crate::storage::{Cache, Cached};
use crate::tyre::influence::{CellInfluence, SurfaceWaves};
use crate::tyre::poles::RationalModel;
use crate::tyre::poles::pole_model::PoleModel;
use crate::tyre::poles::traction_model::TractionModel;
use clap::{Args, Subcommand};

use super::context::{Context, print};
use super::error::CliError;

const EXAMPLES: &str = "\
The cache holds what later runs can use again: influence functions of a tyre (for all time steps and roads at the same \
speed), its surface waves (for all roads), its radiation transfers to a receiver (for all roads and speeds with the \
same patch length), and pressed roads (for all runs with the same tread and cells). It is in TYREWAVE_CACHE_DIR or in \
the platform's cache folder, and takes at most an eighth of the space on its disk (at least 2 GiB, at most 32 GiB); \
the least recently used entries are removed first. An entry that is damaged or of another version is computed again \
when it is needed.

Examples:
  tyrewave cache list
  tyrewave cache clear";

/// Arguments of `tyrewave cache`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct CacheArguments {
    /// Action on the cache.
    #[command(subcommand)]
    pub action: CacheAction,
}

/// Actions on the cache.
#[derive(Clone, Copy, Debug, Subcommand)]
pub(crate) enum CacheAction {
    /// List the entries with their size and whether they can be used.
    List,
    /// Remove all entries.
    Clear,
}

impl CacheArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let cache = Cache::open()?;
        let folder = cache.folder().display();
        match self.action {
            CacheAction::Clear => {
                let (removed, failed) = cache.clear()?;
                print(&format!("{removed} entries removed from {folder}\n"))?;
                match failed.first() {
                    None => Ok(()),
                    Some(first) => Err(CliError::Failed(format!("{} cannot be removed: {first}", failed.len()))),
                }
            }
            CacheAction::List => {
                let entries = cache.list(&[
                    RationalModel::KIND,
                    PoleModel::KIND,
                    TractionModel::KIND,
                    CellInfluence::KIND,
                    CachedBlock::KIND,
                    StoredReceiver::KIND,
                    SurfaceWaves::KIND,
                ])?;
                let rows = entries.iter().map(|entry| {
                    let state =
                        entry.usable.map_or_else(|reason| format!("not usable: {reason}"), |()| "usable".into());
                    let name = entry.path.file_name().unwrap_or_default().to_string_lossy();
                    row([&name, &format!("{:.1}", entry.bytes as f64 / 1e3), &state])
                });
                let mut report = Report::from(words(["entry", "kB", "state"], rows));
                let total: u64 = entries.iter().map(|entry| entry.bytes).sum();
                report.text(format!("{} entries, {:.1} MB in {folder}\n", entries.len(), total as f64 / 1e6));
                context.print_report(&report)
            }
        }
    }
}
