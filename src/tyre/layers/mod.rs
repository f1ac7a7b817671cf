//! The layered plate: compliances C and D by wavenumber and s.
//!
//! - [`material`]: viscoelastic laws, moduli at s;
//! - [`layer`]: the elastic field in one layer, P-SV and SH, without overflow or cancellation;
//! - [`compliance`]: the stack: surface compliance C and transfers D in wavenumber space;
//! - [`curved`]: C and D of the same layers as a hollow cylinder, under inflation, over a cavity;
//! - [`lane_compliance`]: the same at several s in lockstep;
//! - [`surface_asymptote`]: what C becomes at high wavenumbers;
//! - [`cases`]: files of wavenumbers and s in, C and D out.

pub mod cases;
pub mod compliance;
pub mod curved;
pub mod lane_compliance;
pub mod layer;
pub mod material;
pub mod matrix2;
mod scaled_series;
pub mod surface_asymptote;

pub use compliance::{Stack, operations};
