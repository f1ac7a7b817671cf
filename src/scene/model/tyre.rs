//! The tyre: shape, layers, foundation and what is in it.

use serde::{Deserialize, Serialize};

use super::Material;

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

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
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
    /// Pressure p \[Pa\]. On a curved tyre it follows the inner face as it turns.
    pub pressure: f64,
    /// Mass per area that moves with the inner face, of the sidewalls \[kg/m^2\]; a curved tyre's.
    #[serde(skip_serializing_if = "is_default")]
    pub sidewall_mass: f64,
    /// The arcs of the sidewalls: what tension and foundation come from where they are not given.
    #[serde(flatten)]
    pub sidewalls: Option<Sidewalls>,
}

/// Two sidewalls as membranes: circular arcs from rim to belt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sidewalls {
    /// Radius r_s of an arc \[m\].
    #[serde(rename = "sidewall_radius")]
    pub radius: f64,
    /// Half its angle, phi, between 0 and pi.
    #[serde(rename = "sidewall_angle")]
    pub angle: f64,
    /// Shear stiffness G t of the wall \[N/m\].
    #[serde(rename = "sidewall_shear")]
    pub shear: f64,
}

/// The air in a tyre, which the fields without variation across the width compress.
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
    /// Time of relaxation that damps its waves \[s\].
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

impl Tyre {
    /// Rolling radius R = L/(2 pi) \[m\].
    pub fn radius(&self) -> f64 {
        self.circumference / std::f64::consts::TAU
    }

    /// Whether any layer is under tension along the circumference.
    pub fn is_tense_along(&self) -> bool {
        self.layers.iter().any(|layer| layer.tension[0] > 0.0)
    }
}
