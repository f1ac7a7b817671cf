//! The non-linear stiffness of road slices: what the road under an element does to the tread pressed on it.
//!
//! A `builder` turns heights into a `curve` by one of the laws `winkler` and `half_space`, `reduce` omits breakpoints
//! within a tolerance, [`statistics`] has the spread of the curves of a road.

pub(crate) mod builder;
pub(crate) mod curve;
mod error;
mod half_space;
mod reduce;
pub(crate) mod statistics;
mod winkler;

pub(crate) use builder::{SliceBuilder, SliceScratch};
pub use curve::StiffnessCurve;
pub use error::SliceError;
pub(crate) use half_space::CELL_LENGTH;
