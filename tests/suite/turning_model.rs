//! Rational models of a tyre that turns, against exact values of waves with the rotation and against it.

use std::f64::consts::PI;

use num_complex::Complex64;
use tyrewave::internals::{
    Direction, FitOptions, Motion, RationalModel, fit, modes, on_springs, pole_key as key, slowest_wave_below,
};
use tyrewave::scene::{DEFAULT, Scene, Tyre};
use tyrewave::tyre::{FaceValues, Field, InfluenceSum, Projection, Truncation};

/// The car tyre on springs, whose waves are known, at a speed \[km/h\], elements counted against its rotation.
fn turning(speed: f64) -> Tyre {
    turned(&on_springs(DEFAULT), speed)
}

fn turned(scene: &str, speed: f64) -> Tyre {
    let mut tyre = Scene::from_str(scene, "turned").unwrap().scene.tyre;
    tyre.angular_velocity = -speed / 3.6 / tyre.radius();
    tyre
}

fn options(tyre: &Tyre, tolerance: f64) -> FitOptions {
    FitOptions { top: 2.0 * PI * 8e3, ..FitOptions::new(tyre, 24, 0.0).with_tolerance(tolerance) }
}

fn fitted(tyre: &Tyre, tolerance: f64) -> RationalModel {
    fit(tyre, &options(tyre, tolerance)).unwrap()
}

#[test]
fn both_directions_keep_the_tolerance_and_are_passive() {
    let springs = on_springs(DEFAULT);
    for (scene, speed, tolerance) in [(&*springs, 80.0, 1e-5), (&*springs, 250.0, 1e-4), (DEFAULT, 80.0, 1e-5)] {
        let tyre = turned(scene, speed);
        let options = options(&tyre, tolerance);
        let model = fit(&tyre, &options).unwrap();
        let sum = InfluenceSum::with(
            &tyre,
            Projection::new(&tyre, options.elements),
            Truncation::Tail,
            options.influence_tolerance,
            options.top,
        );
        let mut points: Vec<_> =
            (0..150).map(|k| Complex64::new(0.0, options.top * 1e-4f64.powf(f64::from(k) / 149.3))).collect();
        let on_axis = points.len();
        points.extend((1..15).map(|k| Complex64::new(options.top * 0.6f64.powi(k), 0.0)));
        let at: Vec<_> = points.iter().map(|&s| sum.at(s)).collect();
        let mut split = 0.0_f64;
        for n in 0..=model.largest_wavenumber() {
            let mut exact: Vec<FaceValues> = Vec::new();
            sum.faces(n, &at, Field::Surface, &mut exact);
            let modes = model.modes(n, Field::Surface).unwrap();
            let mean = |s| (modes.evaluate(s).norm_sqr() + modes.evaluate_odd(s).norm_sqr()).sqrt();
            let scan = (0..2000).map(|k| mean(Complex64::new(0.0, options.top * 1e-4f64.powf(f64::from(k) / 1999.0))));
            let largest = scan.fold(0.0, f64::max);
            for (k, (&s, face)) in points.iter().zip(&exact).enumerate() {
                let size = (face.driven.norm_sqr() + face.odd[0].norm_sqr()).sqrt().max(3e-3 * largest);
                split = split.max(face.odd[0].norm() / size);
                for direction in Direction::BOTH {
                    let found = modes.evaluate_wave(direction, s);
                    let error = (found - direction.of(face.driven, face.odd[0])).norm() / size;
                    assert!(error < 2.0 * tolerance, "{speed} km/h, n = {n}, {direction:?}, {s}: {error:.1e}");
                    // Re(s H)/|s| = -Im H on the axis.
                    assert!(k >= on_axis || -found.im > -2.0 * tolerance * size, "{speed}: {n}, {direction:?}, {s}");
                }
            }
            let beyond = (1..30).map(|k| Complex64::new(0.0, options.top * 1.3f64.powi(k)));
            for (s, direction) in beyond.flat_map(|s| Direction::BOTH.map(|direction| (s, direction))) {
                let found = modes.evaluate_wave(direction, s);
                assert!(-found.im > -2.0 * tolerance * found.norm().max(3e-3 * largest), "{speed}: {n}, {s}");
            }
        }
        // What the test is about: at a resonance of one direction the other one does not ring.
        assert!(split > 0.3, "{speed}: {split}");
        assert!(model.statistics().iter().all(|entry| entry.passivity >= -tolerance && entry.error <= tolerance));
    }
}

#[test]
fn resonances_of_either_direction_are_poles_of_the_compliance() {
    let tyre = turning(250.0);
    let model = fitted(&tyre, 1e-5);
    // An inextensional ring's with the resonances of the tyre at rest, with the rotation and against it \[Hz\].
    let known = [(1, 32.4, 103.6), (2, 71.5, 128.5), (3, 118.0, 160.7), (6, 260.7, 283.8)];
    let natural = modes(&tyre, 6, 1, 400.0).unwrap().confirmed;
    for (n, with, against) in known {
        for (direction, frequency) in Direction::BOTH.into_iter().zip([with, against]) {
            let of = natural.iter().filter(|mode| (mode.n, mode.direction) == (n, Some(direction)));
            let mode = of
                .filter(|mode| mode.motion == Motion::Radial)
                .min_by(|a, b| (a.frequency() - frequency).abs().total_cmp(&(b.frequency() - frequency).abs()));
            let mode = mode.unwrap();
            assert!((mode.frequency() / frequency - 1.0).abs() < 0.03, "n = {n}, {direction:?}: {mode:?}");
            let fitted = model.modes(n, Field::Surface).unwrap();
            let near = (0..fitted.pairs).filter(|&index| fitted.belongs_to(direction, index));
            let distance = |pole: Complex64| (pole - mode.pole).norm();
            let nearest = near.map(|index| distance(fitted.poles[index])).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.01 * mode.pole.norm(), "n = {n}, {direction:?}: {nearest}");
        }
    }
}

#[test]
fn a_turning_model_has_a_separate_key_and_the_same_bits() {
    let tyre = turning(80.0);
    let on =
        |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| fitted(&tyre, 1e-4));
    let alone = on(1);
    assert!(alone.turns());
    assert_eq!(alone, on(2));
    let key = |speed: f64| {
        let tyre = turning(speed);
        key(&tyre, &options(&tyre, 1e-4)).unwrap()
    };
    assert_ne!(key(80.0), key(81.0));
    assert_ne!(key(80.0), key(0.0));
    // The other way round every wave has the other direction.
    let reversed = Tyre { angular_velocity: -tyre.angular_velocity, ..tyre.clone() };
    let reversed = fitted(&reversed, 1e-4);
    let s = Complex64::new(40.0, 700.0);
    for n in 1..alone.largest_wavenumber() {
        let values =
            |model: &RationalModel, direction| model.modes(n, Field::Surface).unwrap().evaluate_wave(direction, s);
        let (found, mirrored) = (values(&reversed, Direction::Forwards), values(&alone, Direction::Backwards));
        assert!((found - mirrored).norm() < 1e-3 * mirrored.norm(), "{n}: {found} {mirrored}");
    }
}

#[test]
fn a_turning_tyre_outruns_the_belts_waves_later() {
    // A belt wave of 59 m/s at rest; with rotation no pattern that stands beside the axle meets one below 108 m/s.
    let resting = slowest_wave_below(&turning(0.0), 108.0).unwrap();
    assert!((resting.speed - 59.0).abs() < 1.0, "{resting:?}");
    assert_eq!(slowest_wave_below(&turning(250.0), 108.0), None);
}
