//! The heights of a rigid body, and how exactly its contact is solved.

use super::convolution::Extent;
use crate::half_space::HalfSpaceError;

/// A body's height map over a rectangular grid, peaks pointing into the half-space.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// Heights \[m\], nx x ny row-major.
    pub heights: Vec<f64>,
    /// Rows and columns.
    pub extent: Extent,
    /// Spacing of the rows \[m\].
    pub dx: f64,
    /// Spacing of the columns \[m\].
    pub dy: f64,
}

impl HeightMap {
    /// Returns the highest height \[m\].
    pub(super) fn peak(&self) -> f64 {
        self.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Refuses an invalid map, and whatever else must be positive.
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

/// Ending of an iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndentationLimits {
    /// Largest violation of the contact conditions, relative to the penetration: |g| where p > 0 and -g elsewhere.
    pub tolerance: f64,
    /// Iterations on the finest grid.
    pub iterations: usize,
}

impl Default for IndentationLimits {
    /// Returns 1e-8, the precision of published comparisons; far fewer than 1000 iterations are ever needed.
    fn default() -> Self {
        Self { tolerance: 1e-8, iterations: 1000 }
    }
}
