//! The frequency weightings A and Z of IEC 61672-1:2013.
//!
//! Annex E gives A as four real poles, two of them double, and a fourfold zero at 0:
//!
//! ```text
//! R(f) = f_4^2 f^4 / ((f^2 + f_1^2) sqrt(f^2 + f_2^2) sqrt(f^2 + f_3^2) (f^2 + f_4^2)),  A(f) = R(f)/R(1 kHz)
//! ```
//!
//! f_1 ... f_4 follow from the two cut-off frequencies 10^1.5 and 10^3.9 Hz of the C-weighting, 3 dB down, and the
//! high-pass at 10^2.45 Hz (formulas E.2 to E.6); they are computed here rather than copied. Z is 1 everywhere.

use crate::response::PowerSpectrum;

/// Frequency at which every weighting has the gain 1 \[Hz\].
pub(crate) const REFERENCE_FREQUENCY: f64 = 1000.0;

/// Frequency weighting of a sound level meter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FrequencyWeighting {
    /// A: the sensitivity of the ear for faint sounds.
    A,
    /// Z: flat, gain 1 at all frequencies.
    Z,
}

impl FrequencyWeighting {
    /// Gain at a frequency \[Hz\], the factor of amplitudes; 1 at 1 kHz.
    pub fn gain(self, frequency: f64) -> f64 {
        match self {
            Self::A => response(frequency) / response(REFERENCE_FREQUENCY),
            Self::Z => 1.0,
        }
    }

    /// The same in decibels; minus infinity for A at 0 Hz.
    pub fn decibels(self, frequency: f64) -> f64 {
        20.0 * self.gain(frequency).log10()
    }

    /// Spectrum of the weighted signal: each bin's power times the squared gain at its frequency.
    ///
    /// A wide bin gets the gain of its middle: with bins of 3 Hz and the steepest slope, 24 dB per octave, that is an
    /// error of 0.03 dB at 50 Hz, where A is -30 dB.
    pub fn of_spectrum(self, spectrum: &PowerSpectrum) -> PowerSpectrum {
        let bins = spectrum.power.iter().enumerate();
        let power = bins.map(|(bin, power)| power * self.gain(bin as f64 * spectrum.resolution).powi(2));
        PowerSpectrum { power: power.collect(), ..spectrum.clone() }
    }

    /// `A` or `Z`, as in units and file names.
    pub fn letter(self) -> char {
        match self {
            Self::A => 'A',
            Self::Z => 'Z',
        }
    }
}

/// Pole frequencies f_1 ... f_4 of the A-weighting \[Hz\]: formulas E.2 to E.6, with D^2 = 1/2.
pub(super) fn poles() -> [f64; 4] {
    let [reference, low, high] = [REFERENCE_FREQUENCY, 10.0_f64.powf(1.5), 10.0_f64.powf(3.9)].map(|f| f * f);
    let half = 0.5_f64.sqrt();
    let b = (reference + low * high / reference - half * (low + high)) / (1.0 - half);
    let c = low * high;
    let root = (b * b - 4.0 * c).sqrt();
    let high_pass = 10.0_f64.powf(2.45);
    let five = 5.0_f64.sqrt();
    [
        (0.5 * (-b - root)).sqrt(),
        0.5 * (3.0 - five) * high_pass,
        0.5 * (3.0 + five) * high_pass,
        (0.5 * (-b + root)).sqrt(),
    ]
}

/// R(f) of the module's head.
fn response(frequency: f64) -> f64 {
    let square = frequency * frequency;
    let [first, second, third, fourth] = poles().map(|pole| pole * pole);
    let root = ((square + second) * (square + third)).sqrt();
    fourth * square * square / ((square + first) * root * (square + fourth))
}

/// Table 3 of IEC 61672-1:2013: nominal frequency \[Hz\], A-weighting \[dB\], class 1 acceptance limits \[dB\].
#[cfg(test)]
pub(super) const TABLE_3: [(f64, f64, f64, f64); 34] = {
    const NONE: f64 = f64::NEG_INFINITY;
    [
        (10.0, -70.4, 3.0, NONE),
        (12.5, -63.4, 2.5, NONE),
        (16.0, -56.7, 2.0, -4.0),
        (20.0, -50.5, 2.0, -2.0),
        (25.0, -44.7, 2.0, -1.5),
        (31.5, -39.4, 1.5, -1.5),
        (40.0, -34.6, 1.0, -1.0),
        (50.0, -30.2, 1.0, -1.0),
        (63.0, -26.2, 1.0, -1.0),
        (80.0, -22.5, 1.0, -1.0),
        (100.0, -19.1, 1.0, -1.0),
        (125.0, -16.1, 1.0, -1.0),
        (160.0, -13.4, 1.0, -1.0),
        (200.0, -10.9, 1.0, -1.0),
        (250.0, -8.6, 1.0, -1.0),
        (315.0, -6.6, 1.0, -1.0),
        (400.0, -4.8, 1.0, -1.0),
        (500.0, -3.2, 1.0, -1.0),
        (630.0, -1.9, 1.0, -1.0),
        (800.0, -0.8, 1.0, -1.0),
        (1000.0, 0.0, 0.7, -0.7),
        (1250.0, 0.6, 1.0, -1.0),
        (1600.0, 1.0, 1.0, -1.0),
        (2000.0, 1.2, 1.0, -1.0),
        (2500.0, 1.3, 1.0, -1.0),
        (3150.0, 1.2, 1.0, -1.0),
        (4000.0, 1.0, 1.0, -1.0),
        (5000.0, 0.5, 1.5, -1.5),
        (6300.0, -0.1, 1.5, -2.0),
        (8000.0, -1.1, 1.5, -2.5),
        (10_000.0, -2.5, 2.0, -3.0),
        (12_500.0, -4.3, 2.0, -5.0),
        (16_000.0, -6.6, 2.5, -16.0),
        (20_000.0, -9.3, 3.0, NONE),
    ]
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::ThirdOctaveBand;

    #[test]
    fn poles_are_those_that_the_standard_prints() {
        // IEC 61672-1:2013, annex E: 20.60, 107.7, 737.9 and 12194 Hz.
        for (pole, printed, last_digit) in poles()
            .into_iter()
            .zip([20.60, 107.7, 737.9, 12194.0])
            .zip([0.01, 0.1, 0.1, 1.0])
            .map(|((a, b), c)| (a, b, c))
        {
            assert!((pole - printed).abs() <= 0.5 * last_digit, "{pole} is printed as {printed}");
        }
    }

    #[test]
    fn weights_are_those_of_table_3_at_all_third_octaves() {
        for (n, (nominal, table, ..)) in (-20..=13).zip(TABLE_3) {
            let band = ThirdOctaveBand(n);
            assert!((band.nominal_frequency() / nominal - 1.0).abs() < 1e-12);
            let weight = FrequencyWeighting::A.decibels(band.mid_frequency());
            // The table is rounded to tenths.
            assert!((weight - table).abs() <= 0.05, "{nominal} Hz: {weight} dB, table {table} dB");
            assert_eq!(FrequencyWeighting::Z.decibels(nominal).to_bits(), 0);
        }
        assert!(FrequencyWeighting::A.decibels(1000.0).abs() < 1e-12);
        assert!(FrequencyWeighting::A.decibels(0.0).is_infinite());
    }

    #[test]
    fn a_weighted_spectrum_has_the_weighted_lines_and_no_mean() {
        let signal: Vec<f64> = (0..8000)
            .map(|n| f64::from(n) * std::f64::consts::TAU / 8000.0)
            .map(|angle| 3.0 + (1000.0 * angle).sin() + (100.0 * angle).sin())
            .collect();
        let spectrum = PowerSpectrum::of(&signal, 1.0 / 8000.0, None).unwrap();
        let weighted = FrequencyWeighting::A.of_spectrum(&spectrum);
        for (line, weight) in [(1000.0, 0.0), (100.0, -19.145)] {
            let [before, after] = [&spectrum, &weighted].map(|all| all.power_within(line - 5.0..line + 5.0));
            assert!((10.0 * (after / before).log10() - weight).abs() < 0.01, "{line} Hz");
        }
        assert_eq!(weighted.power[0].to_bits(), 0);
    }
}
