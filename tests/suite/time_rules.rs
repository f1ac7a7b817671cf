//! Time rules side by side: order, stability of the inverse, and the hard cases of the model that touch them.

use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

use num_complex::Complex64;
use tyrewave::counters::Meter;
use tyrewave::internals::{
    AxleHeight, CIRCUMFERENCE, ContactError, ContactKernel, EqualBedding, FitOptions, ForceHistory, Geometry, March,
    ModalHistory, RationalModel, RoadStrip, SliceLaw, fetch_model as fetch, scene, scene_text, unstable_zero,
};
use tyrewave::road::SliceBuilder;
use tyrewave::scene::{TimeRule, Tread};
use tyrewave::tyre::Field;

use crate::common::{mean_and_deviation, run, try_run};

const SMOOTH: &str = "kind = \"smooth\"";
const INDENTED: &str = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.15\naxle = { indentation = 0.012, ramp = 0.03 }";

/// Poles of the default tyre with N elements.
fn model(elements: usize, speed: f64, tolerance: f64) -> RationalModel {
    let loaded = scene(&scene_text(elements, SMOOTH, INDENTED, "", ""));
    let options = FitOptions::new(&loaded.scene.tyre, elements, speed).with_tolerance(tolerance);
    fetch(&loaded.scene.tyre, &options, &AtomicBool::new(false)).unwrap().model
}

/// The total force over `duration` \[s\] on a smooth road at 12 mm of indentation, without the program's refusals.
fn smooth_road(
    model: &RationalModel,
    rule: TimeRule,
    speed_kmh: f64,
    substeps: usize,
    duration: f64,
) -> Result<Vec<f64>, ContactError> {
    let elements = model.elements;
    let mut numerics = scene(&scene_text(elements, SMOOTH, INDENTED, "", "")).scene.numerics;
    numerics.time_rule = rule;
    let speed = speed_kmh / 3.6;
    let time_step = CIRCUMFERENCE / elements as f64 / (speed * substeps as f64);
    let geometry = Geometry::new(CIRCUMFERENCE, elements, substeps, 0.0, 0.11);
    let first = ModalHistory::first_weights(model, Field::Surface, rule, time_step).unwrap();
    let kernel = ContactKernel::new(Tread::Elastic, [&first, &[]], elements, EqualBedding::NONE)?;
    let history = ModalHistory::new(model, Field::Surface, rule, time_step, model.elements).unwrap();
    let mut march = March::new(geometry, kernel, SliceLaw::Explicit, Box::new(history), &numerics, time_step);
    let axle = AxleHeight::Fixed { indentation: 0.012, ramp: 0.05 / time_step };
    let mut slices = RoadStrip::starting_at(march.geometry().first_element(0));
    let flat = SliceBuilder::flat(1).unwrap().build_rows(&[0.0]).unwrap();
    let steps = (duration / time_step) as u64;
    let mut force = Vec::new();
    for step in 0..steps {
        let first = march.geometry().first_element(step);
        slices.forget_before(first);
        while slices.end() < first + march.geometry().columns as i64 {
            slices.extend(flat.iter().cloned());
        }
        force.push(march.step(&axle, &slices, &mut Meter::default())?.total_force);
    }
    Ok(force)
}

/// std/mean of the last third.
fn relative_variation(force: &[f64]) -> f64 {
    let (mean, deviation) = mean_and_deviation(&force[force.len() * 2 / 3..]);
    deviation / mean
}

/// The time step \[s\].
fn time_step(elements: usize, speed_kmh: f64, substeps: usize) -> f64 {
    CIRCUMFERENCE / elements as f64 / (speed_kmh / 3.6 * substeps as f64)
}

#[test]
fn rules_are_steady_on_a_smooth_road_with_one_mean_force() {
    let model = model(256, 80.0 / 3.6, 1e-6);
    let mut means = Vec::new();
    for rule in TimeRule::ALL {
        let found = unstable_zero(&model, Field::Surface, rule, time_step(256, 80.0, 1), 0.0).unwrap();
        let first = ModalHistory::first_weights(&model, Field::Surface, rule, time_step(256, 80.0, 1)).unwrap();
        assert!(found.is_none() && first.iter().all(|weight| *weight > 0.0), "{rule:?}: {found:?}");
        let force = smooth_road(&model, rule, 80.0, 1, 0.6).unwrap();
        println!(
            "{rule:?}: mean {:.2} N, std/mean {:.1e}",
            mean_and_deviation(&force[force.len() * 2 / 3..]).0,
            relative_variation(&force)
        );
        assert!(relative_variation(&force) < 1e-4, "{rule:?}: {:e}", relative_variation(&force));
        means.push(mean_and_deviation(&force[force.len() * 2 / 3..]).0);
    }
    // Converged in the time step: 2769.2 N. First order differs most.
    for (rule, mean) in TimeRule::ALL.iter().zip(&means) {
        assert!((mean / 2769.2 - 1.0).abs() < 2e-3, "{rule:?}: {mean}");
    }
}

#[test]
fn direct_sums_refuse_rules_of_several_stages() {
    for rule in ["sdirk2", "sdirk3"] {
        let text = scene_text(64, SMOOTH, INDENTED, &format!("time_rule = \"{rule}\"\nhistory = \"direct\""), "");
        let refused = try_run(&scene(&text)).err().unwrap().to_string();
        assert!(refused.contains("history = \"modal\"") && refused.contains(rule), "{refused}");
    }
}

/// Response at element 0 to a force on it, summed over the wavenumbers.
fn driving_point(model: &RationalModel, s: Complex64) -> Complex64 {
    let last = model.largest_wavenumber();
    let weight = |n: usize| if n == 0 || n == last { 1.0 } else { 2.0 };
    (0..=last).map(|n| weight(n) * model.evaluate(n, s, Field::Surface).unwrap()).sum()
}

/// Displacements of element 0 at all stages of all steps under a force on it given stage by stage.
fn driven(model: &RationalModel, rule: TimeRule, time_step: f64, force: impl Fn(f64) -> f64, steps: usize) -> Vec<f64> {
    let first = ModalHistory::first_weights(model, Field::Surface, rule, time_step).unwrap();
    let kernel = ContactKernel::new(Tread::Elastic, [&first, &[]], model.elements, EqualBedding::NONE).unwrap();
    let mut history = ModalHistory::new(model, Field::Surface, rule, time_step, model.elements).unwrap();
    let mut displacement = Vec::new();
    for step in 0..steps {
        for node in rule.nodes() {
            let mut old = [0.0];
            history.displacement(0, &mut old, &mut Meter::default());
            let force = force(step as f64 - 1.0 + node);
            history.push(0, &[force]);
            displacement.push(old[0] + kernel.instant[0] * force);
        }
    }
    displacement
}

#[test]
fn runge_kutta_recursion_is_the_quadrature_with_matrix_weights() {
    // W_p from H(Delta(zeta)/dt) on a circle: a function of a matrix in Newton's form on its eigenvalues.
    let (model, time_step, lags) = (model(16, 80.0 / 3.6, 1e-4), 3e-4, 64);
    for rule in [TimeRule::Sdirk2, TimeRule::Sdirk3] {
        let method = rule.runge_kutta().unwrap();
        let s = method.nodes.len();
        let mut a = [[0.0; 3]; 3];
        let [a21, a31, a32] = method.below;
        (a[1][0], a[2][0], a[2][1]) = (a21, a31, a32);
        for (i, row) in a.iter_mut().enumerate() {
            row[i] = method.gamma;
        }
        let length = 2 * lags;
        let radius = 1e-12_f64.powf(1.0 / length as f64);
        let mut weights = vec![[[0.0; 3]; 3]; lags];
        for k in 0..length {
            let zeta = Complex64::from_polar(radius, -2.0 * PI * k as f64 / length as f64);
            let m = Matrix::from_fn(s, |i, j| a[i][j] + zeta / (1.0 - zeta) * method.weights()[j]);
            let delta = m.inverse();
            let rates = rule.rates(zeta);
            let mu = rates.all();
            let h: Vec<Complex64> = mu.iter().map(|rate| driving_point(&model, rate / time_step)).collect();
            let first = (h[1] - h[0]) / (mu[1] - mu[0]);
            let shifted = |rate: Complex64| {
                Matrix::from_fn(s, |i, j| delta.0[i][j] - if i == j { rate } else { Complex64::ZERO })
            };
            let mut value =
                Matrix::from_fn(s, |i, j| if i == j { h[0] } else { Complex64::ZERO } + first * shifted(mu[0]).0[i][j]);
            if s == 3 {
                let second = ((h[2] - h[1]) / (mu[2] - mu[1]) - first) / (mu[2] - mu[0]);
                let product = shifted(mu[0]).times(&shifted(mu[1]));
                value = Matrix::from_fn(s, |i, j| value.0[i][j] + second * product.0[i][j]);
            }
            for (p, weight) in weights.iter_mut().enumerate() {
                let factor = Complex64::from_polar(
                    radius.powi(-(p as i32)) / length as f64,
                    2.0 * PI * (k * p) as f64 / length as f64,
                );
                for (row, values) in weight.iter_mut().zip(&value.0) {
                    for (entry, value) in row.iter_mut().zip(values) {
                        *entry += (value * factor).re;
                    }
                }
            }
        }
        let force = |time: f64| (7.3 * time).sin() + (2.9 * time * time).cos();
        let found = driven(&model, rule, time_step, force, lags);
        let peak = found.iter().fold(0.0_f64, |a, u| a.max(u.abs()));
        let mut worst = 0.0_f64;
        for step in 0..lags {
            for i in 0..s {
                let mut expected = 0.0;
                for (p, weight) in weights.iter().take(step + 1).enumerate() {
                    for (entry, node) in weight[i].iter().zip(method.nodes) {
                        expected += entry * force((step - p) as f64 - 1.0 + node);
                    }
                }
                worst = worst.max((expected - found[step * s + i]).abs() / peak);
            }
        }
        println!("{rule:?}: {worst:.1e}");
        assert!(worst < 1e-8, "{rule:?}: {worst:e}");
    }
}

struct Matrix([[Complex64; 3]; 3]);

impl Matrix {
    /// The leading s x s part; unit entries on the rest of the diagonal.
    fn from_fn(s: usize, entry: impl Fn(usize, usize) -> Complex64) -> Self {
        let mut rows = [[Complex64::ZERO; 3]; 3];
        for (i, row) in rows.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                *value = if i < s && j < s {
                    entry(i, j)
                } else if i == j {
                    Complex64::ONE
                } else {
                    Complex64::ZERO
                };
            }
        }
        Self(rows)
    }

    fn times(&self, other: &Self) -> Self {
        Self::from_fn(3, |i, j| (0..3).map(|k| self.0[i][k] * other.0[k][j]).sum())
    }

    /// By cofactors.
    fn inverse(&self) -> Self {
        let m = &self.0;
        let minor = |i: usize, j: usize| {
            let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
            m[a][c] * m[b][d] - m[a][d] * m[b][c]
        };
        let determinant: Complex64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
        Self::from_fn(3, |i, j| minor(j, i) / determinant)
    }
}

#[test]
fn every_rule_has_its_order_for_a_smooth_force_on_the_tyre() {
    // F = x^6 exp(-x), x = t/T, on one element: u by partial fractions in closed form.
    let model = model(16, 80.0 / 3.6, 1e-4);
    let scale = 4e-3;
    let exact = |t: f64| -> f64 {
        let last = model.largest_wavenumber();
        let mut sum = 0.0;
        for n in 0..=last {
            let modes = model.modes(n, Field::Surface).unwrap();
            for (index, (&pole, &residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
                // Integral of exp(lambda (t - tau)) (tau/T)^6 exp(-tau/T), by parts: -sum_k (6!/k!) x^k
                // e^-x/kappa^(7-k) + 6!/kappa^7 e^(lambda t).
                let kappa = 1.0 + pole * scale;
                let x = t / scale;
                // 6!/kappa^7 times what the exponential series of kappa x has beyond its first seven terms: summed as
                // such where little is left of the difference.
                let z = kappa * x;
                let (mut term, mut head, mut tail) = (Complex64::ONE, Complex64::ZERO, Complex64::ZERO);
                for k in 0..40 {
                    if k > 0 {
                        term *= z / f64::from(k);
                    }
                    if k <= 6 {
                        head += term;
                    } else {
                        tail += term;
                    }
                }
                let beyond = if z.norm() < 3.0 { (-x).exp() * tail } else { (pole * t).exp() - (-x).exp() * head };
                let value = 720.0 * scale / kappa.powi(7) * beyond;
                let weight = if n == 0 || n == last { 1.0 } else { 2.0 };
                sum += weight * modes.multiplicity(index) * (residue * value).re;
            }
        }
        sum
    };
    let force = |x: f64| if x > 0.0 { x.powi(6) * (-x).exp() } else { 0.0 };
    for (rule, order) in TimeRule::ALL.into_iter().zip([1.0, 2.0, 2.0, 3.0]) {
        let error = |steps: usize| {
            let time_step = 0.04 / steps as f64;
            let found = driven(&model, rule, time_step, |l| force(l * time_step / scale), steps + 1);
            let stages = rule.nodes().len();
            let (mut worst, mut peak) = (0.0_f64, 0.0_f64);
            for step in 0..=steps {
                let u = exact(step as f64 * time_step);
                peak = peak.max(u.abs());
                worst = worst.max((found[step * stages + stages - 1] - u).abs());
            }
            worst / peak
        };
        let (coarse, fine) = (error(320), error(640));
        println!("{rule:?}: {coarse:.1e} {fine:.1e}, order {:.2}", (coarse / fine).log2());
        assert!(((coarse / fine).log2() - order).abs() < 0.25, "{rule:?}: {coarse:e} {fine:e}");
    }
}

#[test]
fn hard_cases_6_speeds_and_steps_with_runge_kutta_rules() {
    for rule in ["bdf2", "sdirk2", "sdirk3"] {
        for (elements, substeps, speed, duration) in [
            (64, 1, 1.0, 6.0),
            (64, 1, 30.0, 0.4),
            (64, 1, 130.0, 0.3),
            (16, 1, 80.0, 0.3),
            (64, 16, 80.0, 0.1),
            (64, 1, 400.0, 0.03),
        ] {
            let rolling = format!(
                "speed_kmh = {speed:?}\nwarm_up = 0.05\nduration = {duration:?}\n\
                 axle = {{ indentation = 0.012, ramp = 0.03 }}"
            );
            let numerics = format!("substeps = {substeps}\ntime_rule = \"{rule}\"\nhistory = \"modal\"");
            let results = run(&scene_text(elements, SMOOTH, &rolling, &numerics, ""));
            let force = results.array("total_force.npy");
            assert!(force.iter().all(|force| force.is_finite()), "{rule} {speed}");
            assert_eq!(results.report.summary.contact.aborted_searches, 0);
            assert!(results.report.summary.contact.penetration <= 1e-9);
            // sdirk3 has a negative weight: its mean force of a step may be negative for an element, the others' may
            // not.
            if rule != "sdirk3" {
                results.assert_sound(&format!("{rule}, {speed} km/h, N = {elements}, q = {substeps}"));
            }
        }
    }
}

#[test]
#[ignore = "every rule, three cases: a minute"]
fn every_rule_on_a_smooth_road_at_80_and_250_km_h() {
    for (n, speed) in [(256, 80.0), (256, 250.0), (512, 80.0)] {
        let model = model(n, speed / 3.6 * 4.0, 1e-6);
        for rule in TimeRule::ALL {
            for q in [1, 2, 4] {
                let found = unstable_zero(&model, Field::Surface, rule, time_step(n, speed, q), 0.0).unwrap();
                match smooth_road(&model, rule, speed, q, 0.6) {
                    Ok(force) => println!(
                        "{n} {speed} {rule:?} q {q}: mean {:.2}, unrest {:.1e}, {found:?}",
                        mean_and_deviation(&force[force.len() * 2 / 3..]).0,
                        relative_variation(&force)
                    ),
                    Err(error) => println!("{n} {speed} {rule:?} q {q}: {error}, {found:?}"),
                }
            }
        }
    }
}
