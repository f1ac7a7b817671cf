//! Figure 2: driving-point mobility of the tread for patches of several sizes.

use crate::numeric::StraightLine;
use crate::scene::Tyre;
use crate::tyre::influence::mobility::{Mobility, driving_point, frequencies, level};
use serde::Serialize;

use super::statement::{Statement, Verdict};

/// Sides of the patches \[m\], falling.
const PATCHES: [f64; 4] = [0.05, 0.02, 0.01, 0.005];
/// Range of frequencies \[Hz\].
const BAND: [f64; 2] = [50.0, 3000.0];
/// Above this frequency the mobility of a small patch is a spring's \[Hz\].
const SPRING_FROM: f64 = 1000.0;
/// Share of the frequencies at which resonances of the tyre may hide the influence of the patch.
const HIDDEN: f64 = 0.1;

/// Mobilities, and their growth as the patch shrinks.
#[derive(Clone, Debug, Serialize)]
pub(super) struct MobilityFigure {
    /// Values by frequency and patch.
    #[serde(skip)]
    pub mobility: Mobility,
    /// Sides of the square patches \[m\].
    pub patches: Vec<f64>,
    /// Frequencies \[Hz\].
    pub frequencies: Vec<f64>,
    /// Levels at each frequency by patch \[dB re 1 m/(N s)\].
    pub levels: Vec<Vec<f64>>,
    /// Smallest rise from a patch to the next smaller one \[dB\].
    pub smallest_rise: f64,
    /// Frequency of the smallest rise \[Hz\].
    pub smallest_rise_at: f64,
    /// Share of the frequencies at which the level rises from each patch to the next.
    pub rising: f64,
    /// Mean rise over all frequencies per halving of the side \[dB\].
    pub mean_rise_per_halving: f64,
    /// Exponent of frequency of the smallest patch's mobility, from 1 kHz on.
    pub exponent: f64,
}

impl MobilityFigure {
    /// Mobility of a tyre at `points` frequencies.
    pub(super) fn of(tyre: &Tyre, points: u32) -> Self {
        let frequencies = frequencies(BAND[0], BAND[1], points);
        let mobility = driving_point(tyre, &PATCHES, &frequencies);
        let levels: Vec<Vec<f64>> =
            mobility.values.iter().map(|row| row.iter().map(|&value| level(value)).collect()).collect();
        let rises = frequencies
            .iter()
            .zip(&levels)
            .flat_map(|(&frequency, row)| row.windows(2).map(move |pair| (pair[1] - pair[0], frequency)));
        let (smallest_rise, smallest_rise_at) =
            rises.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::NAN, f64::NAN));
        let halvings = (PATCHES[0] / PATCHES[PATCHES.len() - 1]).log2();
        let whole: f64 = levels.iter().map(|row| row[PATCHES.len() - 1] - row[0]).sum();
        let rising = levels.iter().filter(|row| row.windows(2).all(|pair| pair[1] > pair[0])).count();
        let high: Vec<(f64, f64)> = frequencies
            .iter()
            .zip(&mobility.values)
            .filter(|(frequency, _)| **frequency >= SPRING_FROM)
            .map(|(&frequency, row)| (frequency, row[PATCHES.len() - 1].norm()))
            .collect();
        Self {
            patches: PATCHES.to_vec(),
            smallest_rise,
            smallest_rise_at,
            rising: rising as f64 / levels.len() as f64,
            mean_rise_per_halving: whole / (levels.len() as f64 * halvings),
            exponent: StraightLine::power_law(&high).map_or(f64::NAN, |line| line.slope),
            frequencies,
            levels,
            mobility,
        }
    }

    pub(super) fn statements(&self) -> [Statement; 2] {
        [
            Statement {
                place: "figure 2",
                subject: "mobility of the tread over the size of the patch",
                paper: "the level rises as the patch shrinks",
                found: format!(
                    "{:.1} dB for half the side; at {:.0} % of the frequencies from each patch to the next, least \
                     {:+.1} dB at {:.0} Hz",
                    self.mean_rise_per_halving,
                    100.0 * self.rising,
                    self.smallest_rise,
                    self.smallest_rise_at
                ),
                verdict: rises(self.rising),
                why: format!(
                    "a rise from each patch to the next at {} % of the frequencies or more",
                    100.0 - 100.0 * HIDDEN
                ),
            },
            Statement {
                place: "figure 2",
                subject: "mobility of a small patch",
                paper: "grows like that of a spring above 400 to 1000 Hz",
                found: format!(
                    "grows with the frequency to the power {:.2} from {SPRING_FROM} Hz on, {} mm",
                    self.exponent,
                    1e3 * PATCHES[PATCHES.len() - 1]
                ),
                verdict: is_spring(self.exponent),
                why: "a power nearer to a spring's 1 than to a damper's 0".to_owned(),
            },
        ]
    }
}

fn rises(rising: f64) -> Verdict {
    Verdict::of(rising >= 1.0 - HIDDEN)
}

fn is_spring(exponent: f64) -> Verdict {
    Verdict::of((exponent - 1.0).abs() < 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_that_often_falls_and_what_is_no_spring_disagree() {
        assert_eq!([0.95, 0.8, f64::NAN].map(rises), [Verdict::Agrees, Verdict::Disagrees, Verdict::Disagrees]);
        let found = [1.1, 0.7, -1.0, 0.3, f64::NAN].map(is_spring);
        assert_eq!(found.map(|verdict| verdict == Verdict::Agrees), [true, true, false, false, false]);
    }
}
