//! A row of fits, each started from its neighbour: waves of one lateral number, n rising.

use std::sync::atomic::{AtomicBool, Ordering};

use super::error::FitError;
use super::fit::start_of;
use super::ladder::Ladder;
use super::sampled::Target;
use super::wavenumber::{Fitted, fit_wavenumber};
use crate::tyre::influence::{CellWave, FaceValues};

/// Requirements on the fits of a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowTarget {
    /// Largest relative error.
    pub tolerance: f64,
    /// Most poles of one wave, conjugates counted.
    pub most_poles: usize,
    /// Scale of the innermost face \[m/N\].
    pub bottom_scale: f64,
}

/// Fits the waves of a row, given with their n, in their order; checks `stop` before every wave. `sample` appends a
/// wave's values at rungs of the ladder.
pub(super) fn fit_row<'w>(
    ladder: &Ladder,
    row: impl IntoIterator<Item = (usize, &'w CellWave)>,
    &RowTarget { tolerance, most_poles, bottom_scale }: &RowTarget,
    sample: impl Fn(&CellWave, &[usize], &mut Vec<FaceValues>),
    stop: &AtomicBool,
) -> Result<Vec<Fitted>, FitError> {
    let mut done: Vec<Fitted> = Vec::new();
    for (wavenumber, wave) in row {
        if stop.load(Ordering::Relaxed) {
            return Err(FitError::Stopped);
        }
        let start = done.last().map(start_of).unwrap_or_default();
        // From scratch a fit may hold superfluous poles; close to its start, its start had none.
        let (removals, removal_below) = if start.poles.is_empty() { (8, 1.0) } else { (2, 0.6) };
        let target = Target {
            wavenumber,
            least_scale: 0.0,
            tolerance,
            most_poles,
            constant: false,
            bottom_scale,
            removals,
            removal_below,
        };
        let mut sample = |rungs: &[usize], faces: &mut Vec<FaceValues>| sample(wave, rungs, faces);
        done.push(fit_wavenumber(ladder, &target, &start, &mut sample)?);
    }
    Ok(done)
}
