//! Levels of a sound pressure re 20 uPa: third octaves and overall, unweighted and A-weighted.
//!
//! The A-weighting is applied to the narrow bands before they are summed, so a band's A-weighted level is that of its
//! content, and not its level weighted at its middle.

use std::ops::Range;

use super::covered::CoveredBands;
use super::weighting::FrequencyWeighting;
use crate::response::{BandLevel, PowerSpectrum};

/// Reference pressure p_0 of levels \[Pa\] (ISO 1683).
pub const REFERENCE_PRESSURE: f64 = 20e-6;

/// 10 lg(mean square/p_0^2) \[dB re 20 uPa\] of a mean square \[Pa^2\]; minus infinity for silence.
pub fn level(mean_square: f64) -> f64 {
    10.0 * (mean_square / (REFERENCE_PRESSURE * REFERENCE_PRESSURE)).log10()
}

/// Mean square of a level \[Pa^2\]: the inverse of [`level`].
pub fn mean_square(level: f64) -> f64 {
    REFERENCE_PRESSURE * REFERENCE_PRESSURE * 10.0_f64.powf(0.1 * level)
}

/// Level of several incoherent sources \[dB\], such as the four tyres of a car, each at a different receiver position
/// ([`crate::scene::Vehicle::seen_from_tyres`]): 10 lg sum 10^(L/10). Minus infinity for none.
///
/// ```
/// use tyrewave::sound::energetic_sum;
///
/// assert!((energetic_sum([60.0; 4]) - 66.02).abs() < 0.01);
/// ```
pub fn energetic_sum(levels: impl IntoIterator<Item = f64>) -> f64 {
    10.0 * levels.into_iter().map(|level| 10.0_f64.powf(0.1 * level)).sum::<f64>().log10()
}

/// Level of the mean of the mean squares \[dB\], over microphones or times; NaN for none.
pub fn energetic_mean(levels: impl IntoIterator<Item = f64>) -> f64 {
    let mut count = 0.0;
    let sum = energetic_sum(levels.into_iter().inspect(|_| count += 1.0));
    if count > 0.0 { sum - 10.0 * f64::log10(count) } else { f64::NAN }
}

/// Levels of one pressure \[dB re 20 uPa\].
#[derive(Clone, Debug, PartialEq)]
pub struct SoundLevels {
    /// Third octaves, unweighted, lowest first.
    pub third_octaves: Vec<BandLevel>,
    /// The same bands, A-weighted.
    pub a_weighted: Vec<BandLevel>,
    /// Overall level: sum of the bands \[dB\].
    pub overall: f64,
    /// Overall A-weighted level: sum of the A-weighted bands \[dB(A)\].
    pub overall_a: f64,
}

impl SoundLevels {
    /// Levels of a spectrum of pressures \[Pa^2\], over the bands that lie whole within `frequencies` \[Hz\] and below
    /// the Nyquist frequency. The overall levels are sums over these bands alone.
    pub fn of(spectrum: &PowerSpectrum, frequencies: Range<f64>) -> Self {
        let bands = |spectrum: &PowerSpectrum| -> Vec<BandLevel> {
            let all = spectrum.third_octaves(frequencies.start, REFERENCE_PRESSURE);
            // As at the Nyquist frequency: a band that ends on the limit must not be lost to rounding.
            let within = |band: &BandLevel| band.band.upper_edge() <= frequencies.end * (1.0 + 1e-12);
            all.into_iter().filter(within).collect()
        };
        let third_octaves = bands(spectrum);
        let a_weighted = bands(&FrequencyWeighting::A.of_spectrum(spectrum));
        let [overall, overall_a] = [&third_octaves, &a_weighted].map(level_of);
        Self { third_octaves, a_weighted, overall, overall_a }
    }

    /// The same bands; the overall levels become sums over the valid bands alone.
    #[must_use]
    pub fn over_valid_bands(self) -> Self {
        let overall = |bands: &[BandLevel]| level_of(bands.iter().filter(|band| band.valid));
        Self { overall: overall(&self.third_octaves), overall_a: overall(&self.a_weighted), ..self }
    }

    /// Range of the valid bands; `None` if there is none.
    pub(crate) fn covered(&self) -> Option<CoveredBands> {
        let valid: Vec<BandLevel> = self.a_weighted.iter().copied().filter(|band| band.valid).collect();
        CoveredBands::of(&valid)
    }
}

/// Level of the sum of several bands \[dB\].
fn level_of<'a>(bands: impl IntoIterator<Item = &'a BandLevel>) -> f64 {
    level(bands.into_iter().map(|band| band.mean_square).sum())
}

/// Spectrum of a pressure from its one-sided power spectral density \[Pa^2/Hz\] at 0, df, 2 df, ... up to half of
/// `rate` \[Hz\] at most, such as a transfer function times a source spectrum. `None` for no value, a negative or
/// undefined one, or a distance df that is not positive.
pub fn spectrum_of_density(density: &[f64], resolution: f64, rate: f64) -> Option<PowerSpectrum> {
    let nyquist = 0.5 * rate;
    let highest = density.len().checked_sub(1)? as f64 * resolution;
    let sound = resolution > 0.0 && highest <= nyquist * (1.0 + 1e-12) && density.iter().all(|value| *value >= 0.0);
    // As in `PowerSpectrum`: a bin covers (k -+ 1/2) df, cut at 0 and at the Nyquist frequency.
    let width = |bin: usize| {
        let middle = bin as f64 * resolution;
        (middle + 0.5 * resolution).min(nyquist) - (middle - 0.5 * resolution).max(0.0)
    };
    let power = density.iter().enumerate().map(|(bin, density)| density * width(bin)).collect();
    sound.then_some(PowerSpectrum::of_powers(power, resolution, nyquist))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::ThirdOctaveBand;

    /// White noise of 1 Pa^2/Hz up to 8 kHz.
    fn white() -> PowerSpectrum {
        spectrum_of_density(&[1.0; 8001], 1.0, 16e3).unwrap()
    }

    #[test]
    fn white_noise_has_the_levels_of_the_closed_form() {
        let levels = SoundLevels::of(&white(), 100.0..5000.0);
        let middles: Vec<f64> = levels.third_octaves.iter().map(|band| band.band.nominal_frequency()).collect();
        assert_eq!((middles[0], middles[middles.len() - 1]), (125.0, 4000.0));
        for (band, weighted) in levels.third_octaves.iter().zip(&levels.a_weighted) {
            let exact = 10.0 * (band.band.width() / 4e-10).log10();
            assert!((band.level - exact).abs() < 1e-9, "{:?}: {} dB, exactly {exact} dB", band.band, band.level);
            // Across a band the weight is nearly linear: its middle is right to 0.15 dB.
            let weight = FrequencyWeighting::A.decibels(band.band.mid_frequency());
            assert!((weighted.level - band.level - weight).abs() < 0.15, "{:?}", band.band);
        }
        let width = ThirdOctaveBand(6).upper_edge() - ThirdOctaveBand(-9).lower_edge();
        assert!((levels.overall - 10.0 * (width / 4e-10).log10()).abs() < 1e-9);
        let sum = energetic_sum(levels.a_weighted.iter().map(|band| band.level));
        assert!((levels.overall_a - sum).abs() < 1e-9);
    }

    #[test]
    fn density_and_power_are_two_sides_of_one_spectrum() {
        let spectrum = white();
        assert!((spectrum.mean_square() - 8000.0).abs() < 1e-9);
        assert!(spectrum.density().all(|(_, density)| (density - 1.0).abs() < 1e-9));
        assert!(spectrum_of_density(&[], 1.0, 16e3).is_none());
        assert!(spectrum_of_density(&[1.0; 8002], 1.0, 16e3).is_none(), "beyond the Nyquist frequency");
        assert!(spectrum_of_density(&[1.0, -1.0], 1.0, 16e3).is_none());
        assert!(spectrum_of_density(&[1.0, f64::NAN], 1.0, 16e3).is_none());
        assert!(spectrum_of_density(&[1.0, 1.0], 0.0, 16e3).is_none());
    }

    #[test]
    fn sums_and_means_are_those_of_energies() {
        assert!((level(1.0) - 93.979).abs() < 1e-3, "1 Pa is 94 dB");
        assert!((mean_square(level(0.25)) - 0.25).abs() < 1e-15);
        assert!((energetic_sum([70.0, 70.0]) - 73.0103).abs() < 1e-4);
        assert!((energetic_sum([70.0, f64::NEG_INFINITY]) - 70.0).abs() < 1e-12);
        assert!((energetic_mean([70.0, 60.0]) - 67.4036).abs() < 1e-4);
        assert!(energetic_sum([]).is_infinite() && energetic_mean([]).is_nan());
        let silent = spectrum_of_density(&[0.0; 8001], 1.0, 16e3).unwrap();
        assert!(SoundLevels::of(&silent, 100.0..5000.0).overall_a.is_infinite());
    }
}
