//! A run to a results folder: every step, then spectra, plots and summary.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::counters::process::cpu_time;
use crate::counters::{Job, MachinePeak, Meter, Progress, Stage};
use crate::effects::RunError;
use crate::plan::{Forecast, Plan, process_memory, unit};
use crate::results::arrays::ArrayPlace;
use crate::results::folder::ResultsFolder;
use crate::results::placing::unfinished;
use crate::results::summary::{Planned, RunCost, Summary};
use crate::run::checkpoint::{Checkpoint, Checkpoints, inputs_of};
use crate::run::end::{finish, impossible_energy, summary};
use crate::run::meshes::corrected;
use crate::run::simulation::Simulation;
use crate::scene::LoadedScene;

/// Target of a run, and its number of threads.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Results folder.
    pub target: PathBuf,
    /// Threads of the pool that the run is executed on; only recorded.
    pub threads: usize,
}

/// Report of a complete run.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// Folder of the results.
    pub folder: PathBuf,
    /// Content of `summary.json`.
    pub summary: Summary,
    /// Stage times and counters.
    pub meter: Meter,
    /// Wall time of the whole run, earlier processes included.
    pub wall: std::time::Duration,
    /// Message on an impossible energy: the results are not those of any tyre.
    pub impossible: Option<String>,
}

/// Runs a scene into a folder. A job that is stopped ends after the present steps and keeps its partial results.
///
/// # Errors
/// [`RunError`]; nothing is left under the target's name then.
pub fn run(loaded: &LoadedScene, options: &RunOptions, mut job: Job<'_>) -> Result<RunReport, RunError> {
    let begin = Begin::now(&job.meter);
    loaded.check_time_domain()?;
    let plan = Plan::of(loaded)?.with_cached_model();
    let loaded = loaded.clone().settled(plan.scene.clone());
    plan.check(&loaded)?;
    // A target that cannot be written to is refused before the long work, not after it; the folder itself is created
    // when there is something to put in.
    drop(ResultsFolder::create(&options.target)?);
    if let Ok(unfinished) = unfinished(&options.target) {
        let target = options.target.display();
        job.progress.note(&format!(
            "an unfinished run is kept in {}: `tyrewave resume {target}` would continue it",
            unfinished.display()
        ));
    }
    let forecast = PlannedRun::forecast(&plan, options.threads, begin.process);
    let (loaded, plan) = corrected(loaded, plan, &mut job)?;
    let planned = PlannedRun { loaded: &loaded, plan: &plan, threads: options.threads, planned: forecast };
    planned.carry_out(begin, || Ok(ResultsFolder::create(&options.target)?), None, job)
}

/// Continues an unfinished run, given its results folder or its working folder, with the same bytes as if it had never
/// stopped. From now on the cost is measured as closely as the job says.
///
/// # Errors
/// [`RunError`]; [`RunError::Checkpoint`] if there is nothing to continue.
pub fn resume(path: &Path, threads: usize, job: Job<'_>) -> Result<RunReport, RunError> {
    let begin = Begin::now(&job.meter);
    ResultsFolder::put_in_order(path)?;
    let folder = ResultsFolder::reopen(path)?;
    let checkpoint = Checkpoint::read(folder.working())?;
    let loaded = checkpoint.loaded.clone();
    loaded.check_time_domain()?;
    let mut plan = Plan::of(&loaded)?;
    if let Some(corrections) = &checkpoint.corrections {
        plan.take_corrections(corrections.clone());
    }
    let plan = plan.with_cached_model();
    plan.check(&loaded)?;
    let planned = PlannedRun::forecast(&plan, threads, begin.process);
    let planned = PlannedRun { loaded: &loaded, plan: &plan, threads, planned };
    let partial = folder.working().to_owned();
    planned.carry_out(begin, || Ok(folder), Some(checkpoint), job).map_err(|error| match error {
        // Before its first step: what was stored is still there.
        RunError::Interrupted { partial: None } => RunError::Interrupted { partial: Some(partial) },
        other => other,
    })
}

/// A planned run, new or continued.
struct PlannedRun<'a> {
    loaded: &'a LoadedScene,
    plan: &'a Plan,
    threads: usize,
    planned: Planned,
}

/// Readings at the begin of a run.
struct Begin {
    wall: Instant,
    cpu: Option<Duration>,
    /// Memory of the process without the run \[bytes\].
    process: f64,
}

impl Begin {
    fn now(meter: &Meter) -> Self {
        let (cpu, process) = (cpu_time(), process_memory());
        // A timeline and the wall time begin and end with the same reading of the clock.
        let wall = meter.trace().map_or_else(Instant::now, |trace| trace.began);
        Self { wall, cpu, process }
    }
}

impl PlannedRun<'_> {
    /// Forecast on `threads` threads, in a process that holds `process` besides \[bytes\].
    fn forecast(plan: &Plan, threads: usize, process: f64) -> Planned {
        let Forecast { wall_seconds, memory, measured, .. } = plan.forecast(&unit::known(), threads, process);
        Planned { wall_seconds, memory, measured }
    }

    fn carry_out(
        &self,
        begin: Begin,
        folder: impl FnOnce() -> Result<ResultsFolder, RunError>,
        checkpoint: Option<Checkpoint>,
        mut job: Job<'_>,
    ) -> Result<RunReport, RunError> {
        let Self { loaded, plan, .. } = *self;
        let Begin { wall, cpu, .. } = begin;
        // Hashed before they are read: a file that is changed meanwhile does not count as that of the results. A file
        // that cannot be read is reported by the stage that needs it.
        let inputs = checkpoint.as_ref().map_or_else(|| inputs_of(loaded), |checkpoint| Ok(checkpoint.inputs.clone()));
        let mut run = Simulation::prepare(loaded, plan, false, &[], &mut job)?;
        let inputs = inputs?;
        for note in &run.prepared.notes {
            job.progress.note(note);
        }
        for warning in &run.warnings {
            job.progress.warning(warning);
        }
        if job.is_stopped() {
            return Err(RunError::Interrupted { partial: None });
        }

        let mut folder = folder()?;
        let written = checkpoint.as_ref().map(|checkpoint| &checkpoint.written);
        run.open_arrays(Some(&ArrayPlace { folder: &folder, written }))?;
        let earlier = checkpoint.map_or(Ok([Duration::ZERO; 2]), |checkpoint| checkpoint.restore(&mut run))?;
        let corrections = plan.corrections.as_deref().cloned();
        let mut checkpoints = Checkpoints::new((loaded, inputs.clone(), corrections), (wall, cpu), earlier)?;
        let rolled = if plan.segments.is_some() {
            run.roll_to_end(&mut job).map(|()| true)
        } else {
            job.progress.march(run.next_step(), plan.steps, plan.time_step);
            run.enter_steps();
            run.roll(&mut |run| {
                run.report(job.progress);
                let interrupted = job.is_stopped();
                if interrupted || checkpoints.due() {
                    checkpoints.write(&mut folder, run)?;
                }
                Ok(!interrupted)
            })
        };
        run.settle();
        let ended = rolled.and_then(|complete| {
            let ended = self.end(&mut run, &folder, &checkpoints, complete, job.progress);
            ended.map(|summary| (complete, Summary { inputs, ..summary }))
        });
        let (complete, summary) = match ended {
            Ok(ended) => ended,
            Err(RunError::Results(source)) if folder.holds_checkpoint() => {
                return Err(RunError::Resumable { source, folder: folder.stay() });
            }
            Err(error) => {
                // A continued run would fail again.
                folder.discard();
                return Err(error);
            }
        };
        job.progress.finish();
        if !complete {
            let partial = folder.finish_partial(summary)?;
            return Err(RunError::Interrupted { partial: Some(partial) });
        }
        let wall = Duration::from_secs_f64(summary.cost.wall_seconds);
        let folder = folder.finish(summary.clone())?;
        let impossible = impossible_energy(&loaded.scene, &summary.outcome);
        Ok(RunReport { impossible, folder, summary: Summary { complete: true, ..summary }, meter: run.meter, wall })
    }

    /// Writes the arrays, spectra and plots of a run that has ended or been stopped; returns its summary.
    fn end(
        &self,
        run: &mut Simulation,
        folder: &ResultsFolder,
        checkpoints: &Checkpoints,
        complete: bool,
        progress: &mut dyn Progress,
    ) -> Result<Summary, RunError> {
        run.finish_arrays()?;
        progress.stage(Stage::Response);
        let found = finish(run, folder, complete)?;
        let now = Instant::now();
        let (wall, cpu) = (checkpoints.wall(now), checkpoints.cpu());
        if let Some(trace) = run.meter.trace_mut() {
            trace.end(now);
        }
        let summary = summary(run, self.loaded, found, |meter| {
            let mut cost = RunCost::new(meter, wall.as_secs_f64(), self.threads).with_cpu(cpu);
            cost.planned = Some(self.planned);
            if meter.watches_closely() {
                // After the run, when its peak memory has been read.
                cost.machine_peak = Some(MachinePeak::measure());
            }
            cost
        })?;
        // A missed load is an error that the command reports.
        let missed = summary.outcome.load.filter(|load| !load.met).map(|load| load.to_string());
        let reported = run.warnings.len();
        for warning in summary.warnings[reported..].iter().filter(|warning| missed.as_ref() != Some(*warning)) {
            progress.warning(warning);
        }
        Ok(summary)
    }
}
