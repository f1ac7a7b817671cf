//! Sections of a page on one result as data: an effect states them, the report turns them into HTML.

use thiserror::Error;

use super::stored::{Spectrum, Stored, StoredError};
use crate::response::level_errors::BySlices;
use crate::response::{BandLevel, LevelErrors};
use crate::results::PlotError;
use crate::results::plots::ThirdOctavePlot;
use crate::results::table::{TextTable, aligned};
use crate::sound::TotalLevel;

/// Legend of pictures of levels.
pub(crate) const GREY: &str = "Grey: bands that are not valid.";

/// Error of a report.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A results folder that cannot be read.
    #[error(transparent)]
    Stored(#[from] StoredError),
    /// A picture that cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// Figure of a run: a named number.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name, as shown.
    pub name: String,
    /// Unit; empty without a dimension.
    pub unit: &'static str,
    /// Value in that unit.
    pub value: f64,
    /// Bands and error, for a level.
    pub total: Option<TotalLevel>,
}

impl Figure {
    /// A figure of a number that is known.
    pub(crate) fn of(name: impl Into<String>, unit: &'static str, value: Option<f64>) -> Option<Self> {
        value.map(|value| Self { name: name.into(), unit, value, total: None })
    }

    /// A figure of an A-weighted level that is known.
    pub(crate) fn level(name: impl Into<String>, level: Option<TotalLevel>) -> Option<Self> {
        level.map(|level| Self { name: name.into(), unit: "dB(A)", value: level.level, total: Some(level) })
    }
}

/// Definition of a table of third octaves that an effect writes.
pub(crate) struct LevelTable {
    /// Name of the file.
    pub file: &'static str,
    /// Quantity of the levels, reference included.
    pub quantity: &'static str,
    /// Name of the column with the levels.
    pub column: &'static str,
    /// Errors of its levels.
    pub errors: fn(&Stored) -> LevelErrors,
}

/// Section of a page; sections of several effects under one heading are joined.
#[derive(Clone, Debug)]
pub(crate) struct PageSection {
    /// Heading, by which sections are joined.
    pub heading: &'static str,
    /// Content; an empty section is not shown.
    pub blocks: Vec<SectionBlock>,
}

/// Block of a section.
#[derive(Clone, Debug)]
pub(crate) enum SectionBlock {
    /// Picture as SVG, and its caption.
    Picture([String; 2]),
    /// Table of levels, folded away at first.
    Levels(TextTable),
    /// List of names, each with a sentence.
    List(Vec<[String; 2]>),
    /// Sound to play, with a text before it.
    Sound {
        /// Text before the player.
        words: String,
        /// Name of the sound's file.
        file: String,
        /// Content of the file.
        bytes: Vec<u8>,
    },
}

/// A picture of all spectra of a quantity and a table of them; nothing where there is none.
///
/// # Errors
/// Errors of the picture.
pub(super) fn levels(stored: &Stored, quantity: &str, title: &str) -> Result<Vec<SectionBlock>, ReportError> {
    let of: Vec<&Spectrum> = stored.spectra.iter().filter(|spectrum| spectrum.quantity == quantity).collect();
    let Some(first) = of.first() else { return Ok(Vec::new()) };
    let drawn = of.iter().map(|spectrum| (spectrum.name.as_str(), spectrum.levels.as_slice())).collect();
    let plot = ThirdOctavePlot { title, quantity: first.quantity, spectra: drawn, errors: first.errors.clone() };
    let rows = first.levels.iter().map(|level| {
        let cells = of.iter().map(|spectrum| {
            let found = spectrum.levels.iter().find(|other| other.band == level.band);
            found.map_or(String::new(), |found| {
                if found.valid { format!("{:.1}", found.level) } else { format!("({:.1})", found.level) }
            })
        });
        std::iter::once(level.band.label()).chain(cells).collect::<Vec<_>>()
    });
    let header = std::iter::once("Hz".to_owned()).chain(
        of.iter().map(|spectrum| if spectrum.name.is_empty() { "dB".to_owned() } else { spectrum.name.clone() }),
    );
    let picture = [plot.to_svg()?, format!("{title}. {GREY}{}", errors_in_words(&first.errors, &first.levels))];
    Ok(vec![SectionBlock::Picture(picture), SectionBlock::Levels(aligned(header, rows))])
}

/// Sentences on the errors of levels, each after a blank.
fn errors_in_words(errors: &LevelErrors, levels: &[BandLevel]) -> String {
    let numerical = errors.numerical.map_or(" Their numerical error is not known.".to_owned(), |(from, error)| {
        let from = if from > 0.0 { format!(" from {from:.0} Hz on") } else { String::new() };
        format!(" Levels are within {error:.1} dB{from}, as far as the numerical solution goes.")
    });
    let by_slices = match (errors.largest_by_slices(levels), &errors.slices) {
        (Some(error), _) => format!(" Contact over slices adds up to {error:.1} dB, beside contact over cells."),
        (None, BySlices::Known(_)) => " What contact over slices adds is not known.".to_owned(),
        (None, BySlices::None) => String::new(),
    };
    numerical + &by_slices
}

/// Pictures of the folder by name, each with its caption; missing ones are skipped.
///
/// # Errors
/// [`StoredError`].
pub(super) fn pictures(stored: &Stored, named: &[[&str; 2]]) -> Result<Vec<SectionBlock>, ReportError> {
    let mut shown = Vec::new();
    for [file, caption] in named {
        shown.extend(stored.text(file)?.map(|svg| SectionBlock::Picture([svg, (*caption).to_owned()])));
    }
    Ok(shown)
}

/// Pictures of the folder whose names begin with `begin`, in the order of the summary; the rest of a name goes before
/// the caption.
///
/// # Errors
/// [`StoredError`].
pub(super) fn pictures_of(stored: &Stored, begin: &str, caption: &str) -> Result<Vec<SectionBlock>, ReportError> {
    let mut shown = Vec::new();
    for name in stored.summary.files.iter().filter(|name| name.starts_with(begin) && name.ends_with(".svg")) {
        let caption = format!("{}: {caption}", shown_by(name, begin));
        shown.extend(stored.text(name)?.map(|svg| SectionBlock::Picture([svg, caption])));
    }
    Ok(shown)
}

/// Receiver or field of a picture, from its file's name.
fn shown_by(name: &str, begin: &str) -> String {
    name.strip_prefix(begin).unwrap_or(name).trim_end_matches(".svg").replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::ThirdOctaveBand;

    #[test]
    fn a_caption_says_which_errors_are_not_known() {
        let band = ThirdOctaveBand(-11);
        let levels = [BandLevel { band, mean_square: 1.0, level: 0.0, valid: true }];
        let of = |slices| errors_in_words(&LevelErrors { numerical: Some((100.0, 0.2)), slices }, &levels);
        assert!(!of(BySlices::None).contains("slices"));
        assert!(of(BySlices::Known(vec![(band, 2.0)])).contains("adds up to 2.0 dB"));
        let reported = of(BySlices::Known(Vec::new()));
        assert!(
            reported.contains("within 0.2 dB from 100 Hz on") && reported.ends_with("slices adds is not known."),
            "{reported}"
        );
    }

    #[test]
    fn a_caption_names_its_receiver_once_and_as_the_scene_does() {
        assert_eq!(shown_by("pass_by_coast-by.svg", "pass_by_"), "coast-by");
        assert_eq!(shown_by("vibration_map_tread_non-rotating.svg", "vibration_map_"), "tread non-rotating");
    }
}
