//! The knobs of a scene: each a setting, and the values that it is swept through.

use serde::Serialize;

use crate::road::Lattice;
use crate::scene::{Numerics, Scene, Switch, TimeRule, Zone};
use crate::study::accuracy::runs::StudyPoint;
use crate::study::accuracy::settings::Settings;
use crate::study::trial::least_rate;

/// A knob, and the settings it is swept through with the rest at the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Knob {
    pub name: &'static str,
    /// Label of each setting, and all settings.
    #[serde(skip)]
    pub steps: Vec<(String, Settings)>,
    /// The settings that were rolled.
    pub points: Vec<StudyPoint>,
    /// Why some of the settings could not be rolled.
    pub missing: Option<String>,
}

/// A knob of the table: the reference is changed by `turn` to each of `values`.
struct Row {
    name: &'static str,
    turn: fn(&mut Settings, f64, &Scene),
    values: &'static [f64],
    label: fn(&Settings) -> String,
}

const ELEMENTS: Row = Row {
    name: "elements",
    // The time step stays about the same.
    turn: |settings, part, _| {
        let (steps, elements) = (settings.steps(), (part * settings.numerics.elements as f64) as usize);
        settings.numerics.elements = elements;
        settings.numerics.substeps = (steps as f64 / elements as f64).round().max(1.0) as usize;
    },
    values: &[0.25, 0.375, 0.5, 0.75],
    label: |settings| settings.numerics.elements.to_string(),
};
const SUBSTEPS: Row = Row {
    name: "substeps",
    turn: |settings, substeps, _| settings.numerics.substeps = substeps as usize,
    values: &[1.0, 2.0, 3.0, 4.0, 6.0],
    label: |settings| settings.numerics.substeps.to_string(),
};
const POLES: Row = Row {
    name: "pole tolerance",
    turn: |settings, tolerance, _| settings.numerics.pole_tolerance = tolerance,
    values: &[1e-3, 1e-4, 1e-5],
    label: |settings| format!("{:.0e}", settings.numerics.pole_tolerance),
};
/// Parts of the reference's cells across, of contact over cells.
const CELLS: Row = Row {
    name: "cells",
    turn: |Settings { contact, .. }, part, _| {
        contact.cells_across = contact.cells_across.map(|across| ((part * across as f64) as usize).max(1));
    },
    values: &[0.25, 0.5, 0.75],
    label: |settings| settings.contact.cells_across.unwrap_or_default().to_string(),
};
/// Multiples of the reference's cell size of slices.
const CELLS_OF_SLICES: Row = Row {
    name: "cells",
    turn: |settings, factor, scene| {
        settings.cell_length *= factor;
        settings.contact.cells_across = Some(Lattice::across(scene.tyre.contact_width, settings.cell_length));
    },
    values: &[8.0, 4.0, 2.0, 1.33],
    label: |settings| format!("{:.2} mm", 1e3 * settings.cell_length),
};
/// \[m\]
const CURVES: Row = Row {
    name: "slice tolerance",
    turn: |settings, tolerance, _| settings.contact.slice_tolerance = tolerance,
    values: &[1e-7, 3e-7, 1e-6, 1e-5],
    label: |settings| format!("{:.0e} m", settings.contact.slice_tolerance),
};

/// The knobs that a scene can have, in the order of the tables; of an outline every second value.
pub(crate) fn knobs(scene: &Scene, reference: &Settings, highest: f64, is_outline: bool) -> Vec<Knob> {
    // 1. The rows of the table that apply, each with its time rule.
    let rule_of_reference = reference.numerics.time_rule;
    let mut rows = vec![(ELEMENTS, rule_of_reference), (SUBSTEPS, rule_of_reference)];
    let others = TimeRule::ALL.into_iter().filter(|&rule| rule != rule_of_reference);
    rows.extend(others.map(|rule| (Row { name: rule.name(), values: &[1.0, 2.0, 4.0], ..SUBSTEPS }, rule)));
    rows.push((POLES, rule_of_reference));
    let has_cells = reference.contact.cells_across.is_some_and(|points| points > 1);
    if reference.contact.zone == Zone::Cells {
        rows.push((CELLS, rule_of_reference));
    } else if scene.road.varies_across() && scene.effects.texture != Switch::Off {
        rows.extend(has_cells.then_some((CELLS_OF_SLICES, rule_of_reference)));
        rows.push((CURVES, rule_of_reference));
    }
    // 2. Their values, as far as they are coarser than the reference. A step too long for the highest bands gives no
    //    level there.
    let knob = |(row, rule): (Row, TimeRule)| {
        let changed = row.values.iter().map(|&value| {
            reference.with(|settings| {
                settings.numerics.time_rule = rule;
                (row.turn)(settings, value, scene);
            })
        });
        let possible = changed.filter(|settings| {
            is_coarser(settings, reference)
                && settings.numerics.elements >= Numerics::FEWEST_ELEMENTS
                && settings.rate(scene) >= least_rate(highest)
        });
        let (skipped, every) = if is_outline { (1, 2) } else { (0, 1) };
        let steps = possible.skip(skipped).step_by(every).map(|settings| ((row.label)(&settings), settings));
        Knob { name: row.name, steps: steps.collect(), points: Vec::new(), missing: None }
    };
    rows.into_iter().map(knob).collect()
}

fn is_coarser(settings: &Settings, reference: &Settings) -> bool {
    settings.numerics.elements < reference.numerics.elements
        || settings.numerics.substeps < reference.numerics.substeps
        || settings.numerics.elements_per_step > reference.numerics.elements_per_step
        || settings.numerics.pole_tolerance > reference.numerics.pole_tolerance
        || settings.contact.slice_tolerance > reference.contact.slice_tolerance
        || settings.contact.cells_across < reference.contact.cells_across
}

/// The reference with half of its elements, steps and cells; the steps of an element stay.
pub(crate) fn half(reference: &Settings, scene: &Scene) -> Settings {
    reference.with(|settings| {
        settings.numerics.elements /= 2;
        match reference.contact.cells_across {
            Some(2..) if reference.contact.zone == Zone::Cells => (CELLS.turn)(settings, 0.5, scene),
            Some(2..) => (CELLS_OF_SLICES.turn)(settings, 2.0, scene),
            _ => {}
        }
    })
}
