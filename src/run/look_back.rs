//! End of a run: spectra, pictures, the summary.

use ndarray::ArrayView2;

use crate::counters::Meter;
use crate::plan::Plan;
use crate::plan::front::FrontRow;
use crate::response::BandLevel;
use crate::results::files::ResultFiles;
use crate::results::plots::{ForceMap, ThirdOctavePlot};
use crate::results::sound::SoundSummary;
use crate::results::spectra::{FORCE_LEVEL, LOWEST_FREQUENCY, SPECTRA_FILE, force_levels_csv};
use crate::results::summary::{ContactQuality, Cost, LoadResult, Outcome, Summary};
use crate::results::vibration::VibrationSummary;
use crate::run::cell_record::CellRecorder;
use crate::run::error::RunError;
use crate::run::prepare::Prepared;
use crate::run::record::Record;
use crate::scene::LoadedScene;

/// Ingredients of the end of a run.
pub(crate) struct LookBack<'a> {
    pub(crate) loaded: &'a LoadedScene,
    pub(crate) plan: &'a Plan,
    pub(crate) prepared: &'a Prepared,
    pub(crate) record: &'a Record,
    /// Steps recorded.
    pub(crate) steps: u64,
}

/// Parts of the summary on files that were written at the end of a complete run.
#[derive(Default)]
pub(crate) struct Written {
    vibration: Option<VibrationSummary>,
    sound: Option<SoundSummary>,
}

impl LookBack<'_> {
    /// Writes spectra, pictures, vibration and sound of a complete run, those that are wanted and can be had; what the
    /// summary says of the latter two.
    ///
    /// # Errors
    /// Errors of the files and pictures.
    pub(crate) fn write(&self, folder: &dyn ResultFiles, meter: &mut Meter) -> Result<Written, RunError> {
        let Record { vibration, sound, .. } = self.record;
        self.spectra_and_plots(folder)?;
        let vibration = vibration.as_ref().map(|recorder| recorder.write(self.loaded, folder, meter));
        let sound = sound.as_ref().map(|recorder| recorder.write(self.loaded, folder));
        Ok(Written { vibration: vibration.transpose()?.flatten(), sound: sound.transpose()? })
    }

    /// Writes spectra and pictures.
    fn spectra_and_plots(&self, folder: &dyn ResultFiles) -> Result<(), RunError> {
        let outputs = &self.loaded.scene.outputs;
        let title = self.loaded.title();
        // A run too short for a spectrum has none: the summary's warnings say so.
        if (outputs.spectra || outputs.plots)
            && let Some(levels) = self.force_levels()
        {
            if outputs.spectra {
                folder.write_text(SPECTRA_FILE, &force_levels_csv(&levels))?;
            }
            if outputs.plots && !levels.is_empty() {
                let plot = ThirdOctavePlot {
                    title: &format!("Contact force, third octaves: {title}"),
                    quantity: FORCE_LEVEL,
                    spectra: vec![("", &levels)],
                    error: FrontRow::stated_error(&self.plan.scene.numerics),
                };
                folder.write_text("force_spectrum.svg", &plot.to_svg()?)?;
            }
        }
        if outputs.plots
            && let Some(cells) = &self.record.cells
        {
            let Prepared { march, road, .. } = self.prepared;
            for (file, picture) in cells.pictures(&title, march, road.slices())? {
                folder.write_text(file, &picture)?;
            }
        }
        let drawn = &self.record.drawn;
        if outputs.plots && drawn.time.len() >= 2 {
            let geometry = self.prepared.march.geometry();
            let shape = (drawn.time.len(), geometry.columns);
            if let Ok(force) = ArrayView2::from_shape(shape, &drawn.force) {
                let map = ForceMap {
                    title: &format!("Contact force over patch and time: {title}"),
                    time: &drawn.time,
                    first_element: &drawn.first_element,
                    force,
                    element_length: self.plan.element,
                    speed: self.plan.speed,
                    start: geometry.start,
                    shown: drawn.time[0]..f64::INFINITY,
                };
                folder.write_text("patch_force.svg", &map.to_svg()?)?;
            }
        }
        Ok(())
    }

    /// Third octaves of the force re 1 N, of a run that is long enough for a spectrum.
    pub(crate) fn force_levels(&self) -> Option<Vec<BandLevel>> {
        let spectrum = self.record.spectrum()?.valid_to(self.prepared.valid_to);
        Some(spectrum.third_octaves(LOWEST_FREQUENCY, 1.0))
    }

    /// The summary, with what was written.
    ///
    /// # Errors
    /// Settings that JSON cannot hold.
    pub(crate) fn summary(&self, cost: Cost, written: Written) -> Result<Summary, RunError> {
        let march = &self.prepared.march;
        let (totals, counts) = (march.totals(), march.search_counts());
        let steps = self.steps;
        let mean_force = self.record.mean_force();
        let load = self.loaded.scene.rolling.axle.load().zip(mean_force).map(|((wanted, tolerance), mean)| {
            let relative_error = (mean - wanted) / wanted;
            LoadResult { wanted, relative_error, tolerance, met: relative_error.abs() <= tolerance }
        });
        let mut summary = Summary::begun(&self.loaded.title(), self.loaded.settings()?, cost);
        (summary.vibration, summary.sound) = (written.vibration, written.sound);
        summary.outcome = Outcome {
            steps,
            time_step: self.plan.time_step,
            simulated_time: steps as f64 * self.plan.time_step,
            mean_force,
            rms_force_variation: self.record.rms_force_variation(),
            mean_contact_length: self.record.mean_contact_length(),
            indentation: Some(self.prepared.axle.indentation(steps)),
            load,
            axle: self.record.axle_motion(),
            rolling_resistance: self.record.rolling_resistance(),
            cells: self.record.cells.as_ref().and_then(CellRecorder::summary),
        };
        let residuals = totals.relative_residuals();
        summary.contact = ContactQuality {
            tension: residuals.tension,
            penetration: residuals.penetration,
            complementarity: residuals.complementarity,
            slice_error: self.prepared.road.slice_error(),
            local_compliance: self.prepared.local_compliance,
            aborted_searches: 0,
            solves_per_step: counts.solves_per_step(),
        };
        summary.notes.clone_from(&self.prepared.notes);
        summary.warnings.clone_from(&self.prepared.warnings);
        summary.warnings.extend(load.filter(|load| !load.met).map(|load| load.to_string()));
        summary.warnings.extend((totals.edge_contacts > 0).then(|| match march.is_widened() {
            false => format!(
                "in {} steps the outermost element of the window was in contact: \
                 the patch may be longer than the window",
                totals.edge_contacts
            ),
            true => format!(
                "in {} steps contact reached the end of the window of cells, and was solved again over a wider one: \
                 forces of each cell are told for the first window alone, those beyond it with its outermost columns",
                totals.edge_contacts
            ),
        }));
        if self.record.lacks_spectrum() && self.loaded.scene.outputs.spectra {
            summary.warnings.push("the run is too short for a spectrum".into());
        }
        Ok(summary)
    }
}
