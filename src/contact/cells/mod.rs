//! Contact over the whole zone in three dimensions: cells (i, j) of a window, i along, j across.
//!
//! - [`instant`]: displacements by the forces on the cells at the same instant;
//! - [`blocks`]: how blocks of the tread yield by themselves;
//! - [`search`]: which cells touch, and with which forces.
//!
//! - [`wave_transform`]: between cells and waves; [`component_transforms`]: component by component;
//! - [`history`]: displacements by past forces, by poles, most of it found in the background (`waves`, `short_ring`);
//!   [`direct`]: as sums, the reference;
//! - [`resting`]: contact at rest; [`gaps`]: gaps under a tyre that stands on a road;
//! - [`zone`]: one instant, from the history to the forces;
//! - [`two_scales`]: the same where cells carry the tyre's waves and their sub-cells touch, by [`interpolation`]
//!   between both and by [`creep`] of the sub-cells.
//!
//! Values of cells are row-major, cell (i, j) at i x across + j; the window's move by whole columns is the caller's.
//!
//! A void in the tread is a cell that lies deeper than the others, and has all that they have. Tangential tractions
//! stand beside the normal ones as arrays of the same shape: waves are lists of (n, m) and weight whatever component
//! of C is asked for. A [`WaveHistory`](history::WaveHistory) belongs to one component, a
//! [`DirectCellHistory`](direct::DirectCellHistory) to any number of them.

mod along_ring;
mod block_shares;
pub(crate) mod blocks;
pub(crate) mod component_transforms;
mod creep;
pub(crate) mod direct;
mod fewer_poles;
pub(in crate::contact) mod filter;
pub(crate) mod gaps;
mod gradients;
pub(crate) mod history;
pub(crate) mod instant;
pub(crate) mod interpolation;
mod product;
mod proportioning;
pub(crate) mod resting;
pub(in crate::contact) mod ring_waves;
pub(crate) mod search;
pub(crate) mod short_ring;
mod transform;
pub(crate) mod two_scales;
pub(crate) mod wave_transform;
mod waves;
pub(crate) mod zone;

pub use instant::InstantCells;
pub(crate) use product::CellProduct;
pub(crate) use search::{CellSearch, SINGLE};
pub(crate) use zone::{CellHistory, CellZone};
#[cfg(test)]
mod tests;
#[cfg(test)]
mod turning_tests;
