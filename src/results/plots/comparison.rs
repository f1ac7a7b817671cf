//! Measured points and computed curves over a common horizontal axis, in panels above each other, with a legend.

use super::axis::Axis;
use super::colour::{self, INK, WHITE};
use super::curve::has_position;
use super::layout::{EDGE, Key};
use super::lines::STROKE;
use super::sheet::{Form, MARK, Sheet};

/// Height of a panel's frame in shown pixels.
const HEIGHT: f64 = 240.0;

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
    pub(crate) fn to_svg(&self) -> String {
        let mut sheet = Sheet::default();
        for (number, panel) in self.panels.iter().enumerate() {
            let title = if number == 0 { self.title } else { "" };
            let axes = sheet.axes(title, [&self.x, &panel.y], HEIGHT, EDGE);
            sheet.curve(&axes, &[(self.x.range.start, 0.0), (self.x.range.end, 0.0)], INK, 0.75);
            for (index, points) in panel.points.iter().enumerate() {
                for &point in points.iter().filter(|&&point| has_position(axes.at(point))) {
                    sheet.mark(axes.within(point), Form::of_curve(index), 0.6 * MARK, colour::line(index), WHITE);
                }
            }
            for (index, curve) in panel.curves.iter().enumerate() {
                sheet.curve(&axes, curve, colour::line(index), STROKE);
            }
            sheet.outline(axes.frame);
        }
        let key = |index| Key::Mark(Form::of_curve(index), WHITE);
        let names = self.names.iter().enumerate();
        sheet.legend(names.map(|(index, name)| (*name, colour::line(index), key(index))));
        sheet.into_svg()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_panel_has_its_points_curves_and_legend() {
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
        let svg = plot.to_svg();
        for text in ["50 mm", "20 mm", "Level", "Phase", "Frequency"] {
            assert!(svg.contains(text), "{text}");
        }
        // Two disks in each panel, and one in the legend: NaN has no position.
        assert_eq!(svg.matches("<circle").count(), 2 * 2 + 1, "{svg}");
    }
}
