//! Between the cells of a window and the waves of a ring, component by component, each with its own shapes across.

use num_complex::Complex;
use rayon::prelude::*;

use super::wave_transform::{WaveNumber, WaveTransform};
use crate::counters::Work;
use crate::scene::Sides;
use crate::tyre::influence::{COMPONENTS, CellGrid, CellRow, folded_traction_shape, traction_shape};

struct ComponentField<R: WaveNumber> {
    transform: WaveTransform<R>,
    cells: Vec<f64>,
    spectrum: Vec<Complex<R>>,
}

impl<R: WaveNumber> From<WaveTransform<R>> for ComponentField<R> {
    fn from(transform: WaveTransform<R>) -> Self {
        let (cells, waves) = (vec![0.0; transform.cells()], transform.waves());
        Self { transform, cells, spectrum: vec![Complex::new(R::default(), R::default()); waves] }
    }
}

/// Transforms of `C` components: 1, normal forces, or 3, tractions.
pub(crate) struct ComponentTransforms<R: WaveNumber, const C: usize> {
    parts: [ComponentField<R>; C],
}

impl<R: WaveNumber> From<WaveTransform<R>> for ComponentTransforms<R, 1> {
    fn from(transform: WaveTransform<R>) -> Self {
        Self { parts: [transform.into()] }
    }
}

impl<R: WaveNumber> ComponentTransforms<R, COMPONENTS> {
    /// Transforms between tractions on a window of `columns` columns and the waves of rows on the grid's ring.
    pub(crate) fn of_tractions(grid: &CellGrid, columns: usize, rows: &[CellRow]) -> Self {
        let part = |component: usize| {
            let shape = |row: &CellRow, j: usize| {
                let of = if row.folded { folded_traction_shape } else { traction_shape };
                of(grid, component, row.m, j)
            };
            // Sines and cosines of waves between the sides, and sines less their mean.
            let is_cosine = (component == 1) == (grid.waves().sides == Sides::Supported);
            let is_even = |m: usize| m.is_multiple_of(2) == is_cosine;
            WaveTransform::with_shapes([grid.elements(), columns, grid.across], rows, shape, is_even).into()
        };
        Self { parts: std::array::from_fn(part) }
    }
}

impl<R: WaveNumber, const C: usize> ComponentTransforms<R, C> {
    pub(crate) fn cells(&self) -> usize {
        self.parts[0].transform.cells()
    }

    pub(crate) fn waves(&self) -> usize {
        self.parts[0].spectrum.len()
    }

    /// Phase of each wave from one element to the next \[rad\].
    pub(crate) fn angles(&self) -> Vec<f64> {
        self.parts[0].transform.angles()
    }

    /// Work of one direction.
    pub(crate) fn work(&self) -> Work {
        self.parts[0].transform.work() * C as u64
    }

    pub(crate) fn spectra(&self) -> [&[Complex<R>]; C] {
        self.parts.each_ref().map(|part| part.spectrum.as_slice())
    }

    pub(crate) fn spectra_mut(&mut self) -> [&mut [Complex<R>]; C] {
        self.parts.each_mut().map(|part| part.spectrum.as_mut_slice())
    }

    /// Transforms the forces \[N\] on a window that begins with an element; their waves are the spectra.
    pub(crate) fn forward(&mut self, first_element: i64, forces: &[[f64; C]]) {
        self.parts.par_iter_mut().enumerate().for_each(|(component, ComponentField { transform, cells, spectrum })| {
            cells.iter_mut().zip(forces).for_each(|(cell, force)| *cell = force[component]);
            transform.forward(first_element, cells, spectrum);
        });
    }

    /// Adds the displacements \[m\] of the waves in the spectra to the cells of the window.
    pub(crate) fn add_inverse(&mut self, first_element: i64, out: &mut [[f64; C]]) {
        self.parts.par_iter_mut().for_each(|ComponentField { transform, cells, spectrum }| {
            cells.fill(0.0);
            transform.add_inverse(spectrum, first_element, cells);
        });
        for (component, part) in self.parts.iter().enumerate() {
            out.iter_mut().zip(&part.cells).for_each(|(out, cell)| out[component] += cell);
        }
    }
}
