//! Residue that corrections of the forces of a set leave of its equations, where G0 has a skew part.

use super::unsolved::Unsolved;

/// Part of the tolerance at which corrections end.
const ENOUGH: f64 = 0.5;
/// Rounding of y - G0 F relative to the largest y: no tolerance is smaller.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// Residue of the corrections so far; nothing is corrected at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Residue {
    /// Largest value that a solution may have \[m\].
    allowed: f64,
    /// Largest value at which corrections end \[m\].
    enough: f64,
    /// The last one \[m\].
    left: Option<f64>,
    /// r.G_s^-1 r of what was left before the last correction \[N m\].
    work: Option<f64>,
}

impl Residue {
    /// Makes a residue before the first correction. `largest`: largest displacement that is required; `tolerance` \[m\]
    /// is for the solution. `whole`: corrections go on to rounding.
    pub(super) fn new(largest: f64, tolerance: f64, whole: bool) -> Self {
        let allowed = tolerance.max(ROUNDING * largest);
        Self { allowed, enough: if whole { 0.0 } else { ENOUGH * allowed }, left: None, work: None }
    }

    /// Takes note of what the equations leave and tells whether that is little enough, after the first correction.
    pub(super) fn is_small(&mut self, equations: impl Iterator<Item = f64>) -> bool {
        let left = equations.fold(0.0, |largest: f64, value| largest.max(value.abs()));
        self.left.replace(left).is_some() && left <= self.enough
    }

    /// Takes the work of the next correction on what is left, r.G_s^-1 r, and tells whether it is of no use: it has not
    /// fallen to a quarter, and each correction leaves less where there is more than rounding.
    pub(super) fn stalls(&mut self, work: f64) -> bool {
        self.work.replace(work).is_some_and(|before| work.abs() > 0.25 * before.abs())
    }

    /// Begins with other corrections of what the last have left.
    pub(super) fn go_on(&mut self) {
        self.work = None;
    }

    /// Returns # Errors
    /// [`Unsolved::Unsettled`] if a solution leaves more than its tolerance.
    pub(super) fn settled(self) -> Result<(), Unsolved> {
        if self.left.is_some_and(|left| left > self.allowed) { Err(Unsolved::Unsettled) } else { Ok(()) }
    }
}
