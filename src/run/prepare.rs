//! From a planned scene to a contact that is ready for its first step.
//!
//! 1. static influence functions and static contact on a smooth road: axle height, size of the window;
//! 2. the road is opened and must be long enough: everything that can be refused is refused before the long work;
//! 3. convolution weights and the contact's kernels.

use crate::contact::axle::{AxleHeight, LoadControl};
use crate::contact::cells::gaps::GapMap;
use crate::contact::geometry::Geometry;
use crate::contact::march::March;
use crate::contact::static_contact::{deepest, window_reach};
use crate::counters::{Job, Stage};
use crate::effects::{ContactFacts, RunError, RunStart, TyreModels};
use crate::plan::Plan;
use crate::road::ahead::RoadAhead;
use crate::road::strip::RoadStrip;
use crate::road::{RoadProfiles, RoadSurface};
use crate::run::cells::CellContact;
use crate::run::road::{open_road, road_limits};
use crate::run::slices::{SliceContact, check_axle};
use crate::run::zone_maker::{Made, Standing, Window, ZoneMaker};
use crate::scene::{Axle, LoadedScene, Zone};

/// A run about to begin.
pub struct Prepared {
    /// Contact, history and search, initially at rest.
    pub march: March,
    /// The road, whose slices are made ahead of the tyre.
    pub road: RoadAhead,
    /// Height of the axle over the steps.
    pub axle: AxleHeight,
    /// Facts of the contact that effects start from.
    pub contact: ContactFacts,
    /// Models of the tyre that effects may use.
    pub models: TyreModels,
    /// Profiles of the road, where sections need them.
    pub(crate) profiles: Option<RoadProfiles>,
    /// kappa of the local law \[m/Pa\], if slices follow it.
    pub local_compliance: Option<f64>,
    /// Notes: choices of the plan, and effects that it leaves out.
    pub notes: Vec<String>,
}

impl Prepared {
    /// Arguments for the begin of its effects' observers; `in_memory` is true for a run whose results stay in memory.
    pub fn begin<'a>(&'a mut self, loaded: &'a LoadedScene, plan: &'a Plan, in_memory: bool) -> RunStart<'a> {
        let Self { contact, models, profiles, .. } = self;
        RunStart { loaded, plan, contact, models, profiles, in_memory, amounts: Plan::amounts }
    }
}

/// Prepares a run.
///
/// # Errors
/// [`RunError`].
pub fn prepare(loaded: &LoadedScene, plan: &Plan, job: &mut Job<'_>) -> Result<Prepared, RunError> {
    let Plan { scene, radius, .. } = plan;
    // 1. Static influence functions and static contact.
    job.warnings.extend(job.meter.time(Stage::Influence, || plan.warnings()));
    let mut zone = job.meter.time(Stage::Influence, || -> Box<dyn ZoneMaker + '_> {
        match plan.decisions.zone {
            Zone::Slices => Box::new(SliceContact::new(loaded, plan)),
            Zone::Cells => Box::new(CellContact::new(loaded, plan)),
        }
    });
    let (at_rest, scale) = job.meter.time(Stage::Axle, || zone.at_rest())?;

    // 2. The road must reach half of the chord in which the tyre can meet the plane z = 0; texture past the end that is
    //    higher is unknown and counts as no road.
    let chord = Geometry::half_chord(*radius, deepest(&plan.decisions.axle, at_rest.indentation));
    let (mut surface, start) = job.meter.time(Stage::Road, || open_road(loaded, plan, chord))?;
    job.warnings.extend(road_warnings(&surface, plan));
    job.warnings.extend(zone.law_warning(&surface));
    let excited = surface.report().highest_frequency(plan.speed);
    let slice_errors = plan.slice_errors_on(&surface);
    let mut notes: Vec<String> = plan.notes().collect();
    if let Some(errors) = &slice_errors {
        let (message, missed) = plan.end_of_slices(errors);
        if missed { &mut job.warnings } else { &mut notes }.push(message);
    }

    // 3. The window, the voids' air, and the kernels of the contact.
    let reach = window_reach(&plan.decisions.axle, at_rest.indentation, surface.highest(), *radius, plan.element);
    let (numerics, around) = (&scene.numerics, plan.decisions.tyre.circumference);
    let output_window = Geometry::new(around, numerics.elements, numerics.advance(), start, plan.reach * reach);
    let margin = plan.window_margin(output_window.columns);
    let search_window = output_window.wider(margin);
    let (first, columns) = (search_window.first_element(0), search_window.columns);
    let elements = surface
        .extent()
        .map(|(from, to)| ((from / plan.element - 1e-6).ceil() as i64, (to / plan.element + 1e-6).floor() as i64));
    let strip = RoadStrip::starting_at(elements.map_or(first, |(lowest, _)| first.max(lowest)));
    let reached = search_window.first_element(plan.steps.saturating_sub(1)) + columns as i64;

    let standing = Standing { surface: &mut surface, elements, start, at_rest, reach };
    let gaps = job.meter.time(Stage::Axle, || zone.gaps(standing))?;
    notes.extend(closed(&gaps, 0.5 * at_rest.length));
    let window = Window { output_window, margin, columns, surface: &surface, at_rest };
    let Made { march, form, moving, local_compliance, models } = zone.make(window, job)?;
    let axle = match plan.decisions.axle {
        Axle::Indentation { indentation, .. } => AxleHeight::Fixed { indentation, ramp: plan.ramp_steps() },
        Axle::Load { load, .. } | Axle::Mass { load, .. } => {
            let control = || LoadControl::new(load, at_rest, plan.warm_up_steps);
            moving.map_or_else(|| AxleHeight::Loaded(control()), |moving| AxleHeight::Moving(Box::new(moving)))
        }
    };
    let shape = march.footprint().shape();
    let contact = ContactFacts {
        geometry: march.geometry().clone(),
        shape,
        point_size: [plan.element, scene.tyre.contact_width / shape.across as f64],
        at_rest,
        scale,
        spring: march.spring(),
        valid_to: excited.map_or(plan.valid_to, |excited| plan.valid_to.min(excited)),
        slice_errors,
        gaps,
    };
    let profiles = scene.outputs.sections.map(|_| RoadProfiles::of(&surface, road_limits(scene)));
    let profiles = profiles.transpose()?.flatten();
    let road = RoadAhead::new(surface, form, strip, elements, reached);
    Ok(Prepared { march, road, axle, contact, models, profiles, local_compliance, notes })
}

/// Note on the closed share of the patch at the places where the voids are measured; `None` without any.
fn closed(gaps: &[GapMap], half_length: f64) -> Option<String> {
    let parts = || gaps.iter().map(|gap| 100.0 * gap.closed(half_length));
    let [least, most] = [parts().reduce(f64::min)?, parts().reduce(f64::max)?];
    let (places, length) = (gaps.len(), 2e3 * half_length);
    Some(format!(
        "{least:.0} to {most:.0} % of a patch of {length:.0} mm are closed at the {places} places whose voids are open"
    ))
}

/// Warnings about an opened road, before anything rolls on it.
fn road_warnings(surface: &RoadSurface, plan: &Plan) -> Vec<String> {
    let report = surface.report();
    let mut warnings: Vec<String> =
        report.notes.iter().filter(|note| note.is_warning()).map(ToString::to_string).collect();
    warnings.extend(report.highest_frequency(plan.speed).and_then(|highest| unexcited(plan, highest)));
    warnings
}

/// Warning that a road excites nothing above `highest` \[Hz\], if that is too low.
fn unexcited(plan: &Plan, highest: f64) -> Option<String> {
    let Plan { scene, time_step, speed, element, .. } = plan;
    let (nyquist, wanted) = (0.5 / time_step, scene.numerics.fmax);
    if highest >= wanted.unwrap_or(0.0).max(0.5 * nyquist.min(0.5 * speed / element)) {
        return None;
    }
    let missed = scene.numerics.missed(highest).unwrap_or_default();
    let speed = scene.rolling.speed_kmh;
    Some(format!("the road's resolution gives no excitation above {highest:.0} Hz at {speed:.0} km/h{missed}"))
}

/// Plan of a scene that can be run; its road is opened, nothing is simulated.
///
/// # Errors
/// Every error that can be detected without running.
pub fn checked(loaded: &LoadedScene) -> Result<Plan, RunError> {
    loaded.check_time_domain()?;
    let mut plan = Plan::of(loaded)?.with_cached_model();
    plan.check(loaded)?;
    check_axle(loaded, &plan)?;
    let (surface, _) = open_road(loaded, &plan, 0.5 * plan.expected().points * plan.element)?;
    plan.road_warnings = road_warnings(&surface, &plan);
    if let Some(errors) = plan.slice_errors_on(&surface) {
        plan.decisions.notes.push(plan.end_of_slices(&errors).0);
        plan.slice_errors = Some(errors);
    }
    Ok(plan)
}
