//! Colour maps: a field over two axes, with a colour bar.
//!
//! The SVG is small: at most [`MOST_COLUMNS`] x [`MOST_ROWS`] cells (larger fields are averaged), 64 colours, and for
//! each colour one path whose strokes are the runs of equal cells: some bytes per run instead of a rectangle per cell.
//!
//! Two kinds of them: a field over a piece of road or over the contact patch (Larsson's figure 3), and shares that add
//! up to a whole, over a coordinate and the frequency.

use std::fmt::Write as _;
use std::ops::Range;

use ndarray::{Array2, ArrayView2};

use super::PlotError;
use super::axis::{Axis, extent, four_digits};
use super::colour::{NO_VALUE, WHITE, viridis};
use super::layout::width_beside;
use super::sheet::{Frame, Sheet, WIDTH, title};

/// Most cells along x that are drawn.
const MOST_COLUMNS: usize = 400;
/// Most cells along y that are drawn.
pub(crate) const MOST_ROWS: usize = 300;
/// Width of the colour bar, its distance from the frame, and the smallest and largest height of both in shown pixels.
const BAR: f64 = 16.0;
const BAR_GAP: f64 = 14.0;
const LEAST_HEIGHT: f64 = 80.0;
const MOST_HEIGHT: f64 = 420.0;
/// Number of colours.
const LEVELS: usize = 64;

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
    /// [`PlotError`] without cells.
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        self.to_svg_under(&[])
    }

    /// The picture as SVG with curves over it, given in the units of the axes and cut at the frame.
    ///
    /// # Errors
    /// As [`Self::to_svg`].
    pub(crate) fn to_svg_under(&self, curves: &[Vec<(f64, f64)>]) -> Result<String, PlotError> {
        if self.values.is_empty() {
            return Err(PlotError { picture: "a colour map", quantity: "the field", expected: 1, got: 0 });
        }
        let cells = averaged(self.values, MOST_ROWS, MOST_COLUMNS);
        let range = match &self.colours {
            Colours::Extent => extent(cells.iter().copied()),
            Colours::Between(range) => range.clone(),
        };
        let bar = Axis::linear(self.quantity, range);
        // The rooms beside the frame depend on its height, which is known with its width: estimated for the largest.
        let right = |height: f64| BAR_GAP + BAR + width_beside(&bar, height);
        let width = WIDTH - width_beside(&self.y, MOST_HEIGHT) - right(MOST_HEIGHT);
        let height = (width * self.aspect.unwrap_or(0.68)).clamp(LEAST_HEIGHT, MOST_HEIGHT);
        let mut sheet = Sheet::default();
        let axes = sheet.axes(self.title, [&self.x, &self.y], height, right(height));
        draw_cells(&mut sheet, &cells, axes.frame, &bar);
        for curve in curves {
            // White is lighter than all but the very peaks of a map.
            sheet.curve(&axes, curve, WHITE, 0.8);
        }
        let beside = Frame { left: axes.frame.across(1.0) + BAR_GAP, width: BAR, ..axes.frame };
        let scale = Array2::from_shape_fn((LEVELS, 1), |(level, _)| middle_of(level, &bar));
        draw_cells(&mut sheet, &scale, beside, &bar);
        sheet.ticks_beside(beside, &bar, 1.0);
        sheet.outline(axes.frame);
        sheet.outline(beside);
        Ok(sheet.into_svg())
    }
}

/// Value in the middle of a colour's range.
fn middle_of(level: usize, bar: &Axis) -> f64 {
    bar.value((level as f64 + 0.5) / LEVELS as f64)
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

/// Draws all cells: units of one cell, one path per colour, one stroke per run. Strokes are a tenth of a cell wider
/// and longer than their cells: viewers that smooth every edge would show seams.
fn draw_cells(sheet: &mut Sheet, cells: &Array2<f64>, frame: Frame, bar: &Axis) {
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
    let (width, height) = (frame.width / columns as f64, frame.height / rows as f64);
    sheet.put(format_args!(
        "<g transform=\"translate({:.2} {:.3}) scale({width:.6} {height:.6})\" fill=\"none\" stroke-width=\"1.1\" \
         shape-rendering=\"crispEdges\">",
        frame.left,
        frame.top + 0.5 * height,
    ));
    for (level, path) in paths.iter().enumerate().filter(|(_, path)| !path.is_empty()) {
        let (colour, value) = match level {
            LEVELS => (NO_VALUE, "no value".to_owned()),
            _ => (viridis((level as f64 + 0.5) / LEVELS as f64), four_digits(middle_of(level, bar))),
        };
        let value = title(&format!("{}: {value}", bar.title));
        sheet.put(format_args!(r#"<path stroke="{colour}" d="{path}">{value}</path>"#));
    }
    sheet.put(format_args!("</g>"));
}

/// Smallest and largest height over width; beyond these a picture is not true to scale, since 1:1 would be a thread.
const ASPECTS: (f64, f64) = (0.22, 1.2);

/// A field over a lattice of points, each in the middle of its cell; across, they are centred on the tyre.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceMap<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Title of the horizontal axis, without its unit.
    pub along: &'a str,
    /// Quantity of the colours, unit included.
    pub quantity: &'a str,
    /// Values: \[points along, points across\], NaN where there is none.
    pub values: ArrayView2<'a, f64>,
    /// Position of the first points along \[m\].
    pub first_position: f64,
    /// Length and width of a cell \[m\].
    pub size: [f64; 2],
}

impl SurfaceMap<'_> {
    /// The picture as SVG, true to scale unless it would be too flat or too tall.
    ///
    /// # Errors
    /// [`PlotError`] without points.
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        let Self { title, along, quantity, values, first_position, size: [dx, dy] } = self;
        let [length, width] = [values.nrows() as f64 * dx, values.ncols() as f64 * dy];
        let (unit, scale) = if length < 1.0 { ("mm", 1e3) } else { ("m", 1.0) };
        let begin = first_position - 0.5 * dx;
        HeatMap {
            title,
            x: Axis::linear(format!("{along} [{unit}]"), scale * begin..scale * (begin + length)),
            y: Axis::linear("Across [mm]", -500.0 * width..500.0 * width),
            quantity,
            values: values.t(),
            colours: Colours::Extent,
            aspect: Some((width / length).clamp(ASPECTS.0, ASPECTS.1)),
        }
        .to_svg()
    }
}

/// Rows of the picture, evenly spaced on the logarithmic axis, however the frequencies are.
const ROWS: usize = 120;

/// Values of the first and last colour: contributions that cancel each other have sums of shares below 0 and above 1.
/// The value 1, all shares together, is in the middle of a colour and not between two.
const RANGE: std::ops::Range<f64> = -0.6..1.6;

/// Running sums of shares, one row for each frequency.
#[derive(Clone, Debug)]
pub(crate) struct ShareMap<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Coordinate along which shares add up; its range is that of all shares of a row, outer edge to outer edge.
    pub x: Axis,
    /// Quantity of the colours.
    pub quantity: &'a str,
    /// Frequencies, rising \[Hz\].
    pub frequencies: &'a [f64],
    /// Running sums of shares by frequency, all of the same length.
    pub so_far: &'a [Vec<f64>],
    /// Curves over the map, in the units of the axes.
    pub curves: &'a [Vec<(f64, f64)>],
}

impl ShareMap<'_> {
    /// The picture as SVG. Each row shows the nearest frequency.
    ///
    /// # Errors
    /// [`PlotError`] for fewer than two frequencies or rows that are no shares.
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        let picture = "a map of shares";
        let (expected, got) = (self.frequencies.len().max(2), self.so_far.len());
        if got != expected {
            return Err(PlotError { picture, quantity: "the shares", expected, got });
        }
        let columns = self.so_far[0].len();
        if let Some(row) = self.so_far.iter().find(|row| row.len() != columns) {
            return Err(PlotError { picture, quantity: "a row", expected: columns, got: row.len() });
        }
        let (lowest, highest) = (self.frequencies[0], self.frequencies[got - 1]);
        let rows: Vec<usize> = (0..ROWS).map(|row| self.nearest(lowest, highest, row)).collect();
        let values = Array2::from_shape_fn((ROWS, columns), |(row, column)| self.so_far[rows[row]][column]);
        HeatMap {
            title: self.title,
            x: self.x.clone(),
            y: Axis::logarithmic("Frequency [Hz]", lowest..highest),
            quantity: self.quantity,
            values: values.view(),
            colours: Colours::Between(RANGE),
            aspect: None,
        }
        .to_svg_under(self.curves)
    }

    /// Index of the frequency that is shown in a row.
    fn nearest(&self, lowest: f64, highest: f64, row: usize) -> usize {
        let wanted = lowest * (highest / lowest).powf((row as f64 + 0.5) / ROWS as f64);
        let above = self.frequencies.partition_point(|&frequency| frequency < wanted).min(self.frequencies.len() - 1);
        let below = above.saturating_sub(1);
        if wanted / self.frequencies[below] < self.frequencies[above] / wanted { below } else { above }
    }
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
        let frame = Frame { left: 0.0, top: 0.0, width: 4.0, height: 2.0 };
        let mut sheet = Sheet::default();
        draw_cells(&mut sheet, &cells, frame, &Axis::linear("z", 0.0..1.0));
        let svg = sheet.into_svg();
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
        assert!(matches!(empty.to_svg(), Err(PlotError { quantity: "the field", .. })));
    }

    #[test]
    fn holes_and_flat_roads_are_drawn_and_nothing_is_refused() {
        let mut heights = Array2::zeros((100, 10));
        let road = |heights: &Array2<f64>| {
            let (title, along, quantity) = ("r", "Along", "Height [mm]");
            let values = heights.view();
            SurfaceMap { title, along, quantity, values, first_position: 1.0, size: [0.01, 0.02] }.to_svg()
        };
        assert!(road(&heights).unwrap().contains("Along [m]"));
        heights[[3, 4]] = f64::NAN;
        assert!(road(&heights).unwrap().contains("#C8C8C8"), "a hole is grey");
        heights.fill(f64::NAN);
        assert!(road(&heights).is_ok());
        assert!(road(&Array2::zeros((50, 10))).unwrap().contains("Along [mm]"));
        assert!(matches!(road(&Array2::zeros((0, 3))), Err(PlotError { .. })));
    }

    #[test]
    fn rows_show_the_nearest_frequency_and_wrong_shapes_are_refused() {
        let so_far = [vec![0.2, 1.0], vec![0.5, 1.0], vec![0.9, 1.0]];
        let map = ShareMap {
            title: "t",
            x: Axis::linear("n", 0.0..2.0),
            quantity: "share",
            frequencies: &[100.0, 400.0, 1600.0],
            so_far: &so_far,
            curves: &[],
        };
        let shown: Vec<usize> = (0..ROWS).map(|row| map.nearest(100.0, 1600.0, row)).collect();
        let count = |frequency: usize| shown.iter().filter(|&&shown| shown == frequency).count();
        assert!(shown.is_sorted() && (count(0), count(1), count(2)) == (30, 60, 30));
        assert!(map.to_svg().unwrap().contains("</svg>"));
        assert!(ShareMap { so_far: &so_far[..2], ..map.clone() }.to_svg().is_err());
        assert!(ShareMap { so_far: &so_far[..1], frequencies: &[100.0], ..map.clone() }.to_svg().is_err());
        let ragged = [vec![0.2], vec![0.5, 1.0], vec![0.9, 1.0]];
        assert!(ShareMap { so_far: &ragged, ..map }.to_svg().is_err());
    }
}
