//! Simulation of a planned scene: begun, stepped as far as the caller likes, turned into results. The front page of the
//! library has an example.
//!
//! There is one beginning and one step: runs into a folder, in memory and from a checkpoint share them. After each step
//! the effects observe it in their order, and the rows of the arrays are written.

mod output;
mod segments;

use std::any::Any;
use std::borrow::Cow;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::contact::ContactError;
use crate::contact::complementarity::{Residuals, SearchCounts};
use crate::contact::march::StepResult;
use crate::counters::{Counter, Job, Meter, Phase, Progress, Stage, Timing, Unwatched, Watch};
use crate::effects::force::ForceObserver;
use crate::effects::sound::{SoundObserver, SoundResults};
use crate::effects::vibration::{VibrationObserver, VibrationResults};
use crate::effects::{Arrays, EFFECTS, EffectObserver, End, Found, Observer, RunError, Step};
use crate::plan::Plan;
use crate::response::PowerSpectrum;
use crate::response::vibration::ContactPower;
use crate::results::files::ResultFiles;
use crate::results::summary::{FinerMesh, FrictionSummary, RollingResistance};
use crate::run::prepare::{Prepared, prepare};
use crate::run::section_table::SectionTable;
use crate::scene::{LoadedScene, SceneError};
use crate::storage::state::{Evolving, StateError, StateStream};

/// Steps between two checks of the interrupt flag, with an update of the progress.
const CHECK_EVERY: u64 = 16;
/// Factor by which a window of cells is widened once contact has reached its end.
const WIDER: f64 = 1.5;

type Named = (&'static str, Box<dyn EffectObserver>);

/// First observer of a type, if there is one.
fn first_of<T: EffectObserver>(observers: &[Named]) -> Option<&T> {
    observers.iter().find_map(|(_, observer)| (observer.as_ref() as &dyn Any).downcast_ref())
}

/// A run between two of its steps.
pub struct Simulation {
    /// Scene as loaded, and its plan.
    loaded: LoadedScene,
    plan: Plan,
    /// The step after the last recorded one; the contact is behind it after a new begin over a wider window.
    next_step: u64,
    /// Contact, road and axle.
    pub(crate) prepared: Prepared,
    /// Observers by the names of their effects.
    observers: Vec<Named>,
    /// Observers that the caller has added.
    observers_of_caller: Vec<Box<dyn Observer>>,
    /// Power put in by the contact, if an observer needs it.
    power: Option<ContactPower>,
    arrays: Option<Arrays>,
    sections: Option<SectionTable>,
    /// Cost so far.
    pub(crate) meter: Meter,
    /// Warnings of its preparation.
    pub(crate) warnings: Vec<String>,
}

/// Findings of a run after its warm-up; values that do not exist (no step counted yet) are `None`.
#[derive(Clone, Debug)]
pub struct Results {
    /// Time steps done, warm-up included.
    pub steps: u64,
    /// Mean total contact force \[N\].
    pub mean_force: Option<f64>,
    /// Root mean square of the force about its mean \[N\].
    pub rms_force_variation: Option<f64>,
    /// Mean length of the contact patch \[m\].
    pub mean_contact_length: Option<f64>,
    /// Rolling resistance, where the tread law has one.
    pub rolling_resistance: Option<RollingResistance>,
    /// Tangential forces, where the contact has friction.
    pub friction: Option<FrictionSummary>,
    /// Averaged spectrum of the total force; `None` for a run that did not reach its end, or is too short for one.
    pub spectrum: Option<PowerSpectrum>,
    /// Counts of the search for the contact forces.
    pub(crate) search: SearchCounts,
    /// Largest residuals of the contact conditions, relative to the largest force and displacement.
    pub(crate) residuals: Residuals,
    /// Sound at the receivers, where there are any and the run was long enough.
    pub sound: Option<SoundResults>,
    /// Choices of the plan, and effects that it leaves out.
    pub notes: Vec<String>,
    /// Warnings that need the user's attention.
    pub warnings: Vec<String>,
    /// Cost of the run: stages and counters.
    pub meter: Meter,
}

impl Simulation {
    /// Prepares a run that keeps its results in memory, with every effect that the scene calls for. `stop` ends the
    /// work on the tyre and its sound once it is set.
    ///
    /// # Errors
    /// [`RunError`]: what the scene asks for cannot be simulated, a road that cannot be read, ...
    pub fn begin(loaded: &LoadedScene, plan: &Plan, stop: &AtomicBool) -> Result<Self, RunError> {
        Self::begin_watched(loaded, plan, stop, Watch::default())
    }

    /// Begins a run as [`Self::begin`], with the cost measured as closely as `watch` says.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn begin_watched(loaded: &LoadedScene, plan: &Plan, stop: &AtomicBool, watch: Watch) -> Result<Self, RunError> {
        let mut plan = Cow::Borrowed(plan);
        if plan.scene.outputs.sections.is_some() {
            // Nobody would take their rows.
            plan.to_mut().scene.outputs.sections = None;
        }
        let mut run = Self::prepare(loaded, &plan, true, &[], &mut Job::new(stop, &mut Unwatched).watched(watch))?;
        run.enter_steps();
        Ok(run)
    }

    /// Prepares a run: tyre, road, contact, then the observers of its effects, except those named in `without`. Takes
    /// the meter and the warnings of the job. `in_memory` is true for a run whose results stay there; it makes no
    /// pictures.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub(crate) fn prepare(
        loaded: &LoadedScene,
        plan: &Plan,
        in_memory: bool,
        without: &[&str],
        job: &mut Job<'_>,
    ) -> Result<Self, RunError> {
        loaded.check_time_domain()?;
        if plan.wanted_levels().is_some() {
            let wrong = "a run that is stepped by its caller has the levels of its own mesh";
            return Err(SceneError::from(loaded.complain(
                "outputs.levels",
                wrong,
                "leave it out, or run the scene as a whole",
            ))
            .into());
        }
        job.progress.stage(Stage::Influence);
        let mut prepared = prepare(loaded, plan, job)?;
        let mut begin = prepared.begin(loaded, plan, in_memory);
        let mut observers = Vec::new();
        for effect in EFFECTS.into_iter().filter(|effect| !without.contains(&effect.name())) {
            observers.extend(effect.begin(&mut begin, job)?.map(|observer| (effect.name(), observer)));
        }
        let needs_power = observers.iter().any(|(_, observer)| observer.needs_power());
        let mut run = Self {
            loaded: loaded.clone(),
            plan: plan.clone(),
            next_step: 0,
            power: None,
            prepared,
            observers,
            observers_of_caller: Vec::new(),
            arrays: None,
            sections: None,
            meter: std::mem::take(&mut job.meter),
            warnings: std::mem::take(&mut job.warnings),
        };
        run.power = needs_power.then(|| run.contact_power());
        Ok(run)
    }

    /// Power of the contact, before its first step.
    fn contact_power(&self) -> ContactPower {
        let points = self.prepared.contact.shape.points();
        ContactPower::new(self.plan.scene.numerics.time_rule, self.plan.time_step, points)
    }

    /// Adds an observer, which is called after those of the effects.
    #[must_use]
    pub fn with(mut self, observer: impl Observer) -> Self {
        if observer.needs_power() && self.power.is_none() {
            self.power = Some(self.contact_power());
        }
        self.observers_of_caller.push(Box::new(observer));
        self
    }

    /// The caller's first observer of a type, if there is one.
    pub fn observer<T: Observer>(&self) -> Option<&T> {
        self.observers_of_caller.iter().find_map(|observer| (observer.as_ref() as &dyn Any).downcast_ref())
    }

    /// Changes how closely steps are timed from now on.
    pub fn set_timing(&mut self, timing: Timing) {
        self.meter.set_timing(timing);
    }

    /// Time step dt \[s\].
    pub fn time_step(&self) -> f64 {
        self.plan.time_step
    }

    /// Number of the next step, from 0; the number of all steps after the last.
    pub fn next_step(&self) -> u64 {
        self.next_step
    }

    /// Indentation of the tyre at a step \[m\], counted from the tyre at rest: without the growth by rotation.
    pub(crate) fn indentation(&self, step: u64) -> f64 {
        self.prepared.axle.indentation(step) - self.plan.decisions.growth
    }

    /// Takes a step and returns its result; `None` after the last. With more than one thread the road is made on
    /// another one, ahead of its use.
    ///
    /// # Errors
    /// [`RunError`]; the run cannot continue then.
    pub fn step(&mut self) -> Result<Option<StepResult>, RunError> {
        while self.next_step < self.plan.steps {
            if let Some(result) = self.advance()? {
                return Ok(Some(result));
            }
        }
        Ok(None)
    }

    /// Takes the steps up to the last one; returns whether it got there. Every few steps `inspect` may end the run by
    /// returning `false`.
    ///
    /// # Errors
    /// Errors of the steps, and those of `inspect`.
    pub(crate) fn roll(
        &mut self,
        inspect: &mut dyn FnMut(&mut Self) -> Result<bool, RunError>,
    ) -> Result<bool, RunError> {
        while self.next_step < self.plan.steps {
            if self.prepared.march.next_step().is_multiple_of(CHECK_EVERY) {
                self.append_sections(false)?;
                if !inspect(self)? {
                    return Ok(false);
                }
            }
            self.advance()?;
        }
        Ok(true)
    }

    /// Takes all steps, with progress, up to the cost of the last one.
    ///
    /// # Errors
    /// Errors of the steps; [`RunError::Interrupted`] if the job is stopped.
    pub(crate) fn roll_to_end(&mut self, job: &mut Job<'_>) -> Result<(), RunError> {
        if let Some(segments) = self.plan.segments {
            return self.roll_segments(segments, job);
        }
        job.progress.march(0, self.plan.steps, self.plan.time_step);
        self.enter_steps();
        let complete = self.roll(&mut |run| {
            run.report(job.progress);
            Ok(!job.is_stopped())
        })?;
        if complete { Ok(()) } else { Err(RunError::Interrupted { partial: None }) }
    }

    /// Reports the steps that are done, and what will stop them.
    pub(crate) fn report(&self, progress: &mut dyn Progress) {
        let mut remaining = self.observers.iter().map(|(_, observer)| observer.remaining_blocks(CHECK_EVERY));
        let (blocks, stage) = remaining.find(|of_stage| of_stage.0 > 0).unwrap_or_default();
        progress.blocks(blocks, stage);
        progress.step(self.prepared.march.next_step());
    }

    /// Contact forces of the last step by column of the window \[N\]; the first is that of the element
    /// [`StepResult::first_element`].
    pub fn forces(&self) -> &[f64] {
        self.prepared.march.footprint().column_mean()
    }

    /// Velocities of the steps so far, if the scene asks for them and one of their segments is complete.
    pub fn vibration(&mut self) -> Option<VibrationResults> {
        let Self { observers, meter, .. } = self;
        first_of::<VibrationObserver>(observers).and_then(|observer| observer.results_so_far(meter))
    }

    /// Ends the run after any step.
    pub fn finish(mut self) -> Results {
        self.settle();
        let found = self.findings();
        let (sound, spectrum) =
            (first_of::<SoundObserver>(&self.observers), first_of::<ForceObserver>(&self.observers));
        let (sound, spectrum) =
            (sound.and_then(|sound| sound.results().ok()), spectrum.and_then(ForceObserver::spectrum));
        let Self { prepared, meter, warnings, .. } = self;
        let spectrum = spectrum.map(|spectrum| spectrum.valid_to(prepared.contact.force_valid_to()));
        Results {
            steps: self.next_step,
            mean_force: found.outcome.mean_force,
            rms_force_variation: found.outcome.rms_force_variation,
            mean_contact_length: found.outcome.mean_contact_length,
            rolling_resistance: found.outcome.rolling_resistance,
            friction: found.outcome.friction,
            spectrum,
            search: prepared.march.search_counts(),
            residuals: prepared.march.totals().relative_residuals(),
            sound,
            notes: prepared.notes,
            warnings,
            meter,
        }
    }

    /// State of the run at its end, for its effects.
    fn end(&self) -> End<'_> {
        let Prepared { march, road, contact, .. } = &self.prepared;
        End {
            loaded: &self.loaded,
            plan: &self.plan,
            steps: self.next_step,
            valid_to: contact.force_valid_to(),
            slice_errors: contact.slice_errors.as_ref(),
            footprint: march.footprint(),
            geometry: march.geometry(),
            road: road.slices(),
        }
    }

    /// Collects the figures of all effects.
    pub(crate) fn findings(&self) -> Found {
        let (mut found, end) = (Found::default(), self.end());
        self.observers.iter().for_each(|(_, observer)| observer.report(&end, &mut found));
        found
    }

    /// Lets all effects write their tables, pictures, sounds and maps.
    ///
    /// # Errors
    /// Errors of the files and pictures.
    pub(crate) fn write(&mut self, files: &dyn ResultFiles, found: &mut Found) -> Result<(), RunError> {
        self.append_sections(true)?;
        if let Some(sections) = self.sections.take() {
            sections.finish(files)?;
        }
        let mut meter = std::mem::take(&mut self.meter);
        let end = self.end();
        let written = self.observers.iter().try_for_each(|(_, of)| of.write(&end, files, found, &mut meter));
        self.meter = meter;
        written
    }

    /// Begins the contact again over a window of cells `window` times as long as the reported one, if it is shorter;
    /// recorded steps stay.
    pub(crate) fn widen(&mut self, window: f64) -> Result<(), RunError> {
        if self.plan.window >= window {
            return Ok(());
        }
        self.plan.window = window;
        let (stop, mut unwatched) = (AtomicBool::new(false), Unwatched);
        let mut job = Job { meter: std::mem::take(&mut self.meter), ..Job::new(&stop, &mut unwatched) };
        let prepared = prepare(&self.loaded, &self.plan, &mut job);
        self.meter = job.meter;
        let Prepared { march, road, axle, .. } = prepared?;
        let prepared = &mut self.prepared;
        (prepared.march, prepared.road, prepared.axle) = (march, road, axle);
        Ok(())
    }

    /// Continues after `steps` recorded steps; `false` if the contact cannot be there.
    pub(crate) fn resume_after(&mut self, steps: u64) -> bool {
        self.next_step = steps;
        let done = self.prepared.march.next_step();
        done == steps || done < steps && self.window() > 1.0
    }

    /// Finer mesh to which the levels are corrected.
    pub(crate) fn finer_mesh(&self) -> Option<FinerMesh> {
        Some(self.plan.corrections.as_ref()?.mesh)
    }

    /// Length of the window of cells over that of the reported forces.
    pub(crate) fn window(&self) -> f64 {
        self.plan.window
    }

    /// Advances the contact by a step and lets it be observed. If contact reaches the end of a window of cells it
    /// begins again over a wider one, since other waves carry the history through that; `None` until it has caught up.
    fn advance(&mut self) -> Result<Option<StepResult>, RunError> {
        let Self { plan, next_step, prepared, observers, observers_of_caller, power, arrays, meter, .. } = self;
        let Prepared { march, road, axle, contact, .. } = prepared;
        let number = march.next_step();
        meter.begin_step(number);
        // 1. Road and axle of the step, then the contact.
        let reach = march.reach(number);
        road.reach(reach.start, reach.end, meter)?;
        let indentation = axle.indentation(number);
        let result = match march.step(axle, road.slices(), meter) {
            Err(ContactError::AtWindowEnd { .. }) => {
                let times = 1 + march.totals().edge_contacts;
                self.widen(WIDER * self.window())?;
                self.prepared.march.count_again(times);
                return Ok(None);
            }
            result => result?,
        };
        axle.observe(number, result.total_force);
        // 2. After a new begin over a wider window, steps that are recorded already are only repeated.
        if number < *next_step {
            return Ok(None);
        }
        // 3. Effects and arrays see the step.
        *next_step = number + 1;
        let footprint = march.footprint();
        let mut step = Step {
            number,
            time: number as f64 * plan.time_step,
            counts: number >= plan.warm_up_steps,
            indentation: indentation - plan.decisions.growth,
            total_force: result.total_force,
            power: None,
            contact_length: result.extent as f64 * plan.element,
            point_size: contact.point_size,
            footprint,
            geometry: march.geometry(),
        };
        // Backward differences need the two steps before.
        if let Some(power) = power.as_mut().filter(|_| number + 2 >= plan.warm_up_steps) {
            let by_normal = power.push(footprint.first_point(), footprint.forces(), footprint.displacements());
            let by_tangential = footprint.tangential().map(|part| part.power);
            step.power = Some(by_tangential.map_or(by_normal, |by_tangential| by_normal + by_tangential));
        }
        if let Some(arrays) = arrays {
            meter.time_in_step(Stage::Output, || arrays.push(&step))?;
        }
        for (_, observer) in observers {
            observer.observe(&step, meter)?;
        }
        for observer in observers_of_caller {
            observer.observe(&step, meter)?;
        }
        meter.end_step(number + 1);
        Ok(Some(result))
    }

    /// Time spent in the stages of the steps so far, as far as steps were timed: all of it if every step is.
    pub fn spent(&self) -> [Duration; Stage::OF_A_STEP.len()] {
        Stage::OF_A_STEP.map(|stage| self.meter.spent(stage))
    }

    /// Begins the steps, from the next one to the last.
    pub(crate) fn enter_steps(&mut self) {
        let (first, end) = (self.next_step, self.plan.steps);
        if let Some(trace) = self.meter.trace_mut() {
            trace.expect_steps(first, end);
        }
        self.meter.enter(Phase::Contact);
    }

    /// Adds the cost of the steps to the meter; called once, at the end.
    pub(crate) fn settle(&mut self) {
        let next = self.next_step;
        let Self { prepared: Prepared { march, .. }, meter, .. } = self;
        if let Some(trace) = meter.trace_mut() {
            trace.end_block(next);
        }
        meter.enter(Phase::Results);
        meter.settle_steps(next);
        let counts = march.search_counts();
        meter.add_work(Stage::ActiveSet, counts.work - counts.factorisation);
        meter.add_work(Stage::Factorisation, counts.factorisation);
        for (counter, amount) in [
            (Counter::Steps, next),
            (Counter::HistoryMultiplyAdds, meter.cost(Stage::History).work.multiply_adds),
            (Counter::WindowEdgeContacts, march.totals().edge_contacts),
            (Counter::Solves, counts.solves),
            (Counter::Fallbacks, counts.fallbacks),
            (Counter::Factorisations, counts.factors.factorisations),
            (Counter::Bands, counts.factors.bands),
            (Counter::Refactorisations, counts.factors.refactorisations),
            (Counter::CacheHits, counts.factors.hits),
            (Counter::CacheMisses, counts.factors.misses),
            (Counter::Neighbours, counts.factors.neighbours),
            (Counter::CacheEvictions, counts.factors.evictions),
        ] {
            meter.count(counter, amount);
        }
    }
}

impl Evolving for Simulation {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        self.power.state(state)?;
        for (name, observer) in &mut self.observers {
            state.same(&name.to_string())?;
            observer.state(state)?;
        }
        let Prepared { axle, road, march, .. } = &mut self.prepared;
        state.all([axle, road, march])
    }
}
