//! Results of every run: total force of every step, its spectrum, and the forces of the patch. Memory does not grow
//! with the number of steps.

use std::ops::Range;
use std::sync::Arc;

use ndarray::ArrayView2;

use super::channel::{Channel, Read, RowShape};
use super::effect::{Effect, RunStart};
use super::error::RunError;
use super::observer::{EffectObserver, End, Found, Observer, Step};
use super::section::{Figure, LevelTable, PageSection, ReportError, SectionBlock, levels, pictures};
use super::stored::Stored;
use crate::counters::{Job, Meter};
use crate::numeric::RunningMoments;
use crate::plan::front::FrontRow;
use crate::plan::{MeshCorrections, Plan, SEGMENT};
use crate::response::{BandLevel, LevelErrors, PowerSpectrum, SliceErrors, SpectrumAccumulator};
use crate::results::files::ResultFiles;
use crate::results::plots::{Axis, ForceMap, LinePlot, Series, ThirdOctavePlot};
use crate::results::spectra::{FORCE_LEVEL, LOWEST_FREQUENCY, SPECTRA_FILE, force_levels_csv};
use crate::results::summary::AxleMotion;
use crate::scene::{Axle, TimeRule};
use crate::storage::state::{StateError, StateStream, ensure};

pub(crate) struct ForceEffect;

static CHANNELS: [Channel; 6] = [
    Channel::new("time", "s", "time", Read::Number(|step| step.time)),
    Channel::new("total_force", "N", "contact force", Read::Number(|step| step.total_force)),
    Channel::new(
        "patch_force",
        "N",
        "contact force of an element in the window",
        Read::Row(|step| step.footprint.column_mean()),
    )
    .rows(RowShape::Columns),
    Channel::new(
        "patch_element",
        "1",
        "number of the element in the window's first column",
        Read::Count(|step| step.footprint.first_element()),
    ),
    Channel::new(
        "contact_length",
        "m",
        "length of the contact patch, from the first to the last element that carries force",
        Read::Number(|step| step.contact_length),
    ),
    Channel::new("axle", "m", "indentation of the rigid tyre into z = 0", Read::Number(|step| step.indentation))
        .only(moves),
];

/// True if the axle moves, so that its motion is a result.
fn moves(plan: &Plan) -> bool {
    matches!(plan.scene.rolling.axle, Axle::Mass { .. })
}

impl Effect for ForceEffect {
    fn name(&self) -> &'static str {
        "force"
    }

    fn channels(&self) -> &'static [Channel] {
        &CHANNELS
    }

    fn levels(&self) -> &'static [LevelTable] {
        &[LevelTable {
            file: SPECTRA_FILE,
            quantity: FORCE_LEVEL,
            column: "level_db_re_1n",
            errors: |stored| level_errors(&stored.plan, stored.summary.contact.slices.as_ref()),
        }]
    }

    fn figures(&self, stored: &Stored) -> Vec<Figure> {
        let outcome = &stored.summary.outcome;
        let figures = [
            Figure::of("mean force", "N", outcome.mean_force),
            Figure::of("force variation, rms", "N", outcome.rms_force_variation),
            Figure::of("contact length", "mm", outcome.mean_contact_length.map(|length| 1e3 * length)),
            Figure::of("indentation", "mm", outcome.indentation.map(|depth| 1e3 * depth)),
        ];
        figures.into_iter().flatten().collect()
    }

    fn sections(&self, stored: &Stored, _: &[Stored]) -> Result<Vec<PageSection>, ReportError> {
        let mut patch: Vec<SectionBlock> = total_force(stored)?.into_iter().collect();
        let caption = "Force of every element over patch and time; the axle is at 0, rolling to the right.";
        patch.extend(pictures(stored, &[["patch_force.svg", caption]])?);
        let spectrum = levels(stored, FORCE_LEVEL, "Contact force, third octaves")?;
        Ok(vec![
            PageSection { heading: "Contact", blocks: patch },
            PageSection { heading: "Force spectrum", blocks: spectrum },
        ])
    }

    fn begin(&self, begin: &mut RunStart<'_>, _: &mut Job<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError> {
        let RunStart { plan, contact, in_memory, .. } = *begin;
        let outputs = &plan.scene.outputs;
        let steps = plan.steps_drawn(contact.at_rest.length) as u64;
        let drawn = plan.warm_up_steps..(plan.warm_up_steps + steps.max(2)).min(plan.steps);
        let shown = if outputs.plots && !in_memory && plan.segments.is_none() { drawn } else { 0..0 };
        let rows = shown.end.saturating_sub(shown.start) as usize;
        let counted = (plan.steps - plan.warm_up_steps) as usize;
        let spectrum = in_memory || outputs.spectra || outputs.plots;
        let accumulator = || {
            let accumulator = SpectrumAccumulator::new(counted, plan.time_step, Some(SEGMENT)).ok()?;
            Some(accumulator.keeping(plan.kept_transforms))
        };
        Ok(Some(Box::new(ForceObserver {
            shown,
            drawn: Drawn {
                time: Vec::with_capacity(rows),
                first_element: Vec::with_capacity(rows),
                force: Vec::with_capacity(rows * contact.shape.columns),
            },
            force: RunningMoments::default(),
            indentation: moves(plan).then(RunningMoments::default),
            spectrum: spectrum.then(accumulator).flatten(),
            sum_of_lengths: 0.0,
            recording: (plan.scene.numerics.time_rule, plan.time_step),
            corrections: plan.corrections.clone(),
        })))
    }
}

pub(crate) struct ForceObserver {
    shown: Range<u64>,
    /// Steps of the force map.
    drawn: Drawn,
    /// Total force after the warm-up \[N\].
    force: RunningMoments,
    /// Indentation after the warm-up \[m\], if the axle moves.
    indentation: Option<RunningMoments>,
    /// Spectrum, if it is written or drawn and the run is long enough.
    spectrum: Option<SpectrumAccumulator>,
    sum_of_lengths: f64,
    /// Time rule whose mean force over a step is recorded, and the time step \[s\].
    recording: (TimeRule, f64),
    /// Corrections of the levels to a finer mesh.
    corrections: Option<Arc<MeshCorrections>>,
}

#[derive(Clone, Debug, Default)]
struct Drawn {
    /// Time of each step \[s\].
    time: Vec<f64>,
    first_element: Vec<i64>,
    /// Forces, step by step \[N\].
    force: Vec<f64>,
}

impl Observer for ForceObserver {
    fn observe(&mut self, step: &Step<'_>, _: &mut Meter) -> Result<(), RunError> {
        if self.shown.contains(&step.number) {
            self.drawn.time.push(step.time);
            self.drawn.first_element.push(step.footprint.first_element());
            self.drawn.force.extend_from_slice(step.footprint.column_mean());
        }
        if step.counts {
            self.force.push(step.total_force);
            if let Some(indentation) = &mut self.indentation {
                indentation.push(step.indentation);
            }
            self.sum_of_lengths += step.contact_length;
            if let Some(spectrum) = &mut self.spectrum {
                spectrum.push(step.total_force);
            }
        }
        Ok(())
    }
}

impl EffectObserver for ForceObserver {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.force, &mut self.indentation, &mut self.sum_of_lengths, &mut self.spectrum])?;
        let Drawn { time, first_element, force } = &mut self.drawn;
        state.growing(time)?;
        state.growing(first_element)?;
        state.growing(force)?;
        ensure(first_element.len() == time.len())
    }

    fn report(&self, end: &End<'_>, found: &mut Found) {
        let counted = self.force.count();
        found.outcome.mean_force = self.force.mean();
        found.outcome.rms_force_variation = self.force.variance().map(f64::sqrt);
        found.outcome.mean_contact_length = (counted > 0).then(|| self.sum_of_lengths / counted as f64);
        let motion = self.indentation.as_ref().and_then(|moments| moments.mean().zip(moments.variance()));
        found.outcome.axle = motion.map(|(mean, variance)| AxleMotion { mean, rms_variation: variance.sqrt() });
        if self.spectrum.is_none() && end.plan.scene.outputs.spectra {
            found.warnings.push("the run is too short for a spectrum".into());
        }
    }

    fn write(&self, end: &End<'_>, files: &dyn ResultFiles, _: &mut Found, _: &mut Meter) -> Result<(), RunError> {
        let outputs = &end.loaded.scene.outputs;
        // A run too short for a spectrum has none: the summary's warnings say so.
        if (outputs.spectra || outputs.plots)
            && let Some(spectrum) = self.spectrum()
        {
            let spectrum = spectrum.valid_to(end.valid_to);
            let levels = spectrum.third_octaves(LOWEST_FREQUENCY, 1.0);
            if outputs.spectra {
                let errors = level_errors(end.plan, end.slice_errors);
                let standard_error = |band| spectrum.standard_error([band]);
                let text = force_levels_csv(&levels, &errors, standard_error, |band| spectrum.correction(band));
                files.write_text(SPECTRA_FILE, &text)?;
            }
            if outputs.plots && !levels.is_empty() {
                files.write_text("force_spectrum.svg", &spectrum_picture(end, &levels)?)?;
            }
        }
        if outputs.plots && self.drawn.time.len() >= 2 {
            self.draw_patch(end, files)?;
        }
        Ok(())
    }
}

impl ForceObserver {
    /// Averaged spectrum of the force after the warm-up, of a complete run, corrected for the mean over a step.
    pub(crate) fn spectrum(&self) -> Option<PowerSpectrum> {
        let (rule, time_step) = self.recording;
        let spectrum = self.spectrum.clone().and_then(|spectrum| spectrum.finish().ok())?;
        let mut spectrum = spectrum.without_mean_of_steps(rule, time_step);
        if let Some(corrections) = &self.corrections {
            spectrum.correct(&corrections.force.gains(&spectrum));
        }
        Some(spectrum)
    }

    fn draw_patch(&self, end: &End<'_>, files: &dyn ResultFiles) -> Result<(), RunError> {
        let drawn = &self.drawn;
        let shape = (drawn.time.len(), end.geometry.columns);
        if let Ok(force) = ArrayView2::from_shape(shape, &drawn.force) {
            let map = ForceMap {
                title: &format!("Contact force over patch and time: {}", end.loaded.title()),
                time: &drawn.time,
                first_element: &drawn.first_element,
                force,
                element_length: end.plan.element,
                speed: end.plan.speed,
                start: end.geometry.start,
                shown: drawn.time[0]..f64::INFINITY,
            };
            files.write_text("patch_force.svg", &map.to_svg()?)?;
        }
        Ok(())
    }
}

/// Errors of the force's levels: those that a plan states, and those by slices.
fn level_errors(plan: &Plan, slices: Option<&SliceErrors>) -> LevelErrors {
    LevelErrors::new(FrontRow::stated_error(&plan.scene).ok(), plan.by_slices(), slices, SliceErrors::force)
}

fn spectrum_picture(end: &End<'_>, levels: &[BandLevel]) -> Result<String, RunError> {
    let plot = ThirdOctavePlot {
        title: &format!("Contact force, third octaves: {}", end.loaded.title()),
        quantity: FORCE_LEVEL,
        spectra: vec![("", levels)],
        errors: level_errors(end.plan, end.slice_errors),
    };
    Ok(plot.to_svg()?)
}

/// Total force over time of a run whose folder was read.
fn total_force(stored: &Stored) -> Result<Option<SectionBlock>, ReportError> {
    let (Some(time), Some(force)) = (stored.column("time.npy")?, stored.column("total_force.npy")?) else {
        return Ok(None);
    };
    let warm_up = stored.plan.scene.rolling.warm_up;
    let points: Vec<(f64, f64)> = time.into_iter().zip(force).filter(|(time, _)| *time >= warm_up).collect();
    let (Some((from, _)), Some((to, _))) = (points.first(), points.last()) else { return Ok(None) };
    let plot = LinePlot {
        title: "Total contact force",
        x: Axis::linear("Time [s]", *from..*to),
        y: Axis::linear_around("Force [N]", points.iter().map(|point| point.1)),
        series: vec![Series { name: "", points }],
    };
    let caption = "Total contact force of every step after the warm-up.".to_owned();
    Ok(Some(SectionBlock::Picture([plot.to_svg(), caption])))
}
