//! Results of the fields under an open patch: resonances, tables, and pressures in the middle of grooves.

use super::planned::Sound;
use crate::radiation::gap::patch::Channel;
use crate::radiation::gap::resonance::Resonance;
use crate::results::table::{csv, optional, row};
use crate::storage::state::{Evolving, StateError, StateStream};

/// File of the grooves' fields and resonances.
pub(super) const GAP_FILE: &str = "gap.csv";
/// File of the field under the patch over voids.
pub(super) const VOIDS_FILE: &str = "voids.csv";

/// Fields in the grooves of a run.
#[derive(Clone, Debug)]
pub(crate) struct GrooveFields {
    /// By groove; `None` where the response has no peak.
    pub(super) resonances: Vec<Option<Resonance>>,
    pub(super) frequencies: Vec<f64>,
    /// |G| in the middle of a groove by point, frequency and groove \[1/m\].
    pub(super) middle: Vec<Vec<Vec<f64>>>,
    /// |G| at the first point, at the frequency at which it is largest in a groove; `None` without a point.
    pub(super) loudest: Option<UnderPatchLevels>,
    /// Root mean square of G over the patch by point, frequency and place \[1/m\]; empty for grooves alone.
    pub(super) of_places: Vec<Vec<Vec<f64>>>,
}

/// Field under the patch at a frequency.
#[derive(Clone, Debug)]
pub(super) struct UnderPatchLevels {
    /// Frequency \[Hz\].
    pub(super) frequency: f64,
    /// |G| cell by cell along, and in each strip by strip across \[1/m\].
    pub(super) green: Vec<f64>,
    /// Ends of the strips across \[m\].
    pub(super) ends: Vec<f64>,
}

impl GrooveFields {
    /// Messages on grooves that a tone at a frequency \[Hz\] excites.
    pub(super) fn near(&self, passing: f64) -> Vec<String> {
        let one = |(groove, found): (usize, &Option<Resonance>)| {
            let found = (*found)?;
            let frequency = found.frequency;
            found.is_near(passing).then(|| {
                let resonates = format!("tread_pattern.grooves[{groove}] resonates at {frequency:.0} Hz");
                format!("pitches pass at {passing:.0} Hz, and {resonates}")
            })
        };
        self.resonances.iter().enumerate().filter_map(one).collect()
    }

    /// Table of the field under the patch over voids, at the first point of each receiver: its root mean square over
    /// places, and the lowest and highest value of a place; `None` for grooves alone.
    pub(super) fn voids_to_csv(&self, sound: &Sound) -> Option<String> {
        let mut rows = Vec::new();
        for receiver in &sound.receivers {
            for (frequency, places) in self.frequencies.iter().zip(self.of_places.get(receiver.points.start)?) {
                let ends = [f64::min, f64::max].map(|best| places.iter().copied().reduce(best).unwrap_or(0.0));
                let mean = root_mean(places, |place| *place);
                rows.push(row([&receiver.name, frequency, &mean, &ends[0], &ends[1]]));
            }
        }
        let header = ["receiver", "frequency_hz", "green_1_per_m", "lowest_1_per_m", "highest_1_per_m"];
        Some(csv(header, rows))
    }

    /// Table of the grooves: resonances, largest pressures, and |G| in their middles by receiver, at its first point.
    pub(super) fn to_csv(&self, sound: &Sound, pressures: &[MiddlePressure]) -> String {
        let mut rows = Vec::new();
        for (groove, (channel, found)) in sound.channels.iter().zip(&self.resonances).enumerate() {
            let resonance = optional(found.map(|found| found.frequency));
            let quality = optional(found.map(|found| found.quality));
            let largest = optional(pressures.get(groove).map(|middle| middle.largest));
            for receiver in &sound.receivers {
                for (frequency, middle) in self.frequencies.iter().zip(&self.middle[receiver.points.start]) {
                    let Channel { position, width, depth } = channel;
                    let level = middle[groove];
                    rows.push(row([
                        &groove,
                        position,
                        width,
                        depth,
                        &resonance,
                        &quality,
                        &largest,
                        &receiver.name,
                        frequency,
                        &level,
                    ]));
                }
            }
        }
        let header = [
            "groove",
            "position_m",
            "width_m",
            "depth_m",
            "resonance_hz",
            "quality",
            "largest_pa",
            "receiver",
            "frequency_hz",
            "green_1_per_m",
        ];
        csv(header, rows)
    }
}

pub(super) fn root_mean<T>(places: &[T], of: impl Fn(&T) -> f64) -> f64 {
    let sum: f64 = places.iter().map(|place| of(place).powi(2)).sum();
    (sum / places.len() as f64).sqrt()
}

/// Pressure above which air deviates from linearity by 1 %: that part of gamma times its static pressure \[Pa\].
const NOT_LINEAR: f64 = 0.01 * 1.4 * 101_325.0;

/// Statistics of the pressure in the middle of a groove.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct MiddlePressure {
    samples: u64,
    /// Samples above [`NOT_LINEAR`].
    above: u64,
    /// Largest magnitude \[Pa\].
    largest: f64,
}

impl Evolving for MiddlePressure {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.samples, &mut self.above, &mut self.largest])
    }
}

impl MiddlePressure {
    /// Takes the next pressures \[Pa\].
    pub(super) fn take(&mut self, pressures: &[f64]) {
        self.samples += pressures.len() as u64;
        self.above += pressures.iter().filter(|pressure| pressure.abs() > NOT_LINEAR).count() as u64;
        self.largest = pressures.iter().fold(self.largest, |largest, pressure| largest.max(pressure.abs()));
    }

    /// Warning of samples at which the air in groove number `groove` is not linear; `None` without any.
    pub(super) fn warning(&self, groove: usize) -> Option<String> {
        let Self { samples, above, largest } = self;
        (*above > 0).then(|| {
            format!(
                "the pressure in the middle of tread_pattern.grooves[{groove}] is above {NOT_LINEAR:.0} Pa, 1 % of \
                 gamma times that of the air, in {above} of {samples} samples, at most {largest:.0} Pa: it is not \
                 linear there"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressures_above_a_hundredth_of_the_airs_are_counted_and_warned_of() {
        let mut middle = MiddlePressure::default();
        middle.take(&[0.0, -1400.0, 1400.0]);
        assert_eq!(middle.warning(1), None);
        middle.take(&[-1500.0, 1450.0, 3.0]);
        let told = middle.warning(1).unwrap();
        assert!(told.contains("grooves[1]") && told.contains("2 of 6 samples, at most 1500 Pa"), "{told}");
    }
}
