//! Third-octave bands of IEC 61260-1:2014, base ten.
//!
//! With the octave ratio G = 10^(3/10) and the reference frequency 1 kHz, band n has the exact mid-frequency 1000
//! G^(n/3) = 1000 * 10^(n/10) Hz (5.2, formula 2) and the edges G^(-1/6), G^(1/6) = 10^(-1/20), 10^(1/20) times that
//! (5.4, formulas 4 and 5). Neighbours share an edge: the bands tile the frequency axis.

use std::ops::Range;

use serde::{Deserialize, Serialize};

/// One third-octave band, numbered by its distance n from the 1 kHz band.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize)]
pub struct ThirdOctaveBand(pub i32);

/// Nominal mid-frequencies of one decade (IEC 61260-1, annex E; the R10 series).
const NOMINAL: [f64; 10] = [1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0];

impl ThirdOctaveBand {
    /// The band that holds a frequency; a band holds its lower edge. `None` unless `frequency` \[Hz\] is positive and
    /// finite.
    pub fn containing(frequency: f64) -> Option<Self> {
        if !(frequency.is_finite() && frequency > 0.0) {
            return None;
        }
        let guess = Self((10.0 * (frequency / 1000.0).log10() + 0.5).floor() as i32);
        // The logarithm may round across an edge; the edges themselves decide.
        Some(if frequency < guess.lower_edge() {
            Self(guess.0 - 1)
        } else if frequency >= guess.upper_edge() {
            Self(guess.0 + 1)
        } else {
            guess
        })
    }

    /// Bands that lie in `frequencies` \[Hz\] with both edges, lowest first; none if the range is empty. A lower limit
    /// of 0 gives no bands: there is no first one.
    pub fn within(frequencies: Range<f64>) -> Vec<Self> {
        let (Some(first), Some(last)) = (Self::containing(frequencies.start), Self::containing(frequencies.end)) else {
            return Vec::new();
        };
        (first.0..=last.0)
            .map(Self)
            .filter(|band| band.lower_edge() >= frequencies.start && band.upper_edge() <= frequencies.end)
            .collect()
    }

    /// True for a band of a signal that is valid up to a frequency \[Hz\].
    pub fn is_valid_up_to(self, valid_to: f64) -> bool {
        // Exact mid-frequencies lie up to half a percent above the nominal ones that people ask for.
        self.mid_frequency() <= 1.01 * valid_to
    }

    /// Exact mid-frequency 1000 * 10^(n/10) \[Hz\].
    pub fn mid_frequency(self) -> f64 {
        1000.0 * 10.0_f64.powf(f64::from(self.0) / 10.0)
    }

    /// Lower edge \[Hz\]: bit for bit the upper edge of the band below.
    pub fn lower_edge(self) -> f64 {
        1000.0 * 10.0_f64.powf(f64::from(2 * self.0 - 1) / 20.0)
    }

    /// Upper edge \[Hz\].
    pub fn upper_edge(self) -> f64 {
        Self(self.0 + 1).lower_edge()
    }

    /// Bandwidth \[Hz\].
    pub fn width(self) -> f64 {
        self.upper_edge() - self.lower_edge()
    }

    /// Nominal mid-frequency \[Hz\]: 31.5, 40, 50, ...
    pub fn nominal_frequency(self) -> f64 {
        let decade = 3 + self.0.div_euclid(10);
        // Dividing by a power of ten rounds better than multiplying by 0.1, 0.01, ...
        let value = NOMINAL[self.0.rem_euclid(10) as usize];
        if decade >= 0 { value * 10.0_f64.powi(decade) } else { value / 10.0_f64.powi(-decade) }
    }

    /// Nominal mid-frequency as it is written along an axis: `31.5`, `400`, `1k`, `1.25k`.
    pub fn label(self) -> String {
        let nominal = self.nominal_frequency();
        if nominal >= 1000.0 { format!("{}k", nominal / 1000.0) } else { format!("{nominal}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_and_middles_are_those_of_the_standard() {
        // IEC 61260-1 annex E, table E.1: exact base-ten mid-frequencies.
        for (n, exact) in
            [(-16, 25.119), (-15, 31.623), (-10, 100.0), (-3, 501.19), (0, 1000.0), (1, 1258.9), (13, 19953.0)]
        {
            let mid = ThirdOctaveBand(n).mid_frequency();
            assert!((mid / exact - 1.0).abs() < 5e-5, "band {n}: {mid}");
        }
        let kilohertz = ThirdOctaveBand(0);
        assert!((kilohertz.lower_edge() - 891.250_938).abs() < 1e-6);
        assert!((kilohertz.upper_edge() - 1_122.018_454).abs() < 1e-6);
    }

    #[test]
    fn bands_tile_the_axis() {
        for n in -40..40 {
            let band = ThirdOctaveBand(n);
            assert_eq!(band.upper_edge().to_bits(), ThirdOctaveBand(n + 1).lower_edge().to_bits());
            assert_eq!(ThirdOctaveBand::containing(band.mid_frequency()), Some(band));
            assert_eq!(ThirdOctaveBand::containing(band.lower_edge()), Some(band), "an edge belongs to the band above");
            assert_eq!(ThirdOctaveBand::containing(band.upper_edge().next_down()), Some(band));
        }
    }

    #[test]
    fn nominal_labels() {
        let labels: Vec<String> = (-20..=13).map(|n| ThirdOctaveBand(n).label()).collect();
        let expected = "10 12.5 16 20 25 31.5 40 50 63 80 100 125 160 200 250 315 400 500 630 800 \
                        1k 1.25k 1.6k 2k 2.5k 3.15k 4k 5k 6.3k 8k 10k 12.5k 16k 20k";
        assert_eq!(labels.join(" "), expected);
        assert_eq!(ThirdOctaveBand(-31).label(), "0.8");
    }

    #[test]
    fn within_takes_whole_bands_only() {
        let bands = ThirdOctaveBand::within(20.0..5000.0);
        assert_eq!(bands.first(), Some(&ThirdOctaveBand(-16)), "20 Hz lies above the lower edge of its band");
        assert_eq!(bands.last(), Some(&ThirdOctaveBand(6)));
        assert_eq!(bands.len(), 23);
        assert!(ThirdOctaveBand::within(0.0..100.0).is_empty());
        assert!(ThirdOctaveBand::within(f64::NAN..100.0).is_empty());
        assert!(ThirdOctaveBand::within(100.0..50.0).is_empty());
        assert_eq!(ThirdOctaveBand::containing(-1.0), None);
        assert_eq!(ThirdOctaveBand::containing(f64::INFINITY), None);
    }
}
