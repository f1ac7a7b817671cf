//! Why there are no forces.

use super::ldlt::Singular;

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
