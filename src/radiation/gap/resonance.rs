//! Resonance of a response that is known at some frequencies.

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Resonance {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Quality factor: frequency over the bandwidth at half power.
    pub quality: f64,
}

/// Largest relative distance from a resonance at which it is excited.
const NEAR: f64 = 0.1;

impl Resonance {
    /// True if a tone at a frequency \[Hz\] excites it.
    pub(crate) fn is_near(&self, passing: f64) -> bool {
        (passing / self.frequency - 1.0).abs() <= NEAR
    }

    /// Highest peak of magnitudes at rising frequencies \[Hz\]; `None` where it is at an end.
    ///
    /// One over the magnitude's square is a parabola about the resonance of a single mode; it is fitted to the peak and
    /// its neighbours.
    pub(crate) fn of(response: &[(f64, f64)]) -> Option<Self> {
        let highest = (0..response.len()).max_by(|&one, &other| response[one].1.total_cmp(&response[other].1))?;
        if highest == 0 || highest + 1 >= response.len() {
            return None;
        }
        let [(f0, y0), (f1, y1), (f2, y2)] =
            [highest - 1, highest, highest + 1].map(|index| (response[index].0, response[index].1.powi(-2)));
        let [left, right] = [(y1 - y0) / (f1 - f0), (y2 - y1) / (f2 - f1)];
        let bend = (right - left) / (f2 - f0);
        let slope = left + bend * (f1 - f0);
        let frequency = f1 - 0.5 * slope / bend;
        let least = y1 - 0.25 * slope * slope / bend;
        let quality = 0.5 * frequency * (bend / least).sqrt();
        (quality > 0.0 && quality.is_finite()).then_some(Self { frequency, quality })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_is_found_between_frequencies_and_a_rise_is_none() {
        let response = |f: f64| {
            let part = f / 1040.0;
            ((1.0 - part * part).powi(2) + (part / 12.0).powi(2)).sqrt().recip()
        };
        let known: Vec<(f64, f64)> =
            (0..40).map(|step| 500.0 + 25.0 * f64::from(step)).map(|f| (f, response(f))).collect();
        let found = Resonance::of(&known).unwrap();
        assert!((found.frequency - 1040.0).abs() < 5.0 && (found.quality - 12.0).abs() < 0.5, "{found:?}");
        assert_eq!(Resonance::of(&known[..15]), None);
        assert_eq!(Resonance::of(&[]), None);
    }
}
