//! Sidewalls as inflated arcs: the impedance that an arc of inextensible meridional cords gives the edge of the belt.
//!
//! - [`Arc`]: dimensions and properties of a sidewall;
//! - [`Relaxation`]: its losses, a function of s;
//! - `meridian`: its shape and tension under pressure and rotation;
//! - `edge`: from the six states along the arc to the impedance at its edge;
//! - `swept`: the volume that it sweeps, piece by piece;
//! - [`Sidewall`], [`SidewallAt`]: meridian and edge together, with all waves of one s at hand;
//! - [`cases`]: sidewalls in files of compliance cases.

mod arc;
pub(crate) mod cases;
mod edge;
mod meridian;
mod relaxation;
mod swept;
pub(crate) mod table;

pub use arc::Arc;
pub use edge::EdgeImpedance;
pub(crate) use edge::FreeEdgeImpedance;
pub(crate) use meridian::{EdgeStatics, Meridian};
pub use relaxation::Relaxation;
pub(crate) use table::{BothWays, Flow, Pieces, Sidewall, SidewallAt, table_bytes};
