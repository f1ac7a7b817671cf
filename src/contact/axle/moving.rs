//! An axle with a mass on a spring and a damper: its height z, the indentation of the rigid tyre, follows from the
//! force in the contact and feeds back into it,
//!
//! ```text
//! m z'' = load - F - k (z - z_rest) - c z'.
//! ```
//!
//! The axle is led along the ramp of the load control to its static height and set free there, at rest. The rest of the
//! spring is what the load control corrects over the warm-up, so that the mean force is the load; its stiffness is that
//! of tyre and spring in series, K k/(K + k). Without a spring there is nothing to correct: the mean force of a mass
//! that stays where it is is its load.
//!
//! Scheme: leapfrog (Hairer, Lubich & Wanner 2003, *Acta Numerica* 12, 399) with the damper at the mean of the
//! velocities on both sides,
//!
//! ```text
//! (v_(l+1/2) - v_(l-1/2))/dt = (load - F_l - k (z_l - z_rest) - c (v_(l+1/2) + v_(l-1/2))/2)/m,
//! z_(l+1) = z_l + dt v_(l+1/2):
//! ```
//!
//! second order, no numerical damping, one force a step, which is that of the step: z_l stands at the time at which it
//! acts. A multistep rule's acts at the step's end, the mean force of a Runge-Kutta rule in its middle; between these
//! times z goes on with the velocity there, v + dt/2 times the last acceleration, and jumps by no more than dt^2/4 of
//! a change of acceleration.
//!
//! It is stable for w dt < 2, w^2 = (K0 + k)/m with the stiffness K0 of the contact within a step. That is the
//! stiffness G0 gives, up to seven times as much for the fastest motions that a time rule knows; [`SprungMass::rate`]
//! above [`LARGEST_RATE`] is to be refused.

use super::load_control::LoadControl;
use crate::scene::Axle;
use crate::storage::state::{Evolving, StateError, StateStream};

/// Largest w dt with the stiffness of G0: below 2/sqrt(7), and with a phase error (w dt)^2/24 of at most 1 %.
pub(crate) const LARGEST_RATE: f64 = 0.5;

/// Mass, spring and damper of an axle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SprungMass {
    /// Load m g, spring's part included \[N\].
    pub load: f64,
    /// Mass m \[kg\].
    pub mass: f64,
    /// Stiffness k \[N/m\].
    pub stiffness: f64,
    /// Damping c \[N s/m\].
    pub damping: f64,
}

impl SprungMass {
    /// Sprung mass of an axle; `None` for one without a mass.
    pub(crate) fn of(axle: &Axle) -> Option<Self> {
        match *axle {
            Axle::Mass { load, mass, stiffness, damping, .. } => Some(Self { load, mass, stiffness, damping }),
            Axle::Load { .. } | Axle::Indentation { .. } => None,
        }
    }

    /// w dt with the spring and a contact of the given stiffness \[N/m\], or c dt/m if that is larger.
    pub fn rate(&self, contact_stiffness: f64, time_step: f64) -> f64 {
        let swinging = ((contact_stiffness + self.stiffness) / self.mass).sqrt();
        swinging.max(self.damping / self.mass) * time_step
    }

    /// Least mass \[kg\] with a rate of at most [`LARGEST_RATE`].
    pub(crate) fn least_mass(&self, contact_stiffness: f64, time_step: f64) -> f64 {
        let step = time_step / LARGEST_RATE;
        ((contact_stiffness + self.stiffness) * step * step).max(self.damping * step)
    }

    /// Force per change of the spring's rest, with a tyre of the given stiffness: K k/(K + k) \[N/m\].
    pub(crate) fn rest_stiffness(&self, tyre_stiffness: f64) -> f64 {
        tyre_stiffness * self.stiffness / (tyre_stiffness + self.stiffness)
    }
}

/// The axle's motion.
#[derive(Clone, Debug)]
pub struct MovingAxle {
    sprung: SprungMass,
    /// Ramp, then rest of the spring.
    rest: LoadControl,
    time_step: f64,
    /// How long before a step's end its force acts, in steps.
    lead: f64,
    /// Step whose force is the first that moves the axle.
    free: u64,
    /// Step whose force is awaited.
    next: u64,
    /// z at the time at which that force acts \[m\].
    height: f64,
    /// Velocity half a step before \[m/s\], and the acceleration that led to it \[m/s^2\].
    velocity: f64,
    acceleration: f64,
}

impl MovingAxle {
    /// Axle at rest, about to follow the ramp of `rest`; `lead` is how long before a step's end its force acts, in
    /// steps.
    pub fn new(sprung: SprungMass, rest: LoadControl, time_step: f64, lead: f64) -> Self {
        let (free, height) = (rest.ramp, rest.target());
        Self { sprung, rest, time_step, lead, free, next: free, height, velocity: 0.0, acceleration: 0.0 }
    }

    /// z at a time in steps, not before that of the previous force \[m\].
    pub fn between(&self, steps: f64) -> f64 {
        if steps <= self.free as f64 {
            return self.rest.indentation(steps.max(0.0));
        }
        let ahead = (steps - (self.next as f64 - self.lead)) * self.time_step;
        self.height + ahead * (self.velocity + 0.5 * self.time_step * self.acceleration)
    }

    /// Moves on under the force of a step \[N\].
    pub fn observe(&mut self, step: u64, force: f64) {
        if step < self.free {
            return;
        }
        let SprungMass { load, mass, stiffness, damping } = self.sprung;
        let rest = self.rest.indentation((step as f64 - self.lead).max(0.0));
        let pushed = (load - force - stiffness * (self.height - rest)) / mass;
        let velocity = if step == self.free {
            // At rest when set free: half a step to the first half.
            0.5 * self.time_step * pushed
        } else {
            let damped = 0.5 * damping * self.time_step / mass;
            (self.velocity * (1.0 - damped) + self.time_step * pushed) / (1.0 + damped)
        };
        self.acceleration = if step == self.free { pushed } else { (velocity - self.velocity) / self.time_step };
        self.velocity = velocity;
        self.height += self.time_step * velocity;
        self.next = step + 1;
        if stiffness > 0.0 {
            self.rest.observe(step, force);
        }
    }
}

impl Evolving for MovingAxle {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        let Self { rest, next, height, velocity, acceleration, .. } = self;
        state.all([rest, next, height, velocity, acceleration])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::static_contact::StaticContact;
    use crate::storage::state::SavedState;

    const STIFFNESS: f64 = 3e5;
    const LOAD: f64 = 3000.0;
    const MASS: f64 = 30.0;

    /// Axle that is set free after the steps of its ramp, `off` \[m\] below the height at which a spring of
    /// [`STIFFNESS`] carries the load.
    fn axle(stiffness: f64, damping: f64, off: f64, warm_up: u64, time_step: f64, lead: f64) -> MovingAxle {
        let sprung = SprungMass { load: LOAD, mass: MASS, stiffness, damping };
        let indentation = LOAD / STIFFNESS + off;
        let start =
            StaticContact { indentation, force: LOAD, stiffness: sprung.rest_stiffness(STIFFNESS), length: 0.1 };
        MovingAxle::new(sprung, LoadControl::new(LOAD, start, warm_up), time_step, lead)
    }

    /// Heights over the load's at the times of the forces \[m\], on a linear spring; the force is the mean over the
    /// step where it acts in its middle.
    fn swing(mut axle: MovingAxle, steps: u64) -> Vec<f64> {
        let mut heights = Vec::new();
        for step in 0..steps {
            let at = |steps: f64| axle.between(steps);
            let end = step as f64;
            // Simpson's rule over the step for a mean.
            let height = if axle.lead > 0.0 { (at(end - 1.0) + 4.0 * at(end - 0.5) + at(end)) / 6.0 } else { at(end) };
            heights.push(at(end - axle.lead) - LOAD / STIFFNESS);
            axle.observe(step, STIFFNESS * height);
        }
        heights
    }

    #[test]
    fn an_undamped_swing_is_steady_at_the_leapfrogs_frequency() {
        let (time_step, off) = (1e-3, 1e-3);
        let heights = swing(axle(0.0, 0.0, off, 0, time_step, 0.0), 200_000);
        let w = (STIFFNESS / MASS).sqrt();
        // Exactly: sin(w' dt/2) = w dt/2.
        let discrete = 2.0 / time_step * (0.5 * w * time_step).asin();
        for (step, height) in heights.iter().enumerate() {
            let exact = off * (discrete * step as f64 * time_step).cos();
            assert!((height - exact).abs() < 1e-9 * off * (1.0 + step as f64 / 10.0), "{step}: {height} {exact}");
        }
        let peak = |part: &[f64]| part.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        assert!((peak(&heights[199_000..]) / peak(&heights[..1000]) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_damped_swing_is_the_closed_form_to_second_order() {
        let (stiffness, damping, off, time) = (1e5, 900.0, 1e-3, 0.1);
        // The spring's rest is where the axle begins.
        let total = STIFFNESS + stiffness;
        let middle = stiffness * off / total;
        let (decay, w) = (0.5 * damping / MASS, (total / MASS).sqrt());
        let damped = (w * w - decay * decay).sqrt();
        let exact = |t: f64| {
            let (sin, cos) = (damped * t).sin_cos();
            middle + (off - middle) * (-decay * t).exp() * (cos + decay / damped * sin)
        };
        for lead in [0.0, 0.5] {
            let errors = [200_u64, 400, 800].map(|steps| {
                let time_step = time / steps as f64;
                let heights = swing(axle(stiffness, damping, off, 0, time_step, lead), steps);
                // Set free at step 0, the force of which acts `lead` before its end: that is t = 0.
                let error = |(step, height): (usize, &f64)| (height - exact(step as f64 * time_step)).abs() / off;
                heights.iter().enumerate().map(error).fold(0.0, f64::max)
            });
            println!("lead {lead}: errors {errors:.2?} of the amplitude");
            assert!(errors[2] < 1e-4, "{errors:?}");
            for pair in errors.windows(2) {
                assert!((3.6..4.4).contains(&(pair[0] / pair[1])), "lead {lead}: {errors:?}");
            }
        }
    }

    #[test]
    fn the_springs_rest_is_corrected_until_the_load_is_carried() {
        // Set for a tyre of 3e5 N/m; it has 2e5 and touches 1 mm later.
        for (stiffness, damping) in [(2e4, 1500.0), (3e5, 3000.0)] {
            let (time_step, warm_up) = (2e-4, 10_000);
            let mut axle = axle(stiffness, damping, 0.0, warm_up, time_step, 0.0);
            let mut force = 0.0;
            for step in 0..2 * warm_up {
                force = 2e5 * (axle.between(step as f64) - 0.001);
                axle.observe(step, force);
            }
            println!("k = {stiffness}: {force:.2} N");
            assert!((force - LOAD).abs() < 3.0, "{force}");
        }
        // Without a spring by itself.
        let mut axle = axle(0.0, 1500.0, 0.0, 10_000, 2e-4, 0.0);
        let mut force = 0.0;
        for step in 0..20_000 {
            force = 2e5 * (axle.between(step as f64) - 0.001);
            axle.observe(step, force);
        }
        assert!((force - LOAD).abs() < 1e-6, "{force}");
    }

    #[test]
    fn a_restored_axle_goes_on_in_the_same_bits() {
        let force = |height: f64, step: u64| 2e5 * height + 300.0 * (step as f64).sin();
        let go = |axle: &mut MovingAxle, steps: std::ops::Range<u64>| {
            let mut heights = Vec::new();
            for step in steps {
                let height = axle.between(step as f64);
                heights.push(height.to_bits());
                axle.observe(step, force(height, step));
            }
            heights
        };
        for cut in [50, 333, 900] {
            let mut whole = axle(2e4, 100.0, 0.0, 1000, 2e-4, 0.5);
            go(&mut whole, 0..cut);
            let mut restored = axle(2e4, 100.0, 0.0, 1000, 2e-4, 0.5);
            SavedState::of(&mut whole).unwrap().restore(&mut restored).unwrap();
            assert_eq!(go(&mut whole, cut..1500), go(&mut restored, cut..1500));
        }
    }

    #[test]
    fn the_least_mass_is_that_of_the_largest_rate() {
        for (stiffness, damping) in [(0.0, 0.0), (2e4, 10.0), (0.0, 1e5)] {
            let sprung = SprungMass { load: LOAD, mass: 1.0, stiffness, damping };
            let least = SprungMass { mass: sprung.least_mass(5e6, 1e-4), ..sprung };
            assert!((least.rate(5e6, 1e-4) / LARGEST_RATE - 1.0).abs() < 1e-12);
        }
    }
}
