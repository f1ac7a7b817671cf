//! Rates of a rule, which replace s.

use num_complex::Complex64;

/// The rates mu of a rule at one zeta.
#[derive(Clone, Copy, Debug)]
pub struct Rates {
    pub(super) values: [Complex64; 3],
    pub(super) count: usize,
}

impl Rates {
    /// mu, one per stage.
    pub fn all(&self) -> &[Complex64] {
        &self.values[..self.count]
    }
}
