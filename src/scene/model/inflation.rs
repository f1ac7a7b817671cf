//! Content of a tyre: its inflation, the sidewalls that bear it, and the air as a resonator.

use std::f64::consts::PI;

use serde::Serialize;

use crate::scene::Problem;
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::{Bounds, Optional};
use crate::scene::problem::short;
use crate::scene::table::{Kind, Nested, Table};

const LENGTH: Bounds = Bounds::positive("m").plausible(1e-3, 10.0);
const ANGLE: Bounds = Bounds::any("rad");

keys! {
    /// The inflation pressure and, where they are given, the sidewalls that it stretches between rim and belt: what
    /// tension and foundation come from where they are not given. Both lengths of their arcs are given, or neither.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    Inflation {
        /// Pressure p above that outside \[Pa\]. On a curved tyre it follows the inner face as it turns; a flat one
        /// feels it through its sidewalls only.
        pressure: f64 => Bounds::positive("Pa").plausible(1e3, 1e7),
        /// Mass per area that moves with the inner face, of the sidewalls \[kg/m^2\]; a curved tyre's.
        #[serde(skip_serializing_if = "is_default")]
        sidewall_mass: f64 = 0.0 => Bounds::not_negative("kg/m^2").plausible(1e-3, 1e3),
        /// Radius r_s of a sidewall's arc \[m\].
        #[serde(skip_serializing_if = "Option::is_none")]
        sidewall_radius: Option<f64> = None => Optional(LENGTH),
        /// Half the angle of the arc, phi, between 0 and pi \[rad\].
        #[serde(skip_serializing_if = "Option::is_none")]
        sidewall_angle: Option<f64> = None => Optional(ANGLE),
        /// Shear stiffness G t of the wall \[N/m\].
        #[serde(skip_serializing_if = "is_default")]
        sidewall_shear: f64 = 0.0 => Bounds::not_negative("N/m").plausible(1e-3, 1e9),
    }
}

/// Two sidewalls as membranes: circular arcs from rim to belt, see [`Self::carry`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sidewalls {
    /// Radius r_s of an arc \[m\].
    pub radius: f64,
    /// Half its angle, phi, between 0 and pi \[rad\].
    pub angle: f64,
    /// Shear stiffness G t of the wall \[N/m\].
    pub shear: f64,
}

impl Inflation {
    /// The sidewalls, where their arcs are given.
    pub fn sidewalls(&self) -> Option<Sidewalls> {
        let (radius, angle) = self.sidewall_radius.zip(self.sidewall_angle)?;
        Some(Sidewalls { radius, angle, shear: self.sidewall_shear })
    }
}

/// Tension and foundation that the inflation gives the belt through its sidewalls, see [`Sidewalls::carry`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried {
    /// Tension along the belt, per width \[N/m\]; below 0 it would be compressed.
    pub tension: f64,
    /// Normal stiffness per area \[N/m^3\].
    pub normal: f64,
    /// Tangential stiffness per area \[N/m^3\].
    pub tangential: f64,
}

impl Sidewalls {
    /// Finds the tension and foundation by sidewalls under the pressure p for a belt of width B whose inner face has
    /// the radius R_b.
    ///
    /// A wall of length l = 2 phi r_s does not stretch; the pressure makes it an arc under the membrane force p r_s.
    /// Both walls pull a length of the belt inwards by 2 p r_s cos(phi) = p l cos(phi)/phi over the chord l
    /// sin(phi)/phi from rim to belt:
    ///
    /// 1. equilibrium of half the belt under pressure and pull: T = R_b (p - 2 p r_s cos(phi)/B);
    /// 2. the derivative of the pull by the chord, both by phi: kn = p (cos phi + phi sin phi)/((sin phi - phi cos phi)
    ///    B);
    /// 3. along the belt a wall is a string of length l under p r_s, and a strip in shear: kt = (p/phi + G t/(phi
    ///    r_s))/B.
    ///
    /// The radius is that of the inner face since the pressure acts there: with it the first equation is exact for a
    /// belt of any thickness.
    pub fn carry(&self, pressure: f64, width: f64, inner_radius: f64) -> Carried {
        let Self { radius, angle, shear } = *self;
        let (sine, cosine) = angle.sin_cos();
        Carried {
            tension: inner_radius * pressure * (1.0 - 2.0 * radius * cosine / width),
            normal: pressure * (cosine + angle * sine) / ((sine - angle * cosine) * width),
            tangential: (pressure + shear / radius) / (angle * width),
        }
    }
}

keys! {
    /// The air in a tyre, which the fields without variation across the width compress.
    ///
    /// Under a pressure p above that of the atmosphere its density is near 1.4 (p + 1.013e5 Pa)/c^2: 3.8 kg/m^3 at 2.2
    /// bar.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize)]
    Cavity {
        /// Mean radius R_c \[m\].
        radius: f64 => LENGTH,
        /// Depth between rim and tyre \[m\].
        depth: f64 => LENGTH,
        /// Density of the air \[kg/m^3\].
        density: f64 => Bounds::positive("kg/m^3").plausible(0.01, 1e3),
        /// Speed of sound c \[m/s\]; by default that in air at 20 degrees.
        sound_speed: f64 = 343.0 => Bounds::positive("m/s").plausible(50.0, 5e3),
        /// Time of relaxation tau \[s\]: its waves have the loss factor w tau; 0 where nothing damps them.
        relaxation: f64 = 0.0 => Bounds::not_negative("s").plausible(1e-12, 1.0),
    }
}

pub(super) const INFLATION: Nested<Inflation> = Nested {
    title: "the inflation",
    wanted: "a table, { pressure = ..., sidewall_radius = ..., sidewall_angle = ... }",
    schema: Inflation::schema,
    read: inflation,
};
pub(super) const CAVITY: Nested<Cavity> = Nested {
    title: "the cavity",
    wanted: "a table, { radius = ..., depth = ..., density = ... }",
    schema: Cavity::schema,
    read: cavity,
};

fn inflation(table: &mut Table<'_>) -> Option<Inflation> {
    let read = Inflation::read(table);
    let mut sound = Some(());
    if ["sidewall_radius", "sidewall_angle", "sidewall_shear"].iter().any(|key| table.has(key)) {
        for (key, kind) in [("sidewall_radius", LENGTH), ("sidewall_angle", ANGLE)] {
            if !table.has(key) {
                sound = table.complain(key, Problem::missing(&kind.wanted()));
            }
        }
    }
    match table.peek("sidewall_angle", &ANGLE) {
        Some(Some(angle)) if !(angle > 0.0 && angle < PI) => {
            let wrong = format!("{} rad is not half the angle of an arc from rim to belt", short(angle));
            table.complain("sidewall_angle", Problem::new(wrong, "write a number above 0 and below pi rad"))
        }
        _ => sound.and(read),
    }
}

fn cavity(table: &mut Table<'_>) -> Option<Cavity> {
    let read = Cavity::read(table);
    table.below("depth", "radius", &LENGTH, "the cavity's mean radius")?;
    read
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALLS: Sidewalls = Sidewalls { radius: 0.05, angle: 1.1, shear: 8e3 };
    const PRESSURE: f64 = 2.2e5;
    const WIDTH: f64 = 0.136;

    #[test]
    fn a_car_tyres_sidewalls_give_the_tension_and_stiffness_of_a_car_tyre() {
        let inner_radius = 1.95 / std::f64::consts::TAU - 0.019;
        let Carried { tension, normal, tangential } = WALLS.carry(PRESSURE, WIDTH, inner_radius);
        for (found, expected) in [(tension, 4.3e4), (normal, 5.9e6), (tangential, 2.5e6)] {
            assert!((found / expected - 1.0).abs() < 0.02, "{found} is not {expected} to its two digits");
        }
    }

    #[test]
    fn the_normal_stiffness_is_the_change_of_pull_with_the_chord_of_an_arc_that_keeps_its_length() {
        for angle in [0.05, 0.6, 1.1, 1.6, 2.4, 3.0] {
            let walls = Sidewalls { angle, ..WALLS };
            let length = 2.0 * angle * walls.radius;
            // Both walls; a step of the angle that loses as many digits to rounding as to the parabola's neglect.
            let pull = |angle: f64| PRESSURE * length * angle.cos() / angle;
            let chord = |angle: f64| length * angle.sin() / angle;
            let (less, more) = (angle * (1.0 - 1e-4), angle * (1.0 + 1e-4));
            let expected = (pull(more) - pull(less)) / (chord(more) - chord(less)) / WIDTH;
            let found = walls.carry(PRESSURE, WIDTH, 0.3).normal;
            assert!((found / expected - 1.0).abs() < 1e-5, "{found} is not {expected} at {angle}");
        }
    }

    #[test]
    fn walls_that_leave_the_belt_sideways_do_not_pull_it_inwards() {
        let sideways = Sidewalls { angle: std::f64::consts::FRAC_PI_2, ..WALLS };
        let hoop = PRESSURE * 0.3;
        assert!((sideways.carry(PRESSURE, WIDTH, 0.3).tension / hoop - 1.0).abs() < 1e-12);
        assert!(WALLS.carry(PRESSURE, 0.1, 0.3).tension > 0.0);
        assert!(WALLS.carry(PRESSURE, 0.04, 0.3).tension < 0.0, "the pull exceeds the pressure");
    }
}
