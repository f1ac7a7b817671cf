//! State of a history.

use std::ops::Range;

use serde::{Deserialize, Serialize};

/// State of each kind of history; the same for any number of threads.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum HistoryState {
    /// State of [`super::DirectHistory`].
    Direct(DirectState),
    /// State of [`super::ModalHistory`].
    Modal(ModalState),
}

/// State of a [`super::DirectHistory`].
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct DirectState {
    pub(super) steps: u64,
    pub(super) forces: Vec<f64>,
    /// By row: first element, and the columns with force.
    pub(super) marks: Vec<(i64, Range<u32>)>,
}

/// State of a [`super::ModalHistory`].
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct ModalState {
    pub(super) instant: usize,
    /// By instant: elements in contact and their forces \[N\].
    pub(super) rows: Vec<Vec<(i64, f64)>>,
    /// Displacements by the forces up to the block before the last \[m\].
    pub(super) old: Vec<Vec<f64>>,
    /// The last pass: its rings, and the states of all poles.
    pub(super) rings: Vec<Vec<f64>>,
    pub(super) poles: Vec<Vec<f64>>,
}
