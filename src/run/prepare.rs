//! From a planned scene to a contact that is ready for its first step.
//!
//! 1. static influence functions and static contact on a smooth road: axle height, size of the window;
//! 2. the road is opened and must be long enough: everything that can be refused is refused before the long work;
//! 3. convolution weights and the contact's kernels.

use std::sync::atomic::AtomicBool;

use crate::contact::axle::{AxleHeight, LARGEST_RATE, LoadControl, MovingAxle, SprungMass};
use crate::contact::complementarity::SliceLaw;
use crate::contact::geometry::Geometry;
use crate::contact::kernel::{ContactKernel, EqualBedding, equal_bedding};
use crate::contact::local_compliance::local_compliance;
use crate::contact::march::March;
use crate::contact::static_contact::{StaticContact, StaticTyre, deepest, window_reach};
use crate::counters::{Meter, Stage};
use crate::effects::{ContactFacts, TyreModels};
use crate::plan::{Decisions, Plan};
use crate::road::ahead::RoadAhead;
use crate::road::maker::SliceForm;
use crate::road::slices::{CELL_LENGTH, SliceBuilder, SliceError};
use crate::road::strip::RoadStrip;
use crate::road::{Lattice, Limits, RoadError, RoadSurface};
use crate::run::cells::CellContact;
use crate::run::error::RunError;
use crate::run::past::Past;
use crate::scene::{Axle, History, LoadedScene, Scene, SceneError, SliceCoupling, Slices, Zone};
use crate::tyre::influence::{Field, InfluenceSum};

/// Run about to begin.
pub struct Prepared {
    /// The contact at rest.
    pub march: March,
    /// The road.
    pub road: RoadAhead,
    /// The axle.
    pub axle: AxleHeight,
    /// Facts of the contact that effects begin with.
    pub contact: ContactFacts,
    /// Models of the tyre that effects may take.
    pub models: TyreModels,
    /// kappa of the local law \[m/Pa\], where slices yield by it.
    pub local_compliance: Option<f64>,
    /// Choices of the plan, and effects that it leaves out.
    pub notes: Vec<String>,
    /// Warnings that the user should act on.
    pub warnings: Vec<String>,
}

/// Prepares a run. `stop` ends the work on the influence functions once it is set.
///
/// # Errors
/// [`RunError`].
pub fn prepare(loaded: &LoadedScene, plan: &Plan, stop: &AtomicBool, meter: &mut Meter) -> Result<Prepared, RunError> {
    let Plan { scene, field, radius, .. } = plan;
    let (field, radius) = (*field, *radius);
    let numerics = &scene.numerics;
    let Decisions { tyre, slices, .. } = &plan.decisions;
    let mut warnings = meter.time(Stage::Influence, || plan.warnings());
    let mut zone = match plan.decisions.zone {
        Zone::Slices => {
            let largest = numerics.time_rule.resolved_symbol() / plan.time_step;
            let sum = meter.time(Stage::Influence, || InfluenceSum::new(tyre, numerics, largest));
            ZoneSums::Slices(Box::new(sum))
        }
        Zone::Cells => ZoneSums::Cells(Box::new(meter.time(Stage::Influence, || CellContact::new(loaded, plan, stop)))),
    };
    let (at_rest, bedding) = meter.time(Stage::Axle, || match &mut zone {
        ZoneSums::Slices(sum) => static_contact(scene, sum, field),
        ZoneSums::Cells(cells) => Ok((cells.at_rest()?, EqualBedding::NONE)),
    })?;

    // What the tyre can meet of the plane z = 0; higher texture past the end is not known and counts as no road.
    let chord = Geometry::half_chord(radius, deepest(&scene.rolling.axle, at_rest.indentation));
    let (surface, start) = meter.time(Stage::Road, || open_road(loaded, plan, chord))?;
    let lattice = surface.lattice();
    warnings.extend(surface.report().notes.iter().filter(|note| note.is_warning()).map(ToString::to_string));
    // A smooth road has no texture to be resolved, and without a slice law nobody asked for it.
    if plan.decisions.zone == Zone::Slices && lattice.cells() == 1 && !surface.is_smooth() && *slices != Slices::None {
        warnings.push("an element is a single cell of the road: the slice law makes no difference".into());
    }

    let chord = window_reach(&scene.rolling.axle, at_rest.indentation, surface.highest(), radius, plan.element);
    let excited = surface.report().highest_frequency(plan.speed);
    let valid_to = excited.map_or(plan.valid_to, |excited| plan.valid_to.min(excited));
    if let Some(highest) = excited {
        let nyquist = 0.5 / plan.time_step;
        let wanted = numerics.fmax.unwrap_or(0.0);
        if highest < wanted.max(0.5 * nyquist.min(0.5 * plan.speed / plan.element)) {
            let missed = numerics.fmax.filter(|fmax| highest < *fmax);
            let missed = missed.map_or(String::new(), |fmax| format!(": numerics.fmax = {fmax} Hz is not reached"));
            warnings.push(format!(
                "the road's resolution excites nothing above {highest:.0} Hz at {:.0} km/h{missed}",
                scene.rolling.speed_kmh
            ));
        }
    }
    let geometry = Geometry::new(tyre.circumference, numerics.elements, numerics.substeps, start, plan.reach * chord);
    let elements = surface
        .extent()
        .map(|(from, to)| ((from / plan.element - 1e-6).ceil() as i64, (to / plan.element + 1e-6).floor() as i64));
    let margin = plan.window_margin(geometry.columns);
    let window = geometry.wider(margin);
    let first = window.first_element(0);
    let queue = RoadStrip::starting_at(elements.map_or(first, |(lowest, _)| first.max(lowest)));
    let columns = window.columns;
    let reached = window.first_element(plan.steps.saturating_sub(1)) + columns as i64;
    let (mut moving, mut carried) = (None, None);
    let (march, form, kappa, model) = match &zone {
        ZoneSums::Cells(cells) => {
            let instant = cells.instant(columns, meter)?;
            let followed = plan.decisions.vibration.is_some();
            let waves = match numerics.history {
                History::Direct if !followed => Vec::new(),
                _ => cells.carried(columns, meter, &mut warnings)?,
            };
            let zone = cells.zone(instant.clone(), &waves, margin, meter);
            if followed {
                let beyond = meter.time(Stage::Influence, || cells.beyond(instant, &waves))?;
                carried = Some((waves, beyond));
            }
            (March::with_cells(geometry, zone, numerics.time_rule, plan.time_step), SliceForm::Cells, None, None)
        }
        ZoneSums::Slices(sum) => {
            let builder = slice_builder(*slices, lattice)?.with_tolerance(scene.contact.slice_tolerance)?;
            let kappa = match plan.decisions.slice_coupling {
                SliceCoupling::Local => scene.contact.local_compliance.or_else(|| local_compliance(tyre, &surface)),
                SliceCoupling::Explicit | SliceCoupling::Implicit => None,
            };
            let past = Past { loaded, plan, sum, columns, bedding, stop };
            let (mut kernel, history, model) = match numerics.history {
                History::Direct => past.direct(meter, &mut warnings)?,
                History::Modal => past.modal(meter, &mut warnings)?,
            };
            if scene.contact.equal_stiffness {
                kernel.spring = meter.time(Stage::Axle, || {
                    kernel.uncoupled_spring(&sum.static_row(field), tyre.circumference, at_rest)
                })?;
            }
            if let Axle::Mass { load, mass, stiffness, damping, .. } = scene.rolling.axle {
                let sprung = SprungMass { load, mass, stiffness, damping };
                moving = Some(moving_axle(loaded, plan, sprung, &kernel, at_rest)?);
            }
            let law = slice_law(plan, kappa);
            let march = March::new(geometry, kernel, law, history, numerics, plan.time_step);
            (march, SliceForm::Curves(builder), kappa, model)
        }
    };
    let road = RoadAhead::new(surface, form, queue, elements, reached);
    let axle = match scene.rolling.axle {
        Axle::Indentation { indentation, .. } => AxleHeight::Fixed { indentation, ramp: plan.ramp_steps() },
        Axle::Load { load, .. } => AxleHeight::Loaded(LoadControl::new(load, at_rest, plan.warm_up_steps)),
        Axle::Mass { .. } => match moving {
            Some(moving) => AxleHeight::Moving(Box::new(moving)),
            None => {
                let problem =
                    loaded.complain("rolling.axle.mass", "no mass moves on cells yet", "an axle without a mass");
                return Err(SceneError::from(problem).into());
            }
        },
    };
    Ok(Prepared {
        contact: ContactFacts {
            geometry: march.geometry().clone(),
            shape: march.footprint().shape(),
            at_rest,
            scale: bedding.scale,
            spring: march.spring(),
            valid_to,
        },
        models: TyreModels { poles: model.filter(|_| plan.decisions.vibration.is_some()), waves: carried },
        march,
        road,
        axle,
        local_compliance: kappa,
        notes: plan.notes().collect(),
        warnings,
    })
}

/// Opens the road of a planned run, and makes sure that it reaches `chord` \[m\] beyond where the axle goes; with it
/// where the axle starts.
///
/// # Errors
/// [`RunError`] with the key that is to blame.
pub fn open_road(loaded: &LoadedScene, plan: &Plan, chord: f64) -> Result<(RoadSurface, f64), RunError> {
    let scene = &plan.scene;
    let open = || -> Result<_, RoadError> {
        let surface = RoadSurface::open(&scene.road, plan.lattice()?, road_limits(scene))?;
        let start = match (scene.rolling.start, surface.extent()) {
            (Some(start), _) => start,
            (None, None) => 0.0,
            (None, Some((from, _))) => from + (chord / plan.element).ceil() * plan.element,
        };
        let travel = plan.speed * plan.time_step * plan.steps as f64;
        surface.check_covers(start - chord, start + travel + chord)?;
        Ok((surface, start))
    };
    open().map_err(|error| in_scene(loaded, error))
}

/// The plan of a scene that can be run; its road is opened, nothing is simulated.
///
/// # Errors
/// Whatever can be known to be wrong without running.
pub fn checked(loaded: &LoadedScene) -> Result<Plan, RunError> {
    loaded.check_time_domain()?;
    let plan = Plan::of(loaded)?.with_kept_model();
    plan.check(loaded)?;
    open_road(loaded, &plan, 0.5 * plan.amounts().expected.points * plan.element)?;
    Ok(plan)
}

/// Returns the limits of opening a scene's road.
pub fn road_limits(scene: &Scene) -> Limits {
    Limits { bytes: scene.numerics.memory_bytes() }
}

/// Ingredients of the contact's sums.
enum ZoneSums<'a> {
    Slices(Box<InfluenceSum>),
    Cells(Box<CellContact<'a>>),
}

/// By how much slices yield, given the compliance of the local law \[m/Pa\].
fn slice_law(plan: &Plan, kappa: Option<f64>) -> SliceLaw {
    match (plan.decisions.slice_coupling, kappa) {
        (SliceCoupling::Local, Some(kappa)) => SliceLaw::Local(kappa / (plan.element * plan.scene.tyre.contact_width)),
        // Without texture every slice is level, the same by every law, and the factors of the explicit form can be
        // kept.
        (SliceCoupling::Local, None) | (SliceCoupling::Explicit, _) => SliceLaw::Explicit,
        (SliceCoupling::Implicit, _) => SliceLaw::Implicit,
    }
}

/// The maker of a law's stiffness curves on a lattice.
///
/// # Errors
/// As [`SliceBuilder`]'s constructors.
pub fn slice_builder(law: Slices, lattice: Lattice) -> Result<SliceBuilder, SliceError> {
    match law {
        // A single cell presses flat, by every law.
        _ if lattice.cells() == 1 => SliceBuilder::flat(1),
        Slices::None => SliceBuilder::flat(lattice.columns),
        Slices::Winkler => SliceBuilder::winkler(lattice.columns),
        Slices::HalfSpace => SliceBuilder::half_space(lattice.columns, CELL_LENGTH, lattice.dy),
    }?
    .with_lines(lattice.along)
}

/// Static contact under the scene's axle, and what a bedding makes of the influence functions: nothing for the other
/// laws.
fn static_contact(scene: &Scene, sum: &InfluenceSum, field: Field) -> Result<(StaticContact, EqualBedding), RunError> {
    let circumference = scene.tyre.circumference;
    let row = sum.static_row(Field::Surface);
    let elastic = StaticTyre { influence: &row, circumference };
    let on = |tyre: &StaticTyre<'_>| tyre.under(&scene.rolling.axle);
    if field != Field::UnderTread {
        return Ok((on(&elastic)?, EqualBedding::NONE));
    }
    let mut carcass = sum.static_row(field);
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

/// A mass on the axle, refused where the time step is too long for it.
fn moving_axle(
    loaded: &LoadedScene,
    plan: &Plan,
    sprung: SprungMass,
    kernel: &ContactKernel,
    at_rest: StaticContact,
) -> Result<MovingAxle, RunError> {
    let (tyre, rule) = (&plan.scene.tyre, plan.scene.numerics.time_rule);
    // What the contact is within a step: the points at rest by the first weights.
    let influence = kernel.within_a_step();
    let within_a_step = StaticTyre { influence: &influence, circumference: tyre.circumference };
    let stiffness = within_a_step.at(at_rest.indentation)?.stiffness;
    let rate = sprung.rate(stiffness, plan.time_step);
    if rate > LARGEST_RATE {
        let wrong = format!(
            "{} kg follow the force too fast for a step of {:.2e} s: w dt = {rate:.2} with the {stiffness:.2e} N/m \
             of the contact within a step, {LARGEST_RATE} can be stepped",
            sprung.mass, plan.time_step
        );
        let least = sprung.least_mass(stiffness, plan.time_step);
        let right = format!("at least {least:.3} kg, more substeps, or an axle without a mass");
        return Err(SceneError::from(loaded.complain("rolling.axle.mass", wrong, right)).into());
    }
    let rest = StaticContact { stiffness: sprung.rest_stiffness(at_rest.stiffness), ..at_rest };
    let control = LoadControl::new(sprung.load, rest, plan.warm_up_steps);
    Ok(MovingAxle::new(sprung, control, plan.time_step, rule.force_lead()))
}

/// A road's complaint, placed in the scene at the key that it is about.
pub fn in_scene(loaded: &LoadedScene, error: RoadError) -> RunError {
    let (key, right) = match &error {
        error if error.is_of_another_kind() => {
            ("road.kind", "the kind that the file is of, with its keys; or another file")
        }
        RoadError::Short { .. } => ("rolling.duration", "a road that is long enough, a shorter run, or another at_end"),
        RoadError::NotPositive { key, .. } => (*key, "a positive number"),
        RoadError::Range { .. } => ("road.range", "a part of what the file covers"),
        RoadError::LateralPosition { .. } => ("road.lateral_position", "a strip inside the measured columns"),
        RoadError::NotThirdOctave { .. } | RoadError::BandTwice { .. } | RoadError::LevelCount { .. } => {
            ("road.wavelengths", "each third-octave mid-wavelength once, with its level")
        }
        RoadError::Level { .. } => ("road.levels", "a level in dB re 1e-6 m"),
        RoadError::Spacing { .. } | RoadError::TextureTooLarge { .. } => {
            ("road.spacing", "a spacing that suits the wavelengths")
        }
        RoadError::Trend { .. } => ("road.longest_wavelength", "a shorter wavelength, or none"),
        RoadError::TooManyHeights { .. } => ("road", "a coarser spacing, fewer cells, or a larger memory_limit"),
        RoadError::Moments { .. } => ("road.kurtosis", "a kurtosis in that range, or less skewness"),
        RoadError::PowerLaw { .. } | RoadError::TwoSpectra => ("road.power_law", "one valid spectrum"),
        RoadError::MissingUnit { key, .. } => (*key, "\"m\", \"mm\" or \"um\""),
        RoadError::Narrow { .. } => ("road.file", "a road at least as wide as tyre.contact_width"),
        _ => ("road.file", "a complete file of the kind that road.kind names"),
    };
    let key = if key.contains('.') { key.to_owned() } else { format!("road.{key}") };
    SceneError::from(loaded.complain(&key, error.to_string(), right)).into()
}
