//! The knobs of a scene: what is swept, and what it cannot have.

use serde::Serialize;

use crate::local_compliance::{DOUBTS, formula_for};
use crate::plan::front::cell_for;
use crate::road::Lattice;
use crate::scene::{History, Numerics, Scene, SliceCoupling, Slices, Switch, TimeRule, Tread};
use crate::study::accuracy::settings::Settings;
use crate::study::compare::least_rate;

/// What turning a knob changes.
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

/// A knob and the settings that it is swept through.
#[derive(Clone, Debug, PartialEq)]
pub struct Knob {
    /// Its name.
    pub name: String,
    /// What it changes.
    pub kind: Kind,
    /// What its runs are compared with, where that is not the reference of all.
    pub anchor: Option<Settings>,
    /// A word for each setting, and all settings; or why the scene cannot have it.
    pub steps: Result<Vec<(String, Settings)>, String>,
}

/// Parts of the reference's elements that are swept.
const ELEMENT_PARTS: [(usize, usize); 4] = [(1, 4), (3, 8), (1, 2), (3, 4)];
/// Steps per element that are swept, with the scene's rule and with the others.
const SUBSTEPS: [usize; 5] = [1, 2, 3, 4, 6];
const OTHER_SUBSTEPS: [usize; 3] = [1, 2, 4];
/// Tolerances of the poles.
const POLES: [f64; 3] = [1e-3, 1e-4, 1e-5];
/// The reference's.
const FINEST_POLES: f64 = 1e-6;
/// Sizes of a cell across and along, relative to the reference's.
const CELLS: [f64; 4] = [8.0, 4.0, 2.0, 1.33];
/// The reference's, relative to [`cell_for`].
const FINEST_CELL: f64 = 0.5;
/// Tolerances of the slices' curves \[m\].
const CURVES: [f64; 4] = [1e-7, 3e-7, 1e-6, 1e-5];
/// For the direct history: tolerances of the sums with the reference's, lateral terms, memories \[s\].
const SUMS: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5];
const FINEST_SUMS: f64 = 1e-8;
const TERMS: [usize; 4] = [2, 4, 8, 16];
const MEMORIES: [f64; 5] = [0.05, 0.1, 0.2, 0.4, 0.7];
/// Most elements with which laws are compared.
const MOST_FOR_LAWS: usize = 256;
/// Steps of the reference in a period of the highest frequency, at least.
const STEPS_PER_PERIOD: f64 = 48.0;

/// The settings of the reference: twice the scene's elements unless given, and steps for `STEPS_PER_PERIOD` at
/// `highest` \[Hz\].
pub fn reference(scene: &Scene, highest: f64, elements: Option<usize>, substeps: Option<usize>) -> Settings {
    let own = Settings::of(scene);
    // A multiple of 16: all parts of it are even.
    let elements = elements.unwrap_or_else(|| (2 * own.elements).div_ceil(16) * 16);
    let substeps = substeps.unwrap_or_else(|| {
        let steps = STEPS_PER_PERIOD * highest * scene.tyre.circumference / scene.rolling.speed();
        // An even number: it is halved to see whether it is enough.
        (0.5 * steps / elements as f64).ceil().max(1.0) as usize * 2
    });
    let time_rule = match own.time_rule {
        TimeRule::Sdirk2 | TimeRule::Sdirk3 => own.time_rule,
        TimeRule::Bdf1 | TimeRule::Bdf2 | TimeRule::Trapezoidal | TimeRule::FirstOrderHold => TimeRule::Bdf2,
    };
    let cell = FINEST_CELL * cell_for(scene, highest);
    let cells = |_| Lattice::across(scene.tyre.contact_width, cell);
    Settings {
        elements,
        substeps,
        time_rule,
        history: History::Modal,
        pole_tolerance: FINEST_POLES,
        influence_tolerance: FINEST_SUMS,
        lateral_terms: None,
        wavenumber_aliases: None,
        cells_across: own.cells_across.map(cells),
        cell_length: cell,
        slice_tolerance: 0.0,
        ..own
    }
}

/// All knobs, those first that a discretisation has.
pub fn knobs(scene: &Scene, reference: &Settings, highest: f64) -> Vec<Knob> {
    let own = Settings::of(scene);
    let mut knobs = vec![elements(reference), substeps(reference)];
    let rules = TimeRule::ALL.into_iter().filter(|&rule| rule != reference.time_rule);
    knobs.extend(rules.map(|rule| other_rule(reference, rule)));
    let pole =
        |tolerance: f64| (format!("{tolerance:.0e}"), Settings { pole_tolerance: tolerance, ..reference.clone() });
    knobs.push(Knob::error("pole tolerance", Ok(POLES.map(pole).into())));
    knobs.extend(slices(scene, reference));
    knobs.extend(direct(scene, &own, reference));
    knobs.push(Knob::error("single precision", Err("not built: all arithmetic is in double precision".to_owned())));
    knobs.extend(laws(scene, &own, reference));
    for knob in &mut knobs {
        if let Ok(steps) = &mut knob.steps {
            // What holds nothing of the highest bands has no level there.
            steps.retain(|(_, settings)| 1.0 / settings.time_step(scene) >= least_rate(highest));
        }
    }
    knobs
}

impl Knob {
    fn error(name: &str, steps: Result<Vec<(String, Settings)>, String>) -> Self {
        Self { name: name.to_owned(), kind: Kind::Error, anchor: None, steps }
    }
}

/// Fewer elements at the reference's time step.
fn elements(reference: &Settings) -> Knob {
    let step = |(part, of): (usize, usize)| {
        let elements = reference.elements * part / of;
        let substeps = (reference.steps() as f64 / elements as f64).round() as usize;
        (elements.to_string(), Settings { elements, substeps, ..reference.clone() })
    };
    let possible =
        |settings: &Settings| settings.elements >= Numerics::FEWEST_ELEMENTS && settings.elements.is_multiple_of(2);
    Knob::error(
        "elements",
        Ok(ELEMENT_PARTS.map(step).into_iter().filter(|(_, settings)| possible(settings)).collect()),
    )
}

fn substeps(reference: &Settings) -> Knob {
    let step = |substeps: usize| (substeps.to_string(), Settings { substeps, ..reference.clone() });
    let fewer = SUBSTEPS.into_iter().filter(|&substeps| substeps < reference.substeps);
    Knob::error("substeps", Ok(fewer.map(step).collect()))
}

fn other_rule(reference: &Settings, time_rule: TimeRule) -> Knob {
    let steps = if time_rule == TimeRule::FirstOrderHold {
        Err("its inverse is unstable for a tyre: refused by every run".to_owned())
    } else {
        let step = |substeps: usize| (substeps.to_string(), Settings { substeps, time_rule, ..reference.clone() });
        Ok(OTHER_SUBSTEPS.into_iter().filter(|&substeps| substeps < reference.substeps).map(step).collect())
    };
    Knob::error(time_rule.name(), steps)
}

fn slices(scene: &Scene, reference: &Settings) -> Vec<Knob> {
    let level = || "the road is level across the contact width".to_owned();
    let varies = scene.road.varies_across() && scene.effects.texture != Switch::Off;
    let cells = match reference.cells_across {
        Some(points) if varies && points > 1 => Ok(CELLS
            .map(|share| {
                let cell = share * reference.cell_length;
                let points = Lattice::across(scene.tyre.contact_width, cell);
                let settings = Settings { cells_across: Some(points), cell_length: cell, ..reference.clone() };
                (format!("{:.2} mm", 1e3 * cell), settings)
            })
            .into()),
        None if varies => Err("the measured road has cells of its own".to_owned()),
        _ => Err(level()),
    };
    let curves = if varies && reference.slices != Slices::None {
        let step = |tolerance: f64| {
            (format!("{tolerance:.0e} m"), Settings { slice_tolerance: tolerance, ..reference.clone() })
        };
        Ok(CURVES.map(step).into())
    } else {
        Err(level())
    };
    vec![Knob::error("cells", cells), Knob::error("slice tolerance", curves)]
}

/// What only the direct history has, at the scene's own elements and steps: at the reference's it would take days.
fn direct(scene: &Scene, own: &Settings, reference: &Settings) -> Vec<Knob> {
    let refuse = |name: &str, reason: &str| Knob::error(name, Err(reason.to_owned()));
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
    let modal =
        Settings { elements: own.elements, substeps: own.substeps, time_rule: own.time_rule, ..reference.clone() };
    let whole = scene.rolling.warm_up + scene.rolling.duration;
    let all = Settings { history: History::Direct, memory: whole, ..modal.clone() };
    let anchored =
        |name: &str, anchor: &Settings, steps| Knob { anchor: Some(anchor.clone()), ..Knob::error(name, Ok(steps)) };
    let memories = MEMORIES.into_iter().filter(|&memory| memory < whole);
    vec![
        anchored(
            "influence tolerance",
            &all,
            SUMS.map(|tolerance| {
                (format!("{tolerance:.0e}"), Settings { influence_tolerance: tolerance, ..all.clone() })
            })
            .into(),
        ),
        anchored(
            "lateral terms",
            &all,
            TERMS.map(|terms| (terms.to_string(), Settings { lateral_terms: Some(terms), ..all.clone() })).into(),
        ),
        anchored(
            "memory",
            &modal,
            memories.map(|memory| (format!("{memory} s"), Settings { memory, ..all.clone() })).collect(),
        ),
    ]
}

/// Laws at few elements: the stiffness of a bedding is looked for in static solutions, which take minutes with many.
fn laws(scene: &Scene, own: &Settings, reference: &Settings) -> Vec<Knob> {
    let elements = own.elements.min(MOST_FOR_LAWS);
    let substeps = reference.steps().div_ceil(2 * elements);
    let anchor = Settings { elements, substeps, pole_tolerance: POLES[0], ..reference.clone() };
    let knob = |name: &str, steps: Result<Vec<(String, Settings)>, String>| Knob {
        name: name.to_owned(),
        kind: Kind::Model,
        anchor: steps.is_ok().then(|| anchor.clone()),
        steps,
    };
    let varies = scene.road.varies_across() && scene.effects.texture != Switch::Off;
    let level = || "slices that are level across are the same by every law".to_owned();
    let treads = [(Tread::Elastic, "elastic"), (Tread::Uncoupled, "uncoupled"), (Tread::Bedding, "bedding")];
    let treads = others(&treads, anchor.tread, |tread| Settings { tread, ..anchor.clone() });
    let laws = [(Slices::None, "none"), (Slices::Winkler, "winkler"), (Slices::HalfSpace, "half-space")];
    let laws = others(&laws, anchor.slices, |slices| Settings { slices, ..anchor.clone() });
    let couplings =
        [(SliceCoupling::Local, "local"), (SliceCoupling::Explicit, "explicit"), (SliceCoupling::Implicit, "implicit")];
    let coupled = if !varies || anchor.slices == Slices::None {
        Err(level())
    } else if anchor.tread == Tread::Uncoupled {
        Err("points of an uncoupled tread have no neighbours within a step".to_owned())
    } else {
        let with = |slice_coupling| Settings { slice_coupling, local_compliance: None, ..anchor.clone() };
        Ok(others(&couplings, anchor.slice_coupling, with))
    };
    let compliance = if anchor.slice_coupling == SliceCoupling::Local {
        match anchor.local_compliance.or_else(|| formula_for(scene)) {
            Some(kappa) => Ok(DOUBTS
                .map(|(name, factor)| {
                    (name.to_owned(), Settings { local_compliance: Some(factor * kappa), ..anchor.clone() })
                })
                .into()),
            None => Err(level()),
        }
    } else {
        Err("the paper's slice couplings have none".to_owned())
    };
    vec![
        knob("tread law", Ok(treads)),
        knob("slice law", if varies { Ok(laws) } else { Err(level()) }),
        knob("slice coupling", coupled),
        knob("local compliance", compliance),
    ]
}

/// Settings for all laws but one, with their names.
fn others<L: Copy + PartialEq>(laws: &[(L, &str)], own: L, with: impl Fn(L) -> Settings) -> Vec<(String, Settings)> {
    laws.iter().filter(|(law, _)| *law != own).map(|&(law, name)| (name.to_owned(), with(law))).collect()
}
