//! Vibration of a run that wants it: taken in step by step, written at the end by `results`.
//!
//! The plan says whether anything is done at all: without a wish there is no recorder, no table, no model kept.

mod results;

use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};

use crate::contact::march::March;
use crate::counters::{Counter, Meter, Stage, Work};
use crate::plan::{Plan, bytes};
use crate::response::vibration::{
    ContactPower, ElementVelocities, PowerState, SegmentLayout, TransferKind, TyreResponse, VelocityTable,
    VibrationAccumulator, VibrationField, VibrationState, point_bytes,
};
use crate::run::error::RunError;
use crate::run::past::planned_model;
use crate::run::prepare::Prepared;
use crate::scene::{LoadedScene, SceneError, Vibration};
use crate::storage::StateError;
use crate::tyre::poles::{RationalModel, TangentialModel, tangential_model};

/// Takes in the patch forces of every step.
pub struct VibrationRecorder {
    wanted: Vibration,
    accumulator: VibrationAccumulator,
    power: ContactPower,
    model: RationalModel,
    scale: f64,
    spring: f64,
    tangential: Option<TangentialModel>,
    fields: Vec<VibrationField>,
    /// Highest frequency that levels are vouched for \[Hz\].
    valid_to: f64,
    warm_up: u64,
    /// Steps after the warm-up.
    steps: u64,
}

/// What evolves of a [`VibrationRecorder`].
#[derive(Deserialize, Serialize)]
pub(crate) struct RecorderState {
    accumulator: VibrationState,
    power: PowerState,
}

impl VibrationRecorder {
    /// A recorder of a prepared run; `None` if no vibration is wanted, or, with a warning, if the run is shorter than a
    /// revolution.
    ///
    /// # Errors
    /// A plan that needs too much memory; a fit that was refused; [`RunError::Interrupted`].
    pub fn prepare(
        loaded: &LoadedScene,
        plan: &Plan,
        prepared: &mut Prepared,
        stop: &AtomicBool,
        meter: &mut Meter,
    ) -> Result<Option<Self>, RunError> {
        let Some(vibration) = plan.decisions.vibration.clone() else { return Ok(None) };
        let scene = &plan.scene;
        let geometry = prepared.march.geometry();
        let (elements, substeps) = (scene.numerics.elements, scene.numerics.substeps);
        let steps = plan.steps - plan.warm_up_steps;
        let revolution = (elements * substeps) as u64;
        let Some(revolutions) = SegmentLayout::revolutions_for(vibration.segment, revolution, plan.time_step, steps)
        else {
            prepared.warnings.push(format!(
                "the run is too short for vibration: it needs a revolution, {:.2} s, after the warm-up",
                revolution as f64 * plan.time_step
            ));
            return Ok(None);
        };
        let layout = SegmentLayout {
            elements,
            substeps,
            revolutions,
            columns: geometry.columns,
            rule: scene.numerics.time_rule,
            time_step: plan.time_step,
            phase: geometry.substep(plan.warm_up_steps),
            first_position: geometry.first_position(),
            circumference: scene.tyre.circumference,
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
        check_memory(loaded, plan, &layout, fields.len(), &vibration)?;

        let (scale, spring) = (prepared.scale, prepared.march.spring());
        let model = match prepared.model.take() {
            Some(model) => model,
            None => {
                let right = "another tolerance, or no [outputs.vibration]";
                planned_model(loaded, plan, right, stop, meter, &mut prepared.warnings)?
            }
        };
        let top = layout.angular_frequency(layout.bins() - 1);
        let tangential = if vibration.tangential {
            let fitted = meter.time(Stage::Influence, || tangential_model(&plan.decisions.tyre, &model, top));
            let fitted = fitted.map_err(|error| {
                let right = "tangential = false";
                SceneError::from(loaded.complain("outputs.vibration.tangential", error.to_string(), right))
            })?;
            meter.count(Counter::ComplianceEvaluations, fitted.evaluations);
            Some(fitted)
        } else {
            None
        };
        let mut recorder = Self {
            wanted: vibration,
            accumulator: VibrationAccumulator::new(layout),
            power: ContactPower::new(layout.rule, plan.time_step, layout.columns),
            model,
            scale,
            spring,
            tangential,
            fields,
            valid_to: prepared.valid_to,
            warm_up: plan.warm_up_steps,
            steps,
        };
        if !(recorder.wanted.points.is_empty() && recorder.wanted.elements.is_empty()) {
            meter.time(Stage::Vibration, || recorder.add_points(first_element));
            meter.count(Counter::VibrationEvaluations, recorder.evaluations(recorder.fields.len()));
        }
        Ok(Some(recorder))
    }

    fn response(&self) -> TyreResponse<'_> {
        TyreResponse {
            model: &self.model,
            scale: self.scale,
            spring: self.spring,
            tangential: self.tangential.as_ref(),
        }
    }

    /// Points beside the axle and elements; `first_element` is in the window's first column at the first step.
    fn add_points(&mut self, first_element: i64) {
        let layout = *self.accumulator.layout();
        let kind = TransferKind::Rule;
        let mut tables = Vec::new();
        for index in 0..self.fields.len() {
            if let Some(table) = VelocityTable::new(&layout, &self.response(), kind, self.fields[index]) {
                self.accumulator.add_points(&table, &self.wanted.points);
                if !self.wanted.elements.is_empty() {
                    tables.push(table);
                }
            }
        }
        if !tables.is_empty() {
            let elements = self.wanted.elements.clone();
            self.accumulator.set_elements(ElementVelocities::new(&layout, first_element, tables, elements));
        }
    }

    /// Velocities for unit force of some fields at all wavenumbers and frequencies.
    fn evaluations(&self, fields: usize) -> u64 {
        let layout = self.accumulator.layout();
        (fields * (layout.elements / 2 + 1) * layout.stages() * layout.bins()) as u64
    }

    /// Takes in the step that a march has just done.
    pub fn push(&mut self, step: u64, march: &March, meter: &mut Meter) {
        // Backward differences look two steps back.
        if step + 2 < self.warm_up {
            return;
        }
        let completes = step >= self.warm_up && self.accumulator.completes_next();
        let work = || {
            let (forces, displacements) = (march.instant_forces(), march.instant_displacements());
            let power = self.power.push(march.geometry().first_element(step), forces, displacements);
            step >= self.warm_up && self.accumulator.push(forces, power)
        };
        // A segment's end is long and rare: no step stands for it, and it stands for no other.
        let complete =
            if completes { meter.time(Stage::Vibration, work) } else { meter.time_in_step(Stage::Vibration, work) };
        if complete {
            let layout = self.accumulator.layout();
            let points = self.fields.len() * self.wanted.elements.len();
            let (transforms, multiply_adds) = match points {
                0 => (0, 0.0),
                _ => (ElementVelocities::transforms(layout), ElementVelocities::multiply_adds(layout, points)),
            };
            meter.count(Counter::VibrationTransforms, layout.transforms() + transforms);
            let bytes = 8 * (3 * (layout.places() * layout.base_length() + layout.bins() * layout.row())) as u64;
            meter.add_work(
                Stage::Vibration,
                Work { multiply_adds: (layout.multiply_adds() + multiply_adds) as u64, bytes },
            );
        }
    }

    /// Takes the state down.
    pub(crate) fn save(&self) -> RecorderState {
        RecorderState { accumulator: self.accumulator.save(), power: self.power.save() }
    }

    /// Goes on from the state of a recorder of the same run.
    ///
    /// # Errors
    /// [`StateError`].
    pub(crate) fn restore(&mut self, state: RecorderState) -> Result<(), StateError> {
        self.accumulator.restore(state.accumulator)?;
        self.power.restore(state.power)
    }
}

/// Refuses segments that need more memory than the scene allows.
fn check_memory(
    loaded: &LoadedScene,
    plan: &Plan,
    layout: &SegmentLayout,
    fields: usize,
    vibration: &Vibration,
) -> Result<(), SceneError> {
    let (points, elements) = (fields * vibration.points.len(), fields * vibration.elements.len());
    let map = if vibration.map { 3.0 * 16.0 * 1024.0 * layout.wavenumbers() as f64 } else { 0.0 };
    // The powers are there a second time when they are looked at. What is there before is in the plan's sum.
    let at_the_end = map + 8.0 * (layout.bins() * layout.row()) as f64;
    let needed = point_bytes(layout, fields, vibration) + at_the_end;
    let limit = plan.scene.numerics.memory_limit;
    if at_the_end + plan.amounts().memory_on(1) <= 1e9 * limit {
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
