//! The tyre: layers and foundation.

use serde::Serialize;

use super::{Law, Material};

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

    /// Mass per area of all layers m'' \[kg/m^2\].
    pub fn mass_per_area(&self) -> f64 {
        self.layers.iter().map(|layer| layer.material.density * layer.thickness).sum()
    }

    /// Tension along the circumference that the tyre's own mass adds at a speed \[m/s\]: m'' V^2 \[N/m\], the hoop
    /// tension of a thin ring.
    pub fn centrifugal_tension(&self, speed: f64) -> f64 {
        self.mass_per_area() * speed * speed
    }

    /// Tension along the circumference of all layers \[N/m\].
    pub fn tension_along(&self) -> f64 {
        self.layers.iter().map(|layer| layer.tension[0]).sum()
    }

    /// The tyre as it rolls at a speed \[m/s\]: its [centrifugal tension](Self::centrifugal_tension) is carried by the
    /// layers under tension, each in proportion to its own; where there is none, by the layer of the largest stiffness
    /// E h, which holds the others.
    #[must_use]
    pub fn spinning(&self, speed: f64) -> Self {
        let (added, carried) = (self.centrifugal_tension(speed), self.tension_along());
        let mut tyre = self.clone();
        if carried > 0.0 {
            for layer in &mut tyre.layers {
                layer.tension[0] *= 1.0 + added / carried;
            }
        } else {
            let stiffness = |layer: &Layer| layer.material.modulus * layer.thickness;
            if let Some(belt) = tyre.layers.iter_mut().max_by(|a, b| stiffness(a).total_cmp(&stiffness(b))) {
                belt.tension[0] += added;
            }
        }
        tyre
    }

    /// Layers whose law has no causal time-domain form, from 0.
    pub fn acausal_layers(&self) -> impl Iterator<Item = usize> {
        let acausal = |(number, layer): (usize, &Layer)| (layer.material.law == Law::Hysteretic).then_some(number);
        self.layers.iter().enumerate().filter_map(acausal)
    }
}
