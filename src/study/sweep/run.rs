//! Runs the variants of a sweep, several at a time.
//!
//! Workers take the variants one after the other; each has its share of the threads, so that there are never more
//! threads than were asked for. The models of the tyre's influence functions that the variants need are fitted first,
//! once each, and all workers read them from the cache.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};

use crate::counters::{Job, Stage};
use crate::effects::stored::{NamedLevels, levels};
use crate::plan::Plan;
use crate::plan::models::fetch;
use crate::response::BandLevel;
use crate::results::folder::ResultsFolder;
use crate::results::inputs::{Input, Inputs};
use crate::results::pass_by::PassBySummary;
use crate::results::placing::{forget_abandoned, unfinished};
use crate::results::sound::{RatedLevel, ReceiverSummary, SOUND_COLUMN, SOUND_FILE};
use crate::results::spectra::{SPECTRA_FILE, read_force_levels};
use crate::results::summary::{FrictionSummary, LoadResult, RollingResistance, read_summary};
use crate::results::table::StoredTable;
use crate::run::checkpoint::Checkpoint;
use crate::run::end::impossible_energy;
use crate::run::{self, Progress, RunError, RunOptions, RunReport};
use crate::scene::{History, Scene};
use crate::sound::TotalLevel;
use crate::storage::input::{self, TABLE_BYTES};
use crate::study::sweep::variants::Variant;
use crate::study::trial::UNIT;

/// End of a variant.
#[derive(Debug)]
pub(crate) enum VariantOutcome {
    /// Its results are there, from now or from before.
    Done(Done),
    /// The user stopped it, or stopped the sweep before it began.
    Stopped,
    /// It failed.
    Failed(RunError),
}

/// Results of a finished variant, read from its folder.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct Done {
    /// True if an earlier sweep had finished it.
    #[serde(skip)]
    pub found: bool,
    /// Third-octave levels of the contact force \[dB re 1 N\].
    pub levels: Vec<BandLevel>,
    /// Rolling resistance, where the tread law has one.
    pub rolling_resistance: Option<RollingResistance>,
    /// Tangential forces, where the contact has friction.
    pub friction: Option<FrictionSummary>,
    /// Load, and how accurately it was met.
    pub load: Option<LoadResult>,
    /// A-weighted level at each receiver \[dB(A)\], with its bands: the maximum of the passage where the tyre passes,
    /// otherwise the mean.
    pub sound: Vec<(String, TotalLevel)>,
    /// The receivers that the tyre passes.
    #[serde(default)]
    pub passed: Vec<String>,
    /// Passages at these receivers, and their statistical error.
    #[serde(default)]
    pub pass_bys: Vec<(String, PassBySummary)>,
    /// Sentences on receivers whose summary cannot be read: their levels are left out.
    #[serde(default)]
    pub unread: Vec<String>,
}

impl VariantOutcome {
    /// Results, if the variant is done.
    pub(crate) fn done(&self) -> Option<&Done> {
        match self {
            Self::Done(done) => Some(done),
            Self::Stopped | Self::Failed(_) => None,
        }
    }
}

impl Done {
    /// Collects the results from the levels of the force, the A-weighted ones at the receivers and the summary of a
    /// results folder.
    pub(crate) fn new(
        found: bool,
        levels: Vec<BandLevel>,
        receiver_levels: &[(String, Vec<BandLevel>)],
        summary: &serde_json::Value,
    ) -> Self {
        let outcome = &summary["outcome"];
        let (mut receivers, mut unread) = (Vec::new(), Vec::new());
        for receiver in summary["sound"]["receivers"].as_array().into_iter().flatten() {
            match serde_json::from_value::<ReceiverSummary>(receiver.clone()) {
                Ok(receiver) => receivers.push(receiver),
                Err(why) => unread.push(format!("no level at {}: its summary cannot be read: {why}", receiver["name"])),
            }
        }
        let rated: Vec<RatedLevel> = receivers
            .iter()
            .map(|receiver| {
                let bands = receiver_levels.iter().find(|(name, _)| *name == receiver.name);
                receiver.rated(bands.map_or(&[][..], |(_, bands)| bands))
            })
            .collect();
        Self {
            found,
            levels,
            rolling_resistance: serde_json::from_value(outcome["rolling_resistance"].clone()).ok(),
            friction: serde_json::from_value(outcome["friction"].clone()).ok(),
            load: serde_json::from_value(outcome["load"].clone()).ok(),
            sound: rated.iter().filter_map(|rated| Some((rated.name.clone(), rated.level.clone()?))).collect(),
            pass_bys: receivers.into_iter().filter_map(|receiver| Some((receiver.name, receiver.pass_by?))).collect(),
            passed: rated.into_iter().filter(|rated| rated.passed).map(|rated| rated.name).collect(),
            unread,
        }
    }

    /// Level at a receiver \[dB(A)\].
    pub(crate) fn level_at(&self, receiver: &str) -> Option<&TotalLevel> {
        self.sound.iter().find(|(name, _)| name == receiver).map(|(_, level)| level)
    }

    pub(crate) fn pass_by(&self, receiver: &str) -> Option<&PassBySummary> {
        self.pass_bys.iter().find(|(name, _)| name == receiver).map(|(_, pass_by)| pass_by)
    }

    /// Name of the level at a receiver, see [`RatedLevel::label`].
    pub(crate) fn label_of(&self, receiver: &str) -> String {
        let passed = self.passed.iter().any(|name| name == receiver);
        RatedLevel { name: receiver.to_owned(), passed, level: None, pass_by: None }.label()
    }

    /// The load, if it was missed by more than its tolerance.
    pub(crate) fn missed_load(&self) -> Option<&LoadResult> {
        self.load.as_ref().filter(|load| !load.met)
    }
}

/// Progress of all variants together.
struct SweepProgress<'a> {
    progress: &'a mut (dyn Progress + Send),
    /// Simulated time of all variants so far \[s\].
    rolled: f64,
    /// Notes common to all variants: they are reported once, before the first.
    shared: Vec<String>,
}

/// Notes that all plans have in common.
fn shared_notes<'a>(mut plans: impl Iterator<Item = &'a Plan>) -> Vec<String> {
    let mut shared: Vec<String> = plans.next().map_or(Vec::new(), |plan| plan.notes().collect());
    for plan in plans {
        let notes: Vec<String> = plan.notes().collect();
        shared.retain(|note| notes.contains(note));
    }
    shared
}

/// Runs the variants that are not finished, one folder each under `target`, on `threads` threads in all; returns the
/// outcomes in the order of `variants`. A variant that fails does not stop the others.
pub(crate) fn sweep(
    variants: &[Variant],
    target: &Path,
    threads: usize,
    stop: &AtomicBool,
    progress: &mut (dyn Progress + Send),
) -> Vec<VariantOutcome> {
    // 1. What an earlier sweep has finished is not run again.
    let mut known = Inputs::default();
    let outcomes: Vec<Mutex<Option<VariantOutcome>>> =
        variants.iter().map(|variant| Mutex::new(finished(variant, target, &mut known))).collect();
    let pending: Vec<usize> = (0..variants.len()).filter(|&index| lock(&outcomes[index]).is_none()).collect();
    // 2. Fit the models that several variants share.
    progress.stage(Stage::Influence);
    share_models(pending.iter().map(|&index| &variants[index]), stop);
    let plans = || pending.iter().map(|&index| &variants[index].plan);
    let shared = shared_notes(plans());
    shared.iter().for_each(|note| progress.note(note));
    let time: f64 = plans().map(|plan| plan.steps as f64 * plan.time_step).sum();
    progress.march(0, (time / UNIT) as u64, UNIT);
    let watch = Mutex::new(SweepProgress { progress, rolled: 0.0, shared });

    // 3. Run the rest. The boundary elements of a body are solved once, by the first variant that needs them.
    let sounds = pending.iter().any(|&index| !variants[index].plan.scene.receivers.is_empty());
    let workers = if sounds { 1 } else { threads.min(pending.len()).max(1) };
    let next = AtomicUsize::new(0);
    let work = |worker: usize| {
        let share = threads / workers + usize::from(worker < threads % workers);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(share.max(1)).build().ok();
        while let Some(&index) = pending.get(next.fetch_add(1, Ordering::Relaxed)) {
            let variant = &variants[index];
            let one = || carry_out(variant, target, share.max(1), stop, &watch);
            // Without a pool for it, it runs on the caller's: slower for the others, with the same results.
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
    lock(&watch).progress.finish();
    let ended =
        |outcome: Mutex<Option<VariantOutcome>>| outcome.into_inner().ok().flatten().unwrap_or(VariantOutcome::Stopped);
    outcomes.into_iter().map(ended).collect()
}

/// Locks a mutex, even after a panic of its last holder.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Fits every model that the variants need and the cache does not hold.
fn share_models<'a>(variants: impl Iterator<Item = &'a Variant>, stop: &AtomicBool) {
    let mut fitted = Vec::new();
    for variant in variants {
        let plan = &variant.plan;
        let model = (&plan.decisions.tyre, &plan.fit);
        let needed = plan.scene.numerics.history == History::Modal && !fitted.contains(&model);
        if needed && !stop.load(Ordering::Relaxed) {
            // The variant itself reports a refusal.
            let _ = fetch(model.0, model.1, stop);
            fitted.push(model);
        }
    }
}

/// Outcome of a variant that an earlier sweep has finished: with the same scene, version and inputs.
fn finished(variant: &Variant, target: &Path, known: &mut Inputs) -> Option<VariantOutcome> {
    let folder = target.join(&variant.label.name);
    // Errors of this are reported when the variant is run.
    let _ = ResultsFolder::put_in_order(&folder);
    let summary: serde_json::Value = read_summary(&folder)?;
    let planned = variant.loaded.clone().settled(variant.plan.scene.clone());
    let same = summary["complete"] == true
        && summary["scene_sha256"] == planned.hash().ok()?.as_str()
        && summary["version"] == env!("CARGO_PKG_VERSION");
    let recorded: Vec<Input> = serde_json::from_value(summary["inputs"].clone()).unwrap_or_default();
    if !same || recorded != known.of(&variant.plan.scene).ok()? {
        return None;
    }
    if let Some(impossible) = impossible(&variant.plan.scene, &summary) {
        return Some(impossible);
    }
    Some(VariantOutcome::Done(Done::new(true, read_levels(&folder)?, &read_receiver_levels(&folder), &summary)))
}

/// Failure of a finished run whose energies cannot be; `None` if they can.
fn impossible(scene: &Scene, summary: &serde_json::Value) -> Option<VariantOutcome> {
    let outcome = serde_json::from_value(summary["outcome"].clone()).ok()?;
    impossible_energy(scene, &outcome).map(|why| VariantOutcome::Failed(RunError::Impossible(why)))
}

fn read_levels(folder: &Path) -> Option<Vec<BandLevel>> {
    read_force_levels(&input::read_text(&folder.join(SPECTRA_FILE), TABLE_BYTES).ok()?)
}

/// A-weighted levels at a folder's receivers; empty without.
fn read_receiver_levels(folder: &Path) -> NamedLevels {
    let text = input::read_text(&folder.join(SOUND_FILE), TABLE_BYTES).ok();
    let table = text.and_then(|text| StoredTable::parse(&text).ok());
    table.and_then(|table| levels(&table, SOUND_COLUMN)).unwrap_or_default()
}

/// Continues a variant from its checkpoint, or runs it from the beginning.
fn carry_out(
    variant: &Variant,
    target: &Path,
    threads: usize,
    stop: &AtomicBool,
    watch: &Mutex<SweepProgress<'_>>,
) -> VariantOutcome {
    if stop.load(Ordering::Relaxed) {
        return VariantOutcome::Stopped;
    }
    let target = target.join(&variant.label.name);
    let mut progress = VariantProgress { name: &variant.label.name, watch, done: 0, time_step: 0.0, has_blocks: false };
    let report = if resumable(variant, &target, &mut progress) {
        run::resume(&target, threads, Job::new(stop, &mut progress))
    } else {
        run::run(&variant.loaded, &RunOptions { target, threads }, Job::new(stop, &mut progress))
    };
    match report {
        Ok(RunReport { impossible: Some(why), .. }) => VariantOutcome::Failed(RunError::Impossible(why)),
        // Results as written, so that a later sweep that finds them reports the same.
        Ok(RunReport { folder, .. }) => {
            let levels = read_levels(&folder).unwrap_or_default();
            let summary = read_summary(&folder).unwrap_or_default();
            VariantOutcome::Done(Done::new(false, levels, &read_receiver_levels(&folder), &summary))
        }
        Err(RunError::Interrupted { .. }) => VariantOutcome::Stopped,
        Err(error) => VariantOutcome::Failed(error),
    }
}

/// True if there is a checkpoint of this variant; remains of others, or unusable ones, are deleted.
fn resumable(variant: &Variant, target: &Path, progress: &mut dyn Progress) -> bool {
    if let Ok(folder) = unfinished(target) {
        match Checkpoint::read(&folder) {
            Ok(checkpoint) if checkpoint.loaded.scene == variant.loaded.scene => return true,
            Ok(_) => progress.note("started again: its unfinished run was of another scene"),
            Err(error) => progress.note(&format!("started again: {error}")),
        }
    }
    forget_abandoned(target);
    false
}

/// Adds the simulated time of one variant to that of all.
struct VariantProgress<'a, 'b> {
    name: &'a str,
    watch: &'a Mutex<SweepProgress<'b>>,
    done: u64,
    time_step: f64,
    /// True if blocks of steps stop its march for long: those of later variants are not known, so one always remains.
    has_blocks: bool,
}

impl Progress for VariantProgress<'_, '_> {
    fn march(&mut self, done: u64, _steps: u64, time_step: f64) {
        self.time_step = time_step;
        self.step(done);
    }

    fn blocks(&mut self, remaining: u64, stage: Option<Stage>) {
        self.has_blocks |= remaining > 0;
        lock(self.watch).progress.blocks(self.has_blocks.into(), stage);
    }

    fn step(&mut self, done: u64) {
        let SweepProgress { progress, rolled, .. } = &mut *lock(self.watch);
        *rolled += done.saturating_sub(self.done) as f64 * self.time_step;
        progress.step((*rolled / UNIT) as u64);
        self.done = done;
    }

    fn note(&mut self, text: &str) {
        let SweepProgress { progress, shared, .. } = &mut *lock(self.watch);
        if !shared.iter().any(|said| said == text) {
            progress.note(&format!("{}: {text}", self.name));
        }
    }

    fn warning(&mut self, text: &str) {
        lock(self.watch).progress.warning(&format!("{}: {text}", self.name));
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::response::ThirdOctaveBand;
    use crate::scene::DEFAULT;

    #[test]
    fn a_run_of_impossible_energy_has_failed() {
        let scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        let of = |coefficient: f64| {
            let resistance =
                json!({ "coefficient": coefficient, "force": 3400.0 * coefficient, "power": 75e3 * coefficient });
            let summary = crate::results::summary::Outcome {
                mean_force: Some(3400.0),
                indentation: Some(0.016),
                rolling_resistance: serde_json::from_value(resistance).unwrap(),
                ..Default::default()
            };
            impossible(&scene, &json!({ "outcome": summary }))
        };
        assert!(of(0.012).is_none());
        let Some(VariantOutcome::Failed(error)) = of(-480.0) else { panic!("no failure") };
        assert!(error.to_string().contains("gives back"), "{error}");
    }

    #[test]
    fn an_unreadable_receiver_is_reported_alone() {
        let receiver =
            |name: &str, level_a: Option<f64>| json!({ "name": name, "points": 1, "level": 70.0, "level_a": level_a });
        let receivers = [receiver("beside", Some(60.5)), receiver("cpx", None)];
        let band = BandLevel { band: ThirdOctaveBand(0), mean_square: 1.0, level: 60.0, valid: true };
        let receiver_levels = ["beside", "cpx"].map(|name| (name.to_owned(), vec![band]));
        let done = Done::new(
            true,
            Vec::new(),
            &receiver_levels,
            &json!({ "outcome": {}, "sound": { "receivers": receivers } }),
        );
        assert_eq!(
            done.sound.iter().map(|(name, level)| (name.as_str(), level.level)).collect::<Vec<_>>(),
            [("beside", 60.5)]
        );
        let [reported] = &done.unread[..] else { panic!("one sentence: {:?}", done.unread) };
        assert!(reported.starts_with("no level at \"cpx\": its summary cannot be read: "), "{reported}");
    }
}
