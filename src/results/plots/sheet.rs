//! A white sheet on which lines, marks and texts are written as SVG, in shown pixels from its upper left corner.
//!
//! Each element is a line of the file, and later ones lie over earlier ones.

use std::fmt::Write as _;

use super::colour::{Colour, INK};

/// Width of a sheet \[px\].
pub(super) const WIDTH: f64 = 480.0;
/// Line spacing over the size of the text.
const LINE: f64 = 1.25;

pub(super) fn line_height(size: f64) -> f64 {
    LINE * size
}

/// Position from the left and from the top.
pub(super) type Point = (f64, f64);

/// Size of a mark.
pub(super) const MARK: f64 = 8.0;

/// Position of a text relative to its point.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    /// Centred below.
    Below,
    /// Vertically centred, to the left.
    Left,
    /// Vertically centred, to the right.
    Right,
    /// Centred above.
    Above,
    /// Centred on the point, turned by 90 degrees anticlockwise.
    Upwards,
}

/// Form of a mark.
#[derive(Clone, Copy)]
pub(super) enum Form {
    Circle,
    Square,
    Triangle,
    /// A square on its corner.
    Diamond,
    /// A triangle on its tip.
    Tip,
    /// A star of five rays.
    Star,
}

impl Form {
    /// Forms of curves, which repeat after five.
    pub(super) fn of_curve(index: usize) -> Self {
        [Self::Circle, Self::Square, Self::Triangle, Self::Diamond, Self::Tip][index % 5]
    }

    /// Corners in units of the half size, clockwise; empty for a circle.
    fn corners(self) -> Vec<Point> {
        // Number, radii of every first and second one, and angle of the first from above [degrees].
        let (count, radii, first) = match self {
            Self::Circle => (0, [1.0; 2], 0.0),
            Self::Square => (4, [1.27; 2], 45.0),
            Self::Triangle => (3, [1.25; 2], 0.0),
            Self::Diamond => (4, [1.2; 2], 0.0),
            Self::Tip => (3, [1.25; 2], 180.0),
            Self::Star => (10, [1.0, 0.45], 0.0),
        };
        let corner = |index: u8| {
            let (sin, cos) = (first + 360.0 * f64::from(index) / f64::from(count)).to_radians().sin_cos();
            let radius = radii[usize::from(index % 2)];
            (radius * sin, -radius * cos)
        };
        (0..count).map(corner).collect()
    }
}

/// A rectangle on the sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Frame {
    pub(super) fn around((x, y): Point, width: f64, height: f64) -> Self {
        Self { left: x - 0.5 * width, top: y - 0.5 * height, width, height }
    }

    /// Horizontal position of a part of the width.
    pub(super) fn across(&self, part: f64) -> f64 {
        self.left + part * self.width
    }

    /// Vertical position of a part of the height from the bottom.
    pub(super) fn up(&self, part: f64) -> f64 {
        self.top + (1.0 - part) * self.height
    }

    /// The part between two parts of the width.
    pub(super) fn strip(&self, [from, to]: [f64; 2]) -> Self {
        Self { left: self.across(from), width: (to - from) * self.width, ..*self }
    }
}

/// A picture so far.
#[derive(Default)]
pub(super) struct Sheet {
    body: String,
    /// Rectangles that show their values under a pointer; they lie over everything.
    values: String,
    /// Lower end of what is on the sheet.
    pub bottom: f64,
    /// Least distance of a frame from the left, by which frames beneath each other are aligned.
    pub left: f64,
}

impl Sheet {
    /// The picture as SVG.
    pub(super) fn into_svg(self) -> String {
        let Self { body, values, bottom, .. } = self;
        let height = bottom.ceil();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" \
             viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n{body}{values}</svg>\n"
        )
    }

    /// Writes an element. Writing to a string does not fail.
    pub(super) fn put(&mut self, element: std::fmt::Arguments<'_>) {
        let _ = writeln!(self.body, "{element}");
    }

    pub(super) fn line(&mut self, points: &[Point], colour: Colour, width: f64) {
        let points = listed(points);
        self.put(format_args!(r#"<polyline fill="none" stroke="{colour}" stroke-width="{width}" points="{points}"/>"#));
    }

    pub(super) fn dashes(&mut self, ends: [Point; 2], colour: Colour) {
        let ends = listed(&ends);
        self.put(format_args!(
            r#"<polyline stroke="{colour}" stroke-width="1.5" stroke-dasharray="7 5" points="{ends}"/>"#
        ));
    }

    /// Fills a polygon; what lies beneath shines through.
    pub(super) fn band(&mut self, corners: &[Point], colour: Colour) {
        let corners = listed(corners);
        self.put(format_args!(r#"<polygon fill="{colour}" fill-opacity="0.8" points="{corners}"/>"#));
    }

    pub(super) fn fill(&mut self, frame: Frame, colour: Colour) {
        self.put(format_args!(r#"<rect {} fill="{colour}"/>"#, place(frame)));
    }

    /// Draws the outline of a rectangle.
    pub(super) fn outline(&mut self, frame: Frame) {
        self.put(format_args!(r#"<rect {} fill="none" stroke="{INK}"/>"#, place(frame)));
    }

    pub(super) fn circle(&mut self, (x, y): Point, radius: f64, colour: Colour) {
        let [x, y, radius] = [x, y, radius].map(rounded);
        self.put(format_args!(r#"<circle cx="{x}" cy="{y}" r="{radius}" fill="none" stroke="{colour}"/>"#));
    }

    /// Draws a mark of a size across, filled with `inside`.
    pub(super) fn mark(&mut self, (x, y): Point, form: Form, size: f64, colour: Colour, inside: Colour) {
        let reach = 0.5 * size;
        let paint = format!(r#"fill="{inside}" stroke="{colour}" stroke-width="1.5""#);
        if let Form::Circle = form {
            let [x, y] = [x, y].map(rounded);
            self.put(format_args!(r#"<circle {paint} cx="{x}" cy="{y}" r="{reach}"/>"#));
        } else {
            let corners: Vec<Point> = form.corners().iter().map(|at| (x + reach * at.0, y + reach * at.1)).collect();
            self.put(format_args!(r#"<polygon {paint} points="{}"/>"#, listed(&corners)));
        }
    }

    /// Adds the text that a pointer shows over a rectangle.
    pub(super) fn value(&mut self, frame: Frame, text: &str) {
        let title = title(text);
        self.values += &format!("<rect {} fill=\"none\" pointer-events=\"all\">{title}</rect>\n", place(frame));
    }

    /// Writes one line of text.
    pub(super) fn text(&mut self, text: &str, (x, y): Point, anchor: Anchor, size: f64) {
        let [x, y] = [x, y].map(rounded);
        let (side, shift) = match anchor {
            Anchor::Below => ("middle", "0.76em"),
            Anchor::Above => ("middle", "-0.5ex"),
            Anchor::Left => ("end", "0.5ex"),
            Anchor::Right => ("start", "0.5ex"),
            Anchor::Upwards => ("middle", "0.5ex"),
        };
        let turn =
            if let Anchor::Upwards = anchor { format!(r#" transform="rotate(270 {x} {y})""#) } else { String::new() };
        let text = escaped(text);
        self.put(format_args!(
            "<text x=\"{x}\" y=\"{y}\" dy=\"{shift}\" text-anchor=\"{side}\" font-size=\"{size}\" \
             fill=\"{INK}\"{turn}>{text}</text>"
        ));
    }

    /// Writes lines of text beneath each other.
    pub(super) fn texts(&mut self, lines: &[String], (x, y): Point, anchor: Anchor, size: f64) {
        for (row, line) in lines.iter().enumerate() {
            self.text(line, (x, y + row as f64 * line_height(size)), anchor, size);
        }
    }
}

/// SVG title, which viewers show under the pointer.
pub(super) fn title(text: &str) -> String {
    format!("<title>{}</title>", escaped(text))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A coordinate to a tenth of a pixel, which is finer than screens and prints show.
fn rounded(coordinate: f64) -> f64 {
    (10.0 * coordinate).round() / 10.0
}

/// Position and size as attributes.
fn place(frame: Frame) -> String {
    let [left, right] = [0.0, 1.0].map(|part| rounded(frame.across(part)));
    let [top, bottom] = [1.0, 0.0].map(|part| rounded(frame.up(part)));
    format!(r#"x="{left}" y="{top}" width="{}" height="{}""#, rounded(right - left), rounded(bottom - top))
}

fn listed(points: &[Point]) -> String {
    let points: Vec<String> = points.iter().map(|&(x, y)| format!("{},{}", rounded(x), rounded(y))).collect();
    points.join(" ")
}
