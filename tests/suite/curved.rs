//! The curved tyre against displacements found by collocation, against the flat layers, and the hard grid.

use std::f64::consts::PI;

use faer::Mat;
use faer::linalg::solvers::Solve;
use num_complex::Complex64;
use tyrewave::internals::{
    CurvedStack, Cylinder, FINE_STEP, Matrix3, Mode, Motion, Rotation, STEP, StaticTyre, air_stiffness, cases,
    material, modes, modes_of,
};
use tyrewave::scene::{Axle, Cavity, DEFAULT, Foundation, Layer, Material, Scene, Tyre};
use tyrewave::tyre::{Field, InfluenceSum, Projection, Stack, Truncation};

use tyrewave::internals::on_springs;

use crate::common::rubber;

/// The car tyre, its patch and its modes fitted to measurements.
fn car() -> CurvedStack {
    let layer = |name: &str, thickness, tension, material| Layer {
        name: name.into(),
        thickness,
        tension,
        material,
        cords: Vec::new(),
        orthotropic: None,
    };
    CurvedStack {
        layers: vec![
            layer("belt", 0.006, [4.3e4, 2e4], rubber(5e8, 0.08, 0.3, 1300.0)),
            layer("tread", 0.013, [0.0, 0.0], rubber(6.8e6, 0.25, 0.49, 1000.0)),
        ],
        foundation: Foundation {
            normal: 7.7e6,
            tangential: 2.4e6,
            loss_factor: 0.1,
            reference_frequency: Material::REFERENCE_FREQUENCY,
            corner_frequency: Material::CORNER_FREQUENCY,
        },
        radius: 1.95 / (2.0 * PI),
        width: 0.136,
        pressure: 1.46e5,
        sidewall: None,
        sidewall_mass: 0.0,
        cavity: Some(Cavity { radius: 0.235, depth: 0.0825, density: 3.84, sound_speed: 343.0, relaxation: 1.4e-5 }),
        rotation: Rotation::default(),
    }
}

fn at_frequency(frequency: f64) -> Complex64 {
    Complex64::new(0.0, 2.0 * PI * frequency)
}

fn difference(found: &Matrix3, wanted: &Matrix3) -> f64 {
    let size = wanted.iter().flatten().map(|entry| entry.norm()).fold(0.0, f64::max);
    let entries = found.iter().flatten().zip(wanted.iter().flatten());
    entries.map(|(found, wanted)| (found - wanted).norm()).fold(0.0, f64::max) / size
}

/// Chebyshev points on [from, to], from below, and the matrix that differentiates there (Trefethen 2000, program 6).
fn chebyshev(points: usize, from: f64, to: f64) -> (Vec<f64>, Vec<Vec<f64>>) {
    let last = points - 1;
    let x: Vec<f64> = (0..points).map(|j| -(PI * j as f64 / last as f64).cos()).collect();
    let weight = |j: usize| if j == 0 || j == last { 2.0 } else { 1.0 } * if j.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut d = vec![vec![0.0; points]; points];
    for i in 0..points {
        for j in (0..points).filter(|&j| j != i) {
            d[i][j] = weight(i) / weight(j) / (x[i] - x[j]);
        }
        d[i][i] = -d[i].iter().sum::<f64>();
    }
    let scale = 2.0 / (to - from);
    d.iter_mut().flatten().for_each(|entry| *entry *= scale);
    (x.iter().map(|x| from + 0.5 * (x + 1.0) * (to - from)).collect(), d)
}

/// Rows of stresses (rr, tt, yy, rt, ry, ty) by the displacements (v, q, w) at all points of a layer.
struct Stresses {
    rows: [Vec<Vec<Complex64>>; 6],
}

/// C and D by collocation of Navier's equations in cylindrical coordinates: the displacements are polynomials in each
/// layer, stresses are differentiated as they stand; no state vector, no impedance.
fn by_collocation(tyre: &CurvedStack, n: i64, m: usize, s: Complex64, points: usize) -> (Matrix3, Matrix3) {
    let (i, zero) = (Complex64::i(), Complex64::ZERO);
    let (nf, ky) = (n as f64, m as f64 * PI / tyre.width);
    let unknowns = 3 * points * tyre.layers.len();
    let mut system = Mat::<Complex64>::zeros(unknowns, unknowns);
    let mut right = Mat::<Complex64>::zeros(unknowns, 3);
    let mut from = tyre.radius - tyre.layers.iter().map(|layer| layer.thickness).sum::<f64>();
    let inner = from;
    let scale = 1e9;
    let mut below: Option<(usize, Stresses)> = None;
    let mut row = 0;
    for (number, layer) in tyre.layers.iter().enumerate() {
        let (r, d) = chebyshev(points, from, from + layer.thickness);
        let offset = 3 * points * number;
        let modulus = material::modulus(&layer.material, s);
        let nu = layer.material.poisson;
        let mu = modulus / (2.0 * (1.0 + nu));
        let lambda = mu * (2.0 * nu / (1.0 - 2.0 * nu));
        let [sx, sy] = layer.tension.map(|tension| tension / layer.thickness);
        // Stresses at point p as rows over the layer's unknowns, (v, q, w) of each point together.
        let width = 3 * points;
        let mut stresses = Stresses { rows: std::array::from_fn(|_| vec![vec![zero; width]; points]) };
        for p in 0..points {
            let k = nf / r[p];
            let [v, q, w] = [3 * p, 3 * p + 1, 3 * p + 2];
            let mut strain = [(); 6].map(|()| vec![zero; width]);
            for j in 0..points {
                strain[0][3 * j + 2] += d[p][j];
                strain[3][3 * j] += d[p][j];
                strain[4][3 * j + 1] += d[p][j];
            }
            strain[1][v] += i * k;
            strain[1][w] += 1.0 / r[p];
            strain[2][q] += i * ky;
            strain[3][w] += i * k;
            strain[3][v] -= 1.0 / r[p];
            strain[4][w] += i * ky;
            strain[5][v] += i * ky;
            strain[5][q] += i * k;
            for column in 0..width {
                let trace = strain[0][column] + strain[1][column] + strain[2][column];
                for (kind, entries) in strain.iter().enumerate() {
                    let shear = if kind < 3 { 2.0 } else { 1.0 };
                    let volume = if kind < 3 { lambda * trace } else { zero };
                    stresses.rows[kind][p][column] = volume + mu * shear * entries[column];
                }
            }
        }
        let mut put = |row: usize, offset: usize, entries: &[Complex64], factor: f64| {
            for (column, entry) in entries.iter().enumerate() {
                system[(row, offset + column)] += entry * factor;
            }
        };
        // Equilibrium at the inner points.
        for p in 1..points - 1 {
            let k = nf / r[p];
            let over = 1.0 / r[p];
            let mut equations = [(); 3].map(|()| Vec::with_capacity(width));
            for column in 0..width {
                let at = |kind: usize| stresses.rows[kind][p][column];
                let slope =
                    |kind: usize| (0..points).map(|j| stresses.rows[kind][j][column] * d[p][j]).sum::<Complex64>();
                let along = slope(3) + i * k * at(1) + i * ky * at(5) + at(3) * (2.0 * over);
                let across = slope(4) + i * k * at(5) + i * ky * at(2) + at(4) * over;
                let outward = slope(0) + i * k * at(3) + i * ky * at(4) + (at(0) - at(1)) * over;
                equations.iter_mut().zip([along, across, outward]).for_each(|(row, entry)| row.push(entry));
            }
            // The prestress acts on the second derivatives of the displacement vector; inertia.
            let straight = -(s * s * layer.material.density + sx * k * k + sy * ky * ky);
            let hoop = sx * over * over;
            let turn = 2.0 * i * k * over * sx;
            let [v, q, w] = [3 * p, 3 * p + 1, 3 * p + 2];
            equations[0][v] += straight - hoop;
            equations[0][w] += turn;
            equations[1][q] += straight;
            equations[2][w] += straight - hoop;
            equations[2][v] -= turn;
            for equation in &equations {
                put(row, offset, equation, 1.0 / scale);
                row += 1;
            }
        }
        // Below: the foundation, or the layer before.
        let tractions = [3, 4, 0];
        if let Some((before, lower)) = &below {
            for component in 0..3 {
                let mut entries = vec![zero; 3 * points];
                entries[component] = Complex64::new(1.0, 0.0);
                put(row, offset, &entries, 1.0);
                let mut entries = vec![zero; 3 * points];
                entries[3 * (points - 1) + component] = Complex64::new(-1.0, 0.0);
                put(row, *before, &entries, 1.0);
                row += 1;
                put(row, offset, &stresses.rows[tractions[component]][0], 1.0 / scale);
                put(row, *before, &lower.rows[tractions[component]][points - 1], -1.0 / scale);
                row += 1;
            }
        } else {
            let [tangential, normal] = material::foundation_stiffness(&tyre.foundation, s);
            let inertia = s * s * tyre.sidewall_mass;
            let p = tyre.pressure;
            let air = tyre.cavity.filter(|_| m == 0).map_or(zero, |cavity| air_stiffness(&cavity, n, s));
            let impedance = [
                [tangential + inertia - p / inner, zero, i * nf * p / inner],
                [zero, tangential + inertia, i * ky * p],
                [-i * nf * p / inner, -i * ky * p, normal + inertia - p / inner + air],
            ];
            for component in 0..3 {
                put(row, offset, &stresses.rows[tractions[component]][0], 1.0 / scale);
                put(row, offset, &impedance[component].map(|entry| -entry), 1.0 / scale);
                row += 1;
            }
        }
        if number + 1 == tyre.layers.len() {
            for component in 0..3 {
                put(row, offset, &stresses.rows[tractions[component]][points - 1], 1.0 / scale);
                right[(row, component)] = Complex64::new(1.0 / scale, 0.0);
                row += 1;
            }
        }
        below = Some((offset, stresses));
        from += layer.thickness;
    }
    assert_eq!(row, unknowns);
    let solution = system.partial_piv_lu().solve(&right);
    let matrix = |first: usize| std::array::from_fn(|a| std::array::from_fn(|b| solution[(first + a, b)]));
    (matrix(unknowns - 3), matrix(0))
}

#[test]
fn curved_compliance_equals_that_of_polynomials_in_each_layer() {
    let tyre = car();
    let (mut production, mut fine) = (0.0_f64, 0.0_f64);
    for (n, m) in [(0, 0), (1, 0), (2, 1), (5, 2), (20, 1), (60, 3), (160, 1)] {
        for s in [at_frequency(30.0), at_frequency(230.0), at_frequency(1500.0), Complex64::new(3000.0, 8000.0)] {
            let (surface, bottom) = by_collocation(&tyre, n, m, s, 18);
            let (again, _) = by_collocation(&tyre, n, m, s, 24);
            let uncertainty = difference(&surface, &again);
            for (step, worst) in [(STEP, &mut production), (FINE_STEP, &mut fine)] {
                let (c, d) = tyre.compliance(n, m, s, step);
                let error = difference(&c, &surface).max(difference(&d, &bottom));
                *worst = worst.max(error - uncertainty);
            }
        }
    }
    println!("largest difference {production:.1e} at the production step, {fine:.1e} at the fine one");
    assert!(production < 2e-5 && fine < 5e-7, "{production:e} {fine:e}");
}

/// The difference is of the first order in 1/R: about 1e-4 of C at 1000 R, more where the belt resonates.
#[test]
fn a_tyre_of_many_radii_is_flat_to_the_first_order() {
    let differences = [100, 1000, 10_000].map(|stretched| {
        let mut tyre = car();
        let radius = tyre.radius;
        tyre.radius *= f64::from(stretched);
        tyre.cavity = None;
        tyre.pressure = 0.0;
        let flat = Stack::of(tyre.layers.clone(), tyre.foundation.clone());
        let mut all = Vec::new();
        for (n, m) in [(0, 1), (3, 1), (20, 2), (160, 1), (400, 5)] {
            for frequency in [50.0, 400.0, 2000.0] {
                let s = at_frequency(frequency);
                let (c, d) = tyre.compliance(n * i64::from(stretched), m, s, FINE_STEP);
                let (flat_c, flat_d) = flat.at(s).full(n as f64 / radius, m as f64 * PI / tyre.width);
                all.push(difference(&c, &flat_c).max(difference(&d, &flat_d)));
            }
        }
        all.sort_by(f64::total_cmp);
        println!("{stretched} R: median {:.1e}, largest {:.1e}", all[all.len() / 2], all[all.len() - 1]);
        [all[all.len() / 2], all[all.len() - 1]]
    });
    let [_, [median, _], [_, last]] = differences;
    assert!(median < 2e-4 && last < 1e-4, "{differences:?}");
    for pair in differences.windows(2) {
        let ratio = pair[0][1] / pair[1][1];
        assert!((9.0..11.0).contains(&ratio), "{differences:?}");
    }
}

#[test]
fn the_carcass_under_a_riding_tread_tends_to_the_flat_one() {
    let mut tyre = car();
    let (radius, stretched) = (tyre.radius, 10_000);
    tyre.radius *= f64::from(stretched);
    tyre.cavity = None;
    tyre.pressure = 0.0;
    let flat = Stack::of(tyre.layers.clone(), tyre.foundation.clone());
    let cylinder = Cylinder::of(tyre.clone(), 2e4, 1e-8);
    for (n, m) in [(0, 1), (3, 1), (20, 2), (160, 1)] {
        let wave = cylinder.wave(n * i64::from(stretched), m);
        for frequency in [0.0, 50.0, 400.0, 2000.0] {
            let s = at_frequency(frequency);
            let found = wave.under_tread(&cylinder.at(s));
            let wanted = flat.at(s).under_tread(n as f64 / radius, m as f64 * PI / tyre.width);
            assert!((found - wanted).norm() < 1e-4 * wanted.norm(), "n {n}, m {m}, {frequency} Hz: {found} {wanted}");
        }
    }
}

#[test]
fn a_curved_tyre_is_passive_and_reciprocal_on_the_hard_grid() {
    let tyre = car();
    for n in [0, 1, 7, 80, 700, 6000] {
        for m in [0, 1, 4, 40] {
            for frequency in [1.0, 100.0, 1e3, 1e4, 5e4] {
                let s = at_frequency(frequency);
                let (c, d) = tyre.compliance(n, m, s, STEP);
                assert!(c.iter().chain(&d).flatten().all(|entry| entry.is_finite()), "{n} {m} {frequency}");
                let size = c.iter().flatten().map(|entry| entry.norm()).fold(0.0, f64::max);
                for (a, row) in c.iter().enumerate() {
                    let power = s * row[a];
                    assert!(power.re >= -1e-9 * power.norm(), "{n} {m} {frequency} {a}: {power:e}");
                    for (b, entry) in row.iter().enumerate().take(a) {
                        // C at -k is the transpose of C at k; by symmetry its tangential entries change sign.
                        let sign = if a == 2 { -1.0 } else { 1.0 };
                        assert!((entry - sign * c[b][a]).norm() < 1e-6 * size, "{n} {m} {frequency} {a} {b}");
                    }
                }
            }
        }
    }
}

#[test]
fn cases_of_curved_tyres_are_evaluated_without_speed() {
    let file = |cases: &str| {
        let layers = r#"{"thickness": 0.006, "modulus": 5e8, "loss_factor": 0.08, "poisson": 0.3, "density": 1300,
            "tension": [4.3e4, 2e4]}, {"thickness": 0.013, "modulus": 6.8e6, "loss_factor": 0.25, "poisson": 0.49,
            "density": 1000}"#;
        let cavity = r#"{"radius": 0.235, "depth": 0.0825, "density": 3.84, "relaxation": 1.4e-5}"#;
        let foundation = r#"{"normal": 7.7e6, "tangential": 2.4e6, "loss_factor": 0.1}"#;
        format!(
            r#"{{"tyres": [{{"name": "car", "curved": true, "circumference": 1.95, "width": 0.136, "pressure": 1.46e5,
            "foundation": {foundation}, "cavity": {cavity}, "layers": [{layers}]}}], "cases": [{cases}]}}"#
        )
    };
    let s = at_frequency(230.0);
    let found = cases::evaluate(&file(&format!(r#"{{"tyre": "car", "n": 1, "m": 0, "s": [0.0, {}]}}"#, s.im))).unwrap();
    let (surface, bottom) = car().compliance(1, 0, s, FINE_STEP);
    for (name, wanted) in [("C", surface), ("D", bottom)] {
        for (i, row) in wanted.iter().enumerate() {
            for (j, wanted) in row.iter().enumerate() {
                let entry = &found["cases"][0][name][i][j];
                let entry = Complex64::new(entry[0].as_f64().unwrap(), entry[1].as_f64().unwrap());
                assert!((entry - wanted).norm() <= 1e-12 * wanted.norm(), "{name} {i} {j}");
            }
        }
    }
    for (case, why) in [
        (r#"{"tyre": "car", "n": 1, "m": 0, "s": [0, 1], "speed": 20}"#, "the tyre has"),
        (r#"{"tyre": "car", "kx": 1, "ky": 0, "s": [0, 1]}"#, "n and m"),
        (r#"{"tyre": "van", "n": 1, "m": 0, "s": [0, 1]}"#, "'van'"),
    ] {
        let refused = cases::evaluate(&file(case)).unwrap_err().to_string();
        assert!(refused.contains(why), "{refused}");
    }
}

/// Worst relative difference of C_zz and of D between prepared waves and steps through the layers, on a grid that has
/// the belt's resonances, the tread's thickness resonances and the right half plane.
fn differences_from_steps(tyre: &CurvedStack, largest_s: f64, tolerance: f64, step: f64) -> [f64; 2] {
    let cylinder = Cylinder::of(tyre.clone(), largest_s, tolerance);
    let axis = [60.0, 300.0, 1500.0, 5000.0, 20_000.0].map(at_frequency);
    let real = [0.0, 1e3, largest_s].map(|s| Complex64::new(s, 0.0));
    let mut worst = [0.0_f64; 2];
    for (n, m) in [(0, 0), (1, 0), (2, 6), (6, 2), (20, 0), (60, 0), (60, 14), (160, 2), (220, 6)] {
        let wave = cylinder.wave(n, m);
        for &s in axis.iter().chain(&real).filter(|s| s.norm() < 1.001 * largest_s.max(1e-9)) {
            let (c, d) = tyre.compliance(n, m, s, step);
            let at = cylinder.at(s);
            let (found_c, found_d) = wave.full(&at);
            worst[0] = worst[0].max((found_c[2][2] - c[2][2]).norm() / c[2][2].norm()).max(difference(&found_c, &c));
            worst[1] = worst[1].max((found_d[2][2] - d[2][2]).norm() / c[2][2].norm());
            let both = wave.normal(&at);
            assert!((both.surface - found_c[2][2]).norm() < 1e-12 * both.surface.norm());
            assert!((both.bottom - found_d[2][2]).norm() < 1e-9 * both.surface.norm());
        }
    }
    worst
}

#[test]
fn prepared_waves_agree_with_steps_through_the_layers() {
    for largest in [0.0, 2e4, 2.0 * PI * 20e3] {
        for tolerance in [1e-4, 1e-5] {
            let worst = differences_from_steps(&car(), largest, tolerance, FINE_STEP);
            println!("|s| up to {largest:.1e}, {tolerance:.0e}: C {:.1e}, D {:.1e}", worst[0], worst[1]);
            assert!(worst.iter().all(|&error| error < 2.0 * tolerance), "{largest:.1e}, {tolerance:.0e}: {worst:?}");
        }
    }
}

/// Without losses in the belt its prestress couples no modes, and nothing but the degree is left to be wrong.
#[test]
fn refined_waves_agree_with_finer_steps_to_many_digits() {
    let mut tyre = car();
    tyre.layers[0].material.loss_factor = 0.0;
    let worst = differences_from_steps(&tyre, 2.0 * PI * 20e3, 1e-13, 0.5 * FINE_STEP);
    println!("C {:.1e}, D {:.1e}", worst[0], worst[1]);
    assert!(worst.iter().all(|&error| error < 2e-8), "{worst:?}");
}

#[test]
fn prepared_waves_are_passive_and_reciprocal_on_a_hard_grid() {
    let largest = 2.0 * PI * 20e3;
    let cylinder = Cylinder::of(car(), largest, 1e-3);
    for n in [0, 1, 2, 7, 30, 90, 150, 217] {
        for m in [0, 1, 2, 3, 12, 30] {
            let wave = cylinder.wave(n, m);
            for step in 0..120 {
                let s = at_frequency(10f64.powf(-1.0 + 0.045 * f64::from(step)));
                let (c, _) = wave.full(&cylinder.at(s));
                let size = c.iter().flatten().map(|entry| entry.norm()).fold(0.0, f64::max);
                for (axis, row) in c.iter().enumerate() {
                    let power = s * row[axis];
                    assert!(power.re >= -1e-12 * power.norm(), "n {n}, m {m}, s {s}, axis {axis}");
                }
                // C_ij of the wave is C_ji of the one the other way round: odd where one of them is outward.
                for (i, j, sign) in [(0, 1, 1.0), (0, 2, -1.0), (1, 2, -1.0)] {
                    assert!((c[i][j] - c[j][i] * sign).norm() < 1e-9 * size, "n {n}, m {m}, s {s}");
                }
            }
        }
    }
}

/// The default tyre has what it was fitted to: stiffness, patch and load of a car tyre (elements of 1.9 mm).
#[test]
fn the_default_tyre_has_a_car_tyres_stiffness_and_patch() {
    let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
    let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, 1024), Truncation::Tail, 1e-6, 1.0);
    let row = sum.static_row(Field::Surface);
    let at_rest = StaticTyre { influence: &row, circumference: tyre.circumference };
    for (mass, length) in [(300.0, 0.097), (350.0, 0.108), (400.0, 0.118)] {
        let load = mass * 9.81;
        let contact = at_rest.under(&Axle::Load { load, tolerance: 1e-3 }).unwrap();
        let stiffness = load / contact.indentation;
        println!("{mass} kg: {stiffness:.3e} N/m, {:.1} mm", 1e3 * contact.length);
        assert!((stiffness / 1.9e5 - 1.0).abs() < 0.1, "{mass} kg: {stiffness:.3e} N/m");
        assert!((contact.length - length).abs() < 0.003, "{mass} kg: {} m", contact.length);
    }
}

/// The default tyre has the low modes that it was fitted to, and moves as a whole against its sidewalls below its own
/// ring frequency.
#[test]
fn the_default_tyre_has_a_car_tyres_modes() {
    let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
    let found = modes(&tyre, 6, 1, 600.0).unwrap().confirmed;
    for (n, frequency) in (1..).zip([68.0, 90.0, 110.0, 131.0, 155.0, 181.0]) {
        let of = |mode: &&Mode| mode.n == n && mode.motion == Motion::Radial;
        let lowest = found.iter().find(of).unwrap().frequency();
        assert!((lowest - frequency).abs() < 10.0, "n {n}: {lowest} Hz, {frequency} Hz wanted");
    }
    let is_breathing = |mode: &&Mode| mode.n == 0 && mode.motion == Motion::Radial && mode.frequency() > 400.0;
    let breathing = found.iter().filter(is_breathing).max_by(|one, other| one.peak.total_cmp(&other.peak)).unwrap();
    assert!((470.0..518.0).contains(&breathing.frequency()), "{breathing:?}");
    assert!(found.iter().any(|mode| mode.n == 1 && (mode.frequency() - 234.0).abs() < 2.0), "no mode of the air");
}

/// The car tyre on springs at rest: its modes, a belt that breathes above 400 Hz, and the speeds of its free waves.
#[test]
fn the_tyre_on_springs_has_a_car_tyres_modes() {
    let tyre = Scene::from_str(&on_springs(DEFAULT), "springs").unwrap().scene.tyre;
    let found = modes(&tyre, 32, 1, 1300.0).unwrap().confirmed;
    let near = |n: usize, motion: Motion, frequency: f64, within: f64| {
        let of = |mode: &&Mode| mode.n == n && mode.motion == motion;
        let gap = |mode: &&Mode| (mode.frequency() - frequency).abs();
        let mode = found.iter().filter(of).min_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap();
        println!("n {n}: {:.1} Hz, {frequency} Hz wanted", mode.frequency());
        assert!(gap(&mode) < within, "n {n}: {} Hz, {frequency} Hz wanted", mode.frequency());
        mode.frequency()
    };
    for (n, frequency) in (1..).zip([68.0, 90.4, 110.1, 131.7, 155.9, 182.5]) {
        near(n, Motion::Radial, frequency, 0.5);
    }
    near(0, Motion::Radial, 518.0, 2.0);
    near(0, Motion::Circumferential, 45.0, 0.5);
    near(0, Motion::Lateral, 46.5, 0.5);
    near(1, Motion::Radial, 238.5, 0.5);
    // Phase velocities [m/s] near 315, 500, 800 and 1000 Hz.
    for (n, frequency, speed) in [(10, 312.0, 61.0), (15, 515.0, 67.0), (21, 800.0, 75.0), (25, 1010.0, 79.0)] {
        let found = near(n, Motion::Radial, frequency, 40.0) * tyre.circumference / n as f64;
        assert!((found - speed).abs() < 2.0, "{found} m/s, {speed} m/s wanted");
    }
}

/// Tails of guided sides and of curved layers against sums without a tail.
#[test]
fn sums_of_guided_and_curved_tyres_agree_without_a_tail() {
    // Sums without a tail ask so many waves for the impedance of sidewalls that they take minutes.
    let curved = Scene::from_str(&on_springs(DEFAULT), "springs").unwrap().scene.tyre;
    let flat = Tyre { curvature: false, inflation: None, cavity: None, ..curved.clone() };
    for tyre in [&flat, &curved] {
        let of = |truncation| InfluenceSum::with(tyre, Projection::new(tyre, 64), truncation, 1e-6, 1e4);
        let (tail, bounded) = (of(Truncation::Tail), of(Truncation::Bounded));
        let points = [Complex64::ZERO, at_frequency(200.0), at_frequency(1000.0), Complex64::new(1e4, 0.0)];
        let at = points.map(|s| (s, tail.at(s), bounded.at(s)));
        for n in [0, 1, 5, 32] {
            let mut largest = None;
            for (s, at_tail, at_bounded) in &at {
                let (a, b) = (tail.value(n, at_tail, Field::Surface), bounded.value(n, at_bounded, Field::Surface));
                // The first is at rest.
                let error = (a.value - b.value).norm() / *largest.get_or_insert(b.value.norm());
                assert!(error < 2e-6, "curved {}, n {n}, s {s}: {error:.1e}", tyre.curvature);
                assert!(a.evaluations < b.evaluations);
            }
        }
    }
}

/// Where waves are taken as flat is a matter of tolerance: what curvature does to them is added. A sum that evaluates
/// waves of half the length one by one is what they are compared with. The default tyre's tread is the softer one, and
/// its waves are as short at lower frequencies.
#[test]
fn short_waves_do_not_depend_on_where_they_become_flat() {
    let all = [0.0, 300.0, 1000.0, 3000.0, 4500.0, 6000.0, 8000.0, 10_000.0, 14_000.0, 20_000.0];
    short_waves_are_flat_anywhere(&on_springs(DEFAULT), &all);
    short_waves_are_flat_anywhere(DEFAULT, &[0.0, 1000.0, 10_000.0]);
}

fn short_waves_are_flat_anywhere(scene: &str, frequencies: &[f64]) {
    let tyre = Scene::from_str(scene, "scene").unwrap().scene.tyre;
    let of = |tolerance| {
        let projection = Projection::new(&tyre, 1024);
        InfluenceSum::with(&tyre, projection, Truncation::Tail, tolerance, 2.0 * PI * 20e3)
    };
    let (loose, tight) = (of(1e-7), of(1e-16));
    let points = frequencies
        .iter()
        .map(|&frequency| (at_frequency(frequency), if frequency < 5000.0 { 3e-7 } else { 1e-5 }))
        .chain([(Complex64::new(3e4, 0.0), 3e-7), (Complex64::new(1.2e5, 0.0), 1e-6)]);
    for (s, bound) in points {
        let (at_loose, at_tight) = (loose.at(s), tight.at(s));
        for n in [100, 270, 300, 420, 512] {
            let (a, b) = (loose.value(n, &at_loose, Field::Surface), tight.value(n, &at_tight, Field::Surface));
            let error = (a.value - b.value).norm() / b.value.norm();
            println!("n {n}, s {s:.0}: {error:.1e}");
            assert!(error < bound, "n {n}, s {s}: {error:.1e}");
        }
    }
    let (a, b) = (loose.static_row(Field::Surface), tight.static_row(Field::Surface));
    let error = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / b[0];
    assert!(error < 1e-6, "at rest: {error:.1e}");
}

#[test]
fn the_car_tyre_has_its_modes() {
    let car = car();
    let waves: Vec<(usize, usize)> = (0..=6).map(|n| (n, 0)).collect();
    let found = modes_of(&waves, 300.0, |n, m, s| car.compliance(n as i64, m, s, STEP).0).unwrap();
    for mode in &found.confirmed {
        let (frequency, damping) = (mode.frequency(), mode.damping());
        println!(
            "n = {}: {:<15} {frequency:6.1} Hz, damping {damping:.4}, {:.3?}",
            mode.n,
            mode.motion.name(),
            mode.shares
        );
    }
    assert_eq!(found.unconfirmed, []);
    // An independent calculation, within 2 Hz.
    let is_there = |what: &str, n: usize, motion: Motion, frequency: f64| {
        let fits = |mode: &&Mode| (mode.n, mode.motion) == (n, motion) && (mode.frequency() - frequency).abs() < 2.0;
        assert_eq!(found.confirmed.iter().filter(fits).count(), 1, "{what}, {frequency} Hz");
    };
    for (n, frequency) in (1..).zip([68.0, 90.0, 109.5, 131.0, 154.5, 180.5]) {
        is_there("bending", n, Motion::Radial, frequency);
    }
    // The air rings against a belt that gives way round the tyre more than along its radius.
    is_there("cavity", 1, Motion::Circumferential, 227.0);
    is_there("breathing", 0, Motion::Radial, 245.0);
    is_there("torsion", 0, Motion::Circumferential, 47.0);
    is_there("lateral", 0, Motion::Lateral, 48.0);
}
