//! Pictures of a run's sound.

use super::planned::Heard;
use crate::effects::error::RunError;
use crate::response::{BandLevel, LevelErrors};
use crate::results::files::ResultFiles;
use crate::results::plots::{Axis, LinePlot, PolarPlot, Series, ThirdOctavePlot};
use crate::results::sound::{ReceiverSpectrum, SOUND_LEVEL};
use crate::results::spectra::LOWEST_FREQUENCY;
use crate::scene::LoadedScene;
use crate::sound::SoundLevels;

/// Returns the A-weighted third octaves of all receivers.
pub(super) fn draw_levels(
    loaded: &LoadedScene,
    spectra: &[ReceiverSpectrum],
    errors: LevelErrors,
    folder: &dyn ResultFiles,
) -> Result<(), RunError> {
    let drawn: Vec<(&str, Vec<BandLevel>)> = spectra
        .iter()
        .map(|heard| {
            (heard.name.as_str(), SoundLevels::of(&heard.spectrum, LOWEST_FREQUENCY..f64::INFINITY).a_weighted)
        })
        .collect();
    if drawn.iter().all(|(_, levels)| levels.is_empty()) {
        return Ok(());
    }
    let title = format!("Sound, third octaves: {}", loaded.title());
    let plot = ThirdOctavePlot {
        title: &title,
        quantity: SOUND_LEVEL,
        spectra: drawn.iter().map(|(name, levels)| (*name, levels.as_slice())).collect(),
        errors,
    };
    folder.write_text("sound_spectrum.svg", &plot.to_svg()?)?;
    Ok(())
}

/// Returns the level against the place of the tyre, or of the vehicle's middle; rows are time, place, level.
pub(super) fn draw_pass_by(
    loaded: &LoadedScene,
    heard: &Heard,
    rows: &[[f64; 3]],
    folder: &dyn ResultFiles,
) -> Result<(), RunError> {
    let title = format!("Passing {}: {}", heard.name, loaded.title());
    let who = if heard.vehicle().is_some() { "Middle of the vehicle" } else { "Tyre" };
    let points: Vec<(f64, f64)> = rows.iter().map(|[_, place, level]| (-place, *level)).collect();
    let plot = LinePlot {
        title: &title,
        x: Axis::linear_around(format!("{who} ahead of the microphone [m]"), points.iter().map(|point| point.0)),
        y: Axis::linear_around("A-weighted level, F [dB(A)]", points.iter().map(|point| point.1)),
        series: vec![Series { name: "", points }],
    };
    folder.write_text(&format!("pass_by_{}.svg", heard.file), &plot.to_svg()?)?;
    Ok(())
}

/// Returns the level over the angle from straight ahead, by the left.
pub(super) fn draw_directivity(
    loaded: &LoadedScene,
    heard: &Heard,
    levels: &[f64],
    folder: &dyn ResultFiles,
) -> Result<(), RunError> {
    let title = format!("Directivity, {}: {}", heard.name, loaded.title());
    let angle = |index: usize| 360.0 * index as f64 / levels.len() as f64;
    // The first point closes the circle.
    let points: Vec<(f64, f64)> =
        (0..=levels.len()).map(|index| (angle(index), levels[index % levels.len()])).collect();
    let plot = PolarPlot {
        title: &title,
        source: "Source: the rolling tyre",
        quantity: "A-weighted level [dB(A)]",
        series: vec![Series { name: "", points }],
    };
    folder.write_text(&format!("directivity_{}.svg", heard.file), &plot.to_svg()?)?;
    Ok(())
}
