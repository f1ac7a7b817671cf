//! Vibration of a run that wants it: taken in step by step, written at the end.
//!
//! The plan says whether anything is done at all: without a wish there is no recorder, no table, no model kept.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::error::RunError;
use super::past::{contact_field, fetch, fit_options, refused};
use super::plan::{Plan, bytes};
use super::prepare::Prepared;
use super::to_folder::LOWEST_FREQUENCY;
use crate::contact::march::March;
use crate::meter::{Counter, Meter, Stage, Work};
use crate::numeric::{StateError, StateReader, StateWriter};
use crate::response::vibration::{
    ContactPower, ElementVelocities, FieldSpectra, PatchSpectra, SegmentLayout, SpectraRequest, TransferKind,
    TyreResponse, VelocityTable, VibrationAccumulator, VibrationField, dispersion_branches, element_spectrum,
    field_spectra, point_spectrum,
};
use crate::response::{BandLevel, PowerSpectrum};
use crate::results::folder::ResultsFolder;
use crate::results::npy::{NpyWriter, Row};
use crate::results::plots::{ThirdOctavePlot, WavenumberPlot};
use crate::results::vibration::{
    FieldSummary, NamedSpectrum, Place, PowerSummary, VIBRATION_FILE, VIBRATION_NARROW_FILE, VibrationSummary,
    vibration_levels_csv, vibration_narrow_csv,
};
use crate::scene::{LoadedScene, SceneError, TimeRule, Vibration};
use crate::tyre::influence::Field;
use crate::tyre::rational::RationalModel;
use crate::tyre::tangential::{TangentialModel, tangential_model};

/// Takes in the patch forces of every step.
pub struct VibrationRecorder {
    wanted: Vibration,
    accumulator: VibrationAccumulator,
    power: ContactPower,
    displacement: Vec<f64>,
    model: RationalModel,
    scale: f64,
    spring: f64,
    tangential: Option<TangentialModel>,
    fields: Vec<VibrationField>,
    rule: TimeRule,
    warm_up: u64,
    /// Steps after the warm-up.
    steps: u64,
}

impl VibrationRecorder {
    /// A recorder of a prepared run; `None` if no vibration is wanted, or, with a warning, if the run is shorter than a revolution.
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
        let scene = &loaded.scene;
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
        // The position of the first column at substep 0, whichever step that is.
        let aligned = (0..substeps as u64).find(|&step| geometry.substep(step) == 0).unwrap_or(0);
        let layout = SegmentLayout {
            elements,
            substeps,
            revolutions,
            columns: geometry.columns,
            time_step: plan.time_step,
            phase: geometry.substep(plan.warm_up_steps),
            first_position: geometry.position(geometry.first_element(aligned), aligned),
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

        let (scale, spring) = (prepared.scale, prepared.march.kernel().spring);
        let model = match prepared.model.take() {
            Some(model) => model,
            None => {
                let options = fit_options(scene, contact_field(plan.decisions.tread));
                let fetched = meter
                    .time(Stage::Influence, || fetch(&plan.decisions.tyre, &options, stop))
                    .map_err(|error| refused(loaded, error, "another tolerance, or no [outputs.vibration]"))?;
                prepared.warnings.extend(fetched.warnings);
                meter.count(Counter::ComplianceEvaluations, if fetched.warm { 0 } else { fetched.model.evaluations() });
                fetched.model
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
            power: ContactPower::new(scene.numerics.time_rule, plan.time_step, layout.columns),
            displacement: vec![0.0; layout.columns],
            model,
            scale,
            spring,
            tangential,
            fields,
            rule: scene.numerics.time_rule,
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
        let kind = TransferKind::Rule(self.rule);
        let mut tables = Vec::new();
        for &field in &self.fields {
            let response = TyreResponse {
                model: &self.model,
                scale: self.scale,
                spring: self.spring,
                tangential: self.tangential.as_ref(),
            };
            if let Some(table) = VelocityTable::new(&layout, &response, kind, field) {
                table.add_points(&mut self.accumulator, &self.wanted.points);
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
        (fields * (layout.elements / 2 + 1) * layout.bins()) as u64
    }

    /// Takes in the step that a march has just done.
    pub fn push(&mut self, step: u64, march: &March, meter: &mut Meter) {
        // Backward differences look two steps back.
        if step + 2 < self.warm_up {
            return;
        }
        let complete = meter.time(Stage::Vibration, || {
            march.displacements(&mut self.displacement);
            let power = self.power.push(march.geometry().first_element(step), march.forces(), &self.displacement);
            step >= self.warm_up && self.accumulator.push(march.forces(), power)
        });
        if complete {
            let layout = self.accumulator.layout();
            let points = self.fields.len() * self.wanted.elements.len();
            let (transforms, multiply_adds) = match points {
                0 => (0, 0.0),
                _ => (layout.elements as u64, ElementVelocities::multiply_adds(layout, points)),
            };
            meter.count(Counter::VibrationTransforms, layout.transforms() + transforms);
            let bytes =
                8 * (3 * (layout.places() * layout.base_length() + layout.bins() * layout.wavenumbers())) as u64;
            meter.add_work(
                Stage::Vibration,
                Work { multiply_adds: (layout.multiply_adds() + multiply_adds) as u64, bytes },
            );
        }
    }

    /// Takes the state down.
    pub fn save(&self, state: &mut StateWriter) {
        self.accumulator.save(state);
        self.power.save(state);
    }

    /// Goes on from the state of a recorder of the same run.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        self.accumulator.restore(state)?;
        self.power.restore(state)
    }

    /// Writes spectra, maps and pictures of a complete run; what the summary says of them.
    ///
    /// # Errors
    /// Of the files and pictures.
    pub fn write(
        &self,
        loaded: &LoadedScene,
        mean_force: Option<f64>,
        folder: &ResultsFolder,
        meter: &mut Meter,
    ) -> Result<Option<VibrationSummary>, RunError> {
        let Some(patch) = self.accumulator.finish() else { return Ok(None) };
        let vibration = &self.wanted;
        // The power balance is the tread's.
        let mut fields = vec![VibrationField::Tread];
        fields.extend(self.fields.iter().filter(|field| **field != VibrationField::Tread));
        let rule = self.rule;
        let request = SpectraRequest { fields: &fields, kind: TransferKind::Rule(rule), maps: vibration.map };
        let exact = SpectraRequest { kind: TransferKind::Exact, maps: false, ..request.clone() };
        let response = self.response();
        let Some((by_rule, by_tyre)) =
            field_spectra(&patch, &response, &request).zip(field_spectra(&patch, &response, &exact))
        else {
            return Ok(None);
        };
        meter.count(Counter::VibrationEvaluations, 2 * self.evaluations(fields.len()));
        let ((spectra, dissipated), (of_tyre, dissipated_by_tyre)) = (by_rule, by_tyre);
        let spectra: Vec<FieldSpectra> =
            spectra.into_iter().filter(|field| self.fields.contains(&field.field)).collect();

        let named = self.named(vibration, &patch, &spectra);
        let levels = vibration_levels_csv(&named, LOWEST_FREQUENCY, Path::new(VIBRATION_FILE))?;
        folder.write_text(VIBRATION_FILE, &levels)?;
        folder.write_text(VIBRATION_NARROW_FILE, &vibration_narrow_csv(&named, Path::new(VIBRATION_NARROW_FILE))?)?;
        if loaded.scene.outputs.plots {
            draw_levels(loaded, &named, folder)?;
        }
        self.write_maps(loaded, vibration, &spectra, folder, meter)?;

        let layout = &patch.layout;
        let taken = (patch.segments + 1) * layout.hop() as u64;
        let difference = patch.mean_power - dissipated.total();
        let speed = loaded.scene.rolling.speed();
        Ok(Some(VibrationSummary {
            segments: patch.segments,
            segment_seconds: layout.length() as f64 * layout.time_step,
            revolutions: layout.revolutions,
            resolution: layout.resolution(),
            seconds_left_out: self.steps.saturating_sub(taken) as f64 * layout.time_step,
            fields: spectra.iter().map(|field| summary_of(field, &of_tyre, rule)).collect(),
            power: PowerSummary {
                put_in: patch.mean_power,
                dissipated_by_mean_pattern: dissipated.mean_pattern,
                dissipated_by_vibration: dissipated.vibration,
                relative_difference: difference / patch.mean_power,
                dissipated_by_tyre: dissipated_by_tyre.total(),
                rolling_resistance: mean_force
                    .filter(|&force| force > 0.0)
                    .map(|force| patch.mean_power / (speed * force)),
            },
            tangential_error: self.tangential.as_ref().map(|tangential| [tangential.error, tangential.omitted]),
        }))
    }

    /// All spectra that are written, in order.
    fn named(&self, vibration: &Vibration, patch: &PatchSpectra, spectra: &[FieldSpectra]) -> Vec<NamedSpectrum> {
        let mut all = Vec::new();
        for field in spectra {
            let frames = [
                (vibration.frames.material(), MATERIAL, &field.material),
                (vibration.frames.material(), MATERIAL_VARYING, &field.material_varying),
                (vibration.frames.non_rotating(), NON_ROTATING, &field.non_rotating),
            ];
            for (_, frame, spectrum) in frames.into_iter().filter(|(wanted, ..)| *wanted) {
                let spectrum = spectrum.clone();
                all.push(NamedSpectrum { field: field.field.name(), frame, place: Place::Everywhere, spectrum });
            }
        }
        let places =
            self.fields.iter().flat_map(|field| vibration.points.iter().map(move |&position| (field, position)));
        all.extend(places.enumerate().map(|(point, (field, position))| NamedSpectrum {
            field: field.name(),
            frame: NON_ROTATING,
            place: Place::Position(position),
            spectrum: point_spectrum(patch, point),
        }));
        let elements = spectra.iter().flat_map(|field| vibration.elements.iter().map(move |&element| (field, element)));
        for (point, (field, element)) in elements.enumerate() {
            let varying = element_spectrum(patch, point);
            // The mean pattern passes all elements alike.
            let mut whole = varying.clone();
            let lines = field.material.power.iter().zip(&field.material_varying.power);
            whole.power.iter_mut().zip(lines).for_each(|(power, (with, without))| *power += with - without);
            for (frame, spectrum) in [(MATERIAL, whole), (MATERIAL_VARYING, varying)] {
                let (field, place) = (field.field.name(), Place::Element(element));
                all.push(NamedSpectrum { field, frame, place, spectrum });
            }
        }
        all
    }

    fn write_maps(
        &self,
        loaded: &LoadedScene,
        vibration: &Vibration,
        spectra: &[FieldSpectra],
        folder: &ResultsFolder,
        meter: &mut Meter,
    ) -> Result<(), RunError> {
        let rotation = loaded.scene.rolling.speed() / loaded.scene.tyre.circumference;
        let mut axes_written = false;
        for field in spectra {
            let Some([material, non_rotating]) = &field.maps else { continue };
            let face = if field.field == VibrationField::Belt { Field::Bottom } else { self.model.driven };
            let branches = dispersion_branches(&self.model, face, field.material.nyquist);
            let frames = [
                (vibration.frames.material(), MATERIAL, material, 0.0),
                (vibration.frames.non_rotating(), NON_ROTATING, non_rotating, rotation),
            ];
            for (_, frame, map, rotation) in frames.into_iter().filter(|(wanted, ..)| *wanted) {
                let name = format!("vibration_map_{}_{frame}", field.field.name());
                write_rows(folder, &format!("{name}.npy"), &map.density, Row::Columns(map.wavenumbers), meter)?;
                if !axes_written {
                    let rows = map.density.len() / map.wavenumbers;
                    let frequencies: Vec<f64> = (0..rows).map(|row| (row as f64 + 0.5) * map.row_width).collect();
                    let half = (map.wavenumbers / 2) as f64;
                    let wavenumbers: Vec<f64> = (0..map.wavenumbers).map(|index| index as f64 - half).collect();
                    write_rows(folder, "vibration_map_frequency.npy", &frequencies, Row::Scalar, meter)?;
                    write_rows(folder, "vibration_map_wavenumber.npy", &wavenumbers, Row::Scalar, meter)?;
                    axes_written = true;
                }
                if loaded.scene.outputs.plots {
                    let title = format!("{}: {} velocity, {frame} frame", loaded.title(), field.field.name());
                    let plot = WavenumberPlot { title: &title, map, branches: &branches, rotation };
                    folder.write_text(&format!("{name}.svg"), &plot.to_svg()?)?;
                }
            }
        }
        Ok(())
    }
}

/// The frames' names in results.
const MATERIAL: &str = "material";
const MATERIAL_VARYING: &str = "material-varying";
const NON_ROTATING: &str = "non-rotating";

/// Bytes of the sums over the forces with the points and elements of so many fields.
pub(in crate::pipeline) fn point_bytes(layout: &SegmentLayout, fields: usize, vibration: &Vibration) -> f64 {
    let sums = VibrationAccumulator::bytes(layout, fields * vibration.points.len());
    match vibration.elements.len() {
        // A table is there while points are added.
        0 if vibration.points.is_empty() => sums,
        0 => sums + VelocityTable::bytes(layout),
        elements => sums + ElementVelocities::bytes(layout, fields, elements),
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
    // The powers are there a second time when they are looked at.
    let needed = point_bytes(layout, fields, vibration) + map + 8.0 * (layout.bins() * layout.wavenumbers()) as f64;
    let limit = loaded.scene.numerics.memory_limit;
    if needed + plan.amounts.memory_on(1) <= 1e9 * limit {
        return Ok(());
    }
    let wrong = format!(
        "{} revolutions in a segment, {points} points and {elements} elements need {} of memory, with the rest more than numerics.memory_limit = {limit} GB",
        layout.revolutions,
        bytes(needed)
    );
    Err(loaded.complain("outputs.vibration", wrong, "shorter segments, fewer points, or a larger memory_limit").into())
}

/// Velocities of a field, and how far they are from those by the tyre's own transfer.
fn summary_of(field: &FieldSpectra, of_tyre: &[FieldSpectra], rule: TimeRule) -> FieldSummary {
    let decibel = |ratio: f64| 10.0 * ratio.log10();
    let same = of_tyre.iter().find(|other| other.field == field.field && rule != TimeRule::FirstOrderHold);
    let total = |spectrum: &PowerSpectrum| spectrum.mean_square();
    let bands = same.map(|other| {
        let [one, two] = [field, other].map(|field| field.non_rotating.third_octaves(LOWEST_FREQUENCY, 1.0));
        one.iter()
            .zip(&two)
            .filter(|(one, two)| one.band.upper_edge() < 1000.0 && one.mean_square > 0.0 && two.mean_square > 0.0)
            .map(|(one, two)| one.level - two.level)
            .fold(0.0_f64, |largest, difference| if difference.abs() > largest.abs() { difference } else { largest })
    });
    FieldSummary {
        field: field.field.name(),
        rms_velocity: total(&field.non_rotating).sqrt(),
        rms_mean_pattern: field.mean_pattern.sqrt(),
        rule_difference: same.map(|other| decibel(total(&field.non_rotating) / total(&other.non_rotating))),
        rule_difference_below_1k: bands,
    }
}

/// Third octaves: the means of all fields in one picture, the points of each field in one of its own.
fn draw_levels(loaded: &LoadedScene, named: &[NamedSpectrum], folder: &ResultsFolder) -> Result<(), RunError> {
    let drawn = |named: &&NamedSpectrum| named.frame != MATERIAL_VARYING;
    let everywhere = |named: &&NamedSpectrum| named.place == Place::Everywhere;
    draw_spectra(loaded, named.iter().filter(everywhere).filter(drawn), "vibration_spectrum.svg", folder)?;
    let kind = |named: &NamedSpectrum| match named.place {
        Place::Everywhere => None,
        Place::Position(_) => Some((named.field, "points")),
        Place::Element(_) => Some((named.field, "elements")),
    };
    for points in named.chunk_by(|a, b| kind(a) == kind(b)) {
        if let Some((field, places)) = kind(&points[0]) {
            let file = format!("vibration_{places}_{field}.svg");
            draw_spectra(loaded, points.iter().filter(drawn), &file, folder)?;
        }
    }
    Ok(())
}

fn draw_spectra<'a>(
    loaded: &LoadedScene,
    spectra: impl Iterator<Item = &'a NamedSpectrum>,
    file: &str,
    folder: &ResultsFolder,
) -> Result<(), RunError> {
    let drawn: Vec<(String, Vec<BandLevel>)> =
        spectra.map(|named| (named.name(), named.spectrum.third_octaves(LOWEST_FREQUENCY, 1.0))).collect();
    if drawn.iter().all(|(_, levels)| levels.is_empty()) {
        return Ok(());
    }
    let title = loaded.title();
    let plot = ThirdOctavePlot {
        title: &title,
        quantity: "Velocity level [dB re 1 m/s]",
        spectra: drawn.iter().map(|(name, levels)| (name.as_str(), levels.as_slice())).collect(),
    };
    folder.write_text(file, &plot.to_svg()?)?;
    Ok(())
}

/// A whole array at once.
fn write_rows(folder: &ResultsFolder, name: &str, values: &[f64], row: Row, meter: &mut Meter) -> Result<(), RunError> {
    let mut writer = NpyWriter::<f64>::create(&folder.path(name), row)?;
    let length = match row {
        Row::Scalar => 1,
        Row::Columns(columns) => columns,
    };
    values.chunks_exact(length).try_for_each(|row| writer.push(row))?;
    meter.count(Counter::BytesWritten, writer.bytes());
    writer.finish()?;
    Ok(())
}
