//! Tyres on sidewalls: their compliance at rest and turning, its limits, and their statics.

use num_complex::Complex64;
use tyrewave::internals::{CurvedStack, Cylinder, FINE_STEP, Matrix3, critical_speed_limit};
use tyrewave::scene::{DEFAULT, Foundation, Inflation, Scene, Sidewall, Tyre};

const LARGEST_S: f64 = 1.3e5;
const SPEED: f64 = 110.0 / 3.6;

/// The layers of the default tyre on the sidewalls of the reference values.
fn tyre(speed: f64) -> Tyre {
    let mut tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
    tyre.foundation = Foundation::default();
    tyre.inflation = Some(Inflation { pressure: 2.2e5 });
    tyre.sidewall = Some(Sidewall { radius: 0.055, angle: 1.0, mass: 7.0, shear: 8e3, hoop: None, loss_factor: 0.15 });
    for layer in &mut tyre.layers {
        layer.tension[0] = 0.0;
    }
    let belt = tyre.stiffest_layer();
    tyre.layers[belt].tension[0] = tyre.carried_tension().unwrap();
    tyre.angular_velocity = -speed / tyre.radius();
    tyre
}

fn at_frequency(frequency: f64) -> Complex64 {
    Complex64::new(0.0, std::f64::consts::TAU * frequency)
}

fn points() -> Vec<(i64, usize, Complex64)> {
    let mut points = Vec::new();
    for n in [0, 1, 2, 5, 11, 30, 80, 140] {
        for m in [0, 1, 2] {
            for s in [Complex64::ZERO, at_frequency(47.0), at_frequency(260.0), at_frequency(1900.0), 4e3.into()] {
                points.push((n, m, s));
            }
        }
    }
    points
}

fn size(matrix: &Matrix3) -> f64 {
    matrix.iter().flatten().map(|entry| entry.norm()).fold(0.0, f64::max)
}

fn difference(one: &Matrix3, other: &Matrix3) -> f64 {
    assert!(one.iter().chain(other).flatten().all(|entry| entry.is_finite()), "{one:?} {other:?}");
    let off = one.iter().flatten().zip(other.iter().flatten()).map(|(a, b)| (a - b).norm());
    off.fold(0.0, f64::max) / size(other)
}

#[test]
fn waves_on_sidewalls_prepared_once_equal_the_reference_path() {
    for speed in [0.0, SPEED] {
        let stack = CurvedStack::new(&tyre(speed));
        let cylinder = Cylinder::of(stack.clone(), LARGEST_S, 1e-7);
        let mut worst = 0.0_f64;
        for (n, m, s) in points() {
            let wave = cylinder.wave(n, m);
            let at = cylinder.at(s);
            worst = worst.max(difference(&wave.full(&at).0, &stack.compliance(n, m, s, FINE_STEP).0));
            worst = worst.max(difference(&wave.full_backwards(&at).0, &stack.compliance(-n, m, s, FINE_STEP).0));
        }
        println!("{speed} m/s: {worst:.1e}");
        assert!(worst < 3e-5, "{speed} m/s: {worst:.1e}");
    }
}

#[test]
fn a_tyre_on_sidewalls_is_passive_and_reversed_its_transpose() {
    for speed in [0.0, SPEED] {
        let (stack, other) = (CurvedStack::new(&tyre(speed)), CurvedStack::new(&tyre(-speed)));
        for (n, m, s) in points() {
            for n in [n, -n] {
                let compliance = stack.compliance(n, m, s, FINE_STEP).0;
                let power = (s * compliance[2][2]).re;
                assert!(power >= -1e-12 * (s * compliance[2][2]).norm(), "n {n}, m {m}, s {s}: {power:e}");
                // Between circumferential and outward motion; across, k_y changes its sign, too.
                let turned = other.compliance(-n, m, s, FINE_STEP).0;
                let places = [(0, 0), (0, 2), (2, 0), (2, 2)];
                let off = places.map(|(i, j)| (turned[j][i] - compliance[i][j]).norm());
                let off = off.into_iter().fold(0.0, f64::max) / size(&compliance);
                assert!(off < 1e-7, "n {n}, m {m}, s {s}: {off:.1e}");
            }
        }
    }
}

#[test]
fn at_rest_n_0_sidewalls_are_a_foundation_of_their_stiffness() {
    let tyre = tyre(0.0);
    let stack = CurvedStack::new(&tyre);
    let edge = stack.sidewall.as_ref().unwrap().reference(0, Complex64::ZERO);
    let [normal, tangential] = [edge.radial, edge.circumferential].map(|edge| 2.0 * edge.re / tyre.width);
    let foundation = Foundation { normal, tangential, ..Foundation::default() };
    let bed = CurvedStack { sidewall: None, foundation, ..stack.clone() };
    let [found, wanted] = [&stack, &bed].map(|stack| stack.compliance(0, 0, Complex64::ZERO, FINE_STEP).0);
    for place in [0, 2] {
        let off = (found[place][place] / wanted[place][place] - 1.0).norm();
        assert!(off < 1e-6, "{off:.1e}");
    }
    // Across they hold, too, by a separate impedance.
    let lateral = 2.0 * edge.lateral.re / tyre.width;
    let across = found[1][1].re * lateral * stack.inner_radius() / stack.radius;
    assert!(lateral > 1e5 && (across - 1.0).abs() < 0.1, "{lateral} N/m^3, {across}");
    // The air feels the edges, too: B_e/B squared.
    let share = stack.cavity.unwrap().density / tyre.cavity.unwrap().density;
    let pull = stack.sidewall.as_ref().unwrap().edge().unwrap().pull();
    assert!((share.sqrt() - (1.0 - 2.0 * pull / 2.2e5 / tyre.width)).abs() < 1e-12 && share < 0.6, "{share}");
}

#[test]
fn a_turning_tyre_grows_by_layers_and_sidewalls() {
    let tyre = tyre(SPEED);
    let stack = CurvedStack::new(&tyre);
    let [resting, turning] = [0.0, tyre.angular_velocity].map(|angular_velocity| {
        CurvedStack::new(&Tyre { angular_velocity, ..tyre.clone() }).sidewall.unwrap().edge().unwrap()
    });
    assert!(turning.pull() < 0.95 * resting.pull(), "{} N/m", turning.pull());
    let growth = stack.rotation.growth;
    assert!((1e-4..1e-3).contains(&growth), "{growth} m");
    // Without the sidewalls' part less, and with their mass as a dead load more.
    let bed = Tyre {
        sidewall: None,
        foundation: Foundation { normal: 6e6, tangential: 2e6, ..Foundation::default() },
        ..tyre.clone()
    };
    assert!(CurvedStack::new(&bed).rotation.growth < growth);
    let limit = critical_speed_limit(&tyre).unwrap();
    println!("growth {growth:e} m, stable up to {limit} m/s");
    assert!(limit > 80.0 && limit < 130.0, "{limit} m/s");
}
