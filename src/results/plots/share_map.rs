//! Shares that add up to a whole, over a coordinate and the frequency.

use ndarray::Array2;

use super::PlotError;
use super::axis::Axis;
use super::heat_map::{Colours, HeatMap};

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
    use super::*;

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
