//! `sound.csv`, `sound_narrow.csv` and the sound's part of the summary.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::pass_by::PassBySummary;
use super::spectra::CORRECTION;
use super::table::{csv, optional, row};
use crate::radiation::{FrequencyReport, RadiatingBody};
use crate::response::{BandLevel, PowerSpectrum, SliceErrors};
use crate::scene::RadiationQuality;
use crate::sound::{Air, CoveredBands, SoundLevels, TotalLevel};

/// File of the third octaves at the receivers.
pub(crate) const SOUND_FILE: &str = "sound.csv";
/// Column of its A-weighted levels.
pub(crate) const SOUND_COLUMN: &str = "level_db_a";
/// Quantity of these levels.
pub(crate) const SOUND_LEVEL: &str = "Sound pressure level [dB(A) re 20 uPa]";
/// File of the narrow-band spectra at the receivers.
pub(crate) const SOUND_NARROW_FILE: &str = "sound_narrow.csv";

/// Spectrum at a receiver: the mean over its points, times the number of its tyres.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceiverSpectrum {
    /// Name of the receiver.
    pub name: String,
    /// Spectrum of the pressure \[Pa^2\].
    pub spectrum: PowerSpectrum,
    /// Parts of the pressure, where blocks squeeze air out of voids.
    pub parts: Option<SoundParts>,
    /// Spectra for the voids of each place at which they are open \[Pa^2\]; empty without.
    pub places: Vec<PowerSpectrum>,
    /// Errors of the levels.
    pub error: SoundError,
}

/// Spectra of the two parts of a pressure, each as if it were alone \[Pa^2\]. The parts are coherent: the spectrum of
/// their sum is not the sum of their spectra.
#[derive(Clone, Debug, PartialEq)]
pub struct SoundParts {
    /// Due to the vibration of the tyre.
    pub vibration: PowerSpectrum,
    /// Due to the squeeze of blocks.
    pub squeeze: PowerSpectrum,
}

/// Table of third-octave levels: nominal and exact mid-frequency \[Hz\], level \[dB re 20 uPa\], A-weighted level
/// \[dB(A)\], 1 for valid levels and 0 for others, error of valid levels by the numerical solution and the transfer
/// path, and by slices; empty where that is not known \[dB\]. Where there are parts, their levels follow; where voids
/// are open, the standard deviation of the level over their places \[dB\]. Last the standard error \[dB\], and for
/// levels corrected to a finer mesh the correction \[dB\].
pub(crate) fn sound_levels_csv(spectra: &[ReceiverSpectrum], lowest: f64, slices: Option<&SliceErrors>) -> String {
    const HEADER: &str =
        "receiver,nominal_hz,mid_frequency_hz,level_db_re_20upa,level_db_a,valid,error_db,slice_error_db";
    const PARTS: &str = "vibration_db_re_20upa,squeeze_db_re_20upa";
    const SPREAD: &str = "voids_spread_db";
    const SCATTER: &str = "standard_error_db";
    let has_parts = spectra.iter().any(|spectrum| spectrum.parts.is_some());
    let is_corrected = spectra.iter().any(|spectrum| !spectrum.spectrum.gains.is_empty());
    let has_places = spectra.iter().any(|spectrum| !spectrum.places.is_empty());
    let third_octaves = |spectrum| SoundLevels::of(spectrum, lowest..f64::INFINITY).third_octaves;
    let rows = spectra.iter().flat_map(|ReceiverSpectrum { name, spectrum, parts, places, error }| {
        let levels = SoundLevels::of(spectrum, lowest..f64::INFINITY);
        let parts = parts.as_ref().map(|parts| [&parts.vibration, &parts.squeeze].map(third_octaves));
        let places: Vec<_> = places.iter().map(third_octaves).collect();
        let bands = levels.third_octaves.into_iter().zip(levels.a_weighted).enumerate();
        bands.map(move |(index, (plain, weighted))| {
            let band = plain.band;
            let valid = f64::from(u8::from(plain.valid));
            let [nominal, middle] = [band.nominal_frequency(), band.mid_frequency()];
            let error = optional(error.of_band(middle).filter(|_| plain.valid));
            let by_slices = optional(slices.and_then(|slices| slices.sound(band)));
            let of_sum = row([name, &nominal, &middle, &plain.level, &weighted.level, &valid, &error, &by_slices]);
            let of_parts =
                parts.iter().flat_map(|[vibration, squeeze]| row([&vibration[index].level, &squeeze[index].level]));
            let of_places = spread(places.iter().map(|bands| bands[index].level)).map(|spread| row([&spread]));
            let of_record = [optional(spectrum.standard_error([band]))];
            let added = is_corrected.then(|| optional(spectrum.correction(band)));
            let optional = of_parts.chain(of_places.into_iter().flatten());
            of_sum.into_iter().chain(optional).chain(of_record).chain(added).collect::<Vec<String>>()
        })
    });
    let parts = PARTS.split(',').filter(|_| has_parts);
    let spread = [SPREAD].into_iter().filter(|_| has_places);
    let correction = [CORRECTION].into_iter().filter(|_| is_corrected);
    csv(HEADER.split(',').chain(parts).chain(spread).chain([SCATTER]).chain(correction), rows)
}

/// Standard deviation of levels; `None` for fewer than two.
pub(crate) fn spread(levels: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let count = levels.clone().count();
    let mean = levels.clone().sum::<f64>() / count as f64;
    let square: f64 = levels.map(|level| (level - mean).powi(2)).sum();
    (count > 1).then(|| (square / (count - 1) as f64).sqrt())
}

/// Table of narrow-band spectra: frequency \[Hz\] and power spectral density \[Pa^2/Hz\].
pub(crate) fn sound_narrow_csv(spectra: &[ReceiverSpectrum]) -> String {
    let rows = spectra.iter().flat_map(|ReceiverSpectrum { name, spectrum, .. }| {
        spectrum.density().map(move |(frequency, density)| row([name, &frequency, &density]))
    });
    csv(["receiver", "frequency_hz", "density_pa2_hz"], rows)
}

/// Part of `summary.json` on the sound.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct SoundSummary {
    /// Reference pressure of the levels \[Pa\].
    pub reference: f64,
    /// Highest frequency that is radiated \[Hz\].
    pub highest: f64,
    /// Body that radiates.
    pub(crate) body: BodySummary,
    /// Errors of the levels, at the receiver where they are largest.
    pub error: SoundError,
    /// Results by receiver.
    pub receivers: Vec<ReceiverSummary>,
}

/// Errors of levels by the fineness of the numerical solution, without those of the model itself. Bounds add up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct SoundError {
    /// Error of third octaves of the forces, as `preset` or `accuracy` states \[dB\]; `None` where nothing is stated:
    /// then the sums are not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forces: Option<f64>,
    /// Error of third octaves by the transfer path: elements, frequencies and lateral waves, or a draft \[dB\].
    pub way: f64,
    /// Sum of both for a third octave \[dB\].
    pub band: Option<f64>,
    /// Mid-frequency of the lowest third octave for which that holds \[Hz\]; below it nothing is known.
    #[serde(default)]
    pub from: f64,
    /// Sum of both for an A-weighted level \[dB(A)\]: at most that of the worst of its bands.
    pub level_a: Option<f64>,
}

impl SoundError {
    /// Frequency \[Hz\] from which on the error of third octaves holds, and that error \[dB\]; `None` where it is not
    /// known.
    pub fn of_bands(&self) -> Option<(f64, f64)> {
        self.band.map(|band| (self.from, band))
    }

    /// Error of a third octave by its mid-frequency \[Hz\], where it is known \[dB\].
    pub fn of_band(&self, mid_frequency: f64) -> Option<f64> {
        self.band.filter(|_| mid_frequency >= self.from)
    }
}

/// The body that radiates, and the solution of its transfers.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct BodySummary {
    /// Boundary elements, or a draft without them.
    pub quality: RadiationQuality,
    /// Length of its contact patch \[m\].
    pub patch_length: f64,
    /// Sound speed of the air \[m/s\].
    pub sound_speed: f64,
    /// Density of the air \[kg/m^3\].
    pub density: f64,
    /// Number of frequencies of the transfers.
    pub frequencies: usize,
    /// Number of these that were solved in this run; the others were stored by earlier ones.
    pub solved: usize,
    /// Unknowns of a parity block at the highest frequency.
    pub unknowns: usize,
    /// Largest estimated error of the interpolation between frequencies \[dB\].
    pub interpolation_error: f64,
    /// Smallest reciprocal condition number of those solved in this run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reciprocal_condition: Option<f64>,
}

impl BodySummary {
    /// A body in some air, and its solution.
    pub(crate) fn of(quality: RadiationQuality, body: &RadiatingBody, air: &Air, report: &FrequencyReport) -> Self {
        Self {
            quality,
            patch_length: 2.0 * body.half_patch(),
            sound_speed: air.sound_speed,
            density: air.density,
            frequencies: report.count,
            solved: report.solved,
            unknowns: report.solve.unknowns,
            interpolation_error: report.largest_passed.max(report.largest_unhalved),
            reciprocal_condition: (report.solved > 0).then_some(report.reciprocal_condition),
        }
    }
}

/// Levels at a receiver, or their energetic mean over its points.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct ReceiverSummary {
    /// Name of the receiver.
    pub name: String,
    /// Number of its points.
    pub points: usize,
    /// Number of tyres of a vehicle that it receives, their mean squares added; `None` for the one tyre of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tyres: Option<usize>,
    /// Mean level of the valid bands \[dB re 20 uPa\].
    pub level: f64,
    /// A-weighted mean level of the valid bands \[dB(A)\].
    pub level_a: f64,
    /// The same due to the tyre's vibration alone \[dB(A)\], where blocks squeeze air as well.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vibration_level_a: Option<f64>,
    /// The same due to the squeeze of blocks alone \[dB(A)\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub squeeze_level_a: Option<f64>,
    /// Standard deviation of the A-weighted level over the places whose voids are open \[dB(A)\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub voids_spread_a: Option<f64>,
    /// Error of the A-weighted level \[dB(A)\]: [`SoundError::level_a`], and the largest error by slices of its bands;
    /// `None` where one of them is not known.
    pub level_a_error: Option<f64>,
    /// Reason why that error is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_level_a_error: Option<String>,
    /// Standard error of the A-weighted mean level \[dB\], from one run: its scatter from one stretch of road to
    /// another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error_a: Option<f64>,
    /// Bands of both levels, of the pass-by and of the sound files; `None` if no band is valid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) bands: Option<CoveredBands>,
    /// A-weighted sound power level \[dB(A) re 1 pW\], for a hemisphere; bands and error are those of `level_a`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power_level_a: Option<f64>,
    /// Maximum of the pass-by, where the tyre passes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) pass_by: Option<PassBySummary>,
    /// Reason why a receiver that is passed has no pass-by.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_pass_by: Option<String>,
    /// Sound intensity, by pairs of microphones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) intensity: Option<IntensitySummary>,
    /// Sound file, and the pressure of its full scale.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) audio: Option<AudioSummary>,
}

/// Sound intensity at a receiver with pairs of microphones.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct IntensitySummary {
    /// Name of its table.
    pub file: String,
    /// Energetic mean of the probes' A-weighted levels \[dB(A) re 1 pW/m^2\]; `None` if no band is valid, or no sound
    /// leaves the tyre.
    pub level_a: Option<f64>,
    /// A-weighted level of each probe, by name \[dB(A) re 1 pW/m^2\]; `None` likewise.
    pub probes: BTreeMap<String, Option<f64>>,
    /// Bands of these levels; `None` if no band is valid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bands: Option<CoveredBands>,
    /// Duration of the pressures that they are computed from \[s\].
    pub seconds: f64,
}

impl IntensitySummary {
    fn text(&self) -> String {
        let Some(bands) = &self.bands else { return "no intensity: no band valid".to_owned() };
        let Some(level) = self.level_a else { return "no intensity away from the tyre".to_owned() };
        let least = if bands.lower_bound { "at least " } else { "" };
        let probe = |(name, level): (&String, &Option<f64>)| match level {
            Some(level) => format!("{name} {level:.1}"),
            None => format!("{name} none"),
        };
        let probes: Vec<String> = self.probes.iter().map(probe).collect();
        format!("intensity {least}{level:.1} dB(A) re 1 pW/m^2 ({})", probes.join(", "))
    }
}

/// A-weighted level of a receiver by which runs are compared: the maximum of the pass-by, time weighting F, where the
/// tyre passes, else the mean.
#[derive(Clone, Debug, PartialEq)]
pub struct RatedLevel {
    /// Name of the receiver.
    pub name: String,
    /// True if the tyre passes it: its level is a maximum.
    pub passed: bool,
    /// Level \[dB(A)\] with its bands; `None` where the run is too short for a passage, or no band is valid.
    pub level: Option<TotalLevel>,
    /// Passages of a maximum.
    pub(crate) pass_by: Option<PassBySummary>,
}

impl RatedLevel {
    /// Name of the quantity: `coast-by, L_AFmax`, or `cpx`.
    pub fn label(&self) -> String {
        if self.passed { format!("{}, L_AFmax", self.name) } else { self.name.clone() }
    }
}

impl ReceiverSummary {
    /// Level by which runs are compared, given the A-weighted third octaves of the receiver.
    pub fn rated(&self, bands: &[BandLevel]) -> RatedLevel {
        let passed = self.pass_by.is_some() || self.no_pass_by.is_some();
        let level = match &self.pass_by {
            Some(pass_by) => self.mean(bands).map(|mean| mean.at_most(pass_by.maximum)),
            None => self.mean(bands).filter(|_| !passed),
        };
        RatedLevel { name: self.name.clone(), passed, level, pass_by: self.pass_by.clone() }
    }

    /// Mean level, given the A-weighted third octaves of the receiver.
    pub fn mean(&self, bands: &[BandLevel]) -> Option<TotalLevel> {
        let sum = TotalLevel::of(bands.to_vec())?;
        Some(TotalLevel { level: self.level_a, error: self.level_a_error, ..sum })
    }

    /// Levels of the receiver in a line of text.
    pub fn text(&self) -> String {
        let error = self.level_a_error.map_or_else(String::new, |error| format!(" +- {error:.1}"));
        let least = if self.bands.is_some_and(|bands| bands.lower_bound) { "at least " } else { "" };
        let scatter = self.standard_error_a.map(|scatter| format!(" (standard error {scatter:.1} dB)"));
        let scatter = scatter.unwrap_or_default();
        let mut text = match &self.pass_by {
            Some(pass_by) => format!(
                "{least}{:.1}{error} dB(A), L_AFmax as the {} passes ({}), {:.1} dB(A) along the line{scatter}",
                pass_by.maximum,
                if self.tyres.is_some() { "vehicle" } else { "tyre" },
                pass_by.statistics(),
                self.level_a
            ),
            None => format!("{least}{:.1}{error} dB(A){scatter}, {:.1} dB", self.level_a, self.level),
        };
        if let Some(bands) = &self.bands {
            text.push_str(&format!(", {}", bands.text()));
            if let Some(why) = bands.lower_bound_reason() {
                text.push_str(&format!(" ({why})"));
            }
        }
        if let Some(why) = &self.no_level_a_error {
            text.push_str(&format!(", {why}"));
        }
        if let Some((vibration, squeeze)) = self.vibration_level_a.zip(self.squeeze_level_a) {
            text.push_str(&format!(
                ", vibration alone {vibration:.1} dB(A), squeeze of blocks alone {squeeze:.1} dB(A)"
            ));
        }
        if let Some(spread) = self.voids_spread_a {
            text.push_str(&format!(", from voids to voids {spread:.1} dB(A) apart"));
        }
        if let Some(tyres) = self.tyres {
            text.push_str(&format!(", {tyres} tyres"));
        }
        if let Some(why) = &self.no_pass_by {
            text.push_str(&format!(", {why}"));
        }
        if let Some(power) = self.power_level_a {
            text.push_str(&format!(", sound power {least}{power:.1}{error} dB(A)"));
        }
        if let Some(intensity) = &self.intensity {
            text.push_str(&format!(", {}", intensity.text()));
        }
        if let Some(AudioSummary { file, tyres, louder, .. }) = &self.audio {
            text.push_str(&format!(", {file}"));
            if *tyres == Some(1) {
                text.push_str(" (of one tyre: the run is too short for the others)");
            }
            if *louder {
                text.push_str(" (above its full scale: written as floats)");
            }
        }
        text
    }
}

/// A sound file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct AudioSummary {
    /// Name of the file.
    pub file: String,
    /// Pressure of its full scale \[Pa\].
    pub full_scale: f64,
    /// Largest magnitude of the pressure in it \[Pa\].
    pub peak: Option<f64>,
    /// True if its peak is above full scale: then samples are floats.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub louder: bool,
    /// Duration \[s\].
    pub seconds: f64,
    /// Number of tyres of a vehicle in it: all, each from another stretch of the run, or the front left one where the
    /// run has fewer stretches; `None` for a single tyre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tyres: Option<usize>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intensity_without_a_valid_band_is_said_and_read_again() {
        let probes = |level| BTreeMap::from([("leading".to_owned(), level), ("trailing".to_owned(), None)]);
        let none = IntensitySummary {
            file: "intensity_obsi.csv".to_owned(),
            level_a: None,
            probes: probes(None),
            bands: None,
            seconds: 1.0,
        };
        let text = serde_json::to_string(&none).unwrap();
        assert!(text.contains("\"level_a\":null") && text.contains("\"trailing\":null"), "{text}");
        assert_eq!(serde_json::from_str::<IntensitySummary>(&text).unwrap(), none);
        assert_eq!(none.text(), "no intensity: no band valid");
        let bands = Some(CoveredBands { lowest: 400.0, highest: 500.0, missing: None, lower_bound: true });
        let some = IntensitySummary { level_a: Some(80.0), probes: probes(Some(83.0)), bands, ..none };
        assert_eq!(some.text(), "intensity at least 80.0 dB(A) re 1 pW/m^2 (leading 83.0, trailing none)");
    }

    #[test]
    fn a_power_has_the_bound_and_the_error_of_its_level() {
        let summary = ReceiverSummary {
            name: "hemisphere".to_owned(),
            points: 10,
            tyres: None,
            level: 45.0,
            level_a: 43.4,
            vibration_level_a: None,
            squeeze_level_a: None,
            voids_spread_a: None,
            level_a_error: Some(0.4),
            no_level_a_error: None,
            standard_error_a: None,
            bands: Some(CoveredBands { lowest: 25.0, highest: 500.0, missing: None, lower_bound: true }),
            power_level_a: Some(60.7),
            pass_by: None,
            no_pass_by: None,
            intensity: None,
            audio: None,
        };
        let reported = summary.text();
        assert!(reported.starts_with("at least 43.4 +- 0.4 dB(A)"), "{reported}");
        assert!(reported.ends_with("sound power at least 60.7 +- 0.4 dB(A)"), "{reported}");
    }
}
