//! Contact of cells at rest on a smooth road (s -> 0): where an axle stands.

use super::blocks::BlockTerm;
use super::instant::InstantCells;
use super::search::CellSearch;
use crate::contact::error::ContactError;
use crate::contact::geometry::Geometry;
use crate::contact::static_contact::{StaticContact, carrying};
use crate::contact::tread::TreadSurface;
use crate::scene::Axle;
use crate::tyre::influence::CellSums;
use crate::tyre::tread_pattern::blocks::Blocks;

/// Relative tolerance of the load.
const LOAD_TOLERANCE: f64 = 1e-6;
/// How far cells may be from where they are required to be, relative to the indentation.
const TOLERANCE: f64 = 1e-9;
/// Depth that the first window is made for, in radii: summing the influence between cells takes longer than searching
/// a window that is larger than necessary, and few tyres stand deeper.
const FIRST_DEPTH: f64 = 0.08;

/// Cells at rest, in a window that grows with their indentation.
pub(crate) struct RestingCells {
    sums: CellSums,
    /// The undeformed tread, its first element under the axle, and its blocks.
    tread: TreadSurface,
    blocks: Option<Blocks>,
    window: Window,
}

/// A window that holds every cell that can touch down to some depth.
struct Window {
    deepest: f64,
    geometry: Geometry,
    search: CellSearch,
    forces: Vec<f64>,
    required: Vec<f64>,
}

impl RestingCells {
    pub(crate) fn new(sums: CellSums, tread: TreadSurface, blocks: Option<Blocks>) -> Self {
        let window = Window::new(&sums, blocks.as_ref(), FIRST_DEPTH * radius(&sums));
        Self { sums, tread, blocks, window }
    }

    /// Contact under an axle on a smooth road.
    ///
    /// # Errors
    /// [`ContactError::LoadNotReached`].
    pub(crate) fn under(&mut self, axle: &Axle) -> Result<StaticContact, ContactError> {
        match *axle {
            Axle::Load { load, .. } | Axle::Mass { load, .. } => {
                let circumference = self.sums.grid().waves().circumference;
                carrying(load, circumference, LOAD_TOLERANCE, |indentation| Ok(self.pressed(indentation).0))
            }
            Axle::Indentation { indentation, .. } => Ok(self.pressed(indentation).0),
        }
    }

    /// Contact, and forces by cell, column by column \[N\], at an indentation \[m\].
    pub(crate) fn pressed(&mut self, indentation: f64) -> (StaticContact, &[f64]) {
        let Self { sums, tread, blocks, window } = self;
        if indentation > window.deepest {
            *window = Window::new(sums, blocks.as_ref(), 2.0 * indentation);
        }
        let difference = 1e-4 * indentation;
        let below: f64 = window.forces(tread, indentation - difference).iter().sum();
        let forces = window.forces(tread, indentation);
        let force: f64 = forces.iter().sum();
        let touched = forces.chunks(tread.across()).filter(|cells| cells.iter().any(|&force| force > 0.0)).count();
        let length = touched as f64 * sums.grid().length();
        (StaticContact { indentation, force, stiffness: (force - below) / difference, length }, forces)
    }
}

fn radius(sums: &CellSums) -> f64 {
    sums.grid().waves().circumference / std::f64::consts::TAU
}

impl Window {
    fn new(sums: &CellSums, blocks: Option<&Blocks>, deepest: f64) -> Self {
        let grid = sums.grid();
        let reach = Geometry::half_chord(radius(sums), deepest) + 2.0 * grid.length();
        let geometry = Geometry::new(grid.waves().circumference, grid.elements(), 1, 0.0, reach);
        let influence = sums.kept_instant(0.0, geometry.columns);
        let cells = geometry.columns * grid.across;
        let face = grid.length() * grid.pitch();
        let term = blocks.map(|blocks| BlockTerm::new(blocks, face, grid.across, cells));
        let search = CellSearch::new(InstantCells::new(influence).with_blocks(term), TOLERANCE);
        Self { deepest, geometry, search, forces: vec![0.0; cells], required: vec![0.0; cells] }
    }

    fn forces(&mut self, tread: &TreadSurface, indentation: f64) -> &[f64] {
        let first = self.geometry.first_element(0);
        for (element, required) in (first..).zip(self.required.chunks_exact_mut(tread.across())) {
            let rise = self.geometry.rise(self.geometry.position(element, 0));
            for (required, crown) in required.iter_mut().zip(tread.row(element)) {
                *required = indentation - rise - crown;
            }
        }
        self.search.cells_mut().place(first);
        self.search.solve(&self.required, &mut self.forces);
        &self.forces
    }
}
