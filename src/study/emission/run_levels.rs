//! Levels of a sweep's runs at their coast-by receivers, as sound power of a vehicle.

use thiserror::Error;

use crate::effects::stored::{Stored, StoredError};
use crate::response::{BandLevel, LevelErrors, ThirdOctaveBand};
use crate::results::sound::{SOUND_FILE, SOUND_LEVEL};
use crate::scene::Vehicle;
use crate::sound::TotalLevel;
use crate::sound::levels::energetic_sum;
use crate::sound::point_source::PointSources;
use crate::study::sweep::Label;

/// Column of the unweighted levels at receivers.
const LEVEL: &str = "level_db_re_20upa";

/// Reasons why there is no emission.
#[derive(Debug, Error)]
pub(crate) enum EmissionError {
    /// A results folder that cannot be read.
    #[error(transparent)]
    Stored(#[from] StoredError),
    /// A run that is not finished.
    #[error("{name} is not finished: the same `tyrewave sweep` command continues it")]
    Unfinished {
        /// Name of the run.
        name: String,
    },
    /// No microphone beside the road.
    #[error("{name} has no levels at a coast-by receiver: its scene needs [[receiver]] with standard = \"coast-by\"")]
    NoPassage {
        /// Name of the run.
        name: String,
    },
    /// Levels at a single speed.
    #[error(
        "{} at {speed} km/h alone: a line over the speed needs two speeds at least, such as \
         `tyrewave sweep SCENE --speed 50..110:10`",
        if group.is_empty() { "runs" } else { group }
    )]
    OneSpeed {
        /// Group of the runs.
        group: String,
        /// The speed \[km/h\].
        speed: f64,
    },
}

/// Levels of one run at one coast-by receiver.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RunLevels {
    /// Road, load and settings, as far as they are varied.
    pub group: String,
    /// Name of the receiver.
    pub receiver: String,
    /// Number of tyres that the receiver hears.
    pub tyres: usize,
    /// Speed \[km/h\].
    pub speed: f64,
    /// Third octaves of the sound power of four tyres \[dB re 1 pW\], from the sources of CNOSSOS-EU and of Nord2000.
    pub power: [Vec<BandLevel>; 2],
    /// Errors of these, but for those of the models' sources.
    pub errors: LevelErrors,
    /// Maximum of the passage \[dB(A)\], with its bands.
    pub maximum: Option<TotalLevel>,
    /// Number of passages that the maximum is averaged over, and the standard error of that mean \[dB\], where it is
    /// known.
    pub passages: Option<(usize, Option<f64>)>,
}

/// Levels of a run at its coast-by receivers.
pub(super) fn run_levels(label: &Label, run: &Stored) -> Result<Vec<RunLevels>, EmissionError> {
    let name = label.name.clone();
    if !run.summary.complete {
        return Err(EmissionError::Unfinished { name });
    }
    let speed = run.plan.scene.rolling.speed_kmh;
    let reported = run.summary.sound.iter().flat_map(|sound| &sound.receivers);
    let reported: Vec<_> = reported.collect();
    let levels = run.levels(SOUND_FILE, LEVEL)?.unwrap_or_default();
    let mut all = Vec::new();
    if let Some(sound) = run.plan.sound() {
        for receiver in sound.receivers.iter().filter(|receiver| receiver.is_passed()) {
            let levels = levels.iter().find(|(name, _)| *name == receiver.name);
            let summary = reported.iter().find(|summary| summary.name == receiver.name);
            let (Some((_, levels)), Some(summary)) = (levels, summary) else { continue };
            let positions: Vec<[f64; 3]> = sound.counted(receiver).map(|point| sound.path.positions[point]).collect();
            let power = [PointSources::CNOSSOS_EU, PointSources::NORD2000].map(|sources| {
                let one = |of: &BandLevel| {
                    let level = sources.power_level(of.level, of.band, &positions, &sound.path.air)
                        + to_vehicle(receiver.tyres());
                    BandLevel { mean_square: 10.0_f64.powf(0.1 * level), level, ..*of }
                };
                levels.iter().map(one).collect()
            });
            let spectrum = run.spectrum(SOUND_LEVEL, &receiver.name);
            let weighted = spectrum.map_or(&[][..], |spectrum| &spectrum.levels);
            all.push(RunLevels {
                group: label.settings_beside_speed(),
                receiver: receiver.name.clone(),
                tyres: receiver.tyres(),
                speed,
                power,
                errors: spectrum.map(|spectrum| spectrum.errors.clone()).unwrap_or_default(),
                maximum: summary.rated(weighted).level,
                passages: summary.pass_by.as_ref().map(|pass_by| (pass_by.passages, pass_by.standard_error)),
            });
        }
    }
    if all.is_empty() { Err(EmissionError::NoPassage { name }) } else { Ok(all) }
}

/// Level of a vehicle's tyres over that of `tyres` of them \[dB\]: mean squares add.
fn to_vehicle(tyres: usize) -> f64 {
    10.0 * (Vehicle::TYRES as f64 / tyres as f64).log10()
}

/// Octave bands of CNOSSOS-EU, 63 Hz to 8 kHz, from the third octaves within; only those whose three third octaves are
/// all present.
pub(super) fn octaves(third_octaves: &[BandLevel]) -> Vec<BandLevel> {
    let octave = |middle: i32| {
        let three: Vec<&BandLevel> = third_octaves.iter().filter(|of| (of.band.0 - middle).abs() <= 1).collect();
        let level = energetic_sum(three.iter().map(|of| of.level));
        let mean_square = three.iter().map(|of| of.mean_square).sum();
        let valid = three.iter().all(|of| of.valid);
        (three.len() == 3).then_some(BandLevel { band: ThirdOctaveBand(middle), mean_square, level, valid })
    };
    (-12..=9).step_by(3).filter_map(octave).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Bands with these levels \[dB\], valid below number 3.
    pub(in crate::study::emission) fn bands(levels: &[(i32, f64)]) -> Vec<BandLevel> {
        let one = |&(band, level): &(i32, f64)| BandLevel {
            band: ThirdOctaveBand(band),
            mean_square: 10.0_f64.powf(0.1 * level),
            level,
            valid: band < 3,
        };
        levels.iter().map(one).collect()
    }

    #[test]
    fn an_octave_is_the_energy_of_its_three_third_octaves() {
        let thirds = bands(&[(-1, 60.0), (0, 60.0), (1, 60.0), (2, 70.0), (3, 60.0), (4, 50.0), (5, 40.0)]);
        let found = octaves(&thirds);
        assert_eq!(found.iter().map(|of| (of.band.0, of.valid)).collect::<Vec<_>>(), [(0, true), (3, false)]);
        assert!((found[0].level - 60.0 - 10.0 * 3.0_f64.log10()).abs() < 1e-12);
        assert!((found[1].level - 10.0 * 1.11e7_f64.log10()).abs() < 1e-12);
        assert!((10.0 * found[1].mean_square.log10() - found[1].level).abs() < 1e-12);
    }

    #[test]
    fn four_tyres_are_6_db_above_one() {
        assert!((to_vehicle(1) - 6.0206).abs() < 1e-4 && to_vehicle(4).abs() < 1e-12);
    }
}
