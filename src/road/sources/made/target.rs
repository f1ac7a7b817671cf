//! The profile spectrum wanted of a made road, as energies of bands in wavenumber.

use crate::road::error::RoadError;
use crate::road::texture::{
    BandFit, LOWEST_LEVEL, TextureLevel, band_edges, level, mean_square, mid_wavelength, nearest_band,
};
use crate::scene::{MadeRoad, NamedTexture, PowerLawTexture};

/// Expected height of the highest point of a made road over its root-mean-square height.
pub(crate) const PEAK_FACTOR: f64 = 5.0;

/// A wavenumber band and the mean square wanted of a profile in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WavenumberBand {
    /// Lower edge, cycles per metre.
    pub lower: f64,
    /// Upper edge, cycles per metre.
    pub upper: f64,
    /// Mean square of the profile in the band \[m^2\].
    pub energy: f64,
}

impl WavenumberBand {
    /// Comparison of this band's energy, which is wanted, with the one found \[m^2\].
    pub(crate) fn fit(&self, found: f64) -> BandFit {
        let wavelength = 1.0 / (self.lower * self.upper).sqrt();
        BandFit { wavelength, target: level(self.energy), fitted: level(found).max(LOWEST_LEVEL) }
    }
}

/// Band energies of a profile, by rising wavenumber, at least one, not overlapping.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetSpectrum {
    bands: Vec<WavenumberBand>,
}

impl TargetSpectrum {
    /// The spectrum that a scene describes.
    ///
    /// # Errors
    /// For levels without wavelengths, a band given twice, both kinds of spectrum, and values out of range.
    pub fn of(road: &MadeRoad) -> Result<Self, RoadError> {
        let mut target = match (&road.wavelengths, &road.levels, &road.power_law) {
            (None, None, None) => Self::named(road.texture.unwrap_or(NamedTexture::DEFAULT)),
            _ if road.texture.is_some() => return Err(RoadError::TwoSpectra),
            (None, None, Some(law)) => Self::power_law(law)?,
            (wavelengths, levels, None) => {
                Self::third_octaves(wavelengths.as_deref().unwrap_or_default(), levels.as_deref().unwrap_or_default())?
            }
            _ => return Err(RoadError::TwoSpectra),
        };
        let factor = 10.0_f64.powf(0.1 * road.offset);
        target.bands.iter_mut().for_each(|band| band.energy *= factor);
        Ok(target)
    }

    /// The spectrum of a named texture.
    pub fn named(texture: NamedTexture) -> Self {
        Self { bands: texture.levels().map(|(band, level)| third_octave(band, level)).collect() }
    }

    /// The spectrum of dense asphalt, the default road.
    pub fn dense_asphalt() -> Self {
        Self::named(NamedTexture::DEFAULT)
    }

    /// Spectrum of third-octave levels of a profile (dB re 1e-6 m) at mid-wavelengths \[m\], nominal or exact, in any
    /// order.
    ///
    /// # Errors
    /// For lists that are of different length or empty; a wavelength more than 4 % off a mid-wavelength; a band given
    /// twice; a level outside -100 to 120 dB.
    pub fn third_octaves(wavelengths: &[f64], levels: &[f64]) -> Result<Self, RoadError> {
        if wavelengths.is_empty() || wavelengths.len() != levels.len() {
            return Err(RoadError::LevelCount { wavelengths: wavelengths.len(), levels: levels.len() });
        }
        let mut given: Vec<(i32, f64)> = Vec::with_capacity(levels.len());
        for (&wavelength, &level) in wavelengths.iter().zip(levels) {
            if !(wavelength > 0.0 && wavelength.is_finite()) {
                return Err(RoadError::NotPositive { key: "road.wavelengths", value: wavelength });
            }
            let band = nearest_band(wavelength);
            let nearest = mid_wavelength(band);
            if (wavelength / nearest - 1.0).abs() > 0.04 {
                return Err(RoadError::NotThirdOctave { wavelength, nearest });
            }
            if !(-100.0..=120.0).contains(&level) {
                return Err(RoadError::Level { wavelength: nearest, level });
            }
            if given.iter().any(|&(other, _)| other == band) {
                return Err(RoadError::BandTwice { wavelength: nearest });
            }
            given.push((band, level));
        }
        given.sort_by_key(|&(band, _)| std::cmp::Reverse(band));
        Ok(Self { bands: given.into_iter().map(|(band, level)| third_octave(band, level)).collect() })
    }

    /// Spectrum of measured levels; levels below -100 dB are raised to that.
    ///
    /// # Errors
    /// As [`Self::third_octaves`].
    pub fn measured(levels: &[TextureLevel]) -> Result<Self, RoadError> {
        let wavelengths: Vec<f64> = levels.iter().map(|band| band.wavelength).collect();
        let levels: Vec<f64> = levels.iter().map(|band| band.level.max(-100.0)).collect();
        Self::third_octaves(&wavelengths, &levels)
    }

    /// One-sided profile spectrum proportional to wavenumber^(-exponent) between two wavelengths, with the given rms
    /// there, in bands of at most a third octave.
    ///
    /// # Errors
    /// For a range shorter than a third octave, and values that are not positive and finite.
    pub fn power_law(law: &PowerLawTexture) -> Result<Self, RoadError> {
        let &PowerLawTexture { rms, exponent, longest, shortest } = law;
        let ratio = longest / shortest;
        let sound = rms > 0.0 && rms.is_finite() && exponent.abs() <= 20.0 && shortest > 0.0 && longest.is_finite();
        if !sound || ratio.is_nan() || ratio < 1.2589 {
            return Err(RoadError::PowerLaw { rms, exponent, longest, shortest });
        }
        let count = (10.0 * ratio.log10() - 1e-9).ceil().max(1.0) as usize;
        let edge = |index: usize| ratio.powf(index as f64 / count as f64);
        // In units of the lowest wavenumber, so that no exponent overflows early.
        let integral = |from: f64, to: f64| {
            let power = 1.0 - exponent;
            if power.abs() < 1e-9 { (to / from).ln() } else { (to.powf(power) - from.powf(power)) / power }
        };
        let total = integral(1.0, ratio);
        let bands = (0..count)
            .map(|index| (edge(index), edge(index + 1)))
            .map(|(from, to)| WavenumberBand {
                lower: from / longest,
                upper: to / longest,
                energy: rms * rms * integral(from, to) / total,
            })
            .collect();
        Ok(Self { bands })
    }

    /// The bands, by rising wavenumber.
    pub fn bands(&self) -> &[WavenumberBand] {
        &self.bands
    }

    /// The bands, for changes of their energies.
    pub fn bands_mut(&mut self) -> &mut [WavenumberBand] {
        &mut self.bands
    }

    /// Expected height of the highest point of the road above its plane \[m\]: [`PEAK_FACTOR`] times the
    /// root-mean-square height.
    pub fn highest(&self) -> f64 {
        PEAK_FACTOR * self.bands.iter().map(|band| band.energy).sum::<f64>().sqrt()
    }

    /// Longest wavelength of the spectrum \[m\].
    pub fn longest(&self) -> f64 {
        self.bands.first().map_or(f64::NAN, |band| 1.0 / band.lower)
    }

    /// Shortest wavelength of the spectrum \[m\].
    pub fn shortest(&self) -> f64 {
        self.bands.last().map_or(f64::NAN, |band| 1.0 / band.upper)
    }
}

fn third_octave(band: i32, level: f64) -> WavenumberBand {
    let (lower, upper) = band_edges(band);
    WavenumberBand { lower, upper, energy: mean_square(level) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_in_which_a_surface_has_nothing_has_the_lowest_level() {
        let fit = WavenumberBand { lower: 1.0, upper: 2.0, energy: 1e-12 }.fit(0.0);
        assert!((fit.fitted - LOWEST_LEVEL).abs() < 1e-12 && fit.deviation().is_finite(), "{fit:?}");
    }

    #[test]
    fn power_law_has_its_rms_and_slope() {
        for exponent in [0.0, 1.0, 2.0, 3.5] {
            let law = PowerLawTexture { rms: 1e-3, exponent, longest: 0.1, shortest: 0.005 };
            let target = TargetSpectrum::power_law(&law).unwrap();
            let total: f64 = target.bands().iter().map(|band| band.energy).sum();
            assert!((total.sqrt() / 1e-3 - 1.0).abs() < 1e-12);
            let bands = target.bands();
            let ratio = bands[1].energy / bands[0].energy;
            let width = bands[0].upper / bands[0].lower;
            assert!((ratio / width.powf(1.0 - exponent) - 1.0).abs() < 1e-9, "slope {exponent}");
            assert!((target.longest() - 0.1).abs() < 1e-12 && (target.shortest() - 0.005).abs() < 1e-12);
        }
    }

    #[test]
    fn faulty_spectra_are_named() {
        assert!(matches!(TargetSpectrum::third_octaves(&[], &[]), Err(RoadError::LevelCount { .. })));
        assert!(matches!(
            TargetSpectrum::third_octaves(&[0.1], &[]),
            Err(RoadError::LevelCount { wavelengths: 1, levels: 0 })
        ));
        assert!(matches!(TargetSpectrum::third_octaves(&[0.09], &[40.0]), Err(RoadError::NotThirdOctave { .. })));
        assert!(matches!(TargetSpectrum::third_octaves(&[-0.1], &[40.0]), Err(RoadError::NotPositive { .. })));
        assert!(matches!(
            TargetSpectrum::third_octaves(&[0.1, 0.1003], &[40.0, 41.0]),
            Err(RoadError::BandTwice { .. })
        ));
        assert!(matches!(TargetSpectrum::third_octaves(&[0.1], &[f64::NAN]), Err(RoadError::Level { .. })));
        for (longest, shortest) in [(0.1, 0.1), (0.01, 0.1), (f64::NAN, 0.1), (0.1, 0.0), (f64::INFINITY, 0.1)] {
            let law = PowerLawTexture { rms: 1e-3, exponent: 2.0, longest, shortest };
            assert!(matches!(TargetSpectrum::power_law(&law), Err(RoadError::PowerLaw { .. })));
        }
        let both = MadeRoad {
            levels: Some(vec![40.0]),
            power_law: Some(PowerLawTexture { rms: 1e-3, exponent: 2.0, longest: 0.1, shortest: 0.01 }),
            ..MadeRoad::default()
        };
        assert!(matches!(TargetSpectrum::of(&both), Err(RoadError::TwoSpectra)));
        let named = MadeRoad { texture: Some(NamedTexture::ChipSeal), levels: None, ..both };
        assert!(matches!(TargetSpectrum::of(&named), Err(RoadError::TwoSpectra)));
    }

    #[test]
    fn nominal_wavelengths_in_any_order_are_the_exact_bands() {
        let target = TargetSpectrum::third_octaves(&[0.063, 0.125, 0.08, 0.0315], &[1.0, 2.0, 3.0, 4.0]).unwrap();
        let found: Vec<i32> =
            target.bands().iter().map(|band| nearest_band(1.0 / (band.lower * band.upper).sqrt())).collect();
        assert_eq!(found, [-9, -11, -12, -15]);
    }
}
