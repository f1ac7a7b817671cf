//! Pattern of the tread: its depth below the uncut surface, cell by cell of the material, and the blocks between its
//! cuts.
//!
//! - [`pitches`]: beginnings of the pitches, and the spectrum of one pulse per pitch;
//! - [`share`]: exact void ratios;
//! - `raster`: depths of a file;
//! - [`map`]: depths of cells;
//! - [`blocks`]: blocks between cuts, and the compliance of their mean pressure;
//! - [`block_window`]: those under a window of the tyre;
//! - [`squeeze`]: voids beside blocks, which take the volume that these displace.

pub(crate) mod block_window;
pub(crate) mod blocks;
pub(crate) mod map;
pub(crate) mod pitches;
mod raster;
pub(crate) mod share;
pub(crate) mod squeeze;

use thiserror::Error;

/// Fault of a pattern on the cells of a tyre: key within `[tread_pattern]`, fault and remedy.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{wrong}")]
pub(crate) struct PatternFault {
    /// Key within `[tread_pattern]`.
    pub key: String,
    /// Fault found, for the message.
    pub wrong: String,
    /// Remedy, for the message.
    pub right: String,
}

impl PatternFault {
    fn new(key: impl Into<String>, wrong: impl Into<String>, right: impl Into<String>) -> Self {
        Self { key: key.into(), wrong: wrong.into(), right: right.into() }
    }
}
