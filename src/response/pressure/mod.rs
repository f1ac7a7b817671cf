//! Sound pressure at receivers, from the contact forces.
//!
//! With G(y; r) the pressure at a point y of the tread for a unit point source at the receiver r (road, body and all),
//! reciprocity gives the pressure at r for any motion of the tread, with v outwards:
//!
//! ```text
//! p(r, w) = i w rho Int G(y; r, w) v(y, w) dS
//! v(x, y, w) = -(i w - V cos(theta) d/dx) u,      theta = 2 pi x/L
//! u = (1/L) sum_n exp(i kx_n x) sum_m (e_m/B) a_m cos(ky_m y) C_nm(w - n Omega) F_n(w - n Omega)
//! F_n = sinc(kx_n dx/2) sum_c exp(-i kx_n x_c) F_c(w)
//! ```
//!
//! in the frame of the axle, in which F_c is the force at a place x_c of the contact window, e_m = 2 (1 for m = 0) and
//! a_m = sinc(ky_m b/2). All of it is linear in F_c and does not depend on time: a product over the wavenumbers n for
//! each bin, computed for many blocks of forces at once. Forces of cells are resolved into F_nm = sum_j s_m(y_j) F_nj,
//! which replace a_m F_n; among them are waves that are odd about mid-width, sin(ky_m y) there, which meet G's odd
//! part: they reach a receiver beside the tyre, which hears the tyre differently from either side. The frequency shift
//! is that of `vibration`.
//!
//! The air is at rest relative to the road: relative to the axle it runs back at the speed V, along the tread at V
//! cos(theta). Where the tread rests on the road, too, a texture that it has taken on moves no air, however fast it
//! goes by; at the top the air runs against the tread. With I_n = Int G exp(i kx_n x) dS the wave n contributes
//!
//! ```text
//! w I_n - (n Omega/2)(I_(n-1) + I_(n+1)) = (w - n Omega) I_n + n Omega Int G (1 - cos(theta)) exp(i kx_n x) dS
//! ```
//!
//! times its displacement. Air at rest beside the axle, w I_n, and air that turns with the tread, (w - n Omega) I_n,
//! are measures of the uncertainty. A static flattening radiates no sound in all three.
//!
//! n is signed throughout: for a tyre that turns, C_nm and C_-nm differ, one of waves that run forwards, the other of
//! those that run backwards.
//!
//! - [`path`]: body, waves and air between contact and receivers; [`set_up`]: G from the disk or by boundary elements,
//!   [`open_patch`]: under a patch with grooves or voids;
//! - [`model`]: the tyre and its forces; [`surface`]: G on the tread, and its integrals with the tread's waves;
//! - [`transfer`]: pressures from the spectra of forces, by way of `components`, for unit amplitude of each wavenumber,
//!   and `window`, from places to wavenumbers;
//! - [`shares`]: contributions of the waves and of the parts of the circumference;
//! - [`stream`]: forces, step by step, to pressures over time.
//!
//! Volumes of cells may be given in place of forces: a motion independent of the tyre's response, of material cells at
//! the material's rate, w - n Omega, whatever the air does. Each cell across meets the mean of G over its strip.
//!
//! Whole time steps are taken off the propagation delay r0/c from the contact to the receiver: a response then begins
//! with its force, however far the receiver. The forces of a Runge-Kutta rule's stages act at their times with
//! their weights, on the tyre itself (s = i w); those of a multistep rule act on the tyre as the rule sees it.

#[cfg(test)]
mod air_tests;
mod components;
#[cfg(test)]
mod flank_tests;
pub(crate) mod model;
pub(crate) mod open_patch;
pub(crate) mod path;
#[cfg(test)]
mod resolved_tests;
pub(crate) mod set_up;
pub(crate) mod shares;
#[cfg(test)]
mod squeeze_tests;
pub(crate) mod stream;
pub(crate) mod surface;
#[cfg(test)]
mod tests;
pub(crate) mod transfer;
mod window;

pub(crate) use model::PressureModel;
pub(crate) use path::TransferPath;
pub(crate) use shares::PressureShares;
pub(crate) use stream::{BlockPressures, PressureStream};
pub(crate) use surface::SurfaceGreen;
pub(crate) use transfer::PressureTransfers;
