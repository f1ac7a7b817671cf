//! Several curves over common axes, with a legend.

use super::axis::{Axis, four_digits};
use super::colour;
use super::curve::has_position;
use super::layout::{Axes, EDGE, Key, TICK_LABEL, width_of};
use super::sheet::{Anchor, Form, MARK, Point, Sheet};

/// Most marks for curves that leave the picture; with more, none is drawn.
const MOST_BEYOND: usize = 12;
/// Height of the frame in shown pixels.
const HEIGHT: f64 = 300.0;
/// Width of curves in shown pixels.
pub(super) const STROKE: f64 = 1.75;
/// Number of vertical strips of the picture in which a pointer shows the curves' values.
const STRIPS: usize = 120;

/// Range drawn as a band: place, lower and upper end of each of its points.
type Band<'a> = &'a [(f64, [f64; 2])];

/// One curve.
#[derive(Clone, Debug)]
pub(crate) struct Series<'a> {
    /// Name in the legend; a curve with an empty name is not listed.
    pub name: &'a str,
    /// Points in the units of the axes; those without a position on them (NaN, a logarithm of 0) interrupt the curve.
    pub points: Vec<(f64, f64)>,
}

#[derive(Clone, Debug)]
pub(crate) struct LinePlot<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Curves; they are cut at the frame's edges.
    pub series: Vec<Series<'a>>,
}

impl LinePlot<'_> {
    /// The picture as SVG.
    pub(crate) fn to_svg(&self) -> String {
        self.to_svg_by_validity(|_, _| true)
    }

    /// The same with points that are not valid, and the lines to them, in grey; `is_valid(curve, point)` is true for
    /// valid points.
    pub(crate) fn to_svg_by_validity(&self, is_valid: impl Fn(usize, usize) -> bool) -> String {
        self.drawn(None, is_valid)
    }

    /// The picture with a range as a band beneath the curves: its name, and the place, lower and upper end of each of
    /// its points.
    pub(crate) fn to_svg_over(&self, name: &str, range: Band) -> String {
        self.drawn(Some((name, range)), |_, _| true)
    }

    fn drawn(&self, range: Option<(&str, Band)>, is_valid: impl Fn(usize, usize) -> bool) -> String {
        let mut sheet = Sheet::default();
        let axes = sheet.axes(self.title, [&self.x, &self.y], HEIGHT, EDGE);
        if let Some((_, range)) = range {
            // Along the lower ends and back along the upper ones.
            let lower = range.iter().map(|&(x, [low, _])| axes.within((x, low)));
            let upper = range.iter().rev().map(|&(x, [_, high])| axes.within((x, high)));
            sheet.band(&lower.chain(upper).collect::<Vec<_>>(), colour::RANGE);
        }
        for (index, series) in self.series.iter().enumerate() {
            let valid = |point: usize| is_valid(index, point);
            if !(0..series.points.len()).all(valid) {
                sheet.curve(&axes, &series.points, colour::INVALID, STROKE);
            }
            let points = series.points.iter().enumerate();
            let known = points.map(|(point, &(x, y))| (x, if valid(point) { y } else { f64::NAN }));
            sheet.curve(&axes, &known.collect::<Vec<_>>(), colour::line(index), STROKE);
        }
        for (index, at, value, above) in self.beyond(&axes) {
            let (form, anchor) = if above { (Form::Triangle, Anchor::Below) } else { (Form::Tip, Anchor::Above) };
            sheet.mark(at, form, MARK, colour::line(index), colour::line(index));
            // Beside the frame the note would lie on the labels of the other axis.
            let half = 0.5 * width_of(&value, TICK_LABEL) / axes.frame.width;
            let across = at.0.clamp(axes.frame.across(half), axes.frame.across(1.0 - half));
            sheet.text(&value, (across, at.1), anchor, TICK_LABEL);
        }
        for (part, text) in self.values(&is_valid) {
            sheet.value(axes.frame.strip(part), &text);
        }
        sheet.outline(axes.frame);
        let listed =
            self.series.iter().enumerate().map(|(index, series)| (series.name, colour::line(index), Key::Line));
        sheet.legend(listed.chain(range.map(|(name, _)| (name, colour::RANGE, Key::Band))));
        sheet.into_svg()
    }

    /// For each part of a curve that leaves the picture above or below: the curve's index, the point at the edge, the
    /// furthest value, and true for above. Empty if there are too many.
    fn beyond(&self, axes: &Axes<'_>) -> Vec<(usize, Point, String, bool)> {
        let mut all = Vec::new();
        for (index, series) in self.series.iter().enumerate() {
            let placed = series.points.iter().map(|&(x, y)| (self.x.place(x), self.y.place(y), (x, y)));
            let placed: Vec<_> = placed.filter(|&(x, y, _)| has_position((x, y)) && (0.0..=1.0).contains(&x)).collect();
            let side = |y: f64| i8::from(y > 1.0) - i8::from(y < 0.0);
            for part in placed.chunk_by(|a, b| side(a.1) == side(b.1)).filter(|part| side(part[0].1) != 0) {
                let sign = f64::from(side(part[0].1));
                let furthest = part.iter().max_by(|a, b| (sign * a.1).total_cmp(&(sign * b.1)));
                all.extend(furthest.map(|&(.., at)| (index, axes.within(at), four_digits(at.1), sign > 0.0)));
            }
        }
        // Noise that crosses the edge again and again would hide the picture.
        if all.len() > MOST_BEYOND { Vec::new() } else { all }
    }

    /// Texts with the values of the curves in each strip across the picture: of every curve the point nearest to the
    /// strip's middle.
    fn values(&self, is_valid: impl Fn(usize, usize) -> bool) -> Vec<([f64; 2], String)> {
        // By strip and curve: distance from the strip's middle, and number of the nearest point.
        let mut nearest = vec![vec![None::<(f64, usize)>; self.series.len()]; STRIPS];
        for (index, series) in self.series.iter().enumerate() {
            for (point, &(x, y)) in series.points.iter().enumerate() {
                let place = self.x.place(x) * STRIPS as f64;
                let Some(strip) = nearest.get_mut(place as usize).filter(|_| place >= 0.0 && y.is_finite()) else {
                    continue;
                };
                let off = (place.fract() - 0.5).abs();
                if strip[index].is_none_or(|(least, _)| off < least) {
                    strip[index] = Some((off, point));
                }
            }
        }
        let text = |strip: &[Option<(f64, usize)>]| -> Option<String> {
            let mut text = String::new();
            for (index, (_, point)) in strip.iter().enumerate().filter_map(|(index, found)| Some((index, (*found)?))) {
                let Series { name, points } = &self.series[index];
                let (x, y) = points[point];
                if text.is_empty() {
                    text = format!("{}: {}", self.x.title, four_digits(x));
                }
                let name = if name.is_empty() { self.y.title.as_str() } else { name };
                let mark = if is_valid(index, point) { "" } else { ", not valid" };
                text += &format!("\n{name}: {}{mark}", four_digits(y));
            }
            (!text.is_empty()).then_some(text)
        };
        let part = |strip: usize| strip as f64 / STRIPS as f64;
        let strips = nearest.iter().enumerate();
        strips.filter_map(|(strip, found)| Some(([part(strip), part(strip + 1)], text(found)?))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leaves_the_picture_is_marked_with_its_furthest_value() {
        let plot = LinePlot {
            title: "t",
            x: Axis::linear("x", 0.0..4.0),
            y: Axis::linear("y", 0.0..1.0),
            series: vec![Series {
                name: "",
                points: vec![(0.0, 0.5), (1.0, 7.0), (2.0, 9.0), (3.0, 0.5), (4.0, -2.0)],
            }],
        };
        let axes = Sheet::default().axes("", [&plot.x, &plot.y], 50.0, EDGE);
        let beyond = plot.beyond(&axes);
        let reported: Vec<(&str, bool)> = beyond.iter().map(|(_, _, value, above)| (value.as_str(), *above)).collect();
        assert_eq!(reported, [("9.000", true), ("−2.000", false)]);
        assert_eq!(beyond[0].1, (axes.frame.across(0.5), axes.frame.up(1.0)));
        assert!(plot.to_svg().contains(">9.000<"));
    }

    #[test]
    fn the_note_at_a_corner_stays_off_the_labels() {
        let plot = LinePlot {
            title: "t",
            x: Axis::linear("x", 0.0..1.0),
            y: Axis::linear("y", 0.0..1.0),
            series: vec![Series { name: "", points: vec![(0.0, -0.5), (0.5, 0.5), (1.0, 7.123)] }],
        };
        let svg = plot.to_svg();
        let frame = Sheet::default().axes(plot.title, [&plot.x, &plot.y], HEIGHT, EDGE).frame;
        for note in ["−0.5000", "7.123"] {
            let line = svg.lines().find(|line| line.contains(&format!(">{note}<"))).unwrap();
            let at: f64 = line.split("x=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
            let half = 0.5 * width_of(note, TICK_LABEL) - 0.1;
            assert!(frame.left <= at - half && at + half <= frame.across(1.0), "{note} at {at}");
        }
    }

    #[test]
    fn a_range_is_a_band_beneath_the_curves_with_its_name() {
        let (x, y) = (Axis::linear("x", 0.0..2.0), Axis::linear("y", 0.0..1.0));
        let series = vec![Series { name: "computed", points: vec![(0.0, 0.5), (2.0, 0.6)] }];
        let plot = LinePlot { title: "t", x, y, series };
        let svg = plot.to_svg_over("published", &[(0.0, [0.2, 0.4]), (1.0, [0.3, 0.8]), (2.0, [0.3, 2.0])]);
        let band = svg.lines().find(|line| line.starts_with("<polygon")).unwrap();
        assert_eq!(band.matches(',').count(), 6, "{band}");
        assert!(svg.find("<polygon") < svg.find("#0072B2") && svg.contains(">published<"), "{svg}");
    }

    #[test]
    fn values_that_are_not_valid_are_grey() {
        let points = (0..5).map(|x| (f64::from(x), 0.5)).collect();
        let (x, y) = (Axis::linear("x", 0.0..4.0), Axis::linear("y", 0.0..1.0));
        let plot = LinePlot { title: "t", x, y, series: vec![Series { name: "", points }] };
        let grey = |svg: String| svg.contains("#BEBEBE");
        assert!(!grey(plot.to_svg()) && !grey(plot.to_svg_by_validity(|_, point| point < 5)));
        assert!(grey(plot.to_svg_by_validity(|curve, point| curve == 0 && point > 0)));
        // A gap in the middle is not bridged in colour: two stretches of it, of two points each.
        let svg = plot.to_svg_by_validity(|_, point| point != 2);
        let lines = |colour: &str| -> Vec<usize> {
            let drawn = svg.lines().filter(|line| line.contains("<polyline") && line.contains(colour));
            drawn.filter_map(|line| Some(line.split("points=\"").nth(1)?.matches(',').count())).collect()
        };
        assert_eq!((lines("#0072B2"), lines("#BEBEBE")), (vec![2, 2], vec![5]), "{svg}");
        assert_eq!(svg.matches("not valid</title>").count(), 1, "{svg}");
    }

    #[test]
    fn gaps_interrupt_and_names_are_escaped() {
        let plot = LinePlot {
            title: "a < b & c",
            x: Axis::logarithmic("Frequency [Hz]", 10.0..1000.0),
            y: Axis::linear("Level [dB]", 0.0..10.0),
            series: vec![Series {
                name: "one",
                points: vec![(0.0, 1.0), (20.0, 1.0), (30.0, 2.0), (40.0, f64::NAN), (50.0, 3.0), (60.0, 4.0)],
            }],
        };
        let axes = Sheet::default().axes("", [&plot.x, &plot.y], HEIGHT, EDGE);
        let pieces: Vec<usize> = axes.pieces(&plot.series[0].points).iter().map(Vec::len).collect();
        assert_eq!(pieces, [2, 2]);
        let svg = plot.to_svg();
        assert!(
            svg.contains("a &lt; b &amp; c") && svg.contains(">one</text>") && svg.trim_end().ends_with("</svg>"),
            "{svg}"
        );
    }
}
