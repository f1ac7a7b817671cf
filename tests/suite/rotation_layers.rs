//! Curved layers that turn: against values of 20 digits, rotating rings, and what holds of any rotating structure.

use std::f64::consts::PI;

use num_complex::Complex64;
use serde_json::Value;
use tyrewave::internals::{CurvedStack, Cylinder, Matrix3, Rotation, STEP, cases, growth, reference};
use tyrewave::scene::{DEFAULT, Foundation, Law, Layer, Material, Scene};

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
        let (_, stack) = tyres.iter().find(|(other, _)| other == name).unwrap();
        let (n, m) = (case["n"].as_i64().unwrap(), case["m"].as_u64().unwrap() as usize);
        let s = complex(&case["s"]);
        let computed = &ours["cases"][index];
        let cylinder = Cylinder::of(stack.clone(), LARGEST_S, TOLERANCE);
        let (wave, at) = (cylinder.wave(n.abs(), m), cylinder.at(s));
        let ways = [
            (matrix(&computed["C"]), matrix(&computed["D"])),
            stack.compliance(n, m, s, STEP),
            if n < 0 { wave.full_backwards(&at) } else { wave.full(&at) },
        ];
        let errors = ways.map(|(surface, bottom)| error(&surface, &c).max(error(&bottom, &d)));
        println!("{name}, n {n}, m {m}, s {s}: {errors:?}");
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = worst.max(error);
        }
    }
    assert!(worst[0] < 1e-8 && worst[1] < 3e-5 && worst[2] < 3e-5, "{worst:?}");
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

/// A tyre of the reference, turning.
fn turning(name: &str) -> CurvedStack {
    let tyres = cases::curved_tyres(&references().to_string()).unwrap();
    tyres.into_iter().find(|(other, _)| other == name).unwrap().1
}

const TURNING: [&str; 3] = ["isotropic, 250 km/h", "cord belt, 250 km/h", "engineering constants, 250 km/h"];

#[test]
fn prepared_waves_equal_steps_through_the_layers() {
    for name in TURNING {
        let stack = turning(name);
        let cylinder = Cylinder::of(stack.clone(), LARGEST_S, 1e-6);
        for (frequency, allowed) in [(30.0, 1e-6), (500.0, 2e-6), (2000.0, 3e-5), (6e3, 1e-5), (1e4, 2e-5)] {
            let (at, mut errors) = (cylinder.at(at_frequency(frequency)), Vec::new());
            for (n, m) in [(0, 1), (1, 0), (3, 0), (8, 1), (20, 4), (60, 0), (100, 4), (150, 10)] {
                let wave = cylinder.wave(n, m);
                for (n, found) in [(n, wave.full(&at)), (-n, wave.full_backwards(&at))] {
                    let (exact, bottom) = stack.compliance(n, m, at_frequency(frequency), 0.2);
                    let below = error(&found.1, &bottom) * norm(&bottom) / norm(&exact);
                    errors.push(error(&found.0, &exact).max(below));
                }
            }
            errors.sort_by(f64::total_cmp);
            let worst = errors[errors.len() - 1];
            println!("{name}, {frequency} Hz: {worst:.1e}, median {:.1e}", errors[errors.len() / 2]);
            assert!(worst < allowed, "{name}, {frequency} Hz: {worst:.1e}");
        }
    }
}

#[test]
fn the_wave_back_is_the_wave_of_the_other_rotation_transposed() {
    for name in TURNING {
        let stack = turning(name);
        let mut reversed = stack.clone();
        reversed.rotation.angular_velocity *= -1.0;
        for (n, m) in [(0, 1), (1, 0), (5, 2), (40, 1)] {
            for s in [at_frequency(100.0), at_frequency(3000.0), Complex64::new(2000.0, 0.0), Complex64::new(3e3, 8e3)]
            {
                let (c, _) = stack.compliance(n, m, s, STEP);
                // In a mirror across the width: -m is m with the lateral motion turned round.
                let back = reversed.compliance(-n, m, s, STEP).0;
                let sign = |i: usize| if i == 1 { -1.0 } else { 1.0 };
                let transposed: Matrix3 =
                    std::array::from_fn(|i| std::array::from_fn(|j| back[j][i] * (sign(i) * sign(j))));
                assert!(error(&transposed, &c) < 1e-8, "{name}, n {n}, m {m}, s {s}: reciprocity");
                // C(n, s; -Om) = C(n, s*; Om)^H.
                let other = reversed.compliance(n, m, s, STEP).0;
                let conjugate = stack.compliance(n, m, s.conj(), STEP).0;
                let adjoint: Matrix3 = std::array::from_fn(|i| std::array::from_fn(|j| conjugate[j][i].conj()));
                assert!(error(&adjoint, &other) < 1e-8, "{name}, n {n}, m {m}, s {s}: reality");
            }
        }
    }
}

#[test]
fn at_real_s_parts_are_real_and_the_odd_one_is_bounded() {
    for name in TURNING {
        let stack = turning(name);
        let omega = stack.rotation.angular_velocity;
        let cylinder = Cylinder::of(stack, LARGEST_S, TOLERANCE);
        for (n, m) in [(0, 0), (1, 0), (2, 1), (7, 0), (60, 2), (160, 0)] {
            let wave = cylinder.wave(n, m);
            for s in [1e3, 8823.5, 3e4] {
                let [forwards, backwards] = wave.normal_both_ways(&cylinder.at(s.into())).map(|normal| normal.surface);
                assert!((forwards.conj() - backwards).norm() < 1e-12 * forwards.norm(), "{name}, n {n}, s {s}");
                assert!(forwards.re > 0.0);
                assert!(forwards.im.abs() <= 2.0 * omega / s * forwards.re, "{name}, n {n}, s {s}: {forwards}");
                assert!(n > 0 || forwards.im.abs() < 1e-12 * forwards.re);
            }
        }
    }
}

/// Re (s C) is not negative as long as the softened stiffness is positive: below 119.8 m/s.
#[test]
fn turning_tyres_are_passive_below_their_limit_and_not_beyond() {
    let at_speed = |speed: f64| {
        let mut stack = turning("cord belt, 250 km/h");
        stack.sidewall_mass = 0.0;
        stack.rotation = stack.turning(speed / stack.radius);
        stack
    };
    let least = |stack: &CurvedStack, points: &[(i64, usize, f64)]| {
        let mut least = f64::INFINITY;
        for &(n, m, frequency) in points {
            let s = at_frequency(frequency) + 1e-3;
            let (c, _) = stack.compliance(n, m, s, STEP);
            for (axis, row) in c.iter().enumerate() {
                least = least.min((s * row[axis]).re / (s * row[axis]).norm());
            }
        }
        least
    };
    let mut grid = Vec::new();
    for n in [0, 1, -1, 2, -2, 5, -5, 20, -20, 90, -90] {
        for frequency in [0.1, 3.0, 30.0, 100.0, 300.0, 1500.0, 6000.0] {
            grid.extend([0, 1, 4].map(|m| (n, m, frequency)));
        }
    }
    for speed in [30.0, 69.444, 110.0] {
        let found = least(&at_speed(speed), &grid);
        println!("{speed} m/s: {found:.3}");
        assert!(found > 0.0, "{speed} m/s: {found}");
    }
    let slow: Vec<_> = [0.01, 0.1, 1.0, 3.0].into_iter().flat_map(|f| [(1, 0, f), (-1, 0, f)]).collect();
    let found = least(&at_speed(125.0), &slow);
    println!("125 m/s: {found:.3}");
    assert!(found < 0.0, "{found}");
}

/// A pattern that stands on the ground, s = i n Om: inertia, Coriolis force and softening of the growth's tension
/// nearly cancel, where Om has the right sign; its moduli are those at that frequency. Compliances over that at rest, s
/// = 0.
#[test]
fn a_pattern_frozen_to_the_ground_hardly_feels_rotation() {
    let mut stack = turning("cord belt, 250 km/h");
    (stack.sidewall_mass, stack.cavity) = (0.0, None);
    let resting = CurvedStack { rotation: Rotation::default(), ..stack.clone() };
    stack.rotation = resting.turning(69.444 / stack.radius);
    let mut reversed = stack.clone();
    reversed.rotation.angular_velocity *= -1.0;
    let of = |stack: &CurvedStack, n, s| stack.compliance(n, 0, s, STEP).0[2][2].norm();
    for (n, right, turned) in [(2, 0.815, 9.42), (5, 0.929, 1.33)] {
        let s = Complex64::new(0.0, n as f64 * stack.rotation.angular_velocity);
        let found = [&stack, &reversed].map(|stack| of(stack, n, s) / of(&resting, n, Complex64::ZERO));
        println!("n {n}: {found:?}");
        assert!((found[0] - right).abs() < 1e-3 && (found[1] / turned - 1.0).abs() < 4e-3, "n {n}: {found:?}");
    }
}

#[test]
fn at_rest_nothing_changes() {
    let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
    assert_eq!(growth(&tyre).to_bits(), 0);
    let mut stack = CurvedStack::new(&tyre);
    assert_eq!(stack.rotation, Rotation::default());
    let s = Complex64::new(300.0, 2500.0);
    let resting = stack.compliance(7, 2, s, STEP);
    let from = stack.inner_radius();
    let of_layer = stack.layers[0].tension.map(|tension| tension / stack.layers[0].thickness);
    assert_eq!(stack.rotation.prestress(&stack.layers[0], from).map(f64::to_bits), of_layer.map(f64::to_bits));
    stack.rotation = stack.turning(0.0);
    assert_eq!(stack.compliance(7, 2, s, STEP), resting);
    let mut turning = tyre;
    turning.angular_velocity = -30.556 / turning.radius();
    assert!(growth(&turning) > 1e-4 && growth(&turning) < 1e-3);
    // The limit of a slow rotation.
    stack.rotation = stack.turning(1e-6);
    assert!(error(&stack.compliance(7, 2, s, STEP).0, &resting.0) < 1e-8);
}

#[test]
fn bad_speeds_and_speeds_of_a_flat_tyre_are_refused() {
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut document = references();
        document["cases"].as_array_mut().unwrap().truncate(1);
        document["tyres"].as_array_mut().unwrap().truncate(1);
        change(&mut document);
        cases::evaluate(&document.to_string()).unwrap_err().to_string()
    };
    assert!(refused(&|document| document["tyres"][0]["speed"] = (-3.0).into()).contains("not negative"));
    assert!(refused(&|document| document["tyres"][0]["centrifugal_tension"] = "own".into()).contains("given"));
    assert!(refused(&|document| document["cases"][0]["speed"] = 3.0.into()).contains("the tyre has"));
    let flat = r#"{"tyres": [{"name": "a", "speed": 20, "layers": [{"thickness": 0.01, "material": {"law": "elastic",
        "modulus": 1e7, "poisson": 0.4, "density": 1e3}}], "foundation": {"normal": 1e6, "tangential": 1e6}}],
        "cases": []}"#;
    assert!(cases::evaluate(flat).unwrap_err().to_string().contains("flat tyre has no speed"));
}

/// A ring of no bending stiffness: membrane stiffness \[N/m\], tension \[N/m\] and mass \[kg/m^2\] on a foundation.
#[derive(Clone, Copy)]
struct Ring {
    membrane: f64,
    tension: f64,
    mass: f64,
    pressure: f64,
    normal: f64,
    tangential: f64,
    sidewall_mass: f64,
    radius: f64,
    omega: f64,
}

impl Ring {
    /// Stiffness over V, w at s = i w: VV, Vw, ww; real.
    fn stiffness(&self, n: f64, w: f64) -> [f64; 3] {
        let Self { membrane, tension, mass, pressure, normal, tangential, sidewall_mass, radius, omega } = *self;
        let (squared, hoop, mass) = (radius * radius, pressure / radius, mass + sidewall_mass);
        let inertia = -mass * (w * w + omega * omega);
        let both = tension * (n * n + 1.0) / squared - hoop + inertia;
        [
            membrane * n * n / squared + both + tangential,
            (membrane + 2.0 * tension) * n / squared - n * hoop - 2.0 * mass * omega * w,
            membrane / squared + both + normal,
        ]
    }

    /// C_ww at s = i w.
    fn compliance(&self, n: f64, w: f64) -> f64 {
        let [a, b, c] = self.stiffness(n, w);
        a / (a * c - b * b)
    }

    /// Frequencies \[rad/s\] of free waves, of both signs: those back are of -n.
    fn branches(&self, n: f64) -> Vec<f64> {
        let determinant = |w: f64| {
            let [a, b, c] = self.stiffness(n, w);
            a * c - b * b
        };
        let grid: Vec<f64> = (-20_000..=20_000).map(|i| f64::from(i) * 1.000_1).collect();
        let crossing = |pair: &[f64]| {
            let (mut low, mut high) = (pair[0], pair[1]);
            (determinant(low) * determinant(high) < 0.0).then(|| {
                for _ in 0..80 {
                    let middle = 0.5 * (low + high);
                    if determinant(low) * determinant(middle) < 0.0 { high = middle } else { low = middle }
                }
                0.5 * (low + high)
            })
        };
        grid.windows(2).filter_map(crossing).collect()
    }

    /// A layer so thin that it is the ring, of a given tension.
    fn layer(&self, thickness: f64) -> CurvedStack {
        let material = Material {
            law: Law::Elastic,
            // Strains across are held.
            modulus: self.membrane / thickness * (1.0 - 0.09),
            loss_factor: 0.0,
            poisson: 0.3,
            density: self.mass / thickness,
            reference_frequency: Material::REFERENCE_FREQUENCY,
            corner_frequency: Material::CORNER_FREQUENCY,
            weights: Vec::new(),
            times: Vec::new(),
        };
        let layer = Layer {
            name: "ring".into(),
            thickness,
            tension: [self.tension, 0.0],
            material,
            cords: Vec::new(),
            orthotropic: None,
        };
        let foundation = Foundation {
            normal: self.normal,
            tangential: self.tangential,
            loss_factor: 0.0,
            reference_frequency: Material::REFERENCE_FREQUENCY,
            corner_frequency: Material::CORNER_FREQUENCY,
        };
        CurvedStack {
            layers: vec![layer],
            foundation,
            radius: self.radius + 0.5 * thickness,
            width: 0.2,
            pressure: self.pressure,
            sidewall: None,
            sidewall_mass: self.sidewall_mass,
            cavity: None,
            rotation: Rotation::of_given_tension(self.omega),
        }
    }
}

fn ring(speed: f64) -> Ring {
    let radius = 0.3;
    Ring {
        membrane: 3e6,
        tension: 4e4,
        mass: 12.0,
        pressure: 1.2e5,
        normal: 3e6,
        tangential: 1e6,
        sidewall_mass: 1.5,
        radius,
        omega: speed / radius,
    }
}

#[test]
fn a_thin_layer_is_the_rotating_ring_on_all_four_branches() {
    for speed in [22.2, 69.4] {
        let ring = ring(speed);
        let mut worst = 0.0_f64;
        for n in 0..=6_i64 {
            let branches = ring.branches(n as f64);
            assert_eq!(branches.len(), 4, "n {n}: {branches:?}");
            for w in branches {
                // Beside each resonance, and far off.
                for w in [1.01 * w, 1.5 * w] {
                    let s = Complex64::new(0.0, w);
                    // The limit of no thickness, from two of it.
                    let [thick, thin] = [1e-5, 5e-6].map(|h| ring.layer(h).compliance(n, 0, s, STEP).0[2][2]);
                    let found = thin * 2.0 - thick;
                    let wanted = ring.compliance(n as f64, w);
                    let off = (found - wanted).norm() / wanted.abs();
                    worst = worst.max(off);
                }
            }
        }
        println!("{speed} m/s: {worst:.1e}");
        assert!(worst < 2e-5, "{speed} m/s: {worst:.1e}");
    }
}

/// w = 2 n Om/(n^2 + 1) +- sqrt(w_0^2 + Om^2 n^2 (n^2 - 1)^2/(n^2 + 1)^2) of a ring that does not stretch, with the
/// tension of its rotation; w_0 at rest.
#[test]
fn waves_of_a_nearly_inextensional_ring_split_by_rotation() {
    let mut errors = Vec::new();
    for membrane in [1e9, 1e11] {
        let ring = Ring { membrane, ..Ring { sidewall_mass: 0.0, ..ring(69.4) } };
        // Its bending is that of a ring a hundredth as stiff.
        let mut stack = ring.layer(2e-6 * (1e9 / membrane));
        stack.rotation = stack.turning(ring.omega);
        let mut worst = 0.0_f64;
        for n in 1..=4_i64 {
            let (nf, squared) = (n as f64, (n * n) as f64);
            let [a, b, c] = Ring { omega: 0.0, membrane: 0.0, ..ring }.stiffness(nf, 0.0);
            let resting = (a - 2.0 * nf * b + squared * c) / (ring.mass * (squared + 1.0));
            let shift = 2.0 * nf * ring.omega / (squared + 1.0);
            let stiffened = ring.omega * nf * (squared - 1.0) / (squared + 1.0);
            let half = (resting + stiffened * stiffened).sqrt();
            for wanted in [shift + half, shift - half] {
                // The zero of 1/C by the secant.
                let impedance = |w: f64| stack.compliance(n, 0, Complex64::new(0.0, w), STEP).0[2][2].inv().re;
                let (mut before, mut now) = (wanted * 1.001, wanted * 0.999);
                for _ in 0..12 {
                    let [last, value] = [before, now].map(impedance);
                    if (value - last).abs() < 1e-300 || (now - before).abs() < 1e-12 * now.abs() {
                        break;
                    }
                    (before, now) = (now, now - value * (now - before) / (value - last));
                }
                worst = worst.max((now - wanted).abs() / wanted.abs());
            }
        }
        println!("membrane {membrane:.0e} N/m: {worst:.1e}");
        errors.push(worst);
    }
    assert!(errors[0] < 5e-4 && errors[1] < 5e-6, "{errors:?}");
}
