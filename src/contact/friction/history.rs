//! Methods to carry the past of tractions: as sums, the reference, or by poles.

use super::modal::TractionWaves;
use super::past::TractionPast;
use super::product::Vector;
use crate::counters::Work;
use crate::storage::state::{Evolving, StateError, StateStream};

/// Past of tractions.
pub(crate) enum TractionHistory {
    /// Convolution sums over the forces of a limited memory.
    Direct(Box<TractionPast>),
    /// Poles in double precision.
    Modal(Box<TractionWaves<f64>>),
    /// Poles in single precision.
    Single(Box<TractionWaves<f32>>),
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
}

impl Evolving for TractionHistory {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        match self {
            Self::Direct(past) => past.state(state),
            Self::Modal(past) => past.state(state),
            Self::Single(past) => past.state(state),
        }
    }
}
