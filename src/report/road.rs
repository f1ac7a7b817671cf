//! What there is to say and to show of a road.

use ndarray::ArrayView2;

use crate::results::PlotError;
use crate::results::plots::{Axis, LinePlot, Series, road_map};
use crate::results::table::{Report, aligned, words};
use crate::road::RoadDescription;

/// A piece of a road in colours.
///
/// # Errors
/// [`PlotError`], without a sample, too.
pub fn map(title: &str, road: &RoadDescription) -> Result<String, PlotError> {
    let sample = &road.sample;
    let heights = ArrayView2::from_shape((sample.rows, sample.columns), &sample.heights);
    let (picture, quantity, got) = ("a road", "heights", sample.heights.len());
    let expected = sample.rows * sample.columns;
    let heights = heights.map_err(|_| PlotError::Shape { picture, quantity, expected, got })?;
    road_map(title, heights, sample.start, [sample.dx, sample.dy])
}

/// Third-octave levels of a road's texture over the wavelength; `None` for a plane.
///
/// # Errors
/// [`PlotError`].
pub fn texture_spectrum(title: &str, road: &RoadDescription) -> Result<Option<String>, PlotError> {
    let points: Vec<(f64, f64)> =
        road.levels.iter().map(|at| (1e3 * at.wavelength, at.level)).filter(|(_, level)| level.is_finite()).collect();
    if points.len() < 2 {
        return Ok(None);
    }
    let plot = LinePlot {
        title,
        x: Axis::logarithmic_around("Texture wavelength [mm]", points.iter().map(|point| point.0), [0.9, 1.1]),
        y: Axis::linear_around("Texture level [dB re 1e-6 m]", points.iter().map(|point| point.1)),
        series: vec![Series { name: "", points }],
    };
    plot.to_svg().map(Some)
}

/// A road in words and numbers.
pub fn description(road: &RoadDescription) -> Report {
    let mut rows: Vec<[String; 2]> = Vec::new();
    let mut row = |name: &str, value: String| rows.push([name.to_owned(), value]);
    let millimetres = |length: f64| format!("{:.3} mm", 1e3 * length);
    row("extent", road.extent.map_or("endless".into(), |(from, to)| format!("{from:.3} to {to:.3} m")));
    row(
        "run's lattice",
        format!(
            "elements of {}, {} x {} cells of {} along, {} across",
            millimetres(road.lattice.dx),
            road.lattice.along,
            road.lattice.columns,
            millimetres(road.lattice.cell()),
            millimetres(road.lattice.dy)
        ),
    );
    if let Some(spacing) = road.report.spacing {
        let across = road.report.lateral_spacing.map_or("level across".into(), |dy| format!("dy {}", millimetres(dy)));
        row("road's own lattice", format!("dx {}, {across}", millimetres(spacing)));
    }
    if road.report.points > 0 {
        let share = 100.0 * road.report.missing as f64 / road.report.points as f64;
        row("points in the file", format!("{}, {} missing ({share:.1} %)", road.report.points, road.report.missing));
    }
    row("rms height", millimetres(road.rms));
    row("highest to lowest", millimetres(road.span));
    row("mean profile depth", road.mean_profile_depth.map_or("not defined".into(), millimetres));
    let hertz = |frequency: Option<f64>| frequency.map_or("none".into(), |f| format!("{f:.0} Hz"));
    row(
        "highest frequency excited",
        format!(
            "{} in this run, {} by the road itself",
            hertz(road.highest_frequency),
            hertz(road.highest_frequency_of_road)
        ),
    );
    let mut report = Report::default();
    report.table(words([""; 0], rows));
    if !road.levels.is_empty() {
        let level = road.levels.iter().map(|at| [format!("{:.2}", 1e3 * at.wavelength), format!("{:.1}", at.level)]);
        report.text("\n");
        report.table(aligned(["wavelength [mm]", "level [dB re 1e-6 m]"], level));
    }
    report.text("\n");
    road.report.notes.iter().for_each(|note| report.text(format!("note: {note}\n")));
    report
}
