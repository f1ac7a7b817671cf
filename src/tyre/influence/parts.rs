//! Even and odd parts of influences that differ forwards and backwards.

use crate::numeric::ComplexField;

/// Even and odd part of an influence X_n of signed waves: X_n = E + i O, X_-n = E - i O. Both are real functions of s,
/// real at real s and conjugate at conjugate s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parts<T> {
    pub(crate) even: T,
    pub(crate) odd: T,
}

impl<T: ComplexField> Parts<T> {
    /// From X_n and X_-n: E = (X_n + X_-n)/2, O = (X_n - X_-n)/2i.
    #[inline(always)]
    pub(crate) fn of([forwards, backwards]: [T; 2]) -> Self {
        Self { even: (forwards + backwards) * 0.5, odd: ((backwards - forwards) * 0.5).times_i() }
    }

    /// Parts of an X_n that is even in n: O = 0.
    #[inline(always)]
    pub(crate) fn even(even: T) -> Self {
        Self { even, odd: even * 0.0 }
    }
}
