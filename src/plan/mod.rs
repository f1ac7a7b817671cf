//! The plan: a scene compiled, before any work, into what the run will do.
//!
//! 1. [`decisions`]: which effects are on, off or reduced, and why; every later stage asks them;
//! 2. sizes: time step, steps, lags;
//! 3. [`amounts`]: work of each stage in units, memory by what holds it;
//! 4. [`forecast`]: both on this machine, from costs of the units ([`mod@unit`]) that [`crate::study::calibration`] has measured.
//!
//! The plan is data: it is made without any of the work, can be printed as a table or as JSON, and [`crate::run::run()`]
//! follows it.

pub mod amounts;
pub mod decisions;
pub mod forecast;
pub mod unit;
pub mod unit_record;

pub use amounts::{Amounts, Place};
pub use decisions::{Decision, Decisions};
pub use forecast::Forecast;
pub use unit::{Unit, UnitCosts};

use crate::run::past::{contact_field, fit_options};
use crate::scene::{Axle, Choice, History, LoadedScene, Need, Resolution, Scene, SceneError};
use crate::storage::Cache;
use crate::tyre::rational::RationalModel;
use crate::tyre::rational::cache::key;

/// Segments of the averaged spectrum \[s\].
pub(crate) const SEGMENT: f64 = 0.5;
/// Lowest frequency at which the flat plate's absolute levels are those of a tyre \[Hz\]; below, curvature counts.
const PLATE_FROM: f64 = 400.0;

/// What a run will do.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Which effects are simulated.
    pub decisions: Decisions,
    /// Settings that the scene left open.
    pub choices: Vec<Choice>,
    /// Speed V \[m/s\].
    pub speed: f64,
    /// Element length dx = L/N \[m\].
    pub element: f64,
    /// Time step dt = dx/(q V) \[s\].
    pub time_step: f64,
    /// Time steps before anything counts.
    pub warm_up_steps: u64,
    /// All time steps.
    pub steps: u64,
    /// Highest frequency that the settings are good for \[Hz\], the road's own limit apart: `fmax`, or where texture
    /// and rule end.
    pub valid_to: f64,
    /// Lags of the history, lag 0 included.
    pub lags: usize,
    /// Work and memory.
    pub amounts: Amounts,
}

/// Up to where elements and time step are good \[Hz\]: what was asked for, or four elements to a texture wavelength and
/// the rule's rate within its tolerance.
fn valid_to(scene: &Scene) -> f64 {
    let Scene { tyre, rolling, numerics, .. } = scene;
    let (length, speed) = (tyre.circumference, rolling.speed());
    let given = Resolution { elements: numerics.elements, substeps: numerics.substeps };
    let steps = given.steps_per_second(length, speed);
    let rule = numerics.time_rule.largest_angle(Need::RULE_ERROR) * steps / std::f64::consts::TAU;
    numerics.fmax.unwrap_or_else(|| rule.min(0.5 * given.texture_limit(length, speed)))
}

impl Plan {
    /// The plan of a scene, a fit expected where there is one.
    pub fn new(scene: &Scene) -> Self {
        Self::decided(scene).with_amounts(scene, None)
    }

    /// What is decided and how large it is; its amounts are still to come.
    fn decided(scene: &Scene) -> Self {
        let Scene { tyre, rolling, numerics, .. } = scene;
        let speed = rolling.speed();
        let element = tyre.circumference / numerics.elements as f64;
        let time_step = element / (numerics.substeps as f64 * speed);
        // Casts of huge values saturate; the memory estimate works in f64 and refuses them.
        let steps_of = |time: f64| (time / time_step).round();
        let warm_up_steps = steps_of(rolling.warm_up);
        let steps = warm_up_steps + steps_of(rolling.duration).max(1.0);
        let lags = (steps_of(numerics.memory) + 1.0).min(steps + 1.0).max(2.0);
        Self {
            decisions: Decisions::new(scene),
            choices: Vec::new(),
            speed,
            element,
            time_step,
            warm_up_steps: warm_up_steps as u64,
            steps: steps as u64,
            valid_to: valid_to(scene),
            lags: lags as usize,
            amounts: Amounts::default(),
        }
    }

    /// Whether a fitted model is needed: by the recursion, or by the vibration.
    fn needs_model(&self, scene: &Scene) -> bool {
        scene.numerics.history == History::Modal || self.decisions.vibration.is_some()
    }

    /// With the work of a run whose model is kept with so many poles, or still to be fitted.
    fn with_amounts(mut self, scene: &Scene, kept: Option<usize>) -> Self {
        self.amounts = Amounts::new(scene, &self, kept);
        self
    }

    /// The plan of a loaded scene: with what was chosen in it, and with the fitted model that the cache holds, if there
    /// is one.
    pub fn of(loaded: &LoadedScene) -> Self {
        let scene = &loaded.scene;
        let mut plan = Self::decided(scene);
        plan.choices = loaded.choices().to_vec();
        if scene.numerics.accuracy.is_some() || scene.numerics.preset.is_some() {
            let note = format!(
                "the stated accuracy is that of the numerical solution: the flat plate's absolute levels are indicative below about {PLATE_FROM} Hz"
            );
            plan.decisions.notes.push(note);
        }
        let kept = if plan.needs_model(scene) { kept_poles(scene, &plan) } else { None };
        plan.with_amounts(scene, kept)
    }

    /// What it will take on this machine. `process`: what the process itself holds \[bytes\].
    pub fn forecast(&self, costs: &UnitCosts, threads: usize, process: f64) -> Forecast {
        Forecast::new(&self.amounts, self.steps, costs, threads, process)
    }

    /// Refuses a plan that needs more memory or time than the scene allows, and what cannot be simulated at all.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with a complaint that points into the scene.
    pub fn check(&self, loaded: &LoadedScene) -> Result<(), SceneError> {
        let numerics = &loaded.scene.numerics;
        let memory = self.amounts.memory_on(1);
        let hours = self.forecast(&UnitCosts::default(), 1, 0.0).core_seconds() / 3600.0;
        let rule = numerics.time_rule;
        let complaint = if numerics.history == History::Direct && !rule.is_multistep() {
            let why = if rule.runge_kutta().is_some() {
                "couples the stages of a step: its weights are matrices, which the direct sum does not keep"
            } else {
                "is no convolution quadrature: it needs the tyre's modes"
            };
            let wrong = format!("\"{}\" {why}", rule.name());
            loaded.complain("numerics.time_rule", wrong, "history = \"modal\", or a multistep rule such as \"bdf2\"")
        } else if memory / 1e9 > numerics.memory_limit {
            loaded.complain(
                "numerics.elements",
                format!(
                    "{} elements, {} lags and {} steps need about {} of memory, more than numerics.memory_limit = {} GB",
                    numerics.elements,
                    self.lags,
                    self.steps,
                    bytes(memory),
                    numerics.memory_limit
                ),
                "fewer elements, a shorter memory, or a larger memory_limit",
            )
        } else if hours > numerics.time_limit {
            loaded.complain(
                "numerics.elements",
                format!(
                    "{} elements and {} steps need about {hours:.1e} core hours, more than numerics.time_limit = {} h",
                    numerics.elements, self.steps, numerics.time_limit
                ),
                "fewer elements, a shorter run, or a larger time_limit",
            )
        } else {
            return Ok(());
        };
        Err(complaint.into())
    }

    /// The ramp of an axle that is held by its height, in steps.
    pub fn ramp_steps(&self, axle: &Axle) -> f64 {
        match axle {
            Axle::Indentation { ramp, .. } => ramp / self.time_step,
            Axle::Load { .. } | Axle::Mass { .. } => 0.0,
        }
    }

    /// What the user should know before the run: settings that were chosen, and what the run leaves out.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        let choice = |Choice { key, value, reason }: &Choice| format!("{key} = {value} ({reason})");
        self.choices.iter().map(choice).chain(self.decisions.notes.iter().cloned())
    }
}

/// Poles of the model that the cache holds for a scene; `None`: there is none, or it cannot be used.
fn kept_poles(scene: &Scene, plan: &Plan) -> Option<usize> {
    let options = fit_options(scene, contact_field(plan.decisions.tread));
    let key = key(&plan.decisions.tyre, &options).ok()?;
    let model: RationalModel = Cache::open().ok()?.load(&key).ok()??.ok()?;
    Some(model.order())
}

/// A number of bytes for people.
pub fn bytes(count: f64) -> String {
    match count {
        c if c < 1e3 => format!("{c:.0} B"),
        c if c < 1e6 => format!("{:.1} kB", c / 1e3),
        c if c < 1e9 => format!("{:.1} MB", c / 1e6),
        c if c < 1e12 => format!("{:.1} GB", c / 1e9),
        c => format!("{:.1e} GB", c / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counters::Stage;
    use crate::scene::DEFAULT;

    #[test]
    fn the_estimate_knows_how_the_past_is_carried() {
        let text =
            DEFAULT.replace("elements = 512", "elements = 4096").replace("speed_kmh = 80.0", "speed_kmh = 250.0");
        let mut loaded = Scene::from_str(&text, "estimate").unwrap();
        loaded.scene.rolling.duration = 1.0;
        let core_seconds = |plan: &Plan| plan.forecast(&UnitCosts::default(), 1, 0.0).core_seconds();
        let modal = Plan::new(&loaded.scene);
        assert!(modal.check(&loaded).is_ok(), "{} core seconds", core_seconds(&modal));
        loaded.scene.numerics.memory *= 2.0;
        let longer = Plan::new(&loaded.scene);
        assert_eq!(core_seconds(&longer).to_bits(), core_seconds(&modal).to_bits(), "poles have no memory");
        loaded.scene.numerics.history = History::Direct;
        let direct = Plan::new(&loaded.scene);
        assert!(core_seconds(&direct) > 100.0 * core_seconds(&modal));
        assert!(direct.amounts.memory_on(1) > modal.amounts.memory_on(1));
        assert!(direct.check(&loaded).is_err());
    }

    #[test]
    fn threads_share_the_work_and_a_smooth_road_leaves_next_to_nothing_behind() {
        let rough = Plan::new(&Scene::from_str(DEFAULT, "default").unwrap().scene);
        let of = |plan: &Plan, threads| plan.forecast(&UnitCosts::default(), threads, 1e7);
        let behind = |plan: &Plan, of_road: bool| -> f64 {
            let stages = of(plan, 2).stages;
            let road = |stage: Stage| matches!(stage, Stage::Road | Stage::Slices);
            stages.iter().filter(|it| it.background && road(it.stage) == of_road).map(|it| it.seconds).sum()
        };
        // What is done behind the march is nobody's time to wait.
        assert!(behind(&rough, true) > 0.0 && behind(&rough, false) > 0.0);
        assert!(of(&rough, 2).wall_seconds < 0.8 * of(&rough, 1).wall_seconds);
        assert!((of(&rough, 2).core_seconds() - of(&rough, 1).core_seconds()).abs() < 1e-9);
        let text = DEFAULT.replace("kind = \"made\"\nseed = 1", "kind = \"smooth\"");
        let smooth = Plan::new(&Scene::from_str(&text, "smooth").unwrap().scene);
        let road = behind(&smooth, true);
        assert!(road < 0.01 * of(&smooth, 2).wall_seconds, "{road}");
        assert!(of(&smooth, 1).memory < of(&rough, 1).memory);
    }
}
