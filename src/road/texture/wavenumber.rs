//! The mean wavenumber of a road's texture: a measure of its fineness, independent of its height.
//!
//! `<k>` = sum ms |k| / sum ms over the surface's waves, ms being their mean squares. A profile cuts the waves of an
//! isotropic surface at all angles and so `<k_x>` = (2/pi) `<k>`; a surface that is level across has k = k_x.
//!
//! Waves of [`LONGEST`] down to [`SHORTEST`] count: longer ones move the whole contact patch up and down, shorter ones
//! are not resolved by cells of the usual size. Both are fixed lengths: a property of tread and texture must not change
//! with the run's elements. For a road without any of these waves all of its waves count.

use std::f64::consts::PI;

use super::levels::{BandFit, ProfileSpectrum, mean_square};

/// Longest wave that counts \[m\]: the upper edge of the third octave of 0.2 m.
pub(crate) const LONGEST: f64 = 0.2239;
/// Shortest wave that counts \[m\]: the lower edge of the third octave of 4 mm, two cells of 2 mm.
pub(crate) const SHORTEST: f64 = 0.00355;

/// Mean wavenumber `<k_x>` along a profile \[rad/m\] from third-octave (or narrower) bands; `None` without any height.
pub(crate) fn of_bands(bands: &[BandFit]) -> Option<f64> {
    let waves = |from: f64, to: f64| {
        let inside = bands.iter().filter(|band| (from..=to).contains(&band.wavelength));
        mean(inside.map(|band| (mean_square(band.fitted), 2.0 * PI / band.wavelength)))
    };
    waves(SHORTEST, LONGEST).or_else(|| waves(0.0, f64::INFINITY))
}

/// Mean wavenumber `<k_x>` along profiles \[rad/m\] from their spectrum; `None` without any height.
pub(crate) fn of_spectrum(spectrum: &ProfileSpectrum) -> Option<f64> {
    let waves = |from: f64, to: f64| {
        let inside = spectrum.lines().filter(|(cycles, _)| (1.0 / to..=1.0 / from).contains(cycles));
        mean(inside.map(|(cycles, power)| (power, 2.0 * PI * cycles)))
    };
    waves(SHORTEST, LONGEST).or_else(|| waves(f64::MIN_POSITIVE, f64::MAX))
}

/// Mean wavenumber `<k>` of the surface \[rad/m\] from that of its profiles along.
pub(crate) fn of_surface(along: f64, level_across: bool) -> f64 {
    if level_across { along } else { 0.5 * PI * along }
}

/// Mean of values with non-negative weights; `None` if all weights are zero.
fn mean(waves: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let (weights, sum) =
        waves.fold((0.0, 0.0), |(weights, sum), (weight, value)| (weights + weight, sum + weight * value));
    (weights > 0.0).then_some(sum / weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn band(wavelength: f64, fitted: f64) -> BandFit {
        BandFit { wavelength, target: fitted, fitted }
    }

    #[test]
    fn the_level_does_not_count_and_the_stronger_band_does() {
        let even = of_bands(&[band(0.1, 40.0), band(0.01, 40.0)]).unwrap();
        assert!((even - PI * (10.0 + 100.0)).abs() < 1e-9 * even);
        let loud = of_bands(&[band(0.1, 60.0), band(0.01, 60.0)]).unwrap();
        assert!((loud - even).abs() < 1e-9 * even);
        let mostly_long = of_bands(&[band(0.1, 50.0), band(0.01, 40.0)]).unwrap();
        assert!((mostly_long - 2.0 * PI * (10.0 * 10.0 + 100.0) / 11.0).abs() < 1e-9 * even);
    }

    #[test]
    fn hills_and_grains_do_not_count_unless_there_is_nothing_else() {
        let texture = [band(0.1, 40.0), band(0.01, 40.0)];
        let with_hills = [band(5.0, 80.0), texture[0], texture[1], band(0.002, 60.0)];
        assert_eq!(of_bands(&texture), of_bands(&with_hills));
        let hills = of_bands(&[band(5.0, 80.0)]).unwrap();
        assert!((hills - 2.0 * PI / 5.0).abs() < 1e-12);
        assert_eq!(of_bands(&[]), None);
        assert_eq!(of_bands(&[band(0.01, f64::NEG_INFINITY)]), None);
    }

    #[test]
    fn a_sine_has_its_own_wavenumber() {
        let points = 4000;
        let sine = |wavelength: f64| -> ProfileSpectrum {
            let heights: Vec<f64> =
                (0..points).map(|i| 1e-3 * (2.0 * PI * f64::from(i) * 1e-3 / wavelength).sin()).collect();
            let mut spectrum = ProfileSpectrum::new(heights.len(), 1e-3);
            spectrum.add(&heights);
            spectrum
        };
        // The window spreads a line evenly over its two neighbours; the removal of the least-squares line changes less
        // than a permille.
        for wavelength in [0.05, 0.02] {
            let found = of_spectrum(&sine(wavelength)).unwrap();
            assert!((found * wavelength / (2.0 * PI) - 1.0).abs() < 1e-3, "{found}");
        }
        let mut flat = ProfileSpectrum::new(100, 1e-3);
        flat.add(&[0.0; 100]);
        assert_eq!(of_spectrum(&flat), None);
    }
}
