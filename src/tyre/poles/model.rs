//! Poles and residues of the folded influence functions of one tyre at one resolution.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::modes::WaveModes;
use super::pole_model::PoleModel;
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

impl RationalModel {
    /// Largest wavenumber, N/2.
    pub fn largest_wavenumber(&self) -> usize {
        self.elements / 2
    }

    /// Poles and residues of the wavenumber `n` from 0 to N/2. `field` is [`Field::Bottom`] or the driven one; any
    /// other gives `None`.
    pub fn modes(&self, n: usize, field: Field) -> Option<WaveModes<'_>> {
        let face = match field {
            Field::Bottom => 1,
            field if field == self.driven => 0,
            _ => return None,
        };
        Some(WaveModes { constant: self.constants[n][face], ..self.waves.modes(n, face) })
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
