//! Levels over the direction round a body in polar coordinates: straight ahead is up, the left is left.

use std::ops::Range;

use super::axis::{Axis, four_digits};
use super::canvas::{Anchor, GRID, INK, PlotError, draw};
use super::colour;
use super::layout::{EDGE, FINE, Frame, Legend, TICK_LABEL, TITLE, WIDTH, line_height, lines};
use super::lines::Series;

/// Largest range of levels from the outermost circle to the middle \[dB\]: lower ones are drawn in the middle.
const DEEPEST: f64 = 40.0;
/// Distance of the circles \[dB\].
const STEP: f64 = 5.0;
/// Angle between spokes, and between the points of a circle \[degrees\].
const SPOKE: usize = 30;
const ARC: usize = 3;
/// Diameter of the outermost circle in shown pixels.
const DIAMETER: i32 = 340;
/// Half the side of the square that shows a point's value under a pointer, in shown pixels.
const REACH: f64 = 5.0;

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
    ///
    /// # Errors
    /// [`PlotError::Draw`].
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        let level = self.axis();
        let listed: Vec<(usize, &str)> =
            self.series.iter().map(|series| series.name).enumerate().filter(|(_, name)| !name.is_empty()).collect();
        let title = lines(self.title, WIDTH - 2 * EDGE, TITLE);
        let top = EDGE + title.len() as i32 * line_height(TITLE) + 2 * line_height(TICK_LABEL);
        let frame = Frame::of((WIDTH - DIAMETER) / 2..(WIDTH + DIAMETER) / 2, top..top + DIAMETER);
        let below = [self.quantity, self.source].map(|text| lines(text, WIDTH - 2 * EDGE, TICK_LABEL));
        let notes = top + DIAMETER + 2 * line_height(TICK_LABEL);
        let bottom = notes + below.iter().flatten().count() as i32 * line_height(TICK_LABEL) + EDGE;
        let legend = Legend::below(bottom, listed.iter().map(|(_, name)| *name));
        let at = |angle: f64, level: f64| place(&frame, angle, level);
        draw("a polar plot", (WIDTH, legend.bottom), "", |sheet| {
            sheet.heading(&title, EDGE);
            for (radius, _) in level.ticks() {
                let circle = (0..=360).step_by(ARC).map(|angle| at(f64::from(angle as u32), radius));
                sheet.line(circle.collect(), GRID, 1.0);
            }
            for angle in (0..360).step_by(SPOKE) {
                let degrees = f64::from(angle as u32);
                sheet.line(vec![at(degrees, 0.0), at(degrees, 1.0)], GRID, 1.0);
                let (text, anchor) = match angle {
                    0 => ("ahead".to_owned(), Anchor::Above),
                    180 => ("behind".to_owned(), Anchor::Below),
                    90 => ("left".to_owned(), Anchor::Left),
                    270 => ("right".to_owned(), Anchor::Right),
                    1..180 => (format!("{angle}°"), Anchor::Left),
                    _ => (format!("{angle}°"), Anchor::Right),
                };
                sheet.note(&text, at(degrees, 1.03), anchor);
            }
            let rim = (0..=360).step_by(ARC).map(|angle| at(f64::from(angle as u32), 1.0));
            sheet.line(rim.collect(), INK, 1.0);
            for (index, series) in self.series.iter().enumerate() {
                let inside = |&(angle, value): &(f64, f64)| at(angle, level.place(value).clamp(0.0, 1.0));
                let stretches = series.points.chunk_by(|a, b| a.1.is_finite() && b.1.is_finite());
                for stretch in stretches.filter(|stretch| stretch.len() > 1) {
                    sheet.line(stretch.iter().map(inside).collect(), colour::line(index), 1.75);
                }
                for point in series.points.iter().filter(|point| point.1.is_finite()) {
                    let (x, y) = inside(point);
                    let name = if series.name.is_empty() { self.quantity } else { series.name };
                    let text = format!("{}° by the left\n{name}: {}", four_digits(point.0), four_digits(point.1));
                    sheet.value(around(x, &frame), &around(y, &frame), &text);
                }
            }
            // Between two spokes, where curves hide little.
            for (radius, label) in level.ticks() {
                sheet.note(label, at(-0.5 * SPOKE as f64, radius), Anchor::Right);
            }
            for (row, line) in below.iter().flatten().enumerate() {
                let y = notes + row as i32 * line_height(TICK_LABEL);
                sheet.note(line, (frame.across(0.5), y * FINE), Anchor::Below);
            }
            for ((index, _), entry) in listed.iter().zip(&legend.entries) {
                sheet.legend_entry(entry, colour::line(*index), None);
            }
        })
    }

    /// Axis from the middle to the outermost circle.
    fn axis(&self) -> Axis {
        let levels = self.series.iter().flat_map(|series| series.points.iter().map(|point| point.1));
        let finite = || levels.clone().filter(|level| level.is_finite());
        let highest = (finite().fold(f64::NEG_INFINITY, f64::max) / STEP).ceil() * STEP;
        let lowest = (finite().fold(f64::INFINITY, f64::min) / STEP).floor() * STEP;
        Axis::linear(self.quantity, (lowest - STEP).max(highest - DEEPEST)..highest)
    }
}

/// Point at a direction \[degrees\] and a part of the radius, in drawn units.
fn place(frame: &Frame, angle: f64, radius: f64) -> (i32, i32) {
    let (sin, cos) = angle.to_radians().sin_cos();
    (frame.across(0.5 - 0.5 * radius * sin), frame.up(0.5 + 0.5 * radius * cos))
}

/// Range about a coordinate in which a pointer shows the value.
fn around(at: i32, frame: &Frame) -> Range<i32> {
    let reach = (REACH / f64::from(DIAMETER) * f64::from(frame.x.end - frame.x.start)) as i32;
    at - reach..at + reach
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ahead_is_up_and_the_left_is_left_and_the_source_is_named() {
        let frame = Frame::of(0..100, 0..100);
        let middle = place(&frame, 0.0, 0.0);
        let [ahead, left, behind] = [0.0, 90.0, 180.0].map(|angle| place(&frame, angle, 1.0));
        assert!(ahead.0 == middle.0 && ahead.1 < middle.1 && behind.1 > middle.1, "{ahead:?} {behind:?} {middle:?}");
        assert!(left.0 < middle.0 && left.1 == middle.1, "{left:?} {middle:?}");
        let points = vec![(0.0, -3.0), (90.0, -20.0), (180.0, -90.0), (270.0, f64::NEG_INFINITY)];
        let plot = PolarPlot {
            title: "Directivity: a tyre",
            source: "Source: a point of the tread",
            quantity: "Transfer [dB re 1/m]",
            series: vec![Series { name: "500 Hz", points }],
        };
        // Forty decibels are shown, and lower levels are in the middle.
        assert_eq!(plot.axis().range(), -40.0..0.0);
        let svg = plot.to_svg().unwrap();
        for text in ["Directivity: a tyre", "Source: a point of the tread", "Transfer [dB re 1/m]", "ahead", "left"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(svg.contains("90.00° by the left\n500 Hz: −20.00"), "{svg}");
    }
}
