//! Positions of a picture's parts: frame, titles and legend, on a sheet whose text stays legible on a telephone.
//!
//! All sheets have one width. A page of 390 px shows it at three quarters, its smallest text at 10 px; a wide page
//! shows two beside each other at their full size. So titles are broken into lines, and the legend is below.

use std::ops::Range;

use super::axis::Axis;

/// Drawn units per shown pixel.
pub(super) const FINE: i32 = 4;
/// Text sizes in shown pixels.
pub(super) const TITLE: i32 = 16;
pub(super) const TEXT: i32 = 15;
pub(super) const TICK_LABEL: i32 = 14;
/// Width of a sheet in shown pixels.
pub(super) const WIDTH: i32 = 480;
/// Space at the edges of the sheet, in shown pixels.
pub(super) const EDGE: i32 = 12;
/// Distance of tick labels from the frame, and of an axis' title from them, in shown pixels.
pub(super) const TICK: i32 = 9;
/// Line spacing over the size of the text.
const LINE: f64 = 1.25;
/// Width of a letter over the size of the text, somewhat more than the mean of most fonts.
const LETTER: f64 = 0.56;
/// Length of a line or mark in the legend, with its distance from the name, in shown pixels.
pub(super) const KEY: i32 = 30;

/// Line spacing for a size of text, in shown pixels.
pub(super) fn line_height(size: i32) -> i32 {
    (LINE * f64::from(size)) as i32
}

/// Estimated width of a text, in shown pixels.
pub(super) fn width_of(text: &str, size: i32) -> i32 {
    (LETTER * f64::from(size) * text.chars().count() as f64).ceil() as i32
}

/// Breaks a text of a size into lines no wider than `width` pixels: between words, and longer words within.
pub(super) fn lines(text: &str, width: i32, size: i32) -> Vec<String> {
    let most = (f64::from(width) / (LETTER * f64::from(size))).max(1.0) as usize;
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

/// Width that an axis' tick labels take beside a frame, in shown pixels.
pub(super) fn beside(axis: &Axis) -> i32 {
    TICK + axis.ticks().map(|(_, label)| width_of(label, TICK_LABEL)).max().unwrap_or(0)
}

/// Lines of the title of an axis beside a frame of a height.
pub(super) fn side_title(axis: &Axis, height: i32) -> Vec<String> {
    lines(axis.title(), height + 3 * EDGE, TEXT)
}

/// Width that an axis takes beside a frame of a height, title included, in shown pixels.
pub(super) fn side(axis: &Axis, height: i32) -> i32 {
    beside(axis) + TICK + side_title(axis, height).len() as i32 * line_height(TEXT)
}

/// Labels of an axis of words below a frame of a width: position, and lines.
pub(super) fn words_below(axis: &Axis, width: i32) -> Vec<(f64, Vec<String>)> {
    let slot = width / axis.ticks().count().max(1) as i32 - 4;
    axis.ticks().map(|(place, label)| (place, lines(label, slot, TICK_LABEL))).collect()
}

/// Height of the labels below a frame of a width, in shown pixels.
pub(super) fn labels_below(axis: &Axis, width: i32) -> i32 {
    let most = |words: Vec<(f64, Vec<String>)>| words.iter().map(|(_, lines)| lines.len()).max().unwrap_or(1) as i32;
    TICK + line_height(TICK_LABEL) * if axis.is_of_words() { most(words_below(axis, width)) } else { 1 }
}

/// A rectangle on the sheet in drawn units.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Frame {
    pub(super) x: Range<i32>,
    pub(super) y: Range<i32>,
}

impl Frame {
    /// From shown pixels.
    pub(super) fn of(x: Range<i32>, y: Range<i32>) -> Self {
        Self { x: x.start * FINE..x.end * FINE, y: y.start * FINE..y.end * FINE }
    }

    /// Width in shown pixels.
    pub(super) fn width(&self) -> i32 {
        (self.x.end - self.x.start) / FINE
    }

    /// Horizontal position of a part of the width, in drawn units.
    pub(super) fn across(&self, part: f64) -> i32 {
        self.x.start + (part * f64::from(self.x.end - self.x.start)).round() as i32
    }

    /// Vertical position of a part of the height from the bottom, in drawn units.
    pub(super) fn up(&self, part: f64) -> i32 {
        self.y.end - (part * f64::from(self.y.end - self.y.start)).round() as i32
    }
}

/// A frame on its sheet, with room for its titles and labels.
pub(super) struct Layout {
    /// Frame of the axes.
    pub frame: Frame,
    /// Lower end of everything that belongs to it, in shown pixels.
    pub bottom: i32,
}

impl Layout {
    /// Lays out a frame of a height below `top`, with `right` pixels of room on its right.
    pub(super) fn new(title: &str, [x, y]: [&Axis; 2], [top, height]: [i32; 2], right: i32) -> Self {
        let left = EDGE / 2 + side(y, height);
        let width = WIDTH - right - left;
        let title = lines(title, WIDTH - 2 * EDGE, TITLE).len() as i32 * line_height(TITLE);
        let above = top + EDGE + title;
        let x_title = lines(x.title(), width + 2 * EDGE, TEXT).len() as i32 * line_height(TEXT);
        let bottom = above + height + labels_below(x, width) + x_title + EDGE;
        Self { frame: Frame::of(left..left + width, above..above + height), bottom }
    }
}

/// Names below a picture, each beside its line or mark.
pub(super) struct Legend {
    /// Positions of the marks' left ends in shown pixels, and names in lines.
    pub entries: Vec<((i32, i32), Vec<String>)>,
    /// Lower end, in shown pixels.
    pub bottom: i32,
}

impl Legend {
    /// Lays names out below `top`, several in a row if there is room.
    pub(super) fn below<'a>(top: i32, names: impl IntoIterator<Item = &'a str>) -> Self {
        let (mut entries, mut x, mut y, mut rows) = (Vec::new(), EDGE, top, 0);
        for name in names {
            let name = lines(name, WIDTH - 2 * EDGE - KEY, TEXT);
            let width = KEY + name.iter().map(|line| width_of(line, TEXT)).max().unwrap_or(0);
            if x > EDGE && x + width > WIDTH - EDGE {
                (x, y, rows) = (EDGE, y + rows * line_height(TEXT), 0);
            }
            rows = rows.max(name.len() as i32);
            entries.push(((x, y + line_height(TEXT) / 2), name));
            x += width + EDGE;
        }
        let bottom = y + rows * line_height(TEXT) + if entries.is_empty() { 0 } else { EDGE / 2 };
        Self { entries, bottom }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_broken_between_words_and_long_words_within() {
        let width = width_of("1234567890", 10);
        assert_eq!(lines("a short one and more", width, 10), ["a short", "one and", "more"]);
        assert_eq!(lines("scenes/roads/smooth.toml", width, 10), ["scenes/", "roads/", "smooth.tom", "l"]);
        assert_eq!(lines("chip-seal", width, 10), ["chip-seal"]);
        assert!(lines("", width, 10).is_empty());
    }

    #[test]
    fn titles_labels_and_legend_stay_on_the_sheet_and_text_is_legible_on_a_telephone() {
        let long = "Contact force, third octaves: a tyre with a long name on a road with an even longer one";
        let x = Axis::of_words("numerics.preset", &["scenes/roads/smooth.toml", "standard", "reference"]);
        let y = Axis::linear("Growth of the force level [dB per decade of speed]", -0.001..0.002);
        let layout = Layout::new(long, [&x, &y], [0, 200], EDGE);
        assert!(layout.frame.y.start >= 4 * 2 * line_height(TITLE), "two lines of title");
        assert!(layout.frame.x.start >= 4 * side(&y, 200) && layout.frame.x.end <= 4 * WIDTH);
        let legend = Legend::below(layout.bottom, ["one", "two", long, "three"]);
        let row = |entry: usize| legend.entries[entry].0.1;
        assert!(row(0) == row(1) && row(1) < row(2) && row(2) < row(3), "{:?}", legend.entries);
        assert!(legend.bottom > row(3));
        for (at, name) in &legend.entries {
            assert!(name.iter().all(|line| at.0 + KEY + width_of(line, TEXT) <= WIDTH), "{name:?}");
        }
        // A page of 390 px has 358 px for a picture.
        assert!(f64::from(TICK_LABEL) * 358.0 / f64::from(WIDTH) >= 10.0);
    }
}
