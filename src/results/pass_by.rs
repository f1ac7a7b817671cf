//! A pass-by in `summary.json`, and the statistical error of its maximum.
//!
//! The maxima L_p of n passages have the mean L and s^2 = sum (L_p - L)^2/(n - 1). Each passage consists of m stretches
//! of the run, one for each tyre, taken cyclically: passages share stretches, and their maxima are not independent. If
//! a maximum is a sum of m independent parts, one for each stretch, its variance v and the standard error e of L are
//!
//! ```text
//! E s^2 (n - 1)/n = v - e^2,   e^2 <= m v/n,   so   e^2 <= s^2 m (n - 1)/(n (n - m))
//! ```
//!
//! with equality where a stretch has the same effect through all tyres. For one tyre e = s/sqrt(n). Nothing is known
//! for n <= m.

use serde::{Deserialize, Serialize};

/// Longest stretch of a run whose pressures are stored over time \[s\].
pub(crate) const LISTENED: f64 = 30.0;
/// Standard error for which a longer run is recommended \[dB\]: half of the step to which UN R117 rounds levels.
const WANTED: f64 = 0.5;

/// Result of a tyre or a vehicle passing a microphone.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct PassBySummary {
    /// Name of its table, level over time.
    #[serde(default)]
    pub file: String,
    /// Number of passages in the run.
    pub passages: usize,
    /// Mean of their maxima of the A-weighted level, time weighting F \[dB(A)\].
    pub maximum: f64,
    /// Standard deviation of the maxima \[dB\]; `None` for a single one.
    pub deviation: Option<f64>,
    /// Upper bound of the standard error of their mean \[dB\]; `None` for no more passages than tyres.
    pub standard_error: Option<f64>,
    /// Number of tyres that pass, each with a separate stretch of the run.
    #[serde(default = "one")]
    tyres: usize,
    /// Duration that one more passage takes \[s\].
    #[serde(default)]
    pub seconds: f64,
}

fn one() -> usize {
    1
}

impl PassBySummary {
    /// Summary of the maxima of passages \[dB(A)\] of so many tyres; each passage takes `seconds` of the run.
    pub(crate) fn new(file: String, maxima: &[f64], tyres: usize, seconds: f64) -> Self {
        let (passages, count) = (maxima.len(), maxima.len() as f64);
        let maximum = maxima.iter().sum::<f64>() / count;
        let squares: f64 = maxima.iter().map(|level| (level - maximum).powi(2)).sum();
        let deviation = (passages > 1).then(|| (squares / (count - 1.0)).sqrt());
        let shared = tyres as f64;
        let standard_error = (passages > tyres).then(|| (squares * shared / (count * (count - shared))).sqrt());
        Self { file, passages, maximum, deviation, standard_error, tyres, seconds }
    }

    /// Time by which `rolling.duration` must grow for the maximum to have a standard error of half a decibel, or a
    /// known one at all \[s\]; `None` where that is fulfilled already.
    pub(crate) fn missing_seconds(&self) -> Option<f64> {
        let needed = match self.standard_error {
            None => self.tyres + 1,
            Some(error) => (self.passages as f64 * (error / WANTED).powi(2)).ceil() as usize,
        };
        (needed > self.passages).then(|| (needed - self.passages) as f64 * self.seconds)
    }

    /// Text on the number of passages, their statistical error, and how much longer the run must be for a smaller one.
    pub(crate) fn statistics(&self) -> String {
        let Self { passages, seconds, .. } = self;
        let mut text = match (self.standard_error, passages) {
            (Some(error), _) => format!("mean of {passages} passages, standard error {error:.1} dB"),
            (None, 1) => "a single passage, statistical error not known".to_owned(),
            (None, _) => format!("mean of {passages} passages, statistical error not known"),
        };
        let Some(missing) = self.missing_seconds() else { return text };
        let wanted = if self.standard_error.is_some() { format!("for {WANTED} dB") } else { "to know it".to_owned() };
        text.push_str(&if missing + *passages as f64 * seconds < LISTENED {
            format!("; {wanted}, some {missing:.1} s more of rolling.duration")
        } else {
            format!("; {wanted}, a sweep over road.seed, for a run keeps no more than {LISTENED} s of passages")
        });
        text
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn of(maxima: &[f64], tyres: usize) -> PassBySummary {
        PassBySummary::new(String::new(), maxima, tyres, 0.5)
    }

    #[test]
    fn the_maximum_of_a_single_passage_has_no_known_error() {
        let single = of(&[64.1], 1);
        assert_eq!((single.deviation, single.standard_error, single.missing_seconds()), (None, None, Some(0.5)));
        let reported = single.statistics();
        assert!(
            reported.contains("single passage, statistical error not known") && reported.contains("0.5 s more"),
            "{reported}"
        );
        // Passages of four tyres that share their four stretches contain no information on the error.
        let shared = of(&[64.0, 64.1, 64.0, 64.1], 4);
        assert!(shared.deviation.is_some() && shared.standard_error.is_none(), "{shared:?}");
        assert_eq!(shared.missing_seconds(), Some(0.5));
    }

    #[test]
    fn the_duration_for_half_a_decibel_is_stated() {
        // s = 2 dB over four passages: 1 dB, and 16 passages for 0.5 dB.
        let few = of(&[62.0, 66.0, 64.0, 64.0], 1);
        let error = (8.0_f64 / 3.0).sqrt() / 2.0;
        assert!((few.standard_error.unwrap() - error).abs() < 1e-12 && (few.maximum - 64.0).abs() < 1e-12);
        let needed = (4.0 * (error / WANTED).powi(2)).ceil();
        assert_eq!(few.missing_seconds(), Some((needed - 4.0) * 0.5));
        let enough = of(&[64.0, 64.5, 64.2, 64.1], 1);
        assert_eq!(enough.missing_seconds(), None);
        assert_eq!(enough.statistics(), "mean of 4 passages, standard error 0.1 dB");
        let longest = PassBySummary { seconds: 10.0, ..few };
        assert!(longest.statistics().contains("road.seed"), "{}", longest.statistics());
    }

    #[test]
    fn the_stated_error_is_the_scatter_of_means_of_passages() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        for (tyres, passages) in [(1, 5), (4, 12)] {
            let trials = 4000;
            let [mut stated, mut found] = [0.0; 2];
            for _ in 0..trials {
                let stretches: Vec<f64> = (0..passages).map(|_| random.random_range(-1.0..1.0)).collect();
                let sum = |first: usize| (0..tyres).map(|tyre| stretches[(first + tyre) % passages]).sum::<f64>();
                let summary = of(&(0..passages).map(sum).collect::<Vec<_>>(), tyres);
                stated += summary.standard_error.unwrap().powi(2) / f64::from(trials);
                found += summary.maximum.powi(2) / f64::from(trials);
            }
            // Each side scatters by 2 to 3 % over 4000 trials.
            assert!((stated / found - 1.0).abs() < 0.12, "{tyres} tyres: {stated} stated, {found} found");
        }
    }
}
