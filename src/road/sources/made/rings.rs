//! The isotropic two-dimensional spectrum whose profiles have given band energies.
//!
//! A surface of waves of one wavenumber k in all directions, of variance w, has on a straight line the one-sided
//! spectrum (2 w/pi) / sqrt(k^2 - q^2), q < k (the line meets a wave at the angle a as q = k cos a; all a are equally
//! likely). Hence the share of w that a profile has between q1 and q2 is (2/pi) (asin min(q2/k, 1) - asin min(q1/k,
//! 1)): a wave contributes to every longer wavelength, so not every profile spectrum belongs to an isotropic surface.
//!
//! 1. Every band is divided into three rings, the variance of each spread evenly over ln k.
//! 2. The share of ring j in band i is integrated over the ring, giving a matrix.
//! 3. Non-negative ring variances are found by non-negative least squares of the relative band energies. There are more
//!    rings than bands; a small penalty on the difference of neighbouring rings selects a smooth one of the many
//!    solutions.
//! 4. The remaining deviation is reported per band.

use super::nnls;
use super::target::{TargetSpectrum, WavenumberBand};
use crate::road::texture::BandFit;

/// Points per ring of the integral over ln k; the integrand has square-root corners only, the error is below 1e-4.
const POINTS: usize = 256;
/// Points per ring for the whole spectrum of a profile, in cells narrower than a ring.
const FEW_POINTS: usize = 16;

/// Rings per band: the position within a band decides how much a wave contributes to the next longer band, so dips of
/// a decibel or two between bands need more than one.
const RINGS_PER_BAND: usize = 3;
/// Weight of the smoothness penalty relative to the relative error of the band energies.
const SMOOTHNESS: f64 = 0.01;

/// An isotropic two-dimensional spectrum: rings in wavenumber.
#[derive(Clone, Debug, PartialEq)]
pub struct RingSpectrum {
    rings: Vec<Ring>,
    fit: Vec<BandFit>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Ring {
    lower: f64,
    upper: f64,
    /// Two-sided spectral density times k^2, constant in the ring \[m^2\].
    strength: f64,
}

impl Ring {
    fn variance(&self) -> f64 {
        2.0 * std::f64::consts::PI * self.strength * (self.upper / self.lower).ln()
    }
}

impl RingSpectrum {
    /// The spectrum nearest to `target`, by non-negative least squares of the relative band energies.
    pub fn fit(target: &TargetSpectrum) -> Self {
        let bands = target.bands();
        let places: Vec<WavenumberBand> = bands.iter().flat_map(divided).collect();
        let (count, rings) = (bands.len(), places.len());
        let mut matrix = vec![0.0; (count + rings - 1) * rings];
        for (i, band) in bands.iter().enumerate() {
            for (j, ring) in places.iter().enumerate() {
                // Unknowns are variances relative to the target energies: all of order one.
                matrix[i * rings + j] = share(ring, band) * ring.energy / band.energy;
            }
        }
        for j in 0..rings - 1 {
            let row = &mut matrix[(count + j) * rings..][..rings];
            (row[j], row[j + 1]) = (SMOOTHNESS, -SMOOTHNESS);
        }
        let right: Vec<f64> = (0..count + rings - 1).map(|i| if i < count { 1.0 } else { 0.0 }).collect();
        let solution = nnls::solve(&matrix, rings, &right);
        let found = places.iter().zip(&solution).map(|(place, relative)| {
            let variance = relative * place.energy;
            let strength = variance / (2.0 * std::f64::consts::PI * (place.upper / place.lower).ln());
            Ring { lower: place.lower, upper: place.upper, strength }
        });
        let fit = bands.iter().enumerate().map(|(i, band)| {
            let relative: f64 = (0..rings).map(|j| matrix[i * rings + j] * solution[j]).sum();
            band.fit(band.energy * relative)
        });
        Self { fit: fit.collect(), rings: found.collect() }
    }

    /// Two-sided spectral density S(kx, ky) \[m^2 per (cycles/m)^2\] at k^2 = kx^2 + ky^2 = `square`.
    pub fn density(&self, square: f64) -> f64 {
        let index = self.rings.partition_point(|ring| ring.upper * ring.upper <= square);
        match self.rings.get(index) {
            Some(ring) if ring.lower * ring.lower <= square => ring.strength / square,
            _ => 0.0,
        }
    }

    /// The same surface with another comparison of its bands with the wanted ones.
    pub(crate) fn with_fit(self, fit: Vec<BandFit>) -> Self {
        Self { fit, ..self }
    }

    /// Mean square of a profile by cells of wavenumber \[m^2\]; cell j extends from (j - 1/2) to (j + 1/2) `cell`
    /// (cycles per metre), j = 0, ..., `count` - 1.
    pub fn profile(&self, cell: f64, count: usize) -> Vec<f64> {
        let below = |edge: f64| -> f64 {
            self.rings.iter().map(|ring| ring.variance() * share_below(ring.lower, ring.upper, edge, FEW_POINTS)).sum()
        };
        let edges: Vec<f64> = (0..=count).map(|line| below((line as f64 - 0.5).max(0.0) * cell)).collect();
        edges.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    /// Variance of the surface \[m^2\].
    pub fn variance(&self) -> f64 {
        self.rings.iter().map(Ring::variance).sum()
    }

    /// Levels of the profiles in each band and the wanted ones, longest wavelength first.
    pub(crate) fn band_fit(&self) -> &[BandFit] {
        &self.fit
    }

    /// Largest deviation from the wanted levels \[dB\].
    pub fn worst_deviation(&self) -> f64 {
        self.fit.iter().map(BandFit::deviation).fold(0.0, f64::max)
    }
}

/// The rings of a band, each with an equal part of the band's energy.
fn divided(band: &WavenumberBand) -> impl Iterator<Item = WavenumberBand> + use<> {
    let (lower, energy) = (band.lower, band.energy / RINGS_PER_BAND as f64);
    let ratio = (band.upper / band.lower).powf(1.0 / RINGS_PER_BAND as f64);
    (0..RINGS_PER_BAND as i32).map(move |part| WavenumberBand {
        lower: lower * ratio.powi(part),
        upper: lower * ratio.powi(part + 1),
        energy,
    })
}

/// Share of the variance of a ring with the wavenumbers of `ring` that a profile has in `band`.
fn share(ring: &WavenumberBand, band: &WavenumberBand) -> f64 {
    let below = |edge: f64| share_below(ring.lower, ring.upper, edge, POINTS);
    below(band.upper) - below(band.lower)
}

/// Share of a variance spread evenly over ln k between two wavenumbers that a profile has below `edge`: the mean over
/// so many points.
fn share_below(lower: f64, upper: f64, edge: f64, points: usize) -> f64 {
    if edge >= upper {
        return 1.0;
    }
    let log_width = (upper / lower).ln();
    let sum: f64 = (0..points)
        .map(|point| lower * (log_width * (point as f64 + 0.5) / points as f64).exp())
        .map(|k| (edge / k).min(1.0).asin())
        .sum();
    std::f64::consts::FRAC_2_PI * sum / points as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::road::texture::{band_edges, level};

    #[test]
    fn shares_of_all_profile_bands_add_up_to_the_variance() {
        let (lower, upper) = band_edges(-20);
        let ring = WavenumberBand { lower, upper, energy: 1.0 };
        let edges = [0.0, 10.0, 50.0, lower, upper];
        let sum: f64 = edges
            .windows(2)
            .map(|pair| share(&ring, &WavenumberBand { lower: pair[0], upper: pair[1], energy: 1.0 }))
            .sum();
        assert!((sum - 1.0).abs() < 1e-12);
    }

    #[test]
    fn dense_asphalt_all_but_belongs_to_an_isotropic_surface() {
        // Its dip of 2 dB at 79 mm is a little deeper than the neighbouring shorter waves allow: 0.5 dB remain there.
        let spectrum = RingSpectrum::fit(&TargetSpectrum::dense_asphalt());
        assert!(spectrum.worst_deviation() < 0.55, "{:?}", spectrum.band_fit());
    }

    #[test]
    fn a_spectrum_that_a_surface_has_is_recovered() {
        // Band energies of an isotropic surface with S ~ k^-4: its profiles have k^-3.
        let law = crate::scene::PowerLawTexture { rms: 1e-3, exponent: 3.0, longest: 0.2, shortest: 0.002 };
        let spectrum = RingSpectrum::fit(&TargetSpectrum::power_law(&law).unwrap());
        assert!(spectrum.worst_deviation() < 0.02, "{:?}", spectrum.band_fit());
        let ratio = spectrum.density(400.0) / spectrum.density(1600.0);
        assert!((ratio / 16.0 - 1.0).abs() < 0.2, "{ratio}");
    }

    #[test]
    fn the_surfaces_profile_by_integration_has_the_band_energies() {
        // Independent of `share`: integrate S over all ky, then over the band, on a fine grid.
        let target = TargetSpectrum::third_octaves(&[0.05, 0.04, 0.0315], &[40.0, 44.0, 46.0]).unwrap();
        let spectrum = RingSpectrum::fit(&target);
        for (band, fit) in target.bands().iter().zip(spectrum.band_fit()) {
            let (nx, ny) = (200, 4000);
            let mut energy = 0.0;
            for i in 0..nx {
                let kx = band.lower + (band.upper - band.lower) * (f64::from(i) + 0.5) / f64::from(nx);
                for j in 0..ny {
                    let ky = 40.0 * (f64::from(j) + 0.5) / f64::from(ny);
                    energy += spectrum.density(kx * kx + ky * ky);
                }
            }
            energy *= 4.0 * (band.upper - band.lower) / f64::from(nx) * 40.0 / f64::from(ny);
            assert!((level(energy) - fit.fitted).abs() < 0.02, "{} for {}", level(energy), fit.fitted);
        }
    }

    #[test]
    fn a_spectrum_that_no_isotropic_surface_has_is_reported() {
        // The strong short waves lend the long band more than it may have.
        let target = TargetSpectrum::third_octaves(&[0.1, 0.08], &[20.0, 60.0]).unwrap();
        let spectrum = RingSpectrum::fit(&target);
        assert!(spectrum.worst_deviation() > 1.0);
        assert!(spectrum.variance().is_finite());
    }
}
