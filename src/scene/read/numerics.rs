//! `[numerics]` and `[outputs]`.

use super::super::kind::{Bounds, Count, Decibels, Flag, OneOf};
use super::super::table::Kind;
use super::super::table::{Nested, Table, Value};
use super::super::{History, Numerics, Outputs, Preset, Problem, TimeRule};
use super::vibration::VIBRATION;

pub(super) const NUMERICS: Nested<Numerics> =
    Nested { title: "[numerics]", wanted: "the table [numerics]", read: numerics };
pub(super) const OUTPUTS: Nested<Outputs> = Nested { title: "[outputs]", wanted: "the table [outputs]", read: outputs };

const FEWEST_ELEMENTS: u64 = Numerics::FEWEST_ELEMENTS as u64;
/// Below a few units of rounding no sum of thousands of terms converges.
const INFLUENCE: Bounds = Bounds::between(1e-14, 0.1, "");
/// What a fit in double precision can reach, and what still is one.
const POLES: Bounds = Bounds::between(1e-10, 1e-2, "");
/// Likewise for the residual of a linear solve; above, a contact condition would say nothing.
const CONDITION: Bounds = Bounds::between(1e-15, 1e-3, "");

/// From what no road is known to, up to what is hardly an accuracy.
const ACCURACY: Bounds = Bounds::between(0.05, 12.0, "dB");

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
            let right = format!("write an even number, such as {}", elements - 1);
            value.complain(Problem::new(format!("{elements} is odd"), right))
        }
    }
}

fn numerics(table: &mut Table<'_>) -> Option<Numerics> {
    let default = Numerics::default();
    let fmax = table.optional("fmax", &Bounds::positive("Hz"));
    let preset = table.optional("preset", &OneOf::<Preset>::new());
    let accuracy = table.optional("accuracy", &Decibels(ACCURACY));
    // A memory to be summed over is a wish for the sum; sums have weights for multistep rules only.
    let history_default = if table.has("memory") { History::Direct } else { default.history };
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
    if table.has("preset") && table.has("accuracy") {
        let wrong = "this and `preset` both choose a row of the same table";
        return table.complain("accuracy", Problem::new(wrong, "either this or `preset`"));
    }
    if let Some(key) = ["preset", "accuracy"].into_iter().find(|key| table.has(key))
        && !table.has("fmax")
    {
        let wanted = format!("{}, the highest frequency that numerics.{key} is meant for", Bounds::positive("Hz"));
        return table.complain("fmax", Problem::missing(&wanted));
    }
    Some(Numerics {
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
