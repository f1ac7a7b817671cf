//! The tyre: layers and foundation.

use serde::Serialize;

use super::Material;

/// The unwrapped tyre: a layered plate, periodic along its circumference, simply supported at both sides.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tyre {
    /// Circumference L = 2 pi R \[m\].
    pub circumference: f64,
    /// Width B between the simply supported sides \[m\].
    pub width: f64,
    /// Width b of the contact strip, centred \[m\].
    pub contact_width: f64,
    /// The air cushion and carcass under the innermost layer.
    pub foundation: Foundation,
    /// Layers from the rim outwards; the last one is the tread.
    pub layers: Vec<Layer>,
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
