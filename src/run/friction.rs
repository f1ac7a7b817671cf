//! Contact over cells with friction, made for a planned scene.

use crate::contact::ContactError;
use crate::contact::friction::free_creep::FreeCreep;
use crate::contact::friction::law::CellLaw;
use crate::contact::friction::past::TractionPast;
use crate::contact::friction::search::FrictionSearch;
use crate::contact::friction::transform::TractionTransform;
use crate::contact::friction::zone::{FrictionZone, Rolling};
use crate::contact::geometry::Geometry;
use crate::contact::march::March;
use crate::contact::static_contact::StaticContact;
use crate::contact::tread::TreadSurface;
use crate::counters::{Meter, Stage};
use crate::plan::Plan;
use crate::scene::{Friction, LongitudinalCreep};
use crate::tyre::influence::CellSums;

/// Makes the march of cells with friction, over a window that is longer by `margin` columns at either end than what is
/// told.
///
/// # Errors
/// A rule without a first rate.
pub(super) fn friction_march(
    plan: &Plan,
    sums: &CellSums,
    tread: &TreadSurface,
    at_rest: StaticContact,
    (told, margin): (Geometry, usize),
    friction: &Friction,
    meter: &mut Meter,
) -> Result<March, ContactError> {
    let Plan { scene, time_step, .. } = plan;
    let (grid, rule) = (sums.grid(), scene.numerics.time_rule);
    let rate = rule.first_rate(*time_step).ok_or(ContactError::NoSuchField)?;
    let revolution = scene.numerics.elements * scene.numerics.substeps;
    let (given, free) = match friction.creep.longitudinal {
        LongitudinalCreep::Given(creep) => (creep, None),
        LongitudinalCreep::Free => (0.0, Some(FreeCreep::new(at_rest, plan.radius, revolution, plan.warm_up_steps))),
    };
    let rolling = Rolling {
        geometry: told.clone(),
        margin,
        lateral: (0..grid.across).map(|j| grid.from_middle(j)).collect(),
        tread: tread.clone(),
        face: grid.length() * grid.pitch(),
        speed: plan.speed,
        longitudinal: free.as_ref().map_or(given, FreeCreep::creep),
        free,
        creep: friction.creep.clone(),
        rule,
        time_step: *time_step,
    };
    let window = told.columns + 2 * margin;
    let columns = window + rolling.ahead(window);
    let influence = meter.time(Stage::Influence, || sums.traction_instant(rate, columns));
    let rows = sums.traction_rows();
    let transform = TractionTransform::new(grid, columns, &rows);
    let past = meter.time(Stage::Influence, || TractionPast::new(sums, &rows, transform, rule, *time_step, plan.lags));
    let law = CellLaw::new(friction.coefficient(), scene.adhesion.clone(), *time_step, grid.elements() * grid.across);
    let search = FrictionSearch::new(influence, plan.friction_tolerance());
    Ok(March::with_friction(told, FrictionZone::new(rolling, past, search, law), rule, *time_step))
}
