//! Verdict on the presets: the errors found beside those stated.

use serde::Serialize;

use crate::plan::front::FrontRow;
use crate::scene::Preset;
use crate::study::accuracy::front::excess;
use crate::study::accuracy::{Point, Study};

/// How much more work a preset may take than the cheapest settings found that are as accurate. Errors of elements,
/// steps and cells have different signs, and here and there two of them cancel (measured on dense asphalt at 80 km/h:
/// 2.1, 1.2 and 1.9 times for the three presets).
pub(crate) const LARGEST_EXCESS: f64 = 2.5;

/// Findings of a study about a preset.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The judged preset.
    pub preset: Preset,
    /// Stated error \[dB\].
    pub stated: f64,
    /// Largest difference of a level found \[dB\].
    pub found: f64,
    /// Its work over that of the cheapest settings found that are as accurate; at least 1.
    pub excess: f64,
}

impl Verdict {
    /// True if the preset is within the error that it states.
    pub fn keeps_its_error(&self) -> bool {
        self.found <= self.stated
    }

    /// True if it lies on the front, within [`LARGEST_EXCESS`].
    pub(crate) fn is_on_the_front(&self) -> bool {
        self.excess <= LARGEST_EXCESS
    }
}

/// Verdicts on the presets among the named points of a study.
pub fn verdicts(study: &Study) -> Vec<Verdict> {
    let points: Vec<(f64, f64)> = study.points().map(Point::coordinates).collect();
    let verdict = |row: &FrontRow| {
        let point: &Point = study.named.iter().find(|point| point.label == row.preset.name())?;
        let (found, stated) = (point.difference.worst, row.error(study.options.highest)?);
        Some(Verdict { preset: row.preset, stated, found, excess: excess(point.coordinates(), &points) })
    };
    FrontRow::all(study.reference.settings.contact.zone).iter().filter_map(verdict).collect()
}
