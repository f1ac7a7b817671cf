//! A tyre built in code: a belt under tension and a tread. It rolls on a smooth road, held at two heights; the
//! difference of the forces is its vertical stiffness.
//!
//! `cargo run --release --example tyre_in_code`
#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use std::error::Error;
use std::sync::atomic::AtomicBool;

use tyrewave::scene::{Axle, Foundation, Law, Layer, Material, PLATE, Road, Rolling, Sides, Tyre};
use tyrewave::{LoadedScene, Plan, Scene, Simulation};

/// A rubber whose modulus is given at 1 kHz \[Pa\].
fn rubber(modulus: f64, loss_factor: f64, poisson: f64, density: f64) -> Material {
    let (reference_frequency, corner_frequency) = (Material::REFERENCE_FREQUENCY, Material::CORNER_FREQUENCY);
    let (law, weights, times) = (Law::PowerLaw, Vec::new(), Vec::new());
    Material { law, modulus, poisson, density, loss_factor, reference_frequency, corner_frequency, weights, times }
}

/// A layer without cords: thickness \[m\], tension along and across \[N/m\].
fn layer(name: &str, thickness: f64, tension: [f64; 2], material: Material) -> Layer {
    Layer { name: name.to_owned(), thickness, tension, material, cords: Vec::new(), orthotropic: None }
}

fn main() -> Result<(), Box<dyn Error>> {
    let tyre = Tyre {
        circumference: 1.95,
        width: 0.2,
        contact_width: 0.12,
        load_index: None,
        crown_radius: None,
        sides: Sides::Supported,
        curvature: false,
        inflation: None,
        cavity: None,
        sidewall: None,
        foundation: Foundation { normal: 1.8e6, tangential: 1e6, loss_factor: 0.1, ..Foundation::default() },
        layers: vec![
            layer("belt", 0.006, [6e4, 2e4], rubber(5e8, 0.08, 0.3, 1300.0)),
            layer("tread", 0.013, [0.0; 2], rubber(8e6, 0.25, 0.49, 1150.0)),
        ],
        angular_velocity: 0.0,
    };
    // The rest is that of a shipped scene, on a smooth road and coarser.
    let mut scene = Scene::from_str(PLATE, "plate")?.scene;
    (scene.tyre, scene.road) = (tyre, Road::Smooth);
    (scene.numerics.elements, scene.numerics.pole_tolerance) = (128, 1e-3);
    let (indentations, mut forces) = ([0.010, 0.012], Vec::new());
    for indentation in indentations {
        let axle = Axle::Indentation { indentation, ramp: 0.02 };
        scene.rolling = Rolling { speed_kmh: 50.0, duration: 0.1, warm_up: 0.2, start: None, axle };
        // A scene in code is checked like a scene in a file.
        let loaded = LoadedScene::from_scene(&scene, "code")?;
        let plan = Plan::of(&loaded)?;
        plan.check(&loaded)?;
        let mut run = Simulation::begin(&loaded, &plan, &AtomicBool::new(false))?;
        while run.step()?.is_some() {}
        let force = run.finish().mean_force.ok_or("the run ended within its warm-up")?;
        println!("{:.1} mm: {force:.0} N", 1e3 * indentation);
        forces.push(force);
    }
    let stiffness = (forces[1] - forces[0]) / (indentations[1] - indentations[0]);
    println!("vertical stiffness: {:.0} N/mm", 1e-3 * stiffness);
    Ok(())
}
