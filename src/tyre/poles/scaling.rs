//! Cost of a fit.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use serde::Serialize;

use super::fit::{FitError, FitOptions, fit_unless_stopped};
use crate::scene::Tyre;

/// Cost of one fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct FitCost {
    /// Elements N round the tyre.
    pub elements: usize,
    /// Layers of the stack.
    pub layers: usize,
    /// Evaluations of the layered compliance.
    pub evaluations: u64,
    /// Poles of all wavenumbers, conjugates counted.
    pub order: usize,
    /// Wall time \[s\].
    pub seconds: f64,
}

/// Fits a tyre without the cache, unless `stop` is set meanwhile, and measures the cost.
pub(crate) fn cost(tyre: &Tyre, options: &FitOptions, stop: &AtomicBool) -> Result<FitCost, FitError> {
    let begin = Instant::now();
    let model = fit_unless_stopped(tyre, options, stop)?;
    Ok(FitCost {
        elements: options.elements,
        layers: tyre.layers.len(),
        evaluations: model.evaluations(),
        order: model.order(),
        seconds: begin.elapsed().as_secs_f64(),
    })
}
