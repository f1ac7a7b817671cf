//! Work-precision diagrams: curves of single knobs, a front and marked settings, over logarithmic axes, in
//! panels that share the error's axis and a legend.

use super::axis::Axis;
use super::colour::{self, GOLD, GREY, INK, WHITE};
use super::layout::{Axes, EDGE, Key, TICK_LABEL, width_of};
use super::sheet::{Anchor, Form, Frame, MARK, Point, Sheet, line_height};

/// Height of a panel's frame in shown pixels.
const HEIGHT: f64 = 360.0;

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
    pub uncertainty: f64,
    /// Panels, from the top.
    pub panels: Vec<WorkPrecisionPanel<'a>>,
}

impl WorkPrecisionPlot<'_> {
    /// The picture as SVG.
    pub(crate) fn to_svg(&self) -> String {
        let mut sheet = Sheet::default();
        for (number, panel) in self.panels.iter().enumerate() {
            let title = if number == 0 { self.title } else { "" };
            let axes = sheet.axes(title, [&panel.cost, &self.error], HEIGHT, EDGE);
            self.panel(&mut sheet, panel, &axes);
        }
        let key = |index| Key::Mark(Form::of_curve(index), WHITE);
        let knobs = self.knobs.iter().enumerate().map(|(index, name)| (*name, colour::line(index), key(index)));
        sheet.legend(knobs.chain([("front, by work", INK, Key::Line), ("marked", INK, Key::Mark(Form::Star, GOLD))]));
        sheet.into_svg()
    }

    fn panel(&self, sheet: &mut Sheet, panel: &WorkPrecisionPanel<'_>, axes: &Axes<'_>) {
        let frame = axes.frame;
        // An error of 0 has no position on a logarithmic axis.
        let place = |&(cost, error): &(f64, f64)| axes.within((cost, error.max(self.error.range.start)));
        let places = |points: &[(f64, f64)]| points.iter().map(place).collect::<Vec<Point>>();
        let uncertainty = self.error.place(self.uncertainty);
        if (0.0..=1.0).contains(&uncertainty) {
            let up = frame.up(uncertainty);
            sheet.dashes([(frame.left, up), (frame.across(1.0), up)], GREY);
            let at = (frame.left + 6.0, up - 0.5 * TICK_LABEL);
            sheet.text("uncertainty of the reference", at, Anchor::Right, TICK_LABEL);
        }
        let mut taken = Vec::new();
        for (index, curve) in panel.knobs.iter().enumerate() {
            let places = places(curve);
            sheet.line(&places, colour::line(index), 1.25);
            for at in places {
                sheet.mark(at, Form::of_curve(index), MARK, colour::line(index), WHITE);
                taken.push(Frame::around(at, 9.0, 9.0));
            }
        }
        sheet.line(&places(&panel.front), INK, 2.25);
        for (_, point) in &panel.marks {
            sheet.mark(place(point), Form::Star, 2.0 * MARK, INK, GOLD);
            taken.push(Frame::around(place(point), 22.0, 20.0));
        }
        for (name, point) in &panel.marks {
            let (at, anchor, area) = beside(name, place(point), frame, &taken);
            taken.push(area);
            sheet.text(name, at, anchor, TICK_LABEL);
        }
        sheet.outline(frame);
    }
}

impl Frame {
    /// Area of the overlap.
    fn shared(&self, other: &Self) -> f64 {
        let width = self.across(1.0).min(other.across(1.0)) - self.left.max(other.left);
        let height = self.up(0.0).min(other.up(0.0)) - self.top.max(other.top);
        width.max(0.0) * height.max(0.0)
    }
}

/// Position at which a mark's name hides least: right of it, left, above, below, or further away in these directions.
fn beside(name: &str, (x, y): Point, frame: Frame, taken: &[Frame]) -> (Point, Anchor, Frame) {
    let (width, height) = (width_of(name, TICK_LABEL), line_height(TICK_LABEL));
    let mut best = (f64::INFINITY, ((x, y), Anchor::Above, Frame::around((x, y), width, height)));
    for gap in [11.0, 26.0, 44.0] {
        for (across, up, anchor) in [
            (1.0, 0.0, Anchor::Right),
            (-1.0, 0.0, Anchor::Left),
            (0.0, -1.0, Anchor::Above),
            (0.0, 1.0, Anchor::Below),
        ] {
            let middle = (x + across * (gap + 0.5 * width), y + up * (gap + 0.5 * height));
            let area = Frame::around(middle, width, height);
            let outside = if area.shared(&frame) < 0.999 * width * height { 1e9 } else { 0.0 };
            let hidden = taken.iter().map(|other| area.shared(other)).sum::<f64>() + outside;
            if hidden < best.0 {
                best = (hidden, ((x + across * gap, y + up * gap), anchor, area));
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_avoid_each_other_and_the_frame() {
        let frame = Frame { left: 0.0, top: 0.0, width: 500.0, height: 400.0 };
        let mut taken: Vec<Frame> = Vec::new();
        // Four settings in one point: four names that do not overlap.
        for name in ["draft", "standard", "reference", "the scene"] {
            let (_, _, area) = beside(name, (250.0, 200.0), frame, &taken);
            assert!(taken.iter().all(|other| area.shared(other) <= 0.0), "{name}: {area:?} {taken:?}");
            taken.push(area);
            let (_, _, area) = beside(name, (475.0, 200.0), frame, &[]);
            assert!(area.across(1.0) < frame.across(1.0), "{name}: {area:?}");
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
            uncertainty: 0.2,
            panels: vec![panel("Work"), panel("Time")],
        };
        let svg = plot.to_svg();
        for text in ["elements", "poles", "draft", "uncertainty of the reference", "Work", "Time"] {
            assert!(svg.contains(text), "{text}");
        }
    }
}
