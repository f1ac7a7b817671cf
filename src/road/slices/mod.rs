//! The non-linear stiffness of road slices: what the road under an element does to the tread pressed on it.

pub mod builder;
pub mod curve;
pub mod error;
mod half_space;
pub mod reduce;
pub mod statistics;
mod winkler;

pub use builder::{SliceBuilder, SliceScratch};
pub use curve::StiffnessCurve;
pub use error::SliceError;
pub use half_space::CELL_LENGTH;
