//! Results of a run's vibration: tables, maps, pictures, the summary.

use crate::counters::{Counter, Meter};
use crate::effects::error::RunError;
use crate::effects::observer::draw_third_octaves;
use crate::effects::vibration::VibrationObserver;
use crate::response::vibration::{
    Dissipation, FieldSpectra, PatchSpectra, SpectraRequest, TransferKind, VibrationField, element_spectrum,
    field_spectra, point_spectrum, resolved_spectra,
};
use crate::response::{LateralForces, LevelErrors, PowerSpectrum};
use crate::results::files::ResultFiles;
use crate::results::npy::{ArrayRow, array_file};
use crate::results::plots::WavenumberPlot;
use crate::results::spectra::LOWEST_FREQUENCY;
use crate::results::vibration::{
    FieldSummary, PowerSummary, VELOCITY_LEVEL, VIBRATION_FILE, VIBRATION_NARROW_FILE, VelocityPlace, VelocitySpectrum,
    VibrationSummary, vibration_levels_csv, vibration_narrow_csv,
};
use crate::scene::{LoadedScene, Vibration};

/// Names of the frames in results.
const MATERIAL: &str = "material";
const MATERIAL_VARYING: &str = "material-varying";
const NON_ROTATING: &str = "non-rotating";

/// Velocities of a run that keeps its results in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct VibrationResults {
    /// Spectra by field, frame and place.
    pub spectra: Vec<VelocitySpectrum>,
    /// Their part of the run's summary.
    pub(crate) summary: VibrationSummary,
}

/// Results of a complete run.
struct SpectraAndBalance {
    spectra: Vec<FieldSpectra>,
    /// With the exact transfer of the tyre, where it was computed.
    of_tyre: Vec<FieldSpectra>,
    /// Power balance; `None` with friction.
    balance: Option<Balance>,
}

/// Dissipated power \[W\].
struct Balance {
    /// Power put into the waves that the run carries, where those are not all.
    put_into_waves: Option<f64>,
    dissipated: Dissipation,
    by_tyre: Option<f64>,
}

impl VibrationObserver {
    /// Writes spectra, maps and pictures of a complete run; returns their summary.
    ///
    /// # Errors
    /// Errors of the files and pictures.
    pub(super) fn write_all(
        &self,
        loaded: &LoadedScene,
        folder: &dyn ResultFiles,
        meter: &mut Meter,
    ) -> Result<Option<VibrationSummary>, RunError> {
        let Some((VibrationResults { spectra: named, summary }, fields)) = self.found(self.wanted.map, meter) else {
            return Ok(None);
        };
        folder.write_text(VIBRATION_FILE, &vibration_levels_csv(&named, LOWEST_FREQUENCY, &self.errors))?;
        folder.write_text(VIBRATION_NARROW_FILE, &vibration_narrow_csv(&named))?;
        if loaded.scene.outputs.plots {
            draw_levels(loaded, &named, &self.errors, folder)?;
        }
        self.write_maps(loaded, &self.wanted, &fields, folder, meter)?;
        Ok(Some(summary))
    }

    /// Velocities of the steps so far; `None` before the first segment is complete.
    pub(crate) fn results_so_far(&self, meter: &mut Meter) -> Option<VibrationResults> {
        self.found(false, meter).map(|(results, _)| results)
    }

    /// Vibration of a complete run, with maps if `maps`.
    pub(super) fn found(&self, maps: bool, meter: &mut Meter) -> Option<(VibrationResults, Vec<FieldSpectra>)> {
        let patch = self.accumulator.finish()?;
        // The power balance is that of the tread.
        let mut fields = vec![VibrationField::Tread];
        fields.extend(self.fields.iter().filter(|field| **field != VibrationField::Tread));
        let request = SpectraRequest { fields: &fields, kind: TransferKind::Rule, maps };
        let SpectraAndBalance { spectra, of_tyre, balance } = self.spectra_and_balance(&patch, &request, meter)?;

        let layout = &patch.layout;
        let taken = (patch.segments + 1) * layout.hop() as u64;
        let power = balance.map(|Balance { put_into_waves, dissipated, by_tyre }| {
            let put_in = put_into_waves.unwrap_or(patch.mean_power);
            let difference = put_in - dissipated.total();
            PowerSummary {
                put_in: patch.mean_power,
                put_into_waves,
                dissipated_by_mean_pattern: dissipated.mean_pattern,
                dissipated_by_vibration: dissipated.vibration,
                relative_difference: difference / put_in,
                dissipated_by_tyre: by_tyre,
            }
        });
        let summary = VibrationSummary {
            segments: patch.segments,
            segment_seconds: layout.length() as f64 * layout.time_step,
            revolutions: layout.revolutions,
            resolution: layout.resolution(),
            seconds_left_out: self.steps.saturating_sub(taken) as f64 * layout.time_step,
            waves_across: self.lateral_forces.as_ref().map(LateralForces::count),
            fields: spectra.iter().map(|field| summary_of(field, &of_tyre)).collect(),
            power,
            tangential_error: self.tyre.tangential_error(),
        };
        Some((VibrationResults { spectra: self.named(&self.wanted, &patch, &spectra), summary }, spectra))
    }

    /// Velocities and power balance.
    fn spectra_and_balance(
        &self,
        patch: &PatchSpectra,
        request: &SpectraRequest<'_>,
        meter: &mut Meter,
    ) -> Option<SpectraAndBalance> {
        if self.lateral_forces.is_some() {
            // With the exact transfer every segment would have to be transformed again.
            let balance = match &self.resolved {
                Some(resolved) => {
                    let (put_in, dissipated) = resolved.power()?;
                    Some(Balance { put_into_waves: Some(put_in), dissipated, by_tyre: None })
                }
                None => None,
            };
            let spectra = resolved_spectra(patch, &self.fields, request.maps);
            return Some(SpectraAndBalance { spectra, of_tyre: Vec::new(), balance });
        }
        let exact = SpectraRequest { kind: TransferKind::Exact, maps: false, ..request.clone() };
        let (_, response) = self.tyre.responses().into_iter().next()?;
        let (by_rule, by_tyre) =
            field_spectra(patch, &response, request).zip(field_spectra(patch, &response, &exact))?;
        meter.count(Counter::VibrationEvaluations, 2 * self.evaluations(request.fields.len()));
        let ((mut spectra, dissipated), (of_tyre, by_tyre)) = (by_rule, by_tyre);
        spectra.retain(|field| self.fields.contains(&field.field));
        let balance = Balance { put_into_waves: None, dissipated, by_tyre: Some(by_tyre.total()) };
        Some(SpectraAndBalance { spectra, of_tyre, balance: Some(balance) })
    }

    /// All spectra that are written, in order.
    fn named(&self, vibration: &Vibration, patch: &PatchSpectra, spectra: &[FieldSpectra]) -> Vec<VelocitySpectrum> {
        let mut all = Vec::new();
        for field in spectra {
            let frames = [
                (vibration.frames.material(), MATERIAL, &field.material),
                (vibration.frames.material(), MATERIAL_VARYING, &field.material_varying),
                (vibration.frames.non_rotating(), NON_ROTATING, &field.non_rotating),
            ];
            for (_, frame, spectrum) in frames.into_iter().filter(|(wanted, ..)| *wanted) {
                let spectrum = spectrum.clone();
                all.push(VelocitySpectrum {
                    field: field.field.name(),
                    frame,
                    place: VelocityPlace::Everywhere,
                    spectrum,
                });
            }
        }
        let places =
            self.fields.iter().flat_map(|field| vibration.points.iter().map(move |&position| (field, position)));
        all.extend(places.enumerate().map(|(point, (field, position))| VelocitySpectrum {
            field: field.name(),
            frame: NON_ROTATING,
            place: VelocityPlace::Position(position),
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
                let (field, place) = (field.field.name(), VelocityPlace::Element(element));
                all.push(VelocitySpectrum { field, frame, place, spectrum });
            }
        }
        for named in &mut all {
            named.spectrum.valid_to = self.valid_to;
        }
        all
    }

    fn write_maps(
        &self,
        loaded: &LoadedScene,
        vibration: &Vibration,
        spectra: &[FieldSpectra],
        folder: &dyn ResultFiles,
        meter: &mut Meter,
    ) -> Result<(), RunError> {
        let rotation = loaded.scene.rolling.speed() / loaded.scene.tyre.circumference;
        let mut axes_written = false;
        for field in spectra {
            let Some([material, non_rotating]) = &field.maps else { continue };
            let branches = self.tyre.branches(field.field, field.material.nyquist);
            let frames = [
                (vibration.frames.material(), MATERIAL, material, 0.0),
                (vibration.frames.non_rotating(), NON_ROTATING, non_rotating, rotation),
            ];
            for (_, frame, map, rotation) in frames.into_iter().filter(|(wanted, ..)| *wanted) {
                let name = format!("vibration_map_{}_{frame}", field.field.name());
                write_rows(folder, &format!("{name}.npy"), &map.density, ArrayRow::Columns(map.wavenumbers), meter)?;
                if !axes_written {
                    let rows = map.density.len() / map.wavenumbers;
                    let frequencies: Vec<f64> = (0..rows).map(|row| (row as f64 + 0.5) * map.row_width).collect();
                    let half = (map.wavenumbers / 2) as f64;
                    let wavenumbers: Vec<f64> = (0..map.wavenumbers).map(|index| index as f64 - half).collect();
                    write_rows(folder, "vibration_map_frequency.npy", &frequencies, ArrayRow::Scalar, meter)?;
                    write_rows(folder, "vibration_map_wavenumber.npy", &wavenumbers, ArrayRow::Scalar, meter)?;
                    axes_written = true;
                }
                if loaded.scene.outputs.plots {
                    let title = format!("Velocity of {}, {frame} frame: {}", field.field.name(), loaded.title());
                    let plot = WavenumberPlot { title: &title, map, branches: &branches, rotation };
                    folder.write_text(&format!("{name}.svg"), &plot.to_svg()?)?;
                }
            }
        }
        Ok(())
    }
}

/// Summary of the velocities of a field, and their difference from those with the exact transfer.
fn summary_of(field: &FieldSpectra, of_tyre: &[FieldSpectra]) -> FieldSummary {
    let decibel = |ratio: f64| 10.0 * ratio.log10();
    let same = of_tyre.iter().find(|other| other.field == field.field);
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
        field: field.field.name().into(),
        rms_velocity: total(&field.non_rotating).sqrt(),
        rms_mean_pattern: field.mean_pattern.sqrt(),
        rule_difference: same.map(|other| decibel(total(&field.non_rotating) / total(&other.non_rotating))),
        rule_difference_below_1k: bands,
    }
}

/// Draws the third octaves: the means of all fields in one picture, the points of each field in another.
fn draw_levels(
    loaded: &LoadedScene,
    named: &[VelocitySpectrum],
    errors: &LevelErrors,
    folder: &dyn ResultFiles,
) -> Result<(), RunError> {
    let drawn = |named: &&VelocitySpectrum| named.frame != MATERIAL_VARYING;
    let everywhere = |named: &&VelocitySpectrum| named.place == VelocityPlace::Everywhere;
    draw_spectra(loaded, named.iter().filter(everywhere).filter(drawn), errors, "vibration_spectrum.svg", folder)?;
    let kind = |named: &VelocitySpectrum| match named.place {
        VelocityPlace::Everywhere => None,
        VelocityPlace::Position(_) => Some((named.field, "points")),
        VelocityPlace::Element(_) => Some((named.field, "elements")),
    };
    for points in named.chunk_by(|a, b| kind(a) == kind(b)) {
        if let Some((field, places)) = kind(&points[0]) {
            let file = format!("vibration_{places}_{field}.svg");
            draw_spectra(loaded, points.iter().filter(drawn), errors, &file, folder)?;
        }
    }
    Ok(())
}

fn draw_spectra<'a>(
    loaded: &LoadedScene,
    spectra: impl Iterator<Item = &'a VelocitySpectrum>,
    errors: &LevelErrors,
    file: &str,
    folder: &dyn ResultFiles,
) -> Result<(), RunError> {
    let levels = |of: &VelocitySpectrum| (of.name(), of.spectrum.third_octaves(LOWEST_FREQUENCY, 1.0));
    let drawn: Vec<_> = spectra.map(levels).collect();
    draw_third_octaves(loaded, [file, "Velocities", VELOCITY_LEVEL], &drawn, errors.clone(), folder)
}

fn write_rows(
    folder: &dyn ResultFiles,
    name: &str,
    values: &[f64],
    row: ArrayRow,
    meter: &mut Meter,
) -> Result<(), RunError> {
    let file = array_file(values, row);
    meter.count(Counter::BytesWritten, file.len() as u64);
    Ok(folder.write(name, &file)?)
}
