//! Rational models of the waves that carry the past of contact cells: one fit for each pair (n, m).
//!
//! A pair is a single wave and a few aliases of little weight: its function has far fewer resonances than a sum over
//! m. Each lateral number is a row of fits, each started from its neighbour with one n less; rows go to threads as
//! they are free, and results do not depend on which thread takes which. Of a tyre that turns the odd part of a wave's
//! function is fitted with it, over the same poles.

use std::sync::atomic::AtomicBool;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::error::FitError;
use super::ladder::Ladder;
use super::model::Modes;
use super::row::{RowTarget, fit_row};
use super::table::PoleTable;
use super::wavenumber::Fitted;
use crate::numeric::in_parallel;
use crate::storage::{Cached, Format, Kind};
use crate::tyre::influence::{CellRow, CellSums, CellWave, FaceValues, WaveValues};

/// Requirements on the fits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CellFitOptions {
    /// Top of the band \[rad/s\].
    pub top: f64,
    /// Largest error relative to |H(s)|, or to 0.003 of its largest value over the band where that is more.
    pub tolerance: f64,
    /// Most poles of one wave, conjugates counted.
    pub most_poles: usize,
}

/// Rational models of a list of waves.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct CellModel {
    /// lambda \[1/s\].
    poles: PoleTable,
    /// R \[m/(N s)\].
    residues: Vec<Complex64>,
    /// R of the odd parts \[m/(N s)\]; empty at rest.
    odd: Vec<Complex64>,
    evaluations: u64,
}

impl CellModel {
    /// Number of waves.
    pub fn len(&self) -> usize {
        self.poles.functions()
    }

    /// True without any wave.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of poles of all waves, conjugates counted.
    pub fn order(&self) -> usize {
        self.poles.order()
    }

    /// Evaluations of the compliance that the fits took.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// True for a tyre that turns: some of its waves then have odd parts.
    pub fn turns(&self) -> bool {
        !self.odd.is_empty()
    }

    /// Values of all waves at a real s \[1/s\], in their order.
    pub fn values(&self, s: f64) -> WaveValues {
        let all = |of: fn(Modes<'_>, Complex64) -> Complex64| -> Vec<f64> {
            (0..self.len()).map(|wave| of(self.modes(wave), s.into()).re).collect()
        };
        let odd = || all(|modes, s| modes.evaluate_odd(s));
        WaveValues { even: all(|modes, s| modes.evaluate(s)), odd: if self.turns() { odd() } else { Vec::new() } }
    }

    /// Poles and residues of a wave.
    pub(crate) fn modes(&self, wave: usize) -> Modes<'_> {
        let (poles, pairs) = self.poles.of(wave);
        let range = self.poles.range(wave);
        // Waves that rotation does not affect have none.
        let odd = self.odd.get(range.clone()).filter(|odd| odd.iter().any(|residue| residue.norm() > 0.0));
        Modes { poles, residues: &self.residues[range], odd: odd.unwrap_or(&[]), pairs, constant: 0.0 }
    }
}

impl Cached for CellModel {
    const KIND: Kind = Kind {
        extension: "cells",
        format: Format { magic: b"TWAVECEL", version: 3, name: "a model of contact cells" },
    };

    fn is_sound(&self) -> bool {
        let stored = self.poles.stored();
        self.poles.is_sound() && self.residues.len() == stored && [0, stored].contains(&self.odd.len())
    }
}

/// Fits the waves of a list of rows, each row with n rising, in their order; looks at `stop` before every wave.
///
/// # Errors
/// `FitError`: the first wave in the order of the list that is refused, with its n; `FitError::Stopped`.
pub fn fit_cells(
    sums: &CellSums,
    rows: &[CellRow],
    options: &CellFitOptions,
    stop: &AtomicBool,
) -> Result<CellModel, FitError> {
    let ladder = Ladder::new(options.top);
    let at = in_parallel::map(&ladder.points, |&s| sums.at(s));
    let sample = |wave: &CellWave, rungs: &[usize], faces: &mut Vec<FaceValues>| {
        let first = faces.len();
        sums.values(wave, rungs.iter().map(|&rung| &at[rung]), faces);
        for faces in &mut faces[first..] {
            (faces.bottom, faces.odd[1]) = (Complex64::ZERO, Complex64::ZERO);
        }
    };
    // The belt is not sampled: any scale will do.
    let target = RowTarget { tolerance: options.tolerance, most_poles: options.most_poles, bottom_scale: 1.0 };
    let number = |wave: &CellWave| wave.terms.first().map_or(0, |(n, ..)| n.unsigned_abs() as usize);
    let fit =
        |row: &CellRow| fit_row(&ladder, row.waves.iter().map(|wave| (number(wave), wave)), &target, sample, stop);
    let fitted: Vec<Result<Vec<Fitted>, FitError>> = in_parallel::map(rows, fit);
    let mut model = CellModel::default();
    for row in fitted {
        for Fitted { entry, .. } in row? {
            model.poles.push(&entry.poles);
            model.residues.extend_from_slice(&entry.residues[0]);
            if !entry.odd[0].is_empty() {
                // Zeros for waves before it that rotation does not affect.
                model.odd.resize(model.poles.stored() - entry.poles.len(), Complex64::ZERO);
                model.odd.extend_from_slice(&entry.odd[0]);
            }
            model.evaluations += entry.statistics.evaluations;
        }
    }
    if model.turns() {
        model.odd.resize(model.poles.stored(), Complex64::ZERO);
    }
    Ok(model)
}
