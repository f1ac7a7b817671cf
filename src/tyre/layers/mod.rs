//! The layered plate: compliances C and D by wavenumber and s.
//!
//! - [`material`]: viscoelastic laws, moduli at s;
//! - [`layer`]: the elastic field in one layer, P-SV and SH, without overflow or cancellation;
//! - [`compliance`]: the stack: surface compliance C and transfers D in wavenumber space;
//! - `elasticity`: constants of isotropic layers, of cords in rubber, of orthotropic layers;
//! - `anisotropic`: the stack where not all layers are isotropic;
//! - [`curved`]: C and D of the same layers as a hollow cylinder, under inflation, over a cavity;
//! - [`cylinder`]: the same wave by wave, prepared once for all s;
//! - [`rotation`]: growth and hoop stress of a tyre that turns;
//! - [`lane_compliance`]: the flat ones at several s in lockstep;
//! - [`surface_asymptote`]: what C becomes at high wavenumbers;
//! - [`cases`]: files of wavenumbers and s in, C and D out.

mod anisotropic;
pub mod cases;
pub mod compliance;
mod coriolis;
pub mod curved;
pub mod cylinder;
mod elasticity;
mod faces;
pub mod lane_compliance;
pub mod layer;
mod layer_modes;
pub mod material;
pub mod matrix2;
mod radial_polynomials;
pub mod rotation;
mod scaled_series;
pub mod surface_asymptote;
mod triangle;

pub use compliance::{Stack, operations};
