//! Points with intervals over common axes.

use plotters::style::WHITE;

use super::axis::{Axis, four_digits};
use super::canvas::{Anchor, Form, Grid, MARK, PlotError, draw};
use super::colour;
use super::layout::{EDGE, Layout, Legend, WIDTH};

/// Half the width of an interval's ends, and of the square that shows a point's value under a pointer, in drawn units.
const SERIF: i32 = 14;
const REACH: i32 = 20;
/// Height of the frame in shown pixels.
const HEIGHT: i32 = 300;
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
    ///
    /// # Errors
    /// [`PlotError::Draw`].
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        let listed: Vec<(usize, &str)> =
            self.series.iter().map(|series| series.name).enumerate().filter(|(_, name)| !name.is_empty()).collect();
        let Layout { frame, bottom } = Layout::new(self.title, [&self.x, &self.y], [0, HEIGHT], EDGE);
        let legend = Legend::below(bottom, listed.iter().map(|(_, name)| *name));
        let words = self.x.is_of_words();
        let written = words && self.series.iter().map(|series| series.points.len()).sum::<usize>() <= MOST_VALUES;
        let at = |x: f64, y: f64| (frame.across(self.x.place(x)), frame.up(self.y.place(y)));
        draw("points", (WIDTH, legend.bottom), "", |sheet| {
            sheet.axes(self.title, &frame, &self.x, &self.y, Grid::Both);
            for (index, series) in self.series.iter().enumerate() {
                let colour = colour::line(index);
                let means = series.means();
                if !words && (series.joined || means.len() < series.points.len()) && means.len() > 1 {
                    sheet.line(means.iter().map(|&(x, y)| at(x, y)).collect(), colour, 1.75);
                }
                for &(x, y, half) in &series.points {
                    let (place, low, high) = (at(x, y), at(x, y - half), at(x, y + half));
                    if half > 0.0 {
                        sheet.line(vec![low, high], colour, 1.0);
                        for (end, up) in [low, high] {
                            sheet.line(vec![(end - SERIF, up), (end + SERIF, up)], colour, 1.0);
                        }
                    }
                    sheet.mark(place, Form::of_curve(index), MARK, colour, WHITE);
                    let interval = if half > 0.0 { format!(" \u{b1} {}", four_digits(half)) } else { String::new() };
                    let named = if series.name.is_empty() { self.y.title() } else { series.name };
                    let text =
                        format!("{}: {}\n{named}: {}{interval}", self.x.title(), self.x.label(x), four_digits(y));
                    if written {
                        sheet.note(&format!("{y:.1}"), (place.0 + REACH, place.1), Anchor::Right);
                    }
                    sheet.value(place.0 - REACH..place.0 + REACH, &(place.1 - REACH..place.1 + REACH), &text);
                }
            }
            sheet.frame(&frame);
            for ((index, _), entry) in listed.iter().zip(&legend.entries) {
                sheet.legend_entry(entry, colour::line(*index), Some((Form::of_curve(*index), WHITE)));
            }
        })
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
        let svg = PointPlot { title: "t", x, y, series: vec![series] }.to_svg().unwrap();
        for text in ["elastic", "bedding", "beside", "tread: elastic\nbeside: 1.000 \u{b1} 0.5000"] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        assert_eq!(svg.matches("<title>").count(), 3);
        assert!(svg.contains("\n1.0\n") && svg.contains("\n4.0\n"), "values stand beside the points: {svg}");
        let lines = |x: Axis| {
            let points = vec![(0.0, 1.0, 0.0), (1.0, 4.0, 0.0)];
            let series = vec![PointSeries { name: "", points, joined: true }];
            let plot = PointPlot { title: "t", x, y: Axis::linear("y", 0.0..5.0), series };
            plot.to_svg().unwrap().lines().filter(|line| line.contains("<polyline") && line.contains("#0072B2")).count()
        };
        let (words, numbers) = (Axis::of_words("tread", &["elastic", "bedding"]), Axis::linear("x", 0.0..1.0));
        assert_eq!((lines(words), lines(numbers)), (0, 1), "no line joins words");
    }
}
