//! The layered plate: compliances C and D by wavenumber and s.
//!
//! - [`material`]: viscoelastic laws, moduli at s;
//! - [`layer`]: the elastic field in one layer, P-SV and SH, without overflow or cancellation;
//! - [`compliance`]: the stack: surface compliance C and transfers D in wavenumber space;
//! - `elasticity`: constants of isotropic layers, of cords in rubber, of orthotropic layers;
//! - `anisotropic`: the stack where not all layers are isotropic;
//! - [`curved`]: C and D of the same layers as a hollow cylinder, under inflation, over a cavity;
//! - [`cylinder`]: the same wave by wave, prepared once for all s;
//! - [`lateral_split`]: energy of a layer by its derivatives across, for motion of any shape across;
//! - [`rotation`]: growth and hoop stress of a tyre that turns;
//! - [`lane_compliance`]: the flat stack at several s in lockstep;
//! - [`surface_asymptote`]: the limit of C_zz at high wavenumbers, and of all components at real s;
//! - [`cases`]: files of wavenumbers and s in, C and D out.

mod anisotropic;
pub mod cases;
pub(crate) mod compliance;
mod coriolis;
pub(crate) mod curved;
pub(crate) mod cylinder;
mod elasticity;
mod faces;
pub(crate) mod lane_compliance;
pub(crate) mod lateral_split;
pub(crate) mod layer;
mod layer_modes;
mod layer_wave;
pub mod material;
pub(crate) mod matrix2;
mod radial_polynomials;
pub(crate) mod rotation;
mod scaled_series;
pub(crate) mod surface_asymptote;
mod triangle;

#[cfg(test)]
pub(crate) use compliance::Stack;
pub use compliance::operations;
