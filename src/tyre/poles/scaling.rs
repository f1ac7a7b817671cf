//! Cost of a fit: by the elements round the tyre, and by the layers of its stack.

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

/// The tyre with its innermost layer cut into `parts` of equal thickness, which share its tension: only the work
/// changes.
pub(crate) fn cut(tyre: &Tyre, parts: usize) -> Tyre {
    let mut layers = tyre.layers.clone();
    if let Some(first) = layers.first().cloned() {
        let mut part = first;
        part.thickness /= parts as f64;
        part.tension = part.tension.map(|tension| tension / parts as f64);
        layers.splice(0..1, vec![part; parts]);
    }
    Tyre { layers, ..tyre.clone() }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::test_models::tyre;
    use crate::tyre::layers::Stack;

    #[test]
    fn a_cut_layer_changes_nothing() {
        let whole = tyre(0.25);
        let parts = cut(&whole, 4);
        assert_eq!(parts.layers.len(), 5);
        for (k, s) in [(10.0, 600.0), (400.0, 3e4)] {
            let s = Complex64::new(10.0, s);
            let at = |tyre: &Tyre| Stack::new(tyre).at(s).normal(k, 0.3 * k);
            let (a, b) = (at(&whole), at(&parts));
            assert!((a.surface - b.surface).norm() < 1e-10 * a.surface.norm(), "{k}");
            assert!((a.bottom - b.bottom).norm() < 1e-9 * a.bottom.norm(), "{k}");
        }
    }
}
