//! How far the tyre rolls in a time step.

use std::fmt::{self, Display, Formatter};

/// Rolling of a time step: the tyre rolls by an element in `substeps` steps, or by `elements_per_step` elements in
/// each. One of both is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Advance {
    /// Time steps q per element.
    pub substeps: usize,
    /// Elements s per time step.
    pub elements_per_step: usize,
}

/// So many steps per element.
impl From<usize> for Advance {
    fn from(substeps: usize) -> Self {
        Self::within(substeps)
    }
}

impl Advance {
    /// So many steps per element.
    pub const fn within(substeps: usize) -> Self {
        Self { substeps, elements_per_step: 1 }
    }

    /// So many elements per step.
    pub const fn over(elements_per_step: usize) -> Self {
        Self { substeps: 1, elements_per_step }
    }

    /// Time step for elements of a length \[m\] at a speed \[m/s\], in s.
    pub fn time_step(self, element: f64, speed: f64) -> f64 {
        element / (self.substeps as f64 * speed) * self.elements_per_step as f64
    }

    /// Time in which the tyre rolls by an element \[s\].
    pub fn time_of_element(self, time_step: f64) -> f64 {
        self.substeps as f64 * time_step / self.elements_per_step as f64
    }

    /// Number of steps in which the tyre rolls by so many elements, a multiple of s.
    pub const fn steps(self, elements: usize) -> usize {
        elements * self.substeps / self.elements_per_step
    }

    /// Number of whole elements by which the tyre rolls in so many steps.
    pub const fn elements(self, steps: i64) -> i64 {
        (steps * self.elements_per_step as i64).div_euclid(self.substeps as i64)
    }
}

/// Written as a sign with its number: q, or s.
impl Display for Advance {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.elements_per_step {
            1 => write!(f, "q = {}", self.substeps),
            elements => write!(f, "s = {elements}"),
        }
    }
}
