//! Runs the variants of a sweep, several at a time.
//!
//! Workers take the variants one after the other; each has its own share of the threads, so that there are never more
//! threads than were asked for. The models of the tyre's influence functions that the variants need are fitted before,
//! once each, and then read by all from the cache.

use std::fs;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::counters::{Stage, Watch};
use crate::plan::Decisions;
use crate::plan::Plan;
use crate::response::BandLevel;
use crate::results::spectra::{SPECTRA_FILE, read_force_levels};
use crate::results::summary::{RollingResistance, SUMMARY_FILE};
use crate::results::unfinished::{forget_abandoned, unfinished};
use crate::run::checkpoint::Checkpoint;
use crate::run::past::{contact_field, fetch, fit_options};
use crate::run::{self, Progress, RunError, RunOptions};
use crate::scene::History;
use crate::study::sweep::variants::Variant;

/// How a variant ended.
#[derive(Debug)]
pub enum Outcome {
    /// Its results are there, found or made.
    Done {
        /// Whether an earlier sweep had finished it.
        found: bool,
        /// Third-octave levels of the contact force \[dB re 1 N\].
        levels: Vec<BandLevel>,
        /// Rolling resistance, where the tread law has one.
        rolling_resistance: Option<RollingResistance>,
    },
    /// It was stopped, or not begun, because the user wanted the end.
    Stopped,
    /// It failed.
    Failed(RunError),
}

/// Watches a sweep. Calls come from several threads.
pub trait SweepWatch: Sync {
    /// That many steps more are to be done in all.
    fn planned(&self, steps: u64);
    /// That many of them are done.
    fn done(&self, steps: u64);
    /// Something the user should know about a variant.
    fn note(&self, name: &str, text: &str);
}

/// Nobody watches.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unwatched;

impl SweepWatch for Unwatched {
    fn planned(&self, _steps: u64) {}
    fn done(&self, _steps: u64) {}
    fn note(&self, _name: &str, _text: &str) {}
}

/// Runs what is not finished under `target`, one folder per variant, on `threads` threads in all; how each ended, in
/// their order. A variant that fails does not stop the others.
pub fn sweep(
    variants: &[Variant],
    target: &Path,
    threads: usize,
    stop: &AtomicBool,
    watch: &dyn SweepWatch,
) -> Vec<Outcome> {
    let outcomes: Vec<Mutex<Option<Outcome>>> =
        variants.iter().map(|variant| Mutex::new(finished(variant, target))).collect();
    let left: Vec<usize> = (0..variants.len()).filter(|&index| lock(&outcomes[index]).is_none()).collect();
    share_models(left.iter().map(|&index| &variants[index]), stop);
    watch.planned(left.iter().map(|&index| Plan::new(&variants[index].loaded.scene).steps).sum());

    let workers = threads.min(left.len()).max(1);
    let next = AtomicUsize::new(0);
    let work = |worker: usize| {
        let share = threads / workers + usize::from(worker < threads % workers);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(share.max(1)).build().ok();
        while let Some(&index) = left.get(next.fetch_add(1, Ordering::Relaxed)) {
            let variant = &variants[index];
            let one = || carry_out(variant, target, share.max(1), stop, watch);
            // Without a pool of its own it runs on the caller's: slower for the others, the same results.
            let outcome = pool.as_ref().map_or_else(one, |pool| pool.install(one));
            *lock(&outcomes[index]) = Some(outcome);
        }
    };
    std::thread::scope(|scope| {
        for worker in 0..workers {
            let work = &work;
            scope.spawn(move || work(worker));
        }
    });
    let ended = |outcome: Mutex<Option<Outcome>>| outcome.into_inner().ok().flatten().unwrap_or(Outcome::Stopped);
    outcomes.into_iter().map(ended).collect()
}

/// The content, whoever has panicked while holding it.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Fits every model that the variants need and the cache does not have.
fn share_models<'a>(variants: impl Iterator<Item = &'a Variant>, stop: &AtomicBool) {
    let mut fitted = Vec::new();
    for variant in variants {
        let scene = &variant.loaded.scene;
        let Decisions { tyre, tread, .. } = Decisions::new(scene);
        let model = (tyre, fit_options(scene, contact_field(tread)));
        let needed = scene.numerics.history == History::Modal && !fitted.contains(&model);
        if needed && !stop.load(Ordering::Relaxed) {
            // A refusal is the variant's own to report.
            let _ = fetch(&model.0, &model.1, stop);
            fitted.push(model);
        }
    }
}

/// The levels of a variant that an earlier sweep has finished: the same scene, version and road file.
fn finished(variant: &Variant, target: &Path) -> Option<Outcome> {
    let folder = target.join(&variant.name);
    let summary = read_summary(&folder)?;
    let same = summary["complete"] == true
        && summary["scene_sha256"] == variant.loaded.hash.as_str()
        && summary["version"] == env!("CARGO_PKG_VERSION");
    let written = |path: &Path| fs::metadata(path).and_then(|file| file.modified()).ok();
    // A road file written after the results may have another content.
    let newer =
        variant.loaded.scene.road.file().is_some_and(|road| written(road) > written(&folder.join(SUMMARY_FILE)));
    if !same || newer {
        return None;
    }
    let levels = read_force_levels(&fs::read_to_string(folder.join(SPECTRA_FILE)).ok()?)?;
    Some(Outcome::Done { found: true, levels, rolling_resistance: read_resistance(&summary) })
}

/// The rolling resistance that a summary tells.
fn read_resistance(summary: &serde_json::Value) -> Option<RollingResistance> {
    serde_json::from_value(summary["outcome"]["rolling_resistance"].clone()).ok()
}

/// A folder's summary.
fn read_summary(folder: &Path) -> Option<serde_json::Value> {
    serde_json::from_slice(&fs::read(folder.join(SUMMARY_FILE)).ok()?).ok()
}

/// Goes on with a variant, or runs it from its beginning.
fn carry_out(variant: &Variant, target: &Path, threads: usize, stop: &AtomicBool, watch: &dyn SweepWatch) -> Outcome {
    if stop.load(Ordering::Relaxed) {
        return Outcome::Stopped;
    }
    let target = target.join(&variant.name);
    let mut progress = VariantProgress { name: &variant.name, watch, done: 0 };
    let report = match resumable(variant, &target, watch) {
        true => run::resume(&target, threads, Watch::default(), stop, &mut progress),
        false => {
            let options = RunOptions { target: target.clone(), threads, watch: Watch::default() };
            run::run(&variant.loaded, &options, stop, &mut progress)
        }
    };
    match report {
        Ok(report) => {
            let levels = fs::read_to_string(report.folder.join(SPECTRA_FILE)).ok();
            let levels = levels.and_then(|text| read_force_levels(&text)).unwrap_or_default();
            // As written, so that a sweep that finds it finished says the same.
            let rolling_resistance = read_summary(&report.folder).as_ref().and_then(read_resistance);
            Outcome::Done { found: false, levels, rolling_resistance }
        }
        Err(RunError::Interrupted { .. }) => Outcome::Stopped,
        Err(error) => Outcome::Failed(error),
    }
}

/// Whether there is a checkpoint of just this variant; what is left of others, or unusable, is cleared away.
fn resumable(variant: &Variant, target: &Path, watch: &dyn SweepWatch) -> bool {
    if let Ok(folder) = unfinished(target) {
        match Checkpoint::read(&folder) {
            Ok(checkpoint) if checkpoint.loaded.scene == variant.loaded.scene => return true,
            Ok(_) => watch.note(&variant.name, "begun anew: its unfinished run was of another scene"),
            Err(error) => watch.note(&variant.name, &format!("begun anew: {error}")),
        }
    }
    forget_abandoned(target);
    false
}

/// Adds up a variant's steps.
struct VariantProgress<'a> {
    name: &'a str,
    watch: &'a dyn SweepWatch,
    done: u64,
}

impl Progress for VariantProgress<'_> {
    fn stage(&mut self, _stage: Stage) {}

    fn march(&mut self, done: u64, _steps: u64, _time_step: f64) {
        self.step(done);
    }

    fn step(&mut self, done: u64) {
        self.watch.done(done.saturating_sub(self.done));
        self.done = done;
    }

    fn note(&mut self, text: &str) {
        self.watch.note(self.name, text);
    }

    fn finish(&mut self) {}
}
