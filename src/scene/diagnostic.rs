//! A mistake with its place in a file, and its display.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet, normalize_untrusted_str};

use super::Problem;

/// A text and where it comes from.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct SourceText {
    /// The file's path as the user gave it, or any other name.
    pub name: String,
    /// The whole text.
    pub text: String,
}

impl SourceText {
    /// Line and column of a byte, both from 1, the column in characters.
    pub(crate) fn position(&self, byte: usize) -> (usize, usize) {
        let before = self.text.get(..byte).unwrap_or(&self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or(before).chars().count() + 1;
        (line, column)
    }

    /// Byte range of the line that a byte lies in, without its line end.
    pub(crate) fn line(&self, byte: usize) -> Range<usize> {
        let (before, after) = self.text.split_at_checked(byte).unwrap_or((&self.text, ""));
        let begin = before.rfind('\n').map_or(0, |end| end + 1);
        begin..before.len() + after.find('\n').unwrap_or(after.len())
    }
}

/// A mistake, the key it concerns, and its place in a file.
#[derive(Debug)]
pub struct Diagnostic {
    pub(super) source: Arc<SourceText>,
    pub(super) key: String,
    pub(super) span: Range<usize>,
    pub(super) problem: Problem,
}

impl Diagnostic {
    /// Name of the file, as the user gave it.
    pub fn file(&self) -> &str {
        &self.source.name
    }

    /// Line in the file, from 1.
    pub fn line(&self) -> usize {
        self.source.position(self.span.start).0
    }

    /// Column in characters, from 1.
    pub fn column(&self) -> usize {
        self.source.position(self.span.start).1
    }

    /// Path of the key, such as `tyre.layers[1].thickness`, array items from 0; empty where the mistake concerns no
    /// key.
    pub fn key(&self) -> &str {
        &self.key
    }

    pub(crate) fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The key and what is wrong with it.
    fn title(&self) -> String {
        if self.key.is_empty() { self.problem.to_string() } else { format!("{}: {}", self.key, self.problem) }
    }

    /// Message with the lines concerned, the place marked, and what would be right; `colour` for terminals.
    pub fn render(&self, colour: bool) -> String {
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        // A range from a quote that is never closed would mark the rest of the file: it ends with the line.
        let end = self.span.end.min(self.source.line(self.span.start).end).max(self.span.start);
        let annotation = AnnotationKind::Primary.span(self.span.start..end).label(self.problem.right());
        let snippet = Snippet::source(self.source.text.as_str()).path(self.file()).annotation(annotation);
        renderer.render(&[Level::ERROR.primary_title(self.title()).element(snippet)])
    }
}

/// One line: file:line:column: key: what is wrong (what would be right).
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (line, column) = self.source.position(self.span.start);
        // Keys and texts come from the file: control characters must not reach a terminal.
        let message = normalize_untrusted_str(&format!("{} ({})", self.title(), self.problem.right()));
        write!(f, "{}:{line}:{column}: {message}", self.file())
    }
}
