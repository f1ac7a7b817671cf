//! Even and odd parts of influences that differ forwards and backwards.

use crate::numeric::ComplexField;

/// Even and odd part of an influence X_n of signed waves: X_n = E + i O, X_-n = E - i O. Both are real functions of s,
/// real at real s and conjugate at conjugate s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parts<T> {
    /// E.
    pub(crate) even: T,
    /// O.
    pub(crate) odd: T,
}

impl<T: ComplexField> Parts<T> {
    /// Returns those of X_n and X_-n.
    #[inline(always)]
    pub(crate) fn of([forwards, backwards]: [T; 2]) -> Self {
        Self { even: (forwards + backwards) * 0.5, odd: ((backwards - forwards) * 0.5).times_i() }
    }

    /// Returns the parts of an X_n that is even in n.
    #[inline(always)]
    pub(crate) fn even(even: T) -> Self {
        Self { even, odd: even * 0.0 }
    }
}
