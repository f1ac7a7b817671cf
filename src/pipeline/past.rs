//! The ways to carry the past, made for a planned scene.

use super::error::RunError;
use super::plan::Plan;
use crate::contact::ContactError;
use crate::contact::history::{DirectHistory, ModalHistory, PastForces};
use crate::contact::tread::{ContactKernel, LagKernel};
use crate::meter::{Counter, Meter, Stage};
use crate::scene::{LoadedScene, SceneError};
use crate::tyre::convolution_quadrature::Weights;
use crate::tyre::influence::{Field, InfluenceSum};
use crate::tyre::rational::{FitOptions, fit};

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

/// What the points in contact feel of each other at once, and of the past.
pub type Kernels = (ContactKernel, Box<dyn PastForces>);

impl Past<'_> {
    /// Weights summed on the contour of the quadrature, for the lags of the scene's memory.
    ///
    /// # Errors
    /// As [`ContactKernel::new`].
    pub fn direct(&self, meter: &mut Meter, warnings: &mut Vec<String>) -> Result<Kernels, RunError> {
        let numerics = &self.loaded.scene.numerics;
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
    pub fn modal(&self, meter: &mut Meter) -> Result<Kernels, RunError> {
        let scene = &self.loaded.scene;
        let (rule, time_step) = (scene.numerics.time_rule, self.plan.time_step);
        let options = FitOptions {
            driven: self.field,
            tolerance: scene.numerics.pole_tolerance,
            // The sums must be exacter than the fit to them.
            influence_tolerance: scene.numerics.influence_tolerance.min(0.1 * scene.numerics.pole_tolerance),
            ..FitOptions::new(&scene.tyre, scene.numerics.elements, self.plan.speed * scene.numerics.substeps as f64)
        };
        let model = meter.time(Stage::Influence, || fit(&scene.tyre, &options)).map_err(|error| {
            let right = "another tolerance, or history = \"direct\"";
            SceneError::from(self.loaded.complain("numerics.pole_tolerance", error.to_string(), right))
        })?;
        meter.count(Counter::ComplianceEvaluations, model.evaluations());
        meter.count(Counter::Poles, model.order() as u64);
        let (first, history) = ModalHistory::first_weights(&model, self.field, rule, time_step)
            .zip(ModalHistory::new(&model, self.field, rule, time_step))
            .ok_or(ContactError::NoSuchField)?;
        Ok((self.kernel(&first)?, Box::new(history)))
    }

    fn kernel(&self, first_weights: &[f64]) -> Result<ContactKernel, ContactError> {
        let scene = &self.loaded.scene;
        ContactKernel::new(scene.contact.tread, first_weights, scene.numerics.elements, self.spring)
    }
}
