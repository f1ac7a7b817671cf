//! Levels over the direction round a body in polar coordinates: straight ahead is up, the left is left.

use super::axis::{Axis, extent, four_digits};
use super::colour::{self, GRID, INK};
use super::curve::has_position;
use super::layout::{EDGE, Key, TICK_LABEL, TITLE, lines, stacked};
use super::lines::{STROKE, Series};
use super::sheet::{Anchor, Frame, Point, Sheet, WIDTH, line_height};

/// Largest range of levels from the outermost circle to the middle \[dB\]: lower ones are drawn in the middle.
const DEEPEST: f64 = 40.0;
/// Distance of the circles \[dB\].
const STEP: f64 = 5.0;
/// Angle between spokes \[degrees\].
const SPOKE: f64 = 30.0;
/// Diameter of the outermost circle, and side of the square that shows a point's value under a pointer, in shown
/// pixels.
const DIAMETER: f64 = 340.0;
const REACH: f64 = 10.0;

#[derive(Clone, Debug)]
pub(crate) struct PolarPlot<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Name of the source of the sound.
    pub source: &'a str,
    /// Quantity of the levels, with their unit.
    pub quantity: &'a str,
    /// Curves: angles from straight ahead by the left \[degrees\], levels \[dB\].
    pub series: Vec<Series<'a>>,
}

impl PolarPlot<'_> {
    /// The picture as SVG.
    pub(crate) fn to_svg(&self) -> String {
        let level = self.axis();
        let title = lines(self.title, WIDTH - 2.0 * EDGE, TITLE);
        let top = EDGE + stacked(&title, TITLE) + 2.0 * line_height(TICK_LABEL);
        let middle = (0.5 * WIDTH, top + 0.5 * DIAMETER);
        let mut sheet = Sheet::default();
        sheet.texts(&title, (0.5 * WIDTH, EDGE), Anchor::Below, TITLE);
        for (radius, _) in level.ticks() {
            sheet.circle(middle, 0.5 * DIAMETER * radius, GRID);
        }
        for spoke in 0..12 {
            let angle = f64::from(spoke) * SPOKE;
            sheet.line(&[middle, place(middle, angle, 1.0)], GRID, 1.0);
            let degrees = format!("{angle}°");
            let (text, anchor) = match spoke {
                0 => ("ahead", Anchor::Above),
                3 => ("left", Anchor::Left),
                6 => ("behind", Anchor::Below),
                9 => ("right", Anchor::Right),
                1..6 => (degrees.as_str(), Anchor::Left),
                _ => (degrees.as_str(), Anchor::Right),
            };
            sheet.text(text, place(middle, angle, 1.03), anchor, TICK_LABEL);
        }
        sheet.circle(middle, 0.5 * DIAMETER, INK);
        for (index, series) in self.series.iter().enumerate() {
            let name = if series.name.is_empty() { self.quantity } else { series.name };
            let stretches = series.points.chunk_by(|a, b| has_position(*a) == has_position(*b));
            for stretch in stretches.filter(|stretch| has_position(stretch[0])) {
                let at = |&(angle, value): &(f64, f64)| place(middle, angle, level.place(value).max(0.0));
                sheet.line(&stretch.iter().map(at).collect::<Vec<_>>(), colour::line(index), STROKE);
                for point in stretch {
                    let text = format!("{}° by the left\n{name}: {}", four_digits(point.0), four_digits(point.1));
                    sheet.value(Frame::around(at(point), REACH, REACH), &text);
                }
            }
        }
        // Between two spokes, where curves hide little.
        for (radius, label) in level.ticks() {
            sheet.text(label, place(middle, -0.5 * SPOKE, radius), Anchor::Right, TICK_LABEL);
        }
        sheet.bottom = top + DIAMETER + 2.0 * line_height(TICK_LABEL);
        for text in [self.quantity, self.source] {
            let text = lines(text, WIDTH - 2.0 * EDGE, TICK_LABEL);
            sheet.texts(&text, (0.5 * WIDTH, sheet.bottom), Anchor::Below, TICK_LABEL);
            sheet.bottom += stacked(&text, TICK_LABEL);
        }
        sheet.bottom += EDGE;
        let series = self.series.iter().enumerate();
        sheet.legend(series.map(|(index, series)| (series.name, colour::line(index), Key::Line)));
        sheet.into_svg()
    }

    /// Axis from the middle to the outermost circle.
    fn axis(&self) -> Axis {
        let levels = extent(self.series.iter().flat_map(|series| series.points.iter().map(|point| point.1)));
        let highest = (levels.end / STEP).ceil() * STEP;
        let lowest = (levels.start / STEP).floor() * STEP;
        Axis::linear(self.quantity, (lowest - STEP).max(highest - DEEPEST)..highest)
    }
}

/// Point at a direction \[degrees\] and a part of the radius.
fn place((x, y): Point, angle: f64, radius: f64) -> Point {
    let (sin, cos) = angle.to_radians().sin_cos();
    (x - 0.5 * DIAMETER * radius * sin, y - 0.5 * DIAMETER * radius * cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ahead_is_up_and_the_left_is_left_and_the_source_is_named() {
        let [ahead, left, behind] = [0.0, 90.0, 180.0].map(|angle| place((0.0, 0.0), angle, 1.0));
        assert!(ahead.0.abs() < 1e-9 && ahead.1 < 0.0 && behind.1 > 0.0, "{ahead:?} {behind:?}");
        assert!(left.0 < 0.0 && left.1.abs() < 1e-9, "{left:?}");
        let points = vec![(0.0, -3.0), (90.0, -20.0), (180.0, -90.0), (270.0, f64::NEG_INFINITY)];
        let plot = PolarPlot {
            title: "Directivity: a tyre",
            source: "Source: a point of the tread",
            quantity: "Transfer [dB re 1/m]",
            series: vec![Series { name: "500 Hz", points }],
        };
        // Forty decibels are shown, and lower levels are in the middle.
        assert_eq!(plot.axis().range, -40.0..0.0);
        let svg = plot.to_svg();
        for text in ["Directivity: a tyre", "Source: a point of the tread", "Transfer [dB re 1/m]", "ahead", "left"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(svg.contains("90.00° by the left\n500 Hz: −20.00"), "{svg}");
    }
}
