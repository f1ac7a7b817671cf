//! Errors of the levels of a spectrum: the numerical one, and that of slices beside cells.

use super::slice_errors::{Part, SliceErrors};
use super::spectrum::BandLevel;
use super::third_octave::ThirdOctaveBand;

/// Errors of levels, as far as they are known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelErrors {
    /// Frequency \[Hz\] from which on the numerical error of valid levels is known, and that error \[dB\].
    pub numerical: Option<(f64, f64)>,
    /// Errors by slices \[dB\].
    pub slices: BySlices,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub enum BySlices {
    /// There are none: contact over cells, or a road without texture across.
    #[default]
    None,
    /// There are some, and they are known in these bands alone \[dB\].
    Known(Vec<(ThirdOctaveBand, f64)>),
}

impl BySlices {
    /// Error in a band \[dB\]: 0 without slices, `None` where it is not known.
    pub(crate) fn in_band(&self, band: ThirdOctaveBand) -> Option<f64> {
        match self {
            Self::None => Some(0.0),
            Self::Known(errors) => errors.iter().find(|(of, _)| *of == band).map(|(_, error)| *error),
        }
    }
}

/// Largest part of the energy of an overall level that bands of unknown error may hold, if the overall level is to have
/// an error: without them it is 0.05 dB lower, less than is shown.
const UNKNOWN_PART: f64 = 0.0115;

impl LevelErrors {
    /// Errors with the numerical one, and with one by slices if the run has any (`by_slices`); `part` selects force or
    /// sound.
    pub fn new(numerical: Option<(f64, f64)>, by_slices: bool, slices: Option<&SliceErrors>, part: Part) -> Self {
        let known = || BySlices::Known(SliceErrors::by_band(slices, part));
        Self { numerical, slices: if by_slices { known() } else { BySlices::None } }
    }

    /// Numerical error in a band \[dB\], where it is known.
    pub(crate) fn numerical(&self, band: ThirdOctaveBand) -> Option<f64> {
        self.numerical.filter(|(from, _)| band.mid_frequency() >= *from).map(|(_, error)| error)
    }

    /// Error by slices in a band \[dB\]; `None` where it is not known or there are no slices.
    pub(crate) fn by_slices(&self, band: ThirdOctaveBand) -> Option<f64> {
        self.slices.in_band(band).filter(|_| self.slices != BySlices::None)
    }

    /// Sum of both errors in a band \[dB\]; `None` where one of them is not known.
    pub(crate) fn total(&self, band: ThirdOctaveBand) -> Option<f64> {
        Some(self.numerical(band)? + self.slices.in_band(band)?)
    }

    /// Largest error by slices \[dB\] among the valid levels.
    pub(crate) fn largest_by_slices(&self, levels: &[BandLevel]) -> Option<f64> {
        let valid = levels.iter().filter(|level| level.valid);
        valid.filter_map(|level| self.by_slices(level.band)).reduce(f64::max)
    }

    /// Error of the overall level \[dB\], the sum over the valid `levels`: its numerical one plus the largest by
    /// slices. `None` where `numerical` is, or where bands of unknown error hold more than about a hundredth of the
    /// energy.
    pub(crate) fn overall(&self, numerical: Option<f64>, levels: &[BandLevel]) -> Option<f64> {
        let sum = |bands: &mut dyn Iterator<Item = &BandLevel>| bands.map(|level| level.mean_square).sum::<f64>();
        let valid = || levels.iter().filter(|level| level.valid);
        let unknown = sum(&mut valid().filter(|level| self.total(level.band).is_none()));
        let is_known = unknown <= UNKNOWN_PART * sum(&mut valid());
        Some(numerical.filter(|_| is_known)? + self.largest_by_slices(levels).unwrap_or(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_error_makes_the_sum_unknown() {
        let band = ThirdOctaveBand;
        let slices = SliceErrors::new(5e-4, 2.0, band(-2), &[1.0, 2.0, 2.5], &[3.0; 3]);
        let of = |numerical, by_slices, slices| LevelErrors::new(numerical, by_slices, slices, SliceErrors::force);
        let errors = of(Some((band(-1).mid_frequency(), 0.5)), true, Some(&slices));
        assert_eq!([-3, -2, -1, 1].map(|n| errors.total(band(n))), [None, None, Some(2.5), None]);
        let level = |n: i32| BandLevel { band: band(n), mean_square: 1.0, level: 0.0, valid: n < 0 };
        assert_eq!(errors.largest_by_slices(&[-2, -1, 0].map(level)), Some(2.0));
        assert_eq!(LevelErrors::default().total(band(-1)), None);
        assert_eq!(of(Some((0.0, 0.5)), false, None).total(band(-1)), Some(0.5), "cells have no error by slices");
        assert_eq!(of(Some((0.0, 0.5)), true, None).total(band(-1)), None, "that of slices is not known");
        assert_eq!(of(None, true, Some(&slices)).total(band(-1)), None, "that of elements is not known");
    }

    #[test]
    fn an_overall_level_has_an_error_if_its_main_bands_have() {
        let level = |(n, power): (i32, f64)| BandLevel {
            band: ThirdOctaveBand(n),
            mean_square: power,
            level: 10.0 * power.log10(),
            valid: n < 0,
        };
        let errors = LevelErrors { numerical: Some((100.0, 0.5)), slices: BySlices::None };
        // 80 Hz holds a thousandth, and half of the energy.
        let [quiet, loud] = [1e-3, 1.0].map(|low| [(-11, low), (-3, 1.0), (0, 5.0)].map(level));
        assert_eq!([&quiet, &loud].map(|levels| errors.overall(Some(0.4), levels)), [Some(0.4), None]);
        assert_eq!(errors.overall(None, &quiet), None);
        let slices = BySlices::Known(vec![(ThirdOctaveBand(-3), 2.0)]);
        let by_slices = LevelErrors { slices, ..errors };
        assert_eq!(by_slices.overall(Some(0.4), &quiet), Some(2.4));
        let low = [(-11, 1.0), (-10, 1.0)].map(level);
        assert_eq!(by_slices.overall(Some(0.4), &low), None, "bands below all of which an error is known");
    }
}
