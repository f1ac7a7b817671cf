//! The rows of the table behind `preset` and `accuracy` as settings of a scene, and whether they are what they say.

use serde::Serialize;

use crate::plan::front::FrontRow;
use crate::plan::resolution::{Need, Resolution};
use crate::scene::{History, Preset, Road, Scene};
use crate::study::accuracy::front::excess;
use crate::study::accuracy::knobs::{Kind, Knob};
use crate::study::accuracy::settings::Settings;
use crate::study::accuracy::{Point, Study};

/// How much more work a preset may take than the cheapest settings found that are as accurate. Errors of elements,
/// steps and cells have different signs, and here and there two of them cancel (measured on dense asphalt at 80 km/h:
/// 2.1, 1.2 and 1.9 times for the three presets).
pub const LARGEST_EXCESS: f64 = 2.5;

/// Coarsest tolerance of the poles that a scene may ask for.
const COARSEST_POLES: f64 = 1e-2;

/// The settings that a row chooses for a scene up to `highest` \[Hz\].
pub fn settings(scene: &Scene, row: &'static FrontRow, highest: f64) -> Settings {
    let own = Settings::of(scene);
    let need = Need { highest, row: Some(row) };
    let cell = row.cell_for(scene, highest);
    let (length, speed) = (scene.tyre.circumference, scene.rolling.speed());
    let Resolution { elements, substeps } = Resolution::new(need, length, speed, row.time_rule, None, None);
    Settings {
        elements,
        substeps,
        time_rule: row.time_rule,
        history: History::Modal,
        pole_tolerance: row.pole_tolerance,
        lateral_terms: None,
        wavenumber_aliases: None,
        cells_across: own.cells_across.map(|_| Road::cells(scene.tyre.contact_width, cell)),
        cell_length: cell,
        slice_tolerance: row.slice_tolerance,
        ..own
    }
}

/// All rows with their names.
pub fn named(scene: &Scene, highest: f64) -> Vec<(String, Settings)> {
    FrontRow::ALL.iter().map(|row| (row.preset.name().to_owned(), settings(scene, row, highest))).collect()
}

/// Each of some settings with one of them turned either way: what is close to them on the way to more accuracy or less
/// work.
pub fn neighbours(named: &[(String, Settings)]) -> Vec<Knob> {
    named
        .iter()
        .map(|(name, base)| {
            let mut steps = Vec::new();
            let mut add = |what: &str, settings: Settings| steps.push((what.to_owned(), settings));
            let elements = |up: usize, down: usize| Settings {
                elements: (base.elements * up / down).div_ceil(2) * 2,
                ..base.clone()
            };
            add("fewer elements", elements(3, 4));
            add("more elements", elements(4, 3));
            if base.substeps > 1 {
                add("fewer steps", Settings { substeps: base.substeps - 1, ..base.clone() });
            }
            add("more steps", Settings { substeps: base.substeps + 1, ..base.clone() });
            // Poles are hardly seen in either, but for fewer of them.
            add(
                "fewer poles",
                Settings { pole_tolerance: (10.0 * base.pole_tolerance).min(COARSEST_POLES), ..base.clone() },
            );
            if let Some(points) = base.cells_across.filter(|&points| points > 1) {
                let cell_length = 2.0 * base.cell_length;
                add("larger cells", Settings { cells_across: Some(points.div_ceil(2)), cell_length, ..base.clone() });
            }
            Knob { name: format!("around {name}"), kind: Kind::Neighbour, anchor: None, steps: Ok(steps) }
        })
        .collect()
}

/// What a study has found about a preset.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The preset.
    pub preset: Preset,
    /// Stated error \[dB\].
    pub stated: f64,
    /// Largest difference of a level found \[dB\].
    pub found: f64,
    /// Its work over that of the cheapest settings found that are as accurate.
    pub excess: f64,
}

impl Verdict {
    /// Whether the preset keeps its stated error.
    pub fn keeps_its_error(&self) -> bool {
        self.found <= self.stated
    }

    /// Whether it lies on the front, within [`LARGEST_EXCESS`].
    pub fn is_on_the_front(&self) -> bool {
        self.excess <= LARGEST_EXCESS
    }
}

/// The verdicts of a study in which the presets are named points.
pub fn verdicts(study: &Study) -> Vec<Verdict> {
    let points: Vec<(f64, f64)> = study.points().map(Study::coordinates).collect();
    let verdict = |row: &FrontRow| {
        let point: &Point = study.named.iter().find(|point| point.label == row.preset.name())?;
        let (found, stated) = (point.difference.worst, row.error);
        Some(Verdict { preset: row.preset, stated, found, excess: excess(Study::coordinates(point), &points) })
    };
    FrontRow::ALL.iter().filter_map(verdict).collect()
}
