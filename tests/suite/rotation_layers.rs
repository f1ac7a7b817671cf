//! Curved layers that turn: against values of 20 digits, rotating rings, and what holds of any rotating structure.

use std::f64::consts::PI;

use num_complex::Complex64;
use serde_json::Value;
use tyrewave::scene::{DEFAULT, Foundation, Layer, Material, Scene, Tyre};
use tyrewave::test_models::reference;
use tyrewave::tyre::layers::cases;
use tyrewave::tyre::layers::compliance::Matrix3;
use tyrewave::tyre::layers::curved::{CurvedStack, FINE_STEP, STEP};
use tyrewave::tyre::layers::cylinder::Cylinder;
use tyrewave::tyre::layers::rotation::{Rotation, growth};

/// Relative accuracy that waves are prepared for, as influence functions ask for.
const TOLERANCE: f64 = 1e-7;
/// Largest |s| of the tests, 2 pi times 20 kHz.
const LARGEST_S: f64 = 1.3e5;

fn complex(value: &Value) -> Complex64 {
    let part = |part: &Value| part.as_f64().or_else(|| part.as_str()?.parse().ok()).unwrap();
    Complex64::new(part(&value[0]), part(&value[1]))
}

fn matrix(value: &Value) -> Matrix3 {
    std::array::from_fn(|i| std::array::from_fn(|j| complex(&value[i][j])))
}

fn norm(matrix: &Matrix3) -> f64 {
    matrix.iter().flatten().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

fn error(ours: &Matrix3, exact: &Matrix3) -> f64 {
    let difference: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|j| ours[i][j] - exact[i][j]));
    norm(&difference) / norm(exact)
}

fn at_frequency(frequency: f64) -> Complex64 {
    Complex64::new(0.0, 2.0 * PI * frequency)
}

fn references() -> Value {
    let text = std::fs::read_to_string(reference("rotation/rotating_orthotropic_compliance.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn compliance_of_turning_tyres_equals_the_twenty_digit_values() {
    let document = references();
    let cases = document["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 18);
    let ours = cases::evaluate(&document.to_string()).unwrap();
    let tyres = cases::curved_tyres(&document.to_string()).unwrap();
    let mut worst = [0.0_f64; 3];
    for (index, case) in cases.iter().enumerate() {
        let (c, d) = (matrix(&case["C"]), matrix(&case["D"]));
        let name = case["tyre"].as_str().unwrap();
        let (_, stack) = tyres.iter().find(|(own, _)| own == name).unwrap();
        let (n, m) = (case["n"].as_i64().unwrap(), case["m"].as_u64().unwrap() as usize);
        let s = complex(&case["s"]);
        let own = &ours["cases"][index];
        let cylinder = Cylinder::of(stack.clone(), LARGEST_S, TOLERANCE);
        let (wave, at) = (cylinder.wave(n.abs(), m), cylinder.at(s));
        let ways = [
            (matrix(&own["C"]), matrix(&own["D"])),
            stack.compliance(n, m, s, STEP),
            if n < 0 { wave.full_backwards(&at) } else { wave.full(&at) },
        ];
        let errors = ways.map(|(surface, bottom)| error(&surface, &c).max(error(&bottom, &d)));
        println!("{name}, n {n}, m {m}, s {s}: {errors:.1e?}");
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = worst.max(error);
        }
    }
    assert!(worst[0] < 1e-8 && worst[1] < 3e-5 && worst[2] < 3e-5, "{worst:.1e?}");
}

#[test]
fn growth_and_hoop_stress_are_those_of_the_reference() {
    let document = references();
    for (entry, (name, stack)) in
        document["tyres"].as_array().unwrap().iter().zip(cases::curved_tyres(&document.to_string()).unwrap())
    {
        let resolved = &entry["resolved"];
        let close = |found: f64, wanted: &Value| {
            let wanted = wanted.as_f64().unwrap();
            assert!((found - wanted).abs() <= 1e-12 * wanted.abs(), "{name}: {found} {wanted}");
        };
        close(stack.rotation.angular_velocity, &resolved["omega"]);
        close(stack.rotation.growth, &resolved["growth"]);
        let mut from = stack.inner_radius();
        for (layer, wanted) in stack.layers.iter().zip(resolved["hoop_stress"].as_array().unwrap()) {
            close(stack.rotation.prestress(layer, from)[0], wanted);
            from += layer.thickness;
        }
    }
}
