//! The edge impedance of a sidewall against values found otherwise, closed forms and limits, and in a tyre.

use std::f64::consts::TAU;
use std::sync::Arc as Shared;

use faer::Mat;
use faer::linalg::solvers::Solve;
use num_complex::Complex64;
use serde_json::{Value, json};
use tyrewave::internals::{Arc, EdgeImpedance, Relaxation, Sidewall, cases, reference};

/// Radius of an edge whose circumference hardly changes along the arc \[m\].
const FLAT: f64 = 1e6;

/// The sidewall of the reference values, without losses.
fn arc() -> Arc {
    Arc {
        radius: 0.055,
        angle: 1.0,
        pressure: 2.2e5,
        mass: 7.0,
        shear: 8e3,
        hoop: 3.2e4,
        edge_radius: 0.297,
        angular_velocity: 0.0,
        relaxation: Relaxation::default(),
    }
}

fn lossy() -> Arc {
    let terms = [(0.33, 40.0), (0.45, 670.0)].map(|(strength, frequency)| [strength, 1.0 / (TAU * frequency)]);
    Arc { relaxation: Relaxation { terms: terms.to_vec() }, ..arc() }
}

fn at_frequency(frequency: f64) -> Complex64 {
    Complex64::new(0.0, TAU * frequency)
}

fn size(edge: &EdgeImpedance) -> f64 {
    edge.radial.norm().max(edge.coupling.norm()).max(edge.circumferential.norm())
}

/// Largest difference of entries over the largest entry.
fn difference(found: &EdgeImpedance, wanted: &EdgeImpedance) -> f64 {
    let EdgeImpedance { radial, coupling, circumferential, .. } = *found;
    let off = [radial - wanted.radial, coupling - wanted.coupling, circumferential - wanted.circumferential];
    off.iter().map(|off| off.norm()).fold(0.0, f64::max) / size(wanted)
}

fn complex(value: &Value) -> Complex64 {
    Complex64::new(value[0].as_f64().unwrap(), value[1].as_f64().unwrap())
}

fn published(case: &Value) -> EdgeImpedance {
    let [radial, coupling, circumferential] = ["Kww", "KwV", "KVV"].map(|name| complex(&case[name]));
    EdgeImpedance { radial, coupling, circumferential, lateral: Complex64::ZERO }
}

/// All reference values of the toroid: arc, n, s and K.
fn references() -> Vec<(Arc, i64, Complex64, EdgeImpedance)> {
    let text = std::fs::read_to_string(reference("sidewall/arc_impedance.json")).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    let mut all = Vec::new();
    for case in document["cases"].as_array().unwrap() {
        let (n, s) = (case["n"].as_i64().unwrap(), complex(&case["s"]));
        all.push((Arc { hoop: 0.0, ..lossy() }, n, s, published(&case["toroid"])));
        all.push((lossy(), n, s, published(&case["toroid_hoop"])));
    }
    let rotating = &document["rotating"];
    for case in rotating["cases"].as_array().unwrap() {
        let speed = format!("{:.0}", case["speed_kmh"].as_f64().unwrap());
        let angular_velocity = rotating["meridian"][&speed]["omega"].as_f64().unwrap();
        let (n, s) = (case["n"].as_i64().unwrap(), complex(&case["s"]));
        all.push((Arc { angular_velocity, ..lossy() }, n, s, published(case)));
    }
    all
}

#[test]
fn an_arcs_impedance_equals_the_reference_values() {
    let (mut production, mut refined) = (0.0_f64, 0.0_f64);
    let references = references();
    for (arc, n, s, wanted) in &references {
        let sidewall = Sidewall::new(arc.clone());
        let (coarse, fine) = (sidewall.impedance(*n, *s), sidewall.reference(*n, *s));
        production = production.max(difference(&coarse, wanted));
        refined = refined.max(difference(&fine, wanted));
    }
    assert_eq!(references.len(), 47);
    println!("sidewall's impedance, production step, bound 1e-4: {production:.1e}");
    println!("sidewall's impedance, refined, bound 1e-6: {refined:.1e}");
    assert!(production < 1e-5 && refined < 1e-7, "{production:.1e}, {refined:.1e}");
}

#[test]
fn files_of_cases_are_answered_with_the_reference_values() {
    let terms = lossy().relaxation.terms;
    let (mut sidewalls, mut cases_of, mut wanted) = (Vec::new(), Vec::new(), Vec::new());
    for (index, (arc, n, s, expected)) in references().into_iter().enumerate() {
        let mut entry = json!({
            "name": format!("{index}"), "radius": arc.radius, "angle": arc.angle, "pressure": arc.pressure,
            "mass": arc.mass, "shear": arc.shear, "edge_radius": arc.edge_radius, "omega": arc.angular_velocity,
            "relaxation": terms,
        });
        // Left out it is four times the shear stiffness.
        if arc.hoop == 0.0 {
            entry["hoop"] = json!(0.0);
        }
        sidewalls.push(entry);
        cases_of.push(json!({ "sidewall": format!("{index}"), "n": n, "s": [s.re, s.im] }));
        wanted.push(expected);
    }
    let answer = cases::evaluate(&json!({ "sidewalls": sidewalls, "cases": cases_of }).to_string()).unwrap();
    for (case, wanted) in answer["cases"].as_array().unwrap().iter().zip(&wanted) {
        let k = &case["K"];
        let found = EdgeImpedance {
            radial: complex(&k[0][0]),
            coupling: complex(&k[0][1]),
            circumferential: complex(&k[1][1]),
            lateral: Complex64::ZERO,
        };
        assert_eq!(k[0][1], k[1][0]);
        assert!(difference(&found, wanted) < 1e-7, "{case}");
    }
}

#[test]
fn files_of_cases_with_wrong_sidewalls_are_refused() {
    let wall = |change: &dyn Fn(&mut Value)| {
        let mut wall = json!({
            "name": "a", "radius": 0.055, "angle": 1.0, "pressure": 2.2e5, "mass": 7.0, "shear": 8e3,
            "edge_radius": 0.297, "omega": 0.0, "relaxation": [],
        });
        change(&mut wall);
        json!({ "sidewalls": [wall], "cases": [{ "sidewall": "a", "n": 3, "s": [0.0, 600.0] }] })
    };
    let refusal = |document: Value| match cases::evaluate(&document.to_string()) {
        Ok(answer) => panic!("{answer}"),
        Err(error) => error.to_string(),
    };
    assert!(cases::evaluate(&wall(&|_| {}).to_string()).is_ok());
    for (key, value, part) in [
        ("radius", json!(0.0), "must be positive"),
        ("angle", json!(3.2), "above 0 and below pi"),
        ("hoop", json!(-1.0), "must not be negative"),
        ("edge_radius", json!(0.09), "above the axle"),
        ("relaxation", json!([[0.3, -1.0]]), "positive time"),
        ("omega", json!(3e3), "no steady shape"),
        ("size", json!(1.0), "unknown field"),
    ] {
        let message = refusal(wall(&|wall| wall[key] = value.clone()));
        assert!(message.contains(part), "{key}: {message}");
    }
    let case = |case: Value| {
        let mut document = wall(&|_| {});
        document["cases"][0] = case;
        refusal(document)
    };
    assert!(case(json!({ "sidewall": "b", "n": 3, "s": [0.0, 1.0] })).contains("names the sidewall 'b'"));
    assert!(case(json!({ "sidewall": "a", "s": [0.0, 1.0] })).contains("has n"));
    assert!(case(json!({ "n": 3, "s": [0.0, 1.0] })).contains("either a tyre or a sidewall"));
    assert!(case(json!({ "sidewall": "a", "n": 3, "s": [-1.0, 1.0] })).contains("Re s >= 0"));
    assert!(case(json!({ "sidewall": "a", "n": 900_000_000, "s": [0.0, 1.0] })).contains("too short"));
    assert!(refusal(json!({ "cases": [] })).contains("not a file of compliance cases"));
}

/// K_ww of a flat arc at n = 0 by its four exponential solutions.
fn flat_radial(arc: &Arc, s: Complex64) -> Complex64 {
    let (phi, f) = (arc.angle, arc.relaxation.at(s));
    let (stiffness, inertia) = (f * (arc.pressure / arc.radius), s * s * arc.mass);
    // (p/r)(a^4 + a^2) + m s^2 (1 - a^2) = 0.
    let (half, product) = ((inertia / stiffness - 1.0) * 0.5, inertia / stiffness);
    let root = (half * half - product).sqrt();
    let squares = [half + root, half - root];
    let exponents = squares.map(Complex64::sqrt).map(|a| [a, -a]).concat();
    let at = |angle: f64, a: Complex64| (a * (angle - phi * a.re.signum())).exp();
    // t and u = -t' at both ends.
    let rows = [(-phi, 0), (-phi, 1), (phi, 0), (phi, 1)];
    let matrix = Mat::from_fn(4, 4, |row, column| {
        let (angle, order) = rows[row];
        let a = exponents[column];
        let value = at(angle, a);
        if order == 0 { value } else { -a * value }
    });
    let (sine, cosine) = phi.sin_cos();
    let wanted = Mat::from_fn(4, 1, |row, _| Complex64::from([0.0, 0.0, cosine, sine][row]));
    let parts = matrix.partial_piv_lu().solve(&wanted);
    let (mut along, mut normal) = (Complex64::ZERO, Complex64::ZERO);
    for (column, a) in exponents.iter().enumerate() {
        let t = parts[(column, 0)] * at(phi, *a);
        let u = -a * t;
        along += f * arc.pressure * (a * a * u + u) - arc.mass * arc.radius * s * s * u;
        normal += f * arc.pressure * (a * u - t);
    }
    along * cosine + normal * sine
}

#[test]
fn at_n_0_a_flat_arc_has_its_closed_form() {
    let arc = Arc { edge_radius: FLAT, ..lossy() };
    let sidewall = Sidewall::new(arc.clone());
    let mut worst = 0.0_f64;
    for s in [at_frequency(20.0), at_frequency(300.0), at_frequency(2e3), Complex64::new(500.0, 4e3), 1e3.into()] {
        let found = sidewall.reference(0, s);
        let string = arc.relaxation.at(s) * (arc.pressure + arc.shear / arc.radius);
        let x = (s * s * (arc.mass * arc.radius) / string).sqrt();
        let circumferential = string * x / (x * (2.0 * arc.angle)).tanh();
        let radial = flat_radial(&arc, s);
        let off = [(found.radial - radial) / radial, (found.circumferential - circumferential) / circumferential];
        worst = off.iter().map(|off| off.norm()).fold(worst, f64::max);
    }
    println!("flat arc at n = 0 against its closed form, bound 1e-6: {worst:.1e}");
    assert!(worst < 1e-6, "{worst:.1e}");
}

#[test]
fn at_rest_a_flat_arc_is_inextensible() {
    let (radius, angle) = (0.05, 1.1);
    let arc = Arc { radius, angle, edge_radius: FLAT, ..arc() };
    let found = Sidewall::new(arc.clone()).reference(0, Complex64::ZERO);
    let (sine, cosine) = arc.angle.sin_cos();
    let radial = 0.5 * arc.pressure * (cosine + angle * sine) / (sine - angle * cosine);
    let circumferential = 0.5 * (arc.pressure + arc.shear / radius) / angle;
    // Per area of a belt of 136 mm: 26.880 p, and 2.5401e6 N/m^3.
    assert!((2.0 * radial / 0.136 / arc.pressure - 26.880).abs() < 1e-3);
    assert!((2.0 * circumferential / 0.136 / 2.5401e6 - 1.0).abs() < 1e-4);
    for (found, wanted) in [(found.radial, radial), (found.circumferential, circumferential)] {
        assert!((found / wanted - 1.0).norm() < 1e-5, "{found} is not {wanted}");
    }
}

#[test]
fn held_arcs_ring_at_their_frequencies() {
    for (mass, expected) in [(5.0, [341.0, 563.8]), (6.0, [311.3, 514.6]), (8.0, [269.6, 445.7])] {
        let sidewall = Sidewall::new(Arc { radius: 0.05, angle: 1.1, mass, edge_radius: FLAT, ..arc() });
        // With the edge held K is infinite: its inverse changes its sign.
        let flexibility = |frequency: f64| 1.0 / sidewall.reference(0, at_frequency(frequency)).radial.re;
        for wanted in expected {
            let (mut low, mut high) = (0.97 * wanted, 1.03 * wanted);
            assert!(flexibility(low) * flexibility(high) < 0.0, "{mass} kg/m^2, {wanted} Hz");
            for _ in 0..14 {
                let middle = 0.5 * (low + high);
                if flexibility(middle) * flexibility(low) > 0.0 { low = middle } else { high = middle }
            }
            assert!((low - wanted).abs() < 0.06, "{mass} kg/m^2: {low} is not {wanted} Hz");
        }
    }
}

#[test]
fn a_fast_edge_feels_a_mass_and_a_damper_of_its_angle() {
    let arc = Arc { edge_radius: FLAT, ..lossy() };
    let (sine, cosine) = arc.angle.sin_cos();
    let across = 1.0 / (2.0 * arc.angle).tanh();
    let sidewall = Sidewall::new(arc.clone());
    for (s, allowed) in [(1e4, 1e-2), (1e5, 1e-3), (1e6, 1e-4)] {
        let tension = arc.pressure * arc.radius * arc.relaxation.at(s.into()).re;
        let wanted = arc.mass * arc.radius * s * s * cosine * cosine * across
            + s * (arc.mass * tension).sqrt() * (sine + cosine * across).powi(2);
        let off = (sidewall.reference(0, s.into()).radial.re / wanted - 1.0).abs();
        assert!(off < allowed && off > 0.01 * allowed, "s {s}: {off:.1e}");
    }
}

/// R N cos a at the edge of the arc whose edge is moved outwards while its bead and its length stay.
fn pull_moved(arc: &Arc, by: f64) -> f64 {
    let (length, chord) = (arc.length(), arc.edge_radius - arc.bead_radius() + by);
    // Half the angle of the circular arc of this length and chord.
    let mut angle = arc.angle;
    for _ in 0..50 {
        let miss = length * angle.sin() / angle - chord;
        angle -= miss / (length * (angle.cos() - angle.sin() / angle) / angle);
    }
    let moved = Arc { angle, radius: 0.5 * length / angle, edge_radius: arc.edge_radius + by, ..arc.clone() };
    moved.edge_radius * Sidewall::new(moved).edge().unwrap().pull()
}

#[test]
fn at_rest_a_toroid_has_the_derivative_of_its_statics() {
    // Without hoop stiffness, which the steady shape does not know; differences of fourth order.
    let arc = Arc { hoop: 0.0, ..arc() };
    let h = 2e-4;
    let [far, near] = [2.0, 1.0].map(|times| pull_moved(&arc, times * h) - pull_moved(&arc, -times * h));
    let wanted = (8.0 * near - far) / (12.0 * h) / arc.edge_radius;
    let found = Sidewall::new(arc).reference(0, Complex64::ZERO);
    let off = (found.radial.re / wanted - 1.0).abs();
    assert!(off < 1e-7, "{} is not {wanted}, {off:.1e}", found.radial);
}

/// Least eigenvalue of the Hermitian part of s* K, over |s K|.
fn least_power(edge: &EdgeImpedance, s: Complex64) -> f64 {
    let part = |entry: Complex64| (s.conj() * entry).re;
    // The Hermitian part of a symmetric matrix is its real part.
    let (a, b, d) = (part(edge.radial), part(edge.coupling), part(edge.circumferential));
    let least = 0.5 * (a + d) - (0.25 * (a - d) * (a - d) + b * b).sqrt();
    least / (s.norm() * size(edge))
}

/// Least over a hard grid of n and s.
fn least_of(arc: &Arc, around: &[i64]) -> (f64, i64, Complex64) {
    let sidewall = Sidewall::new(arc.clone());
    let mut least = (f64::INFINITY, 0, Complex64::ZERO);
    for &n in around {
        for w in [1.0, 30.0, 125.0, 400.0, 1e3, 1.6e3, 2.5e3, 4e3, 6.3e3, 1e4, 3e4] {
            for angle in [0.0_f64, 0.6, 1.2, 1.5, std::f64::consts::FRAC_PI_2] {
                let s = Complex64::from_polar(w, angle);
                let power = least_power(&sidewall.impedance(n, s), s);
                if power < least.0 || power.is_nan() {
                    least = (power, n, s);
                }
            }
        }
    }
    least
}

#[test]
fn sidewalls_absorb_power_but_not_without_hoop_stiffness() {
    let around = [0, 1, 2, 3, 6, 10, 18, 30, 60, 100, 200, 300, 400];
    let rest = least_of(&lossy(), &around);
    println!("least power of a sidewall at 715 points: {:.1e}", rest.0);
    assert!(rest.0 > 0.0, "{rest:?}");
    let both: Vec<i64> = around[..12].iter().flat_map(|&n| [n, -n]).collect();
    for speed in [110.0, 250.0, 300.0] {
        let turning = least_of(&Arc { angular_velocity: speed / 3.6 / (1.95 / TAU), ..lossy() }, &both);
        assert!(turning.0 > 0.0, "{speed} km/h: {turning:?}");
    }
    let made = least_of(&Arc { relaxation: Relaxation::of_loss_factor(0.2), ..arc() }, &around);
    assert!(made.0 > 0.0, "{made:?}");
    // The check sees what is not passive.
    let soft = least_of(&Arc { hoop: 0.0, ..lossy() }, &[26, 30, 45]);
    assert!(soft.0 < 0.0, "{soft:?}");
}

#[test]
fn waves_backwards_are_those_of_the_other_rotation() {
    let [forth, back] = [98.0, -98.0].map(|angular_velocity| Sidewall::new(Arc { angular_velocity, ..lossy() }));
    for (n, s) in [(0, at_frequency(100.0)), (3, Complex64::new(40.0, 1500.0)), (17, at_frequency(700.0))] {
        let (one, other) = (forth.reference(n, s), back.reference(-n, s));
        let mirrored = EdgeImpedance { coupling: -other.coupling, ..other };
        assert!(difference(&mirrored, &one) < 1e-12, "n {n}");
        // Real functions of s at n and -n together.
        let conjugate = forth.reference(-n, s.conj());
        let conjugate = EdgeImpedance {
            radial: conjugate.radial.conj(),
            coupling: -conjugate.coupling.conj(),
            circumferential: conjugate.circumferential.conj(),
            lateral: conjugate.lateral.conj(),
        };
        assert!(difference(&conjugate, &one) < 1e-12, "n {n}");
        assert!(difference(&forth.reference(-n, s), &one) > 1e-3 || n == 0, "rotation is felt");
    }
}

#[test]
fn neighbours_in_lockstep_are_what_they_are_one_by_one() {
    let sidewall = Shared::new(Sidewall::new(Arc { angular_velocity: 98.0, ..lossy() }));
    let other = Sidewall::new(Arc { angular_velocity: -98.0, ..lossy() });
    for s in [Complex64::ZERO, at_frequency(30.0), at_frequency(900.0), Complex64::new(3e4, 5e4)] {
        let at = sidewall.at(s, 40);
        for n in [0, 1, 7, 8, 13, 40] {
            let both = at.both_ways(n);
            for (found, wanted) in [(both.forwards, &*sidewall), (both.backwards, &other)] {
                let wanted = wanted.reference(n as i64, s);
                assert!(difference(&found, &wanted) < 1e-5, "n {n}, s {s}: {:.1e}", difference(&found, &wanted));
            }
        }
        // Past the largest it stands for all.
        assert_eq!(at.both_ways(99), at.both_ways(40));
    }
}
