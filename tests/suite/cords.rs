//! Layers with cords and orthotropic layers: against values of 20 digits, an independent method, and their limits.

use std::f64::consts::PI;

use faer::Mat;
use faer::linalg::solvers::Solve;
use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use tyrewave::internals::{CurvedStack, Cylinder, FINE_STEP, Matrix3, Rotation, STEP, cases, material, reference};
use tyrewave::scene::{Cavity, Cords, Foundation, Layer, Material, Orthotropic};
use tyrewave::tyre::Stack;

use crate::common::rubber;

/// Relative accuracy that waves are prepared for, as influence functions ask for.
const TOLERANCE: f64 = 1e-7;
/// Largest |s| of the tests, 2 pi times 20 kHz.
const LARGEST_S: f64 = 1.3e5;

fn cords(stiffness: f64, angle_deg: f64, loss_factor: f64) -> Vec<Cords> {
    vec![Cords::new(stiffness, angle_deg, loss_factor)]
}

fn layer(thickness: f64, tension: [f64; 2], material: Material, cords: Vec<Cords>) -> Layer {
    Layer { name: "layer".into(), thickness, tension, material, cords, orthotropic: None }
}

fn bed(normal: f64, tangential: f64) -> Foundation {
    Foundation {
        normal,
        tangential,
        loss_factor: 0.1,
        reference_frequency: Material::REFERENCE_FREQUENCY,
        corner_frequency: Material::CORNER_FREQUENCY,
    }
}

/// A car tyre with a carcass of radial cords and a belt of steel.
fn cord_tyre() -> CurvedStack {
    CurvedStack {
        layers: vec![
            layer(0.0028, [0.0; 2], rubber(1.2e7, 0.15, 0.49, 1160.0), cords(4.3e8, 90.0, 0.05)),
            layer(0.0032, [4.3e4, 2e4], rubber(1e8, 0.15, 0.49, 1450.0), cords(8e9, 25.0, 0.01)),
            layer(0.013, [0.0; 2], rubber(6.6e6, 0.25, 0.49, 980.0), Vec::new()),
        ],
        foundation: bed(7.7e6, 2.2e6),
        radius: 1.95 / (2.0 * PI),
        width: 0.136,
        pressure: 1.46e5,
        sidewall: None,
        sidewall_mass: 0.5,
        cavity: Some(Cavity { radius: 0.235, depth: 0.0825, density: 3.84, sound_speed: 343.0, relaxation: 1.4e-5 }),
        rotation: Rotation::default(),
    }
}

/// The same with a belt of engineering constants.
fn orthotropic_tyre() -> CurvedStack {
    let mut tyre = cord_tyre();
    let belt = &mut tyre.layers[1];
    belt.cords.clear();
    belt.orthotropic = Some(Orthotropic {
        e_theta: 4e9,
        e_y: 9e7,
        e_r: 6e7,
        g_y_r: 1.5e7,
        g_theta_r: 2.4e7,
        g_theta_y: 4e8,
        nu_theta_y: 1.8,
        nu_theta_r: 0.35,
        nu_y_r: 0.4,
    });
    (belt.material.modulus, belt.material.poisson) = belt.orthotropic.as_ref().unwrap().measure();
    tyre
}

fn complex(value: &Value) -> Complex64 {
    let part = |part: &Value| part.as_f64().or_else(|| part.as_str()?.parse().ok()).unwrap();
    Complex64::new(part(&value[0]), part(&value[1]))
}

fn norm(matrix: &Matrix3) -> f64 {
    matrix.iter().flatten().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

fn error(ours: &Matrix3, exact: &Matrix3) -> f64 {
    let difference: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|j| ours[i][j] - exact[i][j]));
    norm(&difference) / norm(exact)
}

/// Waves and s: static, slow, fast, real, short.
fn points(seed: u64, count: usize) -> Vec<(i64, usize, Complex64)> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut point = |index: usize| {
        let n = (200.0_f64.powf(random.random::<f64>()) - 1.0) as i64;
        let m = random.random_range(0..6);
        let size = 10.0_f64.powf(random.random_range(1.0..5.0));
        let s = match index % 4 {
            0 => Complex64::ZERO,
            1 => Complex64::new(size, 0.0),
            2 => Complex64::new(0.3 * size, size),
            _ => Complex64::new(0.0, size),
        };
        (n, m, s)
    };
    (0..count).map(&mut point).collect()
}

#[test]
fn compliance_at_rest_equals_the_twenty_digit_values() {
    let text = std::fs::read_to_string(reference("rotation/rotating_orthotropic_compliance.json")).unwrap();
    let mut document: Value = serde_json::from_str(&text).unwrap();
    let at_rest = |tyre: &Value| tyre["speed"].as_f64().unwrap_or(0.0) == 0.0;
    document["tyres"].as_array_mut().unwrap().retain(at_rest);
    let names: Vec<Value> = document["tyres"].as_array().unwrap().iter().map(|tyre| tyre["name"].clone()).collect();
    document["cases"].as_array_mut().unwrap().retain(|case| names.contains(&case["tyre"]));
    let ours = cases::evaluate(&document.to_string()).unwrap();
    let cases = document["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 5, "cases at rest");
    let matrix = |value: &Value| -> Matrix3 { std::array::from_fn(|i| std::array::from_fn(|j| complex(&value[i][j]))) };
    for (index, case) in cases.iter().enumerate() {
        for name in ["C", "D"] {
            let off = error(&matrix(&ours["cases"][index][name]), &matrix(&case[name]));
            println!("case {index} {name}: {off:.1e}");
            assert!(off < 1e-8, "case {index} {name}: {off:.1e}");
        }
    }
}

#[test]
fn unknown_fields_of_a_tyre_are_refused() {
    let tyre = |more: Value| {
        let mut tyre = json!({
            "name": "a", "curved": true, "circumference": 2.0, "width": 0.2, "resolved": { "growth": "?" },
            "foundation": { "normal": 1e6, "tangential": 1e6 },
            "layers": [{ "thickness": 0.01, "density": 1e3, "modulus": 1e7, "poisson": 0.4 }]
        });
        tyre.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        json!({ "tyres": [tyre], "cases": [{ "tyre": "a", "n": 1, "m": 0, "s": [1.0, 0.0] }] }).to_string()
    };
    assert!(cases::evaluate(&tyre(json!({}))).is_ok());
    let whole =
        |layer: Value| cases::evaluate(&tyre(json!({ "layers": [layer] }))).err().map(|error| error.to_string());
    for (more, word) in [(json!({ "breadth": 1.0 }), "breadth"), (json!({ "speed": -20.0 }), "speed")] {
        let found = cases::evaluate(&tyre(more)).unwrap_err().to_string();
        assert!(found.contains(word), "{found}");
    }
    let moduli = json!({ "E_theta": 1e9, "E_y": 1e9, "E_r": 1e9, "G_y_r": 1e8, "G_theta_r": 1e8, "G_theta_y": 1e8,
        "nu_theta_y": 1.5, "nu_theta_r": 0.1, "nu_y_r": 0.1 });
    let found = whole(json!({ "thickness": 0.01, "density": 1e3, "orthotropic": moduli })).unwrap();
    assert!(found.contains("store energy"), "{found}");
    let found = whole(json!({ "thickness": 0.01, "density": 1e3 })).unwrap();
    assert!(found.contains("modulus and poisson"), "{found}");
    let negative = json!([{ "stiffness": -1.0, "angle_deg": 0.0 }]);
    let found = whole(json!({ "thickness": 0.01, "density": 1e3, "modulus": 1e7, "poisson": 0.4, "cords": negative }));
    assert!(found.unwrap().contains("positive stiffness"));
}

#[test]
fn waves_prepared_once_equal_the_reference_path() {
    for (name, stack, allowed) in [("cords", cord_tyre(), 3e-5), ("orthotropic", orthotropic_tyre(), 3e-5)] {
        let cylinder = Cylinder::of(stack.clone(), LARGEST_S, TOLERANCE);
        let (mut worst, mut worst_step) = (0.0_f64, 0.0_f64);
        for (n, m, s) in points(11, 160) {
            let (exact, bottom) = stack.compliance(n, m, s, FINE_STEP);
            let found = cylinder.wave(n, m).full(&cylinder.at(s));
            worst_step = worst_step.max(error(&stack.compliance(n, m, s, STEP).0, &exact));
            let off = error(&found.0, &exact);
            let below = error(&found.1, &bottom) * norm(&bottom) / norm(&exact);
            worst = worst.max(off).max(below);
            assert!(off < allowed && below < allowed, "{name}: n {n}, m {m}, s {s}: {off:.1e}, {below:.1e}");
        }
        println!("{name}: {worst:.1e} at worst, in steps of production {worst_step:.1e}");
        assert!(worst_step < 3e-5, "{name}: {worst_step:.1e}");
    }
}

#[test]
fn isotropic_moduli_and_empty_cords_are_the_isotropic_layer() {
    let mut stack = cord_tyre();
    for layer in &mut stack.layers {
        layer.cords.clear();
    }
    let mut same = stack.clone();
    for layer in &mut same.layers {
        let (modulus, poisson) = (layer.material.modulus, layer.material.poisson);
        let shear = modulus / (2.0 * (1.0 + poisson));
        layer.orthotropic = Some(Orthotropic {
            e_theta: modulus,
            e_y: modulus,
            e_r: modulus,
            g_y_r: shear,
            g_theta_r: shear,
            g_theta_y: shear,
            nu_theta_y: poisson,
            nu_theta_r: poisson,
            nu_y_r: poisson,
        });
        (layer.material.modulus, layer.material.poisson) = (2.0 * shear, 0.0);
    }
    let (a, b) = [&stack, &same].map(|stack| Cylinder::of(stack.clone(), LARGEST_S, TOLERANCE)).into();
    let flat = [&stack, &same].map(|stack| Stack::of(stack.layers.clone(), stack.foundation.clone()));
    for (n, m, s) in points(5, 60) {
        // Layers that are not isotropic take twice the steps.
        let exact = stack.compliance(n, m, s, 0.5 * STEP).0;
        let off = error(&same.compliance(n, m, s, STEP).0, &exact);
        assert!(off < 1e-12, "steps: n {n}, m {m}, s {s}: {off:.1e}");
        let off = error(&b.wave(n, m).full(&b.at(s)).0, &a.wave(n, m).full(&a.at(s)).0);
        assert!(off < 1e-8, "modes: n {n}, m {m}, s {s}: {off:.1e}");
        // Flat: two formulations that share nothing but the constants.
        let (kx, ky) = (n as f64 / stack.radius, m as f64 * PI / stack.width);
        let [one, other] = flat.each_ref().map(|stack| stack.at(s).full(kx, ky));
        let off = error(&other.0, &one.0).max(error(&other.1, &one.1) * norm(&one.1) / norm(&one.0));
        assert!(off < 1e-9, "flat: kx {kx}, ky {ky}, s {s}: {off:.1e}");
        let under = one.0[2][2].norm();
        let off = (flat[0].at(s).under_tread(kx, ky) - flat[1].at(s).under_tread(kx, ky)).norm() / under;
        assert!(off < 1e-8, "flat, under the tread: kx {kx}, ky {ky}, s {s}: {off:.1e}");
    }
}

#[test]
fn a_thousand_radii_are_flat() {
    for stack in [cord_tyre(), orthotropic_tyre()] {
        let far =
            CurvedStack { radius: 1000.0 * stack.radius, pressure: 0.0, sidewall_mass: 0.0, cavity: None, ..stack };
        let flat = Stack::of(far.layers.clone(), far.foundation.clone());
        for (n, m, s) in points(7, 40) {
            let n = 1000 * n.max(1);
            let exact = far.compliance(n, m, s, FINE_STEP).0;
            let (kx, ky) = (n as f64 / far.radius, m as f64 * PI / far.width);
            let off = error(&flat.at(s).full(kx, ky).0, &exact);
            assert!(off < 2e-3, "n {n}, m {m}, s {s}: {off:.1e}");
        }
    }
}

#[test]
fn compliances_are_passive_on_the_hard_grid() {
    for stack in [cord_tyre(), orthotropic_tyre()] {
        let cylinder = Cylinder::of(stack.clone(), LARGEST_S, TOLERANCE);
        let flat = Stack::of(stack.layers.clone(), stack.foundation.clone());
        for n in [0, 1, 2, 7, 40, 150, 400] {
            for m in [0, 1, 4, 12] {
                let wave = cylinder.wave(n, m);
                for exponent in 0..11 {
                    let size = 10.0_f64.powf(f64::from(exponent) * 0.5);
                    for phase in [0.0, 0.3, 0.49] {
                        let s = Complex64::from_polar(size, PI * phase);
                        let (kx, ky) = (n as f64 / stack.radius, m as f64 * PI / stack.width);
                        for (name, c) in [("curved", wave.full(&cylinder.at(s)).0), ("flat", flat.at(s).full(kx, ky).0)]
                        {
                            let c = c[2][2];
                            assert!(c.is_finite() && (s * c).re > -1e-9 * (s * c).norm(), "{name} {n} {m} {s}: {c}");
                        }
                    }
                }
            }
        }
    }
}

/// C of the outer face by quadratic finite elements in r: the energy of strains in Voigt's order through the inverse of
/// the matrix of compliances. It shares no line with the program's forms but the laws of the materials.
fn by_elements(stack: &CurvedStack, n: f64, ky: f64, s: Complex64, per_layer: usize) -> Matrix3 {
    let i = Complex64::i();
    let nodes = 2 * per_layer * stack.layers.len() + 1;
    let mut z = Mat::<Complex64>::zeros(3 * nodes, 3 * nodes);
    let mut first = 0;
    let mut r0 = stack.inner_radius();
    for layer in &stack.layers {
        let voigt = elasticity(layer, s);
        let (rho, tension) = (layer.material.density, layer.tension.map(|tension| tension / layer.thickness));
        let length = layer.thickness / per_layer as f64;
        for element in 0..per_layer {
            let a = r0 + element as f64 * length;
            let root = 0.6_f64.sqrt();
            for (x, weight) in [(-root, 5.0 / 9.0), (0.0, 8.0 / 9.0), (root, 5.0 / 9.0)] {
                let r = a + 0.5 * length * (1.0 + x);
                let volume = 0.5 * length * weight * r;
                let shape = [0.5 * x * (x - 1.0), 1.0 - x * x, 0.5 * x * (x + 1.0)];
                let slope = [x - 0.5, -2.0 * x, x + 0.5].map(|d| d * 2.0 / length);
                // Strains tt, yy, rr, yr, tr, ty of each unknown; displacement gradients along the prestress.
                let strain = |node: usize, field: usize| -> [Complex64; 6] {
                    let (f, d) = (shape[node], slope[node]);
                    let zero = Complex64::ZERO;
                    match field {
                        0 => [i * (n / r * f), zero, zero, zero, (d - f / r).into(), i * (ky * f)],
                        1 => [zero, i * (ky * f), zero, d.into(), zero, i * (n / r * f)],
                        _ => [(f / r).into(), zero, d.into(), i * (ky * f), i * (n / r * f), zero],
                    }
                };
                let along = |node: usize, field: usize| -> [Complex64; 3] {
                    let f = shape[node] / r;
                    match field {
                        0 => [i * (n * f), Complex64::ZERO, (-f).into()],
                        1 => [Complex64::ZERO, i * (n * f), Complex64::ZERO],
                        _ => [f.into(), Complex64::ZERO, i * (n * f)],
                    }
                };
                for row in 0..9 {
                    for column in 0..9 {
                        let (left, right) = (strain(row / 3, row % 3), strain(column / 3, column % 3));
                        let mut value = Complex64::ZERO;
                        for p in 0..6 {
                            for q in 0..6 {
                                value += left[p].conj() * voigt[p][q] * right[q];
                            }
                        }
                        let (left, right) = (along(row / 3, row % 3), along(column / 3, column % 3));
                        for p in 0..3 {
                            value += left[p].conj() * right[p] * tension[0];
                        }
                        if row % 3 == column % 3 {
                            value += (s * s * rho + tension[1] * ky * ky) * shape[row / 3] * shape[column / 3];
                        }
                        z[(3 * first + row, 3 * first + column)] += value * volume;
                    }
                }
            }
            first += 2;
        }
        r0 += layer.thickness;
    }
    let inner = stack.inner_radius();
    let bed = material::foundation_stiffness(&stack.foundation, s).map(|k| (k + s * s * stack.sidewall_mass) * inner);
    z[(0, 0)] += bed[0];
    z[(1, 1)] += bed[0];
    z[(2, 2)] += bed[1];
    let mut loads = Mat::<Complex64>::zeros(3 * nodes, 3);
    for field in 0..3 {
        loads[(3 * nodes - 3 + field, field)] = stack.radius.into();
    }
    let moved = z.partial_piv_lu().solve(&loads);
    std::array::from_fn(|row| std::array::from_fn(|column| moved[(3 * nodes - 3 + row, column)]))
}

/// Stresses tt, yy, rr, yr, tr, ty by strains at s.
fn elasticity(layer: &Layer, s: Complex64) -> [[Complex64; 6]; 6] {
    let factor = material::modulus(&layer.material, s) / layer.material.modulus;
    let (e, nu) = (layer.material.modulus, layer.material.poisson);
    let g = e / (2.0 * (1.0 + nu));
    let [et, ey, er, gyr, gtr, gty, nty, ntr, nyr] = match &layer.orthotropic {
        None => [e, e, e, g, g, g, nu, nu, nu],
        Some(o) => [o.e_theta, o.e_y, o.e_r, o.g_y_r, o.g_theta_r, o.g_theta_y, o.nu_theta_y, o.nu_theta_r, o.nu_y_r],
    };
    let compliance =
        [[1.0 / et, -nty / et, -ntr / et], [-nty / et, 1.0 / ey, -nyr / ey], [-ntr / et, -nyr / ey, 1.0 / er]];
    let unit = Mat::<f64>::identity(3, 3);
    let stiffness = Mat::from_fn(3, 3, |i, j| compliance[i][j]).partial_piv_lu().solve(&unit);
    let mut c = [[Complex64::ZERO; 6]; 6];
    for row in 0..3 {
        for column in 0..3 {
            c[row][column] = factor * stiffness[(row, column)];
        }
    }
    for (place, modulus) in [(3, gyr), (4, gtr), (5, gty)] {
        c[place][place] = factor * modulus;
    }
    for cords in &layer.cords {
        let cord = rubber(cords.stiffness.unwrap(), cords.loss_factor, 0.0, 1.0);
        let stiffness = material::modulus(&cord, s);
        let (cosine, sine) = (cords.angle_deg.to_radians().cos(), cords.angle_deg.to_radians().sin());
        // Half of them at the angle, half at its negative: their terms odd in the sine cancel.
        for direction in [[cosine * cosine, sine * sine, cosine * sine], [cosine * cosine, sine * sine, -cosine * sine]]
        {
            for (p, a) in [0, 1, 5].into_iter().zip(direction) {
                for (q, b) in [0, 1, 5].into_iter().zip(direction) {
                    c[p][q] += stiffness * (0.5 * a * b);
                }
            }
        }
    }
    c
}

#[test]
fn elements_through_the_thickness_find_the_same() {
    for stack in [cord_tyre(), orthotropic_tyre()] {
        let stack = CurvedStack { pressure: 0.0, cavity: None, ..stack };
        for (n, m, s) in [
            (0, 0, Complex64::ZERO),
            (3, 1, Complex64::new(0.0, 900.0)),
            (25, 0, Complex64::new(0.0, 6e3)),
            (25, 3, Complex64::new(2e3, 9e3)),
            (80, 2, Complex64::new(1e4, 0.0)),
        ] {
            let exact = stack.compliance(n, m, s, FINE_STEP).0;
            let ky = m as f64 * PI / stack.width;
            let [coarse, fine] = [16, 32].map(|count| error(&by_elements(&stack, n as f64, ky, s, count), &exact));
            println!("n {n}, m {m}, s {s}: {coarse:.1e} {fine:.1e}");
            assert!(fine < 1e-5 && fine < 0.2 * coarse + 1e-8, "n {n}, m {m}, s {s}: {coarse:.1e} {fine:.1e}");
        }
    }
}
