//! Corrections of an axle's height within the warm-up until the mean force is the load.

use crate::contact::static_contact::StaticContact;
use crate::storage::state::{Evolving, StateError, StateStream, StateValue, ensure};

/// Height control towards a mean force.
#[derive(Clone, Debug)]
pub struct LoadControl {
    load: f64,
    stiffness: f64,
    /// Steps of the first ramp.
    pub(super) ramp: u64,
    /// Steps of a window between corrections.
    window: u64,
    from: f64,
    to: f64,
    /// Step at which the change from `from` to `to` begins, and its length in steps.
    turn: (u64, u64),
    sum: f64,
    count: u64,
    previous: Option<(f64, f64)>,
}

/// Corrections within the warm-up; one more window follows the last.
const CORRECTIONS: u64 = 3;

/// Part of the warm-up that the first ramp takes, as a fraction.
const RAMP: [u64; 2] = [3, 20];

impl LoadControl {
    /// Part of the warm-up between two corrections, a fraction.
    pub(crate) const WINDOW: f64 = (1.0 - RAMP[0] as f64 / RAMP[1] as f64) / (CORRECTIONS + 1) as f64;

    /// Control for a warm-up of `warm_up` steps towards a mean force of `load` \[N\], starting from the static
    /// solution.
    pub fn new(load: f64, start: StaticContact, warm_up: u64) -> Self {
        let ramp = warm_up * RAMP[0] / RAMP[1];
        Self {
            load,
            stiffness: start.stiffness,
            ramp,
            window: (warm_up - ramp) / (CORRECTIONS + 1),
            from: 0.0,
            to: start.indentation,
            turn: (0, ramp),
            sum: 0.0,
            count: 0,
            previous: None,
        }
    }

    /// Indentation at the end of the present ramp \[m\].
    pub(super) fn target(&self) -> f64 {
        self.to
    }

    pub(super) fn indentation(&self, steps: f64) -> f64 {
        let (begin, length) = self.turn;
        if steps >= (begin + length) as f64 {
            return self.to;
        }
        // A stage of the step in which a turn begins may lie before it, and a short warm-up has turns of no length.
        if steps <= begin as f64 {
            return self.from;
        }
        self.from + (self.to - self.from) * (steps - begin as f64) / length as f64
    }

    pub(super) fn observe(&mut self, step: u64, force: f64) {
        if self.window == 0 || step < self.ramp {
            return;
        }
        let (window, within) = ((step - self.ramp) / self.window, (step - self.ramp) % self.window);
        if window >= CORRECTIONS {
            return;
        }
        // The first part of a window is left to settle.
        if within * 5 >= self.window * 2 {
            self.sum += force;
            self.count += 1;
        }
        if within + 1 == self.window {
            let mean = self.sum / self.count.max(1) as f64;
            if let Some((height, force)) = self.previous {
                let secant = (mean - force) / (self.to - height);
                // A secant from two noisy means is trusted within a factor of two of the static stiffness.
                if secant.is_finite() && secant > 0.0 {
                    self.stiffness = secant.clamp(0.5 * self.stiffness, 2.0 * self.stiffness);
                }
            }
            self.previous = Some((self.to, mean));
            self.from = self.to;
            self.to += (self.load - mean) / self.stiffness;
            self.turn = (step + 1, self.window / 10);
            (self.sum, self.count) = (0.0, 0);
        }
    }
}

impl Evolving for LoadControl {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        let Self { stiffness, from, to, turn, sum, count, previous, .. } = self;
        state.all([stiffness, from, to, turn, sum, count, &mut StateValue(previous)])?;
        // It bounds the next one; 0: a spring that is not there.
        ensure(self.stiffness >= 0.0 && self.turn.0.checked_add(self.turn.1).is_some())
    }
}
