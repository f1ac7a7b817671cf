//! Vibration in a plan: the rows on the velocities of belt and tread, sizes, and expected cost.

use crate::counters::{Counter, Stage};
use crate::plan::amounts::wavenumbers;
use crate::plan::decisions::{Decided, DecisionRow, given};
use crate::plan::settle::PlannedSetting;
use crate::plan::{Amounts, Plan, WorkPlace, WorkUnit};
use crate::response::vibration::{
    Across, ElementVelocities, ResolvedPower, ResolvedVelocity, SegmentLayout, VelocityTable, VibrationAccumulator,
    point_bytes,
};
use crate::scene::{Diagnostic, Effects, LoadedScene, Scene, SceneError, Switch, Vibration, Zone, short};
use crate::tyre::poles::expected_fit;
use crate::tyre::poles::lateral::{LateralFitOptions, lateral_terms};

/// Time of drawing a map over that of other plots (measured).
const MAP_PLOTS: f64 = 20.0;
/// Memory of the vibration over that of its segments: velocities, tables and pictures at the end (measured).
const VIBRATION_RESERVE: f64 = 1.8;
/// Most revolutions of the segments in which the power of all waves of cells is found: these waves are ten times as
/// many as those of the velocities. The error by the window falls with the square of the number of revolutions, as it
/// does for slices: 2e-3 of the power of a rough road at 2 of them, 3e-4 at 4.5 (N = 96, `sdirk2`).
const POWER_REVOLUTIONS: usize = 4;
/// Time of fitting one wave of a lateral number over that of a strip's sum over m (measured for cells' waves).
const WAVE_FIT: f64 = 0.25;

/// Segments of a run's vibration; phase and first position are set by the run.
#[derive(Clone, Debug, PartialEq)]
pub struct VibrationSegments {
    /// Segments of the velocities.
    pub velocities: SegmentLayout,
    /// Further segments of contact over cells.
    pub cells: Option<CellSegments>,
}

/// Vibration of contact over cells.
#[derive(Clone, Debug, PartialEq)]
pub struct CellSegments {
    /// Lateral numbers that contribute to the velocities, which are means across the strip.
    pub in_mean: Vec<usize>,
    /// Number of lateral waves that the run carries: there may be more than a machine can list.
    pub carried: usize,
    /// Segments of the power, to which all waves contribute.
    pub power: SegmentLayout,
}

impl Vibration {
    fn fields(&self) -> usize {
        [self.tread, self.belt, self.tangential].map(usize::from).iter().sum()
    }
}

impl Plan {
    /// Velocities to compute from the forces; `None` if none is requested.
    pub fn vibration(&self) -> Option<Vibration> {
        wanted(&self.scene)
    }

    /// Segments for a window of so many columns; `None` where the run is shorter than a revolution.
    #[doc(hidden)]
    pub fn vibration_segments(&self, vibration: &Vibration, columns: usize) -> Option<VibrationSegments> {
        let steps = self.steps - self.warm_up_steps;
        let revolution = self.steps_per_revolution() as u64;
        let revolutions = SegmentLayout::revolutions_for(vibration.segment, revolution, self.time_step, steps)?;
        let even = SegmentLayout { columns, ..self.segment_layout(revolutions) };
        if self.decisions.zone == Zone::Slices {
            return Some(VibrationSegments { velocities: even, cells: None });
        }
        let (grid, last) = (self.cell_grid(), self.last_lateral_number());
        let tolerance = vibration.lateral_tolerance.unwrap_or(Vibration::LATERAL_TOLERANCE);
        let in_mean = grid.numbers_in_mean(tolerance, last);
        let carried = last + 1 - grid.waves().first_lateral_number();
        let resolved = |components: usize, values: usize| Across::Resolved { components, values };
        let forces = if self.scene.has_tractions() { 3 } else { 1 };
        let velocities = SegmentLayout { across: resolved(forces * in_mean.len(), vibration.fields()), ..even };
        let revolutions = revolutions.min(POWER_REVOLUTIONS);
        let power = SegmentLayout { revolutions, across: resolved(carried, 1), ..even };
        Some(VibrationSegments { velocities, cells: Some(CellSegments { in_mean, carried, power }) })
    }

    /// Number of lateral waves that contribute to the velocities for forces on cells, as a choice.
    pub(super) fn waves_in_mean(&self) -> Option<PlannedSetting> {
        let vibration = self.vibration().filter(|_| self.decisions.zone == Zone::Cells)?;
        let cells = self.vibration_segments(&vibration, 1)?.cells?;
        Some(PlannedSetting {
            key: "outputs.vibration.lateral_tolerance",
            value: short(vibration.lateral_tolerance.unwrap_or(Vibration::LATERAL_TOLERANCE)),
            reason: format!(
                "means across the strip include {} of the {} waves across that the run resolves",
                cells.in_mean.len(),
                cells.carried
            ),
        })
    }

    /// Requirements on the models of single lateral numbers.
    pub(crate) fn lateral_fit(&self) -> LateralFitOptions {
        LateralFitOptions { fit: self.fit, aliases: self.scene.numerics.wavenumber_aliases }
    }
}

/// True if waves of both directions have separate values: for a tyre that turns, and for tangential forces, part of
/// whose response is odd in n.
pub(super) fn has_both_directions(plan: &Plan) -> bool {
    plan.decisions.tyre.turns() || plan.scene.has_tractions()
}

/// Refuses elements that the tyre does not have.
///
/// # Errors
/// [`SceneError::Invalid`].
pub(super) fn check_elements(loaded: &LoadedScene, scene: &Scene) -> Result<(), SceneError> {
    let count = scene.numerics.elements;
    let wanted = scene.outputs.vibration.iter().flat_map(|vibration| vibration.elements.iter().enumerate());
    let complain = |(index, element): (usize, &usize)| {
        let wrong = format!("the tyre has no element {element}: numerics.elements = {count}");
        let right = format!("write a whole number from 0 to {}", count.saturating_sub(1));
        loaded.complain(&format!("outputs.vibration.elements[{index}]"), wrong, right)
    };
    let diagnostics: Vec<Diagnostic> = wanted.filter(|(_, element)| **element >= count).map(complain).collect();
    if diagnostics.is_empty() { Ok(()) } else { Err(SceneError::invalid(diagnostics, 0)) }
}

pub(super) fn add_amounts(amounts: &mut Amounts, plan: &Plan) {
    let Some(vibration) = &plan.vibration() else { return };
    let scene = &plan.scene;
    // A run too short for it has none.
    let Some(segments) = plan.vibration_segments(vibration, amounts.expected.columns as usize) else { return };
    let layout = segments.velocities;
    let steps = (plan.steps - plan.warm_up_steps) as f64;
    let count = |layout: &SegmentLayout| (2.0 * steps / layout.length() as f64 - 1.0).max(1.0).floor();
    let unit = WorkUnit::VibrationMultiplyAdd;
    let wanted = vibration.fields();
    let mut multiply_adds = layout.multiply_adds();
    if !vibration.elements.is_empty() {
        multiply_adds += ElementVelocities::multiply_adds(&layout, wanted * vibration.elements.len());
    }
    amounts.add(Stage::Vibration, unit, count(&layout) * multiply_adds, WorkPlace::March);
    if let Some(cells) = segments.cells.as_ref().filter(|_| !plan.scene.has_tractions()) {
        let multiply_adds = count(&cells.power) * cells.power.multiply_adds();
        amounts.add(Stage::Vibration, unit, multiply_adds, WorkPlace::March);
    }
    let fields = wanted as f64;
    // Each field once for the spectra, once more for the points and for the exact transfer; a pair of poles counts as
    // one. For resolved forces all is computed before the first segment.
    let at_places = !(vibration.points.is_empty() && vibration.elements.is_empty());
    let times = match (&segments.cells, at_places) {
        (Some(_), _) => fields,
        (None, true) => 2.0 * fields + 1.0,
        (None, false) => fields + 1.0,
    };
    let turns = has_both_directions(plan);
    let parts = if turns { 2.0 } else { 1.0 };
    let times = parts * times;
    let poles = match &segments.cells {
        None => 0.5 * amounts.poles,
        Some(cells) => add_models(amounts, plan, cells.in_mean.len()),
    };
    let bins = (layout.stages() * layout.bins()) as f64;
    amounts.add(Stage::Vibration, WorkUnit::VibrationPole, times * poles * bins, WorkPlace::Before);
    if vibration.tangential {
        amounts.add(Stage::Influence, WorkUnit::TangentialPole, poles, WorkPlace::BeforeOnAll);
    }
    if scene.outputs.plots {
        // A map has a thousand times as much to draw as a spectrum.
        let maps = if vibration.map { 2.0 * fields * MAP_PLOTS } else { 0.0 };
        amounts.add(Stage::Response, WorkUnit::Plot, 1.0 + maps, WorkPlace::Before);
    }
    let evaluations = times * wavenumbers(scene) * bins * layout.components() as f64;
    amounts.count(Counter::VibrationEvaluations, evaluations);
    let held = point_bytes(&layout, wanted, vibration, turns);
    amounts.hold("forces and spectra of segments", VIBRATION_RESERVE * held);
    if plan.scene.has_tractions() {
        let tables = fields * (ResolvedVelocity::bytes(&layout, turns) + VelocityTable::bytes(&layout, turns));
        amounts.hold("transfers of tangential forces", tables);
    } else if let Some(CellSegments { power, .. }) = &segments.cells {
        let [waves, ..] = plan.expected_waves(amounts.expected.columns);
        let of_stages = (power.stages() * power.stages() * power.bins()) as f64;
        amounts.add(
            Stage::Vibration,
            WorkUnit::VibrationPole,
            parts * 0.5 * amounts.poles * of_stages,
            WorkPlace::Before,
        );
        amounts.count(Counter::VibrationEvaluations, parts * waves * of_stages);
        // Tables exist one after the other, unless places need them all.
        let double = if at_places { fields } else { 1.0 } * VelocityTable::bytes(&layout, turns);
        let of_power = ResolvedPower::bytes(power, waves, turns);
        let tables = fields * ResolvedVelocity::bytes(&layout, turns) + double + of_power;
        amounts.hold("transfers of the cells' waves", tables);
        amounts.hold("forces and spectra of the power", VibrationAccumulator::bytes(power, 0));
    }
}

/// Adds the models of so many lateral numbers; returns the number of their poles, a pair as one.
fn add_models(amounts: &mut Amounts, plan: &Plan, numbers: usize) -> f64 {
    let waves = wavenumbers(&plan.scene) * numbers as f64;
    let terms = lateral_terms(plan.scene.numerics.wavenumber_aliases) as f64 / lateral_terms(Some(1)) as f64;
    let growth = expected_fit::growth(plan.fit.tolerance, &plan.decisions.tyre);
    amounts.add(Stage::Fit, WorkUnit::Fit, WAVE_FIT * growth * terms * waves / 257.0, WorkPlace::BeforeOnAll);
    amounts.fit_memory_per_thread = amounts.fit_memory_per_thread.max(expected_fit::BYTES);
    let poles = plan.expected_poles_of_wave() * waves;
    amounts.hold("models of the lateral numbers", 24.0 * poles);
    0.5 * poles
}

/// A velocity's row, with its settings among the effects and the outputs.
macro_rules! row {
    ($title:literal, $short:literal, $effect:ident, $output:ident) => {
        DecisionRow {
            title: $title,
            short: $short,
            decide: |scene, _| velocity(scene, scene.effects.$effect, stringify!($effect), |wanted| wanted.$output),
            switch: Some(|scene, on| {
                scene.effects.$effect = if on { Switch::On } else { Switch::Off };
                want(scene, on, |vibration| &mut vibration.$output);
            }),
            of_cells: false,
        }
    };
}

/// Rows of tread, belt and tangential motion.
pub(super) static ROWS: [DecisionRow; 3] = [
    row!("tread vibration", "vibration", tread_vibration, tread),
    row!("belt vibration", "belt", belt_vibration, belt),
    row!("tangential motion", "tangential", tangential_motion, tangential),
];

/// Vibration that the outputs ask for; without outputs, the default for the effects that are on.
pub(super) fn wanted(scene: &Scene) -> Option<Vibration> {
    let Effects { tread_vibration, belt_vibration, tangential_motion, .. } = scene.effects;
    let [tread, belt, tangential] =
        [tread_vibration, belt_vibration, tangential_motion].map(|switch| switch == Switch::On);
    let asked_by_effects =
        || (tread || belt || tangential).then(|| Vibration { tread, belt, tangential, ..Vibration::default() });
    scene.outputs.vibration.clone().or_else(asked_by_effects)
}

fn velocity(scene: &Scene, switch: Switch, key: &str, field: fn(&Vibration) -> bool) -> Decided {
    let on = wanted(scene).as_ref().is_some_and(field);
    let asked = if on { "auto: outputs.vibration asks for it" } else { "auto: no output asks for it" };
    let reason = given(switch, key).unwrap_or_else(|| asked.to_owned());
    let form = if on { "per wavenumber, from the forces" } else { "" }.to_owned();
    Decided { on, form, reason }
}

/// Adds or removes a velocity; the settings go if none is left.
fn want(scene: &mut Scene, on: bool, field: fn(&mut Vibration) -> &mut bool) {
    let none = Vibration { tread: false, belt: false, tangential: false, ..Vibration::default() };
    let vibration = scene.outputs.vibration.get_or_insert(none);
    *field(vibration) = on;
    if !(vibration.tread || vibration.belt || vibration.tangential) {
        scene.outputs.vibration = None;
    }
}
