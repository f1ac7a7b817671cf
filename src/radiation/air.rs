//! Air by its temperature, at the standard pressure.
//!
//! Sound speed after ISO 9613-1:1993: c = 343.2 m/s sqrt(T/293.15 K). Density of dry air as an ideal gas: p/(R T), R =
//! 287.05 J/(kg K). Humidity is left out: saturated air at 20 degC carries sound 0.4 % faster and weighs 1 % less,
//! which changes no level by more than 0.1 dB.

use super::gap::GapAir;

/// Standard atmospheric pressure \[Pa\] (ISO 9613-1: the reference pressure).
pub(crate) const STANDARD_PRESSURE: f64 = 101_325.0;

/// 0 degC in kelvin.
const ICE_POINT: f64 = 273.15;
/// Temperature \[K\] and sound speed \[m/s\] of reference in ISO 9613-1.
const REFERENCE: (f64, f64) = (293.15, 343.2);
/// Specific gas constant of dry air \[J/(kg K)\].
const GAS_CONSTANT: f64 = 287.05;

/// Sutherland's law of the dynamic viscosity, b T^1.5/(T + S) (U.S. Standard Atmosphere, 1976) \[Pa s/K^0.5\] and
/// \[K\].
const SUTHERLAND: (f64, f64) = (1.458e-6, 110.4);
/// Prandtl number of dry air at 0 to 40 degC.
const PRANDTL: f64 = 0.71;
/// Ratio of the heat capacities of air.
pub(crate) const HEAT_RATIO: f64 = 1.4;

/// Air at rest, at 101 325 Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Temperature \[degC\].
    pub temperature: f64,
    /// Sound speed \[m/s\].
    pub sound_speed: f64,
    /// Density \[kg/m^3\].
    pub density: f64,
}

impl Air {
    /// Air of a temperature \[degC\]; `None` unless it is finite and above absolute zero.
    ///
    /// ```
    /// let air = tyrewave::sound::Air::at(20.0).ok_or("no such air")?;
    /// assert!((air.impedance() - 413.3).abs() < 0.1);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn at(temperature: f64) -> Option<Self> {
        let kelvin = temperature + ICE_POINT;
        (kelvin.is_finite() && kelvin > 0.0).then(|| Self {
            temperature,
            sound_speed: REFERENCE.1 * (kelvin / REFERENCE.0).sqrt(),
            density: STANDARD_PRESSURE / (GAS_CONSTANT * kelvin),
        })
    }

    /// The same air as a model of narrow gaps needs it, with viscosity and heat conduction.
    pub(crate) fn in_gap(&self) -> GapAir {
        let kelvin = self.temperature + ICE_POINT;
        let viscosity = SUTHERLAND.0 * kelvin.powf(1.5) / (kelvin + SUTHERLAND.1) / self.density;
        GapAir { sound_speed: self.sound_speed, viscosity, prandtl: PRANDTL, heat_ratio: HEAT_RATIO }
    }

    /// Characteristic impedance rho c \[Pa s/m\].
    pub fn impedance(&self) -> f64 {
        self.density * self.sound_speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn air_is_that_of_the_tables() {
        // Tables of dry air at one atmosphere: -10, 0 and 20 degC, to the last digit that they print.
        for (temperature, speed, density, impedance) in
            [(-10.0, 325.2, 1.341, 436.1), (0.0, 331.3, 1.292, 428.0), (20.0, 343.2, 1.204, 413.3)]
        {
            let air = Air::at(temperature).unwrap();
            assert!((air.sound_speed - speed).abs() < 0.06, "{air:?}");
            assert!((air.density - density).abs() < 6e-4, "{air:?}");
            assert!((air.impedance() - impedance).abs() < 0.2, "{air:?}");
        }
    }

    #[test]
    fn the_viscosity_is_that_of_the_tables() {
        // 1e-6 m^2/s of dry air at 0, 20 and 40 degC.
        for (temperature, viscosity) in [(0.0, 13.3), (20.0, 15.1), (40.0, 17.0)] {
            let found = 1e6 * Air::at(temperature).unwrap().in_gap().viscosity;
            assert!((found - viscosity).abs() < 0.1, "{temperature}: {found}");
        }
    }

    #[test]
    fn what_is_colder_than_absolute_zero_is_no_air() {
        for temperature in [-273.15, -300.0, f64::NAN, f64::INFINITY] {
            assert_eq!(Air::at(temperature), None);
        }
    }
}
