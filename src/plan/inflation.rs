//! Tension from inflation and sidewalls, beside the tension in use.

use super::settle::PlannedSetting;
use crate::scene::Tyre;

/// Tension of the layers along the belt, with that from inflation and the sidewalls' arcs; empty for a tyre without
/// these.
pub(crate) fn choices(tyre: &Tyre) -> Vec<PlannedSetting> {
    let Some(carried) = tyre.carried_tension() else { return Vec::new() };
    let used = tyre.tension_along();
    let reason = if tyre.tension_is_carried() {
        format!("pressure and sidewalls give {carried:.3e} N/m along")
    } else {
        format!("given; pressure and sidewalls would give {carried:.3e} N/m along")
    };
    vec![PlannedSetting { key: "tyre.layers.tension", value: format!("{used:.3e} N/m along all layers"), reason }]
}
