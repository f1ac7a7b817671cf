//! A history whose influence functions are scaled.

use super::{HistoryState, HistoryWork, PastForces};
use crate::counters::Clocks;
use crate::storage::StateError;

/// Another history with all displacements multiplied by a factor.
pub struct ScaledHistory {
    history: Box<dyn PastForces>,
    scale: f64,
}

impl ScaledHistory {
    /// `history` scaled; itself for a factor of 1.
    pub fn of(history: Box<dyn PastForces>, scale: f64) -> Box<dyn PastForces> {
        if (scale - 1.0).abs() > 0.0 { Box::new(Self { history, scale }) } else { history }
    }
}

impl PastForces for ScaledHistory {
    fn displacement(&mut self, first_element: i64, out: &mut [f64]) -> HistoryWork {
        let work = self.history.displacement(first_element, out);
        out.iter_mut().for_each(|displacement| *displacement *= self.scale);
        work
    }

    fn push(&mut self, first_element: i64, forces: &[f64]) {
        self.history.push(first_element, forces);
    }

    fn set_clocks(&mut self, clocks: Clocks) {
        self.history.set_clocks(clocks);
    }

    fn save(&self) -> HistoryState {
        self.history.save()
    }

    fn restore(&mut self, state: HistoryState) -> Result<(), StateError> {
        self.history.restore(state)
    }
}
