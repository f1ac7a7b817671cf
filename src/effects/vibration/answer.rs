//! Response of the tyre to the forces of a run: as a whole, or by lateral number for forces on cells.

use crate::counters::{Counter, Job, Meter, Stage};
use crate::effects::effect::RunStart;
use crate::effects::error::RunError;
use crate::plan::Plan;
use crate::plan::models::{count_evaluations, planned_model, refused};
use crate::response::vibration::{
    DispersionBranch, SegmentLayout, TangentialForces, TyreResponse, VibrationField, dispersion_branches,
};
use crate::scene::{LoadedScene, SceneError};
use crate::storage::Cache;
use crate::tyre::influence::Field;
use crate::tyre::poles::lateral::fit_lateral;
use crate::tyre::poles::{RationalModel, TangentialModel, lateral_tangential_model, tangential_model};

/// Remedy where a fit is refused.
const INSTEAD: &str = "another tolerance, or no [outputs.vibration]";

/// Response of the tyre to the forces of a run.
pub(super) struct TyreAnswer {
    /// By component of the forces.
    components: Vec<Component>,
    /// Angular velocity of the tyre \[rad/s\].
    angular_velocity: f64,
    scale: f64,
    spring: f64,
    /// Response to tangential forces, where there are any.
    tangential_forces: Option<TangentialForces>,
}

/// Response to one component.
struct Component {
    /// Observed share of its velocity: the mean over the strip.
    share: f64,
    /// Lateral number m of a component of forces on cells.
    number: Option<usize>,
    model: RationalModel,
    tangential: Option<TangentialModel>,
}

impl TyreAnswer {
    /// Response for a prepared run, for these lateral numbers, or for forces that are even across.
    ///
    /// # Errors
    /// A fit that was refused; [`RunError::Interrupted`].
    pub(super) fn new(
        begin: &mut RunStart<'_>,
        numbers: Option<&[usize]>,
        job: &mut Job<'_>,
    ) -> Result<Self, RunError> {
        let RunStart { loaded, plan, contact, models, .. } = begin;
        let (scale, spring) = (contact.scale, contact.spring);
        let component = |share, number, model| Component { share, number, model, tangential: None };
        let components = match (numbers, models.poles.take()) {
            (Some(numbers), _) => {
                let models = lateral_models(loaded, plan, numbers, job)?;
                let grid = plan.cell_grid();
                let known = numbers.iter().zip(models);
                known.map(|(&m, model)| component(grid.mean_shape(m), Some(m), model)).collect()
            }
            (None, Some(model)) => vec![component(1.0, None, model)],
            (None, None) => {
                let model = planned_model(loaded, plan, INSTEAD, job)?;
                vec![component(1.0, None, model)]
            }
        };
        Ok(Self {
            components,
            angular_velocity: plan.decisions.tyre.angular_velocity,
            scale,
            spring,
            tangential_forces: None,
        })
    }

    /// Adds the tangential motion up to an angular frequency \[rad/s\].
    ///
    /// # Errors
    /// A fit that was refused.
    pub(super) fn add_tangential(
        &mut self,
        loaded: &LoadedScene,
        plan: &Plan,
        top: f64,
        meter: &mut Meter,
    ) -> Result<(), RunError> {
        let tyre = &plan.decisions.tyre;
        for Component { number, model, tangential, .. } in &mut self.components {
            let fitted = meter.time(Stage::Influence, || match *number {
                None => tangential_model(tyre, model, top),
                Some(m) => lateral_tangential_model(tyre, model, top, m),
            });
            let fitted = fitted.map_err(|error| {
                let right = "tangential = false";
                SceneError::from(loaded.complain("outputs.vibration.tangential", error.to_string(), right))
            })?;
            meter.count(Counter::ComplianceEvaluations, fitted.evaluations);
            *tangential = Some(fitted);
        }
        Ok(())
    }

    /// Adds the response to tangential forces.
    pub(super) fn take_tangential_forces(&mut self, plan: &Plan, layout: &SegmentLayout) {
        let components = self.components.iter();
        let numbers: Vec<(usize, f64)> =
            components.filter_map(|component| Some((component.number?, component.share))).collect();
        let tolerance = plan.scene.numerics.influence_tolerance;
        self.tangential_forces = Some(TangentialForces::new(&plan.decisions.tyre, layout, &numbers, tolerance));
    }

    pub(super) fn tangential_forces(&self) -> Option<&TangentialForces> {
        self.tangential_forces.as_ref()
    }

    /// For each component the share of its velocities that is observed, and the response.
    pub(super) fn responses(&self) -> Vec<(f64, TyreResponse<'_>)> {
        let Self { scale, spring, .. } = *self;
        let responses = self.components.iter().map(|Component { share, model, tangential, .. }| {
            (*share, TyreResponse { model, scale, spring, tangential: tangential.as_ref() })
        });
        responses.collect()
    }

    /// True if waves of both directions have separate values: for a tyre that turns, and for tangential forces.
    pub(super) fn has_both_directions(&self) -> bool {
        self.tangential_forces.is_some() || self.components.iter().any(|component| component.model.turns())
    }

    /// Worst error and truncation of the tangential transfers, where there are any.
    pub(super) fn tangential_error(&self) -> Option<[f64; 2]> {
        let errors = self.components.iter().filter_map(|component| component.tangential.as_ref());
        errors.map(|model| [model.error, model.omitted]).reduce(|[a, b], [c, d]| [a.max(c), b.max(d)])
    }

    /// Free waves of the tyre below a frequency \[Hz\], as a field shows them.
    pub(super) fn branches(&self, field: VibrationField, highest: f64) -> Vec<DispersionBranch> {
        let of_component = |Component { model, .. }: &Component| {
            let face = if field == VibrationField::Belt { Field::Bottom } else { model.driven };
            dispersion_branches(model, self.angular_velocity, face, highest)
        };
        self.components.iter().flat_map(of_component).collect()
    }
}

/// Models of lateral numbers, from the user's cache or fitted all at once.
fn lateral_models(
    loaded: &LoadedScene,
    plan: &Plan,
    numbers: &[usize],
    job: &mut Job<'_>,
) -> Result<Vec<RationalModel>, RunError> {
    let (tyre, options) = (&plan.decisions.tyre, plan.lateral_fit());
    let cache = Cache::open().ok();
    let key = |m: usize| options.key(tyre, m).ok();
    let mut cached = |m: usize| cache.as_ref()?.get::<RationalModel>(&key(m)?, &mut job.warnings);
    let mut models: Vec<Option<RationalModel>> = numbers.iter().map(|&m| cached(m)).collect();
    let known = numbers.iter().zip(&models);
    let missing: Vec<usize> = known.filter(|(_, model)| model.is_none()).map(|(&m, _)| m).collect();
    if !missing.is_empty() {
        let fitted = job.meter.time(Stage::Fit, || fit_lateral(tyre, &missing, &options, job.stop));
        let fitted = fitted.map_err(|error| refused(loaded, error, INSTEAD))?;
        let places = models.iter_mut().filter(|model| model.is_none());
        for ((place, model), m) in places.zip(fitted).zip(missing) {
            count_evaluations(plan, model.evaluations(), &mut job.meter);
            if let Some((cache, key)) = cache.as_ref().zip(key(m)) {
                cache.keep(&key, &model, &mut job.warnings);
            }
            *place = Some(model);
        }
    }
    Ok(models.into_iter().flatten().collect())
}
