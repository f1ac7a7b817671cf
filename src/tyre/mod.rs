//! The tyre: a layered elastic plate under tension, its compliance and its influence functions.
//!
//! - [`material`]: viscoelastic laws;
//! - [`layer`]: the elastic field in one layer, P-SV and SH, without overflow or cancellation;
//! - [`compliance`]: the stack: surface compliance C and transfers D in wavenumber space;
//! - [`mod@tangential`]: how the surface moves sideways under normal forces;
//! - [`flops`]: what one evaluation of it takes;

pub mod cases;
pub mod compliance;
pub mod convolution_quadrature;
pub mod flops;
pub mod half_space_bands;
pub mod influence;
pub mod influence_batch;
mod influence_bounded;
pub mod influence_view;
pub mod lane_compliance;
pub mod layer;
pub mod material;
pub mod matrix2;
pub mod mobility;
pub mod moments;
pub mod rational;
mod scaled_series;
pub mod surface_asymptote;
mod tail_sum;
pub mod tangential;
