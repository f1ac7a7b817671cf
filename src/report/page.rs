//! One HTML file of one or more results: styles, pictures and sound are in it.

use maud::{Markup, html};

use super::compare::{Comparison, SpectrumComparison};
use super::html::{document, figure, table};
use super::sections;
use crate::effects::stored::Stored;
use crate::effects::{EFFECTS, GREY, ReportError, Section};
use crate::response::{BandLevel, LevelErrors};
use crate::results::PlotError;
use crate::results::plots::{Axis, LinePlot, Series, ThirdOctavePlot};
use crate::study::trial::level_changes;

/// Beginning of every page.
pub(crate) const PAGE_HEAD: &str =
    "<!DOCTYPE html><html lang=\"en\"><head><meta name=\"generator\" content=\"tyrewave\">";

/// Returns the page of some results; several are compared with the first one.
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

/// Returns a section with its heading; nothing where there is nothing in it.
fn section(index: usize, heading: &str, content: &Markup) -> Markup {
    let id = format!("{}-{index}", heading.to_ascii_lowercase().replace(' ', "-"));
    html! { @if !content.0.is_empty() { section id=(id) { h2 { (heading) } (content) } } }
}

fn result(index: usize, stored: &Stored, all: &[Stored]) -> Result<Markup, ReportError> {
    let mut parts = vec![
        ("Warnings", sections::warnings(stored)),
        ("Plan", sections::plan(stored)),
        ("Road", sections::road(stored)?),
    ];
    let mut add = |heading: &'static str, content: Markup| match parts.iter_mut().find(|(other, _)| *other == heading) {
        Some((_, before)) => before.0.push_str(&content.0),
        None => parts.push((heading, content)),
    };
    for effect in EFFECTS {
        for Section { heading, blocks } in effect.sections(stored, all)? {
            add(heading, sections::blocks(&blocks));
        }
    }
    add("Contact", sections::residuals(stored));
    add("Cost", sections::cost(stored));
    add("To run it again", sections::repeat(stored)?);
    Ok(html! {
        article {
            header {
                h1 { (stored.summary.title) }
                p { (sections::in_words(stored)) }
                (sections::figures(stored))
            }
            @for (heading, content) in &parts { (section(index, heading, content)) }
        }
    })
}

/// Shows results side by side.
fn comparison(all: &[Stored], of: &Comparison) -> Result<Markup, ReportError> {
    let mut figures = Vec::new();
    for spectrum in &of.spectra {
        let curves = curves(all, of, spectrum)?;
        figures.push(html! {
            @for (svg, caption) in curves { (figure(&svg, &caption)) }
            details { summary { "The levels as a table" } (table(&of.spectrum_table(spectrum))) }
        });
    }
    Ok(html! {
        article {
            h1 { "Comparison of " (of.names.join(", ")) }
            @if of.settings.is_empty() { p { "All settings are the same." } } @else { (table(&of.settings_table())) }
            (table(&of.figures_table()))
            @for figure in figures { (figure) }
        }
    })
}

/// Returns the levels of all results over each other, and their differences from the first; grey where a level is not
/// vouched for.
pub(super) fn curves(
    all: &[Stored],
    of: &Comparison,
    spectrum: &SpectrumComparison,
) -> Result<Vec<(String, String)>, PlotError> {
    let levels = |stored: &'_ Stored| -> Option<Vec<BandLevel>> {
        let found = stored.spectrum(spectrum.quantity, &spectrum.name)?;
        (!found.levels.is_empty()).then(|| found.levels.clone())
    };
    let found: Vec<Option<Vec<BandLevel>>> = all.iter().map(levels).collect();
    let named = || of.names.iter().zip(&found).filter_map(|(name, levels)| Some((name.as_str(), levels.as_deref()?)));
    if named().next().is_none() {
        return Ok(Vec::new());
    }
    let signal = if spectrum.name.is_empty() { String::new() } else { format!(", {}", spectrum.name) };
    let what = spectrum.quantity.split(" [").next().unwrap_or_default();
    let title = format!("{what}{signal}, third octaves");
    let plot = ThirdOctavePlot {
        title: &title,
        quantity: spectrum.quantity,
        spectra: named().collect(),
        errors: LevelErrors::default(),
    };
    let mut pictures = vec![(plot.to_svg()?, format!("{title}. {GREY}"))];
    let Some(first) = found.first().and_then(Option::as_deref) else { return Ok(pictures) };
    let changes = named().skip(1).map(|(name, levels)| {
        let points =
            level_changes(levels, first).map(|(band, change)| ((band.band.mid_frequency(), change), band.valid));
        let (points, vouched): (Vec<(f64, f64)>, Vec<bool>) = points.unzip();
        (Series { name, points }, vouched)
    });
    let (series, vouched): (Vec<Series<'_>>, Vec<Vec<bool>>) = changes.unzip();
    let points = || series.iter().flat_map(|series| &series.points).filter(|(_, change)| change.is_finite());
    if points().next().is_some() {
        let title = format!("{what}{signal}, difference from {}", of.names[0]);
        let plot = LinePlot {
            title: &title,
            x: Axis::logarithmic_around("Frequency [Hz]", points().map(|point| point.0), [0.9, 1.1]),
            y: Axis::linear_around("Difference [dB]", points().map(|point| point.1)),
            series: series.clone(),
        };
        pictures.push((plot.to_svg_vouched(|curve, point| vouched[curve][point])?, format!("{title}. {GREY}")));
    }
    Ok(pictures)
}
