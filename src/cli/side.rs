//! Commands that read a scene and write a folder of files beside their answer.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::counters::Meter;
use crate::planning::settled;
use crate::report::html::{Chapter, chapters};
use crate::results::summary::{RunCost, Summary};
use crate::results::table::Report;
use crate::results::{PlotError, ResultFiles, ResultsFolder};
use crate::scene::LoadedScene;
use clap::Args;

use super::context::{Context, SceneFile, print};
use super::error::CliError;

/// A scene, and where the results of a command that is not `run` go.
#[derive(Clone, Debug, Args)]
pub(super) struct Place {
    #[command(flatten)]
    pub scene: SceneFile,
    /// Results folder; default: results/NAME-COMMAND, NAME being the scene's.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

/// Section of a page: heading, names of pictures with their captions, tables.
pub(super) type PageSection<'a> = (&'static str, &'a [[&'static str; 2]], &'a Report);

/// A command's work on a scene, and the files that it writes.
pub(super) struct Side {
    pub loaded: LoadedScene,
    /// Cost of the work.
    pub meter: Meter,
    /// Settings in the summary: at first the scene's.
    pub settings: serde_json::Value,
    target: PathBuf,
    begin: Instant,
    files: Vec<(&'static str, String)>,
    /// All numbers as JSON, if a command has more of them than its report shows.
    answer: Option<String>,
}

impl Place {
    /// Loads the scene. A folder that cannot be written to is refused now, before the work.
    pub(super) fn open(self, command: &str, context: &Context) -> Result<Side, CliError> {
        let loaded = context.load(&self.scene)?;
        Side::new(loaded, self.target(command))
    }

    /// Loads a scene as [`Self::open`], of which only the tyre counts; the file may be that of a tyre. The title names
    /// the tyre: that of a scene describes its road and speed.
    pub(super) fn open_tyre(self, command: &str, context: &Context) -> Result<Side, CliError> {
        let (mut loaded, is_tyre) = context.load_scene_or_tyre(&self.scene)?;
        let file = if is_tyre { loaded.title() } else { loaded.name() };
        loaded.scene.title = format!("Tyre of {file}");
        Side::new(loaded, self.target(command))
    }

    /// Results folder of a command.
    pub(super) fn target(self, command: &str) -> PathBuf {
        self.out.unwrap_or_else(|| {
            let mut name = self.scene.name();
            name.push(format!("-{command}"));
            Path::new("results").join(name)
        })
    }
}

impl Side {
    pub(super) fn new(loaded: LoadedScene, target: PathBuf) -> Result<Self, CliError> {
        let loaded = settled(loaded)?;
        drop(ResultsFolder::create(&target)?);
        let (settings, meter) = (loaded.settings()?, Meter::default());
        Ok(Self { loaded, meter, settings, target, begin: Instant::now(), files: Vec::new(), answer: None })
    }

    /// Adds a file to the folder.
    pub(super) fn file(&mut self, name: &'static str, text: impl Into<String>) {
        self.files.push((name, text.into()));
    }

    /// Adds a picture to the folder.
    pub(super) fn picture(&mut self, name: &'static str, svg: Result<String, PlotError>) -> Result<(), CliError> {
        self.file(name, svg?);
        Ok(())
    }

    /// Adds a page to the folder: sections of pictures that were added before, by file and caption, and tables;
    /// pictures that do not exist are left out.
    pub(super) fn page(&mut self, name: &'static str, [title, lead]: [&str; 2], sections: &[PageSection<'_>]) {
        let svg = |file: &str| self.files.iter().find(|(name, _)| *name == file).map(|(_, svg)| svg.as_str());
        let pictures = |named: &[[&'static str; 2]]| {
            named.iter().filter_map(|&[file, caption]| Some([svg(file)?, caption])).collect()
        };
        let all: Vec<Chapter<'_>> = sections
            .iter()
            .map(|&(heading, named, tables)| Chapter { heading, pictures: pictures(named), tables })
            .collect();
        let page = chapters(title, lead, &all);
        self.file(name, page);
    }

    /// Adds a JSON file to the folder; it is the answer if JSON is wanted.
    pub(super) fn json(&mut self, name: &'static str, answer: &serde_json::Value) {
        let text = format!("{answer:#}\n");
        self.file(name, text.clone());
        self.answer = Some(text);
    }

    /// Writes the folder and prints the report and the folder's path, or only the JSON if that was asked for.
    pub(super) fn finish(mut self, context: &Context, report: &Report) -> Result<(), CliError> {
        let answer = self.answer.take().filter(|_| context.options.json);
        let place = self.write(context)?;
        let printed = match answer {
            Some(json) => print(&json),
            None => {
                context.print_report(report).and_then(|()| context.say(&format!("results in {}\n", place.display())))
            }
        };
        printed.map_err(|error| error.with_results(&place))
    }

    /// Keeps the results of interrupted work in a partial folder and prints its report; the error is the interruption,
    /// which names the folder.
    pub(super) fn keep(self, context: &Context, report: &Report) -> Result<(), CliError> {
        let (folder, summary) = self.filled(context)?;
        let folder = folder.finish_partial(summary)?;
        context.print_report(report)?;
        Err(CliError::PartDone { folder })
    }

    /// Writes the folder and returns its path.
    pub(super) fn write(self, context: &Context) -> Result<PathBuf, CliError> {
        let (folder, summary) = self.filled(context)?;
        Ok(folder.finish(summary)?)
    }

    /// The folder with its files, and its summary.
    fn filled(self, context: &Context) -> Result<(ResultsFolder, Summary), CliError> {
        let folder = ResultsFolder::create(&self.target)?;
        for (name, text) in &self.files {
            folder.write_text(name, text)?;
        }
        let cost = RunCost::new(&self.meter, self.begin.elapsed().as_secs_f64(), context.threads);
        Ok((folder, Summary::begun(&self.loaded.title(), self.settings, cost)))
    }
}
