//! P between cells and their sub-cells: forces of sub-cells are spread over cells, a field of cells is interpolated
//! between their middles by the transpose of the same weights.
//!
//! Weights are those of cubic convolution (Keys 1981, a = -1/2) along and across: polynomials of the second degree pass
//! unchanged, so sums and first moments of forces do, too.

use std::ops::Range;

use crate::numeric::Element;

/// Weights of a sub-cell: the four cells from the one before the last whose middle is not beyond that of the sub-cell.
#[derive(Clone, Copy, Debug)]
struct Weights {
    /// First cell, relative to the one that the sub-cell is in.
    first: i64,
    weights: [f64; 4],
}

impl Weights {
    /// Weights at a distance t from the middle of a cell, in cells, |t| <= 1/2.
    fn at(t: f64) -> Self {
        let (below, x) = if t < 0.0 { (-1, t + 1.0) } else { (0, t) };
        let (x2, x3) = (x * x, x * x * x);
        let weights =
            [-0.5 * x3 + x2 - 0.5 * x, 1.5 * x3 - 2.5 * x2 + 1.0, -1.5 * x3 + 2.0 * x2 + 0.5 * x, 0.5 * x3 - 0.5 * x2];
        Self { first: below - 1, weights }
    }

    fn cells(self) -> impl Iterator<Item = (i64, f64)> {
        (self.first..).zip(self.weights)
    }
}

/// Middle of a sub-cell from that of its cell, in cells.
fn place(sub_cells: usize, sub_cell: usize) -> f64 {
    (sub_cell as f64 + 0.5) / sub_cells as f64 - 0.5
}

/// Part of a wave's amplitude that the mean over the places of sub-cells passes, by its phase over a cell.
pub(crate) fn passed(sub_cells: usize, phase: f64) -> f64 {
    let of_place = |t: f64| {
        let parts = Weights::at(t).cells().map(|(cell, weight)| weight * (phase * (t - cell as f64)).cos());
        parts.sum::<f64>()
    };
    (0..sub_cells).map(|sub_cell| of_place(place(sub_cells, sub_cell))).sum::<f64>() / sub_cells as f64
}

/// P of a window.
#[derive(Clone, Debug)]
pub(crate) struct Interpolation {
    sub_cells: usize,
    columns: usize,
    across: usize,
    along: Vec<Weights>,
    /// By sub-cell across: cells and weights.
    crosswise: Vec<Vec<(usize, f64)>>,
    /// A row of cells.
    row: Vec<f64>,
    /// Rows of cells, interpolated across.
    rows: Vec<f64>,
}

impl Interpolation {
    /// P between the cells of a window and `sub_cells` each along and across.
    pub(crate) fn new(sub_cells: usize, columns: usize, across: usize) -> Self {
        let along: Vec<Weights> = (0..sub_cells).map(|sub_cell| Weights::at(place(sub_cells, sub_cell))).collect();
        let last = across as i64 - 1;
        let crosswise = (0..across * sub_cells).map(|j| {
            let mut all = vec![0.0; across];
            for (offset, weight) in along[j % sub_cells].cells() {
                // Beyond the strip's edges a field goes on in a straight line.
                let cell = (j / sub_cells) as i64 + offset;
                let edge = cell.clamp(0, last);
                let beyond = (cell - edge).abs() as f64;
                all[edge as usize] += weight * (1.0 + beyond);
                all[(edge - (cell - edge).signum()).clamp(0, last) as usize] -= weight * beyond;
            }
            all.into_iter().enumerate().filter(|(_, weight)| weight.abs() > 0.0).collect()
        });
        Self {
            sub_cells,
            columns,
            across,
            crosswise: crosswise.collect(),
            along,
            row: vec![0.0; across],
            rows: vec![0.0; columns * across * sub_cells],
        }
    }

    pub(crate) fn sub_cells(&self) -> usize {
        self.sub_cells
    }

    /// Sub-cells of some columns of cells.
    pub(crate) fn of_columns(&self, columns: Range<usize>) -> Range<usize> {
        let of_column = self.sub_cells * self.sub_cells * self.across;
        columns.start * of_column..columns.end * of_column
    }

    /// Forces of cells from those of their sub-cells: P f.
    pub(crate) fn spread<R: Element>(&mut self, forces: &[R], out: &mut [f64]) {
        out.fill(0.0);
        let (last, width) = (self.columns as i64 - 1, self.across * self.sub_cells);
        for (i, forces) in forces.chunks_exact(width).enumerate() {
            self.row.fill(0.0);
            let mut is_empty = true;
            for (force, weights) in forces.iter().zip(&self.crosswise) {
                let force = force.double();
                if force != 0.0 {
                    is_empty = false;
                    weights.iter().for_each(|(cell, weight)| self.row[*cell] += weight * force);
                }
            }
            if is_empty {
                continue;
            }
            for (offset, weight) in self.along[i % self.sub_cells].cells() {
                // Contact does not reach the window's ends.
                let column = ((i / self.sub_cells) as i64 + offset).clamp(0, last) as usize;
                let out = &mut out[column * self.across..][..self.across];
                out.iter_mut().zip(&self.row).for_each(|(out, force)| *out += weight * force);
            }
        }
    }

    /// Adds a field of cells, interpolated at the sub-cells.
    pub(crate) fn add_interpolated(&mut self, field: &[f64], out: &mut [f64]) {
        let (last, width) = (self.columns as i64 - 1, self.across * self.sub_cells);
        for (row, field) in self.rows.chunks_exact_mut(width).zip(field.chunks_exact(self.across)) {
            for (value, weights) in row.iter_mut().zip(&self.crosswise) {
                *value = weights.iter().map(|(cell, weight)| weight * field[*cell]).sum();
            }
        }
        for (i, out) in out.chunks_exact_mut(width).enumerate() {
            for (offset, weight) in self.along[i % self.sub_cells].cells() {
                let column = ((i / self.sub_cells) as i64 + offset).clamp(0, last) as usize;
                out.iter_mut().zip(&self.rows[column * width..]).for_each(|(out, value)| *out += weight * value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: usize = 7;
    const ACROSS: usize = 5;
    const SUB_CELLS: usize = 3;

    fn fields() -> (Interpolation, Vec<f64>, Vec<f64>) {
        let of = |count: usize, step: f64| (0..count).map(|n| (step * n as f64).sin()).collect();
        let cells = COLUMNS * ACROSS;
        (Interpolation::new(SUB_CELLS, COLUMNS, ACROSS), of(cells, 0.7), of(cells * SUB_CELLS * SUB_CELLS, 1.3))
    }

    #[test]
    fn spreading_is_the_transpose_of_interpolation() {
        let (mut between, field, forces) = fields();
        let (mut spread, mut interpolated) = (vec![0.0; field.len()], vec![0.0; forces.len()]);
        between.spread(&forces, &mut spread);
        between.add_interpolated(&field, &mut interpolated);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((product(&spread, &field) - product(&forces, &interpolated)).abs() < 1e-13);
        assert!((spread.iter().sum::<f64>() - forces.iter().sum::<f64>()).abs() < 1e-13);
    }

    #[test]
    fn parabolas_along_and_straight_lines_across_pass_unchanged() {
        let (mut between, ..) = fields();
        let value = |x: f64, y: f64| 1.0 + 0.3 * x - 0.2 * x * x + 0.5 * y;
        let field: Vec<f64> = (0..COLUMNS * ACROSS).map(|n| value((n / ACROSS) as f64, (n % ACROSS) as f64)).collect();
        let width = ACROSS * SUB_CELLS;
        let mut found = vec![0.0; COLUMNS * SUB_CELLS * width];
        between.add_interpolated(&field, &mut found);
        let middle = |n: usize| (n as f64 + 0.5) / SUB_CELLS as f64 - 0.5;
        for i in 2 * SUB_CELLS..(COLUMNS - 2) * SUB_CELLS {
            for j in 0..width {
                let expected = value(middle(i), middle(j));
                assert!((found[i * width + j] - expected).abs() < 1e-12, "{i}, {j}");
            }
        }
    }

    #[test]
    fn long_waves_pass_and_the_shortest_are_damped() {
        assert!((passed(4, 0.1) - 1.0).abs() < 1e-5);
        assert!((0.3..0.9).contains(&passed(4, 0.8 * std::f64::consts::PI)));
    }
}
