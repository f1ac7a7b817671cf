//! `tyrewave cache`: what is kept on disk for the next run.

use crate::contact::pressed::KeptBlock;
use crate::effects::sound::KeptReceiver;
use crate::results::table::{Report, row, words};
use crate::storage::{Cache, Cached};
use crate::tyre::influence::{CellInfluence, SurfaceWaves};
use crate::tyre::poles::RationalModel;
use crate::tyre::poles::pole_model::PoleModel;
use clap::{Args, Subcommand};

use super::context::{Context, print};
use super::error::CliError;

const EXAMPLES: &str = "\
A fitted tyre serves every time step and road at its speed, the waves that are heard of it every road, its transfers \
to a receiver every road and speed whose patch is as long, a block of pressed road every run with that tread and those \
cells; all are kept in TYREWAVE_CACHE_DIR, or the platform's cache folder, up to an eighth of the room on its disk \
(2 GiB at least, 32 at most); the least recently used go first. An entry that is damaged or of another version is \
rebuilt when it is needed.

Examples:
  tyrewave cache list
  tyrewave cache clear";

/// Arguments of `tyrewave cache`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct CacheArguments {
    /// Action on the cache.
    #[command(subcommand)]
    pub action: CacheAction,
}

/// Actions on the cache.
#[derive(Clone, Copy, Debug, Subcommand)]
pub enum CacheAction {
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
                    CellInfluence::KIND,
                    KeptBlock::KIND,
                    KeptReceiver::KIND,
                    SurfaceWaves::KIND,
                ])?;
                let rows = entries.iter().map(|entry| {
                    let state =
                        entry.usable.map_or_else(|reason| format!("not usable: {reason}"), |()| "usable".into());
                    let name = entry.path.file_name().unwrap_or_default().to_string_lossy();
                    row([&name, &format!("{:.1}", entry.bytes as f64 / 1e3), &state])
                });
                let mut report = Report::default();
                report.table(words(["entry", "kB", "state"], rows));
                let total: u64 = entries.iter().map(|entry| entry.bytes).sum();
                report.text(format!("{} entries, {:.1} MB in {folder}\n", entries.len(), total as f64 / 1e6));
                context.print_report(&report)
            }
        }
    }
}
