//! Limits in closed form, and agreement with guided sides where these are the same.

use num_complex::Complex64;
use serde_json::Value;

use super::Parity;
use super::belt::{FreeEdges, FreeEdgesError, Resolution};
use super::edge_stiffness::{EdgeForces, LATERAL};
use super::reference_models::{bare, belt, belt_of, complex, document, layer, number, spread_strip, stack};
use crate::numeric::sinc;
use crate::scene::{Cords, DEFAULT, Layer, Scene, Tyre};
use crate::tyre::layers::curved::{CurvedStack, FINE_STEP, STEP};

const RADIUS: f64 = 0.3;
const WIDTH: f64 = 0.136;

/// A thin ring, without loss: E 100 MPa.
fn thin_ring(thickness: f64, poisson: f64, cords: &[Cords]) -> CurvedStack {
    bare(vec![layer(thickness, [1e8, poisson, 0.0, 1100.0], [0.0; 2], cords.to_vec())], [RADIUS, WIDTH])
}

/// Hoop stiffness 1/C_00 per width \[Pa\], at rest but for the rigid motions: nearly s = 0.
fn hoop_stiffness(stack: CurvedStack) -> f64 {
    let belt = belt_of(stack);
    let correction = belt.section(0, Parity::Even).at(Complex64::new(1e-3, 0.0));
    (WIDTH / correction.compliance(0, 0).unwrap()).re
}

/// A_tt h, A_yy h, A_ty h of a layer \[N/m\].
fn plane_stiffness(layer: &Layer) -> [f64; 3] {
    let (modulus, poisson) = (layer.material.modulus, layer.material.poisson);
    let plate = modulus / (1.0 - poisson * poisson);
    let mut sums = [plate, plate, poisson * plate];
    for cords in &layer.cords {
        sums.iter_mut().zip(cords.shares_in(layer.thickness)).for_each(|(sum, share)| *sum += share);
    }
    sums.map(|sum| sum * layer.thickness)
}

/// Hoop stiffness of a ring over that of uniaxial stress, A_tt - A_ty^2/A_yy at the middle radius; and, of guided
/// sides, A_tt over the same.
fn over_uniaxial(thickness: f64, poisson: f64, cords: &[Cords]) -> [f64; 2] {
    let ring = thin_ring(thickness, poisson, cords);
    let [tt, yy, ty] = plane_stiffness(&ring.layers[0]);
    let wanted = (tt - ty * ty / yy) / (RADIUS - 0.5 * thickness);
    [hoop_stiffness(ring) / wanted, tt / (tt - ty * ty / yy)]
}

#[test]
fn a_thin_free_ring_has_the_stiffness_of_uniaxial_stress() {
    for cords in [&[][..], &[Cords::new(8e9, 25.0, 0.0)]] {
        let [thick, guided] = over_uniaxial(5e-4, 0.3, cords);
        let [thin, _] = over_uniaxial(2e-4, 0.3, cords);
        // Edges of a ring of finite thickness curl: an error in proportion to it.
        let limit = (0.5 * thin - 0.2 * thick) / 0.3;
        println!("{cords:?}: 0.5 mm {thick}, 0.2 mm {thin}, limit {limit}; guided {guided}");
        assert!((limit - 1.0).abs() < 5e-5 && (thick - 1.0).abs() < 2e-3, "{thick} {thin} {limit}");
        assert!(guided > 1.09, "free and guided edges differ here: {guided}");
    }
}

#[test]
fn a_thin_ring_that_does_not_contract_is_free_as_it_is_guided() {
    let belt = belt_of(thin_ring(5e-4, 0.0, &[Cords::new(8e9, 90.0, 0.0)]));
    let correction = belt.section(0, Parity::Even).at(Complex64::new(1e-3, 0.0));
    let guided = correction.compliance(0, 0).unwrap() - correction.between(0, 0);
    let ratio = correction.between(0, 0).norm() / guided.norm();
    println!("cords across: {ratio:.1e}");
    assert!(ratio < 1e-9, "{ratio:e}");
}

#[test]
fn a_belt_on_nothing_moves_sideways_as_a_rigid_mass() {
    let document = document();
    let belt = belt(&document["tyres"]["bare"], Resolution::RUN);
    let stack = &belt.stack;
    let mut from = stack.inner_radius();
    let mass: f64 = stack
        .layers
        .iter()
        .map(|layer| {
            let middle = from + 0.5 * layer.thickness;
            from += layer.thickness;
            layer.material.density * layer.thickness * middle * stack.width
        })
        .sum();
    // At |s| = 100 the local compliance of the zone is 0.2 % of the whole.
    for (s, bound) in [(Complex64::new(0.0, 100.0), 4e-3), (Complex64::new(10.0, 0.0), 1e-4)] {
        let forces = EdgeForces::NONE;
        let compliance = belt.section(0, Parity::Odd).compliance(s, &forces).under(&forces.stiffness);
        let ratio = compliance[(LATERAL, LATERAL)] * mass * s * s;
        println!("s = {s}: Y(q_e, q_e) M s^2 = {ratio}");
        assert!((ratio - 1.0).norm() < bound, "s = {s}: {ratio}");
    }
}

#[test]
fn guided_waves_of_the_section_are_those_of_the_layers() {
    let document = document();
    for (name, n) in [("default", 0), ("default", 8), ("turning_110", 2), ("turning_110", -2), ("single", 5)] {
        let tyre = &document["tyres"][name];
        let belt = belt(tyre, Resolution::FINE);
        let guided = belt.guided();
        for s in [Complex64::new(0.0, 2500.0), Complex64::new(3000.0, 0.0)] {
            for parity in [Parity::Even, Parity::Odd] {
                let correction = belt.section(n, parity).at(s);
                let waves: Vec<usize> = correction.waves().collect();
                for m in waves.into_iter().take_while(|&m| m <= 16) {
                    let norm = if m == 0 { guided.width } else { 0.5 * guided.width };
                    let found = correction.compliance(m, m).unwrap() - correction.between(m, m);
                    let (surface, _) = guided.compliance(n, m, s, FINE_STEP);
                    let wanted = surface[2][2] * norm / guided.radius;
                    let error = (found - wanted).norm() / wanted.norm();
                    assert!(error < 1e-6, "{name}, n = {n}, m = {m}, s = {s}: {error:.1e}");
                }
            }
        }
    }
}

#[test]
fn short_waves_do_not_feel_whether_the_edges_are_free() {
    let tyre = Scene::from_str(DEFAULT, "scene").unwrap().scene.tyre;
    let (free, guided) = (FreeEdges::new(&tyre, 0.015).unwrap(), CurvedStack::new(&tyre));
    let difference = |n: i64, frequency: f64| {
        let s = Complex64::new(0.0, std::f64::consts::TAU * frequency);
        let wanted = spread_strip(&guided, n, s, tyre.contact_width);
        (free.strip(n, s, tyre.contact_width) - wanted).norm() / wanted.norm()
    };
    for frequency in [100.0, 300.0, 500.0] {
        println!("{frequency} Hz, n = 20, 40, 60: {:?}", [20, 40, 60].map(|n| difference(n, frequency)));
        assert!(difference(60, frequency) < 1e-3, "{frequency} Hz");
    }
    // They do where they are long.
    assert!(difference(0, 400.0) > 0.1);
}

#[test]
fn the_default_tyre_on_free_edges_is_that_of_the_references() {
    let tyre = Scene::from_str(DEFAULT, "scene").unwrap().scene.tyre;
    let document = document();
    for (name, angular_velocity) in [("default", 0.0), ("turning_110", number(&document["tyres"]["turning_110"]["Om"]))]
    {
        let belt = FreeEdges::new(&Tyre { angular_velocity, ..tyre.clone() }, 0.015).unwrap();
        let of_tyre = |case: &&Value| case["tyre"] == name && case.get("H_strip").is_some();
        let cases = document["cases"].as_array().unwrap().iter().filter(of_tyre);
        for (index, case) in cases.enumerate() {
            let (n, s) = (case["n"].as_i64().unwrap(), complex(&case["s"]));
            let (found, wanted) = (belt.strip(n, s, tyre.contact_width), complex(&case["H_strip"]));
            let error = (found - wanted).norm() / wanted.norm();
            println!("{name}, {index}: {error:.1e}");
            assert!(error < 2e-3, "{name}, n = {n}, s = {s}: {error:.1e}");
        }
    }
}

#[test]
fn free_edges_soften_the_default_tyre_and_its_breathing_mode() {
    let tyre = Scene::from_str(DEFAULT, "scene").unwrap().scene.tyre;
    let (free, guided) = (FreeEdges::new(&tyre, 0.015).unwrap(), CurvedStack::new(&tyre));
    // Static influence, free over guided.
    let at_rest = Complex64::ZERO;
    for (n, wanted) in [(1, 1.10), (2, 1.09), (3, 1.07), (8, 1.05), (20, 1.02)] {
        let found = free.strip(n, at_rest, tyre.contact_width) / spread_strip(&guided, n, at_rest, tyre.contact_width);
        println!("n = {n}: {}", found.re);
        assert!((found.re - wanted).abs() < 6e-3, "n = {n}: {found}");
    }
    // Mobility of the strip under a load that is uniform over the belt.
    let section = free.section(0, Parity::Even);
    let (mut loose, mut held) = (Vec::new(), Vec::new());
    for step in 0..=150 {
        let frequency = 250.0 + 2.0 * f64::from(step);
        let s = Complex64::new(0.0, std::f64::consts::TAU * frequency);
        let correction = section.at(s);
        let share = |m: usize| {
            let (argument, norm) = (0.5 * std::f64::consts::PI * m as f64, if m == 0 { 1.0 } else { 0.5 });
            argument.cos() * sinc(argument * tyre.contact_width / tyre.width) / (norm * tyre.width)
        };
        let strip: Complex64 =
            correction.waves().map(|m| correction.compliance(m, 0).unwrap_or_default() * share(m)).sum();
        loose.push(((strip * s).norm(), frequency));
        let surface = guided.compliance(0, 0, s, STEP).0[2][2];
        held.push(((surface * s / guided.radius).norm(), frequency));
    }
    let peak = |values: &[(f64, f64)]| values.iter().copied().fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
    let (loose, held) = (peak(&loose), peak(&held));
    let decibels = 20.0 * (loose.0 / held.0).log10();
    println!("peak {loose:?} for {held:?}: {decibels} dB");
    assert!((decibels + 6.7).abs() < 0.15, "{decibels} dB");
    assert!((loose.1 - 462.0).abs() <= 2.0 && (held.1 - 494.0).abs() <= 2.0, "{loose:?}, {held:?}");
}

#[test]
fn a_tyre_that_does_not_turn_is_one_at_rest() {
    let tyre = Scene::from_str(DEFAULT, "scene").unwrap().scene.tyre;
    let slow = Tyre { angular_velocity: 1e-6, ..tyre.clone() };
    let [resting, slow] = [&tyre, &slow].map(|tyre| FreeEdges::new(tyre, 0.015).unwrap());
    for n in [0, 2, -2] {
        let s = Complex64::new(0.0, 900.0);
        for parity in [Parity::Even, Parity::Odd] {
            let [one, other] = [&resting, &slow].map(|belt| belt.section(n, parity).at(s));
            let waves: Vec<usize> = one.waves().collect();
            for &m in &waves {
                let (a, b) = (one.compliance(m, m).unwrap(), other.compliance(m, m).unwrap());
                assert!((a - b).norm() < 1e-6 * a.norm(), "n = {n}, m = {m}: {a} {b}");
            }
        }
    }
}

#[test]
fn forwards_and_backwards_are_each_other_with_the_rotation_reversed() {
    let document = document();
    let tyre = &document["tyres"]["turning_110"];
    let [forwards, backwards] = [1.0, -1.0]
        .map(|direction| FreeEdges::of(stack(tyre, direction), number(&tyre["be"]), Resolution::RUN).unwrap());
    let mut differ = 0.0_f64;
    for (n, s) in [(2, Complex64::new(0.0, 630.0)), (8, Complex64::new(30.0, 1885.0)), (1, 700.0.into())] {
        for parity in [Parity::Even, Parity::Odd] {
            let one = forwards.section(n, parity).at(s);
            let other = backwards.section(-n, parity).at(s);
            let conjugate = forwards.section(-n, parity).at(s.conj());
            let against = forwards.section(-n, parity).at(s);
            let waves: Vec<usize> = one.waves().collect();
            let size = |i: usize, j: usize| {
                [i, j].map(|m| one.compliance(m, m).unwrap().norm().sqrt()).into_iter().product::<f64>()
            };
            for &i in &waves {
                for &j in &waves {
                    let found = one.compliance(i, j).unwrap();
                    // C(n; Omega) = C(-n; -Omega)^T = conj C(-n, conj s; Omega).
                    let transposed = (found - other.compliance(j, i).unwrap()).norm() / size(i, j);
                    let real = (found - conjugate.compliance(i, j).unwrap().conj()).norm() / size(i, j);
                    assert!(transposed < 1e-9 && real < 1e-9, "n = {n}, {i}, {j}: {transposed:.1e}, {real:.1e}");
                    differ = differ.max((found - against.compliance(i, j).unwrap()).norm() / size(i, j));
                }
            }
        }
    }
    assert!(differ > 1e-2, "n and -n must differ where the tyre turns: {differ:e}");
}

#[test]
fn belts_that_cannot_be_are_refused() {
    let tyre = Scene::from_str(DEFAULT, "scene").unwrap().scene.tyre;
    let flat = Tyre { curvature: false, ..tyre.clone() };
    assert_eq!(FreeEdges::new(&flat, 0.015).unwrap_err(), FreeEdgesError::Flat);
    let wide = FreeEdges::new(&tyre, 0.5 * tyre.width).unwrap_err();
    assert_eq!(wide, FreeEdgesError::Zone { zone: 0.5 * tyre.width, width: tyre.width });
    assert!(matches!(FreeEdges::new(&tyre, f64::NAN).unwrap_err(), FreeEdgesError::Zone { .. }));
    let pressure = tyre.inflation.as_ref().unwrap().pressure;
    let springs = Tyre { sidewall: None, ..tyre.clone() };
    assert_eq!(FreeEdges::new(&springs, 0.015).unwrap_err(), FreeEdgesError::NoSidewalls { pressure });
    let fast = Tyre { angular_velocity: 1e4, ..tyre };
    assert_eq!(FreeEdges::new(&fast, 0.015).unwrap_err(), FreeEdgesError::NoSteadyShape);
}

#[test]
fn the_sidewalls_pull_across_is_borne_by_the_belt() {
    let tyre = Scene::from_str(DEFAULT, "scene").unwrap().scene.tyre;
    let belt = FreeEdges::new(&tyre, 0.015).unwrap();
    let statics = belt.stack.sidewall.as_ref().unwrap().edge().unwrap();
    let mut from = belt.stack.inner_radius();
    let mut borne = 0.0;
    for (layer, plain) in belt.stack.layers.iter().zip(&tyre.layers) {
        let middle = from + 0.5 * layer.thickness;
        borne += (layer.tension[1] - plain.tension[1]) * middle;
        from += layer.thickness;
    }
    let pull = belt.stack.inner_radius() * statics.tension * statics.angle.sin();
    assert!((borne / pull - 1.0).abs() < 1e-12, "{borne} {pull}");
    let pulled = belt.stack.layers.iter().zip(&tyre.layers).map(|(layer, plain)| layer.tension[1] - plain.tension[1]);
    assert_eq!(pulled.filter(|pull| pull.abs() > 0.0).count(), 1, "the belt alone");
    // The air moves with the edges, not by a share of the width.
    assert_eq!(belt.stack.cavity, tyre.cavity);
}
