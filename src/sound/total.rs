//! Level of several third octaves together, and the bands over which several of them may be compared.
//!
//! Runs differ in their valid bands, and a sum over a few bands is lower than one over all, whatever the sound. Sums
//! are therefore compared over the bands that are valid in all of them. No band can be taken out of a maximum over
//! time: maxima of different bands are not compared at all.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::covered::{CoveredBands, FOLLOWED, range};
use super::levels::energetic_sum;
use crate::response::{BandLevel, ThirdOctaveBand};

/// Level of several third octaves together, with its bands.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct TotalLevel {
    /// Level of the sum of the valid bands \[dB\], or the maximum over time of that sum.
    pub level: f64,
    /// True for a maximum over time.
    pub is_maximum: bool,
    /// All bands, rising, also those that are not valid; for a maximum those of the mean.
    pub bands: Vec<BandLevel>,
    /// Error of the level \[dB\], where it is known.
    pub error: Option<f64>,
}

impl TotalLevel {
    /// Sum of the valid bands; `None` where there is none.
    pub fn of(bands: Vec<BandLevel>) -> Option<Self> {
        let level = energetic_sum(bands.iter().filter(|band| band.valid).map(|band| band.level));
        let is_empty = !bands.iter().any(|band| band.valid);
        (!is_empty).then_some(Self { level, is_maximum: false, bands, error: None })
    }

    /// A maximum over time \[dB\] in place of this mean, over the same bands.
    #[must_use]
    pub fn at_most(self, level: f64) -> Self {
        Self { level, is_maximum: true, ..self }
    }

    fn valid(&self) -> impl Iterator<Item = &BandLevel> + Clone {
        self.bands.iter().filter(|band| band.valid)
    }

    /// Range of the level's bands, and what those above may add; `None` without bands.
    pub(crate) fn covered(&self) -> Option<CoveredBands> {
        CoveredBands::of(&self.valid().copied().collect::<Vec<_>>())
    }

    /// True if the level is a lower bound: bands that matter may be missing.
    pub fn is_lower_bound(&self) -> bool {
        self.covered().is_none_or(|bands| bands.lower_bound)
    }

    /// The level in words, `at least 43.7 +- 0.2`, without its unit.
    pub(crate) fn text(&self) -> String {
        let least = if self.is_lower_bound() { "at least " } else { "" };
        let error = self.error.map_or_else(String::new, |error| format!(" +- {error:.1}"));
        format!("{least}{:.1}{error}", self.level)
    }

    /// The range of the level's bands in words, `25 Hz - 2 kHz`.
    pub(crate) fn range(&self) -> String {
        self.covered().map_or_else(String::new, |bands| bands.text())
    }

    /// Loudest of all bands, also of those that are not valid.
    fn loudest(&self) -> Option<ThirdOctaveBand> {
        self.bands.iter().max_by(|one, other| one.level.total_cmp(&other.level)).map(|band| band.band)
    }
}

/// Levels of several totals over the bands that are valid in all of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Compared {
    /// Levels over these bands, in the order of the totals \[dB\].
    pub levels: Vec<f64>,
    /// First and last of the bands.
    pub bands: [ThirdOctaveBand; 2],
    /// True if these are all valid bands of each.
    pub all: bool,
    /// True if they hold the loudest band of each, so that the missing bands do not determine the level.
    pub hold_loudest: bool,
}

/// Reason why totals cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Apart {
    /// No band is valid in all of them.
    NoCommonBand,
    /// One of them is a maximum over time of other bands.
    Maximum,
}

impl fmt::Display for Apart {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::NoCommonBand => "no common band",
            Self::Maximum => "maxima of different bands",
        })
    }
}

impl Compared {
    /// Compares some totals; an error if they have no common band or are maxima of different bands.
    pub(crate) fn of(totals: &[&TotalLevel]) -> Result<Self, Apart> {
        let (first, others) = totals.split_first().ok_or(Apart::NoCommonBand)?;
        let has = |total: &TotalLevel, band: ThirdOctaveBand| total.valid().any(|other| other.band == band);
        let common: Vec<ThirdOctaveBand> =
            first.valid().map(|of| of.band).filter(|band| others.iter().all(|total| has(total, *band))).collect();
        let (Some(&lowest), Some(&highest)) = (common.first(), common.last()) else { return Err(Apart::NoCommonBand) };
        let is_whole = |total: &TotalLevel| total.valid().count() == common.len();
        let over = |total: &&TotalLevel| match (is_whole(total), total.is_maximum) {
            (true, _) => Ok(total.level),
            (false, true) => Err(Apart::Maximum),
            (false, false) => {
                let bands = total.valid().filter(|of| common.contains(&of.band));
                Ok(energetic_sum(bands.map(|of| of.level)))
            }
        };
        // Where the loudest is the last one, the spectrum may still rise, unless that is where tyres are loudest.
        let is_held = |total: &&TotalLevel| {
            let held = |loudest| common.contains(&loudest) && (loudest < highest || highest >= FOLLOWED);
            total.loudest().is_some_and(held)
        };
        Ok(Self {
            levels: totals.iter().map(over).collect::<Result<_, _>>()?,
            bands: [lowest, highest],
            all: totals.iter().all(|total| is_whole(total)),
            hold_loudest: totals.iter().all(is_held),
        })
    }

    /// Compares totals for their growth with the speed; an error also where the common bands do not reach the loudest.
    pub(crate) fn for_growth(totals: &[&TotalLevel]) -> Result<Self, String> {
        let compared = Self::of(totals).map_err(|why| why.to_string())?;
        let unheld = || format!("the common bands, {}, do not reach the loudest", compared.range());
        if compared.hold_loudest { Ok(compared) } else { Err(unheld()) }
    }

    /// Difference of a total from a reference \[dB\], and the common bands where these are not all bands of both.
    pub(crate) fn difference(found: &TotalLevel, reference: &TotalLevel) -> Result<(f64, Option<String>), Apart> {
        let compared = Self::of(&[found, reference])?;
        let bands = (!compared.all).then(|| compared.range());
        Ok((compared.levels[0] - compared.levels[1], bands))
    }

    /// Nominal mid-frequency of the highest of the bands \[Hz\].
    pub(crate) fn highest_hz(&self) -> f64 {
        self.bands[1].nominal_frequency()
    }

    /// The bands in words, `25 Hz - 80 Hz`.
    pub(crate) fn range(&self) -> String {
        let [lowest, highest] = self.bands.map(ThirdOctaveBand::nominal_frequency);
        range(lowest, highest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of bands from 25 Hz on that are valid up to one of them.
    fn total(valid_to: i32, level: impl Fn(i32) -> f64) -> TotalLevel {
        let band = |n: i32| {
            let level = level(n);
            BandLevel { band: ThirdOctaveBand(n), mean_square: 10.0_f64.powf(0.1 * level), level, valid: n <= valid_to }
        };
        TotalLevel::of((-16..=4).map(band).collect()).unwrap()
    }

    /// A spectrum that is loudest at 800 Hz.
    fn tyre(n: i32) -> f64 {
        60.0 - 3.0 * f64::from((n + 1).abs())
    }

    #[test]
    fn a_sum_of_few_bands_is_compared_with_one_of_many_over_the_few() {
        let (few, many) = (total(-11, |n| tyre(n) + 1.0), total(3, tyre));
        assert!(many.level - few.level > 25.0 && few.is_lower_bound() && !many.is_lower_bound());
        assert_eq!((few.range().as_str(), many.range().as_str()), ("25 Hz - 80 Hz", "25 Hz - 2 kHz"));
        assert!(few.text().starts_with("at least ") && !many.text().contains("least"));
        let (difference, bands) = Compared::difference(&few, &many).unwrap();
        assert!((difference - 1.0).abs() < 1e-9, "{difference}");
        assert_eq!(bands.as_deref(), Some("25 Hz - 80 Hz"));
        let compared = Compared::of(&[&few, &many]).unwrap();
        assert!(!compared.hold_loudest && !compared.all);
        let whole = Compared::of(&[&many, &many]).unwrap();
        assert!(whole.hold_loudest && whole.all);
        assert_eq!(Compared::difference(&many, &many), Ok((0.0, None)));
    }

    #[test]
    fn maxima_over_time_are_compared_over_equal_bands_only() {
        let maximum = |valid_to, level| TotalLevel { level, is_maximum: true, ..total(valid_to, tyre) };
        let (few, many, louder) = (maximum(-11, 14.8), maximum(3, 72.2), maximum(3, 74.2));
        assert_eq!(Compared::difference(&few, &many), Err(Apart::Maximum));
        let (difference, bands) = Compared::difference(&louder, &many).unwrap();
        assert!((difference - 2.0).abs() < 1e-9 && bands.is_none());
        assert_eq!(TotalLevel::of(total(-16, tyre).bands.split_off(1)), None, "no band is valid");
    }

    #[test]
    fn rising_bands_do_not_hold_the_loudest_below_1_khz() {
        let rising = |n: i32| f64::from(n);
        for (last, held) in [(-3, false), (0, true)] {
            let mut cut = total(last, rising);
            cut.bands.retain(|band| band.valid);
            assert_eq!(Compared::of(&[&cut, &cut]).unwrap().hold_loudest, held, "{last}");
        }
        // Louder bands above, which are not valid.
        assert!(!Compared::of(&[&total(0, rising)]).unwrap().hold_loudest);
        assert_eq!(Compared::of(&[]), Err(Apart::NoCommonBand));
    }
}
