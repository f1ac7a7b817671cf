//! Rotation of the tyre.

use super::row::{Decided, DecisionRow, given};
use super::values::Decisions;
use crate::scene::{Axle, Scene, Switch};
use crate::tyre::layers::curved::growth;

pub(super) const ROTATION: DecisionRow = DecisionRow {
    title: "rotation of the tyre",
    short: "rotation",
    decide,
    switch: Some(|scene, on| scene.effects.rotation = if on { Switch::On } else { Switch::Off }),
    of_cells: true,
};

fn decide(scene: &Scene, decisions: &mut Decisions) -> Decided {
    let off = |reason: String| Decided { on: false, form: String::new(), reason };
    let given = given(scene.effects.rotation, "rotation");
    if scene.effects.rotation == Switch::Off {
        return off(given.unwrap_or_default());
    }
    if !scene.tyre.curvature {
        return off("auto: a flat plate does not turn: no growth, no Coriolis forces".to_owned());
    }
    // Element numbers increase against the rotation.
    decisions.tyre.angular_velocity = -scene.rolling.speed() / scene.tyre.radius();
    decisions.growth = growth(&decisions.tyre);
    if let Axle::Indentation { indentation, .. } = &mut decisions.axle {
        *indentation += decisions.growth;
    }
    let form = format!("{:.1} rad/s, grows by {:.2} mm", -decisions.tyre.angular_velocity, 1e3 * decisions.growth);
    let reason = given.unwrap_or_else(|| "auto: the tyre is curved".to_owned());
    Decided { on: true, form, reason }
}
