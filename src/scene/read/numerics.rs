//! `[numerics]` and `[outputs]`.

use super::super::kind::{Bounds, Count, Flag, Kind, OneOf, short};
use super::super::table::{Nested, Table, Value};
use super::super::{History, Numerics, Outputs, Problem, Resolution, Rolling, TimeRule, Tyre};
use super::vibration::VIBRATION;

pub(super) const NUMERICS: Nested<Given> =
    Nested { title: "[numerics]", wanted: "the table [numerics]", read: numerics };
pub(super) const OUTPUTS: Nested<Outputs> = Nested { title: "[outputs]", wanted: "the table [outputs]", read: outputs };

/// Fewer elements do not even resolve the patch of a car tyre by two.
const FEWEST_ELEMENTS: u64 = 16;
/// Below a few units of rounding no sum of thousands of terms converges.
const INFLUENCE: Bounds = Bounds::between(1e-14, 0.1, "");
/// What a fit in double precision can reach, and what still is one.
const POLES: Bounds = Bounds::between(1e-10, 1e-2, "");
/// Likewise for the residual of a linear solve; above, a contact condition would say nothing.
const CONDITION: Bounds = Bounds::between(1e-15, 1e-3, "");

/// The table, and which of the numbers that `fmax` decides were given.
#[derive(Default)]
pub(super) struct Given {
    numerics: Numerics,
    elements: bool,
    substeps: bool,
}

impl Given {
    /// Elements and substeps from `fmax`; a complaint where they were given and cannot reach it.
    pub(super) fn resolve(self, tyre: &Tyre, rolling: &Rolling, table: &Table<'_>) -> Option<Numerics> {
        let Self { mut numerics, elements, substeps } = self;
        let Some(highest) = numerics.fmax else { return Some(numerics) };
        let (length, speed, rule) = (tyre.circumference, rolling.speed(), numerics.time_rule);
        let fixed = |given: bool, value: usize| given.then_some(value);
        let (n, q) = (fixed(elements, numerics.elements), fixed(substeps, numerics.substeps));
        let found = Resolution::new(highest, length, speed, rule, n, q);
        let wanted = Resolution::new(highest, length, speed, rule, None, None);
        (numerics.elements, numerics.substeps) = (found.elements, found.substeps);
        let contradiction =
            |key: &str, wrong: String, right: String| table.complain(key, Problem::Complaint { wrong, right });
        let texture = found.texture_limit(length, speed);
        if elements && texture < highest {
            let wrong = format!(
                "{} elements hold no texture above {texture:.0} Hz at {} km/h, and numerics.fmax = {} Hz is wanted",
                found.elements,
                rolling.speed_kmh,
                short(highest)
            );
            return contradiction("numerics.elements", wrong, format!("{}, or leave it out", wanted.elements));
        }
        let limit = found.rule_limit(length, speed, rule);
        if substeps && limit < highest {
            let wrong = format!(
                "{} steps per element keep phase and damping of {} within {} % up to {limit:.0} Hz, and numerics.fmax = {} Hz is wanted",
                found.substeps,
                rule.name(),
                100.0 * Resolution::RULE_ERROR,
                short(highest)
            );
            let enough = Resolution::new(highest, length, speed, rule, Some(found.elements), None).substeps;
            return contradiction("numerics.substeps", wrong, format!("{enough}, or leave it out"));
        }
        Some(numerics)
    }
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
    let given = (table.has("elements"), table.has("substeps"));
    let elements = table.or("elements", &Elements, default.elements);
    let substeps = table.or("substeps", &Count(1), default.substeps);
    let time_rule = table.or("time_rule", &OneOf::<TimeRule>::new(), default.time_rule);
    let history = table.or("history", &OneOf::<History>::new(), default.history);
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
    Some(Given { numerics, elements: given.0, substeps: given.1 })
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
