//! Context of a command beside its arguments, the scene that it is about, and the output of its answer.

use std::ffi::{OsStr, OsString};
use std::io::Write;
use std::path::PathBuf;

use crate::counters::{AllocationProbe, Job, Progress};
use crate::results::table::Report;
use crate::run::RunError;
use crate::scene::{LoadedScene, Reach, Scene, SceneError, Setting};
use clap::Args;
use indicatif::ProgressBar;
use terminal_size::{Width, terminal_size_of};

use super::error::CliError;
use super::interrupt::Interrupt;
use super::options::GlobalOptions;
use super::progress::{TerminalProgress, pieces};

/// Context of a command beside its arguments.
#[derive(Debug)]
pub(crate) struct Context {
    pub options: GlobalOptions,
    /// Threads that the command is executed on.
    pub threads: usize,
    /// True if messages on standard error may be coloured.
    pub colour: bool,
    /// Flag that the user has asked for the end.
    pub interrupt: Interrupt,
    /// Counts of the program's allocator.
    pub allocations: Option<AllocationProbe>,
    /// The program's commands and arguments, for completions and man pages.
    pub program: fn() -> clap::Command,
}

impl Context {
    /// Loads a scene file; its tyre and road may lie where the options permit.
    pub(crate) fn load(&self, file: &SceneFile) -> Result<LoadedScene, CliError> {
        let reach = if self.options.allow_outside { Reach::Anywhere } else { Reach::Folder };
        Ok(Scene::load_with(&file.scene, &file.settings, reach)?)
    }

    /// Loads a scene file, or the file of a tyre, which then rolls in the default scene; true if it is a tyre.
    pub(crate) fn load_scene_or_tyre(&self, file: &SceneFile) -> Result<(LoadedScene, bool), CliError> {
        match self.load(file) {
            Err(CliError::Run(RunError::Scene(SceneError::Tyre { path }))) => {
                Ok((Scene::with_tyre(path, &file.settings)?, true))
            }
            other => other.map(|loaded| (loaded, false)),
        }
    }

    /// Work that the user may interrupt.
    pub(crate) fn job<'a>(&'a self, progress: &'a mut dyn Progress) -> Job<'a> {
        Job::new(self.interrupt.flag(), progress)
    }

    /// Progress display, as the options want it.
    pub(crate) fn progress(&self) -> TerminalProgress {
        TerminalProgress::new(self.options.quiet)
    }

    /// Progress bar over `count` equal pieces of work.
    pub(crate) fn bar(&self, title: &str, count: u64) -> ProgressBar {
        pieces(self.options.quiet, title, count)
    }

    /// Prints something beside the answer: nothing if the user wants silence, or JSON alone.
    pub(crate) fn say(&self, text: &str) -> Result<(), CliError> {
        if self.options.quiet || self.options.json { Ok(()) } else { print(text) }
    }

    /// Prints a report, its tables within the terminal's width if there is one; as JSON if that is wanted.
    pub(crate) fn print_report(&self, report: &Report) -> Result<(), CliError> {
        if self.options.json {
            return print(&format!("{:#}\n", report.to_json()));
        }
        match terminal_size_of(std::io::stdout()) {
            Some((Width(columns), _)) => print(&report.within(usize::from(columns))),
            None => print(&report.to_string()),
        }
    }
}

/// Writes to standard output; a closed pipe is an error, not a panic.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(CliError::Print)
}

/// A scene, and settings in place of its own.
#[derive(Clone, Debug, Args)]
pub(crate) struct SceneFile {
    /// The scene, a TOML file.
    pub scene: PathBuf,
    /// Set a key in place of the scene's value, such as rolling.speed_kmh=110, numerics.preset=draft or
    /// receiver[0].height=1.5; KEY= removes the key; may be repeated. Paths are relative to the scene's file.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = Setting::parse)]
    pub settings: Vec<Setting>,
}

impl SceneFile {
    /// Name of the scene: its file's, without the ending.
    pub(crate) fn name(&self) -> OsString {
        self.scene.file_stem().unwrap_or(OsStr::new("scene")).to_owned()
    }
}
