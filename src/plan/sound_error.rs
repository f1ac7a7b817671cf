//! Errors of the levels of a planned sound: of the forces, and of the transfer path.

use super::receivers::PlannedReceiver;
use super::sound::Sound;
use crate::radiation::draft::DraftError;
use crate::results::sound::SoundError;
use crate::scene::{Radiation, RadiationQuality, ReceiverPlace};
use crate::sound::receivers::standard;

/// Error of a third octave at the default nodes per wavelength \[dB\]: the worst of single waves (9 against 14 nodes).
/// With 7 nodes it is 0.5 dB, so it falls with about the sixth power. `tyrewave sweep` over `nodes_per_wavelength`,
/// `frequency_tolerance` and `lateral_waves` measures all three.
const ELEMENTS_ERROR: f64 = 0.1;
/// Error of a third octave by interpolation, as a part of the frequencies' tolerance, which is met with intervals of
/// twice the length: 0.009 dB found at 0.2 dB against 0.02 dB (default tyre, coast-by and cpx, to 2.5 kHz).
const FREQUENCIES_ERROR: f64 = 0.05;
/// Error of a third octave at the default lateral waves \[dB\]: 0.009 found against 24 waves, 0.016 with four, 0.004
/// with eight (the same runs), so it falls with about their number's square.
const WAVES_ERROR: f64 = 0.01;
/// Error of a third octave by the rings of a flank that radiates \[dB\]: 1.7 % of the pressure found against boundary
/// elements of the whole body moving up, where the road cuts the shoulders; 0.2 % for breathing.
const RINGS_ERROR: f64 = 0.15;

impl Sound {
    /// Errors of the levels, at the receiver where the transfer's is largest.
    pub(crate) fn error(&self) -> SoundError {
        let all = self.receivers.iter().map(|receiver| self.error_at(receiver));
        let worst = all.reduce(|a, b| if b.way > a.way { b } else { a });
        worst.unwrap_or_else(|| self.with_path(0.0, 0.0, 0.0))
    }

    /// Errors of the levels at a receiver.
    pub(crate) fn error_at(&self, receiver: &PlannedReceiver) -> SoundError {
        let Radiation { quality, nodes_per_wavelength, frequency_tolerance, lateral_waves, .. } = self.path.radiation;
        let waves = WAVES_ERROR * (Radiation::default().lateral_waves as f64 / lateral_waves as f64).powi(2);
        match quality {
            RadiationQuality::Full => {
                let fineness = Radiation::default().nodes_per_wavelength / nodes_per_wavelength;
                let elements = ELEMENTS_ERROR * fineness.powi(6);
                let frequencies = FREQUENCIES_ERROR * frequency_tolerance;
                let rings = if self.path.bead.is_some() { RINGS_ERROR } else { 0.0 };
                let of_path =
                    [elements, frequencies, waves, rings].into_iter().map(|error| error * error).sum::<f64>().sqrt();
                self.with_path(of_path, of_path, 0.0)
            }
            RadiationQuality::Draft => {
                let points = self.path.positions.get(receiver.points.clone()).unwrap_or_default();
                let DraftError { band, from, level } = self.draft_error(&receiver.place, points);
                self.with_path(band + waves, level + waves, from)
            }
        }
    }

    /// Error of a draft over the points of a receiver; infinite where none is stated, which scenes refuse.
    fn draft_error(&self, place: &ReceiverPlace, points: &[[f64; 3]]) -> DraftError {
        let none = DraftError { band: f64::INFINITY, from: 0.0, level: f64::INFINITY };
        let Some(errors) = self.draft else { return none };
        if standard(place).has_stated_draft() {
            return errors.of_standards;
        }
        let all = points.iter().map(|&point| errors.at(point).unwrap_or(none));
        all.reduce(|a, b| if b.band > a.band { b } else { a }).unwrap_or(none)
    }

    /// Errors of forces and transfer path together; `of_path` is the path's for third octaves from a frequency \[Hz\]
    /// on, `of_path_a` that for the A-weighted level \[dB\].
    fn with_path(&self, of_path: f64, of_path_a: f64, from: f64) -> SoundError {
        let (of_forces, forces) = self.stated.ok().unzip();
        let [band, level_a] = [of_path, of_path_a].map(|of_path| forces.map(|forces| forces + of_path));
        SoundError { forces, way: of_path, band, from: from.max(of_forces.unwrap_or(0.0)), level_a }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Plan;
    use crate::scene::{DEFAULT, Preset, Receiver, Scene, StandardReceiver};

    #[test]
    fn the_error_of_a_draft_goes_with_the_place_and_is_the_sum_it_states() {
        let mut scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        let at = |place| Receiver { name: String::new(), place };
        let [beside, ahead] = [[0.0, 2.0, 0.3], [2.0, 0.0, 0.3]].map(|position| ReceiverPlace::Position { position });
        scene.receivers = vec![at(ReceiverPlace::Standard(StandardReceiver::Cpx)), at(beside), at(ahead)];
        scene.radiation.quality = RadiationQuality::Draft;
        (scene.numerics.preset, scene.numerics.fmax) = (Some(Preset::Standard), Some(1000.0));
        let sound = Plan::new(&scene).sound().unwrap();
        let [cpx, beside, ahead] = [0, 1, 2].map(|receiver| sound.error_at(&sound.receivers[receiver]));
        assert!(cpx.band < beside.band && beside.band < ahead.band, "{cpx:?} {beside:?} {ahead:?}");
        assert_eq!(sound.error(), ahead, "the worst stands for all");
        for error in [cpx, beside, ahead] {
            assert_eq!(error.forces, Some(1.0));
            let [band, level] = [error.band, error.level_a].map(Option::unwrap);
            assert!((band - (1.0 + error.way)).abs() < 1e-12 && level < band, "{error:?}");
        }
        scene.numerics.preset = None;
        let error = Plan::new(&scene).sound().unwrap().error();
        assert_eq!((error.forces, error.band, error.level_a), (None, None, None), "that of the forces is not known");
        assert!(error.way > 0.0);
        assert!((cpx.way - sound.draft.unwrap().of_standards.band - WAVES_ERROR).abs() < 1e-12, "{cpx:?}");
    }
}
