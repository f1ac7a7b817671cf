//! Influence functions.

mod bounded_sum;
pub mod convolution_quadrature;
pub mod folded_sum;
mod half_space_bands;
mod lane_sum;
pub mod mobility;
mod moments;

pub use folded_sum::{Field, InfluenceSum, InfluenceValue, Projection, SumAt, Truncation};
pub use lane_sum::FaceValues;
