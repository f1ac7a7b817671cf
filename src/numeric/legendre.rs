//! Gauss-Legendre quadrature, on one panel and on two, and the polynomials through the points of two.

use super::lagrange;

/// Nodes on (-1, 1), falling, and weights: exact up to the degree 2 `points` - 1.
///
/// Newton's iteration on P_n from Tricomi's estimates (Press et al., *Numerical Recipes*, section 4.6).
pub(crate) fn gauss(points: usize) -> Vec<[f64; 2]> {
    let count = points as f64;
    (0..points)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (count + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..NEWTON_STEPS {
                let (mut value, mut before) = (1.0, 0.0);
                for degree in 1..=points {
                    let j = degree as f64;
                    (value, before) = (((2.0 * j - 1.0) * x * value - (j - 1.0) * before) / j, value);
                }
                slope = count * (x * value - before) / (x * x - 1.0);
                x -= value / slope;
            }
            [x, 2.0 / ((1.0 - x * x) * slope * slope)]
        })
        .collect()
}

/// Steps from the estimates to rounding, for any number of points.
const NEWTON_STEPS: usize = 6;

/// A rule over (0, 1) in two panels that meet at a fraction: exact on each for polynomials up to degree 3 and 5.
#[derive(Clone, Debug, PartialEq)]
pub struct SplitRule {
    /// End of the first panel, 0 to 1.
    pub split: f64,
    /// Points, rising; those of the first panel come first.
    pub points: [f64; Self::POINTS],
    /// Weights, 1 together.
    pub weights: [f64; Self::POINTS],
}

impl SplitRule {
    /// Points of the first panel.
    pub const FIRST: usize = 2;
    /// Points of both panels.
    pub const POINTS: usize = Self::FIRST + 3;

    /// The rule with panels that meet at `split`, 0 < `split` < 1.
    pub fn new(split: f64) -> Self {
        let mut rule = Self { split, points: [0.0; Self::POINTS], weights: [0.0; Self::POINTS] };
        for (range, [from, to]) in [(0..Self::FIRST, [0.0, split]), (Self::FIRST..Self::POINTS, [split, 1.0])] {
            let nodes = gauss(range.len()).into_iter().rev();
            for (place, [node, weight]) in range.zip(nodes) {
                rule.points[place] = 0.5 * ((from + to) + (to - from) * node);
                rule.weights[place] = 0.5 * (to - from) * weight;
            }
        }
        rule
    }

    /// Values at the fraction `at` of the polynomials that are 1 at one point and 0 at the others of its panel, 0 on
    /// the other panel.
    pub fn polynomials(&self, at: f64) -> [f64; Self::POINTS] {
        let range = if at < self.split { 0..Self::FIRST } else { Self::FIRST..Self::POINTS };
        let mut values = [0.0; Self::POINTS];
        values[range.clone()].iter_mut().zip(lagrange::weights(&self.points[range], at)).for_each(|(v, w)| *v = w);
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_powers_up_to_its_degree() {
        for points in [1, 2, 5, 24, 40] {
            let rule = gauss(points);
            for power in 0..2 * points as i32 {
                let found: f64 = rule.iter().map(|[x, weight]| weight * x.powi(power)).sum();
                let exact = if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
                assert!((found - exact).abs() < 1e-14, "{points} points, power {power}: {found}");
            }
        }
    }

    #[test]
    fn a_polynomial_on_each_panel_is_met_and_integrated() {
        let rule = SplitRule::new(0.3);
        let of = |x: f64| if x < 0.3 { 1.0 - 2.0 * x } else { 4.0 + x * (x - 3.0) };
        for at in [0.0, 0.1, 0.29, 0.31, 0.7, 1.0] {
            let values = rule.polynomials(at);
            let met: f64 = values.iter().zip(&rule.points).map(|(value, &point)| value * of(point)).sum();
            assert!((met - of(at)).abs() < 1e-13, "{at}: {met}");
            assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        }
        let integral: f64 = rule.weights.iter().zip(&rule.points).map(|(weight, &point)| weight * of(point)).sum();
        let exact = 0.3 - 0.09 + 4.0 * 0.7 + (1.0 - 0.027) / 3.0 - 1.5 * (1.0 - 0.09);
        assert!((integral - exact).abs() < 1e-13, "{integral}: {exact}");
    }
}
