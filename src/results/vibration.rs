//! `vibration.csv`, `vibration_narrow.csv` and the vibration's part of the summary.
//!
//! One row for each field, frame, place and band (or frequency). Spectra at points have a position or the number of an
//! element; those without either are means over the circumference.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::table::{Cells, csv, row};
use crate::response::{BandLevel, LevelErrors, PowerSpectrum};

/// File of the third octaves.
pub(crate) const VIBRATION_FILE: &str = "vibration.csv";
/// Quantity of these levels.
pub(crate) const VELOCITY_LEVEL: &str = "Velocity level [dB re 1 m/s]";
/// File of the narrow-band spectra.
pub(crate) const VIBRATION_NARROW_FILE: &str = "vibration_narrow.csv";

/// Columns that identify the spectrum of a row.
const NAMES: [&str; 4] = ["field", "frame", "position_m", "element"];

/// Place of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VelocityPlace {
    /// Mean over the circumference.
    Everywhere,
    /// At a distance from the axle in the non-rotating frame \[m\].
    Position(f64),
    /// At an element, turning with the tyre.
    Element(usize),
}

/// A velocity spectrum with its names.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocitySpectrum {
    /// Field: `tread`, `belt` or `tangential`.
    pub field: &'static str,
    /// Frame: `material`, the lines of the mean pattern included; `material-varying`, without them; `non-rotating`,
    /// where the mean pattern stands still.
    pub frame: &'static str,
    /// Place on the circumference, or the mean over it.
    pub place: VelocityPlace,
    /// Spectrum of the velocity \[m^2/s^2\].
    pub spectrum: PowerSpectrum,
}

impl VelocitySpectrum {
    /// Field with frame or place, for legends.
    pub fn name(&self) -> String {
        match self.place {
            VelocityPlace::Everywhere => format!("{}, {}", self.field, self.frame),
            VelocityPlace::Position(position) => format!("{} at {position} m", self.field),
            VelocityPlace::Element(element) => format!("{}, element {element}", self.field),
        }
    }

    /// Cells of [`NAMES`], followed by some numbers.
    fn row<const COUNT: usize>(&self, numbers: [f64; COUNT]) -> Vec<String> {
        let [position, element] = match self.place {
            VelocityPlace::Everywhere => [String::new(), String::new()],
            VelocityPlace::Position(position) => [position.to_string(), String::new()],
            VelocityPlace::Element(element) => [String::new(), element.to_string()],
        };
        let mut row = row([&self.field, &self.frame, &position, &element]);
        row.extend(numbers.texts());
        row
    }
}

/// Table of third-octave levels: nominal and exact mid-frequency \[Hz\], mean square \[m^2/s^2\], level \[dB re 1
/// m/s\], 1 for valid levels and 0 for others, the error by slices where that is known \[dB\], of all bands from
/// `lowest` \[Hz\] on.
pub fn vibration_levels_csv(spectra: &[VelocitySpectrum], lowest: f64, errors: &LevelErrors) -> String {
    let header = "nominal_hz,mid_frequency_hz,mean_square_m2_s2,level_db_re_1m_s,valid,slice_error_db";
    let rows = spectra.iter().flat_map(|named| {
        named.spectrum.third_octaves(lowest, 1.0).into_iter().map(|BandLevel { band, mean_square, level, valid }| {
            let valid = f64::from(u8::from(valid));
            let error = errors.by_slices(band).unwrap_or(f64::NAN);
            named.row([band.nominal_frequency(), band.mid_frequency(), mean_square, level, valid, error])
        })
    });
    csv(NAMES.into_iter().chain(header.split(',')), rows)
}

/// Table of narrow-band spectra: frequency \[Hz\] and power spectral density \[m^2/s^2/Hz\].
pub(crate) fn vibration_narrow_csv(spectra: &[VelocitySpectrum]) -> String {
    let rows = spectra
        .iter()
        .flat_map(|named| named.spectrum.density().map(|(frequency, density)| named.row([frequency, density])));
    csv(NAMES.into_iter().chain(["frequency_hz", "density_m2_s2_hz"]), rows)
}

/// Part of `summary.json` on the vibration.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct VibrationSummary {
    /// Number of segments averaged, half of each shared with the next.
    pub segments: u64,
    /// Length of a segment \[s\].
    pub segment_seconds: f64,
    /// Revolutions of a segment.
    pub revolutions: usize,
    /// Frequency resolution \[Hz\].
    pub resolution: f64,
    /// Time at the end of the run that fills no segment and is left out \[s\].
    pub seconds_left_out: f64,
    /// Number of lateral waves, for forces on cells, that contribute to means across the strip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waves_across: Option<usize>,
    /// Velocities by field.
    pub fields: Vec<FieldSummary>,
    /// Power balance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power: Option<PowerSummary>,
    /// Error and truncation of the tangential transfer, relative to its largest value, where it was computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential_error: Option<[f64; 2]>,
}

/// Velocities of a field, root mean squares over time and circumference.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct FieldSummary {
    /// Field: `tread`, `belt` or `tangential`.
    pub field: Cow<'static, str>,
    /// Root mean square of the vibration, the mean pattern left out \[m/s\].
    pub rms_velocity: f64,
    /// Root mean square of the mean pattern, which stands still over the road and passes the material \[m/s\].
    pub rms_mean_pattern: f64,
    /// 20 lg of the vibration, which has the time rule's transfer, over that with the exact transfer of the tyre under
    /// the same forces \[dB\]; `None` for cells.
    pub rule_difference: Option<f64>,
    /// The same at its largest among the third octaves below 1 kHz.
    pub rule_difference_below_1k: Option<f64>,
}

/// Power that the contact forces put in, compared with the power that the tyre dissipates \[W\].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct PowerSummary {
    /// Power put in: forces times velocities, in the time domain.
    pub put_in: f64,
    /// Power of forces on cells that goes into the waves that the run carries, and that is dissipated there. The rest
    /// is lost in the part of the response that follows the forces at once, by the time rule's damping.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub put_into_waves: Option<f64>,
    /// Power dissipated by the mean pattern, with the time rule's transfer.
    pub dissipated_by_mean_pattern: f64,
    /// Power dissipated by the vibration.
    pub dissipated_by_vibration: f64,
    /// (put in - dissipated)/put in, for the waves that the run carries.
    pub relative_difference: f64,
    /// Total dissipated power with the exact transfer of the tyre instead of the rule's; `None` for cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dissipated_by_tyre: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_hold_every_spectrum_once_and_all_digits() {
        let spectrum = PowerSpectrum::of_powers(vec![1.0 / 7.0; 601], 1.0 / 3.0, 200.0).valid_to(150.0);
        let named =
            |place| VelocitySpectrum { field: "belt", frame: "non-rotating", place, spectrum: spectrum.clone() };
        let spectra =
            [named(VelocityPlace::Everywhere), named(VelocityPlace::Position(-0.1)), named(VelocityPlace::Element(7))];
        let narrow = vibration_narrow_csv(&spectra);
        assert_eq!(narrow.lines().count(), 1 + 3 * 601);
        let row: Vec<&str> = narrow.lines().nth(603).unwrap().split(',').collect();
        assert_eq!(&row[..5], ["belt", "non-rotating", "-0.1", "", "0.3333333333333333"]);
        assert_eq!(
            row[5].parse::<f64>().unwrap().to_bits(),
            (1.0 / 7.0 / (1.5 * (1.0 / 3.0) - 0.5 * (1.0 / 3.0_f64))).to_bits()
        );
        let levels = vibration_levels_csv(&spectra, 20.0, &LevelErrors::default());
        let bands = spectrum.third_octaves(20.0, 1.0).len();
        assert_eq!(levels.lines().count(), 1 + 3 * bands);
        assert!(levels.lines().nth(1).unwrap().starts_with("belt,non-rotating,,,25,"), "{levels}");
        assert_eq!(spectra[1].name(), "belt at -0.1 m");
        assert!(levels.lines().last().unwrap().starts_with("belt,non-rotating,,7,"), "{levels}");
    }
}
