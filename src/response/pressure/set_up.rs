//! Set-up of the transfers of a path: G as it is stored on disk, by boundary elements, and under an open patch, and the
//! waves of the tyre that meet it.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::model::PressureModel;
use super::open_patch::{GrooveFields, OpenPatch};
use super::path::TransferPath;
use super::surface::SurfaceGreen;
use super::transfer::PressureTransfers;
use crate::contact::cells::gaps::GapMap;
use crate::counters::{Counter, Job, Stage, Work};
use crate::radiation::stored::StoredTransfers;
use crate::radiation::{FrequencyReport, FrequencyWatch, RadiatingBody, RadiationError, draft, transfers};
use crate::response::vibration::SegmentLayout;
use crate::scene::{LoadedScene, RadiationQuality, SceneError, SetUpError, Tyre};
use crate::storage::Cache;
use crate::tyre::influence::{SurfaceWaves, TractionWaves};

/// Relative tolerance of the waves' compliances.
pub(crate) const WAVES: f64 = 1e-4;

pub(crate) struct SetUp<'a> {
    /// Scene of the run.
    pub loaded: &'a LoadedScene,
    pub path: &'a TransferPath,
    pub body: &'a RadiatingBody,
    pub tyre: &'a Tyre,
    /// Gaps between tread and road at the places whose voids are open.
    pub gaps: &'a [GapMap],
}

/// Transfers to all points.
pub(crate) struct FoundTransfers {
    pub transfers: PressureTransfers,
    /// Report on their frequencies; of a draft the count alone.
    pub report: FrequencyReport,
    /// Fields in the grooves, where air passes through the patch.
    pub grooves: Option<GrooveFields>,
}

impl SetUp<'_> {
    /// Finds the transfers of forces in windows of a layout, for compliances times `scale`.
    ///
    /// # Errors
    /// [`SetUpError`].
    pub(crate) fn find(
        &self,
        layout: SegmentLayout,
        scale: f64,
        job: &mut Job<'_>,
    ) -> Result<FoundTransfers, SetUpError> {
        let Self { path, body, tyre, .. } = *self;
        let open = job.meter.open();
        job.progress.stage(Stage::Radiation);
        let (greens, report, grooves) = self.greens(job)?;
        // Points in grooves have no delay.
        let (_, late) = path.delays(body);
        let delay = |streamed| path.spectrum_of(streamed).map_or(0.0, |spectrum| late[spectrum % path.points()]);
        let delays = (0..greens.len()).map(delay).collect();
        let (lateral, highest) = (path.lateral_numbers(tyre), 0.5 / layout.time_step);
        let rule = path.flank(body).map(|flank| flank.rule);
        let (around, wanted) = (TransferPath::GRID.around / 2, [highest, WAVES]);
        let tangential = path.has_tractions.then(|| Arc::new(TractionWaves::new(tyre, around, &lateral, wanted)));
        let (waves, known) = match Cache::open() {
            Ok(cache) => SurfaceWaves::fetch(&cache, tyre, around, lateral, wanted, rule.as_ref(), &mut job.warnings),
            // The cache of the transfers has warned of that.
            Err(_) => (SurfaceWaves::with_flank(tyre, around, lateral, wanted, rule.as_ref()), false),
        };
        if !known {
            job.meter.count(Counter::ComplianceEvaluations, waves.evaluations());
        }
        let model = path.model(Arc::new(waves), tyre.contact_width);
        let model = PressureModel { layout, tangential, scale, delays, ..model };
        job.meter.close(open, Stage::Radiation);
        Ok(FoundTransfers { transfers: PressureTransfers { model, greens: greens.into() }, report, grooves })
    }

    fn refused(&self, key: &str, wrong: impl ToString, right: impl Into<String>) -> SetUpError {
        SceneError::from(self.loaded.complain(key, wrong.to_string(), right)).into()
    }

    /// G from the tread to all points.
    fn greens(
        &self,
        job: &mut Job<'_>,
    ) -> Result<(Vec<SurfaceGreen>, FrequencyReport, Option<GrooveFields>), SetUpError> {
        let Self { path, body, .. } = *self;
        // 1. Transfers of the sealed body: a draft, or stored ones and boundary elements.
        let problem = path.problem(body, self.loaded.scene.numerics.memory_bytes());
        let range = path.range();
        if path.radiation.quality == RadiationQuality::Draft {
            let drafted = draft::transfers(&problem, &range);
            let set = drafted.map_err(|error| self.refused("radiation.quality", error, "\"full\""))?;
            let report = FrequencyReport { count: set.frequencies().len(), ..FrequencyReport::default() };
            return Ok((SurfaceGreen::of_set(body, set), report, None));
        }
        let open = self.open_patch()?;
        let stored = StoredTransfers::open(&problem, &range, &path.receivers, &mut job.warnings);
        let mut warnings = Vec::new();
        let mut watch = FrequencyWatch {
            known: &mut |wanted| stored.load(wanted, &mut job.warnings),
            sink: &mut |found| {
                stored.store(found, &mut warnings);
                Ok(())
            },
            progress: &mut |so_far| job.progress.pieces(so_far.finished, so_far.open),
            interrupted: &|| job.stop.load(Ordering::Relaxed),
        };
        let found = transfers(&problem, &range, rayon::current_num_threads(), &mut watch);
        job.warnings.extend(warnings);
        let (set, report) = found.map_err(|error| match error {
            RadiationError::Interrupted => {
                job.progress.note("frequencies of the radiation that were solved are kept for the next run");
                SetUpError::Stopped
            }
            error @ RadiationError::Memory { .. } => {
                self.refused("numerics.memory_limit", error, "more, or a lower radiation.fmax")
            }
            error @ RadiationError::Point { .. } => self.refused("receiver", error, "a place in the air"),
            error => self.refused("radiation.fmax", error, "another one"),
        })?;
        job.meter.count(Counter::RadiationSolves, report.solved as u64);
        let work = report.solve.work;
        job.meter.count(Counter::RadiationKernels, work.far_evaluations + work.near_evaluations);
        let multiply_adds = (0.5 * report.solve.factor_operations) as u64;
        job.meter.add_work(Stage::Radiation, Work { multiply_adds, bytes: 0 });
        // 2. Fields under an open patch.
        let Some(open) = open else { return Ok((SurfaceGreen::of_set(body, set), report, None)) };
        let (greens, fields) = open.open(set).map_err(|error| self.refused("air_pumping", error, "other grooves"))?;
        Ok((greens, report, Some(fields)))
    }

    /// Open patch of the body; `None` where it is sealed.
    fn open_patch(&self) -> Result<Option<OpenPatch<'_>>, SetUpError> {
        let Self { path, body, gaps, .. } = *self;
        let Some(open) = OpenPatch::of(path, body, gaps) else { return Ok(None) };
        let (highest, fmax) = (open.highest(), path.radiation.fmax);
        if fmax > highest {
            let wrong = format!(
                "{fmax} Hz: where the field outside is taken over, the gap between tyre and road is more than a sixth \
                 of that wavelength high"
            );
            let right = format!("at most {:.0} Hz, or no [air_pumping]", 10.0 * (highest / 10.0).floor());
            return Err(self.refused("radiation.fmax", wrong, right));
        }
        Ok(Some(open))
    }
}
