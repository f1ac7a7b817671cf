//! `[numerics]` and `[outputs]`.

use super::super::kind::{Bounds, Count, Decibels, Flag, Kind, OneOf, short};
use super::super::table::{Nested, Table, Value};
use super::super::{
    Choice, Contact, FrontRow, History, Need, Numerics, Outputs, Preset, Problem, Resolution, Road, Scene, Switch,
    TimeRule,
};
use super::vibration::VIBRATION;

pub(super) const NUMERICS: Nested<Given> =
    Nested { title: "[numerics]", wanted: "the table [numerics]", read: numerics };
pub(super) const OUTPUTS: Nested<Outputs> = Nested { title: "[outputs]", wanted: "the table [outputs]", read: outputs };

/// Fewer elements do not even resolve the patch of a car tyre by two.
const FEWEST_ELEMENTS: u64 = Resolution::FEWEST_ELEMENTS as u64;
/// Below a few units of rounding no sum of thousands of terms converges.
const INFLUENCE: Bounds = Bounds::between(1e-14, 0.1, "");
/// What a fit in double precision can reach, and what still is one.
const POLES: Bounds = Bounds::between(1e-10, 1e-2, "");
/// Likewise for the residual of a linear solve; above, a contact condition would say nothing.
const CONDITION: Bounds = Bounds::between(1e-15, 1e-3, "");

/// From what no road is known to, up to what is hardly an accuracy.
const ACCURACY: Bounds = Bounds::between(0.05, 12.0, "dB");

/// The table, and which of the keys that `fmax`, `preset` and `accuracy` decide were given.
#[derive(Default)]
pub(super) struct Given {
    numerics: Numerics,
    elements: bool,
    substeps: bool,
    time_rule: bool,
    history: bool,
    pole_tolerance: bool,
}

impl Given {
    /// The numbers as given, or their defaults.
    pub(super) fn numerics(&self) -> &Numerics {
        &self.numerics
    }

    /// Puts what follows from `fmax`, `preset` and `accuracy` into the scene, and says why; a complaint where they
    /// contradict each other or given numbers cannot reach them.
    pub(super) fn resolve(self, scene: &mut Scene, table: &Table<'_>) -> Option<Vec<Choice>> {
        let Numerics { fmax, preset, accuracy, .. } = self.numerics;
        let row = match (preset, accuracy) {
            (Some(_), Some(_)) => {
                let wrong = "this and `preset` both choose a row of the same table".to_owned();
                let right = "either this or `preset`".to_owned();
                return table.complain("numerics.accuracy", Problem::Complaint { wrong, right });
            }
            (Some(preset), None) => Some(preset.row()),
            (None, Some(accuracy)) => match FrontRow::within(accuracy) {
                Some(row) => Some(row),
                None => {
                    let wrong = format!("{} dB is finer than any row of the table states", short(accuracy));
                    let right = format!("at least {} dB, or settings of your own", short(FrontRow::finest_error()));
                    return table.complain("numerics.accuracy", Problem::Complaint { wrong, right });
                }
            },
            (None, None) => None,
        };
        let Some(highest) = fmax else {
            let Some(_) = row else { return Some(Vec::new()) };
            let key = if preset.is_some() { "preset" } else { "accuracy" };
            let wanted = format!("{}, the highest frequency that numerics.{key} is meant for", Bounds::positive("Hz"));
            return table.complain("numerics.fmax", Problem::Missing { wanted });
        };
        let mut choices = row.map_or(Vec::new(), |row| self.take_row(row, highest, preset.is_some(), scene));
        choices.extend(self.resolution(Need { highest, row }, scene, table)?);
        if let Some(row) = row.filter(|_| scene.contact.cells_along.is_none() && !matches!(scene.road, Road::Smooth)) {
            let cell = row.cell_for(scene, highest);
            let cells = Road::cells(scene.tyre.circumference / scene.numerics.elements as f64, cell);
            scene.contact.cells_along = Some(cells);
            let reason = format!("preset \"{}\": cells of at most {} mm along", row.preset.name(), millimetres(cell));
            choices.push(Choice { key: "contact.cells_along", value: cells.to_string(), reason });
        }
        // A wish beside keys that are all given has chosen nothing.
        if row.is_some() && choices.len() == 1 {
            choices.clear();
        }
        Some(choices)
    }

    /// What a row of the table says beside elements and steps.
    fn take_row(&self, row: &FrontRow, highest: f64, named: bool, scene: &mut Scene) -> Vec<Choice> {
        let (name, error) = (row.preset.name(), row.error);
        let why = format!("preset \"{name}\"");
        let worth = format!(
            "third octaves within {} dB up to fmax at {} times the work of \"standard\"",
            short(error),
            short(row.cost)
        );
        let first = if named {
            Choice { key: "numerics.preset", value: name.to_owned(), reason: format!("given: {worth}") }
        } else {
            Choice {
                key: "numerics.accuracy",
                value: why.clone(),
                reason: format!("the cheapest that keeps it: {worth}"),
            }
        };
        let mut choices = vec![first];
        let cell = row.cell_for(scene, highest);
        let mut choose = |key, value: String, reason: String| choices.push(Choice { key, value, reason });
        let Scene { numerics, contact, tyre, .. } = scene;
        if !self.time_rule {
            numerics.time_rule = row.time_rule;
            choose("numerics.time_rule", row.time_rule.name().to_owned(), why.clone());
        }
        if !self.history {
            numerics.history = History::Modal;
            choose("numerics.history", "modal".to_owned(), format!("{why}: the whole past, at the least work"));
        }
        if !self.pole_tolerance && numerics.history == History::Modal {
            numerics.pole_tolerance = row.pole_tolerance;
            choose("numerics.pole_tolerance", format!("{:.0e}", row.pole_tolerance), why.clone());
        }
        // A row that keeps the default chooses nothing.
        let usual = Contact::SLICE_TOLERANCE.to_bits();
        let open = contact.slice_tolerance.to_bits() == usual && row.slice_tolerance.to_bits() != usual;
        if open && scene.effects.texture != Switch::Off {
            contact.slice_tolerance = row.slice_tolerance;
            choose("contact.slice_tolerance", format!("{:.0e}", row.slice_tolerance), why.clone());
        }
        if contact.cells_across.is_none() && scene.effects.texture != Switch::Off && scene.road.varies_across() {
            let points = Road::cells(tyre.contact_width, cell).max(2);
            contact.cells_across = Some(points);
            let reason = format!("{why}: cells of at most {} mm across", millimetres(cell));
            choose("contact.cells_across", points.to_string(), reason);
        }
        choices
    }

    fn resolution(&self, need: Need, scene: &mut Scene, table: &Table<'_>) -> Option<Vec<Choice>> {
        let Scene { tyre, rolling, numerics, .. } = scene;
        let (length, speed, rule) = (tyre.circumference, rolling.speed(), numerics.time_rule);
        let fixed = |given: bool, value: usize| given.then_some(value);
        let (n, q) = (fixed(self.elements, numerics.elements), fixed(self.substeps, numerics.substeps));
        let found = Resolution::new(need, length, speed, rule, n, q);
        let wanted = Resolution::new(need, length, speed, rule, None, None);
        (numerics.elements, numerics.substeps) = (found.elements, found.substeps);
        let contradiction =
            |key: &str, wrong: String, right: String| table.complain(key, Problem::Complaint { wrong, right });
        let texture = found.texture_limit(length, speed);
        let highest = need.highest;
        if self.elements && texture < highest {
            let wrong = format!(
                "{} elements hold no texture above {texture:.0} Hz at {} km/h, and numerics.fmax = {} Hz is wanted",
                found.elements,
                rolling.speed_kmh,
                short(highest)
            );
            return contradiction("numerics.elements", wrong, format!("{}, or leave it out", wanted.elements));
        }
        let limit = found.rule_limit(need, length, speed, rule);
        let percent = (100.0 * need.rule_error()).round();
        if self.substeps && limit < (1.0 - 1e-9) * highest {
            let wrong = format!(
                "{} steps per element keep phase and damping of {} within {percent} % up to {limit:.0} Hz, and numerics.fmax = {} Hz is wanted",
                found.substeps,
                rule.name(),
                short(highest)
            );
            let enough = Resolution::new(need, length, speed, rule, Some(found.elements), None).substeps;
            return contradiction("numerics.substeps", wrong, format!("{enough}, or leave it out"));
        }
        let mut choices = Vec::new();
        if !self.elements {
            let reason = format!(
                "fmax = {highest} Hz: {:.1} per texture wavelength at {} km/h, none longer than {} mm",
                2.0 * texture / highest,
                rolling.speed_kmh,
                short(1e3 * need.longest_element())
            );
            choices.push(Choice { key: "numerics.elements", value: found.elements.to_string(), reason });
        }
        if !self.substeps {
            let reason = format!(
                "{:.1} steps in a period of fmax; {} stays within {percent} % in phase and damping up to {limit:.0} Hz",
                found.steps_per_second(length, speed) / highest,
                rule.name()
            );
            choices.push(Choice { key: "numerics.substeps", value: found.substeps.to_string(), reason });
        }
        Some(choices)
    }
}

/// A length in mm, to a hundredth.
fn millimetres(length: f64) -> String {
    short((1e5 * length).round() / 100.0)
}

/// An even number of elements.
struct Elements;

impl Kind for Elements {
    type Output = usize;

    fn wanted(&self) -> String {
        format!("an even whole number of at least {FEWEST_ELEMENTS}")
    }

    fn read(&self, value: &Value<'_>) -> Option<usize> {
        if value.get().as_integer().is_none() {
            return value.wrong_type(self);
        }
        let elements = Count(FEWEST_ELEMENTS).read(value)?;
        // Wavenumbers run from -N/2 to N/2 - 1.
        if elements.is_multiple_of(2) {
            Some(elements)
        } else {
            value.complain(Problem::Odd { value: elements as u64 })
        }
    }
}

fn numerics(table: &mut Table<'_>) -> Option<Given> {
    let default = Numerics::default();
    let fmax = table.optional("fmax", &Bounds::positive("Hz"));
    let preset = table.optional("preset", &OneOf::<Preset>::new());
    let accuracy = table.optional("accuracy", &Decibels(ACCURACY));
    let given = |key: &str| table.has(key);
    let (elements_given, substeps_given) = (given("elements"), given("substeps"));
    let (rule_given, history_given, poles_given) = (given("time_rule"), given("history"), given("pole_tolerance"));
    // A memory to be summed over is a wish for the sum; sums have weights for multistep rules only.
    let history_default = if given("memory") { History::Direct } else { default.history };
    let elements = table.or("elements", &Elements, default.elements);
    let substeps = table.or("substeps", &Count(1), default.substeps);
    let history = table.or("history", &OneOf::<History>::new(), history_default);
    let rule_default = if history == Some(History::Direct) { TimeRule::Bdf2 } else { default.time_rule };
    let time_rule = table.or("time_rule", &OneOf::<TimeRule>::new(), rule_default);
    let pole_tolerance = table.or("pole_tolerance", &POLES, default.pole_tolerance);
    let memory = table.or("memory", &Bounds::positive("s"), default.memory);
    let influence_tolerance = table.or("influence_tolerance", &INFLUENCE, default.influence_tolerance);
    let contact_tolerance = table.or("contact_tolerance", &CONDITION, default.contact_tolerance);
    let lateral_terms = table.optional("lateral_terms", &Count(1));
    let wavenumber_aliases = table.optional("wavenumber_aliases", &Count(0));
    let cached_factors = table.or("cached_factors", &Count(1), default.cached_factors);
    let memory_limit = table.or("memory_limit", &Bounds::positive("GB"), default.memory_limit);
    let time_limit = table.or("time_limit", &Bounds::positive("h"), default.time_limit);
    let numerics = Numerics {
        fmax: fmax?,
        preset: preset?,
        accuracy: accuracy?,
        elements: elements?,
        substeps: substeps?,
        time_rule: time_rule?,
        history: history?,
        memory: memory?,
        pole_tolerance: pole_tolerance?,
        influence_tolerance: influence_tolerance?,
        contact_tolerance: contact_tolerance?,
        lateral_terms: lateral_terms?,
        wavenumber_aliases: wavenumber_aliases?,
        cached_factors: cached_factors?,
        memory_limit: memory_limit?,
        time_limit: time_limit?,
    };
    Some(Given {
        numerics,
        elements: elements_given,
        substeps: substeps_given,
        time_rule: rule_given,
        history: history_given,
        pole_tolerance: poles_given,
    })
}

fn outputs(table: &mut Table<'_>) -> Option<Outputs> {
    let default = Outputs::default();
    let arrays = table.or("arrays", &Flag, default.arrays);
    let spectra = table.or("spectra", &Flag, default.spectra);
    let plots = table.or("plots", &Flag, default.plots);
    let checkpoint_interval = table.or("checkpoint_interval", &Bounds::not_negative("s"), default.checkpoint_interval);
    let vibration = table.optional("vibration", &VIBRATION);
    Some(Outputs {
        arrays: arrays?,
        spectra: spectra?,
        plots: plots?,
        checkpoint_interval: checkpoint_interval?,
        vibration: vibration?,
    })
}
