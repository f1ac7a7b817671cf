//! Several curves over common axes, with a legend.

use std::ops::Range;

use super::axis::{Axis, four_digits};
use super::canvas::{Anchor, Form, Grid, MARK, PlotError, draw};
use super::colour;
use super::layout::{EDGE, Frame, Layout, Legend, WIDTH};

/// Curves with more than four times as many points are thinned to the extremes in each of so many columns, which does
/// not change the picture.
const COLUMNS: usize = 2000;

/// Most marks for curves that leave the picture; with more, none is drawn.
const MOST_BEYOND: usize = 12;
/// Width of a letter of a note in drawn units.
const NOTE_LETTER: i32 = 34;
/// Height of the frame in shown pixels.
const HEIGHT: i32 = 300;
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

/// A line plot.
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
    ///
    /// # Errors
    /// [`PlotError::Draw`].
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        self.to_svg_vouched(|_, _| true)
    }

    /// The same with points that are not valid, and the lines to them, in grey; `vouched(curve, point)` is true for
    /// valid points.
    ///
    /// # Errors
    /// [`PlotError::Draw`].
    pub(crate) fn to_svg_vouched(&self, vouched: impl Fn(usize, usize) -> bool) -> Result<String, PlotError> {
        self.drawn(None, vouched)
    }

    /// The picture as SVG with a range as a band beneath the curves: its name, and the place, lower and upper end of
    /// each of its points.
    ///
    /// # Errors
    /// [`PlotError::Draw`].
    pub(crate) fn to_svg_over(&self, name: &str, range: Band) -> Result<String, PlotError> {
        self.drawn(Some((name, range)), |_, _| true)
    }

    fn drawn(&self, range: Option<(&str, Band)>, vouched: impl Fn(usize, usize) -> bool) -> Result<String, PlotError> {
        let listed: Vec<(usize, &str)> =
            self.series.iter().map(|series| series.name).enumerate().filter(|(_, name)| !name.is_empty()).collect();
        let Layout { frame, bottom } = Layout::new(self.title, [&self.x, &self.y], [0, HEIGHT], EDGE);
        let names = listed.iter().map(|(_, name)| *name).chain(range.map(|(name, _)| name));
        let legend = Legend::below(bottom, names);
        let beneath = range.map_or_else(String::new, |(_, range)| self.band(&frame, range));
        draw("a line plot", (WIDTH, legend.bottom), &beneath, |sheet| {
            sheet.axes(self.title, &frame, &self.x, &self.y, Grid::Both);
            for (index, series) in self.series.iter().enumerate() {
                let known = |(point, &(x, y))| (x, if vouched(index, point) { y } else { f64::NAN });
                let points = series.points.iter().enumerate().map(known).collect();
                let known = Series { name: series.name, points };
                if !(0..series.points.len()).all(|point| vouched(index, point)) {
                    for stretch in self.stretches(series, &frame) {
                        sheet.line(stretch, colour::UNVOUCHED, 1.75);
                    }
                }
                for stretch in self.stretches(&known, &frame) {
                    sheet.line(stretch, colour::line(index), 1.75);
                }
            }
            for (index, at, value, above) in self.beyond(&frame) {
                let form = if above { Form::Triangle } else { Form::Tip };
                sheet.mark(at, form, MARK, colour::line(index), colour::line(index));
                // Beside the frame the note would lie on the labels of the other axis.
                let half = NOTE_LETTER * value.chars().count() as i32 / 2;
                let at = (at.0.clamp(frame.x.start + half, frame.x.end - half), at.1);
                sheet.note(&value, at, if above { Anchor::Below } else { Anchor::Above });
            }
            for (across, text) in self.values(&vouched) {
                sheet.value(frame.across(across.start)..frame.across(across.end), &frame.y, &text);
            }
            sheet.frame(&frame);
            for ((index, _), entry) in listed.iter().zip(&legend.entries) {
                sheet.legend_entry(entry, colour::line(*index), None);
            }
            if let Some(entry) = legend.entries.get(listed.len()) {
                sheet.legend_band(entry, colour::RANGE);
            }
        })
    }

    /// SVG of a range: a polygon along its lower ends and back along its upper ones.
    fn band(&self, frame: &Frame, range: Band) -> String {
        let at = |x: f64, y: f64| {
            let (across, up) = (self.x.place(x).clamp(0.0, 1.0), self.y.place(y).clamp(0.0, 1.0));
            format!("{},{}", frame.across(across), frame.up(up))
        };
        let lower = range.iter().map(|&(x, [low, _])| at(x, low));
        let corners: Vec<String> = lower.chain(range.iter().rev().map(|&(x, [_, high])| at(x, high))).collect();
        format!("<polygon points=\"{}\" fill=\"{}\"/>\n", corners.join(" "), colour::as_svg(colour::RANGE))
    }

    /// For each part of a curve that leaves the picture above or below: the curve's index, the point at the edge, the
    /// furthest value, and true for above. Empty if there are too many.
    fn beyond(&self, frame: &Frame) -> Vec<(usize, (i32, i32), String, bool)> {
        let mut all = Vec::new();
        for (index, series) in self.series.iter().enumerate() {
            let placed = series.points.iter().map(|&(x, y)| (self.x.place(x), self.y.place(y), y));
            let placed: Vec<_> = placed.filter(|&(x, y, _)| sound((x, y)) && (0.0..=1.0).contains(&x)).collect();
            let side = |y: f64| i8::from(y > 1.0) - i8::from(y < 0.0);
            for part in placed.chunk_by(|a, b| side(a.1) == side(b.1)).filter(|part| side(part[0].1) != 0) {
                let above = side(part[0].1) > 0;
                let further = |a: &&(f64, f64, f64), b: &&(f64, f64, f64)| a.1.total_cmp(&b.1);
                let furthest = if above { part.iter().max_by(further) } else { part.iter().min_by(further) };
                let Some(&(x, _, value)) = furthest else { continue };
                let at = (frame.across(x), if above { frame.y.start } else { frame.y.end });
                all.push((index, at, four_digits(value), above));
            }
        }
        // Noise that crosses the edge again and again would hide the picture.
        if all.len() > MOST_BEYOND { Vec::new() } else { all }
    }

    /// Texts with the values of the curves in each strip across the picture: of every curve the point nearest to the
    /// strip's middle.
    fn values(&self, vouched: impl Fn(usize, usize) -> bool) -> Vec<(Range<f64>, String)> {
        let mut strips = vec![vec![None::<(f64, usize)>; self.series.len()]; STRIPS];
        for (index, series) in self.series.iter().enumerate() {
            for (point, &(x, y)) in series.points.iter().enumerate() {
                let place = self.x.place(x);
                if !y.is_finite() || !(0.0..1.0).contains(&place) {
                    continue;
                }
                let strip = (place * STRIPS as f64) as usize;
                let off = (place * STRIPS as f64 - strip as f64 - 0.5).abs();
                let best = &mut strips[strip][index];
                if best.is_none_or(|(least, _)| off < least) {
                    *best = Some((off, point));
                }
            }
        }
        let text = |best: &[Option<(f64, usize)>]| -> Option<String> {
            let found: Vec<(usize, usize)> =
                best.iter().enumerate().filter_map(|(index, best)| Some((index, (*best)?.1))).collect();
            let &(index, point) = found.first()?;
            let mut text = format!("{}: {}", self.x.title(), four_digits(self.series[index].points[point].0));
            for (index, point) in found {
                let Series { name, points } = &self.series[index];
                let name = if name.is_empty() { self.y.title() } else { name };
                let doubt = if vouched(index, point) { "" } else { ", not vouched for" };
                text.push_str(&format!("\n{name}: {}{doubt}", four_digits(points[point].1)));
            }
            Some(text)
        };
        let part = |strip: usize| strip as f64 / STRIPS as f64;
        let told = |(strip, best): (usize, &Vec<_>)| Some((part(strip)..part(strip + 1), text(best)?));
        strips.iter().enumerate().filter_map(told).collect()
    }

    /// The curve in drawn units, in as many pieces as it has interruptions.
    fn stretches(&self, series: &Series<'_>, frame: &Frame) -> Vec<Vec<(i32, i32)>> {
        let placed = |&(x, y): &(f64, f64)| (self.x.place(x), self.y.place(y));
        series
            .points
            .chunk_by(|a, b| sound(placed(a)) && sound(placed(b)))
            .map(|stretch| thinned(stretch.iter().map(placed).filter(|&place| sound(place)).collect()))
            .flat_map(|stretch| cut(&stretch))
            .map(|stretch| stretch.into_iter().map(|(x, y)| (frame.across(x), frame.up(y))).collect())
            .collect()
    }
}

fn sound((x, y): (f64, f64)) -> bool {
    x.is_finite() && y.is_finite()
}

/// Parts of a curve inside the unit square; where it crosses an edge it gets a point there.
pub(super) fn cut(points: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut open: Vec<(f64, f64)> = Vec::new();
    for pair in points.windows(2) {
        let Some((from, to)) = clipped(pair[0], pair[1]) else {
            pieces.push(std::mem::take(&mut open));
            continue;
        };
        if open.last() != Some(&from) {
            pieces.push(std::mem::replace(&mut open, vec![from]));
        }
        open.push(to);
    }
    pieces.push(open);
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

/// Part of a segment inside the unit square (Liang and Barsky 1984).
fn clipped(a: (f64, f64), b: (f64, f64)) -> Option<((f64, f64), (f64, f64))> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (slope, room) in [(-dx, a.0), (dx, 1.0 - a.0), (-dy, a.1), (dy, 1.0 - a.1)] {
        if slope < 0.0 {
            enter = enter.max(room / slope);
        } else if slope > 0.0 {
            leave = leave.min(room / slope);
        } else if room < 0.0 {
            return None;
        }
    }
    // Unchanged ends are returned without arithmetic, so that neighbours join without rounding.
    let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
    let start = if enter > 0.0 { at(enter) } else { a };
    let end = if leave < 1.0 { at(leave) } else { b };
    (enter <= leave).then_some((start, end))
}

/// First, lowest, highest and last point of each column of the picture, in their order.
fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    if points.len() <= 4 * COLUMNS {
        return points;
    }
    let column = |point: &(f64, f64)| (point.0 * COLUMNS as f64).floor();
    let mut few = Vec::with_capacity(4 * COLUMNS);
    for chunk in points.chunk_by(|a, b| column(a).total_cmp(&column(b)).is_eq()) {
        let extreme = |sign: f64| (0..chunk.len()).max_by(|&i, &j| (sign * chunk[i].1).total_cmp(&(sign * chunk[j].1)));
        let mut kept = vec![0, extreme(-1.0).unwrap_or(0), extreme(1.0).unwrap_or(0), chunk.len() - 1];
        kept.sort_unstable();
        kept.dedup();
        few.extend(kept.into_iter().map(|index| chunk[index]));
    }
    few
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_cut_at_the_frame() {
        let inside = cut(&[(0.0, 0.5), (0.5, 1.5), (1.0, 0.5)]);
        assert_eq!(inside, vec![vec![(0.0, 0.5), (0.25, 1.0)], vec![(0.75, 1.0), (1.0, 0.5)]]);
        assert!(cut(&[(0.0, 2.0), (1.0, 2.0)]).is_empty());
        assert_eq!(cut(&[(-1.0, 0.5), (2.0, 0.5)]), vec![vec![(0.0, 0.5), (1.0, 0.5)]]);
    }

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
        let beyond = plot.beyond(&Frame::of(0..100, 0..50));
        let told: Vec<(&str, bool)> = beyond.iter().map(|(_, _, value, above)| (value.as_str(), *above)).collect();
        assert_eq!(told, [("9.000", true), ("−2.000", false)]);
        assert_eq!(beyond[0].1.1, 0);
        assert!(plot.to_svg().unwrap().contains("9.000"));
    }

    #[test]
    fn the_note_of_what_leaves_at_a_corner_stays_off_the_labels_beside_the_frame() {
        let plot = LinePlot {
            title: "t",
            x: Axis::linear("x", 0.0..1.0),
            y: Axis::linear("y", 0.0..1.0),
            series: vec![Series { name: "", points: vec![(0.0, -0.5), (0.5, 0.5), (1.0, 7.123)] }],
        };
        let svg = plot.to_svg().unwrap();
        let frame = Layout::new(plot.title, [&plot.x, &plot.y], [0, HEIGHT], EDGE).frame;
        let lines: Vec<&str> = svg.lines().collect();
        for note in ["−0.5000", "7.123"] {
            let place = lines.iter().rposition(|line| *line == note).unwrap();
            let at: i32 = lines[place - 1].split("x=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
            let half = 34 * note.chars().count() as i32 / 2;
            assert!(frame.x.start <= at - half && at + half <= frame.x.end, "{note} at {at}");
        }
    }

    #[test]
    fn a_range_is_a_band_beneath_the_curves_with_its_name() {
        let (x, y) = (Axis::linear("x", 0.0..2.0), Axis::linear("y", 0.0..1.0));
        let series = vec![Series { name: "computed", points: vec![(0.0, 0.5), (2.0, 0.6)] }];
        let plot = LinePlot { title: "t", x, y, series };
        let svg = plot.to_svg_over("published", &[(0.0, [0.2, 0.4]), (1.0, [0.3, 0.8]), (2.0, [0.3, 2.0])]).unwrap();
        let band = svg.lines().find(|line| line.starts_with("<polygon")).unwrap();
        assert_eq!(band.matches(',').count(), 6, "{band}");
        assert!(svg.find("<polygon") < svg.find("<polyline") && svg.contains("\npublished\n"), "{svg}");
    }

    #[test]
    fn what_is_not_vouched_for_is_grey() {
        let points = (0..5).map(|x| (f64::from(x), 0.5)).collect();
        let (x, y) = (Axis::linear("x", 0.0..4.0), Axis::linear("y", 0.0..1.0));
        let plot = LinePlot { title: "t", x, y, series: vec![Series { name: "", points }] };
        let grey = |svg: Result<String, PlotError>| svg.unwrap().contains("#BEBEBE");
        assert!(!grey(plot.to_svg()) && !grey(plot.to_svg_vouched(|_, point| point < 5)));
        assert!(grey(plot.to_svg_vouched(|curve, point| curve == 0 && point > 0)));
        // A gap in the middle is not bridged in colour: two stretches of it, of two points each.
        let svg = plot.to_svg_vouched(|_, point| point != 2).unwrap();
        let lines = |colour: &str| -> Vec<usize> {
            let drawn = svg.lines().filter(|line| line.contains("<polyline") && line.contains(colour));
            drawn.filter_map(|line| Some(line.split("points=\"").nth(1)?.matches(',').count())).collect()
        };
        assert_eq!((lines("#0072B2"), lines("#BEBEBE")), (vec![2, 2], vec![5]), "{svg}");
        assert_eq!(svg.matches("not vouched for</title>").count(), 1, "{svg}");
    }

    #[test]
    fn thinning_keeps_spikes() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|n| (f64::from(n) / 1e5, 0.5)).collect();
        points[54_321].1 = 0.9;
        points[12_345].1 = 0.1;
        let few = thinned(points.clone());
        assert!(few.len() <= 4 * COLUMNS);
        assert!(few.contains(&points[54_321]) && few.contains(&points[12_345]));
        assert_eq!((few.first(), few.last()), (points.first(), points.last()));
        assert!(few.windows(2).all(|pair| pair[0].0 <= pair[1].0));
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
        let frame = Frame::of(0..100, 0..100);
        let pieces: Vec<usize> = plot.stretches(&plot.series[0], &frame).iter().map(Vec::len).collect();
        assert_eq!(pieces, [2, 2]);
        let svg = plot.to_svg().unwrap();
        assert!(
            svg.contains("a &lt; b &amp; c") && svg.contains(">\none\n") && svg.trim_end().ends_with("</svg>"),
            "{svg}"
        );
    }
}
