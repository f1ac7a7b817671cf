//! Poles of a list of functions, one function after the other.

use std::ops::Range;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::numeric::rational::partial_fractions::is_pair;

/// Poles of a list of functions. A complex pole is stored once, Im lambda > 0, and stands for itself and its
/// conjugate; a real pole has Im lambda = 0. Within a function the pairs come first.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(super) struct PoleTable {
    /// Position of the first pole of each function; one more at the end.
    offsets: Vec<usize>,
    /// Position of the first real pole of each function.
    first_real: Vec<usize>,
    /// lambda \[1/s\].
    poles: Vec<Complex64>,
}

impl Default for PoleTable {
    fn default() -> Self {
        Self { offsets: vec![0], first_real: Vec::new(), poles: Vec::new() }
    }
}

impl PoleTable {
    /// Appends a function's poles, in the stored order.
    pub(super) fn push(&mut self, poles: &[Complex64]) {
        let pairs = poles.iter().filter(|&&pole| is_pair(pole)).count();
        self.first_real.push(self.poles.len() + pairs);
        self.poles.extend_from_slice(poles);
        self.offsets.push(self.poles.len());
    }

    /// Number of functions.
    pub(super) fn functions(&self) -> usize {
        self.first_real.len()
    }

    /// Positions of a function's poles, and of its residues.
    pub(super) fn range(&self, function: usize) -> Range<usize> {
        self.offsets[function]..self.offsets[function + 1]
    }

    /// A function's poles, and how many of them are pairs.
    pub(super) fn of(&self, function: usize) -> (&[Complex64], usize) {
        (&self.poles[self.range(function)], self.first_real[function] - self.offsets[function])
    }

    /// Number of poles as they are stored, pairs counted once.
    pub(super) fn stored(&self) -> usize {
        self.poles.len()
    }

    /// Number of poles of all functions, conjugates counted.
    pub(super) fn order(&self) -> usize {
        self.poles.iter().map(|&pole| if is_pair(pole) { 2 } else { 1 }).sum()
    }

    /// True if positions read from a file are consistent.
    pub(super) fn is_sound(&self) -> bool {
        let ends = self.offsets.get(1..).unwrap_or_default();
        let ranges = self.offsets.iter().zip(&self.first_real).zip(ends);
        self.offsets.first() == Some(&0)
            && self.offsets.last() == Some(&self.poles.len())
            && ends.len() == self.first_real.len()
            && ranges.into_iter().all(|((start, real), end)| start <= real && real <= end)
    }
}
