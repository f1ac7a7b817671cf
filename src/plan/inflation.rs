//! Tension and foundation that the inflation gives through the sidewalls, beside those used.

use super::settle::Choice;
use crate::scene::Tyre;

/// Tension of the innermost layer and stiffness of the foundation, each with what the sidewalls' arcs give; none for a
/// tyre without them.
pub(crate) fn choices(tyre: &Tyre) -> Vec<Choice> {
    let (Some(carried), Some(innermost)) = (tyre.carried(), tyre.layers.first()) else { return Vec::new() };
    let [along, across] = innermost.tension;
    let across = if across > 0.0 { format!("{across:.3e}") } else { "0".to_owned() };
    let tension = format!("[{along:.3e}, {across}] N/m");
    let stiffness = |value: f64| format!("{value:.3e} N/m^3");
    let foundation = &tyre.foundation;
    [
        ("tyre.layers[0].tension", tension, along, carried.tension, "N/m along"),
        ("tyre.foundation.normal", stiffness(foundation.normal), foundation.normal, carried.normal, "N/m^3"),
        (
            "tyre.foundation.tangential",
            stiffness(foundation.tangential),
            foundation.tangential,
            carried.tangential,
            "N/m^3",
        ),
    ]
    .into_iter()
    .map(|(key, value, used, formula, unit)| {
        // Compared by value: a scene that was written out gives what it once left out.
        let reason = if used.to_bits() == formula.to_bits() {
            format!("pressure and sidewalls give {formula:.3e} {unit}")
        } else {
            format!("given; pressure and sidewalls would give {formula:.3e} {unit}")
        };
        Choice { key, value, reason }
    })
    .collect()
}
