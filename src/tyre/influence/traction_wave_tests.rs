//! Interpolated answers of waves compared with the kernel's, between the known frequencies.

use std::f64::consts::TAU;

use super::*;
use crate::scene::{DEFAULT, PLATE, Scene, Tyre};
use crate::tyre::influence::FaceValues;

#[test]
fn interpolated_answers_are_those_of_the_kernel() {
    let tyre = |text: &str| Scene::from_str(text, "scene").unwrap().scene.tyre;
    let turning = Tyre { angular_velocity: -100.0, ..tyre(DEFAULT) };
    for (name, tyre) in [("plate", tyre(PLATE)), ("curved", tyre(DEFAULT)), ("turning", turning)] {
        let numbers = [1, 2, 3];
        let (elements, time_step) = (32, 2e-4);
        let symbol = |frequency: f64| {
            let turn = Complex64::from_polar(1.0, -TAU * frequency * time_step);
            (1.5 - 2.0 * turn + 0.5 * turn * turn) / time_step
        };
        let lines = TractionLines::new(&tyre, elements, numbers, (2500.0, 1e-8), symbol);
        let waves = TractionWaves::new(&tyre, elements / 2, &numbers, [2500.0, 1e-8]);
        let mut largest = [0.0_f64; 3];
        let mut worst = [0.0_f64; 3];
        for (index, n) in [(0, 0), (0, 3), (1, 7), (2, 15), (1, 16)] {
            let line = lines.wave(index, n);
            let row = CellRow::whole(lines.sums.grid(), numbers[index], ALIASES);
            for frequency in [0.0, 33.3, 71.7, 152.0, 477.0, 1234.0, 2480.0] {
                let at = lines.sums.at(symbol(frequency));
                let parts = lines.sums.traction_parts(&row.waves[n], &at);
                let mut faces: Vec<FaceValues> = Vec::new();
                // Aliases do not reach the inner face.
                let mut main = row.waves[n].clone();
                main.terms.retain(|term| term.0.unsigned_abs() as usize == n);
                lines.sums.values(&main, [&at], &mut faces);
                for (answer, sign) in line.at(frequency).iter().zip([1.0, -1.0]) {
                    let turned = Complex64::new(0.0, sign);
                    for pair in 0..PAIRS {
                        let exact = parts.even[pair] + turned * parts.odd[pair];
                        largest[0] = largest[0].max(exact.norm());
                        worst[0] = worst[0].max((answer.surface[pair / 3][pair % 3] - exact).norm());
                    }
                    // Under normal forces the inner face is known from elsewhere.
                    let exact = faces[0].bottom + turned * faces[0].odd[1];
                    largest[1] = largest[1].max(exact.norm());
                    worst[1] = worst[1].max((answer.bottom[2] - exact).norm());
                }
                let exact_at = lines.sums.at(Complex64::new(0.0, TAU * frequency)).0;
                for (signed, frequency) in [(n as i64, frequency), (-(n as i64), frequency), (n as i64, -frequency)] {
                    let seen = if frequency < 0.0 {
                        lines.sums.at(Complex64::new(0.0, TAU * frequency)).0
                    } else {
                        exact_at.clone()
                    };
                    let exact = in_shapes(&seen.full(signed, numbers[index]), lines.sums.grid().waves().sides);
                    let found = waves.at(signed, frequency, index);
                    for (found, exact) in found.iter().zip(&exact[6..8]) {
                        largest[2] = largest[2].max(exact.norm());
                        worst[2] = worst[2].max((found - exact).norm());
                    }
                }
            }
        }
        println!("{name}: {worst:?} of {largest:?}");
        for (worst, largest) in worst.into_iter().zip(largest) {
            assert!(worst < 1e-3 * largest, "{name}: {worst:e} of {largest:e}");
        }
    }
}
