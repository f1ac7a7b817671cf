//! Everything that an unfinished run consists of: its identity, and the state that its next steps depend on.
//!
//! A checkpoint is used only by the version that wrote it, with the scene and the input files that it was written for,
//! beside arrays that hold the bytes that were written to them, and if the tyre's influence functions have the same
//! bits: then the run continues as if it had never stopped.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::counters::process::cpu_time;
use crate::counters::{Counters, Stage};
use crate::effects::RunError;
use crate::numeric::digest::{hexadecimal, sha256};
use crate::plan::MeshCorrections;
use crate::results::ResultsError;
use crate::results::arrays::WrittenArrays;
use crate::results::checkpoint::{self, CHECKPOINT_FILE, CheckpointError, SCENE_FILE, UnusableCheckpoint};
use crate::results::files::ResultFiles;
use crate::results::folder::ResultsFolder;
use crate::results::inputs::{Input, Inputs, changed};
use crate::run::prepare::Prepared;
use crate::run::simulation::Simulation;
use crate::scene::LoadedScene;
use crate::storage::input::{self, SCENE_BYTES};
use crate::storage::sealed_file::Body;
use crate::storage::state::{SavedState, StateError, ensure};

/// Identity of the run that a checkpoint belongs to.
#[derive(Deserialize, Serialize)]
struct Owner {
    /// SHA-256 of the effective scene, as TOML.
    scene: String,
    /// The scene as written, as TOML.
    written: String,
    /// Path of the scene's file.
    path: String,
    /// Files that the scene reads.
    inputs: Vec<Input>,
    /// Corrections of its levels.
    corrections: Option<MeshCorrections>,
}

impl Owner {
    /// Identity of a scene with its inputs; also the effective scene, as TOML.
    fn of(
        loaded: &LoadedScene,
        inputs: Vec<Input>,
        corrections: Option<MeshCorrections>,
    ) -> Result<(Self, String), RunError> {
        let scene = loaded.scene.to_toml()?;
        let path = loaded.path.to_string_lossy().into_owned();
        let written = loaded.written_toml()?;
        Ok((Self { scene: sha256(&[&scene]), written, path, inputs, corrections }, scene))
    }
}

/// State that a run's next steps and its results depend on.
#[derive(Deserialize, Serialize)]
struct RunState {
    /// SHA-256 of the first weights.
    influence: String,
    /// Length of the window of cells over that of the reported forces.
    window: f64,
    /// Wall and processor time so far.
    times: [Duration; 2],
    cost: Counters,
    simulation: SavedState,
}

/// A checkpoint whose identity has been checked; its state is still to be read.
pub(crate) struct Checkpoint {
    path: PathBuf,
    /// Rest of the file: a [`RunState`].
    state: Body,
    /// Number of steps done.
    pub steps: u64,
    /// Lengths and digests of the arrays when the checkpoint was written.
    pub written: WrittenArrays,
    /// The scene that it belongs to.
    pub loaded: LoadedScene,
    /// Files that the scene reads.
    pub inputs: Vec<Input>,
    /// Corrections of its levels.
    pub corrections: Option<MeshCorrections>,
}

impl Checkpoint {
    /// Reads the checkpoint of an unfinished run and checks its identity, and that the arrays hold what was written.
    ///
    /// # Errors
    /// [`CheckpointError`].
    pub(crate) fn read(folder: &Path) -> Result<Self, RunError> {
        let mut body = checkpoint::read(folder)?;
        let path = folder.join(CHECKPOINT_FILE);
        let unusable =
            |reason: UnusableCheckpoint| CheckpointError::Unusable { path: path.clone(), reason: reason.into() };
        let program: String = body.take().map_err(|error| unusable(error.into()))?;
        if program != env!("CARGO_PKG_VERSION") {
            return Err(unusable(UnusableCheckpoint::Program { found: program }).into());
        }
        let (owner, steps, written): (Owner, u64, WrittenArrays) =
            body.take().map_err(|error| unusable(error.into()))?;
        let scene_path = folder.join(SCENE_FILE);
        let scene = input::read_text(&scene_path, SCENE_BYTES)
            .map_err(|error| CheckpointError::Io { path: scene_path, source: error.into() })?;
        if owner.scene != sha256(&[&scene]) {
            return Err(unusable(UnusableCheckpoint::Scene).into());
        }
        let name = PathBuf::from(owner.path);
        let source = name.parent().map(Path::to_owned).unwrap_or_default();
        let loaded = LoadedScene::restored(&owner.written, &scene, name, source)?;
        let inputs = inputs_of(&loaded)?;
        if let Some(file) = changed(&owner.inputs, &inputs) {
            return Err(unusable(UnusableCheckpoint::Input { file: file.to_owned() }).into());
        }
        written.check(folder)?;
        Ok(Self { path, state: body, steps, written, loaded, inputs, corrections: owner.corrections })
    }

    /// Brings a prepared run to the state; returns its wall and processor time so far.
    ///
    /// # Errors
    /// [`CheckpointError::Unusable`]; the run must not be used then.
    pub(crate) fn restore(self, run: &mut Simulation) -> Result<[Duration; 2], RunError> {
        let Self { path, state, steps, .. } = self;
        let unusable = |reason: UnusableCheckpoint| CheckpointError::Unusable { path, reason: reason.into() };
        let state: RunState = match state.finish() {
            Ok(state) => state,
            Err(error) => return Err(unusable(error.into()).into()),
        };
        run.widen(state.window)?;
        if state.influence != influence_digest(&run.prepared) {
            return Err(unusable(UnusableCheckpoint::Influence).into());
        }
        let times = state.times;
        state.restore(steps, run).map_err(|error| unusable(error.into()))?;
        run.prepared.road.refill(&mut run.meter)?;
        Ok(times)
    }
}

impl RunState {
    /// State of a run; `times` are its wall and processor time so far.
    fn of(run: &mut Simulation, times: [Duration; 2]) -> Result<Self, StateError> {
        Ok(Self {
            influence: influence_digest(&run.prepared),
            window: run.window(),
            times,
            cost: run.meter.counters(),
            simulation: SavedState::of(run)?,
        })
    }

    /// Brings a run to this state after `steps` steps; the slices of its road still have to be made.
    fn restore(&self, steps: u64, run: &mut Simulation) -> Result<(), StateError> {
        run.meter.resume(&self.cost);
        self.simulation.restore(run)?;
        ensure(run.resume_after(steps))
    }
}

/// Writes checkpoints at intervals.
pub(crate) struct Checkpoints {
    owner: Owner,
    /// Effective scene, as TOML.
    scene: String,
    interval: Option<Duration>,
    last: Instant,
    /// Begin of the run in this process, the process's processor time at that moment, and the run's wall and processor
    /// time before.
    begin: Instant,
    begin_cpu: Option<Duration>,
    earlier: [Duration; 2],
}

impl Checkpoints {
    /// Checkpoints of the run of a scene with its inputs and the corrections of its levels, at the interval that the
    /// scene sets. The run began at `begin`, when the process had used `begin_cpu` of processor time, and had taken
    /// `earlier` (wall, processor) in other processes before.
    ///
    /// # Errors
    /// A scene that TOML cannot hold.
    pub(crate) fn new(
        (loaded, inputs, corrections): (&LoadedScene, Vec<Input>, Option<MeshCorrections>),
        (begin, begin_cpu): (Instant, Option<Duration>),
        earlier: [Duration; 2],
    ) -> Result<Self, RunError> {
        let (owner, scene) = Owner::of(loaded, inputs, corrections)?;
        let interval = Duration::try_from_secs_f64(loaded.scene.outputs.checkpoint_interval);
        let interval = interval.ok().filter(|interval| !interval.is_zero());
        Ok(Self { owner, scene, interval, last: Instant::now(), begin, begin_cpu, earlier })
    }

    /// Wall time of the whole run until `now`.
    pub(crate) fn wall(&self, now: Instant) -> Duration {
        self.earlier[0] + now.saturating_duration_since(self.begin)
    }

    /// Processor time of all threads for the whole run so far; `None` if the system does not report it.
    pub(crate) fn cpu(&self) -> Option<Duration> {
        cpu_time().zip(self.begin_cpu).map(|(now, begin)| self.earlier[1] + now.saturating_sub(begin))
    }

    /// True if the interval has passed since the last checkpoint.
    pub(crate) fn due(&self) -> bool {
        self.interval.is_some_and(|interval| self.last.elapsed() >= interval)
    }

    /// Flushes the arrays to the disk, then writes the state.
    ///
    /// # Errors
    /// [`ResultsError`]; the previous checkpoint stays complete then.
    pub(crate) fn write(&mut self, folder: &mut ResultsFolder, run: &mut Simulation) -> Result<(), ResultsError> {
        let written = run.sync_arrays()?;
        if !folder.holds_checkpoint() {
            folder.write_text(SCENE_FILE, &self.scene)?;
        }
        let open = run.meter.open();
        let state = RunState::of(run, [self.wall(Instant::now()), self.cpu().unwrap_or_default()])?;
        let owned = (&self.owner, run.next_step(), written);
        checkpoint::write(folder.working(), &(env!("CARGO_PKG_VERSION"), owned, state))?;
        folder.keep_if_stopped();
        run.meter.close(open, Stage::Output);
        self.last = Instant::now();
        Ok(())
    }
}

/// SHA-256 of the first weights: if their bits differ, all results do.
fn influence_digest(prepared: &Prepared) -> String {
    let mut hash = Sha256::new();
    prepared.march.first_weights().iter().for_each(|value| hash.update(value.to_le_bytes()));
    hexadecimal(hash.finalize())
}

/// Files that a scene reads. Fails if one cannot be read.
pub(crate) fn inputs_of(loaded: &LoadedScene) -> Result<Vec<Input>, CheckpointError> {
    Inputs::default().of(&loaded.scene).map_err(|(path, source)| CheckpointError::Io { path, source })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::counters::Counter;
    use crate::plan::Plan;
    use crate::scene::{DEFAULT, LoadedScene, Scene, Setting};

    fn scene_with(settings: &[&str]) -> LoadedScene {
        let settings: Vec<Setting> = settings.iter().map(|text| Setting::parse(text).unwrap()).collect();
        Scene::from_str_with(DEFAULT, "default", &settings).unwrap()
    }

    /// A run over cells that reports forces over the part `reach` of the rigid chord, in a window `window` times as
    /// long.
    fn run_over(reach: f64, window: f64) -> Simulation {
        let settings = [
            "contact={zone=\"cells\",cells_across=1}",
            "numerics={elements=128,lateral_terms=3,pole_tolerance=1e-5}",
            "rolling.axle={indentation=0.006,ramp=0.0}",
            "rolling.warm_up=0.0",
            "rolling.duration=0.02",
        ];
        let loaded = scene_with(&settings);
        let mut plan = Plan::of(&loaded).unwrap();
        (plan.reach, plan.window) = (reach, window);
        Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap()
    }

    #[test]
    fn single_precision_is_the_same_after_a_stop() {
        single_precision_after_a_stop(
            "contact={zone=\"cells\",cells_across=4}",
            "lateral_terms=12,pole_tolerance=1e-4",
        );
        single_precision_after_a_stop("contact={zone=\"slices\"}", "pole_tolerance=1e-3");
    }

    fn single_precision_after_a_stop(contact: &str, poles: &str) {
        let to = |tolerance: &str| {
            let numerics = format!("numerics={{elements=128,{poles}{tolerance}}}");
            scene_with(&[
                contact,
                &numerics,
                "rolling.axle={indentation=0.006,ramp=0.0}",
                "rolling.warm_up=0.0",
                "rolling.duration=0.04",
            ])
        };
        let loaded = to(",contact_tolerance=1e-5");
        let plan = Plan::of(&loaded).unwrap();
        assert!(plan.is_single());
        let begin = || Simulation::begin(&loaded, &plan, &AtomicBool::new(false)).unwrap();
        let on = |threads: usize, stop: Option<u64>| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut run = begin();
                let mut found = forces(&mut run, stop.unwrap_or(u64::MAX));
                let Some(stop) = stop else { return found };
                let state = RunState::of(&mut run, [Duration::ZERO; 2]).unwrap();
                let mut resumed = begin();
                state.restore(stop, &mut resumed).unwrap();
                resumed.prepared.road.refill(&mut resumed.meter).unwrap();
                found.extend(forces(&mut resumed, u64::MAX));
                found
            })
        };
        let whole = on(1, None);
        assert!(whole.len() > 40 && whole.iter().any(|force| *force > 100.0));
        assert_eq!(on(2, None), whole);
        for (threads, stop) in [(1, 17), (2, 18), (1, 19), (2, 20)] {
            assert_eq!(on(threads, Some(stop)), whole, "{stop}");
        }
        // With the finest tolerance the forces differ slightly.
        let finest = to("");
        let exact = Plan::of(&finest).unwrap();
        assert!(!exact.is_single());
        let mut exact = Simulation::begin(&finest, &exact, &AtomicBool::new(false)).unwrap();
        let exact = forces(&mut exact, u64::MAX);
        let largest = exact.iter().fold(0.0_f64, |largest, force| largest.max(*force));
        let error = exact.iter().zip(&whole).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs())) / largest;
        println!("{contact}: forces by the tolerance {error:.1e}");
        assert!(error > 0.0 && error < 1e-4, "{error:e}");
    }

    /// Runs up to the step `end`, or to the last one; returns the forces \[N\].
    fn forces(run: &mut Simulation, end: u64) -> Vec<f64> {
        std::iter::from_fn(|| (run.next_step() < end).then(|| run.step().unwrap()).flatten())
            .map(|step| step.total_force)
            .collect()
    }

    #[test]
    fn an_outgrown_window_is_widened_with_the_same_bits() {
        let whole = forces(&mut run_over(1.0, 1.0), u64::MAX);
        let mut outgrown = run_over(0.3, 1.0);
        let found = forces(&mut outgrown, u64::MAX);
        let window = outgrown.window();
        let again = outgrown.finish().meter.counted(Counter::WindowEdgeContacts);
        assert!(window > 1.0 && again > 0, "contact stayed within {window} windows, {again} times outgrown");
        // Steps that were recorded are not recorded again; the end is that of a window which had this length from the
        // start.
        assert_eq!(found.len(), whole.len());
        let mut wide = run_over(0.3, window);
        let from_the_start = forces(&mut wide, u64::MAX);
        let largest = whole.iter().fold(0.0_f64, |largest, &force| largest.max(force));
        assert_eq!(from_the_start.last(), found.last());
        assert_eq!(wide.finish().meter.counted(Counter::WindowEdgeContacts), 0);
        for (step, (a, b)) in found.iter().zip(&whole).enumerate() {
            assert!((a - b).abs() < 1e-4 * largest, "step {step}: {a} N, {b} N over the whole chord");
        }
        // State saved after half of the steps, restored to a run that has just begun.
        let half = whole.len() as u64 / 2;
        let mut stopped = run_over(0.3, 1.0);
        forces(&mut stopped, half);
        let state = RunState::of(&mut stopped, [Duration::ZERO; 2]).unwrap();
        let mut resumed = run_over(0.3, 1.0);
        resumed.widen(state.window).unwrap();
        state.restore(half, &mut resumed).unwrap();
        resumed.prepared.road.refill(&mut resumed.meter).unwrap();
        assert_eq!(forces(&mut resumed, u64::MAX), found[half as usize..]);
    }
}
