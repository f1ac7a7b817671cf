//! Results of contact with friction: forces, moment and slip power over time, third octaves of the forces, numbers of
//! cells that stick, slip and are pulled by adhesion, cells' forces and slip at chosen instants, pictures of the last
//! one.

use super::channel::{Channel, Read, RowShape};
use super::effect::{Effect, RunStart};
use super::error::RunError;
use super::observer::{EffectObserver, End, Found, Observer, Step};
use super::section::{Figure, LevelTable, PageSection, ReportError, levels, pictures};
use super::stored::Stored;
use crate::contact::footprint::TangentialPart;
use crate::counters::{Job, Meter};
use crate::numeric::RunningMoments;
use crate::plan::{Plan, SEGMENT};
use crate::response::{LevelErrors, PowerSpectrum, SpectrumAccumulator};
use crate::results::files::ResultFiles;
use crate::results::spectra::{LOWEST_FREQUENCY, force_levels_csv};
use crate::results::summary::{FreeRolling, FrictionSummary};
use crate::scene::{Coefficient, LongitudinalCreep, TimeRule};
use crate::storage::state::{StateError, StateStream};

/// Largest mean torque of a freely rolling wheel, relative to that of full sliding.
const FREE_TORQUE: f64 = 1e-3;

pub(crate) struct FrictionEffect;

/// Tables of third octaves of the total tangential forces, by component; no error of theirs is stated.
static LEVELS: [LevelTable; 2] = [
    of_force("longitudinal_spectra.csv", "Longitudinal force level [dB re 1 N]"),
    of_force("lateral_spectra.csv", "Lateral force level [dB re 1 N]"),
];

const fn of_force(file: &'static str, quantity: &'static str) -> LevelTable {
    LevelTable { file, quantity, column: "level_db_re_1n", errors: |_| LevelErrors::default() }
}

/// A number of the tangential part of a step; 0 without one.
fn number(step: &Step<'_>, of: fn(&TangentialPart) -> f64) -> f64 {
    step.footprint.tangential().map_or(0.0, of)
}

/// A count of the tangential part of a step; 0 without one.
fn count(step: &Step<'_>, of: fn(&TangentialPart) -> usize) -> i64 {
    step.footprint.tangential().map_or(0, |part| of(part) as i64)
}

/// Writes a component of the cells' vectors of a step.
fn frame(step: &Step<'_>, out: &mut [f32], of: fn(&TangentialPart) -> &[[f64; 2]], component: usize) {
    let values = step.footprint.tangential().map_or(&[][..], of);
    out.iter_mut().zip(values).for_each(|(out, value)| *out = value[component] as f32);
}

const fn of_friction(name: &'static str, unit: &'static str, meaning: &'static str, read: Read) -> Channel {
    Channel::new(name, unit, meaning, read).only(has_friction)
}

/// A channel of cells at chosen instants.
const fn frames(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    read: fn(&Step<'_>, &mut [f32]),
) -> Channel {
    Channel::new(name, unit, meaning, Read::Single(read)).rows(RowShape::Points).at_instants(has_frames)
}

static CHANNELS: [Channel; 11] = [
    of_friction(
        "longitudinal_force",
        "N",
        "total longitudinal force on the tyre, forward",
        Read::Number(|step| number(step, |part| part.total[0])),
    ),
    of_friction(
        "lateral_force",
        "N",
        "total lateral force on the tyre, to the left",
        Read::Number(|step| number(step, |part| part.total[1])),
    ),
    of_friction(
        "aligning_moment",
        "N m",
        "moment of the tangential forces about the vertical under the axle, to the left",
        Read::Number(|step| number(step, |part| part.aligning_moment)),
    ),
    of_friction(
        "slip_power",
        "W",
        "power that friction dissipates",
        Read::Number(|step| number(step, |part| part.slip_power)),
    ),
    of_friction(
        "sticking_cells",
        "1",
        "cells that carry force and stick",
        Read::Count(|step| count(step, |part| part.sticking)),
    ),
    of_friction(
        "slipping_cells",
        "1",
        "cells that carry force and slip",
        Read::Count(|step| count(step, |part| part.slipping)),
    ),
    Channel::new("bonded_cells", "1", "cells that adhesion pulls", Read::Count(|step| count(step, |part| part.bonded)))
        .only(|plan| plan.scene.adhesion.is_some()),
    frames(
        "cells_longitudinal",
        "N",
        "longitudinal force of each cell in the window, at chosen instants",
        |step, out| frame(step, out, |part| &part.forces, 0),
    ),
    frames("cells_lateral", "N", "lateral force of each cell in the window, at chosen instants", |step, out| {
        frame(step, out, |part| &part.forces, 1)
    }),
    frames(
        "cells_longitudinal_slip",
        "m/s",
        "longitudinal slip of each pressed cell in the window, at chosen instants",
        |step, out| frame(step, out, |part| &part.slip, 0),
    ),
    frames(
        "cells_lateral_slip",
        "m/s",
        "lateral slip of each pressed cell in the window, at chosen instants",
        |step, out| frame(step, out, |part| &part.slip, 1),
    ),
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

    fn levels(&self) -> &'static [LevelTable] {
        &LEVELS
    }

    fn sections(&self, stored: &Stored, _: &[Stored]) -> Result<Vec<PageSection>, ReportError> {
        let named = [
            ["friction_stress.svg", "Tangential stress of every cell at the last instant."],
            ["friction_slip.svg", "Speed of slip of every cell at that instant; 0 where it sticks, or has no force."],
        ];
        let mut blocks = pictures(stored, &named)?;
        for LevelTable { quantity, .. } in &LEVELS {
            blocks.extend(levels(stored, quantity, quantity)?);
        }
        Ok(vec![PageSection { heading: "Friction", blocks }])
    }

    fn begin(&self, begin: &mut RunStart<'_>, _: &mut Job<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError> {
        let RunStart { plan, contact, in_memory, .. } = *begin;
        if !has_friction(plan) {
            return Ok(None);
        }
        let counted = (plan.steps - plan.warm_up_steps) as usize;
        let spectrum = in_memory || plan.scene.outputs.spectra;
        let accumulator = || SpectrumAccumulator::new(counted, plan.time_step, Some(SEGMENT)).ok();
        Ok(Some(Box::new(FrictionObserver {
            moments: Default::default(),
            speed: plan.speed,
            spectra: [(); 2].map(|()| spectrum.then(accumulator).flatten()),
            recording: (plan.scene.numerics.time_rule, plan.time_step),
            sliding: sliding(plan),
            across: contact.shape.across,
            size: contact.point_size,
        })))
    }
}

/// Coefficient of friction at slow slip, and rolling radius \[m\]; `None` for a wheel that does not roll freely.
fn sliding(plan: &Plan) -> Option<[f64; 2]> {
    let friction = plan.scene.friction.as_ref()?;
    let mu = match friction.coefficient() {
        Coefficient::Constant(mu) => mu,
        Coefficient::Falling(law) => law.slow,
    };
    (friction.creep.longitudinal == LongitudinalCreep::Free).then_some([mu, plan.radius])
}

pub(crate) struct FrictionObserver {
    /// After the warm-up: longitudinal and lateral force \[N\], aligning moment \[N m\], slip power \[W\], share of
    /// slipping cells, normal force \[N\], torque \[N m\], creep.
    moments: [RunningMoments; 8],
    /// Rolling speed \[m/s\].
    speed: f64,
    /// Spectra of both forces, where they are written and the run is long enough.
    spectra: [Option<SpectrumAccumulator>; 2],
    /// Time rule whose mean force over a step is recorded, and the time step \[s\].
    recording: (TimeRule, f64),
    /// See [`sliding`].
    sliding: Option<[f64; 2]>,
    across: usize,
    /// Length and width of a cell \[m\].
    size: [f64; 2],
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
            number(step, |part| part.torque),
            number(step, |part| part.creep),
        ];
        self.moments.iter_mut().zip(values).for_each(|(moments, value)| moments.push(value));
        for (spectrum, force) in self.spectra.iter_mut().zip(values) {
            if let Some(spectrum) = spectrum {
                spectrum.push(force);
            }
        }
        Ok(())
    }
}

impl EffectObserver for FrictionObserver {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.moments, &mut self.spectra])
    }

    fn report(&self, _: &End<'_>, found: &mut Found) {
        let means = self.moments.each_ref().map(RunningMoments::mean);
        let [
            Some(longitudinal),
            Some(lateral),
            Some(moment),
            Some(power),
            Some(slipping),
            Some(load),
            Some(torque),
            Some(creep),
        ] = means
        else {
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
            mean_creep: creep,
            mean_torque: torque,
            free: self.sliding.map(|[friction, radius]| {
                let relative_torque = torque / (friction * load * radius);
                let met = relative_torque.abs() <= FREE_TORQUE;
                FreeRolling { creep, relative_torque, tolerance: FREE_TORQUE, met }
            }),
        });
        let free = found.outcome.friction.and_then(|friction| friction.free).filter(|free| !free.met);
        found.warnings.extend(free.map(|free| free.to_string()));
    }
    fn write(&self, end: &End<'_>, files: &dyn ResultFiles, _: &mut Found, _: &mut Meter) -> Result<(), RunError> {
        let outputs = &end.loaded.scene.outputs;
        if outputs.spectra {
            for (table, spectrum) in LEVELS.iter().zip(&self.spectra) {
                if let Some(spectrum) = self.spectrum(spectrum.as_ref(), end.valid_to) {
                    let levels = spectrum.third_octaves(LOWEST_FREQUENCY, 1.0);
                    let standard_error = |band| spectrum.standard_error([band]);
                    files.write_text(
                        table.file,
                        &force_levels_csv(&levels, &LevelErrors::default(), standard_error, |_| None),
                    )?;
                }
            }
        }
        if let Some(part) = end.footprint.tangential().filter(|_| outputs.plots) {
            let sizes = |vectors: &[[f64; 2]], scale: f64| -> Vec<f64> {
                vectors.iter().map(|[x, y]| scale * x.hypot(*y)).collect()
            };
            let stress = sizes(&part.forces, 1e-3 / (self.size[0] * self.size[1]));
            for (named, values) in [
                (["friction_stress.svg", "Tangential stress at the end", "Stress [kPa]"], stress),
                (["friction_slip.svg", "Slip at the end", "Speed of slip [m/s]"], sizes(&part.slip, 1.0)),
            ] {
                end.draw_points(files, named, (&values, self.across), self.size)?;
            }
        }
        Ok(())
    }
}

impl FrictionObserver {
    /// Spectrum of a force, valid up to a frequency \[Hz\], of a run that is long enough.
    fn spectrum(&self, spectrum: Option<&SpectrumAccumulator>, valid_to: f64) -> Option<PowerSpectrum> {
        let (rule, time_step) = self.recording;
        let spectrum = spectrum?.clone().finish().ok()?.without_mean_of_steps(rule, time_step);
        Some(spectrum.valid_to(valid_to))
    }
}
