//! Emission of a tyre, as models of traffic noise and a regulation take it: levels against the logarithm of the speed.
//!
//! 1. The finished runs of a sweep are grouped by road, load and settings: those of a group differ in speed, and in
//!    seeds, which are draws of the same thing.
//! 2. The level along the line of each coast-by receiver, per third octave, becomes the sound power of a vehicle of
//!    four equal, uncorrelated tyres: [point sources](crate::sound::point_source), and 10 lg 4 = 6.0 dB for a receiver
//!    that hears one tyre. Octaves of CNOSSOS-EU are energy sums of three third octaves.
//! 3. Least squares of L = A + B lg(v/v_ref) over the runs: [`SpeedCoefficient`](crate::sound::SpeedCoefficient).
//!
//! A row is valid where the band is valid in every run that contributes.

mod rows;
mod run_levels;
mod table;

use std::collections::BTreeSet;

use crate::study::sweep::StoredSweep;
use rows::EmissionRow;
pub(crate) use run_levels::EmissionError;
use run_levels::{RunLevels, run_levels};
pub(crate) use table::EMISSION_HEAD;

/// Emission of all groups and receivers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Emission {
    /// Regressions, by group and receiver.
    pub rows: Vec<EmissionRow>,
    /// Lines that cannot be fitted, and why.
    pub missing: Vec<String>,
}

impl Emission {
    /// Evaluates the runs of a sweep.
    ///
    /// # Errors
    /// [`EmissionError`].
    pub(crate) fn of(sweep: &StoredSweep) -> Result<Self, EmissionError> {
        let mut runs = Vec::new();
        for (label, run) in &sweep.variants {
            let unfinished = || EmissionError::Unfinished { name: label.name.clone() };
            runs.extend(run_levels(label, run.as_ref().ok_or_else(unfinished)?)?);
        }
        let (mut rows, mut missing) = (Vec::new(), Vec::new());
        let places = runs.iter().map(|of| (of.group.as_str(), of.receiver.as_str()));
        let mut seen = BTreeSet::new();
        for place in places.filter(|place| seen.insert(*place)) {
            let all: Vec<&RunLevels> =
                runs.iter().filter(|of| (of.group.as_str(), of.receiver.as_str()) == place).collect();
            let speed = all[0].speed;
            if all.iter().all(|other| other.speed.total_cmp(&speed).is_eq()) {
                return Err(EmissionError::OneSpeed { group: place.0.to_owned(), speed });
            }
            rows.extend(rows::rows(&all));
            missing.extend(rows::no_maxima(&all));
        }
        Ok(Self { rows, missing })
    }
}
