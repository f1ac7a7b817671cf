//! Fits of waves that differ from their mirror images: rings with gyroscopic forces, whose poles are known.

use std::f64::consts::PI;

use super::*;
use crate::numeric::rational::partial_fractions::is_pair;
use crate::tyre::influence::{FaceValues, Field};
use crate::tyre::poles::Direction;
use crate::tyre::poles::modes::WaveModes;
use crate::tyre::poles::turning_ring::{self, Gyroscopic};

/// A ring's mode, a mode that moves along it, and a stiff one; with `creep` a branch cut, as rubber has.
struct Ring {
    modes: [Gyroscopic; 3],
    creep: f64,
}

impl Ring {
    fn new(gyration: f64, creep: f64) -> Self {
        let mode = Gyroscopic::new;
        let modes = [
            mode(1.0, 120.0, 0.05, gyration),
            mode(0.8, 700.0, 0.03, -0.6 * gyration),
            mode(9.0, 4e3, 0.1, 0.1 * gyration),
        ];
        Self { modes, creep }
    }

    /// H_n or H_-n of the outer face, and of an inner one in which the stiff mode is weaker and of opposite sign.
    fn faces(&self, direction: Direction, s: Complex64) -> [Complex64; 2] {
        let [ring, along, stiff] = self.modes.map(|mode| mode.at(direction, s));
        let creep = self.creep * ((s + 300.0) / 1e3).powf(-0.6);
        [ring + along + stiff + creep, ring + along * 0.7 - stiff * 0.2]
    }

    fn values(&self, s: Complex64) -> FaceValues {
        let (with, against) = (self.faces(Direction::Forwards, s), self.faces(Direction::Backwards, s));
        let even = |face: usize| (with[face] + against[face]) * 0.5;
        let odd = |face: usize| (with[face] - against[face]) * Complex64::new(0.0, -0.5);
        FaceValues { driven: even(0), bottom: even(1), odd: [odd(0), odd(1)], evaluations: 2 }
    }
}

const TOP: f64 = 2.0 * PI * 8e3;

fn target(tolerance: f64) -> Target {
    Target {
        wavenumber: 3,
        tolerance,
        most_poles: 80,
        constant: false,
        bottom_scale: 0.0,
        least_scale: 0.0,
        removals: 8,
        removal_below: 1.0,
    }
}

fn fitted(ring: &Ring, tolerance: f64, start: &Start) -> Entry {
    let ladder = Ladder::new(TOP);
    let mut sample = |rungs: &[usize], values: &mut Vec<FaceValues>| {
        values.extend(rungs.iter().map(|&rung| ring.values(ladder.points[rung])));
    };
    fit_wavenumber(&ladder, &target(tolerance), start, &mut sample).unwrap().entry
}

fn modes(entry: &Entry, face: usize) -> WaveModes<'_> {
    WaveModes {
        poles: &entry.poles,
        residues: &entry.residues[face],
        odd: &entry.odd[face],
        pairs: entry.poles.iter().filter(|&&pole| is_pair(pole)).count(),
        constant: entry.constants[face],
    }
}

#[test]
fn poles_of_a_turning_ring_are_found_with_their_direction() {
    let ring = Ring::new(150.0, 0.0);
    let entry = fitted(&ring, 1e-8, &Start::default());
    let modes = modes(&entry, 0);
    for mode in ring.modes {
        for (direction, other) in
            [(Direction::Forwards, Direction::Backwards), (Direction::Backwards, Direction::Forwards)]
        {
            let exact = mode.pole(direction);
            let distance = |index: &usize| (modes.poles[*index] - exact).norm();
            let nearest = (0..modes.pairs).min_by(|i, j| distance(i).total_cmp(&distance(j))).unwrap();
            assert!(distance(&nearest) < 1e-4 * exact.norm(), "{direction:?} {exact}: {}", modes.poles[nearest]);
            let residue = modes.residue(direction, nearest);
            assert!(
                (residue - mode.residue(direction)).norm() < 1e-3 * residue.norm(),
                "{direction:?} {exact}: {residue}"
            );
            assert!(modes.residue(other, nearest).norm() < 1e-3 * residue.norm(), "{direction:?} {exact}");
        }
    }
    // Three modes of either direction, and nothing else.
    assert_eq!((modes.pairs, entry.statistics.order), (6, 12));
}

/// Largest error of both faces and waves at points that no fit saw, relative to the mean size of both waves.
fn error(ring: &Ring, entry: &Entry, s: Complex64, largest: [f64; 2]) -> f64 {
    let (with, against) = (ring.faces(Direction::Forwards, s), ring.faces(Direction::Backwards, s));
    let of_face = |face: usize| {
        let modes = modes(entry, face);
        let mean = (0.5 * (with[face].norm_sqr() + against[face].norm_sqr())).sqrt();
        let scale = if face == 0 { mean.max(3e-3 * largest[0]) } else { largest[1] };
        let error = |direction, exact: Complex64| (modes.evaluate_wave(direction, s) - exact).norm() / scale;
        error(Direction::Forwards, with[face]).max(error(Direction::Backwards, against[face]))
    };
    of_face(0).max(of_face(1))
}

#[test]
fn both_waves_are_within_tolerance_between_samples_and_passive() {
    for (gyration, tolerance) in [(20.0, 1e-4), (150.0, 1e-4), (150.0, 1e-5), (0.02, 1e-5)] {
        let ring = Ring::new(gyration, 2e-6);
        let entry = fitted(&ring, tolerance, &Start::default());
        let axis = (0..1500).map(|k| Complex64::new(0.0, 1.0 + TOP * (f64::from(k) / 1500.0).powi(3)));
        let largest = [0, 1].map(|face| {
            let of = |direction, s| ring.faces(direction, s)[face].norm_sqr();
            let both = |s| 0.5 * (of(Direction::Forwards, s) + of(Direction::Backwards, s));
            axis.clone().map(both).fold(0.0, f64::max).sqrt()
        });
        let real = (0..60).map(|k| Complex64::new(3.0 * 1.15_f64.powi(k), 0.0)).filter(|s| s.re < TOP);
        let worst = axis.clone().chain(real).map(|s| error(&ring, &entry, s, largest)).fold(0.0, f64::max);
        assert!(worst < 1.2 * tolerance, "{gyration} {tolerance}: {worst:.1e}");
        assert!(worst > 1e-3 * tolerance, "{gyration} {tolerance}: {worst:.1e}");
        // Both parts are real functions.
        let modes = modes(&entry, 0);
        let s = Complex64::new(70.0, 900.0);
        assert!((modes.evaluate_odd(s.conj()) - modes.evaluate_odd(s).conj()).norm() < 1e-15);
        assert!(modes.evaluate_odd(Complex64::new(500.0, 0.0)).im.abs() < 1e-18);
        let beyond = (0..40).map(|k| Complex64::new(0.0, TOP * 1.2_f64.powi(k)));
        for s in axis.chain(beyond) {
            for direction in Direction::BOTH {
                let value = modes.evaluate_wave(direction, s);
                let floor = value.norm().max(3e-3 * largest[0]);
                assert!(-value.im > -2.0 * tolerance * floor, "{gyration} {tolerance}: {direction:?} {s} {value}");
            }
        }
    }
}

#[test]
fn a_slowly_turning_ring_has_as_many_poles_as_one_at_rest() {
    let [resting, slow, fast] = [0.0, 1e-5, 60.0].map(|gyration| {
        let mut ring = Ring::new(gyration, 0.0);
        ring.creep = 0.0;
        fitted(&ring, 1e-5, &Start::default())
    });
    assert!(resting.odd.iter().all(Vec::is_empty));
    assert_eq!(slow.odd[0].len(), slow.poles.len());
    assert_eq!(slow.statistics.order, resting.statistics.order);
    assert_eq!(fast.statistics.order, 2 * resting.statistics.order);
    for (slow, resting) in slow.poles.iter().zip(&resting.poles) {
        assert!((slow - resting).norm() < 1e-4 * resting.norm());
    }
}

#[test]
fn a_wave_of_a_turning_ring_starts_from_its_resting_neighbour() {
    let at_rest = fitted(&Ring::new(0.0, 2e-6), 1e-5, &Start::default());
    let start = Start { poles: at_rest.poles, grid: Vec::new() };
    let turning = fitted(&Ring::new(100.0, 2e-6), 1e-5, &start);
    let from_scratch = fitted(&Ring::new(100.0, 2e-6), 1e-5, &Start::default());
    assert!(turning.statistics.order <= from_scratch.statistics.order + 4);
}

#[test]
fn a_model_of_waves_with_and_without_odd_parts_is_whole() {
    let model = turning_ring::model(16, -70.0);
    assert!(model.turns());
    for n in 0..=8 {
        let mode = turning_ring::mode(16, n, -70.0);
        for (field, share) in [(Field::Surface, 1.0), (Field::Bottom, 0.5)] {
            let modes = model.modes(n, field).unwrap();
            assert_eq!(modes.odd.len(), modes.poles.len(), "{n}");
            for s in [Complex64::new(0.0, 900.0), Complex64::new(500.0, 0.0), Complex64::new(20.0, -70.0)] {
                for direction in Direction::BOTH {
                    let (found, exact) = (modes.evaluate_wave(direction, s), mode.at(direction, s) * share);
                    assert!((found - exact).norm() < 1e-12 * exact.norm(), "{n} {direction:?} {s}: {found} {exact}");
                }
            }
            for (direction, index) in Direction::BOTH.into_iter().flat_map(|d| (0..modes.pairs).map(move |i| (d, i))) {
                let belongs = (modes.poles[index] - mode.pole(direction)).norm() < 1e-9;
                assert_eq!(modes.belongs_to(direction, index), belongs, "{n} {direction:?}");
            }
        }
        assert!(model.evaluate(n, Complex64::ZERO, Field::Surface).unwrap().im.abs() < 1e-18);
    }
    let resting = turning_ring::model(16, 0.0);
    assert!(!resting.turns() && resting.modes(3, Field::Surface).unwrap().odd.is_empty());
}
