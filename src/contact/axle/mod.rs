//! Axle height: fixed, or found so that the mean force is the load.
//!
//! The static solution (s -> 0, smooth road) gives the start value; the height rises to it along a ramp. With a load,
//! the height is then corrected three times within the warm-up by (load - mean force)/stiffness and stays fixed
//! afterwards: the remaining error is reported as found, not hidden. An axle that has a mass moves on.

mod load_control;
mod moving;

pub use load_control::LoadControl;
pub(crate) use moving::LARGEST_RATE;
pub use moving::{MovingAxle, SprungMass};

use crate::storage::state::{Evolving, StateError, StateStream};

/// Indentation step by step.
#[derive(Clone, Debug)]
pub enum AxleHeight {
    /// Rises linearly to a fixed value.
    Fixed {
        /// Final indentation \[m\].
        indentation: f64,
        /// Steps of the ramp.
        ramp: f64,
    },
    /// Corrected over the warm-up towards a load.
    Loaded(LoadControl),
    /// A mass that the forces move.
    Moving(Box<MovingAxle>),
}

impl AxleHeight {
    /// Indentation at a step \[m\].
    pub fn indentation(&self, step: u64) -> f64 {
        self.between(step as f64)
    }

    /// Indentation at a time in steps \[m\]; before t = 0 as at t = 0.
    pub fn between(&self, steps: f64) -> f64 {
        let steps = steps.max(0.0);
        match self {
            Self::Fixed { indentation, ramp } => {
                if steps < *ramp {
                    indentation * steps / ramp
                } else {
                    *indentation
                }
            }
            Self::Loaded(control) => control.indentation(steps),
            Self::Moving(axle) => axle.between(steps),
        }
    }

    /// Records the force of a step \[N\]: it corrects a loaded axle and moves one that has a mass.
    pub fn observe(&mut self, step: u64, force: f64) {
        match self {
            Self::Fixed { .. } => {}
            Self::Loaded(control) => control.observe(step, force),
            Self::Moving(axle) => axle.observe(step, force),
        }
    }
}

impl Evolving for AxleHeight {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        match self {
            Self::Fixed { .. } => Ok(()),
            Self::Loaded(control) => control.state(state),
            Self::Moving(axle) => axle.state(state),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::static_contact::StaticContact;

    #[test]
    fn a_turn_of_no_length_is_a_step_at_every_stage() {
        let start = StaticContact { indentation: 0.01, force: 4000.0, stiffness: 3e5, length: 0.08 };
        let mut height = AxleHeight::Loaded(LoadControl::new(4000.0, start, 36));
        for step in 0..40 {
            for node in [0.29, 0.5, 1.0] {
                let indentation = height.between(step as f64 - 1.0 + node);
                assert!(indentation.is_finite() && indentation >= 0.0, "step {step}: {indentation}");
            }
            height.observe(step, 3e5 * height.indentation(step));
        }
    }

    #[test]
    fn control_finds_the_load_from_a_wrong_stiffness() {
        let start = StaticContact { indentation: 0.01, force: 4000.0, stiffness: 3e5, length: 0.08 };
        let mut height = AxleHeight::Loaded(LoadControl::new(4000.0, start, 1000));
        let mut force = 0.0;
        for step in 0..1200 {
            force = 4.5e5 * (height.indentation(step) - 0.001);
            height.observe(step, force);
        }
        assert!((force - 4000.0).abs() < 1.0, "{force}");
    }
}
