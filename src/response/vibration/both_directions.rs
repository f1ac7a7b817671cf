//! Waves that run in either direction round a tyre.
//!
//! With rotation, the waves of n and of -n periods differ: H_n = E_n + i O_n and H_-n = E_n - i O_n, with E and O
//! real functions of s ([`InfluenceSum`](crate::tyre::influence::InfluenceSum)). At a frequency w of either sign, with
//! E and O at |n| and i |w|,
//!
//! | | w >= 0 | w < 0 |
//! |---|---|---|
//! | n >= 0 | E + i O | conj(E - i O) |
//! | n < 0 | E - i O | conj(E + i O) |
//!
//! Waves exp(i (kx x + w t)) with n w > 0 run to smaller elements, forwards as the tyre turns (in the contact against
//! the rolling direction), and have E + i O; those with n w < 0 run backwards. The sign of w decides which is
//! conjugate. Rates of a time rule and everything else linear in H keep this: they follow from those of E and of O
//! alone. At rest there is one value for both.

use num_complex::Complex64;

/// A quantity of the waves of |n| periods; one value where both directions are alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct BothDirections<T> {
    /// Value of waves that run forwards; of all at rest.
    pub(super) forwards: T,
    /// Value of waves that run backwards; `None` at rest.
    pub(super) backwards: Option<T>,
}

impl<T> BothDirections<T> {
    pub(super) fn differ(&self) -> bool {
        self.backwards.is_some()
    }

    /// Value of a wavenumber and a bin of the material frame, of either sign.
    pub(super) fn of(&self, wavenumber: i64, material_bin: i64) -> &T {
        match &self.backwards {
            Some(backwards) if (wavenumber < 0) != (material_bin < 0) => backwards,
            _ => &self.forwards,
        }
    }

    pub(super) fn map<U>(&self, of: impl Fn(&T) -> U) -> BothDirections<U> {
        BothDirections { forwards: of(&self.forwards), backwards: self.backwards.as_ref().map(of) }
    }
}

impl BothDirections<Vec<Complex64>> {
    /// E + i O and E - i O from E and, for a tyre that turns, O.
    pub(super) fn of_parts(mut even: Vec<Complex64>, odd: Option<Vec<Complex64>>) -> Self {
        let backwards = odd.map(|mut odd| {
            for (even, odd) in even.iter_mut().zip(&mut odd) {
                let turned = Complex64::i() * *odd;
                (*even, *odd) = (*even + turned, *even - turned);
            }
            odd
        });
        Self { forwards: even, backwards }
    }
}
