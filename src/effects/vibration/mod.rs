//! Vibration of a run: taken step by step, written at the end by `results`.
//!
//! Without a request in the plan there is no observer, no table, and no model is retained.

mod answer;
mod planned;
mod resolved;
pub(crate) mod results;

use super::channel::{Channel, Read};
use super::effect::{Effect, RunStart};
use super::error::RunError;
use super::observer::{EffectObserver, End, Found, Observer, Step};
use super::section::{Figure, LevelTable, PageSection, ReportError, levels, pictures_of};
use super::stored::Stored;
use crate::counters::{Counter, Job, Meter, Stage, Work};
use crate::plan::decisions::DecisionRow;
use crate::plan::{Amounts, Plan, PlannedSetting, bytes};
use crate::response::vibration::{
    ElementVelocities, ResolvedQuantities, ResolvedVelocity, SegmentLayout, TransferKind, VelocityTable,
    VibrationAccumulator, VibrationField, point_bytes,
};
use crate::response::{LateralForces, LevelErrors, SliceErrors};
use crate::results::files::ResultFiles;
use crate::results::vibration::{VELOCITY_LEVEL, VIBRATION_FILE};
use crate::scene::{LoadedScene, Scene, SceneError, Vibration};
use crate::storage::state::{StateError, StateStream};
use answer::TyreAnswer;
use resolved::ResolvedForces;
pub(crate) use results::VibrationResults;

pub(crate) struct VibrationEffect;

static CHANNELS: [Channel; 3] = [
    Channel::new("vibration_map_frequency", "Hz", "frequencies of the maps", Read::Written),
    Channel::new("vibration_map_wavenumber", "1", "wavenumbers of the maps, in periods round the tyre", Read::Written),
    Channel::new("vibration_map", "m^2/s^2/Hz", "power of the velocity by frequency and wavenumber", Read::Written),
];

/// Errors of its levels: those of the force by slices; others are not stated.
fn level_errors(plan: &Plan, slices: Option<&SliceErrors>) -> LevelErrors {
    LevelErrors::new(None, plan.by_slices(), slices, SliceErrors::force)
}

impl Effect for VibrationEffect {
    fn name(&self) -> &'static str {
        "vibration"
    }

    fn channels(&self) -> &'static [Channel] {
        &CHANNELS
    }

    fn rows(&self) -> &'static [DecisionRow] {
        &planned::ROWS
    }

    fn takes_models(&self, scene: &Scene) -> bool {
        planned::wanted(scene).is_some()
    }

    fn check(&self, loaded: &LoadedScene, scene: &Scene) -> Result<(), SceneError> {
        planned::check_elements(loaded, scene)
    }

    fn choice(&self, plan: &Plan) -> Option<PlannedSetting> {
        plan.waves_in_mean()
    }

    fn add_amounts(&self, plan: &Plan, amounts: &mut Amounts) {
        planned::add_amounts(amounts, plan);
    }

    fn levels(&self) -> &'static [LevelTable] {
        &[LevelTable {
            file: VIBRATION_FILE,
            quantity: VELOCITY_LEVEL,
            column: "level_db_re_1m_s",
            errors: |stored| level_errors(&stored.plan, stored.summary.contact.slices.as_ref()),
        }]
    }

    fn figures(&self, stored: &Stored) -> Vec<Figure> {
        let fields = stored.summary.vibration.iter().flat_map(|vibration| &vibration.fields);
        let figure = |(field, velocity)| Figure::of(format!("velocity of {field}, rms"), "m/s", Some(velocity));
        fields.filter_map(|field| figure((&field.field, field.rms_velocity))).collect()
    }

    fn sections(&self, stored: &Stored, _: &[Stored]) -> Result<Vec<PageSection>, ReportError> {
        let mut blocks = levels(stored, VELOCITY_LEVEL, "Velocities, third octaves")?;
        let caption = "waves round the tyre over frequency. White: free waves of the tyre";
        blocks.extend(pictures_of(stored, "vibration_map_", caption)?);
        Ok(vec![PageSection { heading: "Vibration", blocks }])
    }

    fn begin(&self, begin: &mut RunStart<'_>, job: &mut Job<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError> {
        Ok(VibrationObserver::begin(begin, job)?.map(|observer| Box::new(observer) as Box<dyn EffectObserver>))
    }
}

/// Observer of the patch's forces, from which the tyre's velocities are computed.
pub struct VibrationObserver {
    wanted: Vibration,
    accumulator: VibrationAccumulator,
    tyre: TyreAnswer,
    /// Lateral waves, for forces on cells, that the velocities depend on.
    lateral_forces: Option<LateralForces>,
    /// Power that forces on cells put into the waves that the run carries; `None` with friction.
    resolved: Option<ResolvedForces>,
    fields: Vec<VibrationField>,
    /// Highest frequency up to which levels are valid \[Hz\].
    valid_to: f64,
    errors: LevelErrors,
    /// Number of steps after the warm-up.
    steps: u64,
}

impl Observer for VibrationObserver {
    fn needs_power(&self) -> bool {
        true
    }

    fn observe(&mut self, step: &Step<'_>, meter: &mut Meter) -> Result<(), RunError> {
        if let Some(power) = step.power {
            self.push(step, power, meter);
        }
        Ok(())
    }
}

impl EffectObserver for VibrationObserver {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.accumulator, &mut self.resolved])
    }

    fn write(
        &self,
        end: &End<'_>,
        files: &dyn ResultFiles,
        found: &mut Found,
        meter: &mut Meter,
    ) -> Result<(), RunError> {
        found.vibration = self.write_all(end.loaded, files, meter)?;
        Ok(())
    }
}

impl VibrationObserver {
    /// Begins the observer of a run; `None` if no vibration is requested, or, with a warning, if the run is shorter
    /// than a revolution.
    pub fn begin(begin: &mut RunStart<'_>, job: &mut Job<'_>) -> Result<Option<Self>, RunError> {
        let RunStart { loaded, plan, contact, .. } = *begin;
        let Some(vibration) = plan.vibration() else { return Ok(None) };
        let geometry = &contact.geometry;
        let steps = plan.steps - plan.warm_up_steps;
        let Some(segments) = plan.vibration_segments(&vibration, geometry.columns) else {
            let revolution = plan.steps_per_revolution() as f64;
            job.warnings.push(format!(
                "the run is too short for vibration: it needs a revolution, {:.2} s, after the warm-up",
                revolution * plan.time_step
            ));
            return Ok(None);
        };
        let layout = SegmentLayout {
            phase: geometry.substep(plan.warm_up_steps),
            first_position: geometry.first_position(),
            ..segments.velocities
        };
        let first_element = geometry.first_element(plan.warm_up_steps);
        let fields: Vec<VibrationField> = [
            (vibration.tread, VibrationField::Tread),
            (vibration.belt, VibrationField::Belt),
            (vibration.tangential, VibrationField::Tangential),
        ]
        .into_iter()
        .filter_map(|(wanted, field)| wanted.then_some(field))
        .collect();
        check_memory(begin, &layout, fields.len(), &vibration)?;

        let cells = segments.cells.as_ref();
        let numbers = cells.map(|cells| cells.in_mean.as_slice());
        let mut tyre = TyreAnswer::new(begin, numbers, job)?;
        let meter = &mut job.meter;
        if vibration.tangential {
            tyre.add_tangential(loaded, plan, layout.angular_frequency(layout.bins() - 1), meter)?;
        }
        if plan.scene.has_tractions() {
            meter.time(Stage::Influence, || tyre.take_tangential_forces(plan, &layout));
        }
        let open = meter.open();
        let resolved = cells.and_then(|cells| ResolvedForces::new(plan, begin.models, cells, &layout, meter));
        let at_places = !(vibration.points.is_empty() && vibration.elements.is_empty());
        let known = cells.map(|_| known(&layout, &tyre, &fields, at_places));
        meter.close(open, Stage::Vibration);
        let tables_known = known.is_some();
        let (accumulator, tables) = match known {
            None => (VibrationAccumulator::new(layout), None),
            Some((velocities, tables)) => {
                (VibrationAccumulator::resolved(layout, ResolvedQuantities::Velocities(velocities)), Some(tables))
            }
        };
        let (valid_to, errors) = (contact.force_valid_to(), level_errors(plan, contact.slice_errors.as_ref()));
        let lateral_forces = cells.map(|cells| {
            let grid = plan.cell_grid();
            let numbers = LateralForces::new(&grid, cells.in_mean.clone());
            numbers.with_tangential(&grid, plan.scene.has_tractions())
        });
        let mut observer =
            Self { wanted: vibration, accumulator, tyre, lateral_forces, resolved, fields, valid_to, errors, steps };
        if at_places {
            meter.time(Stage::Vibration, || observer.add_points(first_element, tables));
        }
        if at_places || tables_known {
            meter.count(Counter::VibrationEvaluations, observer.evaluations(observer.fields.len()));
        }
        Ok(Some(observer))
    }

    /// Adds points beside the axle and elements, with the fields' tables where they are known; `first_element` is in
    /// the window's first column at the first step.
    fn add_points(&mut self, first_element: i64, known: Option<Vec<VelocityTable>>) {
        let layout = *self.accumulator.layout();
        let mut retained = Vec::new();
        let Self { accumulator, tyre, wanted, fields, .. } = self;
        let mut take = |table: VelocityTable| {
            accumulator.add_points(&table, &wanted.points);
            if !wanted.elements.is_empty() {
                retained.push(table);
            }
        };
        match known {
            Some(known) => known.into_iter().for_each(take),
            None => tables(&layout, tyre, fields, &mut take),
        }
        if !retained.is_empty() {
            let elements = self.wanted.elements.clone();
            self.accumulator.set_elements(ElementVelocities::new(&layout, first_element, retained, elements));
        }
    }

    /// Number of velocities for unit force of some fields at all wavenumbers and frequencies; for a tyre that turns
    /// even and odd parts count separately.
    fn evaluations(&self, fields: usize) -> u64 {
        let layout = self.accumulator.layout();
        let parts = if self.tyre.has_both_directions() { 2 } else { 1 };
        (parts * fields * (layout.elements / 2 + 1) * layout.channels() * layout.bins()) as u64
    }

    /// Takes a step, and the power that its forces put in \[W\].
    fn push(&mut self, step: &Step<'_>, power: f64, meter: &mut Meter) {
        let of_power = self.resolved.as_ref().is_some_and(ResolvedForces::completes_next);
        let completes = step.counts && (of_power || self.accumulator.completes_next());
        let columns = self.accumulator.layout().columns;
        let work = || {
            let footprint = step.footprint;
            let (forces, displacements) = (footprint.forces(), footprint.displacements());
            let first = footprint.first_point();
            let of_waves = self.resolved.as_mut().map_or(0.0, |resolved| resolved.put_in(first, forces, displacements));
            if !step.counts {
                return [false; 2];
            }
            match &mut self.lateral_forces {
                None => [self.accumulator.push(forces, power), false],
                Some(lateral_forces) => {
                    let of_power = self.resolved.as_mut().is_some_and(|resolved| resolved.push(forces, of_waves));
                    let tangential = footprint.tangential().map(|part| part.forces.as_slice());
                    let components = lateral_forces.of_all(forces, tangential, columns);
                    [self.accumulator.push(components, power), of_power]
                }
            }
        };
        // A segment's end is long and rare: it is timed by itself, and does not represent other steps.
        let [complete, of_power] =
            if completes { meter.time(Stage::Vibration, work) } else { meter.time_in_step(Stage::Vibration, work) };
        if complete {
            let layout = self.accumulator.layout();
            let points = self.fields.len() * self.wanted.elements.len();
            let (transforms, multiply_adds) = match points {
                0 => (0, 0.0),
                _ => (ElementVelocities::transforms(layout), ElementVelocities::multiply_adds(layout, points)),
            };
            count_segment(layout, transforms, multiply_adds, meter);
        }
        if let Some(resolved) = self.resolved.as_ref().filter(|_| of_power) {
            count_segment(resolved.layout(), 0, 0.0, meter);
        }
    }
}

/// Computes the table of each field that the tyre has, one after the other.
fn tables(layout: &SegmentLayout, tyre: &TyreAnswer, fields: &[VibrationField], take: &mut dyn FnMut(VelocityTable)) {
    let responses = tyre.responses();
    let table = |&field| {
        let table = VelocityTable::resolved(layout, &responses, TransferKind::Rule, field)?;
        Some(match tyre.tangential_forces() {
            Some(tangential) => table.with_tangential(tangential),
            None => table,
        })
    };
    fields.iter().filter_map(table).for_each(take);
}

/// Transfers of forces on cells, and their tables if they are retained.
fn known(
    layout: &SegmentLayout,
    tyre: &TyreAnswer,
    fields: &[VibrationField],
    keep: bool,
) -> (Vec<ResolvedVelocity>, Vec<VelocityTable>) {
    let (mut velocities, mut retained) = (Vec::new(), Vec::new());
    tables(layout, tyre, fields, &mut |table| {
        velocities.push(ResolvedVelocity::of(&table, layout));
        if keep {
            retained.push(table);
        }
    });
    (velocities, retained)
}

/// Counts the cost of a segment; `transforms` and `multiply_adds` are those of its elements.
fn count_segment(layout: &SegmentLayout, transforms: u64, multiply_adds: f64, meter: &mut Meter) {
    meter.count(Counter::VibrationTransforms, layout.transforms() + transforms);
    let bytes = 8 * (3 * (layout.places() * layout.base_length() + layout.bins() * layout.row())) as u64;
    meter.add_work(Stage::Vibration, Work { multiply_adds: (layout.multiply_adds() + multiply_adds) as u64, bytes });
}

/// Refuses segments that need more memory than the scene allows.
fn check_memory(
    begin: &RunStart<'_>,
    layout: &SegmentLayout,
    fields: usize,
    vibration: &Vibration,
) -> Result<(), SceneError> {
    let RunStart { loaded, plan, amounts, .. } = *begin;
    let (points, elements) = (fields * vibration.points.len(), fields * vibration.elements.len());
    let map = if vibration.map { 3.0 * 16.0 * 1024.0 * layout.wavenumbers() as f64 } else { 0.0 };
    // The powers are in memory a second time when results are computed. Memory in use before is part of the plan's sum.
    let at_the_end = map + 8.0 * (layout.bins() * layout.row()) as f64;
    let needed = point_bytes(layout, fields, vibration, planned::has_both_directions(plan)) + at_the_end;
    let limit = plan.scene.numerics.memory_limit;
    if at_the_end + amounts(plan).memory_on(1) <= 1e9 * limit {
        return Ok(());
    }
    let wrong = format!(
        "{} revolutions in a segment, {points} points and {elements} elements need {} of memory, \
         with the rest more than numerics.memory_limit = {limit} GB",
        layout.revolutions,
        bytes(needed)
    );
    Err(loaded.complain("outputs.vibration", wrong, "shorter segments, fewer points, or a larger memory_limit").into())
}
