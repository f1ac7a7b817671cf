//! Tension that the inflation gives beside the sidewalls' pull, beside that used.

use super::settle::Choice;
use crate::scene::Tyre;

/// Returns the tension of the layers along the belt with what inflation and the sidewalls' arcs give; none for a tyre
/// without them.
pub(crate) fn choices(tyre: &Tyre) -> Vec<Choice> {
    let Some(carried) = tyre.carried_tension() else { return Vec::new() };
    let used = tyre.tension_along();
    let reason = if tyre.tension_is_carried() {
        format!("pressure and sidewalls give {carried:.3e} N/m along")
    } else {
        format!("given; pressure and sidewalls would give {carried:.3e} N/m along")
    };
    vec![Choice { key: "tyre.layers.tension", value: format!("{used:.3e} N/m along all layers"), reason }]
}
