//! A run in memory: made from a scene and its plan, stepped as far as the caller likes, turned into results. The front
//! page of the library has an example.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::contact::ContactError;
use crate::contact::complementarity::{Residuals, SearchCounts};
use crate::contact::march::StepResult;
use crate::counters::{Counter, Meter, Phase, Stage, Timing, Watch, Work};
use crate::plan::Plan;
use crate::response::PowerSpectrum;
use crate::results::summary::RollingResistance;
use crate::run::cell_record::CellRecorder;
use crate::run::error::RunError;
use crate::run::prepare::{Prepared, prepare};
use crate::run::progress::Unwatched;
use crate::run::record::{Record, StepRecord};
use crate::run::rolling_resistance::PowerRecorder;
use crate::run::sound::{HeardSound, SoundRecorder};
use crate::run::vibration::{HeardVibration, VibrationRecorder};
use crate::scene::{LoadedScene, Zone};

/// Factor by which a window of cells becomes longer once contact has reached its end.
const WIDER: f64 = 1.5;

/// A run between two of its steps.
pub struct Run {
    /// Scene and plan from which contact over cells begins again; slices have none.
    again: Option<Box<(LoadedScene, Plan)>>,
    /// Number of all steps.
    steps: u64,
    /// \[s\].
    time_step: f64,
    /// Length of an element \[m\].
    element: f64,
    /// The step after the last one that is recorded; the contact is behind it after it began again.
    next_step: u64,
    /// Contact, road and axle.
    pub(crate) prepared: Prepared,
    /// Record of the steps.
    pub(crate) record: Record,
    /// Cost so far.
    pub(crate) meter: Meter,
}

/// Findings of a run after its warm-up; numbers that do not exist (nothing counted yet) are `None`.
#[derive(Clone, Debug)]
pub struct Results {
    /// Time steps done, warm-up included.
    pub steps: u64,
    /// Mean total contact force \[N\].
    pub mean_force: Option<f64>,
    /// Root mean square of the force less its mean \[N\].
    pub rms_force_variation: Option<f64>,
    /// Mean length of the contact patch \[m\].
    pub mean_contact_length: Option<f64>,
    /// Rolling resistance, where the tread law has one.
    pub rolling_resistance: Option<RollingResistance>,
    /// Averaged spectrum of the total force; `None` for a run that did not reach its end, or is too short for one.
    pub spectrum: Option<PowerSpectrum>,
    /// Work of the search for the forces.
    pub search: SearchCounts,
    /// How far the contact conditions are missed, at worst; relative to the largest force and displacement.
    pub residuals: Residuals,
    /// Sound at the receivers, where it was listened to and the run was long enough.
    pub sound: Option<HeardSound>,
    /// Choices of the plan, and effects that it leaves out.
    pub notes: Vec<String>,
    /// Warnings that the user should act on.
    pub warnings: Vec<String>,
    /// Cost of the run.
    pub meter: Meter,
}

impl Run {
    /// Prepares a run that keeps its results in memory; receivers hear nothing of it, [`crate::run::run()`] is theirs.
    /// `stop` ends the work on the influence functions once it is set.
    ///
    /// # Errors
    /// [`RunError`]: what the scene asks for cannot be simulated, a road that cannot be read, ...
    pub fn begin(loaded: &LoadedScene, plan: &Plan, stop: &AtomicBool) -> Result<Self, RunError> {
        Self::begin_watched(loaded, plan, stop, Watch::default())
    }

    /// As [`Self::begin`], its cost watched as closely as it is told.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn begin_watched(loaded: &LoadedScene, plan: &Plan, stop: &AtomicBool, watch: Watch) -> Result<Self, RunError> {
        loaded.check_time_domain()?;
        let mut meter = Meter::new(watch);
        let mut prepared = prepare(loaded, plan, stop, &mut meter)?;
        let mut record = Record::in_memory(&plan.scene, plan, true);
        let points = prepared.march.footprint().shape().points();
        record.power = PowerRecorder::new(plan, plan.scene.numerics.time_rule, points);
        record.cells = CellRecorder::new(plan, &prepared.march, None)?;
        record.vibration = VibrationRecorder::prepare(loaded, plan, &mut prepared, stop, &mut meter)?;
        let mut run = Self::new(loaded, plan, prepared, record, meter);
        run.enter_steps();
        Ok(run)
    }

    /// As [`Self::begin_watched`], and its receivers hear it.
    ///
    /// # Errors
    /// As [`Self::begin`], and of [`SoundRecorder::prepare`].
    pub fn begin_heard(loaded: &LoadedScene, plan: &Plan, stop: &AtomicBool, watch: Watch) -> Result<Self, RunError> {
        let mut run = Self::begin_watched(loaded, plan, stop, watch)?;
        let Self { prepared, meter, record, .. } = &mut run;
        record.sound = SoundRecorder::prepare(loaded, plan, prepared, stop, &mut Unwatched, meter)?;
        Ok(run)
    }

    /// A prepared run with its record.
    pub(crate) fn new(loaded: &LoadedScene, plan: &Plan, prepared: Prepared, record: Record, meter: Meter) -> Self {
        let has_cells = plan.decisions.zone == Zone::Cells;
        let again = has_cells.then(|| Box::new((loaded.clone(), plan.clone())));
        let &Plan { steps, time_step, element, .. } = plan;
        Self { again, steps, time_step, element, next_step: 0, prepared, record, meter }
    }

    /// Changes how closely steps are timed from now on.
    pub fn set_timing(&mut self, timing: Timing) {
        self.meter.set_timing(timing);
    }

    /// Number of the next step; the number of all steps after the last.
    pub fn next_step(&self) -> u64 {
        self.next_step
    }

    /// Does a step and says what it gave; `None` after the last.
    ///
    /// # Errors
    /// [`RunError`]; the run cannot go on then.
    pub fn step(&mut self) -> Result<Option<StepResult>, RunError> {
        while self.next_step() < self.steps {
            if let Some(result) = self.advance()? {
                return Ok(Some(result));
            }
        }
        Ok(None)
    }

    /// Contact forces of the last step by column of the window, the first one that of element
    /// [`StepResult::first_element`] \[N\].
    pub fn forces(&self) -> &[f64] {
        self.prepared.march.footprint().column_mean()
    }

    /// Velocities of the steps so far, where the scene asks for them and a segment of them is complete.
    pub fn vibration(&mut self) -> Option<HeardVibration> {
        let Self { record, meter, .. } = self;
        record.vibration.as_ref().and_then(|recorder| recorder.found(false, meter)).map(|(heard, _)| heard)
    }

    /// Ends the run, wherever it is.
    pub fn finish(mut self) -> Results {
        self.settle();
        let Self { prepared, record, meter, .. } = self;
        let sound = record.sound.as_ref().and_then(|sound| sound.heard().ok());
        Results {
            steps: self.next_step,
            mean_force: record.mean_force(),
            rms_force_variation: record.rms_force_variation(),
            mean_contact_length: record.mean_contact_length(),
            rolling_resistance: record.rolling_resistance(),
            spectrum: record.spectrum(),
            search: prepared.march.search_counts(),
            residuals: prepared.march.totals().relative_residuals(),
            sound,
            notes: prepared.notes,
            warnings: prepared.warnings,
            meter,
        }
    }

    /// Makes the contact begin again over a window of cells so many times as long as the one whose forces are told,
    /// if it is shorter; what was recorded stays.
    pub(crate) fn widen(&mut self, window: f64) -> Result<(), RunError> {
        let Some((loaded, plan)) = self.again.as_deref_mut().filter(|again| again.1.window < window) else {
            return Ok(());
        };
        plan.window = window;
        let Prepared { march, road, axle, .. } = prepare(loaded, plan, &AtomicBool::new(false), &mut self.meter)?;
        let prepared = &mut self.prepared;
        (prepared.march, prepared.road, prepared.axle) = (march, road, axle);
        Ok(())
    }

    /// Goes on after so many recorded steps; `false` if the contact cannot be where it is then.
    pub(crate) fn go_on_after(&mut self, steps: u64) -> bool {
        self.next_step = steps;
        let done = self.prepared.march.next_step();
        done == steps || done < steps && self.window() > 1.0
    }

    /// Length of the window of cells over that whose forces are told.
    pub(crate) fn window(&self) -> f64 {
        self.again.as_ref().map_or(1.0, |again| again.1.window)
    }

    /// Brings the contact on by a step, and records it. Where contact reaches the end of a window of cells it begins
    /// again over a wider one, since other waves carry the past through that; `None` until it has come as far as it
    /// was.
    pub(crate) fn advance(&mut self) -> Result<Option<StepResult>, RunError> {
        let Self { time_step, element, next_step, prepared: Prepared { march, road, axle, .. }, record, meter, .. } =
            self;
        let step = march.next_step();
        meter.begin_step(step);
        let reach = march.reach(step);
        road.reach(reach.start, reach.end, meter)?;
        let indentation = axle.indentation(step);
        let result = match march.step(axle, road.slices(), meter) {
            Err(ContactError::AtWindowEnd { .. }) => {
                let times = 1 + march.totals().edge_contacts;
                self.widen(WIDER * self.window())?;
                self.prepared.march.count_again(times);
                return Ok(None);
            }
            result => result?,
        };
        axle.observe(step, result.total_force);
        if step < *next_step {
            return Ok(None);
        }
        *next_step = step + 1;
        record.push(
            StepRecord {
                step,
                time: step as f64 * *time_step,
                total_force: result.total_force,
                first_element: result.first_element,
                forces: march.footprint().column_mean(),
                contact_length: result.extent as f64 * *element,
                indentation,
            },
            meter,
        )?;
        if let Some(cells) = &mut record.cells {
            meter.time_in_step(Stage::Output, || cells.push(step, march))?;
        }
        if let Some(power) = &mut record.power {
            power.push(step, march);
        }
        if let Some(vibration) = &mut record.vibration {
            vibration.push(step, march, meter);
        }
        if let Some(sound) = &mut record.sound {
            sound.push(step, march, meter);
        }
        self.meter.end_step(step + 1);
        Ok(Some(result))
    }

    /// Time that the stages of its steps have taken so far, as far as steps were timed: all of it if every step is.
    pub fn spent(&self) -> [Duration; Stage::OF_A_STEP.len()] {
        Stage::OF_A_STEP.map(|stage| self.meter.spent(stage))
    }

    /// The steps begin: from the next one to the last.
    pub(crate) fn enter_steps(&mut self) {
        let (first, end) = (self.next_step(), self.steps);
        if let Some(trace) = self.meter.trace_mut() {
            trace.expect_steps(first, end);
        }
        self.meter.enter(Phase::Contact);
    }

    /// Hands what the steps have cost to the meter; once, at the end.
    pub(crate) fn settle(&mut self) {
        let next = self.next_step();
        let Self { prepared: Prepared { march, .. }, meter, .. } = self;
        if let Some(trace) = meter.trace_mut() {
            trace.end_block(next);
        }
        meter.enter(Phase::Results);
        meter.settle_steps(next);
        let counts = march.search_counts();
        meter.add_work(Stage::ActiveSet, counts.work - counts.factorisation);
        meter.add_work(Stage::Factorisation, counts.factorisation);
        let bytes = meter.counted(Counter::BytesWritten);
        meter.add_work(Stage::Output, Work { multiply_adds: 0, bytes });
        for (counter, amount) in [
            (Counter::Steps, next),
            (Counter::HistoryMultiplyAdds, meter.cost(Stage::History).work.multiply_adds),
            (Counter::WindowEdgeContacts, march.totals().edge_contacts),
            (Counter::Solves, counts.solves),
            (Counter::Fallbacks, counts.fallbacks),
            (Counter::Factorisations, counts.factors.factorisations),
            (Counter::CacheHits, counts.factors.hits),
            (Counter::CacheMisses, counts.factors.misses),
            (Counter::Neighbours, counts.factors.neighbours),
            (Counter::CacheEvictions, counts.factors.evictions),
        ] {
            meter.count(counter, amount);
        }
    }
}
