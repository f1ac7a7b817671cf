//! Contact over the whole zone in three dimensions: cells (i, j) of a window, i along, j across.
//!
//! - [`instant`]: what the forces on the cells displace at the same instant;
//! - [`search`]: which cells touch, and with which forces.
//!
//! Values of cells are row-major, cell (i, j) at i x across + j; the window's move by whole columns is the caller's.

mod element;
mod gradients;
pub mod instant;
mod product;
mod proportioning;
pub mod search;
mod transform;

pub use instant::InstantCells;
pub use search::{CellCounts, CellResiduals, CellSearch};
