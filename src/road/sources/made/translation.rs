//! The Gaussian spectrum whose transformed surface has the wanted levels.
//!
//! 1. The profile spectrum of a Gaussian surface in many narrow cells, from its rings; a cosine transform gives its
//!    correlation r.
//! 2. The transformed surface has the correlation sum a_k^2 r^k ([`HeightShape::powers`]); the inverse transform gives
//!    its profile spectrum, and so its bands.
//! 3. Each band of the Gaussian is scaled by the ratio of the wanted and the transformed energy, and the rings are
//!    fitted again. After some rounds the wanted levels are reached as far as a monotone transformation allows; the
//!    remaining deviation is reported per band, as for a spectrum that no isotropic surface has.

use realfft::RealFftPlanner;

use super::rings::RingSpectrum;
use super::shape::HeightShape;
use super::target::{TargetSpectrum, WavenumberBand};
use crate::road::texture::{BandFit, line_inside};

/// Highest wavenumber over that of the spectrum: products of waves have wavelengths as short as that, those that
/// matter.
const HIGHEST: f64 = 4.0;
/// Number of cells in the lowest wavenumber, and largest number of cells.
const CELLS: (f64, f64) = (8.0, 16_384.0);
/// Number of rounds; the best one is taken.
const ROUNDS: usize = 12;
/// Largest change of a band's energy in a round, as a factor.
const LARGEST_CHANGE: f64 = 2.0;

/// Spectrum of the Gaussian surface; its fit is that of the transformed surface.
pub(super) fn corrected(target: &TargetSpectrum, shape: &HeightShape) -> RingSpectrum {
    let highest = HIGHEST / target.shortest();
    let count = (CELLS.0 * highest * target.longest()).clamp(64.0, CELLS.1) as usize;
    let cell = highest / count as f64;
    let powers = shape.powers();
    let mut asked = target.clone();
    let mut best: Option<(f64, RingSpectrum)> = None;
    for _ in 0..ROUNDS {
        // 1. and 2. The transformed bands of the present Gaussian.
        let spectrum = RingSpectrum::fit(&asked);
        let lines = transformed(&spectrum.profile(cell, count), &powers);
        let found: Vec<f64> = target.bands().iter().map(|band| energy(&lines, cell, band)).collect();
        let fit: Vec<BandFit> = target.bands().iter().zip(&found).map(|(band, &found)| band.fit(found)).collect();
        let worst = fit.iter().map(BandFit::deviation).fold(0.0, f64::max);
        if best.as_ref().is_none_or(|(known, _)| worst < *known) {
            best = Some((worst, spectrum.with_fit(fit)));
        }
        // 3. Scaled for the next round.
        for ((asked, band), found) in asked.bands_mut().iter_mut().zip(target.bands()).zip(&found) {
            asked.energy *= (band.energy / found).clamp(1.0 / LARGEST_CHANGE, LARGEST_CHANGE);
        }
    }
    best.map_or_else(|| RingSpectrum::fit(target), |(_, spectrum)| spectrum)
}

/// Energies by cell of the transformed surface's profiles, up to the wavenumber of the Gaussian's.
fn transformed(energies: &[f64], powers: &[f64]) -> Vec<f64> {
    let length = 2 * energies.len();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, backward) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let mut lines = backward.make_input_vec();
    for (line, &energy) in lines.iter_mut().zip(energies) {
        line.re = 0.5 * energy;
    }
    lines[0].re *= 2.0;
    let mut correlation = backward.make_output_vec();
    // The lengths are the planner's, and the first and last line are real: it cannot fail.
    if backward.process(&mut lines, &mut correlation).is_err() {
        return energies.to_vec();
    }
    let variance = correlation[0];
    for value in &mut correlation {
        let r = *value / variance;
        *value = variance * powers.iter().rev().fold(0.0, |sum, power| (sum + power) * r);
    }
    if forward.process(&mut correlation, &mut lines).is_err() {
        return energies.to_vec();
    }
    let scale = 1.0 / length as f64;
    lines.iter().enumerate().map(|(line, value)| if line == 0 { scale } else { 2.0 * scale } * value.re).collect()
}

/// Energy of a band, cells at its edges counted by their part inside.
fn energy(lines: &[f64], cell: f64, band: &WavenumberBand) -> f64 {
    let inside = |line: usize| line_inside(line, cell, band.lower, band.upper);
    lines.iter().enumerate().map(|(line, energy)| inside(line) * energy).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::road::texture::level;

    #[test]
    fn a_gaussian_is_transformed_into_itself() {
        let spectrum = RingSpectrum::fit(&TargetSpectrum::dense_asphalt());
        let energies = spectrum.profile(0.5, 2048);
        let mut powers = vec![0.0; 16];
        powers[0] = 1.0;
        let found = transformed(&energies, &powers);
        let largest = energies.iter().copied().fold(0.0, f64::max);
        assert!(energies.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-12 * largest));
        // The lines are the profile's: bands from them are those of the fit.
        for (band, fit) in TargetSpectrum::dense_asphalt().bands().iter().zip(spectrum.band_fit()) {
            let found = level(energy(&energies, 0.5, band));
            assert!((found - fit.fitted).abs() < 0.1, "{} for {}", found, fit.fitted);
        }
    }

    #[test]
    fn levels_of_asphalt_survive_the_moments_of_chip_seals() {
        let target = TargetSpectrum::dense_asphalt();
        let plain = RingSpectrum::fit(&target).worst_deviation();
        for (skewness, kurtosis) in [(-0.48, 2.8), (-0.3, 2.5), (-0.13, 2.4)] {
            let shape = HeightShape::new(skewness, kurtosis).unwrap().unwrap();
            let spectrum = corrected(&target, &shape);
            println!("{skewness}, {kurtosis}: worst {:.2} dB, {plain:.2} dB of a Gaussian", spectrum.worst_deviation());
            for band in spectrum.band_fit() {
                println!("   {:6.1} mm {:+.2} dB", 1e3 * band.wavelength, band.fitted - band.target);
            }
            assert!(spectrum.worst_deviation() < plain + 0.5, "{:?}", spectrum.band_fit());
        }
    }
}
