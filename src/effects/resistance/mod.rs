//! Rolling resistance of a run: the mean power that the contact forces put into the tyre, over speed and mean force.
//!
//! The tyre dissipates what is put in, so this is the resistance by hysteresis of tread, belt and foundation, due to
//! the smooth road and to the texture alike. It needs no vibration: only the displacements of the window, at every
//! instant one product of the forces with the first weights. With `tread = "uncoupled"` the displacements are not those
//! of the tyre under the forces, and there is no rolling resistance.

use super::effect::{Effect, RunStart};
use super::error::RunError;
use super::observer::{EffectObserver, End, Found, Observer, Step};
use super::section::Figure;
use super::stored::Stored;
use crate::counters::{Job, Meter};
use crate::numeric::RunningMoments;
use crate::results::summary::RollingResistance;
use crate::scene::Tread;
use crate::storage::state::{StateError, StateStream};

pub(crate) struct ResistanceEffect;

impl Effect for ResistanceEffect {
    fn name(&self) -> &'static str {
        "resistance"
    }

    fn figures(&self, stored: &Stored) -> Vec<Figure> {
        let found = stored.summary.outcome.rolling_resistance.map(|resistance| resistance.coefficient);
        Figure::of("rolling resistance", "", found).into_iter().collect()
    }

    fn begin(&self, begin: &mut RunStart<'_>, _: &mut Job<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError> {
        if begin.plan.decisions.tread == Tread::Uncoupled {
            return Ok(None);
        }
        let [power, force] = Default::default();
        Ok(Some(Box::new(ResistanceObserver { power, force, speed: begin.plan.speed })))
    }
}

pub(crate) struct ResistanceObserver {
    /// Power after the warm-up \[W\].
    power: RunningMoments,
    /// Total force after the warm-up \[N\].
    force: RunningMoments,
    /// Rolling speed \[m/s\].
    speed: f64,
}

impl Observer for ResistanceObserver {
    fn needs_power(&self) -> bool {
        true
    }

    fn observe(&mut self, step: &Step<'_>, _: &mut Meter) -> Result<(), RunError> {
        if let Some(power) = step.power.filter(|_| step.counts) {
            self.power.push(power);
            self.force.push(step.total_force);
        }
        Ok(())
    }
}

impl EffectObserver for ResistanceObserver {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.power, &mut self.force])
    }

    fn report(&self, _: &End<'_>, found: &mut Found) {
        let means = self.power.mean().zip(self.force.mean().filter(|&force| force > 0.0));
        found.outcome.rolling_resistance = means.map(|(power, load)| {
            let force = power / self.speed;
            RollingResistance { coefficient: force / load, force, power }
        });
    }
}
