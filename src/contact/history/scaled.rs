//! A history whose influence functions are scaled.

use super::PastForces;
use crate::counters::Meter;
use crate::numeric::{StateError, StateReader, StateWriter};

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
    fn displacement(&mut self, first_element: i64, out: &mut [f64], meter: &mut Meter) {
        self.history.displacement(first_element, out, meter);
        out.iter_mut().for_each(|displacement| *displacement *= self.scale);
    }

    fn push(&mut self, first_element: i64, forces: &[f64]) {
        self.history.push(first_element, forces);
    }

    fn save(&self, state: &mut StateWriter) {
        self.history.save(state);
    }

    fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        self.history.restore(state)
    }
}
