//! A slice of the road in pictures: its profile, the pressure on it, its displacement and stiffness.

use crate::results::plots::{Axis, LinePlot, Series};
use crate::study::slices::{LAWS, SliceView};

/// Number of points of a drawn curve.
const POINTS: usize = 200;

/// Pictures of the profile with the indentation levels, the pressure at these, displacement S(y) and stiffness s(y) by
/// both laws, each with the name of its file.
pub(crate) fn pictures(title: &str, view: &SliceView) -> Vec<(&'static str, String)> {
    let across: Vec<f64> = view.across.iter().map(|y| 1e3 * y).collect();
    let ends = across[0]..across[across.len() - 1];
    let x = || Axis::linear("Across the tyre [mm]", ends.clone());
    let named = view.levels.map(|level| format!("y = {:.2} mm", 1e3 * level));
    let over = |values: &[f64], unit: f64| across.iter().zip(values).map(|(&y, &value)| (y, unit * value)).collect();

    let mut series = vec![Series { name: "road", points: over(&view.heights, 1e3) }];
    series.extend(view.levels.iter().zip(&named).map(|(level, name)| {
        let height = 1e3 * (view.peak - level);
        Series { name, points: vec![(ends.start, height), (ends.end, height)] }
    }));
    let heights = series.iter().flat_map(|series| series.points.iter().map(|point| point.1)).collect::<Vec<_>>();
    let heading = format!("Road across the tyre: {title}");
    let profile = LinePlot { title: &heading, x: x(), y: Axis::linear_around("Height [mm]", heights), series };

    let under = view.pressures.iter().zip(&named);
    // The road has the first colour in the picture before; a level keeps its colour.
    let mut series = vec![Series { name: "", points: Vec::new() }];
    series.extend(under.map(|(pressure, name)| Series { name, points: over(pressure, 1.0) }));
    let highest = view.pressures.iter().flatten().fold(0.0_f64, |highest, pressure| highest.max(*pressure));
    let y = Axis::linear("Pressure / E* on a half-space [1]", 0.0..1.05 * highest);
    let heading = format!("Pressure across the tyre: {title}");
    let pressure = LinePlot { title: &heading, x: x(), y, series };

    let mut pictures = vec![("slice_profile.svg", profile.to_svg()), ("slice_pressure.svg", pressure.to_svg())];
    let deepest = 1.25 * view.levels[view.levels.len() - 1];
    let curve = |value: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (0..=POINTS).map(|i| deepest * i as f64 / POINTS as f64).map(|y| (1e3 * y, value(y))).collect()
    };
    let curves = view.curves.each_ref();
    for (file, quantity, values) in [
        ("slice_displacement.svg", "S(y) [mm]", curves.map(|c| curve(&|y| 1e3 * c.displacement_at(y)))),
        ("slice_stiffness.svg", "Normalised stiffness s(y) [1]", curves.map(|c| curve(&|y| c.stiffness_at(y)))),
    ] {
        let highest = values.iter().flatten().fold(0.0_f64, |top, point| top.max(point.1));
        let series = LAWS.iter().zip(values).map(|(&(_, name), points)| Series { name, points }).collect();
        let x = Axis::linear("Penetration y past the highest point [mm]", 0.0..1e3 * deepest);
        let heading = format!("A slice by both laws: {title}");
        let plot = LinePlot { title: &heading, x, y: Axis::linear(quantity, 0.0..1.05 * highest), series };
        pictures.push((file, plot.to_svg()));
    }
    pictures
}
