//! Third-octave levels of profiles; their line and root mean square.
//!
//! 1. Remove mean and linear slope, apply a Hann window over the whole length, scaled to keep the mean square.
//! 2. Transform; the one-sided power spectrum at the lines k/length, each line a cell one line spacing wide.
//! 3. A band's energy is the sum of the cells, a cell at a band edge counted by the part of it inside.
//! 4. Level = 10 lg(energy / (1e-6 m)^2) (ISO 13473-4); for several profiles energies are averaged.

use std::ops::RangeInclusive;

use realfft::RealFftPlanner;
use serde::Serialize;

/// Reference height of texture levels \[m\].
const REFERENCE_HEIGHT: f64 = 1e-6;

/// Least length of a profile in wavelengths of a band for a valid level (ISO 13473-4:2024).
const WAVELENGTHS_NEEDED: f64 = 12.0;

/// Level in place of minus infinity, dB re 1e-6 m: a hundred-thousandth of a micrometre.
pub(crate) const LOWEST_LEVEL: f64 = -100.0;

/// Exact mid-wavelength of third-octave band `band` \[m\]: 10^(band/10).
pub(crate) fn mid_wavelength(band: i32) -> f64 {
    10_f64.powf(f64::from(band) / 10.0)
}

/// Number of the band whose mid-wavelength is nearest on the logarithmic scale.
pub(crate) fn nearest_band(wavelength: f64) -> i32 {
    (10.0 * wavelength.log10()).round() as i32
}

/// Lower and upper edge of a band in wavenumber (cycles per metre).
pub(crate) fn band_edges(band: i32) -> (f64, f64) {
    let mid = 1.0 / mid_wavelength(band);
    (mid * 10_f64.powf(-0.05), mid * 10_f64.powf(0.05))
}

/// Texture level of a mean square \[m^2\], dB re 1e-6 m; minus infinity for zero.
pub(crate) fn level(mean_square: f64) -> f64 {
    10.0 * (mean_square / (REFERENCE_HEIGHT * REFERENCE_HEIGHT)).log10()
}

/// Mean square \[m^2\] of a texture level, dB re 1e-6 m.
pub(crate) fn mean_square(level: f64) -> f64 {
    REFERENCE_HEIGHT * REFERENCE_HEIGHT * 10_f64.powf(level / 10.0)
}

/// The level of one third-octave band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TextureLevel {
    /// Exact mid-wavelength \[m\].
    pub wavelength: f64,
    /// Level, dB re 1e-6 m.
    pub level: f64,
    /// True if the profile is long enough for the band (ISO 13473-4:2024): twelve of its wavelengths.
    pub valid: bool,
}

/// The energy sum of neighbouring bands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct OverallLevel {
    /// Level, dB re 1e-6 m.
    pub level: f64,
    /// Mid-wavelength of the longest band included \[m\].
    pub longest: f64,
    /// Mid-wavelength of the shortest band included \[m\].
    pub shortest: f64,
    /// True if all bands of the range are included.
    pub complete: bool,
}

impl OverallLevel {
    /// Level of the macrotexture, the bands of 0.5 to 50 mm; `None` without a valid one.
    pub(crate) fn macrotexture(levels: &[TextureLevel]) -> Option<Self> {
        Self::of(levels, -33..=-13)
    }

    /// Level of the megatexture, the bands of 63 to 500 mm; `None` without a valid one.
    pub(crate) fn megatexture(levels: &[TextureLevel]) -> Option<Self> {
        Self::of(levels, -12..=-3)
    }

    /// Energy sum of the valid ones of some bands.
    fn of(levels: &[TextureLevel], bands: RangeInclusive<i32>) -> Option<Self> {
        let inside = levels.iter().filter(|at| at.valid && bands.contains(&nearest_band(at.wavelength)));
        let wavelengths: Vec<f64> = inside.clone().map(|at| at.wavelength).collect();
        let longest = wavelengths.iter().copied().reduce(f64::max)?;
        let shortest = wavelengths.iter().copied().reduce(f64::min)?;
        let together = level(inside.map(|at| mean_square(at.level)).sum());
        Some(Self { level: together, longest, shortest, complete: wavelengths.len() == bands.count() })
    }
}

/// Wanted level of profiles in one band, and that of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct BandFit {
    /// Geometric middle of the band \[m\].
    pub wavelength: f64,
    /// Wanted level, dB re 1e-6 m.
    pub target: f64,
    /// Level of the surface (expectation), dB re 1e-6 m; [`LOWEST_LEVEL`] if it has no energy there.
    pub fitted: f64,
}

impl BandFit {
    /// Magnitude of the difference between both levels \[dB\].
    pub(crate) fn deviation(&self) -> f64 {
        (self.fitted - self.target).abs()
    }
}

/// Energy spectrum of one or more equally long profiles, averaged.
#[derive(Clone, Debug)]
pub struct ProfileSpectrum {
    line: f64,
    power: Vec<f64>,
    profiles: usize,
}

impl ProfileSpectrum {
    /// An empty average for profiles of `points` heights, `spacing` \[m\] apart.
    pub fn new(points: usize, spacing: f64) -> Self {
        Self { line: 1.0 / (points as f64 * spacing), power: vec![0.0; points / 2 + 1], profiles: 0 }
    }

    /// Adds one profile; it is ignored unless `heights.len()` is the `points` of [`Self::new`], at least 2.
    pub fn add(&mut self, heights: &[f64]) {
        let points = heights.len();
        if points < 2 || self.power.len() != points / 2 + 1 {
            return;
        }
        let mut windowed = heights.to_vec();
        remove_line(&mut windowed);
        let mut window_square = 0.0;
        for (index, height) in windowed.iter_mut().enumerate() {
            let phase = 2.0 * std::f64::consts::PI * (index as f64 + 0.5) / points as f64;
            let window = 0.5 - 0.5 * phase.cos();
            window_square += window * window;
            *height *= window;
        }
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(points);
        let mut spectrum = transform.make_output_vec();
        // It can only fail for wrong lengths, and these are the planner's.
        if transform.process(&mut windowed, &mut spectrum).is_err() {
            return;
        }
        let scale = 1.0 / (points as f64 * window_square);
        for (index, (sum, value)) in self.power.iter_mut().zip(&spectrum).enumerate() {
            let sides = if index == 0 || 2 * index == points { 1.0 } else { 2.0 };
            *sum += sides * scale * value.norm_sqr();
        }
        self.profiles += 1;
    }

    /// Mean square \[m^2\] between two wavenumbers (cycles per metre).
    pub fn energy(&self, lower: f64, upper: f64) -> f64 {
        let from = ((lower / self.line - 0.5).floor().max(0.0)) as usize;
        let to = ((upper / self.line + 0.5).ceil() as usize + 1).min(self.power.len());
        let sum: f64 =
            (from.min(to)..to).map(|index| line_inside(index, self.line, lower, upper) * self.power[index]).sum();
        sum / self.profiles.max(1) as f64
    }

    /// All lines but the mean: wavenumber (cycles per metre) and mean square \[m^2\].
    pub fn lines(&self) -> impl Iterator<Item = (f64, f64)> {
        let profiles = self.profiles.max(1) as f64;
        let lines = self.power.iter().enumerate().skip(1);
        lines.map(move |(index, power)| (index as f64 * self.line, power / profiles))
    }

    /// Level of one third-octave band, dB re 1e-6 m.
    pub fn level(&self, band: i32) -> f64 {
        let (lower, upper) = band_edges(band);
        level(self.energy(lower, upper))
    }

    /// Levels of all bands that are wholly between two wavelengths \[m\], longest wavelength first; a band without any
    /// energy has no level and is left out.
    pub fn levels(&self, longest: f64, shortest: f64) -> Vec<TextureLevel> {
        bands_between(longest, shortest)
            .map(|band| {
                let wavelength = mid_wavelength(band);
                let valid = WAVELENGTHS_NEEDED * wavelength * self.line <= 1.0 + 1e-9;
                TextureLevel { wavelength, level: self.level(band), valid }
            })
            .filter(|at| at.level.is_finite())
            .collect()
    }
}

/// Part of line number `index` of a spectrum, a cell one `spacing` wide, that is between two wavenumbers.
pub(crate) fn line_inside(index: usize, spacing: f64, lower: f64, upper: f64) -> f64 {
    let centre = index as f64;
    ((upper / spacing).min(centre + 0.5) - (lower / spacing).max(centre - 0.5)).clamp(0.0, 1.0)
}

/// Numbers of the bands wholly between two wavelengths \[m\], longest wavelength first.
pub(crate) fn bands_between(longest: f64, shortest: f64) -> impl Iterator<Item = i32> {
    let slack = 1.0 + 1e-9;
    (nearest_band(shortest) - 1..=nearest_band(longest) + 1).rev().filter(move |&band| {
        let (lower, upper) = band_edges(band);
        lower * longest * slack >= 1.0 && upper * shortest <= slack
    })
}

/// Subtracts mean and least-squares line.
pub(crate) fn remove_line(heights: &mut [f64]) {
    let (mean, slope) = line_of(heights);
    let middle = 0.5 * (heights.len() as f64 - 1.0);
    for (index, height) in heights.iter_mut().enumerate() {
        *height -= mean + slope * (index as f64 - middle);
    }
}

/// Mean, and slope per sample, of the least-squares line about the middle of the profile.
pub(crate) fn line_of(heights: &[f64]) -> (f64, f64) {
    let count = heights.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = heights.iter().sum::<f64>() / count.max(1.0);
    let moment: f64 = heights.iter().enumerate().map(|(index, height)| (index as f64 - middle) * height).sum();
    let inertia = count * (count * count - 1.0) / 12.0;
    (mean, if inertia > 0.0 { moment / inertia } else { 0.0 })
}

/// Root mean square about the mean \[m\].
pub(crate) fn rms(heights: &[f64]) -> f64 {
    let count = heights.len().max(1) as f64;
    let mean = heights.iter().sum::<f64>() / count;
    (heights.iter().map(|height| (height - mean) * (height - mean)).sum::<f64>() / count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(amplitude: f64, wavelength: f64, spacing: f64, points: usize) -> Vec<f64> {
        (0..points).map(|i| amplitude * (2.0 * std::f64::consts::PI * i as f64 * spacing / wavelength).sin()).collect()
    }

    #[test]
    fn a_sine_has_the_level_of_its_rms_in_its_band_only() {
        let profile = sine(1e-3, 0.05, 1e-3, 4000);
        let mut spectrum = ProfileSpectrum::new(4000, 1e-3);
        spectrum.add(&profile);
        let expected = level(0.5e-6);
        assert!((spectrum.level(-13) - expected).abs() < 0.01, "{} for {expected}", spectrum.level(-13));
        assert!(spectrum.level(-12) < expected - 60.0 && spectrum.level(-14) < expected - 60.0);
    }

    #[test]
    fn bands_need_twelve_wavelengths_and_add_up_by_energy() {
        // 2 m: 0.158 m fits 12.6 times, 0.2 m 10 times. Waves of 20, 50 and 63 mm, the latter megatexture.
        let profiles = [(1e-3, 0.02), (2e-3, 0.05), (3e-3, 0.063_095_7)];
        let waves = profiles.map(|(amplitude, wavelength)| sine(amplitude, wavelength, 1e-3, 2000));
        let sum: Vec<f64> = (0..2000).map(|i| waves.iter().map(|wave| wave[i]).sum()).collect();
        let mut spectrum = ProfileSpectrum::new(2000, 1e-3);
        spectrum.add(&sum);
        let levels = spectrum.levels(0.5, 2e-3);
        let longest = levels.iter().find(|at| at.valid).unwrap().wavelength;
        assert!((longest - mid_wavelength(-8)).abs() < 1e-9 && levels[0].wavelength > 0.39, "{levels:?}");
        let [large, mega] =
            [OverallLevel::macrotexture(&levels), OverallLevel::megatexture(&levels)].map(Option::unwrap);
        assert!((large.level - level(0.5e-6 + 2e-6)).abs() < 0.1, "{large:?}");
        assert!((mega.level - level(4.5e-6)).abs() < 0.1, "{mega:?}");
        assert!(!large.complete && !mega.complete, "neither below 2.5 mm nor above 160 mm");
        assert_eq!((large.longest, mega.longest), (mid_wavelength(-13), mid_wavelength(-8)));
        let all: Vec<TextureLevel> = (-33..=-3)
            .map(|band| TextureLevel { wavelength: mid_wavelength(band), level: 40.0, valid: band != -20 })
            .collect();
        assert!(OverallLevel::megatexture(&all).unwrap().complete);
        assert!(!OverallLevel::macrotexture(&all).unwrap().complete);
        assert_eq!(OverallLevel::megatexture(&all[..21]), None);
    }

    #[test]
    fn all_lines_together_are_the_windowed_mean_square() {
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let profile: Vec<f64> = (0..200_001).map(|_| noise()).collect();
        let mut spectrum = ProfileSpectrum::new(profile.len(), 1e-3);
        spectrum.add(&profile);
        let total = spectrum.energy(0.0, 501.0);
        assert!((total * 12.0 - 1.0).abs() < 0.01, "uniform noise has the variance 1/12, found {total}");
    }

    #[test]
    fn bands_are_base_ten_and_abut() {
        assert_eq!(nearest_band(0.158), -8);
        assert_eq!(nearest_band(0.0126), -19);
        for band in -30..5 {
            assert!((band_edges(band).1 / band_edges(band - 1).0 - 1.0).abs() < 1e-12);
            assert!((mid_wavelength(band) * (band_edges(band).0 * band_edges(band).1).sqrt() - 1.0).abs() < 1e-12);
        }
        assert_eq!(bands_between(0.158_489 * 1.13, 0.003_981 / 1.13).count(), 17);
    }
}
