//! Requirements of the model that is fitted to a scene's tyre.

use crate::scene::{Numerics, Scene};
use crate::tyre::influence::Field;
use crate::tyre::poles::FitOptions;

/// Options of the model of a scene's tyre under forces on a field.
pub fn fit_options(scene: &Scene, field: Field) -> FitOptions {
    let Numerics { elements, substeps, pole_tolerance, influence_tolerance, .. } = scene.numerics;
    FitOptions {
        driven: field,
        tolerance: pole_tolerance,
        // The sums must be more accurate than the fit to them.
        influence_tolerance: influence_tolerance.min(0.01 * pole_tolerance),
        ..FitOptions::new(&scene.tyre, elements, scene.rolling.speed() * substeps as f64)
    }
}
