//! Between the cells of a window and the waves of the whole tyre, for three components.
//!
//! Across by a product with each component's shapes, along by a transform of the ring for each lateral number. Cells
//! are material: a cell keeps its place on the ring.

use std::sync::Arc;

use num_complex::Complex64;
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use super::product::Vector;
use crate::tyre::influence::{COMPONENTS, CellGrid, CellRow, traction_shape};

/// Forces or displacements of a wave.
pub(super) type WaveVector = [Complex64; COMPONENTS];

/// One lateral number.
struct Row {
    /// Place of its waves in the list of all.
    start: usize,
    /// Number of the first one on the ring.
    first: usize,
    count: usize,
    /// Shapes of the components on the cells across.
    shapes: [Vec<f64>; COMPONENTS],
}

/// Transforms of a window.
pub(crate) struct TractionTransform {
    columns: usize,
    across: usize,
    rows: Vec<Row>,
    waves: usize,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl TractionTransform {
    /// Makes the transforms between a window of so many columns and the waves of rows.
    pub(crate) fn new(grid: &CellGrid, columns: usize, rows: &[CellRow]) -> Self {
        let mut planner = RealFftPlanner::<f64>::new();
        let mut start = 0;
        let row = |row: &CellRow| {
            let shape = |component: usize| -> Vec<f64> {
                (0..grid.across).map(|j| traction_shape(grid, component, row.m, j)).collect()
            };
            start += row.waves.len();
            let shapes = std::array::from_fn(shape);
            Row { start: start - row.waves.len(), first: row.first, count: row.waves.len(), shapes }
        };
        let rows: Vec<Row> = rows.iter().map(row).collect();
        let ring = grid.elements();
        let (forward, inverse) = (planner.plan_fft_forward(ring), planner.plan_fft_inverse(ring));
        Self { columns, across: grid.across, rows, waves: start, forward, inverse }
    }

    /// Returns the number of waves.
    pub(super) fn waves(&self) -> usize {
        self.waves
    }

    /// Finds the waves of the forces on a window that begins with an element.
    pub(super) fn forward(&self, first_element: i64, forces: &[Vector], out: &mut [WaveVector]) {
        let ring = self.forward.len();
        let first = first_element.rem_euclid(ring as i64) as usize;
        let of_row = |row: &Row| -> Vec<WaveVector> {
            let (mut elements, mut spectrum) = (self.forward.make_input_vec(), self.forward.make_output_vec());
            let mut waves = vec![[Complex64::ZERO; COMPONENTS]; row.count];
            for (component, shape) in row.shapes.iter().enumerate() {
                elements.fill(0.0);
                for (column, cells) in forces.chunks_exact(self.across).enumerate() {
                    let sum = cells.iter().zip(shape).map(|(force, shape)| force[component] * shape).sum::<f64>();
                    elements[(first + column) % ring] += sum;
                }
                // Planned lengths: nothing to refuse.
                let _ = self.forward.process(&mut elements, &mut spectrum);
                for (wave, value) in waves.iter_mut().zip(&spectrum[row.first..]) {
                    wave[component] = *value;
                }
            }
            waves
        };
        let rows: Vec<Vec<WaveVector>> = self.rows.par_iter().map(of_row).collect();
        for (row, waves) in self.rows.iter().zip(rows) {
            out[row.start..row.start + row.count].copy_from_slice(&waves);
        }
    }

    /// Adds the displacements of waves to the cells of the window.
    pub(super) fn add_inverse(&self, waves: &[WaveVector], first_element: i64, out: &mut [Vector]) {
        let ring = self.forward.len();
        let first = first_element.rem_euclid(ring as i64) as usize;
        let of_row = |row: &Row| -> Vec<Vector> {
            let (mut spectrum, mut elements) = (self.inverse.make_input_vec(), self.inverse.make_output_vec());
            let mut columns = vec![[0.0; COMPONENTS]; self.columns];
            for component in 0..COMPONENTS {
                spectrum.fill(Complex64::ZERO);
                let own = &waves[row.start..row.start + row.count];
                spectrum[row.first..].iter_mut().zip(own).for_each(|(value, wave)| *value = wave[component]);
                let last = spectrum.len() - 1;
                (spectrum[0].im, spectrum[last].im) = (0.0, 0.0);
                let _ = self.inverse.process(&mut spectrum, &mut elements);
                for (column, values) in columns.iter_mut().enumerate() {
                    values[component] = elements[(first + column) % ring];
                }
            }
            columns
        };
        let rows: Vec<Vec<Vector>> = self.rows.par_iter().map(of_row).collect();
        for (row, columns) in self.rows.iter().zip(rows) {
            for (cells, values) in out.chunks_exact_mut(self.across).zip(columns) {
                for (component, (shape, value)) in row.shapes.iter().zip(values).enumerate() {
                    cells.iter_mut().zip(shape).for_each(|(cell, shape)| cell[component] += shape * value);
                }
            }
        }
    }
}
