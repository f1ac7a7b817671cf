//! Run whose arrays, tables and sounds stay in memory: the content of a folder, except pictures.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::time::Instant;

use crate::counters::process::cpu_time;
use crate::counters::{Job, Meter, Stage};
use crate::effects::{KeptArray, RunError};
use crate::plan::Plan;
use crate::results::summary::{RunCost, Summary};
use crate::run::checkpoint::inputs_of;
use crate::run::end::{finish, summary};
use crate::run::meshes::corrected;
use crate::run::simulation::Simulation;
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

/// Runs a scene. A job that is stopped ends with an error after the present steps.
///
/// # Errors
/// [`RunError`].
pub fn run_in_memory(loaded: &LoadedScene, mut job: Job<'_>) -> Result<RunInMemory, RunError> {
    let (wall, cpu) = (Instant::now(), cpu_time());
    let plan = Plan::of(loaded)?.with_cached_model();
    let loaded = loaded.clone().settled(plan.scene.clone());
    plan.check(&loaded)?;
    let (loaded, plan) = corrected(loaded, plan, &mut job)?;
    let loaded = &loaded;
    let mut undrawn = loaded.clone();
    undrawn.scene.outputs.plots = false;
    let inputs = inputs_of(loaded);
    let mut run = Simulation::prepare(&undrawn, &plan, true, &[], &mut job)?;
    let inputs = inputs?;
    run.open_arrays(None)?;
    run.roll_to_end(&mut job)?;
    run.settle();
    let arrays = run.finish_arrays()?;
    job.progress.stage(Stage::Response);
    let files = RefCell::default();
    let found = finish(&mut run, &files, true)?;
    let spent = cpu.zip(cpu_time()).map(|(before, after)| after.saturating_sub(before));
    let seconds = wall.elapsed().as_secs_f64();
    let cost = |meter: &Meter| RunCost::new(meter, seconds, rayon::current_num_threads()).with_cpu(spent);
    let summary = Summary { complete: true, inputs, ..summary(&run, loaded, found, cost)? };
    Ok(RunInMemory { summary, arrays, files: files.into_inner() })
}
