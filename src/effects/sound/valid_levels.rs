//! Levels over the valid bands of a spectrum.

use crate::response::PowerSpectrum;
use crate::results::spectra::LOWEST_FREQUENCY;
use crate::sound::{FrequencyWeighting, SoundLevels};

/// Standard error of the A-weighted level over the valid bands \[dB\].
pub(super) fn standard_error_a(spectrum: &PowerSpectrum, levels: &SoundLevels) -> Option<f64> {
    let valid = levels.a_weighted.iter().filter(|level| level.valid);
    FrequencyWeighting::A.of_spectrum(spectrum).standard_error(valid.map(|level| level.band))
}

/// Levels whose overall ones are those of the valid bands.
pub(super) fn over_valid_bands(spectrum: &PowerSpectrum) -> SoundLevels {
    SoundLevels::of(spectrum, LOWEST_FREQUENCY..f64::INFINITY).over_valid_bands()
}
