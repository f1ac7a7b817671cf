//! How a level grows with the speed.
//!
//! Least squares of L = a + b lg(V/V_0) over the speeds: b is the growth in dB per decade of speed, 10 times the
//! exponent of the mean square. The root mean square of the residuals shows whether one number is enough.

use crate::numeric::StraightLine;

/// A straight line through levels over the logarithm of the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedExponent {
    /// Growth \[dB per decade of speed\].
    pub decibels_per_decade: f64,
    /// Root mean square of the levels' distances from the line \[dB\]; `None` for two levels: the line goes through
    /// both.
    pub residual: Option<f64>,
    /// Number of pairs of speed and level that count.
    pub speeds: usize,
}

impl SpeedExponent {
    /// Fits pairs of speed (> 0, any unit) and level \[dB\]; pairs without a finite level do not count. `None` for
    /// fewer than two different speeds.
    pub(crate) fn fit(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let points: Vec<(f64, f64)> = pairs
            .into_iter()
            .map(|(speed, level)| (speed.log10(), level))
            .filter(|(x, level)| x.is_finite() && level.is_finite())
            .collect();
        let line = StraightLine::through(&points)?;
        let residual = (points.len() > 2).then_some(line.residual);
        Some(Self { decibels_per_decade: line.slope, residual, speeds: points.len() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_exactly_and_a_bend_shows() {
        let speeds = [50.0, 60.0, 70.0, 80.0, 100.0, 130.0];
        let line = speeds.map(|speed: f64| (speed, 12.0 + 27.5 * speed.log10()));
        let found = SpeedExponent::fit(line).unwrap();
        assert!((found.decibels_per_decade - 27.5).abs() < 1e-12 && found.residual.unwrap() < 1e-13, "{found:?}");
        assert_eq!(found.speeds, 6);
        // A square of the logarithm over three equidistant ones: x^2 on -1, 0, 1 has slope 0 and misses 2/3, 1/3, 1/3
        // of it.
        let bend = [(0.1, 3.0), (1.0, 0.0), (10.0, 3.0)];
        let found = SpeedExponent::fit(bend).unwrap();
        assert!(found.decibels_per_decade.abs() < 1e-12 && (found.residual.unwrap() - 2.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn silence_does_not_count_and_one_speed_has_no_exponent() {
        let silent = [(50.0, 1.0), (80.0, f64::NEG_INFINITY), (100.0, 7.0)];
        let found = SpeedExponent::fit(silent).unwrap();
        assert_eq!((found.speeds, found.residual), (2, None));
        assert_eq!(SpeedExponent::fit([(80.0, 1.0), (80.0, 2.0)]), None);
        assert_eq!(SpeedExponent::fit([]), None);
    }
}
