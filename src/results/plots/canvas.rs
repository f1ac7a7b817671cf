//! A white sheet with a frame, axes and labels, drawn with plotters into SVG.
//!
//! The SVG backend has integer coordinates: the sheet is drawn `FINE` times larger than it is shown, so lines are
//! smooth. Colour maps go beneath, as one path per colour (see `heat_map`): the backend would write a rectangle per
//! cell.

use std::fmt::Write as _;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use thiserror::Error;

use super::axis::Axis;
use super::layout::{
    EDGE, FINE, Frame, KEY, TEXT, TICK, TICK_LABEL, TITLE, WIDTH, beside, labels_below, line_height, lines, side_title,
    width_of, words_below,
};

/// The backend divides font sizes by this.
const BACKEND_FONT_SCALE: f64 = 1.24;

pub(super) const INK: RGBColor = RGBColor(30, 30, 30);
pub(super) const GRID: RGBColor = RGBColor(222, 222, 222);
const FAINT_GRID: RGBColor = RGBColor(240, 240, 240);

/// Error of drawing a picture.
#[derive(Debug, Error)]
pub enum PlotError {
    /// The drawing library failed.
    #[error("cannot draw {picture}: {message}")]
    Draw {
        /// Kind of picture.
        picture: &'static str,
        /// Message of the library (its error has a type per backend).
        message: String,
    },
    /// Data whose lengths do not fit each other.
    #[error("cannot draw {picture}: {got} values of {quantity} where {expected} are needed")]
    Shape {
        /// Kind of picture.
        picture: &'static str,
        /// Name of the data.
        quantity: &'static str,
        /// Length needed.
        expected: usize,
        /// Length given.
        got: usize,
    },
}

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
    /// Centred, turned by 90 degrees anticlockwise, above the point as seen along the text.
    Upwards,
}

/// Size of a mark in shown pixels.
pub(super) const MARK: f64 = 8.0;

/// Form of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// A disk.
    Circle,
    /// A square.
    Square,
    /// A triangle on its base.
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

    /// Corners in units of the half size, y upwards; empty for a circle.
    fn corners(self) -> Vec<(f64, f64)> {
        match self {
            Self::Circle => Vec::new(),
            Self::Square => vec![(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
            Self::Triangle => vec![(-1.1, -0.8), (1.1, -0.8), (0.0, 1.1)],
            Self::Diamond => vec![(-1.2, 0.0), (0.0, -1.2), (1.2, 0.0), (0.0, 1.2)],
            Self::Tip => vec![(-1.1, 0.8), (1.1, 0.8), (0.0, -1.1)],
            Self::Star => (0..10)
                .map(|corner| {
                    let (radius, angle) = (if corner % 2 == 0 { 1.0 } else { 0.45 }, f64::from(corner) * 36.0);
                    (radius * angle.to_radians().sin(), radius * angle.to_radians().cos())
                })
                .collect(),
        }
    }
}

/// Grid lines of a pair of axes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Grid {
    /// None, under a colour map that fills the frame.
    None,
    /// Horizontal lines only, for bars.
    Horizontal,
    /// Both ways.
    Both,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Drawing area of the pictures. An error of the backend is kept until the end; as it writes to memory, none is
/// expected.
pub(super) struct Sheet<'a> {
    area: Area<'a>,
    failure: Option<String>,
    /// SVG of rectangles that show their values under a pointer; they lie over everything.
    values: String,
}

/// Draws a sheet of `size` shown pixels; `beneath` is SVG that comes first.
pub(super) fn draw(
    picture: &'static str,
    size: (i32, i32),
    beneath: &str,
    content: impl FnOnce(&mut Sheet<'_>),
) -> Result<String, PlotError> {
    let mut body = String::new();
    let drawn_size = ((size.0 * FINE).unsigned_abs(), (size.1 * FINE).unsigned_abs());
    let (failure, values) = {
        let area = SVGBackend::with_string(&mut body, drawn_size).into_drawing_area();
        let mut sheet = Sheet { area, failure: None, values: String::new() };
        content(&mut sheet);
        if let Err(error) = sheet.area.present() {
            sheet.failure.get_or_insert(error.to_string());
        }
        (sheet.failure, sheet.values)
    };
    if let Some(message) = failure {
        return Err(PlotError::Draw { picture, message });
    }
    // The backend's own head gives drawn units as the size; ours shows them smaller and puts the background first.
    let inside = body.split_once('\n').map_or("", |(_, inside)| inside);
    let inside = inside.trim_end().trim_end_matches("</svg>");
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {} {}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n{beneath}{inside}{values}</svg>\n",
        size.0, size.1, drawn_size.0, drawn_size.1
    ))
}

impl Sheet<'_> {
    fn keep<T>(&mut self, result: Result<(), DrawingAreaErrorKind<T>>)
    where
        T: std::error::Error + Send + Sync,
    {
        if let Err(error) = result {
            self.failure.get_or_insert(error.to_string());
        }
    }

    /// Draws a line through points in drawn units, `width` in shown pixels.
    pub(super) fn line(&mut self, points: Vec<(i32, i32)>, colour: RGBColor, width: f64) {
        let style = ShapeStyle { color: colour.to_rgba(), filled: false, stroke_width: stroke(width) };
        let result = self.area.draw(&PathElement::new(points, style));
        self.keep(result);
    }

    pub(super) fn fill(&mut self, x: Range<i32>, y: Range<i32>, colour: RGBColor) {
        let result = self.area.draw(&Rectangle::new([(x.start, y.start), (x.end, y.end)], colour.filled()));
        self.keep(result);
    }

    /// Adds the text that a pointer shows over a rectangle.
    pub(super) fn value(&mut self, x: Range<i32>, y: &Range<i32>, text: &str) {
        // Writing to a string does not fail.
        let _ = writeln!(
            self.values,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" pointer-events=\"all\">{}</rect>",
            x.start,
            y.start,
            x.end - x.start,
            y.end - y.start,
            told(text)
        );
    }

    /// Draws a small text beside a point.
    pub(super) fn note(&mut self, text: &str, at: (i32, i32), anchor: Anchor) {
        self.sized_text(text, at, anchor, TICK_LABEL);
    }

    /// Draws a small text that begins at a point and stands on it.
    pub(super) fn note_left(&mut self, text: &str, at: (i32, i32)) {
        self.sized_text(text, (at.0, at.1 - TICK_LABEL * FINE / 2), Anchor::Right, TICK_LABEL);
    }

    /// Draws the lines of a heading in the middle of the sheet; `top` in shown pixels.
    pub(super) fn heading(&mut self, text: &[String], top: i32) {
        for (row, line) in text.iter().enumerate() {
            let y = top + row as i32 * line_height(TITLE);
            self.sized_text(line, (WIDTH * FINE / 2, y * FINE), Anchor::Below, TITLE);
        }
    }

    /// Draws a mark of a form, `size` in shown pixels across; filled with `inside`.
    pub(super) fn mark(&mut self, at: (i32, i32), form: Form, size: f64, colour: RGBColor, inside: RGBColor) {
        let reach = 0.5 * size * f64::from(FINE);
        let corners: Vec<(i32, i32)> = form
            .corners()
            .iter()
            .map(|&(x, y)| (at.0 + (reach * x).round() as i32, at.1 - (reach * y).round() as i32))
            .collect();
        let outline = ShapeStyle { color: colour.to_rgba(), filled: false, stroke_width: stroke(1.5) };
        if form == Form::Circle {
            let filled = self.area.draw(&Circle::new(at, reach.round() as i32, inside.filled()));
            self.keep(filled);
            let drawn = self.area.draw(&Circle::new(at, reach.round() as i32, outline));
            self.keep(drawn);
        } else {
            let filled = self.area.draw(&Polygon::new(corners.clone(), inside.filled()));
            self.keep(filled);
            let closed: Vec<(i32, i32)> = corners.iter().chain(corners.first()).copied().collect();
            self.line(closed, colour, 1.5);
        }
    }

    /// Draws a horizontal dashed line across a frame, at a part of its height.
    pub(super) fn dashes(&mut self, frame: &Frame, place: f64, colour: RGBColor) {
        let (at, dash) = (frame.up(place), 7 * FINE);
        let mut from = frame.x.start;
        while from < frame.x.end {
            self.line(vec![(from, at), ((from + dash).min(frame.x.end), at)], colour, 1.5);
            from += 2 * dash - 2 * FINE;
        }
    }

    /// Draws one line of text, `size` in shown pixels.
    fn sized_text(&mut self, text: &str, at: (i32, i32), anchor: Anchor, size: i32) {
        let font = FontDesc::new(FontFamily::SansSerif, f64::from(size * FINE) * BACKEND_FONT_SCALE, FontStyle::Normal);
        let (font, position) = match anchor {
            Anchor::Below => (font, Pos::new(HPos::Center, VPos::Top)),
            Anchor::Above => (font, Pos::new(HPos::Center, VPos::Bottom)),
            Anchor::Left => (font, Pos::new(HPos::Right, VPos::Center)),
            Anchor::Right => (font, Pos::new(HPos::Left, VPos::Center)),
            Anchor::Upwards => (font.transform(FontTransform::Rotate270), Pos::new(HPos::Center, VPos::Center)),
        };
        let style = TextStyle::from(font).pos(position).color(&INK);
        let result = self.area.draw(&Text::new(text.to_owned(), at, style));
        self.keep(result);
    }

    /// Draws the title over the frame, grid lines, ticks and axis titles; not the frame itself.
    pub(super) fn axes(&mut self, title: &str, frame: &Frame, x: &Axis, y: &Axis, grid: Grid) {
        if grid == Grid::Both {
            self.grid_lines(x, |place| {
                let at = frame.across(place);
                [(at, frame.y.start), (at, frame.y.end)]
            });
        }
        if grid != Grid::None {
            self.grid_lines(y, |place| {
                let at = frame.up(place);
                [(frame.x.start, at), (frame.x.end, at)]
            });
        }
        let title = lines(title, WIDTH - 2 * EDGE, TITLE);
        self.heading(&title, frame.y.start / FINE - EDGE / 2 - title.len() as i32 * line_height(TITLE));
        let width = (frame.x.end - frame.x.start) / FINE;
        for (row, line) in lines(x.title(), width + 2 * EDGE, TEXT).iter().enumerate() {
            let y = frame.y.end + (labels_below(x, width) + 2 + row as i32 * line_height(TEXT)) * FINE;
            self.sized_text(line, (frame.across(0.5), y), Anchor::Below, TEXT);
        }
        self.ticks_below(frame, x);
        self.ticks_beside(frame, y, frame.x.start, -1);
    }

    /// Draws the ticks below a frame, with as many of their labels as do not touch each other.
    fn ticks_below(&mut self, frame: &Frame, x: &Axis) {
        let below = frame.y.end + TICK * FINE;
        let mut free = i32::MIN;
        for (place, label) in x.ticks() {
            let at = frame.across(place);
            self.line(vec![(at, frame.y.end), (at, frame.y.end + 5 * FINE)], INK, 1.0);
            let half = width_of(label, TICK_LABEL) * FINE / 2;
            if !x.is_of_words() && at - half > free {
                self.sized_text(label, (at, below), Anchor::Below, TICK_LABEL);
                free = at + half;
            }
        }
        let words = if x.is_of_words() { words_below(x, (frame.x.end - frame.x.start) / FINE) } else { Vec::new() };
        for (place, lines) in words {
            for (row, line) in lines.iter().enumerate() {
                let y = below + row as i32 * line_height(TICK_LABEL) * FINE;
                self.sized_text(line, (frame.across(place), y), Anchor::Below, TICK_LABEL);
            }
        }
    }

    /// Draws an entry of a legend: a line and a name; with a mark, given by form and inside, the line is thinner.
    pub(super) fn legend_entry(
        &mut self,
        ((x, y), name): &((i32, i32), Vec<String>),
        colour: RGBColor,
        mark: Option<(Form, RGBColor)>,
    ) {
        let (x, y) = (x * FINE, y * FINE);
        self.line(vec![(x, y), (x + 22 * FINE, y)], colour, if mark.is_some() { 1.5 } else { 2.5 });
        if let Some((form, inside)) = mark {
            self.mark((x + 11 * FINE, y), form, MARK, colour, inside);
        }
        for (row, line) in name.iter().enumerate() {
            let y = y + row as i32 * line_height(TEXT) * FINE;
            self.sized_text(line, (x + KEY * FINE, y), Anchor::Right, TEXT);
        }
    }

    /// Draws an entry of a legend for a range.
    pub(super) fn legend_band(&mut self, entry: &((i32, i32), Vec<String>), colour: RGBColor) {
        self.legend_entry(entry, colour, None);
        let ((x, y), _) = *entry;
        self.fill(x * FINE..(x + 22) * FINE, (y - 5) * FINE..(y + 5) * FINE, colour);
    }

    /// Draws small ticks without labels below the frame.
    pub(super) fn small_ticks_below(&mut self, frame: &Frame, places: impl Iterator<Item = f64>) {
        for place in places {
            let at = frame.across(place);
            self.line(vec![(at, frame.y.end), (at, frame.y.end + 3 * FINE)], INK, 0.75);
        }
    }

    /// Draws the frame round the picture; this comes last, so that nothing lies over it.
    pub(super) fn frame(&mut self, frame: &Frame) {
        let (x, y) = (&frame.x, &frame.y);
        let corners = vec![(x.start, y.start), (x.end, y.start), (x.end, y.end), (x.start, y.end), (x.start, y.start)];
        self.line(corners, INK, 1.0);
    }

    /// Draws a colour bar in `frame` with its ticks and title on the right.
    pub(super) fn colour_bar(&mut self, frame: &Frame, axis: &Axis, colour: impl Fn(f64) -> RGBColor, levels: usize) {
        for level in 0..levels {
            let part = |count: f64| count / levels as f64;
            // Up to the top: the next level paints over it, and no seam shows between the two.
            self.fill(frame.x.clone(), frame.y.start..frame.up(part(level as f64)), colour(part(level as f64 + 0.5)));
        }
        self.ticks_beside(frame, axis, frame.x.end, 1);
        self.frame(frame);
    }

    /// Draws the ticks of an axis on the left (`side` -1) or right (1) of a frame, and its title beyond their labels.
    fn ticks_beside(&mut self, frame: &Frame, axis: &Axis, x: i32, side: i32) {
        for (place, label) in axis.ticks() {
            let at = frame.up(place);
            self.line(vec![(x, at), (x + side * 5 * FINE, at)], INK, 1.0);
            let anchor = if side < 0 { Anchor::Left } else { Anchor::Right };
            self.sized_text(label, (x + side * TICK * FINE, at), anchor, TICK_LABEL);
        }
        // Rotated upwards, the first line is the leftmost.
        let title = side_title(axis, (frame.y.end - frame.y.start) / FINE);
        for (row, line) in title.iter().enumerate() {
            let outwards = if side < 0 { title.len() - 1 - row } else { row } as i32;
            let away = beside(axis) + TICK / 2 + line_height(TEXT) / 2 + outwards * line_height(TEXT);
            self.sized_text(line, (x + side * away * FINE, frame.up(0.5)), Anchor::Upwards, TEXT);
        }
    }

    /// Draws grid lines at an axis' ticks; `ends` gives both ends of the line at a position.
    fn grid_lines(&mut self, axis: &Axis, ends: impl Fn(f64) -> [(i32, i32); 2]) {
        let minor = axis.minor_ticks().map(|place| (place, FAINT_GRID));
        for (place, colour) in minor.chain(axis.ticks().map(|(place, _)| (place, GRID))) {
            self.line(ends(place).to_vec(), colour, 1.0);
        }
    }
}

/// SVG title with an escaped text, which viewers show under the pointer.
pub(super) fn told(text: &str) -> String {
    let escaped = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    format!("<title>{escaped}</title>")
}

fn stroke(width: f64) -> u32 {
    (width * f64::from(FINE)).round().max(1.0) as u32
}
