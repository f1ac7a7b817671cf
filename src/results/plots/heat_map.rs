//! Colour maps: a field over two axes, with a colour bar.
//!
//! The SVG is small: at most [`MOST_COLUMNS`] x [`MOST_ROWS`] cells (larger fields are averaged), 64 colours, and for
//! each colour one path whose strokes are the runs of equal cells: some bytes per run instead of a rectangle per cell.

use std::fmt::Write as _;
use std::ops::Range;

use ndarray::{Array2, ArrayView2};
use plotters::style::RGBColor;

use super::axis::{Axis, extent, four_digits};
use super::canvas::{Grid, PlotError, Sheet, draw, told};
use super::colour::viridis;
use super::layout::{EDGE, FINE, Frame, Layout, WIDTH, side};
use super::lines::cut;

/// Most cells along x that are drawn.
pub(crate) const MOST_COLUMNS: usize = 400;
/// Most cells along y that are drawn.
pub(crate) const MOST_ROWS: usize = 300;
/// Width of the colour bar, its distance from the frame, and the smallest and largest height of both in shown pixels.
const BAR: i32 = 16;
const BAR_GAP: i32 = 14;
const LEAST_HEIGHT: i32 = 80;
const MOST_HEIGHT: i32 = 420;
/// Number of colours.
const LEVELS: usize = 64;
const NO_VALUE: RGBColor = RGBColor(200, 200, 200);
/// Colour of curves over a map: lighter than all but its very peaks.
const CURVE: RGBColor = RGBColor(255, 255, 255);

/// Assignment of colours to values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Colours {
    /// Viridis from the smallest value to the largest.
    Extent,
    /// Viridis between two given values.
    Between(Range<f64>),
}

/// A field to be drawn in colours. Cells without a value (NaN) are grey.
#[derive(Clone, Debug)]
pub(crate) struct HeatMap<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Horizontal axis; its range is that of all columns, outer edge to outer edge.
    pub x: Axis,
    /// Vertical axis, upwards; its range is that of all rows, outer edge to outer edge.
    pub y: Axis,
    /// Quantity of the colours, unit included.
    pub quantity: &'a str,
    /// Values: \[rows, columns\], row 0 at the bottom.
    pub values: ArrayView2<'a, f64>,
    /// Assignment of colours to the values.
    pub colours: Colours,
    /// Height of the frame over its width; `None`: a default.
    pub aspect: Option<f64>,
}

impl HeatMap<'_> {
    /// The picture as SVG.
    ///
    /// # Errors
    /// [`PlotError::Shape`] without cells, [`PlotError::Draw`].
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        self.to_svg_under(&[])
    }

    /// The picture as SVG with curves over it, given in the units of the axes and cut at the frame.
    ///
    /// # Errors
    /// As [`Self::to_svg`].
    pub(crate) fn to_svg_under(&self, curves: &[Vec<(f64, f64)>]) -> Result<String, PlotError> {
        let picture = "a colour map";
        if self.values.is_empty() {
            return Err(PlotError::Shape { picture, quantity: "the field", expected: 1, got: 0 });
        }
        let cells = averaged(self.values, MOST_ROWS, MOST_COLUMNS);
        let (low, high) = extent(cells.iter().copied());
        let range = match &self.colours {
            Colours::Extent => low..high,
            Colours::Between(range) => range.clone(),
        };
        let bar = Axis::linear(self.quantity, range);
        let aspect = self.aspect.unwrap_or(0.68);
        // The width beside the frame depends on its height, and the height on the frame's width: laid out twice.
        let laid_out = |height: i32| {
            let beside = BAR_GAP + BAR + side(&bar, height) + EDGE / 2;
            Layout::new(self.title, [&self.x, &self.y], [0, height], beside)
        };
        let width = f64::from(laid_out(MOST_HEIGHT).frame.width());
        let Layout { frame, bottom } = laid_out(((width * aspect) as i32).clamp(LEAST_HEIGHT, MOST_HEIGHT));
        let left = frame.x.end + BAR_GAP * FINE;
        let bar_frame = Frame { x: left..left + BAR * FINE, y: frame.y.clone() };
        let beneath = cells_as_paths(&cells, &frame, &bar);
        draw(picture, (WIDTH, bottom), &beneath, |sheet: &mut Sheet<'_>| {
            sheet.axes(self.title, &frame, &self.x, &self.y, Grid::None);
            for curve in curves {
                let placed: Vec<_> = curve.iter().map(|&(x, y)| (self.x.place(x), self.y.place(y))).collect();
                for piece in cut(&placed) {
                    let points = piece.into_iter().map(|(x, y)| (frame.across(x), frame.up(y))).collect();
                    sheet.line(points, CURVE, 0.8);
                }
            }
            sheet.frame(&frame);
            sheet.colour_bar(&bar_frame, &bar, viridis, LEVELS);
        })
    }
}

/// Averages blocks of cells until there are few enough; NaN cells do not count.
fn averaged(values: ArrayView2<'_, f64>, most_rows: usize, most_columns: usize) -> Array2<f64> {
    let (rows, columns) = values.dim();
    let (few_rows, few_columns) = (rows.min(most_rows), columns.min(most_columns));
    Array2::from_shape_fn((few_rows, few_columns), |(row, column)| {
        let (below, above) = (row * rows / few_rows, (row + 1) * rows / few_rows);
        let (left, right) = (column * columns / few_columns, (column + 1) * columns / few_columns);
        let band = values.slice_axis(ndarray::Axis(0), (below..above).into());
        let block = band.slice_axis(ndarray::Axis(1), (left..right).into());
        let (sum, count) = block.iter().filter(|v| v.is_finite()).fold((0.0, 0.0), |(sum, n), v| (sum + v, n + 1.0));
        if count > 0.0 { sum / count } else { f64::NAN }
    })
}

/// SVG of all cells: units of one cell, one path per colour, one stroke per run. Strokes are a tenth of a cell wider
/// and longer than their cells: viewers that smooth every edge would show seams.
fn cells_as_paths(cells: &Array2<f64>, frame: &Frame, bar: &Axis) -> String {
    let (rows, columns) = cells.dim();
    let level = |value: f64| {
        let place = bar.place(value);
        if place.is_nan() { LEVELS } else { (place * LEVELS as f64).clamp(0.0, (LEVELS - 1) as f64) as usize }
    };
    let mut paths = vec![String::new(); LEVELS + 1];
    for (row, values) in cells.outer_iter().enumerate() {
        let mut start = 0;
        while start < columns {
            let colour = level(values[start]);
            let length = values.iter().skip(start).take_while(|&&value| level(value) == colour).count();
            // Row 0 is at the bottom. Writing to a string does not fail.
            let _ = write!(paths[colour], "M{start} {}h{length}.1", rows - 1 - row);
            start += length;
        }
    }
    let (width, height) = (f64::from(frame.x.end - frame.x.start), f64::from(frame.y.end - frame.y.start));
    let (cell_width, cell_height) = (width / columns as f64, height / rows as f64);
    let mut svg = format!(
        "<g transform=\"translate({} {:.3}) scale({cell_width:.6} {cell_height:.6})\" fill=\"none\" \
         stroke-width=\"1.1\" shape-rendering=\"crispEdges\">\n",
        frame.x.start,
        f64::from(frame.y.start) + 0.5 * cell_height,
    );
    for (colour, path) in paths.iter().enumerate().filter(|(_, path)| !path.is_empty()) {
        let RGBColor(r, g, b) =
            if colour == LEVELS { NO_VALUE } else { viridis((colour as f64 + 0.5) / LEVELS as f64) };
        let middle = bar.value((colour as f64 + 0.5) / LEVELS as f64);
        let value = if colour == LEVELS { "no value".to_owned() } else { four_digits(middle) };
        let value = told(&format!("{}: {value}", bar.title()));
        let _ = writeln!(svg, "<path stroke=\"#{r:02X}{g:02X}{b:02X}\" d=\"{path}\">{value}</path>");
    }
    svg.push_str("</g>\n");
    svg
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;

    #[test]
    fn averaging_keeps_the_mean_and_skips_holes() {
        let field = Array2::from_shape_fn((600, 1200), |(row, column)| (row * 7 + column) as f64);
        let small = averaged(field.view(), 300, 400);
        assert_eq!(small.dim(), (300, 400));
        let mean = |a: &Array2<f64>| a.sum() / a.len() as f64;
        assert!((mean(&field) / mean(&small) - 1.0).abs() < 1e-12);
        let holes = averaged(array![[1.0, f64::NAN], [f64::NAN, f64::NAN]].view(), 2, 1);
        assert!((holes[[0, 0]] - 1.0).abs() < 1e-15 && holes[[1, 0]].is_nan());
    }

    #[test]
    fn runs_are_merged_and_the_first_row_is_at_the_bottom() {
        let cells = array![[0.0, 0.0, 0.0, 1.0], [1.0, f64::NAN, 1.0, 1.0]];
        let svg = cells_as_paths(&cells, &Frame::of(0..4, 0..2), &Axis::linear("z", 0.0..1.0));
        assert_eq!(svg.matches("<path").count(), 3, "two colours and grey");
        assert!(svg.contains("d=\"M0 1h3.1\""), "{svg}");
        assert!(svg.contains("d=\"M3 1h1.1M0 0h1.1M2 0h2.1\""), "{svg}");
        assert!(svg.contains("stroke=\"#C8C8C8\" d=\"M1 0h1.1\""), "{svg}");
    }

    #[test]
    fn the_roughest_field_stays_small() {
        // Random values: runs of equal colour are as short as chance makes them.
        let mut state = 1_u64;
        let field = Array2::from_shape_simple_fn((2000, 3000), || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64
        });
        let map = HeatMap {
            title: "noise",
            x: Axis::linear("x [m]", 0.0..1.0),
            y: Axis::linear("y [m]", 0.0..1.0),
            quantity: "z [mm]",
            values: field.view(),
            colours: Colours::Extent,
            aspect: None,
        };
        let svg = map.to_svg().unwrap();
        assert!(svg.len() < 1_600_000, "{} bytes", svg.len());
        let empty = HeatMap { values: ArrayView2::from_shape((0, 0), &[]).unwrap(), ..map };
        assert!(matches!(empty.to_svg(), Err(PlotError::Shape { .. })));
    }
}
