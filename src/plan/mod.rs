//! The plan: a scene compiled, before any work, into what the run will do.
//!
//! 1. [`settle`]: what the scene leaves open, decided from its `fmax`, `preset` and `accuracy`: [`front`] is the table
//!    of accuracy against time, [`resolution`] makes elements and steps of it;
//! 2. [`decisions`]: physics and effects that are on, off or reduced, and why; every later stage asks them;
//! 3. sizes: time step, steps, lags; [`sound`] with its [`receivers`] and its transfer path;
//! 4. [`Amounts`]: work of each stage in units, memory by what holds it;
//! 5. [`Forecast`]: both on this machine, from costs of the units ([`WorkUnit`]) that were measured on it.
//!
//! The plan is data: it follows from the scene alone, without reading any other file, can be printed as a table or as
//! JSON, and the run takes its numbers from it. [`crate::planning`] makes it, since the effects take part.

pub(crate) mod amounts;
pub(crate) mod cells;
pub(crate) mod decisions;
pub(crate) mod feasible;
mod forecast;
mod foreseen;
pub(crate) mod front;
mod mesh_corrections;
pub(crate) mod meshes;
pub(crate) mod models;
pub(crate) mod overload;
pub(crate) mod receivers;
pub(crate) mod resolution;
mod sections;
mod segments;
pub(crate) mod settle;
mod slice_error;
mod smooth_contact;
pub(crate) mod sound;
pub(crate) mod stated;
#[cfg(test)]
mod tests;
pub(crate) mod unit;

pub(crate) use amounts::{Amounts, WorkPlace};
pub use decisions::Decisions;
pub(crate) use forecast::{Forecast, process_memory};
pub(crate) use mesh_corrections::MeshCorrections;
pub(crate) use unit::UnitCosts;
pub use unit::WorkUnit;

use std::sync::{Arc, OnceLock};

use crate::contact::ContactError;
use crate::contact::static_contact::StaticContact;
use crate::response::SliceErrors;
use crate::response::vibration::{Across, SegmentLayout};
use crate::road::{Lattice, RoadError};
use crate::scene::{Axle, History, Scene, Tread, Zone};
use crate::storage::Cache;
use crate::tyre::influence::Field;
use crate::tyre::poles::cache::key;
use crate::tyre::poles::{FitOptions, RationalModel};
use crate::tyre::tread_pattern::blocks::TreadBlocks;
use crate::tyre::tread_pattern::map::TreadMap;
use decisions::{tread_blocks, tread_map};
pub(crate) use resolution::fit_options;
use resolution::{Need, Resolution};
pub(crate) use segments::Segments;
pub(crate) use settle::PlannedSetting;
pub(crate) use smooth_contact::Expected;

/// Length of the segments of the averaged spectrum \[s\].
pub(crate) const SEGMENT: f64 = 0.5;
/// Part of the run in the force map, in contact lengths.
const LENGTHS_DRAWN: f64 = 6.0;
/// Lowest frequency at which the absolute levels of the flat plate are those of a tyre \[Hz\]; below, curvature
/// matters.
pub(crate) const PLATE_FROM: f64 = 400.0;

/// Plan of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The scene with every setting decided.
    pub scene: Scene,
    /// Decisions on the physics and the effects.
    pub(crate) decisions: Decisions,
    /// Settings that the scene left open, and the tension from the tyre's sidewalls beside that in use.
    pub(crate) choices: Vec<PlannedSetting>,
    /// Keys to which the scene gives other values than its preset or accuracy would, in words.
    pub(crate) overridden: Vec<String>,
    /// Rolling speed V \[m/s\].
    pub speed: f64,
    /// Rolling radius R = L/(2 pi) \[m\].
    pub radius: f64,
    /// Element length dx = L/N \[m\].
    pub element: f64,
    /// Time step dt = dx/(q V) \[s\].
    pub time_step: f64,
    /// Time steps of the warm-up.
    pub warm_up_steps: u64,
    /// All time steps, warm-up included.
    pub steps: u64,
    /// Highest frequency for which the settings are accurate \[Hz\], apart from the road's limit: `fmax`, or the limit
    /// of texture and rule.
    pub valid_to: f64,
    /// Lags of the history, lag 0 included.
    pub lags: usize,
    /// Displacement that the contact conditions are about.
    pub field: Field,
    /// Requirements of the fitted model, if one is needed.
    pub(crate) fit: FitOptions,
    /// Number of poles of the cached model; `None` if it still has to be fitted, or none is needed.
    pub(crate) cached_poles: Option<usize>,
    /// Number of poles of the cached models of cells; `None` as above.
    pub(crate) cached_cell_poles: Option<usize>,
    /// Errors of contact over slices on the scene's road, set once that is open.
    pub(crate) slice_errors: Option<SliceErrors>,
    /// Warnings about the scene's road, set once that is open.
    pub(crate) road_warnings: Vec<String>,
    /// Frequencies whose radiation is cached \[Hz\].
    pub(crate) stored_frequencies: Vec<f64>,
    /// Length of the window of reported forces over that of a rigid tyre's chord: 1, which no contact outgrows; tests
    /// make it less.
    pub(crate) reach: f64,
    /// Length of the window of cells over that of the reported forces: 1, and more once contact has reached its end.
    pub(crate) window: f64,
    /// Segments that are rolled side by side; `None` for a run in one piece.
    pub(crate) segments: Option<Segments>,
    /// Short runs over the scene's and the finer mesh that correct the levels; empty without `outputs.levels`.
    pub(crate) short_runs: Vec<Self>,
    /// Correction of the levels, set once those runs are done.
    pub(crate) corrections: Option<Arc<MeshCorrections>>,
    /// Where spectra keep the transforms of their segments, what the lengths of these are multiples of.
    pub(crate) kept_transforms: Option<usize>,
    /// Contact on a smooth road, computed at first use: nothing else in a plan takes as long.
    standing: OnceLock<Result<StaticContact, ContactError>>,
}

/// Highest frequency for which elements and time step are accurate \[Hz\]: `fmax`, or four elements to a texture
/// wavelength and the rule's rate within its tolerance.
fn valid_to(scene: &Scene) -> f64 {
    let Scene { tyre, rolling, numerics, .. } = scene;
    let (length, speed) = (tyre.circumference, rolling.speed());
    let given = Resolution { elements: numerics.elements, advance: numerics.advance() };
    let steps = given.steps_per_second(length, speed);
    let rule = numerics.time_rule.largest_angle(Need::RULE_ERROR) * steps / std::f64::consts::TAU;
    numerics.fmax.unwrap_or_else(|| rule.min(0.5 * given.texture_limit(length, speed)))
}

impl Plan {
    /// Number of steps in the force map, for a patch of the given length \[m\].
    pub(crate) fn steps_drawn(&self, length: f64) -> f64 {
        let span = self.scene.outputs.patch_span.unwrap_or(LENGTHS_DRAWN * length / self.speed);
        span / self.time_step
    }

    /// Steps in which the tyre turns once.
    pub(crate) fn steps_per_revolution(&self) -> usize {
        let numerics = &self.scene.numerics;
        numerics.advance().steps(numerics.elements)
    }

    /// Plan of a scene with every setting decided, regardless of the cache.
    pub(crate) fn decided(scene: &Scene, decisions: Decisions) -> Self {
        let Scene { tyre, rolling, numerics, contact, .. } = scene;
        let speed = rolling.speed();
        let element = tyre.circumference / numerics.elements as f64;
        let time_step = numerics.advance().time_step(element, speed);
        // Casts of huge values saturate; the memory estimate works in f64 and refuses them.
        let steps_of = |time: f64| (time / time_step).round();
        let warm_up_steps = steps_of(rolling.warm_up);
        let steps = warm_up_steps + steps_of(rolling.duration).max(1.0);
        let lags = (steps_of(numerics.memory) + 1.0).min(steps + 1.0).max(2.0);
        let field = contact_field(contact.tread);
        Self {
            scene: scene.clone(),
            decisions,
            choices: Vec::new(),
            overridden: Vec::new(),
            speed,
            radius: tyre.radius(),
            element,
            time_step,
            warm_up_steps: warm_up_steps as u64,
            steps: steps as u64,
            valid_to: valid_to(scene),
            lags: lags as usize,
            field,
            fit: fit_options(scene, field),
            cached_poles: None,
            cached_cell_poles: None,
            slice_errors: None,
            road_warnings: Vec::new(),
            stored_frequencies: Vec::new(),
            reach: 1.0,
            window: 1.0,
            segments: None,
            short_runs: Vec::new(),
            corrections: None,
            kept_transforms: None,
            standing: OnceLock::new(),
        }
    }

    /// Contact on a smooth road; `None` without a static solution.
    fn standing(&self) -> Option<StaticContact> {
        self.standing_or_error().as_ref().ok().copied()
    }

    /// Contact on a smooth road, or why there is none.
    fn standing_or_error(&self) -> &Result<StaticContact, ContactError> {
        self.standing.get_or_init(|| smooth_contact::standing(&self.decisions.tyre, &self.decisions.axle))
    }

    pub(crate) fn expected(&self) -> Expected {
        Expected::of(&self.scene, self.standing(), self.decisions.tyre.radius(), self.element)
    }

    /// Layout of segments of `revolutions` revolutions, for forces that are even across; the run sets columns, phase
    /// and first position.
    pub(crate) fn segment_layout(&self, revolutions: usize) -> SegmentLayout {
        let Scene { numerics, tyre, .. } = &self.scene;
        SegmentLayout {
            elements: numerics.elements,
            advance: numerics.advance(),
            revolutions,
            columns: 0,
            across: Across::Even,
            rule: numerics.time_rule,
            time_step: self.time_step,
            phase: 0,
            first_position: 0.0,
            circumference: tyre.circumference,
        }
    }

    /// Takes over the contact on a smooth road from another plan, if tyre and axle are the same: that is costly.
    #[must_use]
    pub(crate) fn standing_as(mut self, other: &Self) -> Self {
        if self.decisions.tyre == other.decisions.tyre && self.decisions.axle == other.decisions.axle {
            self.standing = OnceLock::from(other.standing_or_error().clone());
        }
        self
    }

    /// True if a fitted model is needed: by the recursion, or by an effect.
    pub(crate) fn needs_model(&self) -> bool {
        let wanted = self.scene.numerics.history == History::Modal || self.decisions.takes_models;
        wanted && self.decisions.zone == Zone::Slices
    }

    /// Lattice on which the run evaluates its road; reads the header of a grid's file.
    ///
    /// # Errors
    /// As [`Lattice::choose`].
    pub fn lattice(&self) -> Result<Lattice, RoadError> {
        let Scene { road, tyre, .. } = &self.scene;
        let Decisions { cells_across, cells_along, .. } = self.decisions;
        Lattice::choose(road, self.element, tyre.contact_width, cells_across, cells_along)
    }

    /// Map of the tread, if the contact law takes it into account.
    #[doc(hidden)]
    pub fn tread_map(&self) -> Option<TreadMap> {
        tread_map(&self.scene, &self.decisions)?.ok()
    }

    /// Map of the tread and the blocks with a separate compliance; `None` for a level tread.
    #[doc(hidden)]
    pub fn tread(&self) -> Option<(TreadMap, Option<TreadBlocks>)> {
        let map = self.tread_map().filter(|map| !map.is_level())?;
        let blocks = tread_blocks(&self.scene, &map);
        Some((map, blocks))
    }

    /// Ramp of an axle that holds a height, in steps; 0 for other axles.
    pub fn ramp_steps(&self) -> f64 {
        match self.scene.rolling.axle {
            Axle::Indentation { ramp, .. } => ramp / self.time_step,
            Axle::Load { .. } | Axle::Mass { .. } => 0.0,
        }
    }

    /// Notes for the user before the run: settings that were chosen, and effects that the run leaves out.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        let choice = |PlannedSetting { key, value, reason }: &PlannedSetting| format!("{key} = {value} ({reason})");
        self.choices.iter().map(choice).chain(self.decisions.notes.iter().cloned())
    }
}

/// Displacement that the contact conditions are about under a tread law.
fn contact_field(tread: Tread) -> Field {
    match tread {
        Tread::Elastic | Tread::Uncoupled => Field::Surface,
        Tread::Bedding => Field::UnderTread,
    }
}

/// Number of poles of the model that the user's cache holds for a plan; `None` if none is needed, cached, or usable.
pub(crate) fn cached_poles(plan: &Plan) -> Option<usize> {
    let key = key(&plan.decisions.tyre, &plan.fit).ok().filter(|_| plan.needs_model())?;
    let model: RationalModel = Cache::open().ok()?.load(&key).ok()??.ok()?;
    Some(model.order())
}

/// A number of bytes for people.
pub(crate) fn bytes(count: f64) -> String {
    match count {
        c if c < 1e3 => format!("{c:.0} B"),
        c if c < 1e6 => format!("{:.1} kB", c / 1e3),
        c if c < 1e9 => format!("{:.1} MB", c / 1e6),
        c if c < 1e12 => format!("{:.1} GB", c / 1e9),
        c => format!("{:.1e} GB", c / 1e9),
    }
}
