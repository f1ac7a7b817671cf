//! A run in memory: made from a scene and its plan, stepped as far as the caller likes, turned into results.
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use tyrewave::pipeline::{Plan, Run};
//! use tyrewave::scene::Scene;
//!
//! let text = tyrewave::scene::DEFAULT.replace("elements = 512", "elements = 64").replace("duration = 18.0", "duration = 0.2");
//! let scene = Scene::from_str(&text, "small")?;
//! let plan = Plan::of(&scene);
//! plan.check(&scene)?;
//! let mut run = Run::begin(&scene, &plan, &AtomicBool::new(false))?;
//! while let Some(step) = run.step()? {
//!     assert!(step.total_force >= 0.0);
//! }
//! let results = run.finish();
//! assert!(results.mean_force.is_some_and(|force| (2500.0..4500.0).contains(&force)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use rayon::Scope;

use super::error::RunError;
use super::plan::Plan;
use super::prepare::{Prepared, prepare};
use super::record::{Record, StepRecord};
use super::vibration::VibrationRecorder;
use crate::contact::history::HistoryWork;
use crate::contact::march::StepResult;
use crate::meter::{Counter, Meter, Stage, Work};
use crate::response::PowerSpectrum;
use crate::scene::LoadedScene;

/// A run between two of its steps.
pub struct Run {
    /// Time steps of the whole run, and their length \[s\].
    steps: u64,
    time_step: f64,
    /// Length of an element \[m\].
    element: f64,
    /// Contact, road and axle.
    pub(super) prepared: Prepared,
    /// What is recorded.
    pub(super) record: Record,
    /// What it costs.
    pub(super) meter: Meter,
}

/// What a run has found after its warm-up; numbers that do not exist (nothing counted yet) are `None`.
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
    /// Averaged spectrum of the total force; `None` for a run that did not reach its end, or is too short for one.
    pub spectrum: Option<PowerSpectrum>,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// What it cost.
    pub meter: Meter,
}

impl Run {
    /// Prepares a run that keeps its results in memory. `stop` ends the work on the influence functions once it is set.
    ///
    /// # Errors
    /// [`RunError`]: what the scene asks for cannot be simulated, a road that cannot be read, ...
    pub fn begin(loaded: &LoadedScene, plan: &Plan, stop: &AtomicBool) -> Result<Self, RunError> {
        loaded.check_time_domain()?;
        let mut meter = Meter::default();
        let mut prepared = prepare(loaded, plan, stop, &mut meter)?;
        let mut record = Record::in_memory(&loaded.scene, plan, true);
        record.vibration = VibrationRecorder::prepare(loaded, plan, &mut prepared, stop, &mut meter)?;
        Ok(Self::new(plan, prepared, record, meter))
    }

    /// A prepared run with its record.
    pub(super) fn new(plan: &Plan, prepared: Prepared, record: Record, meter: Meter) -> Self {
        Self { steps: plan.steps, time_step: plan.time_step, element: plan.element, prepared, record, meter }
    }

    /// Number of the next step; the number of all steps after the last.
    pub fn next_step(&self) -> u64 {
        self.prepared.march.next_step()
    }

    /// Does a step and says what it gave; `None` after the last.
    ///
    /// # Errors
    /// [`RunError`]; the run cannot go on then.
    pub fn step(&mut self) -> Result<Option<StepResult>, RunError> {
        if self.next_step() >= self.steps { Ok(None) } else { self.step_beside(None).map(Some) }
    }

    /// Contact forces of the last step by column of the window, the first one that of element [`StepResult::first_element`] \[N\].
    pub fn forces(&self) -> &[f64] {
        self.prepared.march.forces()
    }

    /// Ends the run, wherever it is.
    pub fn finish(mut self) -> Results {
        self.settle();
        let Self { prepared, record, meter, .. } = self;
        Results {
            steps: prepared.march.next_step(),
            mean_force: record.mean_force(),
            rms_force_variation: record.rms_force_variation(),
            mean_contact_length: record.mean_contact_length(),
            spectrum: record.spectrum(),
            warnings: prepared.warnings,
            meter,
        }
    }

    /// The next step; given a scope to work in, the road is made in it ahead of its need.
    pub(super) fn step_beside(&mut self, behind: Option<&Scope<'_>>) -> Result<StepResult, RunError> {
        let Self { time_step, element, prepared: Prepared { march, road, axle, .. }, record, meter, .. } = self;
        let step = march.next_step();
        let first = march.geometry().first_element(step);
        road.reach(first, first + march.geometry().columns as i64, meter, behind)?;
        let indentation = axle.indentation(step);
        let result = march.step(axle, road.slices())?;
        axle.observe(step, result.total_force);
        record.push(
            StepRecord {
                step,
                time: step as f64 * *time_step,
                total_force: result.total_force,
                first_element: result.first_element,
                forces: march.forces(),
                contact_length: result.extent as f64 * *element,
                indentation,
            },
            meter,
        )?;
        if let Some(vibration) = &mut record.vibration {
            vibration.push(step, march, meter);
        }
        Ok(result)
    }

    /// Time that the stages of its steps have taken so far.
    pub fn spent(&self, stage: Stage) -> Duration {
        let within = self.march_costs().into_iter().find(|(of, ..)| *of == stage).map(|(_, time, _)| time);
        self.meter.cost(stage).wall + within.unwrap_or_default()
    }

    /// What the march has cost so far, by stage.
    fn march_costs(&self) -> [(Stage, Duration, Work); 4] {
        let (totals, search) = (self.prepared.march.totals(), self.prepared.march.search_counts().work);
        let HistoryWork { sums, transforms, transform_time } = totals.history;
        [
            (Stage::History, totals.history_time - transform_time, sums),
            (Stage::Transforms, transform_time, transforms),
            (Stage::Penetration, totals.slices_time, totals.slices),
            (Stage::ActiveSet, totals.search_time, search),
        ]
    }

    /// Hands what the steps have cost to the meter; once, at the end.
    pub(super) fn settle(&mut self) {
        let costs = self.march_costs();
        let Self { prepared: Prepared { march, .. }, meter, .. } = self;
        let (totals, counts) = (march.totals(), march.search_counts());
        for (stage, time, work) in costs {
            // A stage that this run does not have leaves no trace.
            if time > Duration::ZERO || work != Work::default() {
                meter.add_time(stage, time);
                meter.add_work(stage, work);
            }
        }
        let bytes = meter.counted(Counter::BytesWritten);
        meter.add_work(Stage::Output, Work { multiply_adds: 0, bytes });
        for (counter, amount) in [
            (Counter::Steps, march.next_step()),
            (Counter::HistoryMultiplyAdds, totals.history.sums.multiply_adds),
            (Counter::WindowEdgeContacts, totals.edge_contacts),
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
