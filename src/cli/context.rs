//! What a command needs to know beside its own arguments, and how it answers.

use std::io::Write;
use std::path::Path;

use indicatif::ProgressBar;
use terminal_size::{Width, terminal_size_of};
use tyrewave::counters::AllocationProbe;
use tyrewave::results::table::Report;
use tyrewave::scene::{LoadedScene, Reach, Scene, SceneError};

use super::error::CliError;
use super::interrupt::Interrupt;
use super::options::GlobalOptions;
use super::progress::{TerminalProgress, pieces};

/// What a command needs to know beside its own arguments.
#[derive(Debug)]
pub struct Context {
    pub options: GlobalOptions,
    /// Threads that the command is executed on.
    pub threads: usize,
    /// Whether messages on standard error may be coloured.
    pub colour: bool,
    /// Whether the user has asked for the end.
    pub interrupt: Interrupt,
    /// What the program's allocator counts.
    pub allocations: Option<AllocationProbe>,
}

impl Context {
    /// A scene file, whose tyre and road are where the options let them be.
    pub fn load(&self, path: &Path) -> Result<LoadedScene, SceneError> {
        let reach = if self.options.allow_outside { Reach::Anywhere } else { Reach::Folder };
        Scene::load_within(path, reach)
    }

    /// Progress as the options want it.
    pub fn progress(&self) -> TerminalProgress {
        TerminalProgress::new(self.options.quiet)
    }

    /// A bar over so many equal pieces of work.
    pub fn bar(&self, title: &str, count: u64) -> ProgressBar {
        pieces(self.options.quiet, title, count)
    }
}

/// Prints a report, its tables within the terminal's width where there is a terminal.
pub fn print_report(report: &Report) -> Result<(), CliError> {
    match terminal_size_of(std::io::stdout()) {
        Some((Width(columns), _)) => print(&report.within(usize::from(columns))),
        None => print(&report.to_string()),
    }
}

/// Writes to standard output; a closed pipe is no panic.
pub fn print(text: &str) -> Result<(), CliError> {
    std::io::stdout().write_all(text.as_bytes()).map_err(CliError::Print)
}
