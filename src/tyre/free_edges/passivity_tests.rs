//! Passivity: the power that forces on the tread put into the belt is never negative.

use faer::{Mat, Side};
use num_complex::Complex64;
use serde_json::{Value, json};

use super::Parity;
use super::belt::Resolution;
use super::reference_models::{belt, document, number};

/// Smallest eigenvalue of the Hermitian part of s C/|s|, C scaled to a diagonal of 1, of the three longest waves of a
/// parity, over a grid.
fn smallest(tyre: &Value, periods: &[i64], frequencies: &[f64]) -> f64 {
    let belt = belt(tyre, Resolution::RUN);
    let mut smallest = f64::INFINITY;
    for parity in [Parity::Even, Parity::Odd] {
        for &n in periods {
            let section = belt.section(n, parity);
            for real in [0.1, 10.0, 100.0, 1e3] {
                for &imaginary in frequencies {
                    let s = Complex64::new(real, imaginary);
                    let correction = section.at(s);
                    let waves: Vec<usize> = correction.waves().take(3).collect();
                    let entry = |i: usize, j: usize| correction.compliance(waves[i], waves[j]).unwrap();
                    let scaled = Mat::from_fn(3, 3, |i, j| {
                        entry(i, j) * s / (s.norm() * (entry(i, i).norm() * entry(j, j).norm()).sqrt())
                    });
                    let hermitian = Mat::from_fn(3, 3, |i, j| (scaled[(i, j)] + scaled[(j, i)].conj()) * 0.5);
                    let values = hermitian.self_adjoint_eigenvalues(Side::Lower).unwrap();
                    smallest = smallest.min(values[0]);
                }
            }
        }
    }
    smallest
}

fn check(name: &str, tyre: &Value, least: f64) {
    let frequencies: Vec<f64> =
        [0.0].into_iter().chain((0..13).map(|step| 100.0 * 120.0_f64.powf(f64::from(step) / 12.0))).collect();
    let found = smallest(tyre, &[-3, 0, 1, 2, 3, 5, 8, 12, 20, 30], &frequencies);
    println!("{name}: least eigenvalue {found:.4}");
    assert!(found > least, "{name}: {found}");
}

#[test]
fn the_belt_takes_in_power_at_all_n_and_s() {
    let document = document();
    let tyre = |name: &str| document["tyres"][name].clone();
    check("default", &tyre("default"), 0.01);
    check("turning", &tyre("turning_110"), 0.01);
    // Hardly any loss.
    let mut elastic = tyre("default");
    for layer in elastic["layers"].as_array_mut().unwrap() {
        layer["eta"] = json!(0.02);
        for cords in layer["cords"].as_array_mut().unwrap() {
            cords["loss_factor"] = json!(0.001);
        }
    }
    elastic["side"]["eta"] = json!(0.02);
    check("little loss", &elastic, 0.0);
    // A hard-inflated belt under a soft tread: at rest all tension is in proportion to the pressure.
    let mut soft = tyre("default");
    let factor = 4e5 / number(&soft["p"]);
    soft["p"] = json!(4e5);
    for key in ["S_theta", "S_y"] {
        soft["used"][key]
            .as_array_mut()
            .unwrap()
            .iter_mut()
            .for_each(|stress| *stress = json!(number(stress) * factor));
    }
    soft["layers"][2]["E"] = json!(1.5e6);
    check("4 bar and a soft tread", &soft, 0.01);
}
