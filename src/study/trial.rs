//! Short runs side by side: what every comparison of variants of a scene rolls.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use crate::counters::Watch;
use crate::plan::Plan;
use crate::run::error::RunError;
use crate::run::in_memory::{Results, Run};
use crate::run::progress::Progress;
use crate::scene::{Axle, LoadedScene, Scene, Switch, TimeRule};

/// Steps between two looks at the flag and the progress bar.
const LOOK_EVERY: u64 = 256;
/// Ramp and settling of an axle that is held at a height, left out of a comparison \[s\]: the default tyre's modes lose
/// 40 dB in it.
pub const SETTLING: f64 = 0.2;
/// What the progress counts: rolled time in this \[s\].
const UNIT: f64 = 1e-3;

/// One run of a comparison.
pub struct Trial {
    /// Its plan.
    pub plan: Plan,
    /// Its time rule.
    pub rule: TimeRule,
    /// Total force of every step, warm-up included \[N\].
    pub force: Vec<f64>,
    /// Indentation of the rigid tyre at the last step \[m\].
    pub indentation: f64,
    /// What it found and what it cost.
    pub results: Results,
    /// Wall time of the steps \[s\].
    pub seconds: f64,
}

/// Rolls one variant after the other.
pub struct Trials<'a> {
    stop: &'a AtomicBool,
    progress: &'a mut dyn Progress,
    /// Time rolled \[s\].
    done: f64,
}

impl<'a> Trials<'a> {
    /// Of about `time` \[s\] to be rolled in all.
    pub fn new(time: f64, stop: &'a AtomicBool, progress: &'a mut dyn Progress) -> Self {
        progress.march(0, (time / UNIT) as u64, UNIT);
        Self { stop, progress, done: 0.0 }
    }

    /// What a run looks at for its end.
    pub fn stop(&self) -> &'a AtomicBool {
        self.stop
    }

    /// Rolls a variant to its end. The road is made on another thread where there is one: the march is on its own all
    /// the same.
    ///
    /// # Errors
    /// Of the plan and of the run; [`RunError::Interrupted`].
    pub fn roll(&mut self, scene: &Scene) -> Result<Trial, RunError> {
        let loaded = LoadedScene::from_scene(scene, "variant")?;
        let plan = Plan::of(&loaded)?.with_kept_model();
        plan.check(&loaded)?;
        let mut run = Run::begin_watched(&loaded, &plan, self.stop, Watch::EVERY)?;
        let begin = Instant::now();
        let mut force = Vec::with_capacity(plan.steps as usize);
        rayon::in_place_scope(|scope| {
            let behind = (rayon::current_num_threads() > 1).then_some(scope);
            while run.next_step() < plan.steps {
                force.push(run.step_beside(behind)?.total_force);
                if run.next_step().is_multiple_of(LOOK_EVERY) {
                    let rolled = self.done + run.next_step() as f64 * plan.time_step;
                    self.progress.step((rolled / UNIT) as u64);
                    if self.stop.load(Ordering::Relaxed) {
                        return Err(RunError::Interrupted { kept: None });
                    }
                }
            }
            Ok(())
        })?;
        let seconds = begin.elapsed().as_secs_f64();
        self.done += plan.steps as f64 * plan.time_step;
        let indentation = run.prepared.axle.indentation(plan.steps - 1);
        Ok(Trial { plan, rule: scene.numerics.time_rule, force, indentation, results: run.finish(), seconds })
    }

    /// The scene for a comparison of its forces over `duration` \[s\]: its axle held where it carries the load at the
    /// scene's own settings, found by rolling the warm-up; no outputs; nothing that would be chosen anew for other
    /// settings.
    ///
    /// # Errors
    /// As [`Self::roll`].
    pub fn held(&mut self, scene: &Scene, duration: f64) -> Result<Scene, RunError> {
        let mut held = scene.clone();
        held.numerics.forget_wishes();
        held.outputs.vibration = None;
        let Scene { effects, rolling, .. } = &mut held;
        for switch in [&mut effects.tread_vibration, &mut effects.belt_vibration, &mut effects.tangential_motion] {
            *switch = Switch::Auto;
        }
        rolling.warm_up = rolling.warm_up.max(SETTLING);
        if rolling.axle.load().is_some() {
            let mut found = held.clone();
            // Just enough for the last correction of the height.
            found.rolling.duration = 1e-3;
            let indentation = self.roll(&found)?.indentation;
            held.rolling.axle = Axle::Indentation { indentation, ramp: 0.5 * SETTLING };
        }
        (held.rolling.warm_up, held.rolling.duration) = (SETTLING, duration);
        Ok(held)
    }

    /// The end of the watch.
    pub fn finish(self) {
        self.progress.finish();
    }
}
