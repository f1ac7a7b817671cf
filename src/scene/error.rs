//! Errors of loading and writing a scene.

use std::io;
use std::path::{Path, PathBuf};

use annotate_snippets::{Level, Renderer};

use super::Diagnostic;

/// Most mistakes that are reported; more of them are no help.
const MOST_REPORTED: usize = 32;

/// Reason why what a run needs is not set up.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SetUpError {
    /// It was refused: a complaint about the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The user stopped the work.
    #[error("interrupted")]
    Stopped,
}

/// Reason why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file does not exist.
    #[error("there is no file \"{}\"", path.display())]
    NotFound {
        /// The path as given.
        path: PathBuf,
    },
    /// A folder was named instead of a file.
    #[error("\"{}\" is a folder, not a file", path.display())]
    Folder {
        /// The path as given.
        path: PathBuf,
    },
    /// The file cannot be read.
    #[error("\"{}\" cannot be read: {source}", path.display())]
    Unreadable {
        /// The path as given.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is not UTF-8 text.
    #[error("\"{}\" is not UTF-8 text: byte {byte}, in line {line}", path.display())]
    NotText {
        /// The path as given.
        path: PathBuf,
        /// Offset of the first byte that is not UTF-8, from the begin of the file.
        byte: usize,
        /// Its line, from 1.
        line: usize,
    },
    /// The file describes a tyre, not a scene.
    #[error(
        "\"{}\" is the file of a tyre, not of a scene: a scene names it, tyre = \"{}\"",
        path.display(),
        path.display()
    )]
    Tyre {
        /// The path as given.
        path: PathBuf,
    },
    /// The text does not describe a scene; with all mistakes that could be found, in the order of the file.
    #[error("{}{}", one_per_line(diagnostics), and_more("\n", *more))]
    Invalid {
        /// The mistakes; at least one, and no more than is useful to read.
        diagnostics: Vec<Diagnostic>,
        /// How many there are beyond these.
        more: usize,
    },
    /// The scene cannot be written as TOML (a number beyond 63 bits, a path that is not UTF-8).
    #[error("the scene cannot be written as TOML: {source}")]
    NotToml {
        /// The writer's reason.
        source: toml::ser::Error,
    },
    /// The scene cannot be written as JSON (a path that is not UTF-8).
    #[error("the scene cannot be written as JSON: {source}")]
    NotJson {
        /// The writer's reason.
        source: serde_json::Error,
    },
}

impl SceneError {
    /// Error of mistakes, at least one, beside `more` that are not reported.
    pub(crate) fn invalid(mut diagnostics: Vec<Diagnostic>, more: usize) -> Self {
        let more = more + diagnostics.len().saturating_sub(MOST_REPORTED);
        diagnostics.truncate(MOST_REPORTED);
        Self::Invalid { diagnostics, more }
    }

    /// The mistakes found in the text; empty if it could not be read at all.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        match self {
            Self::Invalid { diagnostics, .. } => diagnostics,
            _ => &[],
        }
    }

    /// The first mistake, without its place.
    pub fn problem(&self) -> String {
        self.diagnostics().first().map_or_else(|| self.to_string(), |first| first.problem().to_string())
    }

    /// Message for people: lines of the file, places marked; `colour` for terminals.
    pub fn render(&self, colour: bool) -> String {
        match self {
            Self::Invalid { diagnostics, more } => {
                let shown: Vec<_> = diagnostics.iter().map(|diagnostic| diagnostic.render(colour)).collect();
                shown.join("\n\n") + &and_more("\n\n", *more)
            }
            other => {
                let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
                renderer.render(&[annotate_snippets::Group::with_title(Level::ERROR.primary_title(other.to_string()))])
            }
        }
    }

    /// Error of a failure to open or read `path`.
    pub(crate) fn reading(path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        match source.kind() {
            io::ErrorKind::NotFound => Self::NotFound { path },
            io::ErrorKind::IsADirectory => Self::Folder { path },
            _ => Self::Unreadable { path, source },
        }
    }
}

impl From<Diagnostic> for SceneError {
    fn from(diagnostic: Diagnostic) -> Self {
        Self::invalid(vec![diagnostic], 0)
    }
}

/// Words after the reported mistakes; empty if there are no more.
fn and_more(before: &str, more: usize) -> String {
    if more == 0 { String::new() } else { format!("{before}and {more} more") }
}

fn one_per_line(diagnostics: &[Diagnostic]) -> String {
    diagnostics.iter().map(Diagnostic::to_string).collect::<Vec<_>>().join("\n")
}
