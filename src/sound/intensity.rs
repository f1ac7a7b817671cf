//! Sound intensity between two microphones (IEC 61043): the power that crosses a unit area from one towards the other.
//!
//! With G_12 the cross spectrum of the pressures at a distance d, I(w) = -Im G_12/(rho w d). From plain power spectra:
//! with p' = p_1(t + T) - p_1(t - T), whose transform is 2 i sin(w T) P_1,
//!
//! ```text
//! |p' + p_2|^2 - |p' - p_2|^2 = 4 Re(P'* P_2) = 8 sin(w T) Im G_12
//! ```
//!
//! exactly at every frequency of the samples. Finite distance: a plane wave from 1 to 2 gives sin(k d)/(k d) of its
//! intensity, -0.4 dB at 3.15 kHz and -1 dB at 5 kHz with the 16 mm of a probe.

use std::f64::consts::TAU;
use std::ops::Range;

use super::levels::REFERENCE_PRESSURE;
use super::weighting::FrequencyWeighting;
use crate::radiation::Air;
use crate::response::{BandLevel, PowerSpectrum, SpectrumAccumulator, SpectrumError};

/// Reference intensity of levels \[W/m^2\] (ISO 1683).
pub(crate) const REFERENCE_INTENSITY: f64 = 1e-12;

/// Sound intensity in third octaves.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Intensity {
    /// Bands: `mean_square` is the intensity \[W/m^2\], negative where sound comes from the opposite direction; `level`
    /// re 1 pW/m^2 \[dB\], minus infinity there.
    pub bands: Vec<BandLevel>,
    /// The same bands, A-weighted.
    pub a_weighted: Vec<BandLevel>,
    /// Pressure-intensity index by band \[dB\]: level of the mean of both pressures re 20 uPa less that of the
    /// intensity; large where the field is no travelling wave.
    pub index: Vec<f64>,
}

impl Intensity {
    /// Intensity from the first of two pressures \[Pa\] towards the second, `spacing` \[m\] apart, in the bands that
    /// lie whole within `frequencies` \[Hz\]; the samples are valid up to `valid_to` \[Hz\].
    ///
    /// # Errors
    /// [`SpectrumError`].
    pub(crate) fn of(
        [first, second]: [&[f64]; 2],
        time_step: f64,
        spacing: f64,
        air: &Air,
        frequencies: Range<f64>,
        [segment, fade]: [f64; 2],
        valid_to: f64,
    ) -> Result<Self, SpectrumError> {
        let samples = first.len().min(second.len()).saturating_sub(2);
        let spectrum = |signal: &dyn Fn(usize) -> f64| -> Result<PowerSpectrum, SpectrumError> {
            let mut accumulator = SpectrumAccumulator::faded(samples, time_step, segment, fade)?;
            (1..=samples).for_each(|index| accumulator.push(signal(index)));
            Ok(accumulator.finish()?.valid_to(valid_to))
        };
        let change = |index: usize| first[index + 1] - first[index - 1];
        let sum = spectrum(&|index| change(index) + second[index])?;
        let difference = spectrum(&|index| change(index) - second[index])?;
        let [one, two] = [spectrum(&|index| first[index])?, spectrum(&|index| second[index])?];
        let mut intensity = sum.clone();
        for (bin, (power, less)) in intensity.power.iter_mut().zip(&difference.power).enumerate() {
            let omega = TAU * bin as f64 * sum.resolution;
            let scale = -8.0 * (omega * time_step).sin() * air.density * omega * spacing;
            *power = if scale < 0.0 { (*power - less) / scale } else { 0.0 };
        }
        let (lowest, reference) = (frequencies.start / 1.2, REFERENCE_INTENSITY.sqrt());
        let within = |spectrum: &PowerSpectrum, reference: f64| -> Vec<BandLevel> {
            let bands = spectrum.third_octaves(lowest, reference).into_iter();
            let of_range = |band: &BandLevel| {
                let middle = band.band.nominal_frequency();
                frequencies.start <= middle && middle <= frequencies.end
            };
            bands.filter(of_range).map(|band| BandLevel { level: outwards(band.level), ..band }).collect()
        };
        let bands = within(&intensity, reference);
        let pressures = [one, two].map(|spectrum| within(&spectrum, REFERENCE_PRESSURE));
        let index = bands.iter().zip(&pressures[0]).zip(&pressures[1]).map(|((band, one), two)| {
            let mean = 0.5 * (one.mean_square + two.mean_square);
            10.0 * (mean / REFERENCE_PRESSURE.powi(2)).log10() - band.level
        });
        Ok(Self {
            index: index.collect(),
            a_weighted: within(&FrequencyWeighting::A.of_spectrum(&intensity), reference),
            bands,
        })
    }

    /// A-weighted level of the valid bands, sound from the opposite direction subtracted \[dB(A) re 1 pW/m^2\].
    pub(crate) fn level_a(&self) -> f64 {
        let sum: f64 = self.a_weighted.iter().filter(|band| band.valid).map(|band| band.mean_square).sum();
        outwards(10.0 * (sum / REFERENCE_INTENSITY).log10())
    }
}

/// The level; minus infinity for the logarithm of a negative number.
fn outwards(level: f64) -> f64 {
    if level.is_nan() { f64::NEG_INFINITY } else { level }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Samples of a wave of noise that travels along the pair of microphones, and one of `back` times its amplitude in
    /// the opposite direction.
    fn wave(back: f64) -> [Vec<f64>; 2] {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let tones: Vec<[f64; 3]> = (0..600)
            .map(|tone| [300.0 + 10.0 * f64::from(tone), random.random_range(0.0..TAU), random.random_range(0.0..TAU)])
            .collect();
        [0.0, SPACING].map(|place| {
            let at = |sample: usize| {
                let time = sample as f64 * TIME_STEP;
                let of = |[frequency, there, here]: &[f64; 3]| {
                    let late = place / 343.2;
                    (TAU * frequency * (time - late) + there).cos()
                        + back * (TAU * frequency * (time + late) + here).cos()
                };
                tones.iter().map(of).sum()
            };
            (0..30_000).map(at).collect()
        })
    }

    const TIME_STEP: f64 = 1.0 / 30e3;
    const SPACING: f64 = 0.016;

    fn intensity(signals: &[Vec<f64>; 2]) -> Intensity {
        let air = Air { sound_speed: 343.2, density: 1.204, ..Air::at(20.0).unwrap() };
        let [first, second] = signals;
        Intensity::of([first, second], TIME_STEP, SPACING, &air, 400.0..5000.0, [0.1, 0.02], 5e3).unwrap()
    }

    #[test]
    fn a_plane_wave_has_the_intensity_of_its_pressure() {
        let signals = wave(0.0);
        let found = intensity(&signals);
        assert_eq!(found.bands.len(), 12, "400 Hz to 5 kHz");
        for (band, index) in found.bands.iter().zip(&found.index) {
            // 20 uPa and 1 pW/m^2 belong together for rho c = 400 kg/(m^2 s); the pair measures sin(k d)/(k d) of the
            // intensity.
            let kd = TAU * band.band.mid_frequency() * SPACING / 343.2;
            let expected = 10.0 * (1.204 * 343.2 / 400.0 * kd / kd.sin()).log10();
            assert!((index - expected).abs() < 0.1, "{:?}: {index} dB, {expected} expected", band.band);
        }
        let [first, second] = signals;
        let turned = intensity(&[second, first]);
        for (here, there) in found.bands.iter().zip(&turned.bands) {
            assert!((here.mean_square + there.mean_square).abs() < 1e-2 * here.mean_square, "{:?}", here.band);
            assert!(there.level.is_infinite() && there.level < 0.0);
        }
        assert!(turned.level_a().is_infinite() && turned.level_a() < 0.0);
    }

    #[test]
    fn opposite_waves_have_the_difference_of_their_intensities() {
        let [there, both] = [wave(0.0), wave(0.7)].map(|signals| intensity(&signals));
        let ratio = 10.0_f64.powf(0.1 * (both.level_a() - there.level_a()));
        assert!((ratio - (1.0 - 0.49)).abs() < 0.05, "{ratio}");
        // The pressures add, (1 + 0.49)/(1 - 0.49) is 4.7 dB; single bands have few tones.
        let more: f64 = both.index.iter().zip(&there.index).map(|(both, there)| both - there).sum();
        let more = more / both.index.len() as f64;
        assert!((3.0..7.0).contains(&more), "{more} dB");
    }
}
