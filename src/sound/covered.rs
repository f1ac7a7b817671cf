//! Third octaves of an overall level, and an estimate of what those above them may add.
//!
//! A run ends at a highest frequency, a tyre's sound does not. With L_i the A-weighted levels of the last three bands,
//! s = (L_3 - L_1)/2 their slope per band, and L = (L_1 + L_2 + L_3)/3 + s the last one's level on the line through
//! them, what is missing up to 10 kHz is estimated by extrapolating that line:
//!
//! ```text
//! 10 lg(1 + sum_(k >= 1) 10^((L + k s)/10) / sum_i 10^(L_i/10))
//! ```
//!
//! Where the last bands do not fall there is no bound, and where they end below 1 kHz the line says little about what a
//! road excites above: for a level over 500 Hz alone, 2.0 dB below that up to 2 kHz, the estimate was 0.13 dB. Below
//! the first band the A-weighting leaves nothing.

use serde::{Deserialize, Serialize};

use crate::response::{BandLevel, ThirdOctaveBand};

/// Estimate of the missing part above which an overall level is a lower bound \[dB\].
const MATTERS: f64 = 0.5;
/// Number of bands that define the slope.
const LAST: usize = 3;
/// Lowest last band whose slope is extrapolated, 1 kHz: a level that ends below is a lower bound.
pub(super) const FOLLOWED: ThirdOctaveBand = ThirdOctaveBand(0);
/// Band up to which the line is extrapolated: 10 kHz.
const HIGHEST: ThirdOctaveBand = ThirdOctaveBand(10);

/// Range of bands of an overall level.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct CoveredBands {
    /// Nominal mid-frequency of the first band \[Hz\].
    pub lowest: f64,
    /// Nominal mid-frequency of the last band \[Hz\].
    pub highest: f64,
    /// Estimate of what the bands above would add \[dB(A)\]; `None` where the last ones do not fall, and below 1 kHz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missing: Option<f64>,
    /// True if the level is a lower bound: more than half a decibel may be missing, or there is no estimate.
    pub lower_bound: bool,
}

impl CoveredBands {
    /// Coverage of A-weighted bands, which must rise; `None` for an empty list.
    pub(crate) fn of(a_weighted: &[BandLevel]) -> Option<Self> {
        let (first, last) = (a_weighted.first()?.band, a_weighted.last()?.band);
        let [lowest, highest] = [first, last].map(ThirdOctaveBand::nominal_frequency);
        let missing = if last >= HIGHEST { Some(0.0) } else { missing(a_weighted).filter(|_| last >= FOLLOWED) };
        Some(Self { lowest, highest, missing, lower_bound: missing.is_none_or(|missing| missing > MATTERS) })
    }

    /// The range in words, `25 Hz - 2 kHz`.
    pub(crate) fn text(&self) -> String {
        range(self.lowest, self.highest)
    }

    /// Reason why the level is a lower bound, if it is.
    pub(crate) fn lower_bound_reason(&self) -> Option<String> {
        self.lower_bound.then(|| match self.missing {
            Some(missing) => {
                format!("a lower bound: by the slope of the last three bands those above add {missing:.1} dB")
            }
            None if self.highest < FOLLOWED.nominal_frequency() => {
                "a lower bound: it ends below 1 kHz, nothing is known of the bands above".to_owned()
            }
            None => "a lower bound: the last three bands do not fall, nothing is known of those above".to_owned(),
        })
    }
}

/// Range between two nominal mid-frequencies \[Hz\] in words: `25 Hz - 2 kHz`.
pub(super) fn range(lowest: f64, highest: f64) -> String {
    let frequency = |hertz: f64| if hertz < 1000.0 { format!("{hertz} Hz") } else { format!("{} kHz", hertz / 1000.0) };
    format!("{} - {}", frequency(lowest), frequency(highest))
}

fn missing(bands: &[BandLevel]) -> Option<f64> {
    let power = |level: f64| 10.0_f64.powf(0.1 * level);
    let all: f64 = bands.iter().map(|band| power(band.level)).sum();
    if all <= 0.0 {
        return Some(0.0);
    }
    let (_, last) = bands.split_at_checked(bands.len().checked_sub(LAST)?)?;
    let slope = (last[LAST - 1].level - last[0].level) / (LAST - 1) as f64;
    // Silence has no slope.
    if slope.is_nan() || slope >= 0.0 {
        return None;
    }
    let middle = last.iter().map(|band| band.level).sum::<f64>() / LAST as f64;
    let above = 1..=HIGHEST.0 - last[LAST - 1].band.0;
    let above = above.map(|band| power(middle + slope * (f64::from(band) + 0.5 * (LAST - 1) as f64)));
    Some(10.0 * (1.0 + above.sum::<f64>() / all).log10())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sound::levels::{energetic_sum, mean_square};

    /// Bands from 25 Hz on with these levels.
    fn bands(last: i32, level: impl Fn(i32) -> f64) -> Vec<BandLevel> {
        let band = |n: i32| {
            let level = level(n);
            BandLevel { band: ThirdOctaveBand(n), mean_square: mean_square(level), level, valid: true }
        };
        (-16..=last).map(band).collect()
    }

    #[test]
    fn an_overall_level_states_its_bands_and_those_missing() {
        // A noise that is equally loud in every band up to 1 kHz, and falls by 3 dB a band above.
        let noise = |n: i32| 70.0 - 3.0 * f64::from(n.max(0));
        let exact = energetic_sum(bands(10, noise).iter().map(|band| band.level));
        for (last, text) in [(3, "25 Hz - 2 kHz"), (5, "25 Hz - 3.15 kHz")] {
            let cut = bands(last, noise);
            let covered = CoveredBands::of(&cut).unwrap();
            let missing = exact - energetic_sum(cut.iter().map(|band| band.level));
            assert!((covered.missing.unwrap() - missing).abs() < 1e-9, "{covered:?} for {missing}");
            assert_eq!((covered.text().as_str(), covered.lower_bound), (text, false));
            assert_eq!(covered.lower_bound_reason(), None);
        }
        // Cut where it is loudest nothing is known of the rest.
        let cut = CoveredBands::of(&bands(0, noise)).unwrap();
        assert!(
            cut.lower_bound && cut.missing.is_none() && cut.lower_bound_reason().unwrap().contains("do not fall"),
            "{cut:?}"
        );
        // A gentle slope leaves more than half a decibel.
        let gentle = CoveredBands::of(&bands(0, |n| 70.0 - f64::from(n))).unwrap();
        let ratio = 10.0_f64.powf(-0.1);
        let (above, below) = (1..=10, -16..=0);
        let sum = |bands: std::ops::RangeInclusive<i32>| bands.map(|n| ratio.powi(n)).sum::<f64>();
        let exact = 10.0 * (1.0 + sum(above) / sum(below)).log10();
        assert!((gentle.missing.unwrap() - exact).abs() < 1e-9, "{gentle:?} for {exact}");
        let steep = CoveredBands::of(&bands(0, |n| 70.0 - 0.4 * f64::from(n))).unwrap();
        assert!(
            steep.lower_bound && steep.lower_bound_reason().unwrap().contains("slope of the last three bands"),
            "{steep:?}"
        );
        // However steep they fall, bands below 1 kHz give no bound for those that a road excites above.
        let low = CoveredBands::of(&bands(-3, |n| 70.0 - 5.0 * f64::from(n))).unwrap();
        assert!(
            low.lower_bound && low.missing.is_none() && low.lower_bound_reason().unwrap().contains("ends below 1 kHz"),
            "{low:?}"
        );
        assert_eq!(CoveredBands::of(&bands(-16, noise)).map(|of| of.lower_bound), Some(true), "one band has no slope");
        assert_eq!(CoveredBands::of(&bands(0, |_| f64::NEG_INFINITY)).map(|of| of.lower_bound), Some(false));
        assert_eq!(CoveredBands::of(&[]), None);
    }
}
