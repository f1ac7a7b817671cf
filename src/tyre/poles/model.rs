//! Poles and residues of the folded influence functions of one tyre at one resolution.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::pole_model::PoleModel;
use crate::numeric::rational::partial_fractions::evaluate;
use crate::tyre::influence::Field;

/// Cost and accuracy of the fit of one wavenumber.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct FitStatistics {
    /// Poles, conjugates counted.
    pub order: usize,
    /// Samples that the fit used.
    pub samples: usize,
    /// Samples that only checked it.
    pub fresh_samples: usize,
    /// Evaluations of the layered compliance.
    pub evaluations: u64,
    /// Relocations of the poles.
    pub relocations: usize,
    /// Largest error on fresh samples of the axis, relative to |H_n(s)|, or to 0.003 of its largest value over the band
    /// where that is more.
    pub error: f64,
    /// Largest error on the positive real axis, relative to the same scale.
    pub real_axis_error: f64,
    /// Largest error of the belt, relative to the largest |D_n| of all wavenumbers.
    pub bottom_error: f64,
    /// Smallest Re(s H_n)/|s| over axis points inside the band and far beyond, relative to the same scale: not below
    /// minus the tolerance.
    pub passivity: f64,
}

/// H_n(s) ~ constant + sum_r R_r/(s - lambda_r), n = 0..=N/2, for the driven face and, with the same poles, the
/// innermost face.
///
/// With rotation, these are the even parts E_n of H_n = E_n + i O_n, H_-n = E_n - i O_n (see
/// [`InfluenceSum`](crate::tyre::influence::InfluenceSum)); the odd parts have separate residues over the same poles.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct RationalModel {
    /// Elements N round the tyre.
    pub elements: usize,
    /// Where the force acts and the displacement is observed: [`Field::Surface`], or [`Field::UnderTread`] for a
    /// bedding.
    pub driven: Field,
    /// Top of the band that was fitted \[rad/s\].
    pub top: f64,
    /// Tolerance that was asked for, see `FitStatistics::error`.
    pub tolerance: f64,
    /// Poles, and residues of the driven and of the innermost face.
    pub(super) waves: PoleModel,
    /// H_n(infinity) of the driven and of the innermost face \[m/N\]; that of odd parts is 0.
    pub(super) constants: Vec<[f64; 2]>,
    /// Cost and accuracy of each wavenumber.
    pub(super) statistics: Vec<FitStatistics>,
}

/// Poles of one wavenumber with the residues of one face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modes<'a> {
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

impl Modes<'_> {
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
        let [own, other] = [direction, direction.opposite()].map(|direction| self.residue(direction, index).norm());
        own >= LEAST_SHARE * other
    }
}

impl RationalModel {
    /// Largest wavenumber, N/2.
    pub fn largest_wavenumber(&self) -> usize {
        self.elements / 2
    }

    /// Poles and residues of the wavenumber `n` from 0 to N/2. `field` is [`Field::Bottom`] or the driven one; any
    /// other gives `None`.
    pub fn modes(&self, n: usize, field: Field) -> Option<Modes<'_>> {
        let face = match field {
            Field::Bottom => 1,
            field if field == self.driven => 0,
            _ => return None,
        };
        Some(Modes { constant: self.constants[n][face], ..self.waves.modes(n, face) })
    }

    /// True for a tyre that turns: the model then has odd parts.
    pub fn turns(&self) -> bool {
        self.waves.turns()
    }

    /// H_n(s) of a face \[m/N\], of a tyre that turns E_n(s); `None` for a face that was not fitted.
    pub fn evaluate(&self, n: usize, s: Complex64, field: Field) -> Option<Complex64> {
        self.modes(n, field).map(|modes| modes.evaluate(s))
    }

    /// H_n(0) of a face \[m/N\], n = 0..=N/2; `None` for a face that was not fitted.
    pub fn at_rest(&self, field: Field) -> Option<Vec<f64>> {
        (0..=self.largest_wavenumber()).map(|n| Some(self.evaluate(n, Complex64::ZERO, field)?.re)).collect()
    }

    /// Number of poles of all wavenumbers, conjugates counted.
    pub fn order(&self) -> usize {
        self.waves.order()
    }

    /// Cost and accuracy of the wavenumbers, n = 0..=N/2.
    pub fn statistics(&self) -> &[FitStatistics] {
        &self.statistics
    }

    /// Evaluations of the compliance that the whole fit took.
    pub fn evaluations(&self) -> u64 {
        self.waves.evaluations()
    }

    /// From one entry for each wavenumber n = 0..=N/2, in this order.
    pub(crate) fn assemble(
        elements: usize,
        driven: Field,
        top: f64,
        tolerance: f64,
        entries: impl IntoIterator<Item = Entry>,
    ) -> Self {
        let (mut waves, mut constants, mut statistics) = (PoleModel::new(2), Vec::new(), Vec::new());
        for entry in entries {
            waves.push(&entry.poles, [&entry.residues, &entry.odd], entry.statistics.evaluations);
            constants.push(entry.constants);
            statistics.push(entry.statistics);
        }
        Self { elements, driven, top, tolerance, waves: waves.complete(), constants, statistics }
    }
}

/// Fit of one wavenumber.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Entry {
    /// lambda, in the stored order.
    pub poles: Vec<Complex64>,
    /// R of the driven and of the innermost face.
    pub residues: [Vec<Complex64>; 2],
    /// R of their odd parts; empty where these are 0: at rest, of n = 0 and of n = N/2.
    pub odd: [Vec<Complex64>; 2],
    /// Constants of both faces.
    pub constants: [f64; 2],
    /// Cost and accuracy of the fit.
    pub statistics: FitStatistics,
}
