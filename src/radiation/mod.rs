//! Sound that a rigid body radiates over a rigid road when its surface vibrates, by boundary elements.
//!
//! A tyre's transfers, ready to be multiplied with its vibration: [`TransferProblem`] at one wavenumber, [`transfers`]
//! over a range of frequencies chosen adaptively. Any body and velocity: [`Problem`]. Reference command: [`cases`].
//!
//! - Time factor exp(+i w t), G = exp(-ikR)/(4 pi R), normals and v_n > 0 out of the body into the air, dp/dn =
//!   -i w rho v_n. The road z = 0 is rigid, by images. The air is inviscid.
//! - The total Green function G_N(y; r) of body and road for a point source at a receiver r takes the double layer
//!   alone: p/2 - int p dG/dn' dS' = p_incident. By reciprocity p(r) = i w rho int G_N(y; r) v_n(y) dS for any v_n.
//! - Axes: x fore and aft, y across (the axle), z up; the contact's centre is the origin.
//!
//! From the surface to the transfer: [`body`], its pieces as [`chart`]s, cut into [`elements`] by the [`mesh`]; the
//! [`kernel`] in lanes, [`near`] integrals, both put together by [`assembly`] for four blocks of [`parity`];
//! [`interior`] points against irregular frequencies; LU ([`factor`]); the boundary problem ([`solve`]) with its
//! [`cost`]; the [`transfer`] from a tread, and from the [`flank`]
//! beside it where that moves, too, its [`frequencies`]. Beside all that, in a second: [`draft`].
//!
//! How accurate (sphere and tyre body against independent values, the standing tyre against itself): 1e-5 at 10 nodes
//! per wavelength with 4 x 4 elements; the standing tyre's transfers 0.02 dB by default ([`Resolution::NODES`]).

pub mod assembly;
pub mod body;
pub mod cases;
pub mod chart;
pub mod cost;
pub mod draft;
pub mod elements;
pub mod error;
pub mod factor;
pub mod flank;
pub mod frequencies;
pub mod interior;
pub mod kernel;
pub mod mesh;
pub mod near;
pub mod parity;
pub mod solve;
#[cfg(test)]
mod tests;
pub mod transfer;

pub use body::{Body, Shape, Vector};
pub use cost::Cost;
pub use error::RadiationError;
pub use flank::Flank;
pub use frequencies::{
    FrequencyRange, FrequencyReport, FrequencyTransfers, Progress, SetUpCost, TransferSet, Watch, transfers,
};
pub use mesh::Resolution;
pub use parity::Block;
pub use solve::{Drive, Problem, Solution, SolveReport};
pub use transfer::{Transfer, TransferGrid, TransferProblem};
