//! Work and memory of a road that is pressed in three dimensions.

use super::Plan;
use super::amounts::{Amounts, WorkPlace};
use super::unit::WorkUnit;
use crate::contact::pressed::strip::block_elements;
use crate::counters::Stage;
use crate::numeric::transform_multiply_adds;
use crate::road::Lattice;

/// Products with the influence between a block's cells for all of its approaches, with the work around them: an
/// estimate from the products of some blocks.
const PRODUCTS: f64 = 300.0;
/// Bytes of a block per cell: tables of products of many lengths, forces, displacements: an estimate from the memory of
/// runs with N = 256 to 1024.
const CELL_BYTES: f64 = 1200.0;

impl Plan {
    /// Number of elements whose curves a block gives, and of all that it presses.
    fn block_elements(&self) -> [f64; 2] {
        let tyre = &self.decisions.tyre;
        let thickness = tyre.layers.last().map_or(0.0, |tread| tread.thickness);
        let [inner, beyond] = block_elements(tyre.circumference, thickness, self.element);
        [inner as f64, (inner + 2 * beyond) as f64]
    }
}

impl Amounts {
    /// Adds the curves of `elements` elements of a road that is pressed.
    pub(super) fn pressed(&mut self, plan: &Plan, lattice: Lattice, elements: f64) {
        let [inner, all] = plan.block_elements();
        let cells = all * lattice.cells() as f64;
        let product = transform_multiply_adds(4 * cells as usize);
        let blocks = (elements / inner).ceil() + 1.0;
        self.add(Stage::Slices, WorkUnit::TransformMultiplyAdd, blocks * PRODUCTS * product, WorkPlace::Background);
        self.hold("a block of road that is pressed", CELL_BYTES * cells);
    }
}
