//! Expected cost of a boundary problem, before it is set up.

use super::body::RadiatingBody;
use super::elements::padded;
use super::error::RadiationError;
use super::interior::interior_points;
use super::mesh::{MeshResolution, patches};
use super::parity::{MIRRORS, ParityBlock};

/// Cost of one wavenumber.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RadiationCost {
    /// Patches of the quarter.
    pub patches: usize,
    /// Unknown pressures of one block.
    pub unknowns: usize,
    /// Interior points of one block.
    pub interior_points: usize,
    /// Kernel evaluations of far pairs.
    pub far_evaluations: f64,
    /// Kernel evaluations of near pairs, estimated.
    pub near_evaluations: f64,
    /// Real operations of the factorisations of all blocks.
    pub factor_operations: f64,
    /// Peak memory \[bytes\].
    pub bytes: u64,
}

/// Near evaluations per unknown in the equations, as measured: 4000-5500 on a sealed tyre; with a gap up to 8000, and
/// the points at which transfers are evaluated add to them.
const NEAR_EVALUATIONS: f64 = 5e3;

impl RadiationCost {
    /// Expected cost of a body at a wavenumber \[rad/m\], with a mesh for `mesh_wavenumber` (the same, unless a
    /// velocity needs a finer one).
    ///
    /// # Errors
    /// As [`patches`], but not for too many of them.
    pub(crate) fn expected(
        body: &RadiatingBody,
        wavenumber: f64,
        mesh_wavenumber: f64,
        resolution: &MeshResolution,
        blocks: &[ParityBlock],
    ) -> Result<Self, RadiationError> {
        let patches = match patches(body, mesh_wavenumber, resolution) {
            Ok(made) => made.len(),
            // Too many to be made: a lower bound of their number.
            Err(RadiationError::Patches { patches, .. }) => patches,
            Err(error) => return Err(error),
        };
        let unknowns = patches * resolution.order * resolution.order;
        let interior_points = interior_points(body, wavenumber);
        let size = (unknowns + interior_points) as f64;
        let images = if body.on_road() { 2 * MIRRORS } else { MIRRORS };
        let rows = padded(unknowns + interior_points) as f64;
        let panel = rows * (resolution.order.pow(2) * blocks.len() * 16 + 2 * MIRRORS * 8) as f64;
        Ok(Self {
            patches,
            unknowns,
            interior_points,
            far_evaluations: images as f64 * size * unknowns as f64,
            near_evaluations: NEAR_EVALUATIONS * unknowns as f64,
            factor_operations: 8.0 / 3.0 * size.powi(3) * blocks.len() as f64,
            bytes: (16.0 * size * size * blocks.len() as f64 + 2.0 * panel) as u64,
        })
    }

    /// [`RadiationError::Memory`] if the problem needs more than `limit` bytes.
    pub(crate) fn check(&self, limit: u64) -> Result<(), RadiationError> {
        if self.bytes > limit {
            return Err(RadiationError::Memory { unknowns: self.unknowns, needed: self.bytes, limit });
        }
        Ok(())
    }
}
