//! Surface compliance against 50-digit reference values, analytic limits and the hard grid.

use num_complex::Complex64;
use serde_json::Value;
use tyrewave::internals::{cases, plate_tyre, reference};
use tyrewave::scene::{Law, Layer, Material, Tyre};
use tyrewave::tyre::Stack;

use crate::common::hard_case::measured;

const BOUND: f64 = 1e-10;

fn complex(value: &Value) -> Complex64 {
    Complex64::new(value[0].as_f64().unwrap(), value[1].as_f64().unwrap())
}

/// Relative error in the Frobenius norm, scaled so that tiny matrices do not underflow, and that of the zz entry.
fn errors(ours: &Value, reference: &Value) -> (f64, f64) {
    let entries = || (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
    let scale = entries().map(|(i, j)| complex(&reference[i][j]).norm()).fold(0.0, f64::max);
    if scale == 0.0 {
        // Below the smallest double: ours must be nothing, too.
        let ours = entries().map(|(i, j)| complex(&ours[i][j]).norm()).fold(0.0, f64::max);
        return (ours, 0.0);
    }
    let (mut error, mut norm) = (0.0, 0.0);
    for (i, j) in entries() {
        error += ((complex(&ours[i][j]) - complex(&reference[i][j])) / scale).norm_sqr();
        norm += (complex(&reference[i][j]) / scale).norm_sqr();
    }
    let zz = complex(&reference[2][2]);
    let zz_error = if zz.norm() > 0.0 { (complex(&ours[2][2]) - zz).norm() / zz.norm() } else { 0.0 };
    ((error / norm).sqrt(), zz_error)
}

#[test]
fn hard_case_1_compliance_equals_the_fifty_digit_values() {
    let text = std::fs::read_to_string(reference("compliance.json")).unwrap();
    let reference: Value = serde_json::from_str(&text).unwrap();
    let ours = cases::evaluate(&text).unwrap();
    let cases = reference["cases"].as_array().unwrap();
    assert!(!cases.is_empty());
    let mut worst = 0.0_f64;
    for (index, case) in cases.iter().enumerate() {
        for name in ["C", "D"] {
            let (matrix, zz) = errors(&ours["cases"][index][name], &case[name]);
            worst = worst.max(matrix).max(zz);
            assert!(matrix <= BOUND && zz <= BOUND, "case {index} {name}: matrix {matrix:.1e}, zz {zz:.1e}");
        }
    }
    measured(format!("relative error over {} cases", cases.len()), "1e-10", format!("{worst:.1e}"));
}

fn material(law: Law, modulus: f64, poisson: f64, density: f64, loss_factor: f64) -> Material {
    Material {
        law,
        modulus,
        loss_factor,
        poisson,
        density,
        reference_frequency: 1000.0,
        corner_frequency: 1.0,
        weights: vec![],
        times: vec![],
    }
}

fn layer(thickness: f64, tension: [f64; 2], material: Material) -> Layer {
    Layer { name: "layer".into(), thickness, tension, material, cords: Vec::new(), orthotropic: None }
}

/// The default tyre with another Poisson's ratio of its tread.
fn tread_of(poisson: f64) -> Tyre {
    let mut tyre = plate_tyre();
    tyre.layers[1].material.poisson = poisson;
    tyre
}

#[test]
fn hard_case_2_finite_and_passive_on_the_hard_grid() {
    let pi = std::f64::consts::PI;
    let (mut checked, mut lowest) = (0, f64::INFINITY);
    for poisson in [0.0, 0.3, 0.49, 0.4999, 0.49999] {
        let stack = Stack::new(&tread_of(poisson));
        let mut points = vec![Complex64::new(0.0, 0.0)];
        for frequency in [1e-3, 1.0, 30.0, 95.8, 500.0, 2e3, 2e4] {
            points.push(Complex64::new(0.0, 2.0 * pi * frequency));
            points.push(Complex64::new(1.0, 2.0 * pi * frequency));
            points.push(Complex64::new(2.0 * pi * frequency, 2.0 * pi * frequency));
        }
        for real in [1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6] {
            points.push(Complex64::new(real, 0.0));
        }
        for s in points {
            let at = stack.at(s);
            // Up to k h = 1000 on the 13 mm tread.
            for kx in [0.0, 1e-3, 3.2, 30.0, 300.0, 1e3, 3e3, 1e4, 3e4, 1000.0 / 0.013] {
                for ky in [0.0, 15.7, 47.1, 800.0] {
                    let (surface, bottom) = at.full(kx, ky);
                    let all_finite = surface
                        .iter()
                        .chain(&bottom)
                        .flatten()
                        .all(|entry| entry.re.is_finite() && entry.im.is_finite());
                    assert!(all_finite, "nu {poisson} s {s} kx {kx} ky {ky}: {surface:?}");
                    let zz = surface[2][2];
                    let real_part = (s * zz).re;
                    assert!(
                        real_part >= -1e-13 * (s * zz).norm(),
                        "nu {poisson} s {s} kx {kx} ky {ky}: Re(s C_zz) = {real_part:e} of {:e}",
                        (s * zz).norm()
                    );
                    if s.norm() > 0.0 {
                        lowest = lowest.min(real_part / (s * zz).norm());
                    }
                    checked += 1;
                }
            }
        }
    }
    measured(format!("real part of s C_zz over its modulus, {checked} points"), ">= -1e-13", format!("{lowest:.1e}"));
}

#[test]
fn grazing_incidence_and_the_switch_between_ways_leave_no_step() {
    // Lossless layer: exponents pass through zero where the wavenumber meets a wave's own. C_zz must be smooth across
    // it and across the thresholds.
    let tyre =
        Tyre { layers: vec![layer(0.02, [0.0; 2], material(Law::Elastic, 5e8, 0.3, 1300.0, 0.0))], ..tread_of(0.3) };
    let stack = Stack::new(&tyre);
    let s = Complex64::new(0.0, 2.0 * std::f64::consts::PI * 2e4);
    let at = stack.at(s);
    let shear: f64 = 5e8 / 2.6;
    for wavenumber in [s.im / (shear / 1300.0).sqrt(), s.im / (shear * 3.5 / 1300.0).sqrt()] {
        // At grazing incidence, and where |exponent h| = 0.05 ends the cutting into thin layers.
        for place in [wavenumber, wavenumber.hypot(0.05 / 0.02)] {
            let [below, middle, above] = [-1e-8, 0.0, 1e-8].map(|step| at.normal(place * (1.0 + step), 0.0).surface);
            let around = (below + above) / 2.0;
            assert!((middle - around).norm() < 1e-10 * middle.norm(), "{middle} {around}");
        }
    }
    // |exponent h| = 2 at rest: k h = 2.
    let still = stack.at(Complex64::ZERO);
    let (below, above) = (still.normal(100.0 - 1e-9, 0.0).surface, still.normal(100.0 + 1e-9, 0.0).surface);
    assert!((below - above).norm() < 1e-9 * below.norm());
}

#[test]
fn static_uniform_load_compresses_foundation_and_layers() {
    let tyre = tread_of(0.49);
    let stack = Stack::new(&tyre);
    let (surface, bottom) = stack.at(Complex64::ZERO).full(0.0, 0.0);
    let gamma = |loss: f64| 1e-3_f64.powf(2.0 * loss.atan() / std::f64::consts::PI);
    let foundation = 1.0 / (1.8e6 * gamma(0.1));
    let oedometer = |m: &Material| {
        let nu = m.poisson;
        m.modulus * gamma(m.loss_factor) * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
    };
    let expected: f64 = foundation + tyre.layers.iter().map(|l| l.thickness / oedometer(&l.material)).sum::<f64>();
    assert!((surface[2][2].re / expected - 1.0).abs() < 1e-12);
    assert!((bottom[2][2].re / foundation - 1.0).abs() < 1e-12);
}

#[test]
fn cutting_a_layer_in_two_changes_nothing() {
    let tyre = tread_of(0.49);
    let mut cut = tyre.clone();
    let tread = cut.layers.pop().unwrap();
    for part in [0.3, 0.7] {
        cut.layers.push(Layer { thickness: part * tread.thickness, ..tread.clone() });
    }
    let (whole, cut) = (Stack::new(&tyre), Stack::new(&cut));
    for (kx, ky, s) in [
        (3.2, 15.7, Complex64::new(0.0, 600.0)),
        (400.0, 47.0, Complex64::new(1.0, 9e3)),
        (5e3, 15.7, Complex64::new(0.0, 6.0)),
        (50.0, 300.0, Complex64::new(1e4, 0.0)),
    ] {
        let (a, b) = (whole.at(s).full(kx, ky), cut.at(s).full(kx, ky));
        for i in 0..3 {
            for j in 0..3 {
                let scale = a.0[2][2].norm();
                assert!((a.0[i][j] - b.0[i][j]).norm() < 1e-11 * scale, "C{i}{j} at {kx} {ky} {s}");
                assert!((a.1[i][j] - b.1[i][j]).norm() < 1e-10 * a.1[2][2].norm(), "D{i}{j} at {kx} {ky} {s}");
                // Reciprocity: C_ij(k) = C_ji(-k); in-plane entries are even in k, those with one z odd.
                let sign = if (i == 2) == (j == 2) { 1.0 } else { -1.0 };
                assert!((a.0[i][j] - a.0[j][i] * sign).norm() < 1e-12 * scale, "C{i}{j} at {kx} {ky} {s}");
            }
        }
    }
}

#[test]
fn resonances_of_the_default_tyre_lie_where_they_were_found() {
    // An independent calculation: m = 1 resonances of the surface compliance for n = 0..6.
    let stack = Stack::new(&tread_of(0.49));
    let pi = std::f64::consts::PI;
    for (n, expected) in [91.5, 95.8, 107.8, 125.5, 147.5, 172.5, 200.0].into_iter().enumerate() {
        let kx = 2.0 * pi * n as f64 / 1.95;
        let peak = (0..2000)
            .map(|i| 60.0 + 0.1 * f64::from(i))
            .max_by(|&a, &b| {
                let level = |f: f64| stack.at(Complex64::new(0.0, 2.0 * pi * f)).normal(kx, pi / 0.2).surface.norm();
                level(a).total_cmp(&level(b))
            })
            .unwrap();
        assert!((peak - expected).abs() <= 1.0, "n = {n}: {peak} Hz, expected {expected} Hz");
    }
}

#[test]
fn bad_case_files_are_refused() {
    assert!(cases::evaluate("{").is_err());
    assert!(cases::evaluate("{}").is_err());
    let tyre = r#"{
        "name": "a",
        "layers": [{
            "thickness": 0.01,
            "material": {"law": "elastic", "modulus": 1e6, "poisson": 0.5, "density": 1000}
        }],
        "foundation": {"normal": 1e6, "tangential": 1e6}
    }"#;
    let error = cases::evaluate(&format!(r#"{{"tyres": [{tyre}], "cases": []}}"#)).unwrap_err();
    assert!(error.to_string().contains("below 0.5"), "{error}");
    let error =
        cases::evaluate(r#"{"tyres": [], "cases": [{"tyre": "b", "kx": 1, "ky": 1, "s": [0, 1]}]}"#).unwrap_err();
    assert!(error.to_string().contains("'b'"), "{error}");
}

#[test]
fn a_wave_of_too_many_steps_through_the_layers_is_refused() {
    let with = |n: &str, s: &str, modulus: &str| {
        let text = format!(
            r#"{{"tyres": [{{"name": "t", "curved": true, "circumference": 1.95, "width": 0.2, "foundation":
            {{"normal": 2e6, "tangential": 1e6}}, "layers": [{{"thickness": 0.01, "modulus": {modulus}, "poisson": 0.4,
            "density": 1200}}]}}], "cases": [{{"tyre": "t", "n": {n}, "m": 2, "s": [0, {s}]}}]}}"#
        );
        cases::evaluate(&text).map_err(|error| error.to_string())
    };
    assert!(with("3", "900", "1e8").is_ok());
    for (n, s) in [("6148914691236517206", "900"), ("3", "1e300")] {
        let error = with(n, s, "1e8").unwrap_err();
        assert!(error.contains("case 0") && error.contains("too short"), "{error}");
    }
    // Steps whose matrices are not finite are not squared two thousand million times.
    for modulus in ["1e308", "1e-308"] {
        let error = with("3", "900", modulus).unwrap_err();
        assert!(error.contains("case 0"), "{error}");
    }
}
