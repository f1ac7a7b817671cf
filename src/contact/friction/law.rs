//! Coefficients of friction and bonds of cells from step to step: a cell is material and keeps its values.

use crate::scene::{Adhesion, Coefficient};
use crate::storage::state::evolving;

/// Law of all cells round the tyre, and their states.
pub(crate) struct CellLaw {
    coefficient: Coefficient,
    adhesion: Option<Adhesion>,
    time_step: f64,
    /// Coefficient of friction cell by cell; empty where it is constant.
    friction: Vec<f64>,
    /// Bonds cell by cell; empty without adhesion.
    bonded: Vec<bool>,
}

impl CellLaw {
    /// Law of `cells` cells round the tyre, at rest and without bonds.
    pub(crate) fn new(coefficient: Coefficient, adhesion: Option<Adhesion>, time_step: f64, cells: usize) -> Self {
        let friction = match coefficient {
            Coefficient::Constant(_) => Vec::new(),
            Coefficient::Falling(law) => vec![law.steady(0.0); cells],
        };
        let bonded = vec![false; if adhesion.is_some() { cells } else { 0 }];
        Self { coefficient, adhesion, time_step, friction, bonded }
    }

    /// Coefficient of friction of a cell in the coming step.
    pub(crate) fn friction(&self, cell: usize) -> f64 {
        match self.coefficient {
            Coefficient::Constant(mu) => mu,
            Coefficient::Falling(_) => self.friction[cell],
        }
    }

    /// Pull on a cell in the coming step \[Pa\]; 0 without a bond.
    pub(crate) fn pull(&self, cell: usize) -> f64 {
        self.adhesion.as_ref().filter(|_| self.bonded[cell]).map_or(0.0, |adhesion| adhesion.stress)
    }

    pub(crate) fn has_adhesion(&self) -> bool {
        self.adhesion.is_some()
    }

    /// Follows a step of a cell: the speed of its slip where it is pressed \[m/s\], and its gap \[m\].
    pub(crate) fn follow(&mut self, cell: usize, slip: Option<f64>, gap: f64) {
        if let (Coefficient::Falling(law), Some(friction)) = (&self.coefficient, self.friction.get_mut(cell)) {
            // A cell that leaves the road begins anew where it meets it again.
            *friction = slip.map_or(law.steady(0.0), |speed| law.after(*friction, speed, self.time_step));
        }
        if let (Some(adhesion), Some(bonded)) = (&self.adhesion, self.bonded.get_mut(cell)) {
            *bonded = gap <= adhesion.range;
        }
    }
}

evolving!(CellLaw: friction, bonded);
