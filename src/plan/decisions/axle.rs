//! Motion of the axle, and rotation of the tyre.

use crate::scene::{Axle, Scene, Switch};
use crate::tyre::layers::curved::growth;

use super::values::{Decided, DecisionRow, Decisions, given};

/// Unsprung mass \[kg\], spring \[N/m\] and damper \[N s/m\] of a passenger car's wheel, for a scene without these
/// whose axle is switched to motion.
const TYPICAL_AXLE: (f64, f64, f64) = (40.0, 2e4, 1.5e3);

pub(super) const AXLE: DecisionRow = DecisionRow {
    title: "axle motion",
    short: "axle",
    decide: axle,
    switch: Some(|scene, on| {
        let axle = &mut scene.rolling.axle;
        *axle = match (&*axle, on) {
            (&Axle::Load { load, tolerance }, true) => {
                let (mass, stiffness, damping) = TYPICAL_AXLE;
                Axle::Mass { load, mass, stiffness, damping, tolerance }
            }
            (&Axle::Mass { load, tolerance, .. }, false) => Axle::Load { load, tolerance },
            (other, _) => other.clone(),
        };
    }),
    of_cells: false,
};

fn axle(scene: &Scene, _: &mut Decisions) -> Decided {
    let (on, form, reason) = match scene.rolling.axle {
        Axle::Load { load, .. } => (false, format!("height held, mean force {load} N"), "rolling.axle.load"),
        Axle::Mass { load, mass, .. } => {
            (true, format!("{mass} kg under {load} N move with the contact force"), "rolling.axle.mass")
        }
        Axle::Indentation { indentation, .. } => {
            (false, format!("height held, {} mm into the road", 1e3 * indentation), "rolling.axle.indentation")
        }
    };
    Decided { on, form, reason: reason.to_owned() }
}

pub(super) const ROTATION: DecisionRow = DecisionRow {
    title: "rotation of the tyre",
    short: "rotation",
    decide: rotation,
    switch: Some(|scene, on| scene.effects.rotation = if on { Switch::On } else { Switch::Off }),
    of_cells: true,
};

fn rotation(scene: &Scene, decisions: &mut Decisions) -> Decided {
    let given = given(scene.effects.rotation, "rotation");
    if scene.effects.rotation == Switch::Off {
        return Decided::off(given.unwrap_or_default());
    }
    if !scene.tyre.curvature {
        return Decided::off("auto: a flat plate does not turn: no growth, no Coriolis forces");
    }
    // Element numbers increase against the rotation.
    decisions.tyre.angular_velocity = -scene.rolling.speed() / scene.tyre.radius();
    decisions.growth = growth(&decisions.tyre);
    if let Axle::Indentation { indentation, .. } = &mut decisions.axle {
        *indentation += decisions.growth;
    }
    let form = format!("{:.1} rad/s, grows by {:.2} mm", -decisions.tyre.angular_velocity, 1e3 * decisions.growth);
    Decided::on(form, given.unwrap_or_else(|| "auto: the tyre is curved".to_owned()))
}
