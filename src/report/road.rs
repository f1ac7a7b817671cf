//! Words and pictures of a road.

use ndarray::ArrayView2;

use crate::results::PlotError;
use crate::results::plots::{Axis, LinePlot, Series, SurfaceMap, four_digits};
use crate::results::table::{Report, aligned, words};
use crate::road::texture::OverallLevel;
use crate::road::{RoadDescription, TextureLevel};

/// Picture of a piece of a road, its heights in colours.
///
/// # Errors
/// [`PlotError`], also without a sample.
pub(crate) fn map(title: &str, road: &RoadDescription) -> Result<String, PlotError> {
    let sample = &road.sample;
    let heights = ArrayView2::from_shape((sample.rows, sample.columns), &sample.heights);
    let (picture, quantity, got) = ("a road", "heights", sample.heights.len());
    let expected = sample.rows * sample.columns;
    let heights = heights.map_err(|_| PlotError { picture, quantity, expected, got })?;
    let millimetres = heights.mapv(|height| 1e3 * height);
    SurfaceMap {
        title,
        along: "Along the road",
        quantity: "Height [mm]",
        values: millimetres.view(),
        first_position: sample.start,
        size: [sample.dx, sample.dy],
    }
    .to_svg()
}

/// Picture of the third-octave levels of a road's texture over the wavelength, grey where the road is too short for
/// them; `None` for a plane.
pub(crate) fn texture_spectrum(title: &str, road: &RoadDescription) -> Option<String> {
    let points: Vec<(f64, f64)> = road.levels.iter().map(|at| (1e3 * at.wavelength, at.level)).collect();
    if points.len() < 2 {
        return None;
    }
    let plot = LinePlot {
        title,
        x: Axis::logarithmic_around("Texture wavelength [mm]", points.iter().map(|point| point.0), [0.9, 1.1]),
        y: Axis::linear_around("Texture level [dB re 1e-6 m]", points.iter().map(|point| point.1)),
        series: vec![Series { name: "", points }],
    };
    Some(plot.to_svg_by_validity(|_, point| road.levels[point].valid))
}

/// A road in words and numbers.
pub(crate) fn description(road: &RoadDescription) -> Report {
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
    if let Some([skewness, kurtosis]) = road.moments {
        row("skewness, kurtosis", format!("{skewness:.2}, {kurtosis:.2}"));
    }
    if let Some(depth) = &road.mean_profile_depth {
        row("mean profile depth", depth.mean.map_or("not defined".into(), millimetres));
        let deviation = depth.deviation.map_or(String::new(), |deviation| {
            format!(", standard deviation {} of a segment's depth", millimetres(deviation))
        });
        row("its segments", format!("{} of {} of 100 mm are valid{deviation}", depth.valid, depth.segments));
        if depth.too_coarse {
            row("its standard", "ISO 13473-1 asks for a spacing of 1 mm or less: the depth is too small".into());
        }
        let reference = match depth.reference_surface {
            Some(true) => "its depth agrees",
            Some(false) => "its depth does not agree",
            None => "not known: there is no depth by the standard",
        };
        row("ISO 10844:2014, 0.5 +- 0.2 mm", reference.into());
    }
    for (name, overall) in [("macrotexture", &road.macrotexture), ("megatexture", &road.megatexture)] {
        if let Some(OverallLevel { level, longest, shortest, complete }) = overall {
            let part = if *complete { "all" } else { "only" };
            let bands = format!("{part} bands of {} to {} mm", four_digits(1e3 * shortest), four_digits(1e3 * longest));
            row(&format!("level of {name}"), format!("{level:.1} dB re 1e-6 m, {bands}"));
        }
    }
    let hertz = |frequency: Option<f64>| frequency.map_or("none".into(), |f| format!("{f:.0} Hz"));
    row(
        "highest frequency excited",
        format!(
            "{} in this run, {} by the road itself",
            hertz(road.highest_frequency),
            hertz(road.highest_frequency_of_road)
        ),
    );
    let mut report = Report::from(words([""; 0], rows));
    if !road.levels.is_empty() {
        let value =
            |at: &TextureLevel| if at.valid { format!("{:.1}", at.level) } else { format!("({:.1})", at.level) };
        let level = road.levels.iter().map(|at| [format!("{:.2}", 1e3 * at.wavelength), value(at)]);
        report.titled("\n", aligned(["wavelength [mm]", "level [dB re 1e-6 m]"], level));
        if road.levels.iter().any(|at| !at.valid) {
            report.text("in brackets: the road is shorter than the twelve wavelengths that ISO 13473-4 asks for\n");
        }
    }
    report.text("\n");
    road.report.notes.iter().for_each(|note| report.text(format!("note: {note}\n")));
    report
}
