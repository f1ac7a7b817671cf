//! Level of a sound level meter over time (IEC 61672-1:2013, 3.8 and 5.8).
//!
//! The squared pressure goes through an exponential average of time constant tau, 125 ms for F(ast) and 1 s for S(low):
//!
//! ```text
//! m(t) = 1/tau Int_-inf^t p^2(s) exp(-(t - s)/tau) ds,   L(t) = 10 lg(m/p_0^2)
//! m_n = m_(n-1) + (1 - exp(-dt/tau)) (p_n^2 - m_(n-1))
//! ```
//!
//! exact for a squared pressure that is constant over each sample.

use super::levels::level;
use super::weighting::FrequencyWeighting;
use super::weighting_filter::{RateError, WeightingFilter};

/// Time weighting of a sound level meter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TimeWeighting {
    /// F, 125 ms: the weighting of pass-by levels.
    Fast,
    /// S, 1 s: for slowly varying sound.
    Slow,
}

impl TimeWeighting {
    /// Time constant tau \[s\].
    pub fn time_constant(self) -> f64 {
        match self {
            Self::Fast => 0.125,
            Self::Slow => 1.0,
        }
    }
}

/// Running exponential average of the squared pressure, and its highest value.
///
/// ```
/// use tyrewave::sound::{Detector, TimeWeighting};
///
/// // 1 Pa is 94 dB, whatever the time weighting, once it has lasted long enough.
/// let mut meter = Detector::new(TimeWeighting::Fast, 48_000.0);
/// for _ in 0..96_000 {
///     meter.push(1.0);
/// }
/// assert!((meter.level() - 93.98).abs() < 0.01);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Detector {
    share: f64,
    mean_square: f64,
    highest: Option<(usize, f64)>,
    count: usize,
}

impl Detector {
    /// Detector at a sampling rate \[Hz\], with silence before the first sample.
    pub fn new(weighting: TimeWeighting, rate: f64) -> Self {
        let share = -(-1.0 / (rate * weighting.time_constant())).exp_m1();
        Self { share, mean_square: 0.0, highest: None, count: 0 }
    }

    /// The same, with a sound of that mean square \[Pa^2\] before the first sample: for a record that begins in the
    /// midst of a noise. Without it the level of a steady noise is 0.6 dB low after 2 tau and 0.1 dB after 4.
    #[must_use]
    pub fn after(self, mean_square: f64) -> Self {
        Self { mean_square, ..self }
    }

    /// Takes the next pressure \[Pa\], already weighted by frequency; returns the averaged mean square \[Pa^2\].
    pub fn push(&mut self, pressure: f64) -> f64 {
        self.mean_square += self.share * (pressure * pressure - self.mean_square);
        if self.highest.is_none_or(|(_, highest)| self.mean_square > highest) {
            self.highest = Some((self.count, self.mean_square));
        }
        self.count += 1;
        self.mean_square
    }

    /// Level after the last sample \[dB re 20 uPa\].
    pub fn level(&self) -> f64 {
        level(self.mean_square)
    }

    /// Highest level so far \[dB re 20 uPa\], and the index of its sample before it; `None` before any sample.
    pub fn maximum(&self) -> Option<(usize, f64)> {
        self.highest.map(|(sample, mean_square)| (sample, level(mean_square)))
    }

    /// Level after each sample of a signal \[Pa\] \[dB re 20 uPa\].
    pub fn levels(&mut self, signal: &[f64]) -> Vec<f64> {
        signal.iter().map(|&pressure| level(self.push(pressure))).collect()
    }
}

/// Reading of a sound level meter after each sample of a pressure \[Pa\], both weightings applied \[dB re 20 uPa\]:
/// L_AF for A and F. The meter starts in silence.
///
/// # Errors
/// [`RateError`] for a sampling rate \[Hz\] without a weighting filter.
pub fn meter_levels(
    signal: &[f64],
    rate: f64,
    frequency_weighting: FrequencyWeighting,
    time_weighting: TimeWeighting,
) -> Result<Vec<f64>, RateError> {
    let weighted = WeightingFilter::new(frequency_weighting, rate)?.apply(signal);
    Ok(Detector::new(time_weighting, rate).levels(&weighted))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const RATE: f64 = 48_000.0;

    /// Highest level of a 4 kHz burst of 1 Pa amplitude, relative to the level of the same tone without end.
    fn burst_response(weighting: TimeWeighting, milliseconds: f64) -> f64 {
        let mut detector = Detector::new(weighting, RATE);
        let samples = (milliseconds * 1e-3 * RATE).round() as usize;
        for n in 0..samples + 4800 {
            let tone = (TAU * 4000.0 * n as f64 / RATE).sin();
            detector.push(if n < samples { tone } else { 0.0 });
        }
        detector.maximum().unwrap().1 - level(0.5)
    }

    #[test]
    fn tone_bursts_have_the_responses_of_table_4() {
        // IEC 61672-1:2013, table 4: duration [ms], reference response [dB], class 1 acceptance limits [dB].
        let fast = [
            (1000.0, 0.0, 0.5, -0.5),
            (500.0, -0.1, 0.5, -0.5),
            (200.0, -1.0, 0.5, -0.5),
            (100.0, -2.6, 1.0, -1.0),
            (50.0, -4.8, 1.0, -1.0),
            (20.0, -8.3, 1.0, -1.0),
            (10.0, -11.1, 1.0, -1.0),
            (5.0, -14.1, 1.0, -1.0),
            (2.0, -18.0, 1.0, -1.5),
            (1.0, -21.0, 1.0, -2.0),
            (0.5, -24.0, 1.0, -2.5),
            (0.25, -27.0, 1.0, -3.0),
        ];
        let slow = [
            (1000.0, -2.0, 0.5, -0.5),
            (500.0, -4.1, 0.5, -0.5),
            (200.0, -7.4, 0.5, -0.5),
            (100.0, -10.2, 1.0, -1.0),
            (50.0, -13.1, 1.0, -1.0),
            (20.0, -17.0, 1.0, -1.5),
            (10.0, -20.0, 1.0, -2.0),
            (5.0, -23.0, 1.0, -2.5),
            (2.0, -27.0, 1.0, -3.0),
        ];
        for (weighting, table) in [(TimeWeighting::Fast, &fast[..]), (TimeWeighting::Slow, &slow[..])] {
            for &(duration, reference, above, below) in table {
                let error = burst_response(weighting, duration) - reference;
                assert!((below..=above).contains(&error), "{weighting:?}, {duration} ms: {error} dB");
                // The table's formula, 10 lg(1 - exp(-T/tau)), rounded to tenths, and half a period of the tone.
                assert!(error.abs() < 0.07, "{weighting:?}, {duration} ms: {error} dB");
            }
        }
    }

    #[test]
    fn levels_decay_at_the_rate_of_the_standard_and_a_maximum_stays() {
        for (weighting, per_second) in [(TimeWeighting::Fast, 34.7), (TimeWeighting::Slow, 4.34)] {
            let mut detector = Detector::new(weighting, RATE).after(1.0);
            let levels = detector.levels(&vec![0.0; RATE as usize]);
            let decay = levels[0] - levels[RATE as usize - 1];
            assert!((decay / per_second - 1.0).abs() < 2e-3, "{weighting:?}: {decay} dB a second");
            assert_eq!(detector.maximum().unwrap().0, 0);
        }
        assert_eq!(Detector::new(TimeWeighting::Fast, RATE).maximum(), None);
    }
}
