//! Transfer path of the sound: G from the cache or by boundary elements, and the waves of the tyre that meet it.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use num_complex::Complex32;
use rayon::prelude::*;

use super::groove_fields::GrooveFields;
use super::kept_transfers::KeptTransfers;
use super::open_patch::{OpenPatch, Opened};
use super::planned::Sound;
use crate::contact::cells::gaps::GapMap;
use crate::counters::{Counter, Job, Stage, Work};
use crate::effects::effect::ContactFacts;
use crate::effects::error::RunError;
use crate::plan::Plan;
use crate::radiation::transfer::contact_distance;
use crate::radiation::{Body, RadiationError, TransferSet, Watch, draft, transfers};
use crate::response::pressure::{PressureModel, PressureTransfers, SurfaceGreen};
use crate::response::vibration::SegmentLayout;
use crate::results::sound::BodySummary;
use crate::scene::{LoadedScene, RadiationQuality, SceneError};
use crate::sound::Air;
use crate::storage::Cache;
use crate::tyre::influence::{SurfaceWaves, TractionWaves};

/// Relative tolerance of the waves' compliances.
pub(crate) const WAVES: f64 = 1e-4;

/// Facts of the transfer path that are kept once its transfers are known.
pub(super) struct Way {
    /// Air of the run.
    pub(super) air: Air,
    /// Whole time steps of each point's propagation delay, by which its pressures are early.
    pub(super) delays: Vec<u64>,
    /// Summary of the body and its solution.
    pub(super) body: BodySummary,
    /// Fields in the grooves, where air passes through the patch.
    pub(super) grooves: Option<GrooveFields>,
}

impl Way {
    /// The path as far as it is known before anything is solved; `None` for a body or air that the run will refuse.
    pub(super) fn expected(plan: &Plan, sound: &Sound) -> Option<Self> {
        let air = Air::at(sound.radiation.temperature)?;
        let body = plan.radiating_body(&sound.radiation, plan.expected().length).ok()?;
        let (delays, _) = delays(sound, &body, &air);
        let body = BodySummary::of(sound.radiation.quality, &body, &air);
        Some(Self { air, delays, body, grooves: None })
    }
}

/// Propagation delays of all points: in whole time steps, and the remainder \[s\].
fn delays(sound: &Sound, body: &Body, air: &Air) -> (Vec<u64>, Vec<f64>) {
    let step = sound.layout.time_step;
    let late = |&position: &[f64; 3]| contact_distance(body, position) / air.sound_speed;
    let split = |late: f64| ((late / step).floor() as u64, late - (late / step).floor() * step);
    sound.positions.iter().map(late).map(split).unzip()
}

/// Input of a transfer path.
pub(super) struct TransferSearch<'a> {
    /// Scene of the run.
    pub(super) loaded: &'a LoadedScene,
    /// Plan of the run.
    pub(super) plan: &'a Plan,
    /// Sound of the plan.
    pub(super) sound: &'a Sound,
    /// Blocks of the forces.
    pub(super) layout: SegmentLayout,
}

impl TransferSearch<'_> {
    /// Finds the transfers to all points.
    ///
    /// # Errors
    /// Complaints about the scene; [`RunError::Interrupted`].
    pub(super) fn find(&self, contact: &ContactFacts, job: &mut Job<'_>) -> Result<(Way, PressureTransfers), RunError> {
        let Self { plan, sound, layout, .. } = *self;
        let tyre = &plan.decisions.tyre;
        let air = Air::at(sound.radiation.temperature).ok_or_else(|| {
            self.refused("radiation.temperature", "air cannot be this cold".to_owned(), "a higher temperature")
        })?;
        let open = job.meter.open();
        job.progress.stage(Stage::Radiation);
        let body = self.body(contact.at_rest.length)?;
        let (greens, summary, grooves) = self.greens(&air, &body, &contact.gaps, job)?;
        let (delays, of_points) = delays(sound, &body, &air);
        // Points in grooves have no delay.
        let delay = |streamed| sound.spectrum_of(streamed).map_or(0.0, |spectrum| of_points[spectrum % sound.points()]);
        let delays_of_all = (0..greens.len()).map(delay).collect();
        let (lateral, highest) = (sound.lateral_numbers(tyre), 0.5 / layout.time_step);
        let rule = sound.flank(&body).map(|flank| flank.rule);
        let around = Sound::GRID.around / 2;
        let wanted = [highest, WAVES];
        let tangential =
            plan.scene.has_tractions().then(|| Arc::new(TractionWaves::new(tyre, around, &lateral, wanted)));
        let (waves, known) = match Cache::open() {
            Ok(cache) => SurfaceWaves::fetch(&cache, tyre, around, lateral, wanted, rule.as_ref(), &mut job.warnings),
            // The cache of the transfers has warned of that.
            Err(_) => (SurfaceWaves::with_flank(tyre, around, lateral, wanted, rule.as_ref()), false),
        };
        if !known {
            job.meter.count(Counter::ComplianceEvaluations, waves.evaluations());
        }
        let model = PressureModel {
            layout,
            waves: Arc::new(waves),
            tangential,
            scale: contact.scale,
            contact_width: tyre.contact_width,
            density: air.density,
            air: sound.radiation.air,
            highest: sound.radiation.fmax,
            delays: delays_of_all,
            strips: None,
        };
        job.meter.close(open, Stage::Radiation);
        Ok((Way { air, delays, body: summary, grooves }, PressureTransfers { model, greens: greens.into() }))
    }

    fn refused(&self, key: &str, wrong: String, right: &str) -> RunError {
        SceneError::from(self.loaded.complain(key, wrong, right)).into()
    }

    /// Body that radiates, with a patch as long as that of the static contact \[m\].
    fn body(&self, at_rest: f64) -> Result<Body, RunError> {
        let Self { plan, sound, .. } = *self;
        plan.radiating_body(&sound.radiation, at_rest).map_err(|error| {
            let key = match error {
                RadiationError::Gap { .. } => "radiation.acoustic_gap",
                RadiationError::Shoulder { .. } => "radiation.shoulder",
                _ => "radiation.patch_length",
            };
            self.refused(key, error.to_string(), "another one")
        })
    }

    /// G from the tread to all points, stored on disk or solved for.
    fn greens(
        &self,
        air: &Air,
        body: &Body,
        gaps: &[GapMap],
        job: &mut Job<'_>,
    ) -> Result<(Vec<SurfaceGreen>, BodySummary, Option<GrooveFields>), RunError> {
        let Self { plan, sound, .. } = *self;
        // 1. Transfers of the sealed body: a draft, or stored ones and boundary elements.
        let problem = sound.problem(body, plan.scene.numerics.memory_bytes());
        let range = sound.range(air);
        if sound.radiation.quality == RadiationQuality::Draft {
            let set = draft::transfers(&problem, &range)
                .map_err(|error| self.refused("radiation.quality", error.to_string(), "\"full\""))?;
            let summary = BodySummary {
                frequencies: set.frequencies().len(),
                ..BodySummary::of(RadiationQuality::Draft, body, air)
            };
            return Ok((surface_greens(set, body, sound), summary, None));
        }
        let open = self.open_patch(air, body, gaps)?;
        let kept = KeptTransfers::open(&problem, &range, sound, &mut job.warnings);
        let mut troubles = Vec::new();
        let mut watch = Watch {
            known: &mut |wanted| kept.load(wanted, &mut job.warnings),
            sink: &mut |found| {
                kept.store(found, &mut troubles);
                Ok(())
            },
            progress: &mut |so_far| job.progress.pieces(so_far.finished, so_far.open),
            interrupted: &|| job.stop.load(Ordering::Relaxed),
        };
        let found = transfers(&problem, &range, rayon::current_num_threads(), &mut watch);
        job.warnings.extend(troubles);
        let (set, report) = found.map_err(|error| match error {
            RadiationError::Interrupted => {
                job.progress.note("frequencies of the radiation that were solved are kept for the next run");
                RunError::Interrupted { kept: None }
            }
            error @ RadiationError::Memory { .. } => {
                self.refused("numerics.memory_limit", error.to_string(), "more, or a lower radiation.fmax")
            }
            error @ RadiationError::Point { .. } => self.refused("receiver", error.to_string(), "a place in the air"),
            error => self.refused("radiation.fmax", error.to_string(), "another one"),
        })?;
        job.meter.count(Counter::RadiationSolves, report.solved as u64);
        let work = report.solve.work;
        job.meter.count(Counter::RadiationKernels, work.far_evaluations + work.near_evaluations);
        let multiply_adds = (0.5 * report.solve.factor_operations) as u64;
        job.meter.add_work(Stage::Radiation, Work { multiply_adds, bytes: 0 });
        let summary = BodySummary {
            frequencies: report.count,
            solved: report.solved,
            unknowns: report.solve.unknowns,
            interpolation_error: report.largest_passed.max(report.largest_unhalved),
            reciprocal_condition: (report.solved > 0).then_some(report.reciprocal_condition),
            ..BodySummary::of(RadiationQuality::Full, body, air)
        };
        // 2. Fields under an open patch.
        let Some(open) = open else { return Ok((surface_greens(set, body, sound), summary, None)) };
        let opened = open.open(set).map_err(|error| self.refused("air_pumping", error.to_string(), "other grooves"))?;
        let Opened { set, under, of_middles, fields } = opened;
        let mut greens = surface_greens(set, body, sound);
        // 3. G by point: the first place, points in grooves, then the other places.
        let mut under = under.into_iter();
        let first = under.next().unwrap_or_default();
        let sealed = if under.len() > 0 { greens.clone() } else { Vec::new() };
        // The pressures in grooves leave out sources beyond the sheet.
        let silent = greens.first().filter(|_| !of_middles.is_empty()).map(|first| {
            let values = first.values.iter().map(|values| vec![Complex32::ZERO; values.len()]).collect();
            SurfaceGreen { values, ..first.clone() }
        });
        greens.iter_mut().zip(first).for_each(|(green, under)| green.under_patch = Some(under));
        let of = |under| silent.clone().map(|green| SurfaceGreen { under_patch: Some(under), ..green });
        greens.extend(of_middles.into_iter().filter_map(of));
        // Then those of the other places, point by point.
        for under in under {
            let pairs = sealed.iter().cloned().zip(under);
            greens.extend(pairs.map(|(green, under)| SurfaceGreen { under_patch: Some(under), ..green }));
        }
        Ok((greens, summary, Some(fields)))
    }

    /// Open patch of a body; `None` where it is sealed.
    fn open_patch<'b>(&'b self, air: &Air, body: &'b Body, gaps: &[GapMap]) -> Result<Option<OpenPatch<'b>>, RunError> {
        let Some(open) = OpenPatch::of(self.sound, body, air, gaps) else { return Ok(None) };
        let (highest, fmax) = (open.highest(), self.sound.radiation.fmax);
        if fmax > highest {
            let wrong = format!(
                "{fmax} Hz: where the field outside is taken over, the gap between tyre and road is more than a sixth \
                 of that wavelength high"
            );
            let right = format!("at most {:.0} Hz, or no [air_pumping]", 10.0 * (highest / 10.0).floor());
            return Err(self.refused("radiation.fmax", wrong, &right));
        }
        Ok(Some(open))
    }
}

/// G on the tread for each receiver point, from a set of transfers.
fn surface_greens(set: TransferSet, body: &Body, sound: &Sound) -> Vec<SurfaceGreen> {
    let mut by_receiver = vec![Vec::new(); sound.points()];
    for found in set.into_frequencies() {
        for (known, transfer) in by_receiver.iter_mut().zip(found.transfers) {
            known.push((found.frequency, transfer));
        }
    }
    // Takes the set apart: each receiver's transfers become its values in place.
    by_receiver.into_par_iter().map(|known| SurfaceGreen::of(body, known)).collect()
}
