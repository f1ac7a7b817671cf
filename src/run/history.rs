//! Histories of contact over slices, made for a planned scene.

use crate::contact::ContactError;
use crate::contact::history::{DirectHistory, ForceHistory, INSTANTS, LagKernel, ModalHistory, SinglePrecision};
use crate::contact::kernel::{ContactKernel, EqualBedding};
use crate::contact::stability::{UNSTABLE, unstable_zero};
use crate::counters::{Counter, Job, Stage};
use crate::effects::RunError;
use crate::plan::Plan;
use crate::plan::models::{count_evaluations, planned_model};
use crate::scene::{LoadedScene, SceneError};
use crate::tyre::influence::InfluenceSum;
use crate::tyre::influence::convolution_quadrature::Weights;
use crate::tyre::poles::RationalModel;

/// Ingredients of a history.
pub(crate) struct HistoryBuilder<'a> {
    /// Scene as loaded.
    pub loaded: &'a LoadedScene,
    /// Plan of the scene.
    pub plan: &'a Plan,
    /// Sums of the influence functions.
    pub sum: &'a InfluenceSum,
    /// Columns of the contact window.
    pub columns: usize,
    /// Factor of the influence functions, and the spring in series with them.
    pub bedding: EqualBedding,
}

/// Influence between the points in contact within an instant, and the history; and the model that both were made from,
/// if there is one.
pub(crate) type Kernels = (ContactKernel, Box<dyn ForceHistory>, Option<RationalModel>);

impl HistoryBuilder<'_> {
    /// Direct history: weights summed on the contour of the quadrature, for the lags of the scene's memory.
    ///
    /// # Errors
    /// As [`ContactKernel::new`]; [`RunError::Interrupted`].
    pub(crate) fn direct(&self, job: &mut Job<'_>) -> Result<Kernels, RunError> {
        let numerics = &self.plan.scene.numerics;
        let weights = job.meter.time(Stage::Influence, || {
            let (rule, time_step) = (numerics.time_rule, self.plan.time_step);
            Weights::unless_stopped(self.sum, self.plan.field, rule, time_step, self.plan.lags, job.stop)
        });
        let weights = weights.ok_or(RunError::Interrupted { partial: None })?;
        count_evaluations(self.plan, weights.evaluations, &mut job.meter);
        let truncated = weights.truncated();
        if truncated > 0.01 && self.plan.lags as u64 <= self.plan.steps {
            job.warnings.push(format!(
                "numerics.memory = {} s leaves out {:.1} % of the static influence function: a longer memory is more \
                 exact",
                numerics.memory,
                100.0 * truncated
            ));
        }
        job.meter.time(Stage::Influence, || {
            let wavenumbers = 0..=numerics.elements / 2;
            let first: Vec<f64> = wavenumbers.clone().map(|n| weights.of(n)[0]).collect();
            let odd: Vec<f64> = wavenumbers.filter_map(|n| weights.odd_of(n).first().copied()).collect();
            let lags = LagKernel::new(&weights, numerics.elements, self.columns, numerics.advance());
            let history = DirectHistory::new(lags, self.columns, numerics.advance());
            Ok((self.kernel([&first, &odd])?, Box::new(history) as Box<dyn ForceHistory>, None))
        })
    }

    /// Modal history: poles fitted to the influence functions.
    ///
    /// # Errors
    /// A fit that was refused; as [`ContactKernel::new`].
    pub(crate) fn modal(&self, job: &mut Job<'_>) -> Result<Kernels, RunError> {
        let (rule, time_step) = (self.plan.scene.numerics.time_rule, self.plan.time_step);
        let right = "another tolerance, or history = \"direct\"";
        let model = planned_model(self.loaded, self.plan, right, job)?;
        job.meter.count(Counter::Poles, model.order() as u64);
        job.meter.time(Stage::Influence, || self.check_stability(&model, &mut job.warnings))?;
        let field = self.plan.field;
        let (tolerance, advance) = (self.plan.fit.tolerance, self.plan.scene.numerics.advance());
        let single = self.plan.is_single().then_some(SinglePrecision { tolerance, advance });
        let windows = [self.columns, advance.elements_per_step];
        let history = ModalHistory::with_blocks(&model, field, rule, time_step, windows, INSTANTS, single);
        let (first, odd) = ModalHistory::first_weights(&model, field, rule, time_step)
            .zip(ModalHistory::odd_first_weights(&model, field, rule, time_step))
            .ok_or(ContactError::NoSuchField)?;
        let kernel = self.kernel([&first, &odd])?;
        Ok((kernel, Box::new(history.ok_or(ContactError::NoSuchField)?), Some(model)))
    }

    /// Refuses a model whose inverse is unstable under this rule and time step; warns where a force grows slowly.
    fn check_stability(&self, model: &RationalModel, warnings: &mut Vec<String>) -> Result<(), RunError> {
        let (rule, time_step) = (self.plan.scene.numerics.time_rule, self.plan.time_step);
        // The zeros of scale w + spring are those of w + spring/scale.
        let spring = self.bedding.spring / self.bedding.scale;
        if let Some(zero) = unstable_zero(model, self.plan.field, rule, time_step, spring)? {
            let wrong = format!(
                "the inverse of the discretised tyre is unstable with \"{}\" at dt = {time_step:.3e} s: at wavenumber \
                 {} (and {} others) a force at {:.0} Hz grows by a factor of {:.3} a step while nothing moves, and the \
                 contact would chatter",
                rule.name(),
                zero.wavenumber,
                zero.wavenumbers - 1,
                zero.frequency,
                1.0 / zero.zeta.norm()
            );
            let right = "a smaller tolerance: its poles generate energy";
            if zero.zeta.norm() >= UNSTABLE {
                warnings.push(format!("{wrong}; numerics.pole_tolerance: {right}"));
                return Ok(());
            }
            return Err(SceneError::from(self.loaded.complain("numerics.pole_tolerance", wrong, right)).into());
        }
        Ok(())
    }

    fn kernel(&self, first_weights: [&[f64]; 2]) -> Result<ContactKernel, ContactError> {
        let elements = self.plan.scene.numerics.elements;
        ContactKernel::new(self.plan.decisions.tread, first_weights, elements, self.bedding)
    }
}
