//! Why there are no forces.

use super::ldlt::Singular;

/// Why there are no forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsolved {
    /// A matrix turned out singular.
    Singular,
    /// What is left does not become small: the tolerance is below what rounding allows.
    Unsettled,
}

impl From<Singular> for Unsolved {
    fn from(_: Singular) -> Self {
        Self::Singular
    }
}
