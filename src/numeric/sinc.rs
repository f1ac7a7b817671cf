//! sin(x)/x.

/// sin(x)/x; 1 at 0, by its series for |x| < 1e-4, where the next term is below rounding.
pub(crate) fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}
