//! Frictionless contact of a rigid body with an elastic half-space. Knows no road and no tyre.
//!
//! `love` has the influence of a loaded cell. From it: `line`, a profile pushed into a row of cells, which
//! serves the road's slices; and `rough`, a whole height map, free or periodic.
//!
//! Lengths in m, pressures in Pa; the modulus enters as E* = E/(1 - nu^2).

mod error;
pub(crate) mod line;
pub(crate) mod love;
#[cfg(test)]
mod reference;
pub(crate) mod rough;

pub use error::HalfSpaceError;
pub(crate) use line::{GrowingContact, LineInfluence};
pub use rough::{Extent, HeightMap, Indentation, IndentationControl, IndentationLimits, indent};
