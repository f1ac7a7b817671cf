//! `tyrewave slices --calibrate`: what pressing patches of the road says about the local contact law.

use tyrewave::local_compliance::calibrate::Fit;
use tyrewave::local_compliance::{self, Calibration};
use tyrewave::plan::Plan;
use tyrewave::results::table::aligned;
use tyrewave::road::RoadSurface;
use tyrewave::run::RunError;
use tyrewave::run::prepare::{in_scene, road_limits};
use tyrewave::scene::LoadedScene;

use super::CliError;

/// Presses at most `most` patches of a scene's road; `None` for one without texture.
///
/// # Errors
/// Of the road and of the half-space's solver.
pub fn calibration(loaded: &LoadedScene, most: usize) -> Result<Option<Calibration>, CliError> {
    let scene = &loaded.scene;
    let (plan, limits) = (Plan::new(scene), road_limits(scene));
    let lattice = plan.lattice().map_err(|error| in_scene(loaded, error))?;
    let surface = RoadSurface::open(&scene.road, lattice, limits).map_err(|error| in_scene(loaded, error))?;
    let found = local_compliance::calibrate(&plan.decisions.tyre, &scene.road, &surface, limits, plan.element, most);
    found.map_err(|error| match error {
        RunError::Road(error) => in_scene(loaded, error).into(),
        other => other.into(),
    })
}

/// The calibration for people.
pub fn text(calibration: Option<&Calibration>) -> String {
    let Some(found) = calibration else { return "the road has no texture: nothing to calibrate\n".into() };
    let millimetres = |compliance: f64| format!("{:.2} mm", 1e3 * compliance * found.effective_modulus);
    let [length, width] = found.size.map(|size| 1e3 * size);
    let mut text = format!(
        "\nCompliance of the local contact law: {} patches of {length:.0} by {width:.0} mm, E* = {:.2} MPa, \
         {} elements each\n",
        found.patches,
        1e-6 * found.effective_modulus,
        found.elements
    );
    let header = ["", "kappa [m/Pa]", "kappa E*", "patch by patch", "rms difference", "of the formula"];
    let row = |name: &str, fit: &Fit, difference: &dyn Fn(f64) -> String| {
        let (low, high) =
            fit.by_patch.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &kappa| (low.min(kappa), high.max(kappa)));
        [
            name.to_owned(),
            format!("{:.3e}", fit.compliance),
            millimetres(fit.compliance),
            format!("{} to {}", millimetres(low), millimetres(high)),
            difference(fit.rms_difference),
            difference(fit.rms_difference_of_formula),
        ]
    };
    let empty = || String::new();
    let formula = ["by formula".to_owned(), format!("{:.3e}", found.formula), millimetres(found.formula)];
    let [name, kappa, length] = formula;
    let rows = [
        [name, kappa, length, empty(), empty(), empty()],
        row("by approach", &found.by_approach, &|difference| format!("{:.3} mm", 1e3 * difference)),
        row("by line pressure", &found.by_line_pressure, &|difference| format!("{:.1} %", 100.0 * difference)),
    ];
    text.push_str(&aligned(&header, &rows));
    text.push('\n');
    let header = ["pressure", "contact", "approach", "of the law", "by formula", "line pressures", "by formula"];
    let rows: Vec<[String; 7]> = found
        .levels
        .iter()
        .map(|level| {
            let length = |value: f64| format!("{:.3} mm", 1e3 * value);
            let pair = |which: usize| {
                let correlation = level.correlation[which].map_or("-".to_owned(), |value| format!("{value:.3}"));
                format!("{correlation}, {:.0} %", 100.0 * level.rms_difference[which])
            };
            [
                format!("{:.2} MPa", 1e-6 * level.pressure),
                format!("{:.0} %", 100.0 * level.contact_fraction),
                length(level.approach),
                length(level.approach_of_law[0]),
                length(level.approach_of_law[1]),
                pair(0),
                pair(1),
            ]
        })
        .collect();
    text.push_str(&aligned(&header, &rows));
    text.push_str("line pressures: correlation and rms difference, local law against three dimensions\n\n");
    // The approach is what the law must give in the mean, and patches agree best on it; the pressures hardly tell
    // compliances apart.
    text.push_str(&format!("[contact]\nlocal_compliance = {:.3e}\n\n", found.by_approach.compliance));
    text
}
