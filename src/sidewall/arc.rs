//! Dimensions and properties of a sidewall.

use super::relaxation::Relaxation;

/// One sidewall as an arc from bead to belt. At rest under pressure, over a straight axis, it would be circular; its
/// ends and its length are those of that arc, whatever shape pressure and rotation give it.
#[derive(Clone, Debug, PartialEq)]
pub struct Arc {
    /// Radius r of the arc \[m\].
    pub radius: f64,
    /// Half its angle, phi \[rad\].
    pub angle: f64,
    /// Inflation pressure p over that outside \[Pa\].
    pub pressure: f64,
    /// Mass per area \[kg/m^2\].
    pub mass: f64,
    /// Shear stiffness G t \[N/m\].
    pub shear: f64,
    /// Hoop stiffness E t, of rubber across cords \[N/m\].
    pub hoop: f64,
    /// Radius R_b of the belt's edge \[m\].
    pub edge_radius: f64,
    /// Angular velocity \[rad/s\]; positive where it moves with growing theta, the direction of the waves exp(i n
    /// theta).
    pub angular_velocity: f64,
    /// Losses, of tension, pressure and stiffness alike.
    pub relaxation: Relaxation,
}

impl Arc {
    /// Hoop over shear stiffness of rubber across inextensible cords: without a strain along them it is 4 G t.
    pub const HOOP_OVER_SHEAR: f64 = 4.0;

    /// Length from bead to belt \[m\].
    pub fn length(&self) -> f64 {
        2.0 * self.radius * self.angle
    }

    /// Radius of the bead \[m\]; a sidewall needs a positive one.
    pub fn bead_radius(&self) -> f64 {
        self.edge_radius - 2.0 * self.radius * self.angle.sin()
    }
}
