//! Planning: a scene becomes a plan. Physics and effects are asked in the order of their lists, so that each effect
//! states its decision, its choices and its work in its module.

use crate::effects::{Arrays, EFFECTS, channels};
use crate::plan::decisions::{DecisionRow, Decisions, LATE, PHYSICS};
use crate::plan::models::cached_cell_poles;
use crate::plan::settle::{self, PlannedSetting};
use crate::plan::{Amounts, Forecast, PLATE_FROM, Plan, UnitCosts, cached_poles, feasible, meshes};
use crate::scene::{LoadedScene, Scene, SceneError, Zone};
use crate::storage::Cache;

/// Rows of the plan's table, in the order of the computation.
pub fn rows() -> impl Iterator<Item = &'static DecisionRow> {
    PHYSICS.iter().chain(EFFECTS.into_iter().flat_map(|effect| effect.rows())).chain(&LATE)
}

/// Decides every setting of a loaded scene, for commands that do not follow a [`Plan`].
///
/// # Errors
/// [`SceneError::Invalid`] where wishes contradict each other, or given numbers cannot reach them.
pub(crate) fn settled(loaded: LoadedScene) -> Result<LoadedScene, SceneError> {
    let (scene, _) = decide(&loaded)?;
    Ok(loaded.settled(scene))
}

/// Decides every setting of a scene; returns the scene and the choices.
fn decide(loaded: &LoadedScene) -> Result<(Scene, Vec<PlannedSetting>), SceneError> {
    let (scene, choices) = settle::decide(loaded)?;
    feasible::check_sizes(loaded, &scene)?;
    EFFECTS.iter().try_for_each(|effect| effect.check(loaded, &scene))?;
    Ok((scene, choices))
}

impl Decisions {
    /// Decisions on everything that a run of the scene simulates.
    pub fn new(scene: &Scene) -> Self {
        Self::by(rows(), scene, EFFECTS.iter().any(|effect| effect.takes_models(scene)))
    }
}

impl Plan {
    /// Plans a loaded scene: decides what it leaves open, with the time of a fit if a model is needed.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] where wishes contradict each other, or given numbers cannot reach them; for a tyre whose
    /// sums over waves have no end, or too many terms.
    pub fn of(loaded: &LoadedScene) -> Result<Self, SceneError> {
        let (scene, mut choices) = decide(loaded)?;
        feasible::check(loaded, &scene)?;
        choices.extend(settle::tension(&scene.tyre));
        let mut plan = Self::new(&scene);
        plan.cut(loaded)?;
        plan.check_rotation(loaded)?;
        plan.decisions.notes.extend(plan.outrun_tread());
        choices.extend(EFFECTS.iter().filter_map(|effect| effect.choice(&plan)));
        choices.extend(plan.choice_of_finer_mesh());
        let notes: Vec<String> = EFFECTS.iter().flat_map(|effect| effect.notes(&plan)).collect();
        plan.decisions.notes.extend(notes);
        plan.choices = choices;
        plan.overridden = settle::overridden(loaded, &scene);
        if let Some(levels) = &scene.outputs.levels {
            let short = meshes::short_scenes(loaded, &scene, levels, plan.compared_at_first())?;
            plan.short_runs =
                short.map(|scene| Self::new(&scene).standing_as(&plan).keeping_transforms(1)).into_iter().collect();
        }
        if !scene.tyre.curvature && (scene.numerics.accuracy.is_some() || scene.numerics.preset.is_some()) {
            let note = format!(
                "the stated accuracy is that of the numerical solution: the flat plate's absolute levels are \
                 indicative below about {PLATE_FROM} Hz"
            );
            plan.decisions.notes.push(note);
        }
        Ok(plan)
    }

    /// Plans a scene whose settings are all decided, with the time of a fit if a model is needed.
    pub fn new(scene: &Scene) -> Self {
        Self::decided(scene, Decisions::new(scene))
    }

    /// Takes into account what the user's cache holds for the plan and for its effects: amounts and forecast are less
    /// then.
    #[must_use]
    pub fn with_cached_model(mut self) -> Self {
        self.cached_poles = cached_poles(&self);
        self.cached_cell_poles = Cache::open().ok().and_then(|cache| cached_cell_poles(&self, &cache));
        EFFECTS.iter().for_each(|effect| effect.look_up(&mut self));
        self.short_runs = std::mem::take(&mut self.short_runs).into_iter().map(Self::with_cached_model).collect();
        self
    }

    /// Work of each stage in units, and memory by what holds it.
    #[doc(hidden)]
    pub fn amounts(&self) -> Amounts {
        let mut amounts = Amounts::of_physics(self);
        let across = if self.decisions.zone == Zone::Cells { self.cell_grid().across } else { 1 };
        let window = [amounts.expected.columns as usize, across];
        amounts.add_segments(self, rayon::current_num_threads());
        amounts.add_results(self, Arrays::bytes(channels(), self, window));
        // The last effect, sound, takes what memory the others leave.
        EFFECTS.iter().for_each(|effect| effect.add_amounts(self, &mut amounts));
        self.short_runs.iter().for_each(|plan| amounts.add_before(plan.amounts()));
        amounts
    }

    /// Forecast of time and memory on this machine. `process` is the memory of the process itself \[bytes\].
    pub(crate) fn forecast(&self, costs: &UnitCosts, threads: usize, process: f64) -> Forecast {
        Forecast::new(&self.amounts(), self.steps, costs, threads, process)
    }

    /// Refuses a plan that needs more memory or time than the scene allows, and what cannot be simulated at all.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with a complaint that points into the scene.
    pub fn check(&self, loaded: &LoadedScene) -> Result<(), SceneError> {
        self.check_standing(loaded)?;
        self.check_warm_up(loaded)?;
        self.check_sections(loaded)?;
        self.check_amounts(loaded, &self.amounts())
    }
}

/// Results that a run of a plan will not give, and other warnings, known without running it.
pub(crate) fn foreseen(plan: &Plan) -> Vec<String> {
    let missing = EFFECTS.into_iter().flat_map(|effect| effect.missing(plan));
    plan.warnings().into_iter().chain(plan.road_warnings.iter().cloned()).chain(missing).collect()
}
