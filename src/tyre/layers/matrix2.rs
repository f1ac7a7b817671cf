//! 2x2 matrices over a [`ComplexField`]: all the linear algebra that the P-SV system needs.

use std::ops::{Add, Mul, Sub};

use crate::numeric::ComplexField;

/// A 2x2 matrix, rows first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Matrix2<T>(pub [[T; 2]; 2]);

impl<T: ComplexField> Matrix2<T> {
    /// diag(a, b).
    #[inline(always)]
    pub(crate) fn diagonal(a: T, b: T) -> Self {
        let zero = a.like(0.0);
        Self([[a, zero], [zero, b]])
    }

    /// a b^-1 by cofactors. A singular `b` gives entries that are not finite.
    #[inline(always)]
    pub(crate) fn over(self, b: Self) -> Self {
        self * b.inverse()
    }

    /// a^-1 b by cofactors. A singular `a` gives entries that are not finite.
    #[inline(always)]
    pub(crate) fn solve(self, b: Self) -> Self {
        self.inverse() * b
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        let [[p, q], [r, s]] = self.0;
        let scale = (p * s - q * r).reciprocal();
        Self([[s * scale, -(q * scale)], [-(r * scale), p * scale]])
    }

    #[inline(always)]
    pub(crate) fn scaled(self, factor: T) -> Self {
        let [[a, b], [c, d]] = self.0;
        Self([[a * factor, b * factor], [c * factor, d * factor]])
    }
}

impl<T: ComplexField> Add for Matrix2<T> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([[a, b], [c, d]], [[e, f], [g, h]]) = (self.0, other.0);
        Self([[a + e, b + f], [c + g, d + h]])
    }
}

impl<T: ComplexField> Sub for Matrix2<T> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([[a, b], [c, d]], [[e, f], [g, h]]) = (self.0, other.0);
        Self([[a - e, b - f], [c - g, d - h]])
    }
}

impl<T: ComplexField> Mul for Matrix2<T> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let ([[a, b], [c, d]], [[e, f], [g, h]]) = (self.0, other.0);
        Self([[a * e + b * g, a * f + b * h], [c * e + d * g, c * f + d * h]])
    }
}
