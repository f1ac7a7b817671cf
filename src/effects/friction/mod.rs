//! Tangential side of a contact with friction: forces, moment and slip power against time, counts of cells that stick,
//! slip and are pulled, and cells' forces and slip at chosen instants.

use super::channel::{Channel, Read, RowShape, RowTimes};
use super::effect::{Begin, Effect};
use super::error::RunError;
use super::observer::{EffectObserver, End, Found, Observer, Step};
use super::section::Figure;
use super::stored::Stored;
use crate::contact::footprint::TangentialPart;
use crate::counters::Meter;
use crate::numeric::RunningMoments;
use crate::plan::Plan;
use crate::results::summary::FrictionSummary;
use crate::storage::state::{StateError, StateReader, StateWriter};

/// Contact with friction.
pub(crate) struct FrictionEffect;

/// Returns the number of the tangential part of a step; 0 without one.
fn number(step: &Step<'_>, of: fn(&TangentialPart) -> f64) -> f64 {
    step.footprint.tangential().map_or(0.0, of)
}

/// Returns the count of the tangential part of a step; 0 without one.
fn count(step: &Step<'_>, of: fn(&TangentialPart) -> usize) -> i64 {
    step.footprint.tangential().map_or(0, |part| of(part) as i64)
}

/// Writes a component of the cells' vectors.
fn frame(out: &mut [f32], values: &[[f64; 2]], component: usize) {
    out.iter_mut().zip(values).for_each(|(out, value)| *out = value[component] as f32);
}

/// Channel of a frame of cells at chosen instants.
const FRAME: Channel =
    Channel { row: RowShape::Points, when: RowTimes::CellsEvery, wanted: has_frames, ..Channel::BASE };

static CHANNELS: [Channel; 11] = [
    Channel {
        name: "longitudinal_force",
        unit: "N",
        meaning: "total longitudinal force on the tyre, forward",
        wanted: has_friction,
        read: Read::Number(|step| number(step, |part| part.total[0])),
        ..Channel::BASE
    },
    Channel {
        name: "lateral_force",
        unit: "N",
        meaning: "total lateral force on the tyre, to the left",
        wanted: has_friction,
        read: Read::Number(|step| number(step, |part| part.total[1])),
        ..Channel::BASE
    },
    Channel {
        name: "aligning_moment",
        unit: "N m",
        meaning: "moment of the tangential forces about the vertical under the axle, to the left",
        wanted: has_friction,
        read: Read::Number(|step| number(step, |part| part.aligning_moment)),
        ..Channel::BASE
    },
    Channel {
        name: "slip_power",
        unit: "W",
        meaning: "power that friction dissipates",
        wanted: has_friction,
        read: Read::Number(|step| number(step, |part| part.slip_power)),
        ..Channel::BASE
    },
    Channel {
        name: "sticking_cells",
        unit: "1",
        meaning: "cells that carry force and stick",
        wanted: has_friction,
        read: Read::Count(|step| count(step, |part| part.sticking)),
        ..Channel::BASE
    },
    Channel {
        name: "slipping_cells",
        unit: "1",
        meaning: "cells that carry force and slip",
        wanted: has_friction,
        read: Read::Count(|step| count(step, |part| part.slipping)),
        ..Channel::BASE
    },
    Channel {
        name: "bonded_cells",
        unit: "1",
        meaning: "cells that adhesion pulls",
        wanted: |plan| plan.scene.adhesion.is_some(),
        read: Read::Count(|step| count(step, |part| part.bonded)),
        ..Channel::BASE
    },
    Channel {
        name: "cells_longitudinal",
        unit: "N",
        meaning: "longitudinal force of each cell in the window, at chosen instants",
        read: Read::Single(|step, out| {
            if let Some(part) = step.footprint.tangential() {
                frame(out, &part.forces, 0);
            }
        }),
        ..FRAME
    },
    Channel {
        name: "cells_lateral",
        unit: "N",
        meaning: "lateral force of each cell in the window, at chosen instants",
        read: Read::Single(|step, out| {
            if let Some(part) = step.footprint.tangential() {
                frame(out, &part.forces, 1);
            }
        }),
        ..FRAME
    },
    Channel {
        name: "cells_longitudinal_slip",
        unit: "m/s",
        meaning: "longitudinal slip of each pressed cell in the window, at chosen instants",
        read: Read::Single(|step, out| {
            if let Some(part) = step.footprint.tangential() {
                frame(out, &part.slip, 0);
            }
        }),
        ..FRAME
    },
    Channel {
        name: "cells_lateral_slip",
        unit: "m/s",
        meaning: "lateral slip of each pressed cell in the window, at chosen instants",
        read: Read::Single(|step, out| {
            if let Some(part) = step.footprint.tangential() {
                frame(out, &part.slip, 1);
            }
        }),
        ..FRAME
    },
];

fn has_friction(plan: &Plan) -> bool {
    plan.scene.friction.is_some()
}

fn has_frames(plan: &Plan) -> bool {
    has_friction(plan) && plan.scene.outputs.cells_every.is_some()
}

impl Effect for FrictionEffect {
    fn name(&self) -> &'static str {
        "friction"
    }

    fn channels(&self) -> &'static [Channel] {
        &CHANNELS
    }

    fn figures(&self, stored: &Stored) -> Vec<Figure> {
        let friction = stored.summary.outcome.friction;
        let figures = [
            Figure::of("longitudinal force", "N", friction.map(|friction| friction.mean_longitudinal_force)),
            Figure::of("lateral force", "N", friction.map(|friction| friction.mean_lateral_force)),
            Figure::of("slip power", "W", friction.map(|friction| friction.mean_slip_power)),
        ];
        figures.into_iter().flatten().collect()
    }

    fn begin(&self, begin: &mut Begin<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError> {
        let observer = FrictionObserver { moments: Default::default(), speed: begin.plan.speed };
        Ok(has_friction(begin.plan).then(|| Box::new(observer) as Box<dyn EffectObserver>))
    }
}

/// Observer of the tangential forces.
pub(crate) struct FrictionObserver {
    /// After the warm-up: longitudinal and lateral force, moment, slip power, share of slipping cells, normal force.
    moments: [RunningMoments; 6],
    /// Rolling speed \[m/s\].
    speed: f64,
}

impl Observer for FrictionObserver {
    fn observe(&mut self, step: &Step<'_>, _: &mut Meter) -> Result<(), RunError> {
        if !step.counts {
            return Ok(());
        }
        let pressed = count(step, |part| part.sticking + part.slipping).max(1) as f64;
        let values = [
            number(step, |part| part.total[0]),
            number(step, |part| part.total[1]),
            number(step, |part| part.aligning_moment),
            number(step, |part| part.slip_power),
            count(step, |part| part.slipping) as f64 / pressed,
            step.total_force,
        ];
        self.moments.iter_mut().zip(values).for_each(|(moments, value)| moments.push(value));
        Ok(())
    }
}

impl EffectObserver for FrictionObserver {
    fn save(&self, state: &mut StateWriter) -> Result<(), StateError> {
        state.put(&self.moments)
    }

    fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        self.moments = state.take()?;
        Ok(())
    }

    fn tell(&self, _: &End<'_>, found: &mut Found) {
        let means = self.moments.each_ref().map(RunningMoments::mean);
        let [Some(longitudinal), Some(lateral), Some(moment), Some(power), Some(slipping), Some(load)] = means else {
            return;
        };
        let resistance = if load > 0.0 { power / (self.speed * load) } else { 0.0 };
        found.outcome.friction = Some(FrictionSummary {
            mean_longitudinal_force: longitudinal,
            mean_lateral_force: lateral,
            mean_aligning_moment: moment,
            mean_slip_power: power,
            slipping_share: slipping,
            slip_resistance: resistance,
        });
    }
}
