//! `vibration.csv`, `vibration_narrow.csv` and the vibration's part of the summary.
//!
//! One row for each field, frame, place and band (or frequency). A position or the number of an element stands where
//! the spectrum is that of a point; without either it is the mean over the circumference.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::table::{Cells, csv, row};
use crate::response::{BandLevel, LevelErrors, PowerSpectrum};

/// Third octaves.
pub(crate) const VIBRATION_FILE: &str = "vibration.csv";
/// Quantity of its levels.
pub(crate) const VELOCITY_LEVEL: &str = "Velocity level [dB re 1 m/s]";
/// Narrow band.
pub(crate) const VIBRATION_NARROW_FILE: &str = "vibration_narrow.csv";

/// The columns that say which spectrum a row is of.
const NAMES: [&str; 4] = ["field", "frame", "position_m", "element"];

/// Where a spectrum was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VelocityPlace {
    /// Mean over the circumference.
    Everywhere,
    /// Beside the road, at a distance from the axle \[m\].
    Position(f64),
    /// On the tyre, at an element.
    Element(usize),
}

/// A spectrum with its names.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocitySpectrum {
    /// `tread`, `belt`, `tangential`.
    pub field: &'static str,
    /// `material`, the lines of the mean pattern included; `material-varying`, without them; `non-rotating`, where it
    /// stands still.
    pub frame: &'static str,
    /// Where.
    pub place: VelocityPlace,
    /// The spectrum \[m^2/s^2\].
    pub spectrum: PowerSpectrum,
}

impl VelocitySpectrum {
    /// Returns the field with frame or place, for legends.
    pub fn name(&self) -> String {
        match self.place {
            VelocityPlace::Everywhere => format!("{}, {}", self.field, self.frame),
            VelocityPlace::Position(position) => format!("{} at {position} m", self.field),
            VelocityPlace::Element(element) => format!("{}, element {element}", self.field),
        }
    }

    /// Returns its [`NAMES`] and some numbers.
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

/// Returns the third-octave levels: nominal and exact mid-frequency \[Hz\], mean square \[m^2/s^2\], level \[dB re 1
/// m/s\], 1 where the run vouches for it and 0 beyond, its error by slices where that is known \[dB\], of all bands
/// from `lowest` \[Hz\] on.
pub(crate) fn vibration_levels_csv(spectra: &[VelocitySpectrum], lowest: f64, errors: &LevelErrors) -> String {
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

/// Returns the narrow-band spectra: frequency \[Hz\] and power spectral density \[m^2/s^2/Hz\].
pub(crate) fn vibration_narrow_csv(spectra: &[VelocitySpectrum]) -> String {
    let rows = spectra
        .iter()
        .flat_map(|named| named.spectrum.density().map(|(frequency, density)| named.row([frequency, density])));
    csv(NAMES.into_iter().chain(["frequency_hz", "density_m2_s2_hz"]), rows)
}

/// Part of `summary.json` on the vibration.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct VibrationSummary {
    /// Segments averaged, half of each shared with the next.
    pub segments: u64,
    /// Length of a segment \[s\], and the revolutions that it is.
    pub segment_seconds: f64,
    /// Revolutions of a segment.
    pub revolutions: usize,
    /// Frequency resolution \[Hz\].
    pub resolution: f64,
    /// Time at the end of the run that fills no segment and is left out \[s\].
    pub seconds_left_out: f64,
    /// Lateral waves of forces on cells that means across the strip hear.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waves_across: Option<usize>,
    /// By field.
    pub fields: Vec<FieldSummary>,
    /// Power balance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power: Option<PowerSummary>,
    /// Error and truncation of the tangential transfer, relative to its largest value, where it was wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential_error: Option<[f64; 2]>,
}

/// Velocities of a field, root mean squares over time and circumference.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct FieldSummary {
    /// `tread`, `belt`, `tangential`.
    pub field: Cow<'static, str>,
    /// Root mean square of the vibration, the mean pattern left out \[m/s\].
    pub rms_velocity: f64,
    /// Root mean square of the mean pattern, which stands over the road and passes the material \[m/s\].
    pub rms_mean_pattern: f64,
    /// 20 lg of the vibration, which has the time rule's transfer, over that with the tyre's own under the same forces
    /// \[dB\]; `null` for the first-order hold, whose transfer is the tyre's, and for cells.
    pub rule_difference: Option<f64>,
    /// The same where it is largest among the third octaves below 1 kHz.
    pub rule_difference_below_1k: Option<f64>,
}

/// Power that the contact forces put in, against what the tyre dissipates \[W\].
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct PowerSummary {
    /// Put in: forces times velocities, in the time domain.
    pub put_in: f64,
    /// Power of forces on cells that goes into the waves that the run carries, and that is dissipated there.
    /// The rest is lost in what follows the forces at once, by the time rule's damping.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub put_into_waves: Option<f64>,
    /// Dissipated by the mean pattern, by the time rule's transfer.
    pub dissipated_by_mean_pattern: f64,
    /// Dissipated by the vibration.
    pub dissipated_by_vibration: f64,
    /// (put in - dissipated)/put in, of the waves that the run carries.
    pub relative_difference: f64,
    /// All that is dissipated, by the tyre's own transfer instead of the rule's; not known of cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dissipated_by_tyre: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_hold_every_spectrum_once_and_all_digits() {
        let spectrum = PowerSpectrum {
            mean: 0.0,
            resolution: 1.0 / 3.0,
            power: vec![1.0 / 7.0; 601],
            nyquist: 200.0,
            valid_to: 150.0,
        };
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
