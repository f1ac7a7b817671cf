//! Gains of third octaves, by which a spectrum and its sound are corrected.

use super::third_octave::ThirdOctaveBand;

/// Gain of a band's mean square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BandGain {
    /// The band.
    pub band: ThirdOctaveBand,
    /// Factor of its mean square.
    pub gain: f64,
    /// Variance of the corrected mean square, relative to its square.
    pub variance: f64,
}

/// Gain of a pressure at a frequency \[Hz\]: between the middles of bands it changes evenly in dB over the logarithm of
/// the frequency, beyond the outermost it stays.
pub(crate) fn gain_at(gains: &[BandGain], frequency: f64) -> f64 {
    let after = gains.partition_point(|gain| gain.band.mid_frequency() <= frequency);
    let at = |place: usize| (gains[place].band.mid_frequency().ln(), 0.5 * gains[place].gain.ln());
    match (after.checked_sub(1).map(at), (after < gains.len()).then(|| at(after))) {
        (Some((x, low)), Some((end, high))) => (low + (high - low) * (frequency.ln() - x) / (end - x)).exp(),
        (Some((_, gain)), None) | (None, Some((_, gain))) => gain.exp(),
        (None, None) => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_change_evenly_between_bands() {
        let of = |number: i32, gain: f64| BandGain { band: ThirdOctaveBand(number), gain, variance: 0.0 };
        let gains = [of(-1, 1.0), of(0, 4.0)];
        let expected = [(50.0, 1.0), (ThirdOctaveBand(0).mid_frequency(), 2.0), (5000.0, 2.0)];
        for (frequency, gain) in expected {
            assert!((gain_at(&gains, frequency) - gain).abs() < 1e-9, "{frequency}");
        }
        let between = (ThirdOctaveBand(-1).mid_frequency() * ThirdOctaveBand(0).mid_frequency()).sqrt();
        assert!((gain_at(&gains, between) - 2.0_f64.sqrt()).abs() < 1e-9);
        assert_eq!(gain_at(&[], 100.0).to_bits(), 1.0_f64.to_bits());
    }
}
