//! Complex arithmetic as the compliance kernel needs it, for one number or for several in lockstep; and complex numbers
//! in single precision, in which large tables are stored.

use std::ops::{Add, Mul, Neg, Sub};

use num_complex::{Complex32, Complex64};

/// A complex number, or several processed in lockstep.
///
/// The compliance kernel is written once against this trait: with [`Complex64`] it is the readable reference, with
/// lanes of numbers it is the fast path.
pub trait ComplexField:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Add<f64, Output = Self>
    + Neg<Output = Self>
{
    /// A real constant, in as many lanes as `self` has.
    fn like(self, value: f64) -> Self;
    /// self + factor z.
    fn plus_scaled(self, factor: f64, z: Self) -> Self;
    /// i z.
    fn times_i(self) -> Self;
    /// 1/z.
    fn reciprocal(self) -> Self;
    /// Square root with non-negative real part.
    fn square_root(self) -> Self;
    /// exp(z).
    fn exponential(self) -> Self;
    /// The numbers `value`(0), `value`(1), ..., one per lane of `self`.
    fn gathered(self, value: impl FnMut(usize) -> Complex64) -> Self;
    /// `small` where |self|^2 < `limit`, `large` elsewhere.
    fn select_below(self, limit: f64, small: Self, large: Self) -> Self;
    /// Carries out a long part as a function that all callers share: inlined, each would have a copy for every set of
    /// instructions. The call takes some nanoseconds. The part has to be inlined into it (`#[inline(always)]`).
    fn outlined<R>(self, part: impl FnOnce() -> R) -> R;
}

impl ComplexField for Complex64 {
    #[inline]
    fn like(self, value: f64) -> Self {
        Self::new(value, 0.0)
    }

    #[inline]
    fn plus_scaled(self, factor: f64, z: Self) -> Self {
        self + z * factor
    }

    #[inline]
    fn times_i(self) -> Self {
        Self::new(-self.im, self.re)
    }

    #[inline]
    fn reciprocal(self) -> Self {
        self.inv()
    }

    #[inline]
    fn square_root(self) -> Self {
        self.sqrt()
    }

    #[inline]
    fn exponential(self) -> Self {
        self.exp()
    }

    #[inline]
    fn gathered(self, mut value: impl FnMut(usize) -> Complex64) -> Self {
        value(0)
    }

    #[inline]
    fn select_below(self, limit: f64, small: Self, large: Self) -> Self {
        if self.norm_sqr() < limit { small } else { large }
    }

    #[inline(never)]
    fn outlined<R>(self, part: impl FnOnce() -> R) -> R {
        part()
    }
}

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
