//! Creep of a wheel that rolls freely: it follows the torque about the axle until that is 0 in the mean.
//!
//! ```text
//! d(xi)/dt = F/(K tau),      F = sum (F_x + x F_z/R)
//! ```
//!
//! with F the torque over the radius, forward as a force on the tyre, and K an estimate of the longitudinal stiffness
//! -dF/d(xi). A wheel of the inertia J = K tau R^2/V turns like that. So its creep varies little and slowly, and the
//! mean torque of a record of the length T is K tau (xi(T) - xi(0))/T. The time tau is one revolution, half of it until
//! the warm-up has ended: the force follows creep over a length that is shorter by far, at any speed.

use crate::contact::static_contact::StaticContact;
use crate::storage::state::evolving;

/// K over the load: tyres have between 8 and 40.
const STIFFNESS: f64 = 20.0;
/// Creep of free rolling over the deflection in radii, to begin with.
const OF_DEFLECTION: f64 = 1.0 / 3.0;
/// Speed at which the creep follows in the warm-up over that afterwards.
const FASTER: f64 = 2.0;

/// Creep that follows the torque.
#[derive(Clone, Debug)]
pub(crate) struct FreeCreep {
    creep: f64,
    /// Change in a step for a force \[1/N\].
    rate: f64,
    /// Steps of the warm-up.
    warm_up: u64,
}

impl FreeCreep {
    /// Creep of a wheel with the contact `at_rest`, `revolution` being steps to a revolution and `warm_up` those in
    /// the warm-up.
    pub(crate) fn new(at_rest: StaticContact, radius: f64, revolution: usize, warm_up: u64) -> Self {
        let rate = 1.0 / (STIFFNESS * at_rest.force * revolution as f64);
        Self { creep: OF_DEFLECTION * at_rest.indentation / radius, rate, warm_up }
    }

    /// Creep of the coming step.
    pub(crate) fn creep(&self) -> f64 {
        self.creep
    }

    /// Follows the torque over the radius in a step \[N\].
    pub(crate) fn follow(&mut self, step: u64, force: f64) {
        let faster = if step < self.warm_up { FASTER } else { 1.0 };
        self.creep += faster * self.rate * force;
    }
}

evolving!(FreeCreep: creep);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn creep_finds_a_mean_torque_of_0_for_stiff_and_soft_tyres() {
        let at_rest = StaticContact { indentation: 0.018, force: 3400.0, stiffness: 2e5, length: 0.1 };
        let (revolution, warm_up, steps) = (256, 1400, 14_000);
        for stiffness in [8.0, 20.0, 40.0] {
            let mut free = FreeCreep::new(at_rest, 0.3, revolution, warm_up);
            let (mut force, mut sum) = (0.0, 0.0);
            for step in 0..steps {
                // The force follows over a tenth of a revolution, beside that of a texture.
                let steady = 3400.0 * stiffness * (0.0173 - free.creep());
                force += (steady - force) / (0.1 * revolution as f64);
                let all = force + 80.0 * (0.7 * step as f64).sin() + 15.0 * (step as f64 / 97.0).cos();
                free.follow(step, all);
                sum += if step >= warm_up { all } else { 0.0 };
            }
            let mean = sum / (steps - warm_up) as f64;
            assert!((free.creep() - 0.0173).abs() < 3e-4, "{stiffness}: {}", free.creep());
            assert!(mean.abs() < 1e-3 * 0.9 * 3400.0, "{stiffness}: {mean}");
        }
    }
}
