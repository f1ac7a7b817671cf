//! The rows of the table behind `preset` and `accuracy` as settings of a scene.

use crate::plan::decisions::square_cells;
use crate::plan::front::FrontRow;
use crate::plan::resolution::{Need, Resolution};
use crate::scene::{History, Road, Scene, Zone};
use crate::study::accuracy::knobs::{Kind, Knob};
use crate::study::accuracy::settings::Settings;

/// Coarsest tolerance of the poles that a scene may ask for.
const COARSEST_POLES: f64 = 1e-2;

/// Settings that a row of the table chooses for a scene up to `highest` \[Hz\].
pub(crate) fn settings(scene: &Scene, row: &'static FrontRow, highest: f64) -> Settings {
    let mut settings = Settings::of(scene);
    let Settings { numerics, contact, cell_length } = &mut settings;
    let need = Need { highest, row: Some(row) };
    let (length, speed) = (scene.tyre.circumference, scene.rolling.speed());
    let Resolution { elements, substeps } = Resolution::new(need, length, speed, row.time_rule, None, None);
    (numerics.elements, numerics.substeps, numerics.time_rule) = (elements, substeps, row.time_rule);
    (numerics.history, numerics.pole_tolerance) = (History::Modal, row.pole_tolerance);
    (numerics.lateral_terms, numerics.wavenumber_aliases) = (None, None);
    let width = scene.tyre.contact_width;
    if contact.zone == Zone::Cells {
        numerics.contact_tolerance = row.cell_tolerance;
        contact.cells_across = Some(square_cells(&scene.tyre, elements));
        return settings;
    }
    *cell_length = row.cell_for(scene, highest);
    contact.cells_across = contact.cells_across.map(|_| Road::cells(width, *cell_length));
    contact.slice_tolerance = row.slice_tolerance;
    settings
}

/// The settings of all rows, by preset name.
pub(crate) fn named(scene: &Scene, highest: f64) -> Vec<(String, Settings)> {
    let rows = FrontRow::all(scene.contact.zone).iter();
    rows.map(|row| (row.preset.name().to_owned(), settings(scene, row, highest))).collect()
}

/// Settings next to each of `named`, with one quantity changed up or down: towards more accuracy or less work.
pub(crate) fn neighbours(named: &[(String, Settings)]) -> Vec<Knob> {
    named
        .iter()
        .map(|(name, base)| {
            let mut steps = Vec::new();
            let mut add = |what: &str, turn: &dyn Fn(&mut Settings)| steps.push((what.to_owned(), base.with(turn)));
            let Settings { numerics, contact, .. } = base;
            let elements = |up: usize, down: usize| (numerics.elements * up / down).div_ceil(2) * 2;
            add("fewer elements", &|settings| settings.numerics.elements = elements(3, 4));
            add("more elements", &|settings| settings.numerics.elements = elements(4, 3));
            if numerics.substeps > 1 {
                add("fewer steps", &|settings| settings.numerics.substeps -= 1);
            }
            add("more steps", &|settings| settings.numerics.substeps += 1);
            // Poles hardly matter in either, except that fewer are cheaper.
            let poles = (10.0 * numerics.pole_tolerance).min(COARSEST_POLES);
            add("fewer poles", &|settings| settings.numerics.pole_tolerance = poles);
            if let Some(points) = contact.cells_across.filter(|&points| points > 1) {
                add("larger cells", &|settings| {
                    settings.cell_length *= 2.0;
                    settings.contact.cells_across = Some(points.div_ceil(2));
                });
            }
            Knob::new(&format!("around {name}"), Kind::Neighbour, None, Ok(steps))
        })
        .collect()
}
