//! Friction: whether tangential forces act, and by which law.

use super::row::{Decided, DecisionRow, given};
use super::values::Decisions;
use crate::scene::{Coefficient, FallingFriction, LongitudinalCreep, Scene, Switch};

pub(super) const FRICTION: DecisionRow = DecisionRow {
    title: "friction",
    short: "friction",
    decide: friction,
    // A scene without [friction] refuses to have it switched on.
    switch: Some(|scene, on| {
        scene.effects.friction = if on { Switch::On } else { Switch::Auto };
        if !on {
            (scene.friction, scene.adhesion) = (None, None);
        }
    }),
    of_cells: true,
};

fn friction(scene: &Scene, _: &mut Decisions) -> Decided {
    let reason = given(scene.effects.friction, "friction");
    let Some(friction) = &scene.friction else {
        let reason = reason.unwrap_or_else(|| "auto: the scene has no [friction]".to_owned());
        return Decided { on: false, form: String::new(), reason };
    };
    let law = match friction.coefficient() {
        Coefficient::Constant(mu) => format!("mu = {mu}"),
        Coefficient::Falling(FallingFriction { slow, fast, .. }) => format!("mu from {slow} down to {fast}"),
    };
    let rolling = match friction.creep.longitudinal {
        LongitudinalCreep::Given(_) => "",
        LongitudinalCreep::Free => ", rolls freely",
    };
    let law = format!("{law}{rolling}");
    let form = scene.adhesion.as_ref().map_or(law.clone(), |pull| format!("{law}, a pull of {} Pa", pull.stress));
    let reason = reason.unwrap_or_else(|| "the scene has [friction]".to_owned());
    Decided { on: scene.has_tractions(), form, reason }
}
