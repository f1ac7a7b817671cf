//! Errors of the levels of a spectrum: the numerical one, and that of slices beside cells.

use super::slice_errors::{Part, SliceErrors};
use super::spectrum::BandLevel;
use super::third_octave::ThirdOctaveBand;

/// Errors of levels, as far as they are known.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LevelErrors {
    /// Frequency \[Hz\] from which on the numerical error of valid levels is known, and that error \[dB\].
    pub numerical: Option<(f64, f64)>,
    /// Errors by slices \[dB\].
    pub slices: Vec<(ThirdOctaveBand, f64)>,
}

impl LevelErrors {
    /// Returns both errors; `part` tells which of those by slices.
    pub(crate) fn new(numerical: Option<(f64, f64)>, slices: Option<&SliceErrors>, part: Part) -> Self {
        Self { numerical, slices: SliceErrors::by_band(slices, part) }
    }

    /// Returns the numerical error in a band \[dB\].
    pub(crate) fn numerical(&self, band: ThirdOctaveBand) -> Option<f64> {
        self.numerical.filter(|(from, _)| band.mid_frequency() >= *from).map(|(_, error)| error)
    }

    /// Returns the error by slices in a band \[dB\].
    pub(crate) fn by_slices(&self, band: ThirdOctaveBand) -> Option<f64> {
        self.slices.iter().find(|(of, _)| *of == band).map(|(_, error)| *error)
    }

    /// Adds up what is known of a band \[dB\].
    pub(crate) fn total(&self, band: ThirdOctaveBand) -> Option<f64> {
        let known = [self.numerical(band), self.by_slices(band)];
        known.into_iter().flatten().reduce(|own, slices| own + slices)
    }

    /// Finds the largest error by slices of the valid ones among some levels \[dB\].
    pub(crate) fn largest_by_slices(&self, levels: &[BandLevel]) -> Option<f64> {
        let valid = levels.iter().filter(|level| level.valid);
        valid.filter_map(|level| self.by_slices(level.band)).reduce(f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_adds_up_and_valid_levels_alone_count() {
        let band = ThirdOctaveBand;
        let slices = SliceErrors::new(5e-4, 2.0, band(-2), &[1.0, 2.0, 2.5], &[3.0; 3]);
        let errors = LevelErrors::new(Some((band(-1).mid_frequency(), 0.5)), Some(&slices), SliceErrors::force);
        assert_eq!([-3, -2, -1, 1].map(|n| errors.total(band(n))), [None, Some(1.0), Some(2.5), Some(0.5)]);
        let level = |n: i32| BandLevel { band: band(n), mean_square: 1.0, level: 0.0, valid: n < 0 };
        assert_eq!(errors.largest_by_slices(&[-2, -1, 0].map(level)), Some(2.0));
        assert_eq!(LevelErrors::default().total(band(-1)), None);
    }
}
