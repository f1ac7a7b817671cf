//! One HTML file of one or more results: styles, pictures and sound are in it.

use maud::{Markup, html};

use super::compare::{Comparison, SpectrumComparison};
use super::error::ReportError;
use super::html::{document, figure, table};
use super::sections;
use super::stored::Stored;
use crate::results::PlotError;
use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::spectra::FORCE_LEVEL;
use crate::results::vibration::VELOCITY_LEVEL;

/// What every page begins with.
pub const PAGE_HEAD: &str = "<!DOCTYPE html><html lang=\"en\"><head><meta name=\"generator\" content=\"tyrewave\">";

/// The page of some results; several are compared with the first one.
///
/// # Errors
/// [`ReportError`].
pub fn page(all: &[Stored]) -> Result<String, ReportError> {
    let title = all.iter().map(|stored| stored.summary.title.as_str()).collect::<Vec<_>>().join(" | ");
    let comparison = if all.len() > 1 { Some(comparison(&Comparison::of(all))?) } else { None };
    let audio = all.iter().filter_map(|stored| stored.summary.sound.as_ref()).flat_map(|sound| &sound.receivers);
    let scales = audio.filter_map(|receiver| receiver.audio.as_ref()).map(|audio| audio.full_scale);
    // What is louder in one run than in another is so in the page.
    let full_scale = scales.fold(0.0, f64::max);
    let results = all
        .iter()
        .enumerate()
        .map(|(index, stored)| result(index, stored, full_scale))
        .collect::<Result<Vec<_>, _>>()?;
    let content = html! {
        @if let Some(comparison) = comparison { (comparison) }
        @for result in &results { (result) }
    };
    Ok(document(&title, &content))
}

/// A section with its heading; nothing where there is nothing in it.
fn section(index: usize, heading: &str, content: &Markup) -> Markup {
    let id = format!("{}-{index}", heading.to_ascii_lowercase().replace(' ', "-"));
    html! { @if !content.0.is_empty() { section id=(id) { h2 { (heading) } (content) } } }
}

fn result(index: usize, stored: &Stored, full_scale: f64) -> Result<Markup, ReportError> {
    let vibration = html! {
        (sections::spectra(stored, VELOCITY_LEVEL, "Velocities, third octaves")?)
        (sections::pictures(
            stored,
            "vibration_map_",
            "waves round the tyre over frequency. White: the tyre's own waves"
        )?)
    };
    let parts = [
        ("Warnings", sections::warnings(stored)),
        ("Plan", sections::plan(stored)),
        ("Road", sections::road(stored)?),
        ("Contact", sections::contact(stored)?),
        ("Force spectrum", sections::spectra(stored, FORCE_LEVEL, "Contact force, third octaves")?),
        ("Vibration", vibration),
        ("Sound", sections::sound(stored, full_scale)?),
        ("Cost", sections::cost(stored)),
        ("To run it again", sections::repeat(stored)?),
    ];
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

/// Results side by side.
fn comparison(of: &Comparison) -> Result<Markup, ReportError> {
    let mut figures = Vec::new();
    for spectrum in &of.spectra {
        let curves = curves(of, spectrum)?;
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

/// Levels of all results over each other, and their differences from the first.
fn curves(of: &Comparison, spectrum: &SpectrumComparison) -> Result<Vec<(String, String)>, PlotError> {
    let level =
        |result: usize| spectrum.bands.iter().filter_map(move |band| Some((band.nominal_hz, band.levels[result]?)));
    let name = if spectrum.name.is_empty() { String::new() } else { format!(", {}", spectrum.name) };
    let draw = |title: &str, quantity: &str, curves: Vec<(usize, Vec<(f64, f64)>)>| {
        let all = || curves.iter().flat_map(|(_, points)| points);
        if all().count() == 0 {
            return Ok(None);
        }
        let plot = LinePlot {
            title,
            x: Axis::logarithmic_around("Frequency [Hz]", all().map(|point| point.0), [0.9, 1.1]),
            y: Axis::linear_around(quantity, all().map(|point| point.1)),
            series: curves
                .iter()
                .map(|(result, points)| Series { name: &of.names[*result], points: points.clone() })
                .collect(),
        };
        plot.to_svg().map(Some)
    };
    let levels = (0..of.names.len()).map(|result| (result, level(result).collect())).collect();
    let differences = (1..of.names.len()).map(|result| {
        let bands = spectrum.bands.iter();
        let points = bands.filter_map(|band| Some((band.nominal_hz, band.levels[result]? - band.levels[0]?)));
        (result, points.collect())
    });
    let what = spectrum.quantity.split(" [").next().unwrap_or_default();
    let title = format!("{what}{name}, third octaves");
    let over = draw(&title, spectrum.quantity, levels)?;
    let from = format!("{what}{name}, difference from {}", of.names[0]);
    let difference = draw(&from, "Difference [dB]", differences.collect())?;
    Ok(over.map(|svg| (svg, title)).into_iter().chain(difference.map(|svg| (svg, from))).collect())
}
