//! Contact over slices, made for a planned scene.

use crate::contact::axle::{LARGEST_RATE, LoadControl, MovingAxle, SprungMass};
use crate::contact::complementarity::SliceLaw;
use crate::contact::kernel::{ContactKernel, EqualBedding, equal_bedding};
use crate::contact::local_compliance::local_compliance;
use crate::contact::march::March;
use crate::contact::pressed::PressedRoad;
use crate::contact::static_contact::{StaticContact, StaticTyre};
use crate::counters::{Job, Stage};
use crate::effects::{RunError, TyreModels};
use crate::plan::Plan;
use crate::road::maker::SliceForm;
use crate::road::slices::{CELL_LENGTH, SliceBuilder, SliceError};
use crate::road::{Lattice, RoadSurface};
use crate::run::history::HistoryBuilder;
use crate::run::zone_maker::{Made, Window, ZoneMaker};
use crate::scene::{History, LoadedScene, SceneError, SliceCoupling, Slices, Tread, Zone};
use crate::tyre::influence::{Field, InfluenceSum};

pub(super) struct SliceContact<'a> {
    loaded: &'a LoadedScene,
    plan: &'a Plan,
    sum: InfluenceSum,
    bedding: EqualBedding,
}

impl<'a> SliceContact<'a> {
    /// Contact of a planned scene.
    pub(super) fn new(loaded: &'a LoadedScene, plan: &'a Plan) -> Self {
        let numerics = &plan.scene.numerics;
        let largest = numerics.time_rule.resolved_symbol() / plan.time_step;
        let sum = InfluenceSum::new(&plan.decisions.tyre, numerics, largest);
        Self { loaded, plan, sum, bedding: EqualBedding::NONE }
    }
}

impl ZoneMaker for SliceContact<'_> {
    fn at_rest(&mut self) -> Result<(StaticContact, f64), RunError> {
        let (at_rest, bedding) = static_contact(self.plan, &self.sum)?;
        self.bedding = bedding;
        Ok((at_rest, bedding.scale))
    }

    fn law_warning(&self, surface: &RoadSurface) -> Option<String> {
        let asked = self.plan.decisions.slices.is_some();
        // A smooth road has no texture to resolve, and without a slice law none is asked for.
        let single = surface.lattice().cells() == 1 && !surface.is_smooth() && asked;
        single.then(|| "an element is a single cell of the road: the slice law makes no difference".into())
    }

    fn make(&self, window: Window<'_>, job: &mut Job<'_>) -> Result<Made, RunError> {
        let Self { loaded, plan, sum, bedding } = self;
        let Plan { scene, field, .. } = plan;
        let Window { output_window, columns, surface, at_rest, .. } = window;
        let (numerics, tyre) = (&scene.numerics, &plan.decisions.tyre);
        let pressed = pressed_road(plan, surface.lattice());
        let spring = pressed.as_ref().map(PressedRoad::spring);
        let form = match pressed {
            Some(pressed) => SliceForm::Strips(Box::new(pressed)),
            None => {
                let builder = slice_builder(plan.decisions.slices, surface.lattice())?;
                let builder = builder.with_tolerance(scene.contact.slice_tolerance)?;
                match plan.tread() {
                    Some((map, _)) => SliceForm::Voids(builder, map.depths),
                    None => SliceForm::Curves(builder),
                }
            }
        };
        let local_compliance = match plan.decisions.slice_coupling {
            SliceCoupling::Local if spring.is_some() => None,
            SliceCoupling::Local => scene.contact.local_compliance.or_else(|| local_compliance(tyre, surface)),
            SliceCoupling::Explicit => None,
        };
        let builder = HistoryBuilder { loaded, plan, sum, columns, bedding: *bedding };
        let (mut kernel, history, model) = match numerics.history {
            History::Direct => builder.direct(job)?,
            History::Modal => builder.modal(job)?,
        };
        if scene.contact.equal_stiffness {
            kernel.spring = job
                .meter
                .time(Stage::Axle, || kernel.uncoupled_spring(&sum.static_row(*field), tyre.circumference, at_rest))?;
        }
        let moving = SprungMass::of(&scene.rolling.axle)
            .map(|sprung| moving_axle(loaded, plan, sprung, &kernel, at_rest))
            .transpose()?;
        let law = spring.map_or_else(|| slice_law(plan, local_compliance), SliceLaw::Local);
        Ok(Made {
            march: March::new(output_window, kernel, law, history, numerics, plan.time_step),
            form,
            moving,
            local_compliance,
            models: TyreModels { poles: model.filter(|_| plan.decisions.takes_models), waves: None },
        })
    }
}

/// Curves of a pressed road, if the plan's slices have these; a single cell presses flat by every law.
fn pressed_road(plan: &Plan, lattice: Lattice) -> Option<PressedRoad> {
    if plan.decisions.slices != Some(Slices::Pressed) || lattice.cells() == 1 {
        return None;
    }
    let crown = (0..lattice.columns).map(|column| plan.crown(lattice.y(column))).collect();
    PressedRoad::new(&plan.decisions.tyre, lattice, crown)
}

/// Law by which slices yield, given the compliance of the local law \[m/Pa\].
fn slice_law(plan: &Plan, kappa: Option<f64>) -> SliceLaw {
    match (plan.decisions.slice_coupling, kappa) {
        (SliceCoupling::Local, Some(kappa)) => SliceLaw::Local(kappa / (plan.element * plan.scene.tyre.contact_width)),
        // Without texture every slice is level and the same by every law, and the explicit form can keep its factors.
        (SliceCoupling::Local, None) | (SliceCoupling::Explicit, _) => SliceLaw::Explicit,
    }
}

/// Builder of a law's stiffness curves on a lattice, of flat ones without a law.
///
/// # Errors
/// As [`SliceBuilder`]'s constructors; [`SliceError::Together`] for the law of a pressed road.
pub(crate) fn slice_builder(law: Option<Slices>, lattice: Lattice) -> Result<SliceBuilder, SliceError> {
    match law {
        // A single cell presses flat by every law.
        _ if lattice.cells() == 1 => SliceBuilder::flat(1),
        None => SliceBuilder::flat(lattice.columns),
        Some(Slices::Winkler) => SliceBuilder::winkler(lattice.columns),
        Some(Slices::HalfSpace) => SliceBuilder::half_space(lattice.columns, CELL_LENGTH, lattice.dy),
        Some(Slices::Pressed) => return Err(SliceError::Together),
    }?
    .with_lines(lattice.along)
}

/// Static contact under the axle, and the change of the influence functions by a bedding; none for the other laws.
fn static_contact(plan: &Plan, sum: &InfluenceSum) -> Result<(StaticContact, EqualBedding), RunError> {
    let Plan { scene, field, .. } = plan;
    let circumference = scene.tyre.circumference;
    let row = sum.static_row(Field::Surface);
    let elastic = StaticTyre { influence: &row, circumference };
    let on = |tyre: &StaticTyre<'_>| tyre.under(&plan.decisions.axle);
    if *field != Field::UnderTread {
        return Ok((on(&elastic)?, EqualBedding::NONE));
    }
    let mut carcass = sum.static_row(*field);
    let bedding = match scene.contact.bedding_stiffness {
        Some(stiffness) => {
            let spring = 1.0 / (stiffness * sum.projection().element * scene.tyre.contact_width);
            EqualBedding { scale: 1.0, spring }
        }
        None => equal_bedding(&carcass, &row, circumference, on(&elastic)?)?,
    };
    carcass.iter_mut().for_each(|influence| *influence *= bedding.scale);
    carcass[0] += bedding.spring;
    Ok((on(&StaticTyre { influence: &carcass, circumference })?, bedding))
}

/// Refuses what a run over slices would refuse before its first step: a bedding that no scale makes as stiff as the
/// elastic tread, and a mass for which the time step is too long. The influence within a step is that of the sums, for
/// which a run has a model.
///
/// # Errors
/// As [`ZoneMaker::at_rest`], and [`SceneError::Invalid`] at the mass.
pub(crate) fn check_axle(loaded: &LoadedScene, plan: &Plan) -> Result<(), RunError> {
    let Plan { scene, field, time_step, .. } = plan;
    let sprung = SprungMass::of(&scene.rolling.axle);
    if plan.decisions.zone != Zone::Slices || sprung.is_none() && *field != Field::UnderTread {
        return Ok(());
    }
    let SliceContact { sum, .. } = SliceContact::new(loaded, plan);
    let (at_rest, EqualBedding { scale, spring }) = static_contact(plan, &sum)?;
    // Uncoupled points of an equal stiffness have a spring in series, which is found later.
    let is_known = !scene.contact.equal_stiffness;
    let Some(sprung) = sprung.filter(|_| is_known) else { return Ok(()) };
    let mut row = sum.row_at(scene.numerics.time_rule.first_rate(*time_step), *field);
    row.iter_mut().for_each(|influence| *influence *= scale);
    row[0] += spring;
    if plan.decisions.tread == Tread::Uncoupled {
        row[1..].fill(0.0);
    }
    check_mass(loaded, plan, sprung, &row, at_rest)
}

/// Refuses a mass on the axle for which the time step is too long; `influence` is that within a step \[m/N\].
fn check_mass(
    loaded: &LoadedScene,
    plan: &Plan,
    sprung: SprungMass,
    influence: &[f64],
    at_rest: StaticContact,
) -> Result<(), RunError> {
    let within_a_step = StaticTyre { influence, circumference: plan.scene.tyre.circumference };
    let stiffness = within_a_step.at(at_rest.indentation)?.stiffness;
    let rate = sprung.rate(stiffness, plan.time_step);
    if rate <= LARGEST_RATE {
        return Ok(());
    }
    let wrong = format!(
        "{} kg follow the force too fast for a step of {:.2e} s: w dt = {rate:.2} with the {stiffness:.2e} N/m of the \
         contact within a step, {LARGEST_RATE} can be stepped",
        sprung.mass, plan.time_step
    );
    let least = sprung.least_mass(stiffness, plan.time_step);
    let right = format!("at least {least:.3} kg, more substeps, or an axle without a mass");
    Err(SceneError::from(loaded.complain("rolling.axle.mass", wrong, right)).into())
}

/// A mass on the axle; refused if the time step is too long for it.
fn moving_axle(
    loaded: &LoadedScene,
    plan: &Plan,
    sprung: SprungMass,
    kernel: &ContactKernel,
    at_rest: StaticContact,
) -> Result<MovingAxle, RunError> {
    // The contact within a step is that of the points at rest with the first weights.
    check_mass(loaded, plan, sprung, &kernel.within_a_step(), at_rest)?;
    let rule = plan.scene.numerics.time_rule;
    let rest = StaticContact { stiffness: sprung.rest_stiffness(at_rest.stiffness), ..at_rest };
    let control = LoadControl::new(sprung.load, rest, plan.warm_up_steps);
    Ok(MovingAxle::new(sprung, control, plan.time_step, rule.force_lead()))
}
