//! Points with intervals over common axes.

use super::axis::{Axis, four_digits};
use super::colour::{self, WHITE};
use super::layout::{EDGE, Key, TICK_LABEL};
use super::lines::STROKE;
use super::sheet::{Anchor, Form, Frame, MARK, Sheet};

/// Half the width of an interval's ends, and of the square that shows a point's value under a pointer, in shown
/// pixels.
const SERIF: f64 = 3.5;
const REACH: f64 = 5.0;
/// Height of the frame in shown pixels.
const HEIGHT: f64 = 300.0;
/// Most points over an axis of words whose values are written beside them.
const MOST_VALUES: usize = 12;

/// Points of one kind.
#[derive(Clone, Debug)]
pub(crate) struct PointSeries<'a> {
    /// Name in the legend; a series with an empty name is not listed.
    pub name: &'a str,
    /// Places, values and half the width of each value's interval, in the units of the axes.
    pub points: Vec<(f64, f64, f64)>,
    /// True if a line joins the means even where no two points share a place.
    pub joined: bool,
}

/// A plot of points; where several share a place, or where [`PointSeries::joined`] is set, a line joins their means. On
/// an axis of words no line is drawn, and values are written beside the points.
#[derive(Clone, Debug)]
pub(crate) struct PointPlot<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Points by kind.
    pub series: Vec<PointSeries<'a>>,
}

impl PointPlot<'_> {
    /// The picture as SVG.
    pub(crate) fn to_svg(&self) -> String {
        let words = self.x.is_of_words();
        let written = words && self.series.iter().map(|series| series.points.len()).sum::<usize>() <= MOST_VALUES;
        let mut sheet = Sheet::default();
        let axes = sheet.axes(self.title, [&self.x, &self.y], HEIGHT, EDGE);
        for (index, series) in self.series.iter().enumerate() {
            let colour = colour::line(index);
            let means = series.means();
            if !words && (series.joined || means.len() < series.points.len()) {
                sheet.curve(&axes, &means, colour, STROKE);
            }
            for &(x, y, half) in &series.points {
                let mut interval = String::new();
                if half > 0.0 {
                    let ends = [y - half, y + half].map(|end| axes.within((x, end)));
                    sheet.line(&ends, colour, 1.0);
                    for (across, up) in ends {
                        sheet.line(&[(across - SERIF, up), (across + SERIF, up)], colour, 1.0);
                    }
                    interval = format!(" \u{b1} {}", four_digits(half));
                }
                let at = axes.within((x, y));
                sheet.mark(at, Form::of_curve(index), MARK, colour, WHITE);
                if written {
                    sheet.text(&format!("{y:.1}"), (at.0 + REACH, at.1), Anchor::Right, TICK_LABEL);
                }
                let named = if series.name.is_empty() { self.y.title.as_str() } else { series.name };
                let (place, value) = (self.x.label(x), four_digits(y));
                let text = format!("{}: {place}\n{named}: {value}{interval}", self.x.title);
                sheet.value(Frame::around(at, 2.0 * REACH, 2.0 * REACH), &text);
            }
        }
        sheet.outline(axes.frame);
        let key = |index| Key::Mark(Form::of_curve(index), WHITE);
        let series = self.series.iter().enumerate();
        sheet.legend(series.map(|(index, series)| (series.name, colour::line(index), key(index))));
        sheet.into_svg()
    }
}

impl PointSeries<'_> {
    /// Mean value at every place, from the left; places with fewer points than others are left out, since their means
    /// are not comparable.
    fn means(&self) -> Vec<(f64, f64)> {
        let mut points = self.points.clone();
        points.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mean = |points: &[(f64, f64, f64)]| {
            (points[0].0, points.iter().map(|point| point.1).sum::<f64>() / points.len() as f64)
        };
        let places = || points.chunk_by(|one, other| one.0.total_cmp(&other.0).is_eq());
        let most = places().map(<[_]>::len).max();
        places().filter(|points| Some(points.len()) == most).map(mean).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_have_intervals_values_and_a_line_through_their_means() {
        let points = vec![(0.0, 1.0, 0.5), (1.0, 4.0, 0.0), (0.0, 3.0, 0.0), (1.0, 5.0, 0.0), (2.0, 9.0, 0.0)];
        let mut series = PointSeries { name: "beside", points, joined: false };
        assert_eq!(series.means(), [(0.0, 2.0), (1.0, 4.5)], "one of two is missing at 2");
        series.points.truncate(3);
        let (x, y) = (Axis::of_words("tread", &["elastic", "bedding"]), Axis::linear("Level [dB]", 0.0..5.0));
        let svg = PointPlot { title: "t", x, y, series: vec![series] }.to_svg();
        for text in ["elastic", "bedding", "beside", "tread: elastic\nbeside: 1.000 \u{b1} 0.5000"] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        assert_eq!(svg.matches("<title>").count(), 3);
        assert!(svg.contains(">1.0</text>") && svg.contains(">4.0</text>"), "values stand beside the points: {svg}");
        let lines = |x: Axis| {
            let points = vec![(0.0, 1.0, 0.0), (1.0, 4.0, 0.0)];
            let series = vec![PointSeries { name: "", points, joined: true }];
            let plot = PointPlot { title: "t", x, y: Axis::linear("y", 0.0..5.0), series };
            plot.to_svg().lines().filter(|line| line.contains("<polyline") && line.contains("#0072B2")).count()
        };
        let (words, numbers) = (Axis::of_words("tread", &["elastic", "bedding"]), Axis::linear("x", 0.0..1.0));
        assert_eq!((lines(words), lines(numbers)), (0, 1), "no line joins words");
    }
}
