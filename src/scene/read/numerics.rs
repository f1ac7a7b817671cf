//! `[numerics]` and `[outputs]`.

use super::super::kind::{Bounds, Count, Decibels, Flag, Kind, OneOf, short};
use super::super::table::{Nested, Table, Value};
use super::super::{Choice, History, Need, Numerics, Outputs, Problem, Resolution, Scene, Switch, TimeRule};
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

/// From what no road is known to, up to what is hardly an accuracy.
const ACCURACY: Bounds = Bounds::between(0.05, 6.0, "dB");

/// The table, and which of the numbers that `fmax` and `accuracy` decide were given.
#[derive(Default)]
pub(super) struct Given {
    numerics: Numerics,
    elements: bool,
    substeps: bool,
    pole_tolerance: bool,
    influence_tolerance: bool,
}

impl Given {
    /// The numbers as given, or their defaults.
    pub(super) fn numerics(&self) -> &Numerics {
        &self.numerics
    }

    /// Puts what follows from `fmax` and `accuracy` into the scene, and says why; a complaint where given numbers cannot reach them.
    pub(super) fn resolve(self, scene: &mut Scene, table: &Table<'_>) -> Option<Vec<Choice>> {
        let Some(highest) = self.numerics.fmax else {
            return match self.numerics.accuracy {
                None => Some(Vec::new()),
                Some(_) => {
                    let wanted = format!(
                        "{}, the highest frequency that numerics.accuracy is meant for",
                        Bounds::positive("Hz")
                    );
                    table.complain("numerics.fmax", Problem::Missing { wanted })
                }
            };
        };
        let need = Need { highest, accuracy: self.numerics.accuracy };
        let mut choices = self.resolution(need, scene, table)?;
        if need.accuracy.is_some() {
            self.tolerances(need, scene, &mut choices);
            if scene.contact.lateral_points.is_none()
                && scene.effects.texture != Switch::Off
                && scene.road.varies_across()
            {
                let cell = need.cell();
                let points = (scene.tyre.contact_width / cell).ceil().max(2.0) as usize;
                scene.contact.lateral_points = Some(points);
                let reason = format!("cells of at most {} mm across", short(1e3 * cell));
                choices.push(Choice { key: "contact.lateral_points", value: points.to_string(), reason });
            }
        }
        Some(choices)
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
        let (limit, error) = (found.rule_limit(need, length, speed, rule), 100.0 * need.rule_error());
        if self.substeps && limit < highest {
            let wrong = format!(
                "{} steps per element keep phase and damping of {} within {error:.1} % up to {limit:.0} Hz, and numerics.fmax = {} Hz is wanted",
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
                1e3 * Resolution::LONGEST_ELEMENT
            );
            choices.push(Choice { key: "numerics.elements", value: found.elements.to_string(), reason });
        }
        if !self.substeps {
            let reason = format!("{} stays within {error:.1} % in phase and damping up to {limit:.0} Hz", rule.name());
            choices.push(Choice { key: "numerics.substeps", value: found.substeps.to_string(), reason });
        }
        Some(choices)
    }

    fn tolerances(&self, need: Need, scene: &mut Scene, choices: &mut Vec<Choice>) {
        let numerics = &mut scene.numerics;
        if !self.pole_tolerance && numerics.history == History::Modal {
            numerics.pole_tolerance = need.pole_tolerance();
            let value = format!("{:.1e}", numerics.pole_tolerance);
            let reason = "a fifth of it is the force's error relative to its peak".to_owned();
            choices.push(Choice { key: "numerics.pole_tolerance", value, reason });
        }
        if !self.influence_tolerance {
            numerics.influence_tolerance = numerics.influence_tolerance.max(0.01 * need.pole_tolerance());
            let value = format!("{:.1e}", numerics.influence_tolerance);
            let reason =
                "lateral terms and aliases until they add less than a hundredth of the poles' tolerance".to_owned();
            choices.push(Choice { key: "numerics.influence_tolerance", value, reason });
        }
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
    let accuracy = table.optional("accuracy", &Decibels(ACCURACY));
    let given = |key: &str| table.has(key);
    let (elements_given, substeps_given) = (given("elements"), given("substeps"));
    let (poles_given, influence_given) = (given("pole_tolerance"), given("influence_tolerance"));
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
        pole_tolerance: poles_given,
        influence_tolerance: influence_given,
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
