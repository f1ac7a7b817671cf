//! Motion of the axle.

use super::row::{Decided, DecisionRow};
use super::values::Decisions;
use crate::scene::{Axle, Scene};

/// Unsprung mass \[kg\], spring \[N/m\] and damper \[N s/m\] of a passenger car's wheel, for a scene without these
/// whose axle is switched to motion.
pub(crate) const TYPICAL_AXLE: (f64, f64, f64) = (40.0, 2e4, 1.5e3);

pub(super) const AXLE: DecisionRow = DecisionRow {
    title: "axle motion",
    short: "axle",
    decide,
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

fn decide(scene: &Scene, _: &mut Decisions) -> Decided {
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
