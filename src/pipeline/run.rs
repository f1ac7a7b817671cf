//! The run: every step, then spectra, plots and summary.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use ndarray::ArrayView2;

use super::error::RunError;
use super::plan::Plan;
use super::prepare::{Prepared, prepare};
use super::progress::Progress;
use super::record::{Record, StepRecord};
use crate::meter::{Counter, Meter, Stage};
use crate::response::PowerSpectrum;
use crate::results::folder::ResultsFolder;
use crate::results::plots::{ForceMap, ThirdOctavePlot};
use crate::results::spectra::{SPECTRA_FILE, force_levels_csv};
use crate::results::summary::{ContactQuality, Cost, LoadResult, Outcome, Summary};
use crate::scene::{Axle, LoadedScene};

/// Lowest band of the force spectrum \[Hz\]: below, a run of seconds says little.
const LOWEST_FREQUENCY: f64 = 20.0;
/// Segments of the averaged spectrum \[s\].
const SEGMENT: f64 = 0.5;
/// Part of the run that the force map shows, in contact lengths rolled.
const LENGTHS_DRAWN: f64 = 6.0;
/// Steps between two looks at the interrupt flag and the progress bar.
const LOOK_EVERY: u64 = 16;

/// Where results go and on how many threads the run is.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Results folder.
    pub target: PathBuf,
    /// Threads of the pool that the run is executed on, for the record.
    pub threads: usize,
}

/// What a complete run hands back.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// The results folder.
    pub folder: PathBuf,
    /// Its summary.
    pub summary: Summary,
    /// Stage times and counters.
    pub meter: Meter,
    /// Wall time.
    pub wall: std::time::Duration,
}

/// Runs a scene. `stop` is looked at between steps: once it is set the run ends and keeps what it has.
///
/// # Errors
/// [`RunError`]; nothing is left under the target's name then.
pub fn run(
    loaded: &LoadedScene,
    options: &RunOptions,
    stop: &AtomicBool,
    progress: &mut dyn Progress,
) -> Result<RunReport, RunError> {
    let begin = Instant::now();
    loaded.check_time_domain()?;
    let plan = Plan::new(&loaded.scene);
    plan.check(loaded)?;
    // A place that cannot be written to is refused before the long work, not after it; the folder itself is made when there is something to put in.
    drop(ResultsFolder::create(&options.target)?);
    let mut meter = Meter::default();
    progress.stage(Stage::Influence);
    let mut prepared = prepare(loaded, &plan, &mut meter)?;
    for warning in &prepared.warnings {
        progress.note(warning);
    }
    if stop.load(Ordering::Relaxed) {
        return Err(RunError::Interrupted { kept: None });
    }

    let folder = ResultsFolder::create(&options.target)?;
    let drawn = (LENGTHS_DRAWN * prepared.at_rest.length / plan.speed / plan.time_step) as u64;
    let shown = plan.warm_up_steps..plan.warm_up_steps + drawn.max(2);
    let columns = prepared.march.geometry().columns;
    let mut record = Record::new(&folder, &loaded.scene.outputs, columns, plan.warm_up_steps, shown)?;
    progress.march(plan.steps, plan.time_step);
    let interrupted = march(&plan, &mut prepared, &mut record, stop, progress, &mut meter)?;
    record.finish(&mut meter)?;
    progress.stage(Stage::Response);

    let context = Context { loaded, plan: &plan, prepared: &prepared, record: &record };
    if !interrupted {
        let drawn = Instant::now();
        context.spectra_and_plots(&folder)?;
        meter.add_time(Stage::Response, drawn.elapsed());
    }
    let wall = begin.elapsed();
    let summary = context.summary(Cost::new(&meter, wall.as_secs_f64(), options.threads))?;
    for warning in &summary.warnings[prepared.warnings.len()..] {
        progress.note(warning);
    }
    progress.finish();
    if interrupted {
        let kept = folder.finish_partial(summary)?;
        return Err(RunError::Interrupted { kept: Some(kept) });
    }
    let folder = folder.finish(summary.clone())?;
    Ok(RunReport { folder, summary: Summary { complete: true, ..summary }, meter, wall })
}

/// All steps; returns whether the user stopped them.
fn march(
    plan: &Plan,
    prepared: &mut Prepared,
    record: &mut Record,
    stop: &AtomicBool,
    progress: &mut dyn Progress,
    meter: &mut Meter,
) -> Result<bool, RunError> {
    let Prepared { march, road, axle, .. } = prepared;
    let (columns, element) = (march.geometry().columns as i64, plan.element);
    let mut interrupted = false;
    for step in 0..plan.steps {
        if step % LOOK_EVERY == 0 {
            progress.step(step);
            if stop.load(Ordering::Relaxed) {
                interrupted = true;
                break;
            }
        }
        let first = march.geometry().first_element(step);
        road.reach(first, first + columns, meter)?;
        let result = march.step(axle, road.slices())?;
        axle.observe(step, result.total_force);
        record.push(
            StepRecord {
                step,
                time: step as f64 * plan.time_step,
                total_force: result.total_force,
                first_element: result.first_element,
                forces: march.forces(),
                contact_length: result.extent as f64 * element,
            },
            meter,
        )?;
    }
    let (totals, counts) = (march.totals(), march.search_counts());
    meter.add_time(Stage::History, totals.history_time);
    meter.add_time(Stage::ActiveSet, totals.search_time);
    for (counter, amount) in [
        (Counter::Steps, march.next_step()),
        (Counter::HistoryMultiplyAdds, totals.multiply_adds),
        (Counter::WindowEdgeContacts, totals.edge_contacts),
        (Counter::Solves, counts.solves),
        (Counter::Fallbacks, counts.fallbacks),
        (Counter::Factorisations, counts.factors.factorisations),
        (Counter::CacheHits, counts.factors.hits),
        (Counter::CacheMisses, counts.factors.misses),
        (Counter::CacheEvictions, counts.factors.evictions),
    ] {
        meter.count(counter, amount);
    }
    Ok(interrupted)
}

/// What the end of a run looks back at.
struct Context<'a> {
    loaded: &'a LoadedScene,
    plan: &'a Plan,
    prepared: &'a Prepared,
    record: &'a Record,
}

impl Context<'_> {
    fn spectra_and_plots(&self, folder: &ResultsFolder) -> Result<(), RunError> {
        let outputs = &self.loaded.scene.outputs;
        let title = self.loaded.title();
        // A run too short for a spectrum has none: the summary's warnings say so.
        if (outputs.spectra || outputs.plots)
            && let Ok(spectrum) = PowerSpectrum::of(&self.record.force, self.plan.time_step, Some(SEGMENT))
        {
            let levels = spectrum.third_octaves(LOWEST_FREQUENCY, 1.0);
            if outputs.spectra {
                folder.write_text(SPECTRA_FILE, &force_levels_csv(&levels, Path::new(SPECTRA_FILE))?)?;
            }
            if outputs.plots && !levels.is_empty() {
                let plot = ThirdOctavePlot {
                    title: &title,
                    quantity: "Contact force level [dB re 1 N]",
                    spectra: vec![("", &levels)],
                };
                folder.write_text("force_spectrum.svg", &plot.to_svg()?)?;
            }
        }
        let drawn = &self.record.drawn;
        if outputs.plots && drawn.time.len() >= 2 {
            let geometry = self.prepared.march.geometry();
            let shape = (drawn.time.len(), geometry.columns);
            if let Ok(force) = ArrayView2::from_shape(shape, &drawn.force) {
                let map = ForceMap {
                    title: &title,
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

    fn summary(&self, cost: Cost) -> Result<Summary, RunError> {
        let march = &self.prepared.march;
        let (totals, counts) = (march.totals(), march.search_counts());
        let steps = march.next_step();
        let mean_force = self.record.mean_force();
        let load = match (&self.loaded.scene.rolling.axle, mean_force) {
            (&Axle::Load { load, tolerance }, Some(mean)) => {
                let relative_error = (mean - load) / load;
                Some(LoadResult { wanted: load, relative_error, tolerance, met: relative_error.abs() <= tolerance })
            }
            _ => None,
        };
        let mut summary = Summary::begun(&self.loaded.title(), self.loaded.settings()?, cost);
        summary.outcome = Outcome {
            steps,
            time_step: self.plan.time_step,
            simulated_time: steps as f64 * self.plan.time_step,
            mean_force,
            rms_force_variation: self.record.rms_force_variation(),
            mean_contact_length: self.record.mean_contact_length(),
            indentation: Some(self.prepared.axle.indentation(steps)),
            load,
        };
        let residuals = totals.relative_residuals();
        summary.contact = ContactQuality {
            tension: residuals.tension,
            penetration: residuals.penetration,
            complementarity: residuals.complementarity,
            aborted_searches: 0,
            solves_per_step: counts
                .histogram
                .iter()
                .enumerate()
                .filter(|(_, steps)| **steps > 0)
                .map(|(solves, &steps)| (solves as u32, steps))
                .collect::<BTreeMap<_, _>>(),
        };
        summary.warnings.clone_from(&self.prepared.warnings);
        if let Some(LoadResult { wanted, relative_error, tolerance, met: false }) = load {
            summary.warnings.push(format!(
                "the mean force is {:+.2} % off the load of {wanted} N (tolerance {} %): a longer warm_up corrects the height more exactly",
                100.0 * relative_error,
                100.0 * tolerance
            ));
        }
        if totals.edge_contacts > 0 {
            summary.warnings.push(format!(
                "in {} steps the outermost element of the window was in contact: the patch may be longer than the window",
                totals.edge_contacts
            ));
        }
        if self.record.force.len() < 8 && self.loaded.scene.outputs.spectra {
            summary.warnings.push("the run is too short for a spectrum".into());
        }
        Ok(summary)
    }
}
