//! sin(x)/x.

/// Returns sin(x)/x, 1 at 0.
pub(crate) fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}
