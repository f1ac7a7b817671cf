//! Contact forces over patch and time (Larsson's figure 5).

use std::ops::Range;

use ndarray::{Array2, ArrayView2};

use super::PlotError;
use super::axis::Axis;
use super::heat_map::{Colours, HeatMap, MOST_ROWS};

/// Arrays as in a results folder, and what is needed to position them.
#[derive(Clone, Debug)]
pub(crate) struct ForceMap<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Time of each step \[s\], rising.
    pub time: &'a [f64],
    /// Element number e of the window's first column, for each step.
    pub first_element: &'a [i64],
    /// Contact forces \[N\]: \[steps, window\].
    pub force: ArrayView2<'a, f64>,
    /// Length of an element dx \[m\].
    pub element_length: f64,
    /// Speed V \[m/s\].
    pub speed: f64,
    /// Road coordinate under the axle at t = 0 \[m\].
    pub start: f64,
    /// Part of the time that is drawn \[s\].
    pub shown: Range<f64>,
}

impl ForceMap<'_> {
    /// The picture as SVG: position in the patch (the axle at 0, rolling to the right) horizontally, time upwards.
    ///
    /// # Errors
    /// [`PlotError`] if the arrays differ in length or no step lies in the time shown.
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        let picture = "the forces over patch and time";
        let steps = self.force.nrows();
        for (quantity, got) in [("time", self.time.len()), ("first elements", self.first_element.len())] {
            if got != steps {
                return Err(PlotError { picture, quantity, expected: steps, got });
            }
        }
        let from = self.time.partition_point(|&t| t < self.shown.start);
        let to = self.time.partition_point(|&t| t < self.shown.end);
        if from >= to {
            return Err(PlotError { picture, quantity: "time steps in the part shown", expected: 1, got: 0 });
        }
        let steps = from..to;
        let columns = self.columns(&steps);
        let field = self.field(&steps, &columns);
        // A constant time step: the rows' outer edges are half a row beyond the first and last step's blocks.
        let step = if to - from > 1 { (self.time[to - 1] - self.time[from]) / (to - from - 1) as f64 } else { 1.0 };
        let millimetres = |column: f64| (column - 0.5) * self.element_length * 1e3;
        let map = HeatMap {
            title: self.title,
            x: Axis::linear(
                "Position in the patch, rolling direction to the right [mm]",
                millimetres(columns.start as f64)..millimetres(columns.end as f64),
            ),
            y: Axis::linear("Time [s]", self.time[from]..self.time[to - 1] + step),
            quantity: "Contact force per element [N]",
            values: field.view(),
            colours: Colours::Between(0.0..field.iter().copied().fold(f64::MIN_POSITIVE, f64::max)),
            aspect: Some(1.0),
        };
        map.to_svg()
    }

    /// Position of element `first_element + column` relative to the axle at a step, in whole elements.
    fn place(&self, step: usize, column: usize) -> i64 {
        let element = (self.first_element[step] + column as i64) as f64;
        let x = element * self.element_length - (self.start + self.speed * self.time[step]);
        (x / self.element_length).round() as i64
    }

    /// Positions that carry force at any of the steps, with a margin of two elements on either side.
    fn columns(&self, steps: &Range<usize>) -> Range<i64> {
        let loaded = steps.clone().flat_map(|step| {
            let row = self.force.row(step);
            let first = row.iter().position(|&force| force > 0.0);
            let last = row.iter().rposition(|&force| force > 0.0);
            [first, last].into_iter().flatten().map(move |column| self.place(step, column))
        });
        let (low, high) = loaded.fold((i64::MAX, i64::MIN), |(low, high), place| (low.min(place), high.max(place)));
        if low <= high { low - 2..high + 3 } else { -2..3 }
    }

    /// Forces at fixed positions in the patch, \[rows of time, positions\]; several steps in a row are averaged.
    fn field(&self, steps: &Range<usize>, columns: &Range<i64>) -> Array2<f64> {
        let rows = steps.len().min(MOST_ROWS);
        let mut field = Array2::zeros((rows, (columns.end - columns.start) as usize));
        for row in 0..rows {
            let block = steps.start + row * steps.len() / rows..steps.start + (row + 1) * steps.len() / rows;
            let share = 1.0 / block.len() as f64;
            for step in block {
                for (column, &force) in self.force.row(step).iter().enumerate() {
                    let place = self.place(step, column);
                    if columns.contains(&place) {
                        field[[row, (place - columns.start) as usize]] += share * force;
                    }
                }
            }
        }
        field
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standing_patch_stands_in_the_picture() {
        // Elements roll through: the window follows the axle, and the force is centred on it.
        let (dx, speed, window, steps) = (0.004, 20.0, 21_usize, 1000_usize);
        let time: Vec<f64> = (0..steps).map(|step| step as f64 * dx / speed).collect();
        let first: Vec<i64> = (0..steps).map(|step| step as i64 - 10).collect();
        let hill = |column: usize| (25.0 - (column as f64 - 10.0).powi(2)).max(0.0);
        let force = Array2::from_shape_fn((steps, window), |(_, column)| hill(column));
        let map = ForceMap {
            title: "hill",
            time: &time,
            first_element: &first,
            force: force.view(),
            element_length: dx,
            speed,
            start: 0.0,
            shown: 0.0..1.0,
        };
        let all = 0..steps;
        let columns = map.columns(&all);
        assert_eq!(columns, -6..7);
        let field = map.field(&all, &columns);
        assert_eq!(field.dim(), (MOST_ROWS, 13));
        for row in field.outer_iter() {
            for (column, value) in row.iter().enumerate() {
                assert!((value - hill(column + 4)).abs() < 1e-9, "{column}: {value}");
            }
        }
        let svg = map.to_svg().unwrap();
        assert!(svg.len() < 100_000, "a smooth patch is a small picture: {}", svg.len());
        let short = ForceMap { time: &time[1..], ..map.clone() };
        assert!(matches!(short.to_svg(), Err(PlotError { quantity: "time", .. })));
        assert!(ForceMap { shown: 5.0..6.0, ..map }.to_svg().is_err());
    }
}
