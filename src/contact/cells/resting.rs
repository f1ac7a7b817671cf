//! Contact of cells at rest on a smooth road (s -> 0): where an axle stands.

use std::iter::repeat;

use super::instant::InstantCells;
use super::search::CellSearch;
use crate::contact::error::ContactError;
use crate::contact::geometry::Geometry;
use crate::contact::static_contact::{StaticContact, carrying};
use crate::contact::tread::TreadSurface;
use crate::scene::Axle;
use crate::tyre::influence::CellSums;
use crate::tyre::tread_pattern::blocks::TreadBlocks;

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
    blocks: Option<TreadBlocks>,
    /// A window that holds every cell that can touch down to a depth, and that depth \[m\].
    window: PressedWindow,
    deepest: f64,
}

/// Cells of a window that are pressed on a road without a history.
pub(super) struct PressedWindow {
    pub(super) geometry: Geometry,
    pub(super) search: CellSearch,
    /// Required displacements, then forces of the last search, column by column.
    pub(super) required: Vec<f64>,
    pub(super) forces: Vec<f64>,
}

impl RestingCells {
    pub(crate) fn new(sums: CellSums, tread: TreadSurface, blocks: Option<TreadBlocks>) -> Self {
        let deepest = FIRST_DEPTH * radius(&sums);
        let window = window_to(&sums, blocks.as_ref(), deepest);
        Self { sums, tread, blocks, window, deepest }
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
        let Self { sums, tread, blocks, window, deepest } = self;
        if indentation > *deepest {
            *deepest = 2.0 * indentation;
            *window = window_to(sums, blocks.as_ref(), *deepest);
        }
        let difference = 1e-4 * indentation;
        let below: f64 = window.press(tread, 0, indentation - difference, &[]).iter().sum();
        let forces = window.press(tread, 0, indentation, &[]);
        let force: f64 = forces.iter().sum();
        let touched = forces.chunks(tread.across()).filter(|cells| cells.iter().any(|&force| force > 0.0)).count();
        let length = touched as f64 * sums.grid().length();
        (StaticContact { indentation, force, stiffness: (force - below) / difference, length }, forces)
    }
}

fn radius(sums: &CellSums) -> f64 {
    sums.grid().waves().circumference / std::f64::consts::TAU
}

/// A window that holds every cell that can touch down to a depth \[m\].
fn window_to(sums: &CellSums, blocks: Option<&TreadBlocks>, deepest: f64) -> PressedWindow {
    let reach = Geometry::half_chord(radius(sums), deepest) + 2.0 * sums.grid().length();
    PressedWindow::new(sums, blocks, 0.0, reach, TOLERANCE)
}

impl PressedWindow {
    /// A window that reaches so far from the contact's centre \[m\], with the compliance at a rate \[1/s\];
    /// `tolerance` relative to the indentation.
    pub(super) fn new(sums: &CellSums, blocks: Option<&TreadBlocks>, rate: f64, reach: f64, tolerance: f64) -> Self {
        let grid = sums.grid();
        let geometry = Geometry::new(grid.waves().circumference, grid.elements(), 1, 0.0, reach);
        let influence = sums.cached_instant(rate, geometry.columns);
        let zeros = vec![0.0; geometry.columns * grid.across];
        let search = CellSearch::new(InstantCells::on_blocks(influence, grid, blocks), tolerance);
        Self { geometry, search, required: zeros.clone(), forces: zeros }
    }

    /// Presses the cells on the road's heights \[m\] under the window, cell by cell, or on a smooth road without any;
    /// the axle is over the middle of the element `under`, at an indentation \[m\]. Returns the forces \[N\].
    pub(super) fn press(&mut self, tread: &TreadSurface, under: i64, indentation: f64, heights: &[f64]) -> &[f64] {
        let first = self.geometry.first_element(0);
        let mut heights = heights.iter().copied().chain(repeat(0.0));
        for (element, required) in (first..).zip(self.required.chunks_exact_mut(tread.across())) {
            let rise = self.geometry.rise(self.geometry.position(element, 0));
            let cells = required.iter_mut().zip(tread.row(element + under)).zip(&mut heights);
            cells.for_each(|((required, depth), height)| *required = indentation - rise - depth + height);
        }
        self.search.cells_mut().place(first + under);
        self.search.solve(&self.required, &mut self.forces);
        &self.forces
    }
}
