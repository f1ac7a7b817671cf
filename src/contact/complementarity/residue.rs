//! Residual that corrections of the forces of a set leave in its equations, where G0 has a skew part; why a search has
//! ended without forces.

use super::ldlt::Singular;

/// Part of the tolerance at which corrections end.
const ENOUGH: f64 = 0.5;
/// Rounding of y - G0 F relative to the largest y: no tolerance is smaller.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// Residual of the corrections so far; nothing is corrected at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Residue {
    /// Largest value that a solution may have \[m\].
    allowed: f64,
    /// Largest value at which corrections end \[m\].
    enough: f64,
    /// The last one \[m\].
    residual: Option<f64>,
    /// r.G_s^-1 r of the residual before the last correction \[N m\].
    work: Option<f64>,
}

impl Residue {
    /// Residual before the first correction. `largest`: largest displacement that is required \[m\]; `tolerance` \[m\]
    /// is for the solution. `whole`: corrections go on to rounding.
    pub(super) fn new(largest: f64, tolerance: f64, whole: bool) -> Self {
        let allowed = tolerance.max(ROUNDING * largest);
        Self { allowed, enough: if whole { 0.0 } else { ENOUGH * allowed }, residual: None, work: None }
    }

    /// Records the residuals of the equations; returns whether they are small enough, which needs one correction at
    /// least.
    pub(super) fn is_small(&mut self, equations: impl Iterator<Item = f64>) -> bool {
        let residual = equations.fold(0.0, |largest: f64, value| largest.max(value.abs()));
        self.residual.replace(residual).is_some() && residual <= self.enough
    }

    /// Takes the work r.G_s^-1 r of the next correction; returns whether that is of no use: the work has not fallen to
    /// a quarter, and so the norm not to a half, which only rounding prevents.
    pub(super) fn stalls(&mut self, work: f64) -> bool {
        self.work.replace(work).is_some_and(|before| work.abs() > 0.25 * before.abs())
    }

    /// Continues with other corrections from the residual of the last ones.
    pub(super) fn restart(&mut self) {
        self.work = None;
    }

    /// [`Unsolved::Unsettled`] if the residual of a solution exceeds its tolerance.
    pub(super) fn settled(self) -> Result<(), Unsolved> {
        if self.residual.is_some_and(|residual| residual > self.allowed) { Err(Unsolved::Unsettled) } else { Ok(()) }
    }
}

/// Why a search has ended without forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsolved {
    /// A matrix turned out singular.
    Singular,
    /// The residual does not become small: the tolerance is below rounding.
    Unsettled,
}

impl From<Singular> for Unsolved {
    fn from(_: Singular) -> Self {
        Self::Singular
    }
}
