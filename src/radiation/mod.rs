//! Sound radiated by a rigid body that vibrates over a rigid road, by boundary elements.
//!
//! Time factor exp(+i w t), G = exp(-ikR)/(4 pi R), normals out of the body into the air.

pub mod assembly;
pub mod body;
pub mod cases;
pub mod chart;
pub mod cost;
pub mod elements;
pub mod error;
pub mod factor;
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
pub use frequencies::{FrequencyRange, FrequencyReport, FrequencyTransfers, Progress, TransferSet, Watch, transfers};
pub use mesh::Resolution;
pub use parity::Block;
pub use solve::{Drive, Problem, Solution, SolveReport};
pub use transfer::{Transfer, TransferGrid, TransferProblem};
