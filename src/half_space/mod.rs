//! Frictionless contact of a rigid body with an elastic half-space: influence of a loaded cell, rough contact.
//!
//! Knows no road and no tyre. Lengths in m, pressures in Pa; the modulus enters as E* = E/(1 - nu^2).

pub mod active_set;
pub mod convolution;
pub mod error;
mod gradients;
pub mod growing;
pub mod line;
pub mod love;
pub mod periodic;
#[cfg(test)]
pub(crate) mod reference;
pub mod rough;

pub use error::HalfSpaceError;
pub use growing::GrowingContact;
pub use line::LineInfluence;
pub use periodic::PeriodicContact;
