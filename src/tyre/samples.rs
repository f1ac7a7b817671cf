//! A tyre to test with.

use crate::scene::{Foundation, Law, Layer, Material, Tyre};

/// A belt and a tread of the given loss factor, close to the default tyre.
pub fn tyre(loss_factor: f64) -> Tyre {
    let material = |modulus, loss_factor, poisson| Material {
        law: Law::PowerLaw,
        modulus,
        loss_factor,
        poisson,
        density: 1200.0,
        reference_frequency: 1000.0,
        corner_frequency: 1.0,
        weights: Vec::new(),
        times: Vec::new(),
    };
    let layer = |thickness, tension, material| Layer { name: String::new(), thickness, tension, material };
    Tyre {
        circumference: 1.95,
        width: 0.2,
        contact_width: 0.15,
        foundation: Foundation {
            normal: 1.8e6,
            tangential: 1e6,
            loss_factor: 0.1,
            reference_frequency: 1000.0,
            corner_frequency: 1.0,
        },
        layers: vec![
            layer(6e-3, [6e4, 2e4], material(5e8, 0.08, 0.3)),
            layer(13e-3, [0.0; 2], material(8e6, loss_factor, 0.49)),
        ],
    }
}
