//! Work-precision diagrams: curves of single knobs, points, a front and marked settings, over logarithmic axes, in
//! panels that share the error's axis and a legend.

use plotters::style::{RGBColor, WHITE};

use super::axis::Axis;
use super::canvas::{Anchor, Form, Grid, INK, MARK, PlotError, Sheet, draw};
use super::colour;
use super::layout::{EDGE, Frame, Layout, Legend, WIDTH};

const GREY: RGBColor = RGBColor(150, 150, 150);
const GOLD: RGBColor = RGBColor(255, 205, 40);

/// Height of a panel's frame in shown pixels.
const HEIGHT: i32 = 360;
/// Width of a letter and height of a note in drawn units.
const LETTER: i32 = 28;
const LINE: i32 = 60;

/// Errors over one kind of cost. Errors below the axis are drawn at its end.
#[derive(Clone, Debug)]
pub(crate) struct WorkPrecisionPanel<'a> {
    /// Axis of the cost.
    pub cost: Axis,
    /// Cost and error along one curve for each knob.
    pub knobs: Vec<Vec<(f64, f64)>>,
    /// Cost and error along the front, by rising cost.
    pub front: Vec<(f64, f64)>,
    /// Settings with a name; cost and error.
    pub marks: Vec<(&'a str, (f64, f64))>,
}

#[derive(Clone, Debug)]
pub(crate) struct WorkPrecisionPlot<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Axis of the error.
    pub error: Axis,
    /// Names of the knobs in the legend.
    pub knobs: Vec<&'a str>,
    /// Uncertainty of the reference: smaller errors cannot be distinguished from it.
    pub doubt: f64,
    /// Panels, from the top.
    pub panels: Vec<WorkPrecisionPanel<'a>>,
}

impl WorkPrecisionPlot<'_> {
    /// The picture as SVG.
    ///
    /// # Errors
    /// [`PlotError::Draw`].
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        let knobs = self.knobs.iter().enumerate();
        let knobs = knobs.map(|(index, name)| (*name, colour::line(index), Some((Form::of_curve(index), WHITE))));
        let others = [("front, by work", INK, None), ("marked", INK, Some((Form::Star, GOLD)))];
        let entries: Vec<_> = knobs.chain(others).collect();
        if self.panels.is_empty() {
            return Err(PlotError::Shape { picture: "work and precision", quantity: "panels", expected: 1, got: 0 });
        }
        let (mut frames, mut top) = (Vec::new(), 0);
        for (number, panel) in self.panels.iter().enumerate() {
            let Layout { frame, bottom } =
                Layout::new(self.title_of(number), [&panel.cost, &self.error], [top, HEIGHT], EDGE);
            frames.push(frame);
            top = bottom;
        }
        let legend = Legend::below(top, entries.iter().map(|(name, ..)| *name));
        draw("work and precision", (WIDTH, legend.bottom), "", |sheet| {
            for (number, (panel, frame)) in self.panels.iter().zip(&frames).enumerate() {
                sheet.axes(self.title_of(number), frame, &panel.cost, &self.error, Grid::Both);
                self.panel(sheet, panel, frame);
            }
            for (entry, (_, line, mark)) in legend.entries.iter().zip(entries) {
                sheet.legend_entry(entry, line, mark);
            }
        })
    }

    /// Title of a panel: only the first has one, for all.
    fn title_of(&self, panel: usize) -> &str {
        if panel == 0 { self.title } else { "" }
    }

    fn panel(&self, sheet: &mut Sheet<'_>, panel: &WorkPrecisionPanel<'_>, frame: &Frame) {
        let place = |&(cost, error): &(f64, f64)| {
            let up = self.error.place(error.max(self.error.range().start)).clamp(0.0, 1.0);
            (frame.across(panel.cost.place(cost).clamp(0.0, 1.0)), frame.up(up))
        };
        let doubt = self.error.place(self.doubt);
        if (0.0..=1.0).contains(&doubt) {
            sheet.dashes(frame, doubt, GREY);
            let at = (frame.x.start + 6 * LETTER / 7, frame.up(doubt) - LETTER / 4);
            sheet.note_left("doubt of the reference", at);
        }
        for (index, curve) in panel.knobs.iter().enumerate() {
            let places: Vec<(i32, i32)> = curve.iter().map(place).collect();
            sheet.line(places.clone(), colour::line(index), 1.25);
            for at in places {
                sheet.mark(at, Form::of_curve(index), MARK, colour::line(index), WHITE);
            }
        }
        sheet.line(panel.front.iter().map(place).collect(), INK, 2.25);
        let places: Vec<(i32, i32)> = panel.marks.iter().map(|(_, at)| place(at)).collect();
        for &at in &places {
            sheet.mark(at, Form::Star, 2.0 * MARK, INK, GOLD);
        }
        let mut taken: Vec<Area> = places.iter().map(|&(x, y)| Area::around(x, y, 45, 40)).collect();
        let points = panel.knobs.iter().flatten().map(place);
        taken.extend(points.map(|(x, y)| Area::around(x, y, 18, 18)));
        for ((name, _), at) in panel.marks.iter().zip(places) {
            let (at, anchor, area) = beside(name, at, frame, &taken);
            taken.push(area);
            sheet.note(name, at, anchor);
        }
        sheet.frame(frame);
    }
}

/// A rectangle in drawn units: left, right, top, bottom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Area(i32, i32, i32, i32);

impl Area {
    fn around(x: i32, y: i32, width: i32, height: i32) -> Self {
        Self(x - width, x + width, y - height, y + height)
    }

    /// Size of the overlap, in drawn units squared.
    fn shared(self, other: Self) -> i64 {
        let overlap = |a: (i32, i32), b: (i32, i32)| i64::from((a.1.min(b.1) - a.0.max(b.0)).max(0));
        overlap((self.0, self.1), (other.0, other.1)) * overlap((self.2, self.3), (other.2, other.3))
    }
}

/// Position at which a mark's name hides least: right of it, left, above, below, or further away in these directions.
fn beside(name: &str, (x, y): (i32, i32), frame: &Frame, taken: &[Area]) -> ((i32, i32), Anchor, Area) {
    let width = LETTER * name.chars().count() as i32;
    let mut best: Option<(i64, (i32, i32), Anchor, Area)> = None;
    for away in [0, 60, 130] {
        let gap = 44 + away;
        let places = [
            ((x + gap, y), Anchor::Right, Area(x + gap, x + gap + width, y - LINE / 2, y + LINE / 2)),
            ((x - gap, y), Anchor::Left, Area(x - gap - width, x - gap, y - LINE / 2, y + LINE / 2)),
            ((x, y - gap), Anchor::Above, Area(x - width / 2, x + width / 2, y - gap - LINE, y - gap)),
            ((x, y + gap), Anchor::Below, Area(x - width / 2, x + width / 2, y + gap, y + gap + LINE)),
        ];
        for (at, anchor, area) in places {
            let inside =
                area.0 > frame.x.start && area.1 < frame.x.end && area.2 > frame.y.start && area.3 < frame.y.end;
            let hidden = taken.iter().map(|&other| area.shared(other)).sum::<i64>() + if inside { 0 } else { 1 << 40 };
            if best.as_ref().is_none_or(|best| hidden < best.0) {
                best = Some((hidden, at, anchor, area));
            }
        }
    }
    let (_, at, anchor, area) = best.unwrap_or((0, (x, y), Anchor::Above, Area(x, x, y, y)));
    (at, anchor, area)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_avoid_each_other_and_the_frame() {
        let frame = Frame::of(0..500, 0..400);
        let mut taken = Vec::new();
        // Four settings in one point: four names that do not overlap.
        for name in ["draft", "standard", "reference", "the scene"] {
            let (_, _, area) = beside(name, (1000, 800), &frame, &taken);
            assert!(taken.iter().all(|&other| area.shared(other) == 0), "{name}: {area:?} {taken:?}");
            taken.push(area);
            let (_, _, area) = beside(name, (1900, 800), &frame, &[]);
            assert!(area.1 < frame.x.end, "{name}: {area:?}");
        }
    }

    #[test]
    fn a_picture_names_its_knobs_and_marks() {
        let panel = |title: &str| WorkPrecisionPanel {
            cost: Axis::logarithmic(title, 1.0..100.0),
            knobs: vec![vec![(2.0, 3.0), (20.0, 0.3)], vec![(5.0, 0.0)]],
            front: vec![(2.0, 3.0), (9.0, 0.5)],
            marks: vec![("draft", (9.0, 0.5))],
        };
        let plot = WorkPrecisionPlot {
            title: "t",
            error: Axis::logarithmic("Error [dB]", 0.1..10.0),
            knobs: vec!["elements", "poles"],
            doubt: 0.2,
            panels: vec![panel("Work"), panel("Time")],
        };
        let svg = plot.to_svg().unwrap();
        for text in ["elements", "poles", "draft", "doubt of the reference", "Work", "Time"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(WorkPrecisionPlot { panels: vec![], ..plot }.to_svg().is_err());
    }
}
