//! Titles, axes and legend, on a sheet whose text stays legible on a telephone.
//!
//! All sheets have one width. A page of 390 px shows it at three quarters, its smallest text at 10 px; a wide page
//! shows two beside each other at their full size. So titles are broken into lines, and the legend is below. Lengths
//! are in shown pixels.

use super::axis::Axis;
use super::colour::{Colour, FAINT_GRID, GRID, INK};
use super::sheet::{Anchor, Form, Frame, MARK, Point, Sheet, WIDTH, line_height};

/// Text sizes.
pub(super) const TITLE: f64 = 16.0;
pub(super) const TEXT: f64 = 15.0;
pub(super) const TICK_LABEL: f64 = 14.0;
/// Space at the edges of the sheet.
pub(super) const EDGE: f64 = 12.0;
/// Distance of tick labels from the frame, and of an axis' title from them.
const TICK: f64 = 9.0;
/// Width of a letter over the size of the text, somewhat more than the mean of most fonts.
const LETTER: f64 = 0.56;
/// Length of a line or mark in the legend, without and with its distance from the name.
const KEY: f64 = 22.0;
const KEY_ROOM: f64 = 30.0;

/// A frame with the axes that position values in it.
#[derive(Clone, Copy)]
pub(super) struct Axes<'a> {
    pub frame: Frame,
    pub x: &'a Axis,
    pub y: &'a Axis,
}

impl Axes<'_> {
    /// Position of a point, outside the frame for values beyond the axes; NaN where an axis has none.
    pub(super) fn at(&self, (x, y): (f64, f64)) -> Point {
        (self.frame.across(self.x.place(x)), self.frame.up(self.y.place(y)))
    }

    /// Position of a point, at the frame's edge for values beyond the axes.
    pub(super) fn within(&self, (x, y): (f64, f64)) -> Point {
        (self.frame.across(self.x.place(x).clamp(0.0, 1.0)), self.frame.up(self.y.place(y).clamp(0.0, 1.0)))
    }
}

/// Sign before a name in the legend.
pub(super) enum Key {
    Line,
    /// A line with a mark that is filled with a colour.
    Mark(Form, Colour),
    /// A range.
    Band,
}

impl Sheet {
    /// Draws title, grid, ticks and titles of axes of a height below all that is on the sheet, with some room on their
    /// right. The outline is drawn last, by [`Sheet::outline`], so that nothing lies over it.
    pub(super) fn axes<'a>(&mut self, title: &str, [x, y]: [&'a Axis; 2], height: f64, right: f64) -> Axes<'a> {
        let title = lines(title, WIDTH - 2.0 * EDGE, TITLE);
        self.texts(&title, (0.5 * WIDTH, self.bottom + 0.5 * EDGE), Anchor::Below, TITLE);
        let (left, top) = (width_beside(y, height).max(self.left), self.bottom + EDGE + stacked(&title, TITLE));
        let frame = Frame { left, top, width: WIDTH - right - left, height };
        let ([left, right], [low, high]) =
            ([0.0, 1.0].map(|part| frame.across(part)), [0.0, 1.0].map(|part| frame.up(part)));

        for (axis, upright) in [(x, true), (y, false)] {
            let minor = axis.minor_ticks().map(|place| (place, FAINT_GRID, 3.0));
            for (place, colour, tick) in minor.chain(axis.ticks().map(|(place, _)| (place, GRID, 5.0))) {
                let (at, up) = (frame.across(place), frame.up(place));
                let ends = if upright { [(at, high), (at, low)] } else { [(left, up), (right, up)] };
                self.line(&ends, colour, 1.0);
                if upright {
                    self.line(&[(at, low), (at, low + tick)], INK, 1.0);
                }
            }
        }
        let labels = labels_below(x, frame.width);
        for (place, label) in &labels {
            self.texts(label, (frame.across(*place), low + TICK), Anchor::Below, TICK_LABEL);
        }
        let labels = labels.iter().map(|(_, label)| stacked(label, TICK_LABEL)).fold(0.0, f64::max);
        let title = lines(&x.title, frame.width + 2.0 * EDGE, TEXT);
        self.texts(&title, (frame.across(0.5), low + TICK + labels + 2.0), Anchor::Below, TEXT);
        self.bottom = low + TICK + labels + stacked(&title, TEXT) + EDGE;
        self.ticks_beside(frame, y, -1.0);
        Axes { frame, x, y }
    }

    /// Draws the ticks of an axis on the left (`side` -1) or right (1) of a frame, and its title beyond their labels.
    pub(super) fn ticks_beside(&mut self, frame: Frame, axis: &Axis, side: f64) {
        let (x, anchor) = if side < 0.0 { (frame.left, Anchor::Left) } else { (frame.across(1.0), Anchor::Right) };
        for (place, _) in axis.ticks() {
            let at = frame.up(place);
            self.line(&[(x, at), (x + 5.0 * side, at)], INK, 1.0);
        }
        for (place, label) in apart(axis, |_| TICK_LABEL / frame.height) {
            self.text(label, (x + TICK * side, frame.up(place)), anchor, TICK_LABEL);
        }
        // Rotated upwards, the first line is the leftmost.
        let title = title_beside(axis, frame.height);
        let first = if side < 0.0 { title.len() as f64 - 1.0 } else { 0.0 };
        for (row, line) in title.iter().enumerate() {
            let outwards = 0.5 + first + side * row as f64;
            let away = labels_beside(axis) + 0.5 * TICK + outwards * line_height(TEXT);
            self.text(line, (x + side * away, frame.up(0.5)), Anchor::Upwards, TEXT);
        }
    }

    /// Draws a legend below all that is on the sheet, several names in a row if there is room. Entries without a name
    /// are left out.
    pub(super) fn legend<'a>(&mut self, entries: impl IntoIterator<Item = (&'a str, Colour, Key)>) {
        let (mut x, mut below) = (EDGE, self.bottom);
        for (name, colour, key) in entries.into_iter().filter(|(name, ..)| !name.is_empty()) {
            let name = lines(name, WIDTH - 2.0 * EDGE - KEY_ROOM, TEXT);
            let width = KEY_ROOM + name.iter().map(|line| width_of(line, TEXT)).fold(0.0, f64::max);
            if x > EDGE && x + width > WIDTH - EDGE {
                (x, self.bottom) = (EDGE, below);
            }
            let y = self.bottom + 0.5 * line_height(TEXT);
            let ends = [(x, y), (x + KEY, y)];
            match key {
                Key::Line => self.line(&ends, colour, 2.5),
                Key::Band => self.fill(Frame { left: x, top: y - 5.0, width: KEY, height: 10.0 }, colour),
                Key::Mark(form, inside) => {
                    self.line(&ends, colour, 1.5);
                    self.mark((x + 0.5 * KEY, y), form, MARK, colour, inside);
                }
            }
            self.texts(&name, (x + KEY_ROOM, y), Anchor::Right, TEXT);
            below = below.max(self.bottom + stacked(&name, TEXT));
            x += width + EDGE;
        }
        self.bottom = if below > self.bottom { below + 0.5 * EDGE } else { below };
    }
}

/// Height of lines of text beneath each other.
pub(super) fn stacked(lines: &[String], size: f64) -> f64 {
    lines.len() as f64 * line_height(size)
}

/// Estimated width of a text.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    LETTER * size * text.chars().count() as f64
}

/// Breaks a text of a size into lines no wider than `width`: between words, and longer words within.
pub(super) fn lines(text: &str, width: f64, size: f64) -> Vec<String> {
    let most = (width / (LETTER * size)).max(1.0) as usize;
    let (mut all, mut line) = (Vec::new(), String::new());
    for word in text.split_inclusive([' ', '-', '_', '/']) {
        if !line.is_empty() && line.chars().count() + word.trim_end().chars().count() > most {
            all.push(std::mem::take(&mut line));
        }
        line.push_str(word);
        while line.trim_end().chars().count() > most {
            let rest = line.split_off(line.char_indices().nth(most).map_or(line.len(), |(place, _)| place));
            all.push(std::mem::replace(&mut line, rest));
        }
    }
    all.push(line);
    all.iter().map(|line| line.trim().to_owned()).filter(|line| !line.is_empty()).collect()
}

/// Distance from a frame to the end of an axis' tick labels beside it.
fn labels_beside(axis: &Axis) -> f64 {
    TICK + axis.ticks().map(|(_, label)| width_of(label, TICK_LABEL)).fold(0.0, f64::max)
}

/// Lines of the title of an axis beside a frame of a height.
fn title_beside(axis: &Axis, height: f64) -> Vec<String> {
    lines(&axis.title, height + 3.0 * EDGE, TEXT)
}

/// Width that an axis takes between a frame of a height and the sheet's edge.
pub(super) fn width_beside(axis: &Axis, height: f64) -> f64 {
    labels_beside(axis) + TICK + stacked(&title_beside(axis, height), TEXT) + 0.5 * EDGE
}

/// Labels below a frame of a width, with their positions: words in lines, and as many numbers as do not touch.
fn labels_below(axis: &Axis, width: f64) -> Vec<(f64, Vec<String>)> {
    if axis.is_of_words() {
        let slot = width / axis.ticks().count().max(1) as f64 - 4.0;
        return axis.ticks().map(|(place, label)| (place, lines(label, slot, TICK_LABEL))).collect();
    }
    let labels = apart(axis, |label| width_of(label, TICK_LABEL) / width);
    labels.map(|(place, label)| (place, vec![label.to_owned()])).collect()
}

/// Labels that do not touch each other, with their positions; `size` is the part of the axis that one takes.
fn apart(axis: &Axis, size: impl Fn(&str) -> f64) -> impl Iterator<Item = (f64, &str)> {
    let mut free = f64::NEG_INFINITY;
    axis.ticks().filter(move |(place, label)| {
        let half = 0.5 * size(label);
        let fits = place - half > free;
        free = if fits { place + half } else { free };
        fits
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_broken_between_words_and_long_words_within() {
        let width = width_of("1234567890", 10.0);
        assert_eq!(lines("a short one and more", width, 10.0), ["a short", "one and", "more"]);
        assert_eq!(lines("scenes/roads/smooth.toml", width, 10.0), ["scenes/", "roads/", "smooth.tom", "l"]);
        assert_eq!(lines("chip-seal", width, 10.0), ["chip-seal"]);
        assert!(lines("", width, 10.0).is_empty());
    }

    #[test]
    fn text_stays_on_the_sheet_and_is_legible_on_a_telephone() {
        let long = "Contact force, third octaves: a tyre with a long name on a road with an even longer one";
        let x = Axis::of_words("numerics.preset", &["scenes/roads/smooth.toml", "standard", "reference"]);
        let y = Axis::linear("Growth of the force level [dB per decade of speed]", -0.001..0.002);
        let mut sheet = Sheet::default();
        let frame = sheet.axes(long, [&x, &y], 200.0, EDGE).frame;
        assert!(frame.top >= 2.0 * line_height(TITLE), "two lines of title");
        assert!(frame.left >= width_beside(&y, 200.0) && frame.across(1.0) <= WIDTH);
        let below = sheet.bottom;
        assert!(below >= frame.up(0.0) + 3.0 * line_height(TICK_LABEL) + line_height(TEXT), "words in lines, title");
        sheet.legend(["one", "two", long, "", "three"].map(|name| (name, INK, Key::Line)));
        let (bottom, svg) = (sheet.bottom, sheet.into_svg());
        let number = |line: &str, name: &str| -> f64 {
            line.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
        };
        let names: Vec<(f64, f64, &str)> = svg
            .lines()
            .filter(|line| line.starts_with("<text") && line.contains("\"start\""))
            .map(|line| (number(line, "x"), number(line, "y"), line.split(['<', '>']).nth(2).unwrap()))
            .collect();
        let row = |first: &str| names.iter().find(|(.., name)| name.starts_with(first)).unwrap().1;
        assert!(
            (row("one") - row("two")).abs() < 1e-9 && row("two") < row("Contact") && row("Contact") < row("three"),
            "{names:?}"
        );
        assert!(below < row("one") && row("three") < bottom, "{names:?}");
        for (x, _, name) in names {
            assert!(x + width_of(name, TEXT) <= WIDTH, "{name}");
        }
        // A page of 390 px has 358 px for a picture.
        assert!(
            svg.lines()
                .filter(|line| line.starts_with("<text"))
                .all(|line| number(line, "font-size") * 358.0 / WIDTH >= 10.0)
        );
    }
}
