//! Between the cells of a window and the waves of a ring, for three components, each with different shapes across.

use num_complex::Complex;
use rayon::prelude::*;

use super::product::Vector;
use crate::contact::cells::wave_transform::{WaveNumber, WaveTransform};
use crate::counters::Work;
use crate::scene::Sides;
use crate::tyre::influence::{COMPONENTS, CellGrid, CellRow, folded_traction_shape, traction_shape};

struct Part<R: WaveNumber> {
    transform: WaveTransform<R>,
    cells: Vec<f64>,
    spectrum: Vec<Complex<R>>,
}

pub(crate) struct TractionTransform<R: WaveNumber = f64> {
    parts: Vec<Part<R>>,
}

impl<R: WaveNumber> TractionTransform<R> {
    /// Transforms between a window of `columns` columns and the waves of rows on a ring of `ring` cells.
    pub(crate) fn new(grid: &CellGrid, [ring, columns]: [usize; 2], rows: &[CellRow]) -> Self {
        let part = |component: usize| {
            let shape = |row: &CellRow, j: usize| {
                let of = if row.folded { folded_traction_shape } else { traction_shape };
                of(grid, component, row.m, j)
            };
            // Sines and cosines of waves between the sides, and sines less their mean.
            let is_cosine = (component == 1) == (grid.waves().sides == Sides::Supported);
            let is_even = |m: usize| m.is_multiple_of(2) == is_cosine;
            let transform = WaveTransform::with_shapes([ring, columns, grid.across], rows, shape, is_even);
            let (cells, waves) = (vec![0.0; transform.cells()], transform.waves());
            Part { transform, cells, spectrum: vec![Complex::new(R::default(), R::default()); waves] }
        };
        Self { parts: (0..COMPONENTS).map(part).collect() }
    }

    pub(super) fn cells(&self) -> usize {
        self.parts[0].transform.cells()
    }

    pub(super) fn waves(&self) -> usize {
        self.parts[0].spectrum.len()
    }

    /// Phase of each wave from one element to the next \[rad\].
    pub(super) fn angles(&self) -> Vec<f64> {
        self.parts[0].transform.angles()
    }

    /// Work of one direction.
    pub(super) fn work(&self) -> Work {
        self.parts[0].transform.work() * COMPONENTS as u64
    }

    pub(super) fn spectra(&self) -> [&[Complex<R>]; COMPONENTS] {
        std::array::from_fn(|component| self.parts[component].spectrum.as_slice())
    }

    pub(super) fn spectra_mut(&mut self) -> impl Iterator<Item = &mut [Complex<R>]> {
        self.parts.iter_mut().map(|part| part.spectrum.as_mut_slice())
    }

    /// Transforms the forces \[N\] on a window that begins with an element; their waves are the spectra.
    pub(super) fn forward(&mut self, first_element: i64, forces: &[Vector]) {
        self.parts.par_iter_mut().enumerate().for_each(|(component, Part { transform, cells, spectrum })| {
            cells.iter_mut().zip(forces).for_each(|(cell, force)| *cell = force[component]);
            transform.forward(first_element, cells, spectrum);
        });
    }

    /// Adds the displacements \[m\] of the waves in the spectra to the cells of the window.
    pub(super) fn add_inverse(&mut self, first_element: i64, out: &mut [Vector]) {
        self.parts.par_iter_mut().for_each(|Part { transform, cells, spectrum }| {
            cells.fill(0.0);
            transform.add_inverse(spectrum, first_element, cells);
        });
        for (component, part) in self.parts.iter().enumerate() {
            out.iter_mut().zip(&part.cells).for_each(|(out, cell)| out[component] += cell);
        }
    }
}
