//! A straight line through points, by least squares.

/// y = intercept + slope x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StraightLine {
    /// Change of y per unit of x.
    pub slope: f64,
    /// y at x = 0.
    pub intercept: f64,
    /// Root mean square of the residuals.
    pub residual: f64,
}

impl StraightLine {
    /// Fits a line through at least two points of different x; `None` otherwise.
    pub(crate) fn through(points: &[(f64, f64)]) -> Option<Self> {
        let count = points.len() as f64;
        let mean = |value: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / count;
        let (x, y) = (mean(&|point| point.0), mean(&|point| point.1));
        let spread = mean(&|point| (point.0 - x).powi(2));
        // Positions that agree to rounding are one.
        if points.len() < 2 || spread <= 1e-20 * (1.0 + x * x) {
            return None;
        }
        let slope = mean(&|point| (point.0 - x) * (point.1 - y)) / spread;
        let intercept = y - slope * x;
        let residual = mean(&|point| (point.1 - intercept - slope * point.0).powi(2)).sqrt();
        Some(Self { slope, intercept, residual })
    }

    /// The line through the base-10 logarithms of positive values: y ~ x^slope.
    pub(crate) fn power_law(points: &[(f64, f64)]) -> Option<Self> {
        let logarithms: Vec<_> = points.iter().map(|point| (point.0.log10(), point.1.log10())).collect();
        Self::through(&logarithms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_again_and_what_is_no_line_leaves_a_residual() {
        let line = StraightLine::through(&[(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]).expect("a line");
        assert!((line.slope - 2.0).abs() < 1e-14 && (line.intercept - 3.0).abs() < 1e-14 && line.residual < 1e-14);
        let bent = StraightLine::through(&[(0.0, 0.0), (1.0, 3.0), (2.0, 0.0)]).expect("a line");
        assert!((bent.residual - 2.0_f64.sqrt()).abs() < 1e-14, "{bent:?}");
        let cubic = StraightLine::power_law(&[(10.0, 2e3), (100.0, 2e6)]).expect("a line");
        assert!((cubic.slope - 3.0).abs() < 1e-14);
        assert_eq!(StraightLine::through(&[(1.0, 2.0), (1.0, 3.0)]), None);
        assert_eq!(StraightLine::through(&[(1.0, 2.0)]), None);
    }
}
