//! The tyre: shape, layers, foundation and what is in it.

use serde::{Deserialize, Serialize};

use super::{Material, is_default};

/// The tyre: layers round its circumference, flat or curved, between two sides.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tyre {
    /// Circumference L = 2 pi R \[m\].
    pub circumference: f64,
    /// Width B between the sides \[m\].
    pub width: f64,
    /// Width b of the contact strip, centred \[m\].
    pub contact_width: f64,
    /// What the sides allow.
    #[serde(skip_serializing_if = "is_default")]
    pub sides: Sides,
    /// Whether the layers are a hollow cylinder; a flat plate otherwise.
    #[serde(skip_serializing_if = "is_default")]
    pub curvature: bool,
    /// The pressure within and the sidewalls that bear it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inflation: Option<Inflation>,
    /// The air within, as a resonator.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cavity: Option<Cavity>,
    /// The air cushion and carcass under the innermost layer.
    pub foundation: Foundation,
    /// Layers from the rim outwards; the last one is the tread.
    pub layers: Vec<Layer>,
}

/// What the sides of the tyre allow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sides {
    /// Simply supported: sines of odd number across the width.
    #[default]
    Supported,
    /// Free to rise and to slide along: cosines of even number, the constant one included.
    Guided,
}

/// The inflation pressure and, where they are given, the sidewalls that it stretches between rim and belt.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inflation {
    /// Pressure p above that outside \[Pa\]. On a curved tyre it follows the inner face as it turns; a flat one feels
    /// it through its sidewalls only.
    pub pressure: f64,
    /// Mass per area that moves with the inner face, of the sidewalls \[kg/m^2\]; a curved tyre's.
    #[serde(skip_serializing_if = "is_default")]
    pub sidewall_mass: f64,
    /// The arcs of the sidewalls: what tension and foundation come from where they are not given.
    #[serde(flatten)]
    pub sidewalls: Option<Sidewalls>,
}

/// Two sidewalls as membranes: circular arcs from rim to belt, see [`Sidewalls::carry`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sidewalls {
    /// Radius r_s of an arc \[m\].
    #[serde(rename = "sidewall_radius")]
    pub radius: f64,
    /// Half its angle, phi, between 0 and pi \[rad\].
    #[serde(rename = "sidewall_angle")]
    pub angle: f64,
    /// Shear stiffness G t of the wall \[N/m\].
    #[serde(rename = "sidewall_shear")]
    pub shear: f64,
}

/// What the inflation gives the belt through its sidewalls, see [`Sidewalls::carry`].
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
    /// What sidewalls under the pressure p give a belt of width B whose inner face has the radius R_b.
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

/// The air in a tyre, which the fields without variation across the width compress.
///
/// Under a pressure p above that of the atmosphere its density is near 1.4 (p + 1.013e5 Pa)/c^2: 3.8 kg/m^3 at 2.2 bar.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cavity {
    /// Mean radius R_c \[m\].
    pub radius: f64,
    /// Depth between rim and tyre \[m\].
    pub depth: f64,
    /// Density of the air \[kg/m^3\].
    pub density: f64,
    /// Speed of sound c \[m/s\].
    pub sound_speed: f64,
    /// Time of relaxation tau \[s\]: its waves have the loss factor w tau; 0 where nothing damps them.
    pub relaxation: f64,
}

/// Elastic foundation under the innermost layer; its loss follows the same power law as the materials.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Foundation {
    /// Normal stiffness per area at the reference frequency \[N/m^3\].
    pub normal: f64,
    /// Tangential stiffness per area at the reference frequency \[N/m^3\].
    pub tangential: f64,
    /// Loss factor eta \[1\].
    pub loss_factor: f64,
    /// Frequency at which the stiffness is as given \[Hz\].
    pub reference_frequency: f64,
    /// Frequency below which the power law levels off \[Hz\].
    pub corner_frequency: f64,
}

/// One elastic layer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Layer {
    /// What people call it: belt, tread, ...
    pub name: String,
    /// Thickness h \[m\].
    pub thickness: f64,
    /// Tension per width along x and y \[N/m\]; the prestress is T/h.
    pub tension: [f64; 2],
    /// What it is made of.
    pub material: Material,
}

impl Layer {
    /// Whether the layer is under tension in any direction.
    pub fn is_tense(&self) -> bool {
        self.tension.iter().any(|tension| tension.abs() > 0.0)
    }
}

impl Cavity {
    /// Speed of sound in air at 20 degrees \[m/s\].
    pub const SOUND_SPEED: f64 = 343.0;
}

impl Tyre {
    /// Rolling radius R = L/(2 pi) \[m\].
    pub fn radius(&self) -> f64 {
        self.circumference / std::f64::consts::TAU
    }

    /// Thickness of all layers \[m\].
    pub fn thickness(&self) -> f64 {
        self.layers.iter().map(|layer| layer.thickness).sum()
    }

    /// What inflation and sidewalls give, where the arcs of the sidewalls are known; tension and foundation of the tyre
    /// are these values where the scene left them out.
    pub fn carried(&self) -> Option<Carried> {
        let Inflation { pressure, sidewalls, .. } = self.inflation.as_ref()?;
        let inner_radius = self.radius() - self.thickness();
        sidewalls.as_ref().map(|sidewalls| sidewalls.carry(*pressure, self.width, inner_radius))
    }

    /// Whether any layer is under tension along the circumference.
    pub fn is_tense_along(&self) -> bool {
        self.layers.iter().any(|layer| layer.tension[0] > 0.0)
    }
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
