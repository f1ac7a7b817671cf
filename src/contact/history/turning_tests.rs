//! Rings that turn, forces on them and in the road's frame: histories against the equations of motion of the waves.

use std::f64::consts::PI;

use num_complex::Complex64;
use realfft::RealFftPlanner;

use super::*;
use crate::contact::kernel::{ContactKernel, EqualBedding};
use crate::scene::Tread;
use crate::time_rule::TimeRule;
use crate::tyre::influence::Field;
use crate::tyre::influence::convolution_quadrature::{Contour, Weights};
use crate::tyre::poles::turning_ring;
use crate::tyre::poles::{Direction, RationalModel};

const ELEMENTS: usize = 32;
/// Radius \[m\].
const RADIUS: f64 = 0.31;
/// How long the ring is driven \[s\].
const DURATION: f64 = 0.03;

/// A force on an element at a time \[N\]: a bump, at an element or where the ring touches the road.
#[derive(Clone, Copy, Debug)]
struct Bump {
    /// Elements that it passes over in a second.
    speed: f64,
}

impl Bump {
    fn force(self, element: usize, time: f64) -> f64 {
        if time <= 0.0 {
            return 0.0;
        }
        let distance = (element as f64 - 6.0 - self.speed * time).rem_euclid(ELEMENTS as f64);
        let distance = distance.min(ELEMENTS as f64 - distance);
        let begun = (0.5 * PI * (time / 0.012).min(1.0)).sin().powi(4);
        begun * (1.0 + 0.4 * (2.0 * PI * 45.0 * time).sin()) * (-(distance / 3.0).powi(2)).exp()
    }
}

/// sum of F_e exp(-2 pi i n e/N).
fn wave(n: usize, force: impl Fn(usize) -> f64) -> Complex64 {
    let turned = |e: usize| Complex64::cis(-2.0 * PI * (n * e % ELEMENTS) as f64 / ELEMENTS as f64);
    (0..ELEMENTS).map(|e| turned(e) * force(e)).sum()
}

/// Reference: displacements after each of so many parts of the duration. Every wave n = 0..=N/2 has a separate
/// equation of motion, u'' + (c - 2 i g) u' + w^2 u = a F_n, stepped by the classical Runge-Kutta rule.
fn moved(angular_velocity: f64, bump: Bump, parts: usize) -> Vec<Vec<f64>> {
    const STEPS: usize = 64;
    let step = DURATION / (parts * STEPS) as f64;
    let mut displacements = vec![vec![0.0; ELEMENTS]; parts];
    for n in 0..=ELEMENTS / 2 {
        let turning_ring::Gyroscopic { share, damping, frequency, gyration } =
            turning_ring::mode(ELEMENTS, n, angular_velocity);
        let drag = Complex64::new(damping, -2.0 * gyration);
        let slope = |force: Complex64, [u, v]: [Complex64; 2]| [v, force * share - drag * v - u * frequency.powi(2)];
        let along = |from: [Complex64; 2], by: f64, slope: [Complex64; 2]| [0, 1].map(|i| from[i] + slope[i] * by);
        let mut state = [Complex64::ZERO; 2];
        for (part, displacement) in displacements.iter_mut().enumerate() {
            for number in 0..STEPS {
                let time = (part * STEPS + number) as f64 * step;
                let forces = [0.0, 0.5, 1.0].map(|node| wave(n, |e| bump.force(e, time + node * step)));
                let first = slope(forces[0], state);
                let second = slope(forces[1], along(state, 0.5 * step, first));
                let third = slope(forces[1], along(state, 0.5 * step, second));
                let fourth = slope(forces[2], along(state, step, third));
                let sum = [0, 1].map(|i| first[i] + second[i] * 2.0 + third[i] * 2.0 + fourth[i]);
                state = along(state, step / 6.0, sum);
            }
            let ends = if n == 0 || 2 * n == ELEMENTS { 1.0 } else { 2.0 };
            for (e, u) in displacement.iter_mut().enumerate() {
                *u += ends * (state[0] * Complex64::cis(2.0 * PI * (n * e % ELEMENTS) as f64 / ELEMENTS as f64)).re;
            }
        }
    }
    displacements
}

/// Displacements at the ends of the parts by a history and the influence within an instant. The window is the whole
/// ring and moves on with the road.
fn marched(
    history: &mut dyn ForceHistory,
    row: &[f64],
    rule: TimeRule,
    bump: Bump,
    [parts, steps, substeps]: [usize; 3],
) -> Vec<Vec<f64>> {
    let time_step = DURATION / (parts * steps) as f64;
    let mut found = Vec::new();
    for step in 0..=parts * steps {
        let first = step / substeps;
        let mut displacement = vec![0.0; ELEMENTS];
        for node in rule.nodes() {
            let time = (step as f64 - 1.0 + node) * time_step;
            history.displacement(first as i64, &mut displacement, &mut Meter::default());
            let forces: Vec<f64> = (0..ELEMENTS).map(|c| bump.force((first + c) % ELEMENTS, time)).collect();
            history.push(first as i64, &forces);
            for (column, displacement) in displacement.iter_mut().enumerate() {
                let of = |(point, force): (usize, &f64)| row[(ELEMENTS + column - point) % ELEMENTS] * force;
                *displacement += forces.iter().enumerate().map(of).sum::<f64>();
            }
        }
        if step > 0 && step % steps == 0 {
            displacement.rotate_right(first % ELEMENTS);
            found.push(displacement);
        }
    }
    found
}

/// Weights of the ring's closed form, wave by wave, by the points of a circle.
fn weights(angular_velocity: f64, rule: TimeRule, time_step: f64, lags: usize) -> Weights {
    let contour = Contour::new(rule, time_step, lags);
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(contour.circle.length);
    let of = |n: usize, odd: bool| {
        let mode = turning_ring::mode(ELEMENTS, n, angular_velocity);
        let mut spectrum: Vec<Complex64> = contour
            .points
            .iter()
            .map(|&s| {
                let [with, against] = Direction::BOTH.map(|direction| mode.at(direction, s));
                if odd { (with - against) * Complex64::new(0.0, -0.5) } else { (with + against) * 0.5 }
            })
            .collect();
        let last = spectrum.len() - 1;
        (spectrum[0].im, spectrum[last].im) = (0.0, 0.0);
        let mut signal = inverse.make_output_vec();
        inverse.process(&mut spectrum, &mut signal).unwrap();
        (0..lags).map(|p| signal[p] * contour.circle.scale(p)).collect::<Vec<_>>()
    };
    let all = |odd| (0..=ELEMENTS / 2).flat_map(|n| of(n, odd)).collect();
    Weights { values: all(false), odd: all(true), lags, at_rest: Vec::new(), evaluations: 0 }
}

fn row(first: [&[f64]; 2]) -> Vec<f64> {
    let kernel = ContactKernel::new(Tread::Elastic, first, ELEMENTS, EqualBedding::NONE).unwrap();
    kernel.instant.iter().zip(&kernel.odd).map(|(even, odd)| even + odd).collect()
}

fn modal(model: &RationalModel, rule: TimeRule, time_step: f64) -> (Box<dyn ForceHistory>, Vec<f64>) {
    let history = ModalHistory::new(model, Field::Surface, rule, time_step, ELEMENTS).unwrap();
    let first = ModalHistory::first_weights(model, Field::Surface, rule, time_step).unwrap();
    let odd = ModalHistory::odd_first_weights(model, Field::Surface, rule, time_step).unwrap();
    (Box::new(history), row([&first, &odd]))
}

fn direct(weights: &Weights, substeps: usize) -> (Box<dyn ForceHistory>, Vec<f64>) {
    let history = DirectHistory::new(LagKernel::new(weights, ELEMENTS, ELEMENTS, substeps), ELEMENTS, substeps);
    let wavenumbers = 0..=ELEMENTS / 2;
    let first: Vec<f64> = wavenumbers.clone().map(|n| weights.of(n)[0]).collect();
    let odd: Vec<f64> = wavenumbers.map(|n| weights.odd_of(n)[0]).collect();
    (Box::new(history), row([&first, &odd]))
}

/// Largest difference relative to the largest value.
fn difference(found: &[Vec<f64>], exact: &[Vec<f64>]) -> f64 {
    let largest = exact.iter().flatten().fold(0.0_f64, |a, b| a.max(b.abs()));
    let errors = found.iter().flatten().zip(exact.iter().flatten()).map(|(a, b)| (a - b).abs());
    errors.fold(0.0, f64::max) / largest
}

#[test]
fn a_turning_ring_moves_as_its_equations_of_motion() {
    const PARTS: usize = 5;
    for speed in [80.0, 250.0] {
        let angular_velocity = -speed / 3.6 / RADIUS;
        let model = turning_ring::model(ELEMENTS, angular_velocity);
        let elements_per_second = -angular_velocity * ELEMENTS as f64 / (2.0 * PI);
        for bump in [Bump { speed: 0.0 }, Bump { speed: elements_per_second }] {
            let exact = moved(angular_velocity, bump, PARTS);
            let resting = moved(0.0, bump, PARTS);
            println!("{speed} km/h, {bump:?}: at rest {:.1e} from it", difference(&resting, &exact));
            for rule in [TimeRule::Bdf2, TimeRule::Sdirk2] {
                let errors = [60, 120, 240].map(|steps| {
                    let time_step = DURATION / (PARTS * steps) as f64;
                    // An element is passed in a whole number of steps; the window moves less, and never more.
                    let substeps = (1.0 / (elements_per_second * time_step)).ceil() as usize;
                    let sizes = [PARTS, steps, substeps];
                    let (mut history, row) = modal(&model, rule, time_step);
                    let found = marched(&mut *history, &row, rule, bump, sizes);
                    if rule.is_multistep() {
                        let weights = weights(angular_velocity, rule, time_step, PARTS * steps + 1);
                        let (mut history, row) = direct(&weights, substeps);
                        let summed = marched(&mut *history, &row, rule, bump, sizes);
                        let error = difference(&summed, &found);
                        assert!(error < 1e-9, "{rule:?}, {steps} steps: {error:e}");
                    }
                    difference(&found, &exact)
                });
                let order = (errors[1] / errors[2]).log2();
                println!("{speed} km/h, {bump:?}, {rule:?}: {errors:?}, order {order:.2}");
                assert!((order - 2.0).abs() < 0.2 && errors[2] < 2e-3, "{rule:?}: {errors:?}, {order}");
            }
        }
    }
}

#[test]
fn first_weights_of_a_passive_turning_ring_are_hardly_odd() {
    let angular_velocity = -250.0 / 3.6 / RADIUS;
    let model = turning_ring::model(ELEMENTS, angular_velocity);
    for rule in [TimeRule::Bdf1, TimeRule::Bdf2, TimeRule::Sdirk2, TimeRule::Sdirk3] {
        let time_step = 1e-4;
        let rate = rule.first_rate(time_step);
        let even = ModalHistory::first_weights(&model, Field::Surface, rule, time_step).unwrap();
        let odd = ModalHistory::odd_first_weights(&model, Field::Surface, rule, time_step).unwrap();
        for (n, (even, odd)) in even.iter().zip(&odd).enumerate() {
            assert!(odd.abs() <= 2.0 * angular_velocity.abs() / rate * even, "{rule:?}, n = {n}: {even:e}, {odd:e}");
            assert_eq!(*odd == 0.0, n == 0 || 2 * n == ELEMENTS, "{rule:?}, n = {n}: {odd:e}");
        }
    }
    // Nothing of it at rest.
    let model = turning_ring::model(ELEMENTS, 0.0);
    assert!(ModalHistory::odd_first_weights(&model, Field::Surface, TimeRule::Bdf2, 1e-4).unwrap().is_empty());
}

#[test]
fn work_of_a_pass_is_counted_with_its_odd_parts() {
    use super::wavenumber_group::WavenumberGroup;
    const GROUP: usize = <f64 as crate::numeric::Element>::MOST_LANES;
    let [resting, turning] = [0.0, -200.0].map(|angular_velocity| turning_ring::model(ELEMENTS, angular_velocity));
    for rule in [TimeRule::Bdf2, TimeRule::Sdirk2, TimeRule::Sdirk3] {
        let steps = 4;
        let work = |model: &RationalModel, odd: bool| {
            let modes = (1..=GROUP).map(|n| {
                let modes = model.modes(n, Field::Surface).unwrap();
                if odd { modes } else { crate::tyre::poles::WaveModes { odd: &[], ..modes } }
            });
            WavenumberGroup::<f64>::new(1, modes, rule, 1e-4, steps * rule.stages()).work()
        };
        // Two pairs to a wavenumber, or one and one to fill up; outputs of two systems at all stages of all steps.
        let (even, both) = (work(&turning, false), work(&turning, true));
        let more = (2 * GROUP * steps * 2 * 2 * rule.stages()) as u64;
        assert_eq!(both.multiply_adds - even.multiply_adds, more, "{rule:?}");
        assert_eq!(both.bytes - even.bytes, (8 * 2 * 2 * GROUP) as u64, "{rule:?}");
        assert_eq!(work(&resting, true), even, "{rule:?}");
        let expected = expected_multiply_adds(rule, steps, GROUP, (4 * GROUP) as f64, true);
        assert!((expected * steps as f64 / both.multiply_adds as f64 - 1.0).abs() < 1e-12, "{rule:?}: {expected}");
    }
}
