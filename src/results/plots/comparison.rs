//! Measured points and computed curves over a common horizontal axis, in panels above each other, with a legend.

use plotters::style::WHITE;

use super::axis::Axis;
use super::canvas::{Form, Grid, INK, MARK, PlotError, draw};
use super::colour;
use super::layout::{EDGE, Layout, Legend, WIDTH};
use super::lines::cut;

/// Height of a panel's frame in shown pixels.
const HEIGHT: i32 = 240;

#[derive(Clone, Debug)]
pub(crate) struct ComparisonPanel {
    /// Vertical axis.
    pub y: Axis,
    /// Points by name, in the order of [`ComparisonPlot::names`].
    pub points: Vec<Vec<(f64, f64)>>,
    /// Curves by name; empty for points alone.
    pub curves: Vec<Vec<(f64, f64)>>,
}

/// Points and curves in panels. Points outside the frame are drawn at its edge; curves are cut there.
#[derive(Clone, Debug)]
pub(crate) struct ComparisonPlot<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Horizontal axis.
    pub x: Axis,
    /// Names in the legend: a colour and a form each.
    pub names: Vec<&'a str>,
    /// Panels, from the top.
    pub panels: Vec<ComparisonPanel>,
}

impl ComparisonPlot<'_> {
    /// The picture as SVG.
    ///
    /// # Errors
    /// [`PlotError::Draw`].
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        let (mut frames, mut top) = (Vec::new(), 0);
        for (number, panel) in self.panels.iter().enumerate() {
            let title = if number == 0 { self.title } else { "" };
            let Layout { frame, bottom } = Layout::new(title, [&self.x, &panel.y], [top, HEIGHT], EDGE);
            frames.push(frame);
            top = bottom;
        }
        let legend = Legend::below(top, self.names.iter().copied());
        draw("a comparison", (WIDTH, legend.bottom), "", |sheet| {
            for (number, (panel, frame)) in self.panels.iter().zip(&frames).enumerate() {
                sheet.axes(if number == 0 { self.title } else { "" }, frame, &self.x, &panel.y, Grid::Both);
                let zero = panel.y.place(0.0);
                if (0.0..=1.0).contains(&zero) {
                    sheet.line(vec![(frame.x.start, frame.up(zero)), (frame.x.end, frame.up(zero))], INK, 0.75);
                }
                let place = |&(x, y): &(f64, f64)| (self.x.place(x), panel.y.place(y));
                for (index, points) in panel.points.iter().enumerate() {
                    for (x, y) in points.iter().map(place).filter(|(x, y)| x.is_finite() && y.is_finite()) {
                        let at = (frame.across(x.clamp(0.0, 1.0)), frame.up(y.clamp(0.0, 1.0)));
                        sheet.mark(at, Form::of_curve(index), 0.6 * MARK, colour::line(index), WHITE);
                    }
                }
                for (index, curve) in panel.curves.iter().enumerate() {
                    for piece in cut(&curve.iter().map(place).collect::<Vec<_>>()) {
                        let points = piece.into_iter().map(|(x, y)| (frame.across(x), frame.up(y))).collect();
                        sheet.line(points, colour::line(index), 1.75);
                    }
                }
                sheet.frame(frame);
            }
            for (index, entry) in legend.entries.iter().enumerate() {
                sheet.legend_entry(entry, colour::line(index), Some((Form::of_curve(index), WHITE)));
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_panel_has_its_points_and_curves_and_the_legend_its_names() {
        let panel = |title: &str, curves: Vec<Vec<(f64, f64)>>| ComparisonPanel {
            y: Axis::linear(title, -1.0..1.0),
            points: vec![vec![(10.0, 0.5), (20.0, f64::NAN), (50.0, 7.0)], vec![(30.0, -0.5)]],
            curves,
        };
        let plot = ComparisonPlot {
            title: "t",
            x: Axis::logarithmic("Frequency", 10.0..100.0),
            names: vec!["50 mm", "20 mm"],
            panels: vec![panel("Level", vec![vec![(10.0, 0.4), (100.0, 0.6)]]), panel("Phase", vec![])],
        };
        let svg = plot.to_svg().unwrap();
        for text in ["50 mm", "20 mm", "Level", "Phase", "Frequency"] {
            assert!(svg.contains(text), "{text}");
        }
        // Two disks with an inside and an outline in each panel, and one in the legend: NaN has no position.
        assert_eq!(svg.matches("<circle").count(), 2 * 2 * 2 + 2, "{svg}");
    }
}
