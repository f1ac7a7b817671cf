//! Content of a tyre: inflation pressure, and the air as a resonator. `[tyre.sidewall]`: the sidewalls as inflated arcs
//! between rim and belt.

use std::f64::consts::PI;

use crate::scene::Problem;
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::Bounds;
use crate::scene::table::{Keys, Nested, Table};
use serde::{Deserialize, Serialize};

use super::material::LOSS;

const LENGTH: Bounds = Bounds::positive("m").plausible(1e-3, 10.0);

keys! {
    /// The inflation.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Inflation {
        /// Pressure p above that outside \[Pa\]. On a curved tyre it follows the inner face as it turns: the full
        /// pressure beside `sidewall`, the pressure less the sidewalls' pull beside `foundation`.
        pressure: f64 => Bounds::positive("Pa").plausible(1e3, 1e7),
    }
}

keys! {
    /// The air in a tyre, compressed by the displacements that are constant across the width.
    ///
    /// Under a pressure p above that of the atmosphere its density is near 1.4 (p + 1.013e5 Pa)/c^2: 3.8 kg/m^3 at 2.2
    /// bar.
    #[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub Cavity {
        /// Mean radius R_c \[m\].
        #[serde(alias = "R_c")]
        radius: f64 => LENGTH,
        /// Depth between rim and tyre \[m\].
        depth: f64 => LENGTH,
        /// Density of the air \[kg/m^3\].
        #[serde(alias = "rho")]
        density: f64 => Bounds::positive("kg/m^3").plausible(0.01, 1e3),
        /// Speed of sound c \[m/s\]; by default that in air at 20 degrees.
        #[serde(alias = "c", default = "sound_speed")]
        sound_speed: f64 = sound_speed() => Bounds::positive("m/s").plausible(50.0, 5e3),
        /// Relaxation time tau \[s\]: its waves have the loss factor w tau; 0 without damping.
        #[serde(alias = "tau", default)]
        relaxation: f64 = 0.0 => Bounds::not_negative("s").plausible(1e-12, 1.0),
    }
}

/// Speed of sound in air at 20 degrees C \[m/s\].
fn sound_speed() -> f64 {
    343.0
}

pub(super) const INFLATION: Nested<Inflation> =
    Nested::new("the inflation", "a table, { pressure = ... }").read_by(inflation);
pub(super) const CAVITY: Nested<Cavity> =
    Nested::new("the cavity", "a table, { radius = ..., depth = ..., density = ... }").read_by(cavity);

/// Keys of the sidewalls that once stood here, and their present names.
const MOVED: [(&str, &str); 4] = [
    ("sidewall_radius", "radius"),
    ("sidewall_angle", "angle"),
    ("sidewall_mass", "mass"),
    ("sidewall_shear", "shear"),
];

fn inflation(table: &mut Table<'_>) -> Option<Inflation> {
    let mut sound = Some(());
    for (key, now) in MOVED {
        if !table.has(key) {
            continue;
        }
        sound = table.complain(key, Problem::moved(&format!("tyre.sidewall.{now}"), SIDEWALL.wanted));
        table.pass(&[key]);
    }
    let read = Inflation::read(table);
    sound.and(read)
}

fn cavity(table: &mut Table<'_>) -> Option<Cavity> {
    let read = Cavity::read(table);
    table.below("depth", "radius", &LENGTH, "the cavity's mean radius")?;
    read
}

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
