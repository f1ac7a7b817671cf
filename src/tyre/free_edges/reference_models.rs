//! Tyres and cases of the references, and stacks of simple belts.

use num_complex::Complex64;
use serde_json::Value;

use super::Parity;
use super::belt::{FreeEdges, Resolution};
use super::strip::strip_of;
use crate::scene::{Cavity, Cords, Foundation, Layer, Material};
use crate::sidewall::{Arc, Relaxation, Sidewall};
use crate::test_models::reference;
use crate::tyre::layers::curved::CurvedStack;
use crate::tyre::layers::rotation::Rotation;

/// The file of references.
pub(super) fn document() -> Value {
    let text = std::fs::read_to_string(reference("edges/references.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

pub(super) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

pub(super) fn complex(value: &Value) -> Complex64 {
    Complex64::new(number(&value[0]), number(&value[1]))
}

pub(super) fn layer(thickness: f64, material: [f64; 4], tension: [f64; 2], cords: Vec<Cords>) -> Layer {
    let [modulus, poisson, loss_factor, density] = material;
    let material = Material::power_law(modulus, loss_factor, poisson, density);
    Layer { name: String::new(), thickness, tension, material, cords, orthotropic: None }
}

/// Layers alone, on nothing.
pub(super) fn bare(layers: Vec<Layer>, [radius, width]: [f64; 2]) -> CurvedStack {
    let foundation = Foundation {
        normal: 0.0,
        tangential: 0.0,
        loss_factor: 0.0,
        reference_frequency: Material::REFERENCE_FREQUENCY,
        corner_frequency: Material::CORNER_FREQUENCY,
    };
    CurvedStack {
        layers,
        foundation,
        radius,
        width,
        sidewall: None,
        pressure: 0.0,
        sidewall_mass: 0.0,
        cavity: None,
        rotation: Rotation::default(),
    }
}

/// A tyre of the references, its tension as given; turning forwards, or backwards with `direction` -1.
pub(super) fn stack(tyre: &Value, direction: f64) -> CurvedStack {
    let used = &tyre["used"];
    let layers = tyre["layers"].as_array().unwrap().iter().enumerate().map(|(index, entry)| {
        let thickness = number(&entry["h"]);
        let cords = entry["cords"].as_array().unwrap().iter();
        let cords = cords.map(|cords| {
            let [stiffness, angle, loss] = ["stiffness", "angle_deg", "loss_factor"].map(|key| number(&cords[key]));
            Cords::new(stiffness, angle, loss)
        });
        let tension = ["S_theta", "S_y"].map(|key| number(&used[key][index]) * thickness);
        layer(thickness, ["E", "nu", "eta", "rho"].map(|key| number(&entry[key])), tension, cords.collect())
    });
    let stack = bare(layers.collect(), ["R", "B"].map(|key| number(&tyre[key])));
    let angular_velocity = direction * number(&tyre["Om"]);
    let rotation = Rotation::of_given_tension(angular_velocity);
    if tyre["sidewalls"] == false {
        return CurvedStack { rotation, ..stack };
    }
    let side = &tyre["side"];
    let [radius, angle, mass, shear, loss] = ["r", "phi", "m", "G", "eta"].map(|key| number(&side[key]));
    let pressure = number(&tyre["p"]);
    let arc = Arc {
        radius,
        angle,
        pressure,
        mass,
        shear,
        hoop: Arc::HOOP_OVER_SHEAR * shear,
        edge_radius: stack.inner_radius(),
        angular_velocity,
        relaxation: Relaxation::of_loss_factor(loss),
    };
    let cavity = tyre["cav"].as_object().map(|cavity| {
        let [radius, depth, density, sound_speed, relaxation] =
            ["radius", "depth", "rho", "c", "tau"].map(|key| number(&cavity[key]));
        Cavity { radius, depth, density, sound_speed, relaxation }
    });
    CurvedStack { rotation, pressure, cavity, sidewall: Some(std::sync::Arc::new(Sidewall::new(arc))), ..stack }
}

/// The belt of a tyre of the references.
pub(super) fn belt(tyre: &Value, resolution: Resolution) -> FreeEdges {
    FreeEdges::of(stack(tyre, 1.0), number(&tyre["be"]), resolution).unwrap()
}

/// As [`belt`], with edge zones of 15 mm and the resolution of runs.
pub(super) fn belt_of(stack: CurvedStack) -> FreeEdges {
    FreeEdges::of(stack, 0.015, Resolution::RUN).unwrap()
}

pub(super) fn parity(value: &Value) -> Parity {
    if value == "even" { Parity::Even } else { Parity::Odd }
}

/// Compliance of a strip of a tyre on guided sides, its sidewalls spread over the width.
pub(super) fn spread_strip(stack: &CurvedStack, n: i64, s: Complex64, strip: f64) -> Complex64 {
    strip_of(stack.clone(), n, s, strip)
}
