//! Tension that the inflation gives beside the sidewalls' pull, beside that used.

use super::settle::Choice;
use crate::scene::Tyre;

/// Tension of the layers along the belt with what inflation and the sidewalls' arcs give; none for a tyre without them.
pub(crate) fn choices(tyre: &Tyre) -> Vec<Choice> {
    let Some(carried) = tyre.carried_tension() else { return Vec::new() };
    let used: f64 = tyre.layers.iter().map(|layer| layer.tension[0]).sum();
    // Compared by value: a scene that was written out gives what it once left out.
    let reason = if used.to_bits() == carried.to_bits() {
        format!("pressure and sidewalls give {carried:.3e} N/m along")
    } else {
        format!("given; pressure and sidewalls would give {carried:.3e} N/m along")
    };
    vec![Choice { key: "tyre.layers.tension", value: format!("{used:.3e} N/m along all layers"), reason }]
}
