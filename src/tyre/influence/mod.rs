//! Influence functions by wavenumber summation.
//!
//! [`kernel`]: the compliance of one wave (n, m, s); `projection`: what an element takes of it; [`folded_sum`]: ...

mod bounded_sum;
pub mod convolution_quadrature;
pub mod folded_sum;
mod half_space_bands;
mod half_space_tail;
pub(crate) mod kernel;
mod lane_sum;
pub mod mobility;
mod moments;
mod projection;

pub use folded_sum::{InfluenceSum, InfluenceValue, SumAt, Truncation};
pub use kernel::{Field, Waves};
pub use lane_sum::FaceValues;
pub use projection::Projection;
