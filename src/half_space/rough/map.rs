//! Height map of a rigid body, and when its solution ends.

use super::convolution::Extent;
use crate::half_space::HalfSpaceError;

/// Height map of a body over a rectangular grid, positive into the half-space.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Heights \[m\], nx x ny row-major.
    pub heights: Vec<f64>,
    /// Rows (along x) and columns (along y).
    pub extent: Extent,
    /// Spacing of the rows \[m\].
    pub dx: f64,
    /// Spacing of the columns \[m\].
    pub dy: f64,
}

impl HeightMap {
    pub(super) fn peak(&self) -> f64 {
        self.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Refuses an invalid map, and any of the named `others` that is not positive and finite.
    pub(super) fn check(&self, others: &[(&'static str, f64)]) -> Result<(), HalfSpaceError> {
        let Extent { nx, ny } = self.extent;
        if self.heights.len() != nx * ny || self.heights.is_empty() {
            return Err(HalfSpaceError::Shape { rows: nx, columns: ny, found: self.heights.len() });
        }
        let cell = [("cell size dx", self.dx), ("cell size dy", self.dy)];
        if let Some(&(what, value)) = cell.iter().chain(others).find(|(_, value)| !(*value > 0.0 && value.is_finite()))
        {
            return Err(HalfSpaceError::NotPositive { what, value });
        }
        match self.heights.iter().position(|height| !height.is_finite()) {
            Some(place) => {
                Err(HalfSpaceError::Hole { row: place / ny, column: place % ny, value: self.heights[place] })
            }
            None => Ok(()),
        }
    }
}

/// When an iteration ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndentationLimits {
    /// Largest violation of the contact conditions, relative to the penetration: |g| where p > 0 and -g elsewhere.
    pub tolerance: f64,
    /// Most iterations on each grid.
    pub iterations: usize,
}

impl Default for IndentationLimits {
    /// 1e-8, the precision of published comparisons; far fewer than 1000 iterations are ever needed.
    fn default() -> Self {
        Self { tolerance: 1e-8, iterations: 1000 }
    }
}
