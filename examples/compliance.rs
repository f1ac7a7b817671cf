//! Compliance of a layered tyre by wavenumber: its layers as a flat plate, and as the curved tyre.
//!
//! `cargo run --release --example compliance`
#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use std::error::Error;
use std::f64::consts::TAU;

use num_complex::Complex64;
use tyrewave::Scene;
use tyrewave::scene::DEFAULT;
use tyrewave::tyre::{Stack, wave_compliance};

const FREQUENCY: f64 = 500.0;
/// Numbers of waves around the tyre.
const WAVES: [u32; 5] = [0, 3, 10, 30, 100];

fn main() -> Result<(), Box<dyn Error>> {
    let tyre = Scene::from_str(DEFAULT, "default")?.scene.tyre;
    let layers = Stack::new(&tyre).at(Complex64::new(0.0, TAU * FREQUENCY));
    // Outward displacement for outward traction, of waves that are even across.
    let curved = wave_compliance(&tyre, &WAVES, 0, &[FREQUENCY]);
    println!("at {FREQUENCY} Hz:  n   k [1/m]   |C| of the layers, of the curved tyre [m/Pa]   phase [degrees]");
    for (n, matrix) in WAVES.into_iter().zip(&curved) {
        let k = TAU * f64::from(n) / tyre.circumference;
        let flat = layers.normal(k, 0.0).surface;
        let normal = matrix[2][2];
        println!("{n:12} {k:9.1} {:14.3e} {:14.3e} {:20.1}", flat.norm(), normal.norm(), normal.arg().to_degrees());
    }
    Ok(())
}
