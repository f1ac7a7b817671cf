//! `[tyre.sidewall]`: the sidewalls as inflated arcs between rim and belt.

use std::f64::consts::PI;

use serde::Serialize;

use super::material::LOSS;
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::Bounds;
use crate::scene::table::Nested;

/// A stiffness in kN/m lies below.
const STIFFNESS: Bounds = Bounds::positive("N/m").plausible(100.0, 1e9);

keys! {
    /// Both sidewalls of a curved tyre, in place of a foundation: arcs of inextensible cords under the inflation
    /// pressure.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Sidewall {
        /// Radius r of the arc \[m\].
        radius: f64 => Bounds::positive("m").plausible(1e-3, 10.0),
        /// Half the angle of the arc from rim to belt, phi \[rad\].
        angle: f64 => Bounds::inside(0.0, PI, "rad"),
        /// Mass per area \[kg/m^2\].
        mass: f64 => Bounds::positive("kg/m^2").plausible(1e-2, 1e3),
        /// Shear stiffness G t of the wall \[N/m\].
        shear: f64 => STIFFNESS,
        /// Hoop stiffness of the wall \[N/m\]; 4 G t, that of rubber across cords, where it is left out.
        hoop?: f64 => STIFFNESS,
        /// Loss factor eta, of pressure, tension and stiffness alike \[1\].
        #[serde(skip_serializing_if = "is_default")]
        loss_factor: f64 = 0.0 => LOSS,
    }
}

pub(super) const SIDEWALL: Nested<Sidewall> =
    Nested::new("the sidewalls", "a table, { radius = ..., angle = ..., mass = ..., shear = ... }");
