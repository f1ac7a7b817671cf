//! `tyrewave cache`: what is stored on disk for the next run.

use std::ffi::OsStr;

use crate::contact::cells::history::FewerPoles;
use crate::contact::pressed::CachedBlock;
use crate::radiation::stored::StoredReceiver;
use crate::results::table::{Report, aligned, row, words};
use crate::storage::{Cache, Cached};
use crate::tyre::influence::{CellInfluence, SurfaceWaves};
use crate::tyre::poles::RationalModel;
use crate::tyre::poles::pole_model::PoleModel;
use crate::tyre::poles::traction_model::TractionModel;
use clap::{Args, Subcommand};

use super::context::{Context, print};
use super::error::CliError;

const EXAMPLES: &str = "\
The cache holds what later runs can use again: influence functions of a tyre (for all time steps and roads at the \
same speed), poles of cells for a time step (for all roads), its surface waves (for all roads), its radiation \
transfers to a receiver (for all roads and speeds with the same patch length), and pressed roads (for all runs with \
the same tread and cells). It is in TYREWAVE_CACHE_DIR or in the platform's cache folder, and takes at most an eighth \
of the space on its disk (at least 2 GiB, at most 32 GiB); the least recently used entries are removed first. An \
entry that is damaged or of another version is computed again when it is needed.

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
    /// List the entries by what they hold, with their size, and those that cannot be used.
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
                let kinds = [
                    RationalModel::KIND,
                    PoleModel::KIND,
                    FewerPoles::KIND,
                    TractionModel::KIND,
                    CellInfluence::KIND,
                    CachedBlock::KIND,
                    StoredReceiver::KIND,
                    SurfaceWaves::KIND,
                ];
                let entries = cache.list(&kinds)?;
                let (usable, others): (Vec<_>, Vec<_>) = entries.iter().partition(|entry| entry.usable.is_ok());
                let megabytes = |bytes: u64| format!("{:.1}", bytes as f64 / 1e6);
                let of_kind = kinds.iter().filter_map(|kind| {
                    let extension = OsStr::new(kind.extension);
                    let sizes = usable.iter().filter(|entry| entry.path.extension() == Some(extension));
                    let sizes: Vec<u64> = sizes.map(|entry| entry.bytes).collect();
                    let total = megabytes(sizes.iter().sum());
                    (!sizes.is_empty()).then(|| row([&kind.format.name, &sizes.len(), &total]))
                });
                let of_kind: Vec<_> = of_kind.collect();
                let mut report = Report::default();
                if !of_kind.is_empty() {
                    report.table(aligned(["contents", "entries", "MB"], of_kind));
                }
                if !others.is_empty() {
                    let rows = others.iter().map(|entry| {
                        let name = entry.path.file_name().unwrap_or_default().to_string_lossy();
                        let reason = entry.usable.as_ref().err().map(ToString::to_string).unwrap_or_default();
                        row([&name, &megabytes(entry.bytes), &reason])
                    });
                    report.table(words(["not usable", "MB", "reason"], rows));
                }
                let total = megabytes(entries.iter().map(|entry| entry.bytes).sum());
                report.text(format!("{} entries, {total} MB in {folder}\n", entries.len()));
                context.print_report(&report)
            }
        }
    }
}
