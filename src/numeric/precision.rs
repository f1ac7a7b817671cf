//! Complex numbers in single precision, in which large tables are stored.

use num_complex::{Complex32, Complex64};

/// Rounds to single precision; relative error 6e-8 in each part.
#[inline]
pub(crate) fn single(value: Complex64) -> Complex32 {
    Complex32::new(value.re as f32, value.im as f32)
}

/// The same number in double precision, exactly.
#[inline]
pub fn double(value: Complex32) -> Complex64 {
    Complex64::new(f64::from(value.re), f64::from(value.im))
}
