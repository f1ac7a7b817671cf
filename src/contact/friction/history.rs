//! Methods to carry the past of tractions: as sums, the reference, or by poles.

use serde::{Deserialize, Serialize};

use super::modal::{TractionWaves, TractionWavesState};
use super::past::{TractionPast, TractionPastState};
use super::product::Vector;
use crate::counters::Work;
use crate::storage::state::StateError;

/// Past of tractions.
pub(crate) enum TractionHistory {
    /// Convolution sums over the forces of a limited memory.
    Direct(Box<TractionPast>),
    /// Poles in double precision.
    Modal(Box<TractionWaves<f64>>),
    /// Poles in single precision.
    Single(Box<TractionWaves<f32>>),
}

/// State of a [`TractionHistory`] between two steps.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) enum TractionHistoryState {
    /// State of sums.
    Direct(TractionPastState),
    /// State of poles.
    Modal(TractionWavesState),
}

impl TractionHistory {
    /// Work of a step.
    pub(crate) fn work(&self) -> Work {
        match self {
            Self::Direct(past) => past.work(),
            Self::Modal(past) => past.work(),
            Self::Single(past) => past.work(),
        }
    }

    /// Adds the displacements by past forces at the coming step \[m\].
    pub(crate) fn add_displacement(&mut self, first_element: i64, out: &mut [Vector]) {
        match self {
            Self::Direct(past) => past.add_displacement(first_element, out),
            Self::Modal(past) => past.add_displacement(first_element, out),
            Self::Single(past) => past.add_displacement(first_element, out),
        }
    }

    /// Takes the forces of the step \[N\]; returns whether there is room for all of them.
    pub(crate) fn push(&mut self, first_element: i64, forces: &[Vector]) -> bool {
        match self {
            Self::Direct(past) => {
                past.push(first_element, forces);
                true
            }
            Self::Modal(past) => past.push(first_element, forces),
            Self::Single(past) => past.push(first_element, forces),
        }
    }

    pub(crate) fn save(&self) -> TractionHistoryState {
        match self {
            Self::Direct(past) => TractionHistoryState::Direct(past.save()),
            Self::Modal(past) => TractionHistoryState::Modal(past.save()),
            Self::Single(past) => TractionHistoryState::Modal(past.save()),
        }
    }

    /// Continues from the state of an equal history.
    pub(crate) fn restore(&mut self, state: &TractionHistoryState) -> Result<(), StateError> {
        match (self, state) {
            (Self::Direct(past), TractionHistoryState::Direct(state)) => past.restore(state),
            (Self::Modal(past), TractionHistoryState::Modal(state)) => past.restore(state),
            (Self::Single(past), TractionHistoryState::Modal(state)) => past.restore(state),
            _ => Err(StateError::Value),
        }
    }
}
