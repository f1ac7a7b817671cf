//! Third-octave levels side by side.

use crate::response::{BandLevel, ThirdOctaveBand};
use crate::study::trial::{LOWEST_BAND, level_changes};
use serde::Serialize;

/// Levels that differ by less count as equal \[dB\]: the error that the accuracy `standard` states, and about the
/// smallest audible difference.
pub(super) const INSIGNIFICANT: f64 = 1.0;

/// Change of a level in a band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Change {
    /// Nominal mid-frequency \[Hz\].
    pub frequency: f64,
    /// Change of the level \[dB\].
    pub change: f64,
}

/// Changes from a reference, from 100 Hz up to the band that contains `highest` \[Hz\]; bands that are silent in one of
/// them are left out.
pub(super) fn changes(found: &[BandLevel], reference: &[BandLevel], highest: f64) -> Vec<Change> {
    let highest = ThirdOctaveBand::containing(highest).map_or(highest, ThirdOctaveBand::upper_edge);
    let within = |level: &BandLevel| (LOWEST_BAND..=highest).contains(&level.band.nominal_frequency());
    level_changes(found, reference)
        .filter(|(level, change)| within(level) && change.is_finite())
        .map(|(level, change)| Change { frequency: level.band.nominal_frequency(), change })
        .collect()
}

/// Mean of the changes \[dB\]; NaN without any.
pub(super) fn mean(changes: &[Change]) -> f64 {
    changes.iter().map(|change| change.change).sum::<f64>() / changes.len() as f64
}

/// The change with the largest value of `measure`; NaN without any.
pub(super) fn largest(changes: &[Change], measure: fn(f64) -> f64) -> Change {
    let none = Change { frequency: f64::NAN, change: f64::NAN };
    changes.iter().copied().max_by(|a, b| measure(a.change).total_cmp(&measure(b.change))).unwrap_or(none)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_those_of_the_bands_looked_at() {
        let levels = |level: &dyn Fn(f64) -> f64| -> Vec<BandLevel> {
            (-13..4)
                .map(ThirdOctaveBand)
                .map(|band| {
                    let level = level(band.nominal_frequency());
                    BandLevel { band, mean_square: 1.0, level, valid: true }
                })
                .collect()
        };
        let bent = |f: f64| if f > 790.0 && f < 810.0 { -7.0 } else { 2.0 };
        let silent = |f: f64| if f > 190.0 && f < 210.0 { f64::NEG_INFINITY } else { bent(f) };
        let found = changes(&levels(&silent), &levels(&|_| 0.0), 1000.0);
        assert!(found.len() == 10 && found[0].frequency > 99.0 && found[9].frequency < 1001.0, "{found:?}");
        assert!((mean(&found) - 1.1).abs() < 1e-12);
        assert!((largest(&found, f64::abs).frequency - 800.0).abs() < 1e-9);
        assert!((largest(&found, |change| change).change - 2.0).abs() < 1e-12);
        assert!(mean(&[]).is_nan() && largest(&[], f64::abs).change.is_nan());
    }
}
