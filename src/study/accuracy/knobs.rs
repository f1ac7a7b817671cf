//! The knobs of a scene: what is swept, and what it cannot have.

use serde::Serialize;

use crate::contact::local_compliance::{DOUBTS, formula_for};
use crate::plan::decisions::square_cells;
use crate::plan::front::cell_for;
use crate::road::Lattice;
use crate::scene::{History, Numerics, Scene, SliceCoupling, Slices, Switch, TimeRule, Tread, Zone};
use crate::study::accuracy::lab::Point;
use crate::study::accuracy::options::{StudyOptions, Sweep};
use crate::study::accuracy::settings::Settings;
use crate::study::trial::least_rate;

/// Kind of change that a knob makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// How finely the same model is solved.
    Error,
    /// Which model is solved.
    Model,
    /// Several settings, each close to one that has a name.
    Neighbour,
}

/// A knob, and the settings it is swept through.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Knob {
    /// Name in tables.
    pub name: String,
    /// Kind of the change.
    pub kind: Kind,
    /// Reference of its runs, where that is not the reference of all.
    pub anchor: Option<Settings>,
    /// Label of each setting, and all settings.
    #[serde(skip)]
    pub steps: Vec<(String, Settings)>,
    /// The settings that were rolled.
    pub points: Vec<Point>,
    /// Why the scene cannot have the knob, or some of its points.
    pub missing: Option<String>,
}

/// Fractions of the reference's elements that are swept.
const ELEMENT_PARTS: [(usize, usize); 4] = [(1, 4), (3, 8), (1, 2), (3, 4)];
/// Steps per element that are swept, with the scene's rule and with the others.
const SUBSTEPS: [usize; 5] = [1, 2, 3, 4, 6];
const OTHER_SUBSTEPS: [usize; 3] = [1, 2, 4];
const POLES: [f64; 3] = [1e-3, 1e-4, 1e-5];
/// Tolerance of the reference's poles.
const FINEST_POLES: f64 = 5e-6;
/// The same for contact over cells, which has poles for each pair of wavenumbers; the reference's contact tolerance,
/// unless the scene's is finer; and fractions of its cells across.
const FINEST_POLES_OF_CELLS: f64 = 1e-5;
const FINEST_TOLERANCE_OF_CELLS: f64 = 1e-6;
const CELL_PARTS: [(usize, usize); 3] = [(1, 4), (1, 2), (3, 4)];
/// Sizes of a cell across and along, relative to the reference's.
const CELLS: [f64; 4] = [8.0, 4.0, 2.0, 1.33];
/// The reference's cell size, relative to [`cell_for`].
const FINEST_CELL: f64 = 0.5;
/// Tolerances of the slices' curves \[m\].
const CURVES: [f64; 4] = [1e-7, 3e-7, 1e-6, 1e-5];
/// For the direct history: tolerances of the sums with the reference's, lateral terms, memories \[s\].
const SUMS: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5];
const FINEST_SUMS: f64 = 1e-8;
const TERMS: [usize; 4] = [2, 4, 8, 16];
const MEMORIES: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.7];
const MOST_FOR_LAWS: usize = 256;
/// Least number of the reference's steps in a period of the highest frequency.
const STEPS_PER_PERIOD: f64 = 48.0;
/// The same for an outline, and its tolerances of poles and sums.
const STEPS_PER_PERIOD_OF_OUTLINE: f64 = 24.0;
const TOLERANCES_OF_OUTLINE: [f64; 2] = [1e-5, 1e-7];

/// Settings of the reference: twice the scene's elements unless given, and steps for `STEPS_PER_PERIOD`, or
/// `STEPS_PER_PERIOD_OF_OUTLINE`, at the highest frequency.
pub(crate) fn reference(scene: &Scene, options: &StudyOptions) -> Settings {
    let StudyOptions { highest, elements, substeps, sweep, .. } = *options;
    let (per_period, [poles, sums]) = match sweep {
        Sweep::Outline => (STEPS_PER_PERIOD_OF_OUTLINE, TOLERANCES_OF_OUTLINE),
        _ => (STEPS_PER_PERIOD, [FINEST_POLES, FINEST_SUMS]),
    };
    let mut settings = Settings::of(scene);
    let Settings { numerics, contact, cell_length } = &mut settings;
    // A multiple of 16: all parts of it are even.
    let elements = elements.unwrap_or_else(|| (2 * numerics.elements).div_ceil(16) * 16);
    let substeps = substeps.unwrap_or_else(|| {
        let steps = per_period * highest * scene.tyre.circumference / scene.rolling.speed();
        // An even number: it is halved to see whether it is enough.
        (0.5 * steps / elements as f64).ceil().max(1.0) as usize * 2
    });
    (numerics.elements, numerics.substeps) = (elements, substeps);
    if numerics.time_rule.runge_kutta().is_none() {
        numerics.time_rule = TimeRule::Bdf2;
    }
    numerics.history = History::Modal;
    (numerics.lateral_terms, numerics.wavenumber_aliases) = (None, None);
    if contact.zone == Zone::Cells {
        numerics.pole_tolerance = FINEST_POLES_OF_CELLS;
        numerics.contact_tolerance = numerics.contact_tolerance.min(FINEST_TOLERANCE_OF_CELLS);
        let square = square_cells(&scene.tyre, elements);
        contact.cells_across = contact.cells_across.map(|across| square.max(2 * across));
        return settings;
    }
    (numerics.pole_tolerance, numerics.influence_tolerance) = (poles, sums);
    let of_law = contact.cell_of_law(&scene.road).filter(|_| contact.cells_across.is_none());
    *cell_length = of_law.unwrap_or_else(|| FINEST_CELL * cell_for(scene, highest));
    contact.cells_across = contact.cells_across.map(|_| Lattice::across(scene.tyre.contact_width, *cell_length));
    contact.slice_tolerance = 0.0;
    settings
}

/// Every other setting of the knobs of the discretisation, from the second on.
pub(crate) fn outline(scene: &Scene, reference: &Settings, highest: f64) -> Vec<Knob> {
    let mut knobs = knobs(scene, reference, highest);
    knobs.retain(|knob| knob.kind == Kind::Error && knob.anchor.is_none());
    for knob in &mut knobs {
        let mut place = 0;
        knob.steps.retain(|_| {
            place += 1;
            place % 2 == 0
        });
    }
    knobs
}

/// All knobs, first those of the discretisation.
pub(crate) fn knobs(scene: &Scene, reference: &Settings, highest: f64) -> Vec<Knob> {
    let own = Settings::of(scene);
    let mut knobs = vec![elements(reference), substeps(reference)];
    let rules = TimeRule::ALL.into_iter().filter(|&rule| rule != reference.numerics.time_rule);
    knobs.extend(rules.map(|rule| other_rule(reference, rule)));
    let poles = POLES.into_iter().filter(|&tolerance| tolerance > reference.numerics.pole_tolerance);
    let poles = poles.map(|tolerance| {
        (format!("{tolerance:.0e}"), reference.with(|settings| settings.numerics.pole_tolerance = tolerance))
    });
    knobs.push(Knob::error("pole tolerance", Ok(poles.collect())));
    if reference.contact.zone == Zone::Cells {
        knobs.push(cells(reference));
    } else {
        knobs.extend(slices(scene, reference));
        knobs.extend(direct(scene, &own, reference));
        knobs.push(Knob::error("single precision", Err("not built: all arithmetic is in double precision".to_owned())));
        knobs.extend(laws(scene, &own, reference));
    }
    for knob in &mut knobs {
        // A step too long for the highest bands gives no level there.
        knob.steps.retain(|(_, settings)| 1.0 / settings.time_step(scene) >= least_rate(highest));
    }
    knobs
}

impl Knob {
    /// A knob compared with `anchor`, or with the reference if that is `None`; `steps` is `Err` with the reason where
    /// the scene cannot have it.
    pub(crate) fn new(
        name: &str,
        kind: Kind,
        anchor: Option<&Settings>,
        steps: Result<Vec<(String, Settings)>, String>,
    ) -> Self {
        let (steps, missing) = steps.map_or_else(|reason| (Vec::new(), Some(reason)), |steps| (steps, None));
        let anchor = anchor.filter(|_| missing.is_none()).cloned();
        Self { name: name.to_owned(), kind, anchor, steps, points: Vec::new(), missing }
    }

    fn error(name: &str, steps: Result<Vec<(String, Settings)>, String>) -> Self {
        Self::new(name, Kind::Error, None, steps)
    }
}

/// The reference with other elements and steps, and its label.
fn resolved(name: impl ToString, reference: &Settings, elements: usize, substeps: usize) -> (String, Settings) {
    let turn = |settings: &mut Settings| {
        (settings.numerics.elements, settings.numerics.substeps) = (elements, substeps);
    };
    (name.to_string(), reference.with(turn))
}

/// Fewer elements at the reference's time step.
fn elements(reference: &Settings) -> Knob {
    let parts = ELEMENT_PARTS.map(|(part, of)| reference.numerics.elements * part / of).into_iter();
    let possible = parts.filter(|count| *count >= Numerics::FEWEST_ELEMENTS && count.is_multiple_of(2));
    let step = |count: usize| {
        let substeps = (reference.steps() as f64 / count as f64).round() as usize;
        resolved(count, reference, count, substeps)
    };
    Knob::error("elements", Ok(possible.map(step).collect()))
}

/// The settings for those of `substeps` that are fewer than the reference's.
fn fewer(reference: &Settings, substeps: &[usize]) -> Vec<(String, Settings)> {
    let fewer = substeps.iter().filter(|&&substeps| substeps < reference.numerics.substeps);
    fewer.map(|&substeps| resolved(substeps, reference, reference.numerics.elements, substeps)).collect()
}

fn substeps(reference: &Settings) -> Knob {
    Knob::error("substeps", Ok(fewer(reference, &SUBSTEPS)))
}

fn other_rule(reference: &Settings, time_rule: TimeRule) -> Knob {
    let reference = reference.with(|settings| settings.numerics.time_rule = time_rule);
    Knob::error(time_rule.name(), Ok(fewer(&reference, &OTHER_SUBSTEPS)))
}

fn cells(reference: &Settings) -> Knob {
    let all = reference.contact.cells_across.unwrap_or(1);
    let parts = CELL_PARTS.map(|(part, of)| all * part / of).into_iter().filter(|&across| across > 0);
    let step =
        |across: usize| (across.to_string(), reference.with(|settings| settings.contact.cells_across = Some(across)));
    Knob::error("cells", Ok(parts.map(step).collect()))
}

fn slices(scene: &Scene, reference: &Settings) -> Vec<Knob> {
    let level = || "the road is level across the contact width".to_owned();
    let varies = scene.road.varies_across() && scene.effects.texture != Switch::Off;
    let cells = match reference.contact.cells_across {
        Some(points) if varies && points > 1 => Ok(CELLS
            .map(|share| {
                let cell = share * reference.cell_length;
                let points = Lattice::across(scene.tyre.contact_width, cell);
                let turn = |settings: &mut Settings| {
                    (settings.contact.cells_across, settings.cell_length) = (Some(points), cell);
                };
                (format!("{:.2} mm", 1e3 * cell), reference.with(turn))
            })
            .into()),
        None if varies => Err("the measured road has cells of its own, or those of the law".to_owned()),
        _ => Err(level()),
    };
    let curves = if varies {
        let step = |tolerance: f64| {
            (format!("{tolerance:.0e} m"), reference.with(|settings| settings.contact.slice_tolerance = tolerance))
        };
        Ok(CURVES.map(step).into())
    } else {
        Err(level())
    };
    vec![Knob::error("cells", cells), Knob::error("slice tolerance", curves)]
}

/// The knobs that only the direct history has, at the scene's elements and steps: at the reference's it would take
/// days.
fn direct(scene: &Scene, own: &Settings, reference: &Settings) -> Vec<Knob> {
    let refuse = |name: &str, reason: &str| Knob::error(name, Err(reason.to_owned()));
    let own = &own.numerics;
    if own.history == History::Modal {
        return vec![
            refuse("influence tolerance", "history = \"modal\": the fit's sums follow the tolerance of the poles"),
            refuse("lateral terms", "history = \"modal\": the fit sums them with their tail"),
            refuse("memory", "history = \"modal\": nothing is forgotten"),
        ];
    }
    if !own.time_rule.is_multistep() {
        return vec![refuse("memory", "the direct history needs a multistep rule")];
    }
    let rule = |settings: &mut Settings| settings.numerics.time_rule = own.time_rule;
    let modal = resolved("", reference, own.elements, own.substeps).1.with(rule);
    let whole = scene.rolling.warm_up + scene.rolling.duration;
    let direct = |memory: f64| {
        modal.with(|Settings { numerics, .. }| (numerics.history, numerics.memory) = (History::Direct, memory))
    };
    let all = direct(whole);
    let sums = SUMS.map(|tolerance| {
        (format!("{tolerance:.0e}"), all.with(|settings| settings.numerics.influence_tolerance = tolerance))
    });
    let terms =
        TERMS.map(|terms| (terms.to_string(), all.with(|settings| settings.numerics.lateral_terms = Some(terms))));
    let memories = MEMORIES.into_iter().filter(|&memory| memory < whole);
    let memories = memories.map(|memory| (format!("{memory} s"), direct(memory))).collect();
    let anchored = |name: &str, anchor: &Settings, steps| Knob::new(name, Kind::Error, Some(anchor), Ok(steps));
    vec![
        anchored("influence tolerance", &all, sums.into()),
        anchored("lateral terms", &all, terms.into()),
        anchored("memory", &modal, memories),
    ]
}

/// The laws, at few elements: the stiffness of a bedding is found from static solutions, which take minutes with many.
fn laws(scene: &Scene, own: &Settings, reference: &Settings) -> Vec<Knob> {
    let elements = own.numerics.elements.min(MOST_FOR_LAWS);
    let anchor = resolved("", reference, elements, reference.steps().div_ceil(2 * elements)).1;
    let anchor = anchor.with(|settings| settings.numerics.pole_tolerance = POLES[0]);
    let law = &anchor.contact;
    let knob = |name: &str, steps| Knob::new(name, Kind::Model, Some(&anchor), steps);
    let varies = scene.road.varies_across() && scene.effects.texture != Switch::Off;
    let level = || "slices that are level across are the same by every law".to_owned();
    let treads = [(Tread::Elastic, "elastic"), (Tread::Uncoupled, "uncoupled"), (Tread::Bedding, "bedding")];
    let treads = others(&treads, law.tread, |tread| anchor.with(|settings| settings.contact.tread = tread));
    let laws = [(Slices::Winkler, "winkler"), (Slices::HalfSpace, "half-space"), (Slices::Pressed, "pressed")];
    let laws = others(&laws, law.slices, |slices| anchor.with(|settings| settings.contact.slices = slices));
    let couplings = [(SliceCoupling::Local, "local"), (SliceCoupling::Explicit, "explicit")];
    let coupled = if !varies {
        Err(level())
    } else if law.tread == Tread::Uncoupled {
        Err("points of an uncoupled tread have no neighbours within a step".to_owned())
    } else {
        let with = |coupling| {
            let turn = |Settings { contact, .. }: &mut Settings| {
                (contact.slice_coupling, contact.local_compliance) = (coupling, None);
            };
            anchor.with(turn)
        };
        Ok(others(&couplings, law.slice_coupling, with))
    };
    let compliance = if law.slices == Slices::Pressed {
        Err("the curves of a pressed road have none".to_owned())
    } else if law.slice_coupling == SliceCoupling::Local {
        let kappa = law.local_compliance.or_else(|| formula_for(scene)).ok_or_else(level);
        let with = |kappa: f64| anchor.with(|settings| settings.contact.local_compliance = Some(kappa));
        kappa.map(|kappa| DOUBTS.map(|(name, factor)| (name.to_owned(), with(factor * kappa))).into())
    } else {
        Err("the paper's slice coupling has none".to_owned())
    };
    vec![
        knob("tread law", Ok(treads)),
        knob("slice law", if varies { Ok(laws) } else { Err(level()) }),
        knob("slice coupling", coupled),
        knob("local compliance", compliance),
    ]
}

/// The settings for all laws but `own`, with their names.
fn others<L: Copy + PartialEq>(laws: &[(L, &str)], own: L, with: impl Fn(L) -> Settings) -> Vec<(String, Settings)> {
    laws.iter().filter(|(law, _)| *law != own).map(|&(law, name)| (name.to_owned(), with(law))).collect()
}
