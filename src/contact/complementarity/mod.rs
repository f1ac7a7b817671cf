//! Which points touch, and with which forces: F >= 0, G0 F >= d, F.(G0 F - d) = 0.
//!
//! - `active_set`: displacements d prescribed;
//! - `local_set`: slices that yield by themselves;
//! - `pieces`: where in their curves they are;
//! - `search`: which of these methods;
//! - `sweeps`: the beginning of both;
//! - `residue`: where the corrections for a tyre that turns end, and why there are no forces;
//! - `factors`: cached factorisations, found by `pattern_index` or served by a `neighbour_set`;
//! - `ldlt`: how they are made, of whole matrices and of bands, in `tiles`.

pub(crate) mod active_set;
mod factors;
pub(crate) mod ldlt;
mod local_set;
mod neighbour_set;
mod pattern_index;
mod pieces;
mod residue;
mod search;
#[cfg(test)]
mod skew_tests;
mod sweeps;
mod tiles;

pub(crate) use active_set::{ActiveSet, Residuals};
pub(crate) use factors::largest_memory;
pub use factors::{FactorCache, FactorCounts};
pub(crate) use local_set::{LocalSet, SlicesUnder};
pub(crate) use search::Search;
pub use search::SliceLaw;
pub(crate) use sweeps::SearchCounts;
pub use tiles::{LINE, add_to_diagonal, packed_length};
