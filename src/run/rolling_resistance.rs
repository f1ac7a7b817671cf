//! Rolling resistance of a run: the mean power that the contact forces put into the tyre, over speed and mean force.
//!
//! The tyre dissipates what is put in, so this is the resistance by hysteresis of tread, belt and foundation, to the
//! smooth road and to the texture alike. It asks for no vibration: the displacements of the window, at every instant
//! one product of the forces with the first weights. With `tread = "uncoupled"` the displacements are not those of the
//! tyre under the forces, and there is none.

use serde::{Deserialize, Serialize};

use crate::contact::march::March;
use crate::numeric::RunningMoments;
use crate::plan::Plan;
use crate::response::vibration::{ContactPower, PowerState};
use crate::results::summary::RollingResistance;
use crate::scene::{TimeRule, Tread};
use crate::storage::StateError;

/// Takes in the power of every step after the warm-up.
pub struct PowerRecorder {
    power: ContactPower,
    /// Power \[W\].
    mean: RunningMoments,
    warm_up: u64,
    /// Rolling speed \[m/s\].
    speed: f64,
}

/// State of a [`PowerRecorder`].
#[derive(Deserialize, Serialize)]
pub(crate) struct ResistanceState {
    power: PowerState,
    mean: RunningMoments,
}

impl PowerRecorder {
    /// A recorder of a planned run, of so many points in the window; `None` where its displacements are not the tyre's.
    pub fn new(plan: &Plan, rule: TimeRule, points: usize) -> Option<Self> {
        (plan.decisions.tread != Tread::Uncoupled).then(|| Self {
            power: ContactPower::new(rule, plan.time_step, points),
            mean: RunningMoments::default(),
            warm_up: plan.warm_up_steps,
            speed: plan.speed,
        })
    }

    /// Takes in the step that a march has just done.
    pub fn push(&mut self, step: u64, march: &March) {
        // Backward differences look two steps back.
        if step + 2 < self.warm_up {
            return;
        }
        let footprint = march.footprint();
        let power = self.power.push(footprint.first_point(), footprint.forces(), footprint.displacements());
        if step >= self.warm_up {
            self.mean.push(power);
        }
    }

    /// Returns the resistance of the power so far; `None` before the end of the warm-up, and without a mean force
    /// \[N\].
    pub fn resistance(&self, mean_force: Option<f64>) -> Option<RollingResistance> {
        let (power, load) = self.mean.mean().zip(mean_force.filter(|&force| force > 0.0))?;
        let force = power / self.speed;
        Some(RollingResistance { coefficient: force / load, force, power })
    }

    /// Takes the state down.
    pub(crate) fn save(&self) -> ResistanceState {
        ResistanceState { power: self.power.save(), mean: self.mean.clone() }
    }

    /// Goes on from the state of a recorder of the same run.
    ///
    /// # Errors
    /// [`StateError`].
    pub(crate) fn restore(&mut self, state: ResistanceState) -> Result<(), StateError> {
        self.mean = state.mean;
        self.power.restore(state.power)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::run::Run;
    use crate::scene::{LoadedScene, PLATE};
    use crate::test_models::{self, edit};

    fn scene(changes: &[(&str, &str)]) -> LoadedScene {
        let small = [("numerics.elements", "128"), ("numerics.substeps", "4"), ("rolling.duration", "0.3")];
        test_models::scene(&edit(&edit(PLATE, &small), changes))
    }

    #[test]
    fn on_a_smooth_road_it_is_the_moment_of_the_forces() {
        for (rule, lag) in [("bdf2", 0.0), ("sdirk2", 0.5)] {
            let (found, expected, load) = smooth(rule, lag);
            // Elements that have just come down were above the plane two steps before; there are some 20 steps of
            // contact.
            assert!((found.power / expected - 1.0).abs() < 0.15, "{rule}: {} W for {expected} W", found.power);
            assert!((found.force * load / found.power - 1.0).abs() < 1e-12);
            assert!((0.001..0.1).contains(&found.coefficient), "{}", found.coefficient);
        }
    }

    /// Rolling resistance on a smooth road, the mean moment of its forces times the speed of rotation \[W\], and the
    /// speed; forces belong to a time `lag` steps before the end.
    fn smooth(rule: &str, lag: f64) -> (RollingResistance, f64, f64) {
        let rule = format!("\"{rule}\"");
        let loaded = scene(&[("road", "{ kind = \"smooth\" }"), ("numerics.time_rule", &rule)]);
        let plan = Plan::of(&loaded).unwrap();
        let mut run = Run::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap();
        let radius = plan.radius;
        // An element in contact follows the plane: it is pressed in by V x/sqrt(R^2 - x^2), x ahead of the axle.
        let mut work = RunningMoments::default();
        while let Some(step) = run.step().unwrap() {
            let march = &run.prepared.march;
            let number = march.next_step() - 1;
            let geometry = march.geometry();
            let power = march.footprint().mean().iter().enumerate().map(|(column, force)| {
                let x = geometry.position_between(step.first_element + column as i64, number as f64 - lag);
                force * plan.speed * x / (radius * radius - x * x).sqrt()
            });
            if number >= plan.warm_up_steps {
                work.push(power.sum());
            }
        }
        let found = run.finish().rolling_resistance.unwrap();
        (found, work.mean().unwrap(), plan.speed)
    }

    #[test]
    fn uncoupled_points_have_none() {
        let loaded = scene(&[("contact.tread", "\"uncoupled\"")]);
        assert!(PowerRecorder::new(&Plan::of(&loaded).unwrap(), TimeRule::Bdf2, 4).is_none());
    }
}
