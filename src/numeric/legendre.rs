//! Gauss-Legendre quadrature.

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
}
