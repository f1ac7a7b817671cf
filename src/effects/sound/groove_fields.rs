//! Fields under an open patch: messages on resonances, tables, and pressures in the middle of grooves.

use crate::plan::Plan;
use crate::plan::sound::Sound;
use crate::radiation::air::{HEAT_RATIO, STANDARD_PRESSURE};
use crate::radiation::gap::patch::GapChannel;
use crate::radiation::gap::resonance::Resonance;
use crate::response::pressure::open_patch::{GrooveFields, OpenPatch, root_mean};
use crate::results::table::{csv, optional, row};
use crate::storage::state::evolving;

/// File of the grooves' fields and resonances.
pub(super) const GAP_FILE: &str = "gap.csv";
/// File of the field under the patch over voids.
pub(super) const VOIDS_FILE: &str = "voids.csv";

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
        for (groove, (channel, found)) in sound.path.channels.iter().zip(&self.resonances).enumerate() {
            let resonance = optional(found.map(|found| found.frequency));
            let quality = optional(found.map(|found| found.quality));
            let largest = optional(pressures.get(groove).map(|middle| middle.largest));
            for receiver in &sound.receivers {
                for (frequency, middle) in self.frequencies.iter().zip(&self.middle[receiver.points.start]) {
                    let GapChannel { position, width, depth } = channel;
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

/// Passing frequency of a plan's pitches \[Hz\]; `None` without pitches.
pub(super) fn pitch_frequency(plan: &Plan) -> Option<f64> {
    let train = plan.tread_map().and_then(|map| map.train)?;
    Some(train.count() as f64 * plan.speed / train.circumference)
}

/// Message on the resonances of a plan's grooves, by the gap equation over the expected patch, and on the passing
/// frequency of its pitches; `None` for a sealed patch, or for a body or air that the run will refuse.
pub(super) fn expected_resonances(plan: &Plan) -> Option<String> {
    let path = plan.sound()?.path;
    if path.channels.is_empty() {
        return None;
    }
    let body = plan.radiating_body(&path.radiation, plan.expected().length).ok()?;
    let resonances = OpenPatch::of(&path, &body, &[])?.resonances().ok()?;
    let of = |(groove, found): (usize, &Option<Resonance>)| match found {
        Some(Resonance { frequency, .. }) => {
            format!("tread_pattern.grooves[{groove}] resonates near {frequency:.0} Hz")
        }
        None => format!("tread_pattern.grooves[{groove}] has no resonance in the range that is searched"),
    };
    let mut reported: Vec<String> = resonances.iter().enumerate().map(of).collect();
    reported.extend(pitch_frequency(plan).map(|passing| {
        let is_near = resonances.iter().flatten().any(|found| found.is_near(passing));
        format!("pitches pass at {passing:.0} Hz{}", if is_near { ", within 10 % of a resonance" } else { "" })
    }));
    let length = 2e3 * body.half_patch();
    Some(format!("in a patch of {length:.0} mm {}", reported.join(", ")))
}

/// Pressure above which air deviates from linearity by 1 %: that part of gamma times its static pressure \[Pa\].
const NOT_LINEAR: f64 = 0.01 * HEAT_RATIO * STANDARD_PRESSURE;

/// Statistics of the pressure in the middle of a groove.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct MiddlePressure {
    samples: u64,
    /// Samples above [`NOT_LINEAR`].
    above: u64,
    /// Largest magnitude \[Pa\].
    largest: f64,
}

evolving!(MiddlePressure: samples, above, largest);

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
    fn pitches_that_pass_near_a_resonance_give_a_message() {
        let resonances = vec![Some(Resonance { frequency: 1100.0, quality: 5.0 }), None];
        let (frequencies, middle, of_places) = (Vec::new(), Vec::new(), Vec::new());
        let fields = GrooveFields { resonances, frequencies, middle, loudest: None, of_places };
        assert_eq!(fields.near(1.05 * 1100.0).len(), 1);
        assert!(fields.near(1.2 * 1100.0).is_empty());
    }

    #[test]
    fn pressures_above_one_percent_of_the_airs_are_warned_of() {
        let mut middle = MiddlePressure::default();
        middle.take(&[0.0, -1400.0, 1400.0]);
        assert_eq!(middle.warning(1), None);
        middle.take(&[-1500.0, 1450.0, 3.0]);
        let reported = middle.warning(1).unwrap();
        assert!(reported.contains("grooves[1]") && reported.contains("2 of 6 samples, at most 1500 Pa"), "{reported}");
    }
}
