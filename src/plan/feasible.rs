//! Refusals before a plan sums anything: sums over the tyre's waves that would not converge, or only after hours.
//!
//! The plan itself presses the tyre onto a smooth road, and no limit on the run's time protects it from a tyre whose
//! sums have too many terms.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::decisions::cells_across;
use crate::scene::sizes::{MOST, MOST_CELLS};
use crate::scene::{LoadedScene, Numerics, Scene, SceneError, Zone, short};
use crate::tyre::influence::Waves;
use crate::tyre::layers::material::shear_modulus;
use crate::tyre::layers::surface_asymptote::thickness_limit;
use crate::tyre::poles::expected_fit;

/// Tolerance of the sums with which a plan presses the tyre onto a smooth road.
pub(super) const COARSE_TOLERANCE: f64 = 1e-3;
/// Most evaluations of the compliance in the sums of a plan, some seconds on one core: twenty times those of a curved
/// car tyre.
const MOST_EVALUATIONS: f64 = 5e7;
/// Tension of the outermost layer over its shear modulus, above which no bound on short waves is known.
const LARGEST_PRESTRESS: f64 = 0.3;
/// Number of lobes of a strip's weights across that a bound on the remainder needs.
const LOBES: f64 = 20.0;
/// Most terms of the sums over both kinds of waves that a scene fixes itself, for one time step and one wavenumber.
const MOST_FIXED: f64 = 1e6;

/// Checks what was decided against the largest sizes of a scene, before anything is allocated or looped over.
///
/// # Errors
/// [`SceneError::Invalid`] with the key that is to blame.
pub(crate) fn check_sizes(loaded: &LoadedScene, scene: &Scene) -> Result<(), SceneError> {
    let Numerics { elements, substeps, .. } = scene.numerics;
    let across = if scene.contact.zone == Zone::Cells { cells_across(scene) } else { 1 };
    let has_row = scene.numerics.preset.is_some() || scene.numerics.accuracy.is_some();
    let (key, right) = match loaded.gives("contact.cell") {
        true => ("contact.cell", "larger cells"),
        false if has_row => ("numerics.fmax", "a lower frequency, or larger cells"),
        false => ("numerics.elements", "larger cells, or fewer elements"),
    };
    let sizes = [
        ("numerics.fmax", elements, MOST, "elements", "a lower frequency, or a higher speed"),
        ("numerics.fmax", substeps, MOST, "steps for each element", "a lower frequency, or a higher speed"),
        (key, across, MOST_CELLS, "cells across", right),
    ];
    match sizes.into_iter().find(|(_, size, most, ..)| *size as u64 > *most) {
        Some((key, size, most, name, right)) => {
            Err(loaded.complain(key, format!("{size} {name} are needed, at most {most} possible"), right).into())
        }
        None => Ok(()),
    }
}

/// Checks that the sums of a plan are finite and short enough; the error names the key that is to blame.
pub(crate) fn check(loaded: &LoadedScene, scene: &Scene) -> Result<(), SceneError> {
    let Scene { tyre, numerics, .. } = scene;
    let Some((tread, place)) = tyre.layers.last().zip(tyre.layers.len().checked_sub(1)) else { return Ok(()) };
    let mut right = "a thicker outermost layer, or a smaller tyre".to_owned();
    let mut key = format!("tyre.layers[{place}].thickness");
    let mut lateral = thickness_limit(tread.thickness, COARSE_TOLERANCE);
    if tread.is_tense() {
        let [along, across] = tread.tension;
        let shear = shear_modulus(&tread.material, Complex64::ZERO).norm();
        let prestress = along.max(across) / (tread.thickness * shear);
        if prestress.is_nan() || prestress > LARGEST_PRESTRESS {
            let wrong = format!(
                "a tension of {} N/m in {} m is {prestress:.1e} of the outermost layer's shear modulus at rest, {} Pa: \
                 the sums over its short waves do not converge",
                short(along.max(across)),
                short(tread.thickness),
                short(shear)
            );
            let right = format!("less tension, or a thicker or stiffer layer: at most {LARGEST_PRESTRESS}");
            return Err(loaded.complain(&format!("tyre.layers[{place}].tension"), wrong, right).into());
        }
        // Without a half-space's tail the waves across a narrow strip are summed until their weights have decayed.
        lateral = lateral.max(LOBES * PI / tyre.contact_width);
        right.push_str(", or no tension in it");
    }
    let waves = Waves::new(tyre);
    let around = thickness_limit(tread.thickness, COARSE_TOLERANCE) / waves.kx(1) + 1.0;
    let each = if tyre.curvature { expected_fit::WAVE_AT_REST } else { 1.0 };
    let mut terms = each * around * (0.5 * lateral / waves.ky(1) + 1.0);
    let mut most = MOST_EVALUATIONS;
    let Numerics { lateral_terms, wavenumber_aliases, .. } = *numerics;
    let fixed = lateral_terms.unwrap_or(1) as f64 * (2.0 * wavenumber_aliases.unwrap_or(0) as f64 + 1.0);
    if fixed > MOST_FIXED {
        (terms, most) = (fixed, MOST_FIXED);
        let name = if lateral_terms.is_some() { "lateral_terms" } else { "wavenumber_aliases" };
        (key, right) = (format!("numerics.{name}"), "fewer of them, or leave them to the tolerance".to_owned());
    }
    if terms <= most {
        return Ok(());
    }
    let wrong = format!(
        "sums over the tyre's waves would take {terms:.1e} evaluations of its compliance, and {most:.0e} are done at \
         most"
    );
    Err(loaded.complain(&key, wrong, right).into())
}
