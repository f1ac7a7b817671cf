//! Why there are no forces.

use super::ldlt::Singular;

/// Why there are no forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsolved {
    /// A matrix turned out singular.
    Singular,
    /// Residue that does not become small: the tolerance is below rounding.
    Unsettled,
}

impl From<Singular> for Unsolved {
    fn from(_: Singular) -> Self {
        Self::Singular
    }
}
