//! Sound that a rigid body radiates over a rigid road when its surface vibrates, by boundary elements.
//!
//! A tyre's transfers, to be multiplied with its vibration: [`TransferProblem`] at one wavenumber, [`transfers`] over a
//! range of frequencies chosen adaptively. Any body and velocity: [`solve::RadiationProblem`]. Reference command:
//! [`cases`].
//!
//! - Time factor exp(+i w t), G = exp(-ikR)/(4 pi R), normals and v_n > 0 out of the body into the air, dp/dn =
//!   -i w rho v_n. The road z = 0 is rigid, by images. The air is inviscid.
//! - The total Green function G_N(y; r) of body and road for a point source at a receiver r needs the double layer
//!   alone: p/2 - int p dG/dn' dS' = p_incident. By reciprocity p(r) = i w rho int G_N(y; r) v_n(y) dS for any v_n.
//! - Axes: x fore and aft, y across (the axle), z up; the contact's centre is the origin.
//!
//! From the surface to the transfer: [`body`], its pieces as [`chart`]s, cut into [`elements`] by the [`mesh`]; the
//! [`kernel`] in lanes, [`near`] integrals, both put together by [`assembly`] for four blocks of [`parity`];
//! [`interior`] points against irregular frequencies; LU ([`factor`]); the boundary problem ([`solve`]) with its
//! [`cost`]; the [`transfer`] from a tread, and from the [`flank`] beside it where that moves, too, its
//! [`frequencies`], [`stored`] on disk. An approximation in a second: [`draft`]. The [`air`] by its temperature.
//!
//! Accuracy (sphere and tyre body against independent values, the standing tyre against itself): 1e-5 at 10 nodes per
//! wavelength with 4 x 4 elements; the standing tyre's transfers 0.02 dB by default ([`MeshResolution::NODES`]).

pub(crate) mod air;
pub(crate) mod assembly;
pub(crate) mod body;
pub(crate) mod cases;
pub(crate) mod chart;
pub(crate) mod cost;
pub(crate) mod draft;
pub(crate) mod elements;
pub(crate) mod error;
pub(crate) mod factor;
pub(crate) mod flank;
pub(crate) mod frequencies;
pub(crate) mod gap;
pub(crate) mod interior;
pub(crate) mod kernel;
pub(crate) mod mesh;
pub(crate) mod near;
pub(crate) mod parity;
pub(crate) mod solve;
pub(crate) mod stored;
#[cfg(test)]
mod tests;
pub(crate) mod transfer;

pub use air::Air;
pub use body::{BodyShape, RadiatingBody, Vector};
pub(crate) use cost::RadiationCost;
pub(crate) use error::RadiationError;
pub(crate) use flank::Flank;
pub(crate) use frequencies::{
    FrequencyRange, FrequencyReport, FrequencyTransfers, FrequencyWatch, SetUpCost, TransferSet, transfers,
};
pub use mesh::MeshResolution;
pub use parity::ParityBlock;
#[cfg(test)]
pub(crate) use solve::{Drive, RadiationProblem};
pub use transfer::{SurfaceTransfer, TransferGrid, TransferProblem};
