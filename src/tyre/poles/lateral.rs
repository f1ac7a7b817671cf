//! Rational models of the tyre's waves of one lateral number, n = 0..=N/2: response of both faces to forces that are
//! resolved across the strip.
//!
//! A model is like that of a strip's sum over m, without its shapes, which the user of the model applies. Unlike the
//! waves that carry the history of cells, which move to shorter rings where they are short, these have every n, all
//! aliases of the instant's lobes, and the belt. Of a tyre that turns they have odd parts as a strip's do.

use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::error::FitError;
use super::fit::FitOptions;
use super::ladder::{Ladder, RUNGS};
use super::model::RationalModel;
use super::row::{RowTarget, fit_row};
use crate::numeric::in_parallel;
use crate::scene::Tyre;
use crate::storage::cache::key;
use crate::tyre::influence::{CellGrid, CellRow, CellSums, CellTruncation, CellWave, FaceValues, Field};

/// Distance on the axis, in rungs, of the samples for the belt's scale.
const SCALE_STRIDE: usize = 8;
/// Largest alias of a wave: the lobes up to which the instant's sum between cells goes wave by wave.
const ALIASES: usize = 8;

/// Requirements on the models.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct LateralFitOptions {
    /// As for a strip, but the sums are those of single lateral numbers.
    pub fit: FitOptions,
    /// Largest alias |p|; `None`: as far as the sums between cells go.
    pub aliases: Option<usize>,
}

impl LateralFitOptions {
    /// Cache key of a lateral number's model; an error for a tyre whose numbers are not finite.
    pub(crate) fn key(&self, tyre: &Tyre, m: usize) -> serde_json::Result<[u8; 32]> {
        key::<RationalModel>(&(tyre.levelled(), self, "lateral number", m))
    }
}

/// Evaluations of the compliance for a wave with its aliases.
pub(crate) fn lateral_terms(aliases: Option<usize>) -> usize {
    2 * aliases.unwrap_or(ALIASES) + 1
}

/// Fits the models of some lateral numbers, in their order; checks `stop` before every wave.
///
/// # Errors
/// [`FitError`]: the first wave in the order of the list that is refused; [`FitError::Stopped`].
pub(crate) fn fit_lateral(
    tyre: &Tyre,
    numbers: &[usize],
    options: &LateralFitOptions,
    stop: &AtomicBool,
) -> Result<Vec<RationalModel>, FitError> {
    let FitOptions { elements, top, influence_tolerance, .. } = options.fit;
    // Waves do not depend on the cells across.
    let grid = CellGrid::new(tyre, elements, 1);
    let sums = CellSums::new(tyre, grid, CellTruncation::default(), influence_tolerance, top);
    let ladder = Ladder::new(top);
    let at = in_parallel::map(&ladder.points, |&s| sums.at(s));
    let fit = |&m: &usize| {
        let row = CellRow::whole(sums.grid(), m, options.aliases.unwrap_or(ALIASES));
        let mut faces: Vec<FaceValues> = Vec::new();
        if let Some(wave) = row.waves.first() {
            sums.values(wave, at[..=RUNGS].iter().step_by(SCALE_STRIDE), &mut faces);
        }
        let bottom = |faces: &FaceValues| faces.bottom.norm().hypot(faces.odd[1].norm());
        let bottom_scale = faces.iter().fold(0.0_f64, |largest, faces| largest.max(bottom(faces)));
        let target = RowTarget { tolerance: options.fit.tolerance, most_poles: options.fit.most_poles, bottom_scale };
        let sample = |wave: &CellWave, rungs: &[usize], faces: &mut Vec<FaceValues>| {
            sums.values(wave, rungs.iter().map(|&rung| &at[rung]), faces);
        };
        let fitted = fit_row(&ladder, row.waves.iter().enumerate(), &target, sample, stop)?;
        let entries = fitted.into_iter().map(|fitted| fitted.entry);
        Ok(RationalModel::assemble(elements, Field::Surface, top, options.fit.tolerance, entries))
    };
    in_parallel::map(numbers, fit).into_iter().collect()
}
