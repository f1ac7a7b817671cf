//! Numbers of the vibration.

use super::Plan;
use super::amounts::{Amounts, Place, wavenumbers};
use super::settle::Choice;
use super::unit::Unit;
use crate::counters::{Counter, Stage};
use crate::response::vibration::{
    Across, ElementVelocities, HeardPower, HeardVelocity, SegmentLayout, VelocityTable, VibrationAccumulator,
    point_bytes,
};
use crate::scene::{Scene, Vibration, Zone, short};
use crate::tyre::poles::expected_fit;
use crate::tyre::poles::lateral::{LateralFitOptions, lateral_terms};

/// Time of drawing a map over that of other plots (measured).
const MAP_PLOTS: f64 = 20.0;
/// Memory of the vibration over that of its segments: velocities, tables and pictures at the end (measured).
const VIBRATION_RESERVE: f64 = 1.8;
/// Revolutions of the segments in which the power of all waves of cells is found, at most: there are ten times as many
/// of them as are heard. What is blurred by the window falls with the square of their number, as it does for slices:
/// 2e-3 of the power of a rough road at 2 of them, 3e-4 at 4.5 (N = 96, `sdirk2`).
const POWER_REVOLUTIONS: usize = 4;
/// Time of fitting one wave of a lateral number over that of a strip's sum over m (measured for cells' waves).
const WAVE_FIT: f64 = 0.25;

/// The segments of a run's vibration; phase and first position are the run's to say.
#[derive(Clone, Debug, PartialEq)]
pub struct VibrationSegments {
    /// Segments of the velocities.
    pub velocities: SegmentLayout,
    /// Segments of contact over cells.
    pub cells: Option<CellSegments>,
}

/// Parts of the vibration of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct CellSegments {
    /// Lateral numbers that the velocities, means across the strip, hear.
    pub heard: Vec<usize>,
    /// How many the run carries: there may be more than a machine can list.
    pub carried: usize,
    /// Segments of the power, which all waves put in.
    pub power: SegmentLayout,
}

impl Vibration {
    /// Fields that are wanted.
    fn fields(&self) -> usize {
        [self.tread, self.belt, self.tangential].map(usize::from).iter().sum()
    }
}

impl Plan {
    /// Segments for a window of so many columns; `None` where the run is shorter than a revolution.
    pub fn vibration_segments(&self, vibration: &Vibration, columns: usize) -> Option<VibrationSegments> {
        let Scene { numerics, tyre, .. } = &self.scene;
        let (elements, substeps) = (numerics.elements, numerics.substeps);
        let steps = self.steps - self.warm_up_steps;
        let revolution = (elements * substeps) as u64;
        let revolutions = SegmentLayout::revolutions_for(vibration.segment, revolution, self.time_step, steps)?;
        let even = SegmentLayout {
            elements,
            substeps,
            revolutions,
            columns,
            across: Across::Even,
            rule: numerics.time_rule,
            time_step: self.time_step,
            phase: 0,
            first_position: 0.0,
            circumference: tyre.circumference,
        };
        if self.decisions.zone == Zone::Slices {
            return Some(VibrationSegments { velocities: even, cells: None });
        }
        let (grid, last) = (self.cell_grid(), self.last_lateral_number());
        let tolerance = vibration.lateral_tolerance.unwrap_or(Vibration::LATERAL_TOLERANCE);
        let heard = grid.heard_by_mean(tolerance, last);
        let carried = last + 1 - grid.waves().first_lateral_number();
        let resolved = |components: usize, kept: usize| Across::Resolved { components, kept };
        let velocities = SegmentLayout { across: resolved(heard.len(), vibration.fields()), ..even };
        let revolutions = revolutions.min(POWER_REVOLUTIONS);
        let power = SegmentLayout { revolutions, across: resolved(carried, 1), ..even };
        Some(VibrationSegments { velocities, cells: Some(CellSegments { heard, carried, power }) })
    }

    /// How many lateral waves are heard of forces on cells, told as what was chosen.
    pub(super) fn lateral_choices(&self) -> Vec<Choice> {
        let mut choices = Vec::new();
        if self.decisions.zone != Zone::Cells {
            return choices;
        }
        let asked = self.decisions.vibration.as_ref();
        let segments = asked.and_then(|vibration| Some((vibration, self.vibration_segments(vibration, 1)?.cells?)));
        if let Some((vibration, cells)) = segments {
            choices.push(Choice {
                key: "outputs.vibration.lateral_tolerance",
                value: short(vibration.lateral_tolerance.unwrap_or(Vibration::LATERAL_TOLERANCE)),
                reason: format!(
                    "means across the strip hear {} of the {} waves across that the run carries",
                    cells.heard.len(),
                    cells.carried
                ),
            });
        }
        if let Some(sound) = self.sound() {
            choices.push(Choice {
                key: "radiation.lateral_waves",
                value: sound.radiation.lateral_waves.to_string(),
                reason: format!("even waves across; with the odd ones between them {} radiate", sound.lateral),
            });
        }
        choices
    }

    /// Returns the requirements of the models of single lateral numbers.
    pub fn lateral_fit(&self) -> LateralFitOptions {
        LateralFitOptions { fit: self.fit, aliases: self.scene.numerics.wavenumber_aliases }
    }
}

impl Amounts {
    pub(super) fn vibration(&mut self, plan: &Plan, vibration: &Vibration) {
        let scene = &plan.scene;
        // A run too short for it has none.
        let Some(segments) = plan.vibration_segments(vibration, self.expected.columns as usize) else { return };
        let layout = segments.velocities;
        let steps = (plan.steps - plan.warm_up_steps) as f64;
        let count = |layout: &SegmentLayout| (2.0 * steps / layout.length() as f64 - 1.0).max(1.0).floor();
        let unit = Unit::VibrationMultiplyAdd;
        let wanted = vibration.fields();
        let mut multiply_adds = layout.multiply_adds();
        if !vibration.elements.is_empty() {
            multiply_adds += ElementVelocities::multiply_adds(&layout, wanted * vibration.elements.len());
        }
        self.add(Stage::Vibration, unit, count(&layout) * multiply_adds, Place::March);
        if let Some(cells) = &segments.cells {
            let multiply_adds = count(&cells.power) * cells.power.multiply_adds();
            self.add(Stage::Vibration, unit, multiply_adds, Place::March);
        }
        let fields = wanted as f64;
        // Each field once for the spectra, once more for the points and for the rule's own transfer; a pair of poles is
        // one. Of resolved forces all is known before the first segment.
        let at_places = !(vibration.points.is_empty() && vibration.elements.is_empty());
        let times = match (&segments.cells, at_places) {
            (Some(_), _) => fields,
            (None, true) => 2.0 * fields + 1.0,
            (None, false) => fields + 1.0,
        };
        // Even and odd parts of the waves of a tyre that turns.
        let turns = plan.decisions.tyre.turns();
        let parts = if turns { 2.0 } else { 1.0 };
        let times = parts * times;
        let poles = match &segments.cells {
            None => 0.5 * self.poles,
            Some(cells) => self.lateral_models(plan, cells.heard.len()),
        };
        let bins = (layout.stages() * layout.bins()) as f64;
        self.add(Stage::Vibration, Unit::VibrationPole, times * poles * bins, Place::Before);
        if vibration.tangential {
            self.add(Stage::Influence, Unit::TangentialPole, poles, Place::BeforeOnAll);
        }
        if scene.outputs.plots {
            // A map has a thousand times as much to draw as a spectrum has.
            let maps = if vibration.map { 2.0 * fields * MAP_PLOTS } else { 0.0 };
            self.add(Stage::Response, Unit::Plot, 1.0 + maps, Place::Before);
        }
        let evaluations = times * wavenumbers(scene) * bins * layout.components() as f64;
        self.count(Counter::VibrationEvaluations, evaluations);
        let held = point_bytes(&layout, wanted, vibration, turns);
        self.hold("forces and spectra of segments", VIBRATION_RESERVE * held);
        if let Some(CellSegments { power, .. }) = &segments.cells {
            let [waves, ..] = plan.expected_waves(self.expected.columns);
            let of_stages = (power.stages() * power.stages() * power.bins()) as f64;
            self.add(Stage::Vibration, Unit::VibrationPole, parts * 0.5 * self.poles * of_stages, Place::Before);
            self.count(Counter::VibrationEvaluations, parts * waves * of_stages);
            // One field's table after the other, unless places want them all.
            let double = if at_places { fields } else { 1.0 } * VelocityTable::bytes(&layout, turns);
            let of_power = HeardPower::bytes(power, waves, turns);
            let tables = fields * HeardVelocity::bytes(&layout, turns) + double + of_power;
            self.hold("transfers of the cells' waves", tables);
            self.hold("forces and spectra of the power", VibrationAccumulator::bytes(power, 0));
        }
    }

    /// Models of so many lateral numbers; their poles, pairs as one.
    fn lateral_models(&mut self, plan: &Plan, numbers: usize) -> f64 {
        let waves = wavenumbers(&plan.scene) * numbers as f64;
        let terms = lateral_terms(plan.scene.numerics.wavenumber_aliases) as f64 / lateral_terms(Some(1)) as f64;
        self.add(Stage::Fit, Unit::Fit, WAVE_FIT * terms * waves / 257.0, Place::BeforeOnAll);
        self.fit_memory_per_thread = self.fit_memory_per_thread.max(expected_fit::BYTES);
        let poles = plan.expected_poles_of_wave() * waves;
        self.hold("models of the lateral numbers", 24.0 * poles);
        0.5 * poles
    }
}
