//! The non-linear stiffness of road slices: what a cross-section of the road does to the tread pressed on it.

pub mod curve;

pub use curve::StiffnessCurve;
