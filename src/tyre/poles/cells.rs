//! Rational models of the waves that carry the history of contact cells: one fit for each pair (n, m).
//!
//! A pair is a single wave and a few aliases of little weight: its function has far fewer resonances than a sum over
//! m. Each lateral number is a row of fits, each started from its neighbour with one n less; rows go to threads as
//! they are free, and results do not depend on which thread takes which. Of a tyre that turns the odd part of a wave's
//! function is fitted with it, over the same poles.

use std::sync::atomic::AtomicBool;

use num_complex::Complex64;
use serde::Serialize;

use super::error::FitError;
use super::ladder::Ladder;
use super::model::Entry;
use super::pole_model::PoleModel;
use super::row::{RowTarget, fit_row};
use super::wavenumber::Fitted;
use crate::numeric::in_parallel;
use crate::tyre::influence::{CellRow, CellSums, CellWave, FaceValues};

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

/// Fits the waves of a list of rows, each row with n rising, in their order; checks `stop` before every wave.
///
/// # Errors
/// `FitError`: the first wave in the order of the list that is refused, with its n; `FitError::Stopped`.
pub fn fit_cells(
    sums: &CellSums,
    rows: &[CellRow],
    options: &CellFitOptions,
    stop: &AtomicBool,
) -> Result<PoleModel, FitError> {
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
    let mut model = PoleModel::new(1);
    for row in fitted {
        for Fitted { entry: Entry { poles, residues, odd, statistics, .. }, .. } in row? {
            model.push(&poles, [&residues, &odd], statistics.evaluations);
        }
    }
    Ok(model.complete())
}
