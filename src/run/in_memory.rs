//! Run whose arrays, tables and sounds stay in memory: the content of a folder, except pictures.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use crate::counters::process::cpu_time;
use crate::counters::{Meter, Progress, Stage, Watch};
use crate::effects::{KeptArray, RunError};
use crate::plan::Plan;
use crate::results::files::FilesInMemory;
use crate::results::summary::{Cost, Summary};
use crate::run::checkpoint::inputs_of;
use crate::run::look_back::{look_back, summary};
use crate::run::simulation::{Setup, Simulation};
use crate::scene::LoadedScene;

/// Results of a complete run in memory.
#[derive(Clone, Debug)]
pub struct RunInMemory {
    /// Summary, as in `summary.json`.
    pub summary: Summary,
    /// Arrays with a row per step.
    pub arrays: Vec<KeptArray>,
    /// Content of every other file, by name.
    pub files: BTreeMap<String, Vec<u8>>,
}

/// Runs a scene. `stop` is checked between steps: once it is set the run ends with an error.
///
/// # Errors
/// [`RunError`].
pub fn run_in_memory(
    loaded: &LoadedScene,
    stop: &AtomicBool,
    progress: &mut dyn Progress,
) -> Result<RunInMemory, RunError> {
    let (wall, cpu, meter) = (Instant::now(), cpu_time(), Meter::new(Watch::default()));
    let plan = Plan::of(loaded)?.with_cached_model();
    let loaded = &loaded.clone().settled(plan.scene.clone());
    plan.check(loaded)?;
    let mut undrawn = loaded.clone();
    undrawn.scene.outputs.plots = false;
    let inputs = inputs_of(loaded);
    let setup = Setup { stop, meter, progress, in_memory: true, without: &[] };
    let mut run = Simulation::prepare(&undrawn, &plan, setup)?;
    let inputs = inputs?;
    run.open_arrays(None)?;
    progress.march(0, plan.steps, plan.time_step);
    run.enter_steps();
    let complete = run.roll(&mut |run| {
        progress.step(run.next_step());
        Ok(!stop.load(Ordering::Relaxed))
    })?;
    if !complete {
        return Err(RunError::Interrupted { kept: None });
    }
    run.settle();
    let arrays = run.finish_arrays()?;
    progress.stage(Stage::Response);
    let files = FilesInMemory::default();
    let found = look_back(&mut run, &files, true)?;
    let spent = cpu.zip(cpu_time()).map(|(before, after)| after.saturating_sub(before));
    let seconds = wall.elapsed().as_secs_f64();
    let cost = |meter: &Meter| Cost::new(meter, seconds, rayon::current_num_threads()).with_cpu(spent);
    let summary = Summary { complete: true, inputs, ..summary(&run, loaded, found, cost)? };
    Ok(RunInMemory { summary, arrays, files: files.into_inner() })
}
