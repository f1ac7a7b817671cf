//! Error of contact over slices compared with contact over cells, by third octave, apart from the numerical error of
//! either.

use serde::{Deserialize, Serialize};

use super::third_octave::ThirdOctaveBand;

/// Error of one kind of levels in a band \[dB\]: [`SliceErrors::force`] or [`SliceErrors::sound`].
pub(crate) type Part = fn(&SliceErrors, ThirdOctaveBand) -> Option<f64>;

/// Errors of a run's levels, as far as they are known.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct SliceErrors {
    /// Root-mean-square height of the road's macrotexture \[m\].
    pub macrotexture: f64,
    /// Largest error of a valid level \[dB\].
    pub largest: f64,
    /// Frequency \[Hz\] up to which levels of force and vibration have at most that error.
    pub force_valid_to: f64,
    /// Frequency \[Hz\] up to which levels of sound have at most that error.
    pub sound_valid_to: f64,
    /// Errors by band.
    pub bands: Vec<SliceLevelError>,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct SliceLevelError {
    /// Nominal mid-frequency of the band \[Hz\].
    pub nominal_hz: f64,
    /// Error of force and vibration \[dB\].
    pub force_db: f64,
    /// Error of sound \[dB\].
    pub sound_db: f64,
}

impl SliceErrors {
    /// From the errors of force and sound \[dB\] in successive bands from `first` on. Levels are valid up to the last
    /// band before an error is above `largest`; past the last band no error is known, and no level is valid.
    pub(crate) fn new(macrotexture: f64, largest: f64, first: ThirdOctaveBand, force: &[f64], sound: &[f64]) -> Self {
        let valid_to = |errors: &[f64]| {
            let within = errors.iter().take_while(|error| **error <= largest).count();
            ThirdOctaveBand(first.0 + within as i32 - 1).mid_frequency()
        };
        let bands = (first.0..).map(ThirdOctaveBand).zip(force.iter().zip(sound));
        let bands = bands.map(|(band, (&force_db, &sound_db))| SliceLevelError {
            nominal_hz: band.nominal_frequency(),
            force_db,
            sound_db,
        });
        Self {
            macrotexture,
            largest,
            force_valid_to: valid_to(force),
            sound_valid_to: valid_to(sound),
            bands: bands.collect(),
        }
    }

    /// Error of levels of force and vibration in a band \[dB\], where it is known.
    pub fn force(&self, band: ThirdOctaveBand) -> Option<f64> {
        self.of(band).map(|error| error.force_db)
    }

    /// Error of levels of sound in a band \[dB\], where it is known.
    pub(crate) fn sound(&self, band: ThirdOctaveBand) -> Option<f64> {
        self.of(band).map(|error| error.sound_db)
    }

    /// Errors by band \[dB\], none where nothing is known; `part` is [`Self::force`] or [`Self::sound`].
    pub(crate) fn by_band(errors: Option<&Self>, part: Part) -> Vec<(ThirdOctaveBand, f64)> {
        let Some(errors) = errors else { return Vec::new() };
        let bands = errors.bands.iter().filter_map(|error| ThirdOctaveBand::containing(error.nominal_hz));
        bands.filter_map(|band| Some((band, part(errors, band)?))).collect()
    }

    fn of(&self, band: ThirdOctaveBand) -> Option<&SliceLevelError> {
        let is_it = |error: &&SliceLevelError| ThirdOctaveBand::containing(error.nominal_hz) == Some(band);
        self.bands.iter().find(is_it)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_valid_up_to_the_first_band_that_is_off() {
        let errors = SliceErrors::new(5e-4, 2.0, ThirdOctaveBand(-2), &[1.0, 2.0, 2.5], &[3.0, 3.0, 3.0]);
        let at = |n: i32| ThirdOctaveBand(n).mid_frequency();
        let ends = [errors.force_valid_to, errors.sound_valid_to];
        assert_eq!(ends.map(f64::to_bits), [at(-1), at(-3)].map(f64::to_bits));
        let band = ThirdOctaveBand;
        assert_eq!(
            [errors.force(band(-1)), errors.sound(band(-1)), errors.force(band(1))],
            [Some(2.0), Some(3.0), None]
        );
        let last = SliceErrors::new(5e-4, 2.0, band(-2), &[1.0], &[1.0]).force_valid_to;
        assert_eq!(last.to_bits(), at(-2).to_bits());
    }
}
