//! Pictures of a run's sound.

use ndarray::Array2;

use crate::effects::error::RunError;
use crate::effects::observer::draw_third_octaves;
use crate::plan::receivers::PlannedReceiver;
use crate::response::LevelErrors;
use crate::response::pressure::TransferPath;
use crate::response::pressure::open_patch::UnderPatchLevels;
use crate::results::files::ResultFiles;
use crate::results::plots::{Axis, LinePlot, PolarPlot, Series, SurfaceMap};
use crate::results::sound::{ReceiverSpectrum, SOUND_LEVEL};
use crate::results::spectra::LOWEST_FREQUENCY;
use crate::scene::LoadedScene;
use crate::sound::SoundLevels;

/// Draws the A-weighted third octaves of all receivers in one picture.
pub(super) fn draw_levels(
    loaded: &LoadedScene,
    spectra: &[ReceiverSpectrum],
    errors: LevelErrors,
    folder: &dyn ResultFiles,
) -> Result<(), RunError> {
    let levels = |receiver: &ReceiverSpectrum| {
        let levels = SoundLevels::of(&receiver.spectrum, LOWEST_FREQUENCY..f64::INFINITY);
        (receiver.name.clone(), levels.a_weighted)
    };
    let drawn: Vec<_> = spectra.iter().map(levels).collect();
    draw_third_octaves(loaded, ["sound_spectrum.svg", "Sound", SOUND_LEVEL], &drawn, errors, folder)
}

const ROWS: usize = 120;

/// Draws |G| under the patch, as it is at the first point of a receiver; closed ribs have no value.
pub(super) fn draw_under_patch(
    loaded: &LoadedScene,
    receiver: &str,
    levels: &UnderPatchLevels,
    folder: &dyn ResultFiles,
) -> Result<(), RunError> {
    let UnderPatchLevels { frequency, green, ends } = levels;
    let [first, .., last] = ends.as_slice() else { return Ok(()) };
    let strips = ends.len() - 1;
    let (along, dy) = (green.len() / strips, (last - first) / ROWS as f64);
    let values = Array2::from_shape_fn((along, ROWS), |(cell, row)| {
        let y = first + (row as f64 + 0.5) * dy;
        let strip = ends.partition_point(|end| *end <= y).clamp(1, strips) - 1;
        let value = green[cell * strips + strip];
        if value > 0.0 { 20.0 * value.log10() } else { f64::NAN }
    });
    let dx = loaded.scene.tyre.circumference / TransferPath::GRID.around as f64;
    let title = format!("Field under the patch for {receiver}, {frequency:.0} Hz: {}", loaded.title());
    let map = SurfaceMap {
        title: &title,
        along: "Along, from the axle",
        quantity: "|G| [dB re 1/m]",
        values: values.view(),
        first_position: (0.5 - 0.5 * along as f64) * dx,
        size: [dx, dy],
    };
    Ok(folder.write_text("gap.svg", &map.to_svg()?)?)
}

/// Draws the level over the position of the tyre, or of the vehicle's middle; rows are time, position, level.
pub(super) fn draw_pass_by(
    loaded: &LoadedScene,
    receiver: &PlannedReceiver,
    rows: &[[f64; 3]],
    folder: &dyn ResultFiles,
) -> Result<(), RunError> {
    let title = format!("Passing {}: {}", receiver.name, loaded.title());
    let subject = if receiver.vehicle().is_some() { "Middle of the vehicle" } else { "Tyre" };
    let points: Vec<(f64, f64)> = rows.iter().map(|[_, place, level]| (-place, *level)).collect();
    let plot = LinePlot {
        title: &title,
        x: Axis::linear_around(format!("{subject} ahead of the microphone [m]"), points.iter().map(|point| point.0)),
        y: Axis::linear_around("A-weighted level, F [dB(A)]", points.iter().map(|point| point.1)),
        series: vec![Series { name: "", points }],
    };
    Ok(folder.write_text(&format!("pass_by_{}.svg", receiver.file), &plot.to_svg())?)
}

/// Draws the level over the angle from straight ahead, by the left.
pub(super) fn draw_directivity(
    loaded: &LoadedScene,
    receiver: &PlannedReceiver,
    levels: &[f64],
    folder: &dyn ResultFiles,
) -> Result<(), RunError> {
    let title = format!("Directivity, {}: {}", receiver.name, loaded.title());
    let angle = |index: usize| 360.0 * index as f64 / levels.len() as f64;
    // The first point again closes the circle.
    let points: Vec<(f64, f64)> =
        (0..=levels.len()).map(|index| (angle(index), levels[index % levels.len()])).collect();
    let plot = PolarPlot {
        title: &title,
        source: "Source: the rolling tyre",
        quantity: "A-weighted level [dB(A)]",
        series: vec![Series { name: "", points }],
    };
    Ok(folder.write_text(&format!("directivity_{}.svg", receiver.file), &plot.to_svg())?)
}
