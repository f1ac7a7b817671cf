//! Student's distribution.

/// Probability that |t| stays below a value for so many degrees of freedom (at least 1): Abramowitz and Stegun, 26.7.3
/// and 26.7.4.
fn probability_of_student(value: f64, freedom: usize) -> f64 {
    let angle = (value / (freedom as f64).sqrt()).atan();
    let (sine, cosine) = angle.sin_cos();
    // cos + 2/3 cos^3 + ... + (2 4 ...)/(3 5 ...) cos^(n-2) for odd n, 1 + 1/2 cos^2 + ... for even n.
    let odd = freedom % 2;
    let mut term = if odd == 1 { cosine } else { 1.0 };
    let mut sum = 0.0;
    for power in (odd..freedom.saturating_sub(1)).step_by(2) {
        sum += term;
        term *= cosine * cosine * (power + 1) as f64 / (power + 2) as f64;
    }
    if odd == 1 { std::f64::consts::FRAC_2_PI * (angle + sine * sum) } else { sine * sum }
}

/// Two-sided 95 % quantile: |t| stays below it with a probability of 95 %; `None` without a degree of freedom.
pub(crate) fn quantile_of_student(freedom: usize) -> Option<f64> {
    if freedom == 0 {
        return None;
    }
    // 12.7 for one degree of freedom, falling to 1.96; 60 bisections end at rounding.
    let (mut low, mut high) = (1.9, 13.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if probability_of_student(middle, freedom) < 0.95 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz and Stegun, table 26.10.
        for (freedom, quantile) in
            [(1, 12.706), (2, 4.303), (3, 3.182), (4, 2.776), (5, 2.571), (6, 2.447), (10, 2.228), (30, 2.042)]
        {
            let found = quantile_of_student(freedom).unwrap();
            assert!((found - quantile).abs() < 6e-4, "{freedom}: {found}");
        }
        assert_eq!(quantile_of_student(0), None);
    }
}
