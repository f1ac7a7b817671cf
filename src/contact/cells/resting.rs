//! Contact of cells at rest on a smooth road (s -> 0): where an axle stands.

use super::instant::InstantCells;
use super::search::CellSearch;
use crate::contact::error::ContactError;
use crate::contact::geometry::Geometry;
use crate::contact::static_contact::{StaticContact, carrying};
use crate::scene::Axle;
use crate::tyre::influence::{CellInfluence, CellSums};

/// How exactly a load is met.
const LOAD_TOLERANCE: f64 = 1e-6;
/// How far cells may be from where they are required to be, relative to the indentation.
const TOLERANCE: f64 = 1e-9;

/// Cells at rest.
pub struct RestingCells<'a> {
    sums: &'a CellSums,
    /// Height of the tread above its middle by cell across \[m\].
    crown: &'a [f64],
}

impl<'a> RestingCells<'a> {
    /// Of a tyre's cells.
    pub fn new(sums: &'a CellSums, crown: &'a [f64]) -> Self {
        Self { sums, crown }
    }

    fn circumference(&self) -> f64 {
        self.sums.grid().waves().circumference
    }

    /// The contact that an axle has on a smooth road.
    ///
    /// # Errors
    /// [`ContactError::LoadNotReached`].
    pub fn under(&self, axle: &Axle) -> Result<StaticContact, ContactError> {
        match *axle {
            Axle::Load { load, .. } | Axle::Mass { load, .. } => {
                let mut window = Window::new(self, 4e-3);
                carrying(load, self.circumference(), LOAD_TOLERANCE, |indentation| {
                    Ok(self.at(indentation, &mut window).0)
                })
            }
            Axle::Indentation { indentation, .. } => Ok(self.at(indentation, &mut Window::new(self, indentation)).0),
        }
    }

    /// Contact and forces by cell, column by column, at an indentation \[m\].
    pub fn pressed(&self, indentation: f64) -> (StaticContact, Vec<f64>) {
        self.at(indentation, &mut Window::new(self, indentation))
    }

    fn at(&self, indentation: f64, window: &mut Window) -> (StaticContact, Vec<f64>) {
        if indentation > window.deepest {
            *window = Window::new(self, 2.0 * indentation);
        }
        let difference = 1e-4 * indentation;
        let below: f64 = window.forces(self.crown, indentation - difference).iter().sum();
        let forces = window.forces(self.crown, indentation).to_vec();
        let force: f64 = forces.iter().sum();
        let touched = forces.chunks(self.crown.len()).filter(|cells| cells.iter().any(|&force| force > 0.0)).count();
        let length = touched as f64 * self.sums.grid().length();
        (StaticContact { indentation, force, stiffness: (force - below) / difference, length }, forces)
    }
}

/// A window that holds every cell that can touch down to some depth.
struct Window {
    deepest: f64,
    geometry: Geometry,
    search: CellSearch,
    forces: Vec<f64>,
    required: Vec<f64>,
}

impl Window {
    fn new(cells: &RestingCells<'_>, deepest: f64) -> Self {
        let grid = cells.sums.grid();
        let circumference = cells.circumference();
        let reach = Geometry::half_chord(circumference / std::f64::consts::TAU, deepest) + 2.0 * grid.length();
        let geometry = Geometry::new(circumference, grid.elements(), 1, 0.0, reach);
        let CellInfluence { columns, across, toeplitz, hankel } = cells.sums.instant(0.0, geometry.columns);
        let search = CellSearch::new(InstantCells::new(columns, across, toeplitz, hankel), TOLERANCE);
        let zeros = || vec![0.0; columns * across];
        Self { deepest, geometry, search, forces: zeros(), required: zeros() }
    }

    fn forces(&mut self, crown: &[f64], indentation: f64) -> &[f64] {
        let first = self.geometry.first_element(0);
        for (element, required) in (first..).zip(self.required.chunks_exact_mut(crown.len())) {
            let rise = self.geometry.rise(self.geometry.position(element, 0));
            for (required, crown) in required.iter_mut().zip(crown) {
                *required = indentation - rise - crown;
            }
        }
        self.search.solve(&self.required, &mut self.forces);
        &self.forces
    }
}
