//! One HTML file of one or more results, with styles, pictures and sound embedded.

use maud::{Markup, html};

use super::compare::{Comparison, SpectrumComparison};
use super::html::{article, document, figure, table};
use super::sections;
use crate::effects::stored::{Spectrum, Stored};
use crate::effects::{EFFECTS, GREY, PageSection, ReportError};
use crate::response::{BandLevel, LevelErrors};
use crate::results::PlotError;
use crate::results::plots::{Axis, LinePlot, Series, ThirdOctavePlot};
use crate::study::trial::level_changes;

/// Begin of every page, by which an earlier page is recognised.
pub const PAGE_HEAD: &str = "<!DOCTYPE html><html lang=\"en\"><head><meta name=\"generator\" content=\"tyrewave\">";

/// HTML page of some results; several are compared with the first one.
///
/// # Errors
/// [`ReportError`].
pub fn page(all: &[Stored]) -> Result<String, ReportError> {
    let title = all.iter().map(|stored| stored.summary.title.as_str()).collect::<Vec<_>>().join(" | ");
    let comparison = if all.len() > 1 { Some(comparison(all, &Comparison::of(all))?) } else { None };
    let results =
        all.iter().enumerate().map(|(index, stored)| result(index, stored, all)).collect::<Result<Vec<_>, _>>()?;
    let content = html! {
        @if let Some(comparison) = comparison { (comparison) }
        @for result in &results { (result) }
    };
    Ok(document(&title, &content))
}

fn result(index: usize, stored: &Stored, all: &[Stored]) -> Result<Markup, ReportError> {
    // Results come first, how they were computed last.
    let mut parts = vec![
        ("Warnings", sections::warnings(stored)),
        ("Sound", Markup::default()),
        ("Force spectrum", Markup::default()),
        ("Road", sections::road(stored)?),
    ];
    let mut add = |heading: &'static str, content: Markup| match parts.iter_mut().find(|(other, _)| *other == heading) {
        Some((_, before)) => before.0.push_str(&content.0),
        None => parts.push((heading, content)),
    };
    for effect in EFFECTS {
        for PageSection { heading, blocks } in effect.sections(stored, all)? {
            add(heading, sections::blocks(&blocks));
        }
    }
    add("Contact", sections::residuals(stored));
    add("Plan", sections::plan(stored));
    add("Cost", sections::cost(stored));
    add("To run it again", sections::repeat(stored)?);
    let lead = html! {
        p { (sections::in_words(stored)) }
        (sections::figures(stored))
    };
    let parts = parts.into_iter().map(|(heading, content)| (heading.to_owned(), content));
    Ok(article(index, &stored.summary.title, &lead, parts))
}

/// Results side by side, with links to their articles.
fn comparison(all: &[Stored], of: &Comparison) -> Result<Markup, ReportError> {
    let first = (0..all.len()).map(|index| (index > 0).then_some(0));
    let references: Vec<Option<usize>> = first.collect();
    let overview = html! {
        @if of.settings.is_empty() { p { "All settings are the same." } } @else { (table(&of.settings_table())) }
        (table(&of.figures_table()))
    };
    let mut sections = vec![("Settings and figures".to_owned(), overview)];
    for spectrum in &of.spectra {
        let content = html! {
            @for (svg, caption) in curves(all, of, spectrum, &references)? { (figure(&svg, &caption)) }
            details { summary { "The levels as a table" } (table(&of.spectrum_table(spectrum))) }
        };
        sections.push((signal_of(spectrum), content));
    }
    let lead = html! {
        p {
            "The single results: "
            @for (index, name) in of.names.iter().enumerate() {
                @if index > 0 { ", " }
                a href=(format!("#article-{index}")) { (name) }
            }
            "."
        }
    };
    let title = format!("Comparison of {}", of.names.join(", "));
    Ok(article(all.len(), &title, &lead, sections))
}

/// Quantity and signal of a spectrum in words.
fn signal_of(spectrum: &SpectrumComparison) -> String {
    let signal = if spectrum.name.is_empty() { String::new() } else { format!(", {}", spectrum.name) };
    format!("{}{signal}", spectrum.quantity.split(" [").next().unwrap_or_default())
}

/// Pictures, with captions, of the levels of all results, and of their differences from the result whose index
/// `references` gives for each; grey where a level is not valid. A result has the same colour in all pictures.
pub(super) fn curves(
    all: &[Stored],
    of: &Comparison,
    spectrum: &SpectrumComparison,
    references: &[Option<usize>],
) -> Result<Vec<(String, String)>, PlotError> {
    let found: Vec<Option<&Spectrum>> = all
        .iter()
        .map(|stored| stored.spectrum(spectrum.quantity, &spectrum.name).filter(|found| !found.levels.is_empty()))
        .collect();
    if found.iter().all(Option::is_none) {
        return Ok(Vec::new());
    }
    let signal = signal_of(spectrum);
    let title = format!("{signal}, third octaves");
    // A result without the signal keeps its place, so that the others keep their colours.
    let levels = |(name, found): (&'_ String, &Option<&'_ Spectrum>)| match found {
        Some(found) => (name.clone(), found.levels.clone(), found.errors.clone()),
        None => (String::new(), Vec::new(), LevelErrors::default()),
    };
    let shown: Vec<(String, Vec<BandLevel>, LevelErrors)> = of.names.iter().zip(&found).map(levels).collect();
    let plot = ThirdOctavePlot {
        title: &title,
        quantity: spectrum.quantity,
        spectra: shown.iter().map(|(name, levels, _)| (name.as_str(), levels.as_slice())).collect(),
        errors: LevelErrors::default(),
    };
    let errors: Vec<&LevelErrors> = shown.iter().map(|(_, _, errors)| errors).collect();
    let mut pictures = vec![(plot.to_svg_with(&errors)?, format!("{title}. {GREY} {BARS}"))];
    let changes = (0..all.len()).map(|index| {
        let reference = references.get(index).copied().flatten().and_then(|reference| found[reference]);
        let Some((shown, reference)) = found[index].zip(reference) else {
            return (Series { name: "", points: Vec::new() }, Vec::new());
        };
        let points = level_changes(&shown.levels, &reference.levels)
            .map(|(band, change)| ((band.band.mid_frequency(), change), band.valid));
        let (points, valid): (Vec<(f64, f64)>, Vec<bool>) = points.unzip();
        (Series { name: &of.names[index], points }, valid)
    });
    let (series, valid): (Vec<Series<'_>>, Vec<Vec<bool>>) = changes.unzip();
    let points = || series.iter().flat_map(|series| &series.points).filter(|(_, change)| change.is_finite());
    if points().next().is_some() {
        let mut compared: Vec<usize> = references.iter().flatten().copied().collect();
        compared.dedup();
        let from = match compared[..] {
            [one] => of.names[one].clone(),
            _ => "the first run of the same speed".to_owned(),
        };
        let title = format!("{signal}, difference from {from}");
        let plot = LinePlot {
            title: &title,
            x: Axis::logarithmic_around("Frequency [Hz]", points().map(|point| point.0), [0.9, 1.1]),
            // Rounding errors must not fill the axis of differences.
            y: Axis::linear_around("Difference [dB]", points().map(|point| point.1).chain([-0.5, 0.5])),
            series: series.clone(),
        };
        pictures.push((plot.to_svg_by_validity(|curve, point| valid[curve][point]), format!("{title}. {GREY}")));
    }
    Ok(pictures)
}

/// Explanation of the bars on levels that are compared.
const BARS: &str = "Bars: errors of the levels, as far as they are known.";
