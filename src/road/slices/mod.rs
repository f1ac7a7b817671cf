//! The non-linear stiffness of road slices: what a cross-section of the road does to the tread pressed on it.

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
