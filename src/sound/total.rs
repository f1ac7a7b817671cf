//! Level of several third octaves together, and over which bands several of them may be compared.
//!
//! Runs differ in the bands that they vouch for, and a sum over a few bands is lower than one over all, whatever the
//! sound. Sums are therefore compared over the bands that all of them vouch for. No band can be taken out of a maximum
//! over time: maxima of different bands are not compared at all.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::covered::{CoveredBands, FOLLOWED, range};
use super::levels::energetic_sum;
use crate::response::{BandLevel, ThirdOctaveBand};

/// Level of several third octaves together, with the bands that it is made of.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct TotalLevel {
    /// Level of the bands that are vouched for \[dB\], or the maximum over time of what they make.
    pub level: f64,
    /// True of a maximum over time.
    pub is_maximum: bool,
    /// All bands, rising, also those that are not vouched for; of a maximum those of the mean.
    pub bands: Vec<BandLevel>,
    /// How far off the level may be \[dB\], where that is known.
    pub error: Option<f64>,
}

impl TotalLevel {
    /// Makes the sum of the bands that are vouched for; `None` where there is none.
    pub fn of(bands: Vec<BandLevel>) -> Option<Self> {
        let level = energetic_sum(bands.iter().filter(|band| band.valid).map(|band| band.level));
        let is_empty = !bands.iter().any(|band| band.valid);
        (!is_empty).then_some(Self { level, is_maximum: false, bands, error: None })
    }

    /// Returns a maximum over time in the place of this mean over the same bands.
    #[must_use]
    pub fn at_most(self, level: f64) -> Self {
        Self { level, is_maximum: true, ..self }
    }

    /// Returns the bands that are vouched for.
    fn valid(&self) -> impl Iterator<Item = &BandLevel> + Clone {
        self.bands.iter().filter(|band| band.valid)
    }

    /// Returns the bands of the level, and what those above may add; `None` of none.
    pub(crate) fn covered(&self) -> Option<CoveredBands> {
        CoveredBands::of(&self.valid().copied().collect::<Vec<_>>())
    }

    /// Tells whether the level is a lower bound: bands that matter may be missing.
    pub fn is_lower_bound(&self) -> bool {
        self.covered().is_none_or(|bands| bands.lower_bound)
    }

    /// Returns the level in words, `at least 43.7 +- 0.2`, without its unit.
    pub(crate) fn text(&self) -> String {
        let least = if self.is_lower_bound() { "at least " } else { "" };
        let error = self.error.map_or_else(String::new, |error| format!(" +- {error:.1}"));
        format!("{least}{:.1}{error}", self.level)
    }

    /// Returns the bands of the level in words, `25 Hz - 2 kHz`.
    pub(crate) fn range(&self) -> String {
        self.covered().map_or_else(String::new, |bands| bands.text())
    }

    /// Returns the loudest of all bands.
    fn loudest(&self) -> Option<ThirdOctaveBand> {
        self.bands.iter().max_by(|one, other| one.level.total_cmp(&other.level)).map(|band| band.band)
    }
}

/// Levels over the bands that all of several totals are vouched for in.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Compared {
    /// Their levels over these bands, in their order \[dB\].
    pub levels: Vec<f64>,
    /// First and last of the bands.
    pub bands: [ThirdOctaveBand; 2],
    /// True if these are all bands of each.
    pub all: bool,
    /// True if they hold the loudest band of each: what is missing above is not what the level is made of.
    pub hold_loudest: bool,
}

/// Why totals cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Apart {
    /// No band is vouched for in all of them.
    NoCommonBand,
    /// A maximum over time of other bands is among them.
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
    /// Compares some totals.
    ///
    /// # Errors
    /// [`Apart`].
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
        // Where it is the last one it may be on the way up, unless that is where tyres are loudest.
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

    /// Compares totals whose growth is asked for: their common bands reach the loudest.
    ///
    /// # Errors
    /// Why it is not known.
    pub(crate) fn for_growth(totals: &[&TotalLevel]) -> Result<Self, String> {
        let compared = Self::of(totals).map_err(|why| why.to_string())?;
        let unheld = || format!("the common bands, {}, do not reach the loudest", compared.range());
        if compared.hold_loudest { Ok(compared) } else { Err(unheld()) }
    }

    /// Returns the difference of a total from a reference \[dB\], and the bands where these are not all of both.
    ///
    /// # Errors
    /// [`Apart`].
    pub(crate) fn difference(found: &TotalLevel, reference: &TotalLevel) -> Result<(f64, Option<String>), Apart> {
        let compared = Self::of(&[found, reference])?;
        let bands = (!compared.all).then(|| compared.range());
        Ok((compared.levels[0] - compared.levels[1], bands))
    }

    /// Returns the nominal mid-frequency of the highest of the bands \[Hz\].
    pub(crate) fn highest_hz(&self) -> f64 {
        self.bands[1].nominal_frequency()
    }

    /// Returns the bands in words, `25 Hz - 80 Hz`.
    pub(crate) fn range(&self) -> String {
        let [lowest, highest] = self.bands.map(ThirdOctaveBand::nominal_frequency);
        range(lowest, highest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes the sum of bands from 25 Hz on that are vouched for up to one of them.
    fn total(valid_to: i32, level: impl Fn(i32) -> f64) -> TotalLevel {
        let band = |n: i32| {
            let level = level(n);
            BandLevel { band: ThirdOctaveBand(n), mean_square: 10.0_f64.powf(0.1 * level), level, valid: n <= valid_to }
        };
        TotalLevel::of((-16..=4).map(band).collect()).unwrap()
    }

    /// Returns a spectrum that is loudest at 800 Hz.
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
    fn maxima_over_time_are_compared_where_their_bands_are_the_same_and_not_at_all_else() {
        let maximum = |valid_to, level| TotalLevel { level, is_maximum: true, ..total(valid_to, tyre) };
        let (few, many, louder) = (maximum(-11, 14.8), maximum(3, 72.2), maximum(3, 74.2));
        assert_eq!(Compared::difference(&few, &many), Err(Apart::Maximum));
        let (difference, bands) = Compared::difference(&louder, &many).unwrap();
        assert!((difference - 2.0).abs() < 1e-9 && bands.is_none());
        assert_eq!(TotalLevel::of(total(-16, tyre).bands.split_off(1)), None, "no band is vouched for");
    }

    #[test]
    fn bands_that_end_on_the_way_up_do_not_hold_the_loudest_below_1_khz() {
        let rising = |n: i32| f64::from(n);
        for (last, held) in [(-3, false), (0, true)] {
            let mut cut = total(last, rising);
            cut.bands.retain(|band| band.valid);
            assert_eq!(Compared::of(&[&cut, &cut]).unwrap().hold_loudest, held, "{last}");
        }
        // Louder bands above, which are not vouched for.
        assert!(!Compared::of(&[&total(0, rising)]).unwrap().hold_loudest);
        assert_eq!(Compared::of(&[]), Err(Apart::NoCommonBand));
    }
}
