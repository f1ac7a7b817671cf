//! Power that the contact forces put into the tyre, from the run's own displacements.
//!
//! P_l = sum_e F_e v_e over the elements in contact. With backward differences v is the difference quotient of the rule itself, so that in the mean
//! P = sum_n Re(s H_n(s)) |F_n|^2 holds exactly with the rule's s. For the other rules the work of a step is (F_l + F_(l-1))/2 (u_l - u_(l-1)), or F_l (u_l - u_(l-1)) where the force is already
//! the mean over the step: right to second order.
//!
//! What limits the agreement with the power dissipated: the segments' window blurs Re(s H_n) by its own width, the tyre stores what it has not yet dissipated when the record ends, and
//! with rules other than backward differences both sides differ by the rule's error. The power is averaged with the square of the segments' window, so that the mean pattern, which has most
//! of it, is balanced without any of that. Measured, N = 128, 2.5 s: smooth road 2e-7, rough road 2e-5 (`bdf2`), 5e-6 (`bdf1`). With `tread = "uncoupled"` the contact's displacements are
//! not those of the tyre under its forces, and nothing is balanced.

use crate::numeric::{StateError, StateReader, StateWriter};
use crate::scene::TimeRule;

/// Displacements of the last steps.
#[derive(Clone, Debug)]
pub struct ContactPower {
    rule: TimeRule,
    time_step: f64,
    /// The last two steps, the latest first.
    earlier: [Window; 2],
}

/// A window of elements.
#[derive(Clone, Debug)]
struct Window {
    first: i64,
    displacement: Vec<f64>,
    force: Vec<f64>,
}

impl Window {
    /// A value by element; 0 outside.
    fn at(values: &[f64], first: i64, element: i64) -> f64 {
        usize::try_from(element - first).ok().and_then(|column| values.get(column)).copied().unwrap_or(0.0)
    }
}

impl ContactPower {
    /// Everything at rest, for windows of `columns`.
    pub fn new(rule: TimeRule, time_step: f64, columns: usize) -> Self {
        let window = Window { first: 0, displacement: vec![0.0; columns], force: vec![0.0; columns] };
        Self { rule, time_step, earlier: [window.clone(), window] }
    }

    /// The power in the step that ends with these forces \[N\] and displacements \[m\] of the elements from `first` on, in W. An element that was not in the window is taken as one that has not moved.
    pub fn push(&mut self, first: i64, forces: &[f64], displacement: &[f64]) -> f64 {
        let [last, before] = &self.earlier;
        let mut work = 0.0;
        for (column, (&force, &now)) in forces.iter().zip(displacement).enumerate() {
            let element = first + column as i64;
            let old_force = Window::at(&last.force, last.first, element);
            if force == 0.0 && old_force == 0.0 {
                continue;
            }
            let [one, two] = [last, before].map(|window| {
                let known = (window.first..window.first + window.displacement.len() as i64).contains(&element);
                if known { Window::at(&window.displacement, window.first, element) } else { now }
            });
            work += match self.rule {
                TimeRule::Bdf1 | TimeRule::Sdirk2 | TimeRule::Sdirk3 => force * (now - one),
                TimeRule::Bdf2 => force * (1.5 * now - 2.0 * one + 0.5 * two),
                TimeRule::Trapezoidal | TimeRule::FirstOrderHold => 0.5 * (force + old_force) * (now - one),
            };
        }
        self.earlier.swap(0, 1);
        let latest = &mut self.earlier[0];
        latest.first = first;
        latest.displacement.copy_from_slice(displacement);
        latest.force.copy_from_slice(forces);
        work / self.time_step
    }

    /// Takes the state down.
    pub fn save(&self, state: &mut StateWriter) {
        for window in &self.earlier {
            state.whole(window.first);
            state.numbers(&window.displacement);
            state.numbers(&window.force);
        }
    }

    /// Goes on from the state of an equal one.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        for window in &mut self.earlier {
            window.first = state.whole()?;
            state.numbers_into(&mut window.displacement)?;
            state.numbers_into(&mut window.force)?;
        }
        Ok(())
    }
}
