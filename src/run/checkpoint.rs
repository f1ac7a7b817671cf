//! All that an unfinished run is: who it belongs to, and the state that its next steps depend on.
//!
//! A checkpoint is used only by the version that wrote it, with the scene and the road file that it was written for,
//! and where the tyre's influence functions come out with the same bits: then the run goes on as if it had never
//! stopped.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use sha2::{Digest, Sha256};

use crate::counters::process::cpu_time;
use crate::counters::{Allocations, Counters, Spent, Stage, StageCost, Work};
use crate::numeric::digest::{hexadecimal, sha256};
use crate::numeric::{StateError, StateReader, StateWriter, nanoseconds};
use crate::results::ResultsError;
use crate::results::checkpoint::{self, CHECKPOINT_FILE, CheckpointError, SCENE_FILE, Unusable};
use crate::results::folder::ResultsFolder;
use crate::run::error::RunError;
use crate::run::in_memory::Run;
use crate::run::prepare::Prepared;
use crate::run::road_ahead::Missing;
use crate::scene::LoadedScene;

/// What a checkpoint belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// The scene as used, as TOML.
    scene: String,
    /// The scene as written, as TOML.
    written: String,
    /// The scene's file.
    path: String,
    /// SHA-256 of the road file's content; empty without one.
    road: String,
}

impl Identity {
    /// Of a scene; reads its road file once.
    ///
    /// # Errors
    /// A scene that TOML cannot hold, a road file that cannot be read.
    pub fn of(loaded: &LoadedScene) -> Result<Self, RunError> {
        let road = match loaded.scene.road.file() {
            Some(file) => file_digest(file).map_err(|source| CheckpointError::Io { path: file.to_owned(), source })?,
            None => String::new(),
        };
        Ok(Self {
            scene: loaded.scene.to_toml()?,
            written: loaded.written_toml()?,
            path: loaded.path.to_string_lossy().into_owned(),
            road,
        })
    }

    /// The scene as used, as TOML.
    pub fn scene(&self) -> &str {
        &self.scene
    }
}

/// The body of a run's checkpoint; `wall` and `cpu` are wall and processor time of the run so far.
fn encode(identity: &Identity, run: &Run, wall: Duration, cpu: Option<Duration>) -> Vec<u8> {
    let mut state = StateWriter::default();
    state.text(env!("CARGO_PKG_VERSION"));
    state.text(&sha256(&[&identity.scene]));
    for text in [&identity.written, &identity.path, &identity.road] {
        state.text(text);
    }
    state.count(run.prepared.march.next_step());
    state.text(&influence_digest(&run.prepared));
    state.counts(&[nanoseconds(wall), cpu.map_or(0, nanoseconds)]);
    let Counters { stages, counts, in_steps, timed_steps, steps } = run.meter.counters();
    let times = |spent: Spent| [spent.wall, spent.watched, spent.cpu].map(nanoseconds);
    state.count(timed_steps);
    state.counts(&times(steps));
    for (cost, in_steps) in stages.into_iter().zip(in_steps) {
        let StageCost { calls, spent, watched_all, background, work, allocations, peak_memory } = cost;
        state.counts(&[calls, work.multiply_adds, work.bytes]);
        state.counts(&[watched_all, background].map(nanoseconds));
        state.counts(&times(spent));
        state.counts(&times(in_steps));
        // Nothing is what is not known.
        let Allocations { count, bytes } = allocations.unwrap_or_default();
        state.counts(&[u64::from(allocations.is_some()), count, bytes, peak_memory.unwrap_or(0)]);
    }
    state.counts(&counts);
    run.record.save(&mut state);
    run.prepared.axle.save(&mut state);
    run.prepared.road.save(&mut state);
    run.prepared.march.save(&mut state);
    state.into_bytes()
}

/// A checkpoint that belongs to a known scene, version and road; its state is still to be read.
pub struct Checkpoint {
    path: PathBuf,
    body: Vec<u8>,
    /// Where the state begins in the body.
    begin: usize,
    /// Steps done.
    pub steps: u64,
    /// The scene that it belongs to.
    pub loaded: LoadedScene,
}

impl Checkpoint {
    /// Reads the checkpoint of an unfinished run and checks whose it is.
    ///
    /// # Errors
    /// [`CheckpointError`].
    pub fn read(folder: &Path) -> Result<Self, RunError> {
        let body = checkpoint::read(folder)?;
        let path = folder.join(CHECKPOINT_FILE);
        let unusable = |reason: Unusable| CheckpointError::Unusable { path: path.clone(), reason };
        let of_state = |error: StateError| unusable(error.into());
        let mut state = StateReader::new(&body);
        let program = state.text().map_err(of_state)?;
        if program != env!("CARGO_PKG_VERSION") {
            return Err(unusable(Unusable::Program { found: program.to_owned() }).into());
        }
        let scene_path = folder.join(SCENE_FILE);
        let scene =
            std::fs::read_to_string(&scene_path).map_err(|source| CheckpointError::Io { path: scene_path, source })?;
        if state.text().map_err(of_state)? != sha256(&[&scene]) {
            return Err(unusable(Unusable::Scene).into());
        }
        let mut text = || state.text().map_err(of_state);
        let (written, name, road) = (text()?, PathBuf::from(text()?), text()?);
        let source = name.parent().map(Path::to_owned).unwrap_or_default();
        let loaded = LoadedScene::restored(written, &scene, name, source)?;
        if Identity::of(&loaded)?.road != road {
            let file = loaded.scene.road.file().unwrap_or(Path::new("")).to_owned();
            return Err(unusable(Unusable::Road { file }).into());
        }
        let steps = state.count().map_err(of_state)?;
        let begin = body.len() - state.left();
        Ok(Self { path, begin, steps, loaded, body })
    }

    /// Brings a prepared run to the state; returns the wall and processor time that it had taken before.
    ///
    /// # Errors
    /// [`CheckpointError::Unusable`]; the parts are of no use then.
    pub fn restore(&self, run: &mut Run) -> Result<[Duration; 2], RunError> {
        let unusable = |reason| CheckpointError::Unusable { path: self.path.clone(), reason };
        let mut state = StateReader::new(&self.body[self.begin..]);
        let influence = state.text().map_err(|error| unusable(error.into()))?;
        if influence != influence_digest(&run.prepared) {
            return Err(unusable(Unusable::Influence).into());
        }
        let (earlier, missing) = self.read_state(&mut state, run).map_err(|error| unusable(error.into()))?;
        state.end().map_err(|error| unusable(error.into()))?;
        run.prepared.road.refill(&missing, &mut run.meter)?;
        Ok(earlier)
    }

    fn read_state(&self, state: &mut StateReader<'_>, run: &mut Run) -> Result<([Duration; 2], Missing), StateError> {
        let mut earlier = [0; 2];
        state.counts_into(&mut earlier)?;
        let times = |state: &mut StateReader<'_>| -> Result<Spent, StateError> {
            let mut times = [0; 3];
            state.counts_into(&mut times)?;
            let [wall, watched, cpu] = times.map(Duration::from_nanos);
            Ok(Spent { wall, watched, cpu })
        };
        let mut counters = Counters { timed_steps: state.count()?, steps: times(state)?, ..Counters::default() };
        for (cost, in_steps) in counters.stages.iter_mut().zip(&mut counters.in_steps) {
            let (mut counts, mut durations, mut memory) = ([0; 3], [0; 2], [0; 4]);
            state.counts_into(&mut counts)?;
            state.counts_into(&mut durations)?;
            let spent = times(state)?;
            *in_steps = times(state)?;
            state.counts_into(&mut memory)?;
            let [calls, multiply_adds, bytes] = counts;
            let work = Work { multiply_adds, bytes };
            let [watched_all, background] = durations.map(Duration::from_nanos);
            let [counted, count, bytes, peak] = memory;
            let allocations = (counted > 0).then_some(Allocations { count, bytes });
            let peak_memory = (peak > 0).then_some(peak);
            *cost = StageCost { calls, spent, watched_all, background, work, allocations, peak_memory };
        }
        state.counts_into(&mut counters.counts)?;
        run.meter.go_on(&counters);
        run.record.restore(state)?;
        run.prepared.axle.restore(state)?;
        let missing = run.prepared.road.restore(state)?;
        run.prepared.march.restore(state)?;
        if run.prepared.march.next_step() == self.steps {
            Ok((earlier.map(Duration::from_nanos), missing))
        } else {
            Err(StateError::Value)
        }
    }
}

/// Writes checkpoints as the time comes.
pub struct Checkpoints {
    identity: Identity,
    interval: Option<Duration>,
    last: Instant,
    /// When this process began with the run, what processor time it had taken by then, and the run's wall and processor
    /// time before that.
    begin: Instant,
    begin_cpu: Option<Duration>,
    earlier: [Duration; 2],
}

impl Checkpoints {
    /// Every `interval` seconds of wall time, not at all for 0; the run began at `begin`, by when the process had taken
    /// so much processor time, and had taken `earlier` (wall, processor) before.
    pub fn new(
        identity: Identity,
        interval: f64,
        (begin, begin_cpu): (Instant, Option<Duration>),
        earlier: [Duration; 2],
    ) -> Self {
        let interval = Duration::try_from_secs_f64(interval).ok().filter(|interval| !interval.is_zero());
        Self { identity, interval, last: Instant::now(), begin, begin_cpu, earlier }
    }

    /// Wall time of the whole run so far.
    pub fn wall(&self) -> Duration {
        self.earlier[0] + self.begin.elapsed()
    }

    /// Processor time of all threads for the whole run so far; `None` where the system does not tell.
    pub fn cpu(&self) -> Option<Duration> {
        cpu_time().zip(self.begin_cpu).map(|(now, begin)| self.earlier[1] + now.saturating_sub(begin))
    }

    /// Whether it is time for one.
    pub fn due(&self) -> bool {
        self.interval.is_some_and(|interval| self.last.elapsed() >= interval)
    }

    /// Brings the arrays to the disk, then the state.
    ///
    /// # Errors
    /// [`ResultsError`]; the checkpoint before stays whole then.
    pub fn write(&mut self, folder: &mut ResultsFolder, run: &mut Run) -> Result<(), ResultsError> {
        run.record.sync(&mut run.meter)?;
        if !folder.holds_checkpoint() {
            folder.write_text(SCENE_FILE, self.identity.scene())?;
        }
        let open = run.meter.open();
        checkpoint::write(folder.working(), &encode(&self.identity, run, self.wall(), self.cpu()))?;
        folder.keep_if_stopped();
        run.meter.close(open, Stage::Output);
        self.last = Instant::now();
        Ok(())
    }
}

/// SHA-256 of the first weights: other bits there mean other bits everywhere.
fn influence_digest(prepared: &Prepared) -> String {
    let mut hash = Sha256::new();
    prepared.march.kernel().instant.iter().for_each(|value| hash.update(value.to_le_bytes()));
    hexadecimal(hash.finalize())
}

fn file_digest(path: &Path) -> std::io::Result<String> {
    let mut reader = BufReader::with_capacity(1 << 16, File::open(path)?);
    let (mut hash, mut block) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match reader.read(&mut block)? {
            0 => return Ok(hexadecimal(hash.finalize())),
            count => hash.update(&block[..count]),
        }
    }
}
