//! Pattern of the tread: how deep it lies below its uncut surface, cell by cell of the material, and which blocks its
//! cuts leave.
//!
//! - [`pitches`]: where the pitches begin, and the spectrum of one pulse to each;
//! - [`share`]: exact shares of void;
//! - `raster`: depths of a file;
//! - [`map`]: depths of cells;
//! - [`blocks`]: blocks between cuts, and the compliance of their mean pressure;
//! - [`block_window`]: those under a window of the tyre;
//! - [`squeeze`]: voids beside blocks, which take the volume that these yield.

pub(crate) mod block_window;
pub(crate) mod blocks;
pub(crate) mod map;
pub(crate) mod pitches;
mod raster;
pub(crate) mod share;
pub(crate) mod squeeze;

use thiserror::Error;

/// Fault of a pattern on the cells of a tyre: the key within `[tread_pattern]`, what is wrong and what would be right.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{wrong}")]
pub(crate) struct PatternFault {
    /// Key.
    pub key: String,
    /// Wrong.
    pub wrong: String,
    /// Right.
    pub right: String,
}

impl PatternFault {
    fn new(key: impl Into<String>, wrong: impl Into<String>, right: impl Into<String>) -> Self {
        Self { key: key.into(), wrong: wrong.into(), right: right.into() }
    }
}
