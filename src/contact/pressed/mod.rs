//! Slice curves of a road that is pressed as a whole, in three dimensions, by the flat tread: docs/theory.md 7.3.
//!
//! - [`flat_tread`]: the tyre's outermost layer on a rigid base, and displacements by forces on its cells and lines;
//! - [`yielding`]: by how much a slice yields under its force, as a concave curve, and as a curve of stiffness;
//! - [`press`]: a block of road pressed deeper and deeper;
//! - [`strip`]: the blocks of a road, slice by slice as the tyre reaches them, cached on disk.

pub(crate) mod flat_tread;
pub(crate) mod press;
pub(crate) mod strip;
#[cfg(test)]
mod tests;
pub(crate) mod yielding;

pub(crate) use strip::{CachedBlock, PressedRoad};
