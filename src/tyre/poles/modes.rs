//! Poles and residues of one wavenumber, and what of them belongs to a wave of one direction.

use num_complex::Complex64;
use serde::Serialize;

use crate::numeric::rational::partial_fractions::evaluate;

/// Poles of one wavenumber with the residues of one face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveModes<'a> {
    /// lambda: `pairs` complex ones (Im > 0), then the real ones \[1/s\].
    pub poles: &'a [Complex64],
    /// R, in the order of the poles \[m/(N s)\].
    pub residues: &'a [Complex64],
    /// R of the odd part, in the order of the poles; empty at rest.
    pub odd: &'a [Complex64],
    /// Number of conjugate pairs.
    pub pairs: usize,
    /// H_n(infinity), the part that follows the force at once \[m/N\].
    pub constant: f64,
}

/// Least ratio of the residues of a wave in one direction and in the other for which it belongs to the former.
pub(crate) const LEAST_SHARE: f64 = 0.1;

/// Direction of a wave round the tyre, in the frame of its material.
///
/// Elements count against the rotation. A wave exp(i n theta' + i w t), n and w > 0 and theta' rising with the
/// elements, has crests that run to smaller elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// With the rotation, to smaller elements: H_n = E_n + i O_n on the upper imaginary axis.
    Forwards,
    /// Against the rotation, to larger elements: H_-n = E_n - i O_n there.
    Backwards,
}

impl Direction {
    /// Both directions, in the order of their poles.
    pub const BOTH: [Self; 2] = [Self::Forwards, Self::Backwards];

    pub(crate) fn opposite(self) -> Self {
        match self {
            Self::Forwards => Self::Backwards,
            Self::Backwards => Self::Forwards,
        }
    }

    /// H_n = E + i O, or H_-n = E - i O.
    pub fn of(self, even: Complex64, odd: Complex64) -> Complex64 {
        let turned = Complex64::new(-odd.im, odd.re);
        match self {
            Self::Forwards => even + turned,
            Self::Backwards => even - turned,
        }
    }
}

impl WaveModes<'_> {
    /// Weight of a pole in a sum of real parts: 2 where it stands for a pair.
    pub fn multiplicity(&self, index: usize) -> f64 {
        if index < self.pairs { 2.0 } else { 1.0 }
    }

    /// Value at s, of a tyre that turns the even part E_n(s) \[m/N\].
    pub fn evaluate(&self, s: Complex64) -> Complex64 {
        evaluate(self.poles, self.residues, self.constant, s)
    }

    /// Odd part O_n(s) \[m/N\].
    pub fn evaluate_odd(&self, s: Complex64) -> Complex64 {
        if self.odd.is_empty() { Complex64::ZERO } else { evaluate(self.poles, self.odd, 0.0, s) }
    }

    /// Value at s of the waves of one direction: H_n(s), or H_-n(s) \[m/N\].
    pub fn evaluate_wave(&self, direction: Direction, s: Complex64) -> Complex64 {
        direction.of(self.evaluate(s), self.evaluate_odd(s))
    }

    /// Residue at a stored pole of the waves of one direction: R + i Q of H_n, or R - i Q of H_-n, with the residues R
    /// of E_n and Q of O_n. A resonance of one direction has none in the other \[m/(N s)\].
    pub(crate) fn residue(&self, direction: Direction, index: usize) -> Complex64 {
        direction.of(self.residues[index], self.odd.get(index).copied().unwrap_or_default())
    }

    /// True if a stored pole is a wave of a direction: at rest of both, of a tyre that turns where its residue is at
    /// least [`LEAST_SHARE`] of that in the other direction.
    pub fn belongs_to(&self, direction: Direction, index: usize) -> bool {
        let [along, against] = [direction, direction.opposite()].map(|direction| self.residue(direction, index).norm());
        along >= LEAST_SHARE * against
    }
}
