//! The ways to carry the past, made for a planned scene.

use super::error::RunError;
use super::plan::Plan;
use crate::contact::ContactError;
use crate::contact::history::{DirectHistory, ModalHistory, PastForces};
use crate::contact::stability::Stability;
use crate::contact::tread::{ContactKernel, LagKernel};
use crate::meter::{Counter, Meter, Stage};
use crate::scene::{LoadedScene, Numerics, Scene, SceneError, TimeRule, Tyre};
use crate::tyre::convolution_quadrature::Weights;
use crate::tyre::influence::{Field, InfluenceSum};
use crate::tyre::rational::cache::{Cache, Fetched};
use crate::tyre::rational::{FitError, FitOptions, RationalModel, fit};

/// What a way to carry the past is made from.
pub struct Past<'a> {
    /// The scene.
    pub loaded: &'a LoadedScene,
    /// Its plan.
    pub plan: &'a Plan,
    /// The influence functions.
    pub sum: &'a InfluenceSum,
    /// The displacement that the contact feels.
    pub field: Field,
    /// Columns of the contact window.
    pub columns: usize,
    /// Spring compliance per element \[m/N\].
    pub spring: f64,
}

/// A model from the user's cache, or fitted where there is none.
///
/// # Errors
/// [`FitError`] for a fit that is refused.
pub fn fetch(tyre: &Tyre, options: &FitOptions) -> Result<Fetched, FitError> {
    match Cache::open() {
        Ok(cache) => cache.fetch(tyre, options),
        Err(error) => Ok(Fetched {
            model: fit(tyre, options)?,
            warm: false,
            warnings: vec![format!("no cache of influence models: {error}")],
        }),
    }
}

/// The options of the model that a scene's run needs.
pub fn fit_options(scene: &Scene, field: Field) -> FitOptions {
    let Numerics { elements, substeps, pole_tolerance, influence_tolerance, .. } = scene.numerics;
    FitOptions {
        driven: field,
        tolerance: pole_tolerance,
        // The sums must be exacter than the fit to them.
        influence_tolerance: influence_tolerance.min(0.1 * pole_tolerance),
        ..FitOptions::new(&scene.tyre, elements, scene.rolling.speed() * substeps as f64)
    }
}

/// The warning of a rule that is marginal.
fn ringing(rule: TimeRule, time_step: f64) -> String {
    format!(
        "time_rule = \"{}\" is marginal: the force rings at half the sampling frequency ({:.0} Hz) without decay; \"bdf2\" does not",
        rule.name(),
        0.5 / time_step
    )
}

/// What the points in contact feel of each other at once, and of the past.
pub type Kernels = (ContactKernel, Box<dyn PastForces>);

impl Past<'_> {
    /// Weights summed on the contour of the quadrature, for the lags of the scene's memory.
    ///
    /// # Errors
    /// As [`ContactKernel::new`].
    pub fn direct(&self, meter: &mut Meter, warnings: &mut Vec<String>) -> Result<Kernels, RunError> {
        let numerics = &self.loaded.scene.numerics;
        if numerics.time_rule == TimeRule::Trapezoidal {
            warnings.push(ringing(numerics.time_rule, self.plan.time_step));
        }
        let weights = meter.time(Stage::Influence, || {
            Weights::new(self.sum, self.field, numerics.time_rule, self.plan.time_step, self.plan.lags)
        });
        meter.count(Counter::ComplianceEvaluations, weights.evaluations);
        let truncated = weights.truncated();
        if truncated > 0.01 && self.plan.lags as u64 <= self.plan.steps {
            warnings.push(format!(
                "numerics.memory = {} s leaves out {:.1} % of the static influence function: a longer memory is more exact",
                numerics.memory,
                100.0 * truncated
            ));
        }
        meter.time(Stage::Influence, || {
            let first: Vec<f64> = (0..=numerics.elements / 2).map(|n| weights.of(n)[0]).collect();
            let lags = LagKernel::new(&weights, numerics.elements, self.columns, numerics.substeps);
            let history = DirectHistory::new(lags, self.columns, numerics.substeps);
            Ok((self.kernel(&first)?, Box::new(history) as Box<dyn PastForces>))
        })
    }

    /// Poles fitted to the influence functions.
    ///
    /// # Errors
    /// A fit that was refused, as a complaint about the scene's tolerance; as [`ContactKernel::new`].
    pub fn modal(&self, meter: &mut Meter, warnings: &mut Vec<String>) -> Result<Kernels, RunError> {
        let scene = &self.loaded.scene;
        let (rule, time_step) = (scene.numerics.time_rule, self.plan.time_step);
        let options = fit_options(scene, self.field);
        let fetched = meter.time(Stage::Influence, || fetch(&scene.tyre, &options)).map_err(|error| {
            let right = "another tolerance, or history = \"direct\"";
            SceneError::from(self.loaded.complain("numerics.pole_tolerance", error.to_string(), right))
        })?;
        warnings.extend(fetched.warnings);
        let model = fetched.model;
        // A warm model took its evaluations in an earlier run.
        meter.count(Counter::ComplianceEvaluations, if fetched.warm { 0 } else { model.evaluations() });
        meter.count(Counter::Poles, model.order() as u64);
        meter.time(Stage::Influence, || self.check_rule(&model, warnings))?;
        let (first, history) = ModalHistory::first_weights(&model, self.field, rule, time_step)
            .zip(ModalHistory::new(&model, self.field, rule, time_step))
            .ok_or(ContactError::NoSuchField)?;
        Ok((self.kernel(&first)?, Box::new(history)))
    }

    /// Refuses a time rule whose inverse is unstable for this tyre and time step; warns of one that rings.
    fn check_rule(&self, model: &RationalModel, warnings: &mut Vec<String>) -> Result<(), RunError> {
        let (rule, time_step) = (self.loaded.scene.numerics.time_rule, self.plan.time_step);
        let stability =
            Stability::of(model, self.field, rule, time_step, self.spring).ok_or(ContactError::NoSuchField)?;
        if let Some(zero) = stability.unstable {
            let wrong = format!(
                "the inverse of the discretised tyre is unstable with \"{}\" at dt = {time_step:.3e} s: at wavenumber {} (and {} others) a force at {:.0} Hz grows \
                 by a factor of {:.2} a step while nothing moves, and the contact would chatter for ever",
                rule.name(),
                zero.wavenumber,
                zero.wavenumbers - 1,
                zero.frequency,
                1.0 / zero.zeta.norm()
            );
            let right = "time_rule = \"bdf2\", or another A-stable rule";
            return Err(SceneError::from(self.loaded.complain("numerics.time_rule", wrong, right)).into());
        }
        if stability.rings() {
            warnings.push(ringing(rule, time_step));
        }
        Ok(())
    }

    fn kernel(&self, first_weights: &[f64]) -> Result<ContactKernel, ContactError> {
        let scene = &self.loaded.scene;
        ContactKernel::new(scene.contact.tread, first_weights, scene.numerics.elements, self.spring)
    }
}
