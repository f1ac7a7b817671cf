//! Rings with gyroscopic forces, for tests: modes whose poles, residues and directions are known.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::Direction;
use super::model::{Entry, FitStatistics, RationalModel};
use crate::numeric::rational::partial_fractions::{order, sort};
use crate::tyre::influence::Field;

/// a/(s^2 + c s + w^2 - 2 i g s): a mode of the wave n of a ring that turns; -n has -g.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gyroscopic {
    pub share: f64,
    pub damping: f64,
    pub frequency: f64,
    pub gyration: f64,
}

impl Gyroscopic {
    /// Natural frequency \[Hz\], damping relative to the critical one.
    pub(crate) fn new(share: f64, hertz: f64, damping: f64, gyration: f64) -> Self {
        let frequency = 2.0 * PI * hertz;
        Self { share, damping: 2.0 * damping * frequency, frequency, gyration }
    }

    fn turned(self, direction: Direction) -> Complex64 {
        let sign = if direction == Direction::Forwards { 1.0 } else { -1.0 };
        Complex64::new(self.damping, -2.0 * sign * self.gyration)
    }

    /// H_n, or H_-n.
    pub(crate) fn at(self, direction: Direction, s: Complex64) -> Complex64 {
        self.share / (s * (s + self.turned(direction)) + self.frequency.powi(2))
    }

    /// The pole with Im > 0 of the wave n or -n.
    pub(crate) fn pole(self, direction: Direction) -> Complex64 {
        let half = self.turned(direction) * 0.5;
        let root = (half * half - self.frequency.powi(2)).sqrt();
        if root.im > 0.0 { root - half } else { -root - half }
    }

    /// The residue at that pole.
    pub(crate) fn residue(self, direction: Direction) -> Complex64 {
        self.share / (self.pole(direction) * 2.0 + self.turned(direction))
    }
}

/// Mode of n periods of a ring of so many elements that turns at `angular_velocity`, elements counted against it:
/// split as that of an inextensional ring, waves with the rotation lowered.
pub(crate) fn mode(elements: usize, n: usize, angular_velocity: f64) -> Gyroscopic {
    let around = n as f64;
    let gyration = if 2 * n == elements { 0.0 } else { 2.0 * around * angular_velocity / (around * around + 1.0) };
    Gyroscopic::new(3.0, 60.0f64.hypot(25.0 * around), 0.02, gyration)
}

/// Exact model of that ring: its innermost face moves half as far.
pub(crate) fn model(elements: usize, angular_velocity: f64) -> RationalModel {
    let entry = |n: usize| {
        let mode = mode(elements, n, angular_velocity);
        let directions = if mode.gyration == 0.0 { vec![Direction::Forwards] } else { Direction::BOTH.to_vec() };
        let mut poles: Vec<_> = directions.iter().map(|&direction| mode.pole(direction)).collect();
        sort(&mut poles);
        // E has half of a wave's residue, O that times -i, or i.
        let direction_of = |pole: &Complex64| {
            directions.iter().copied().find(|&direction| mode.pole(direction) == *pole).expect("one of them")
        };
        let even: Vec<_> =
            poles.iter().map(|pole| mode.residue(direction_of(pole)) / directions.len() as f64).collect();
        let odd: Vec<_> = poles
            .iter()
            .zip(&even)
            .filter(|_| directions.len() > 1)
            .map(|(pole, even)| {
                even * if direction_of(pole) == Direction::Forwards { -Complex64::i() } else { Complex64::i() }
            })
            .collect();
        let halved = |residues: &[Complex64]| residues.iter().map(|residue| residue * 0.5).collect();
        let statistics = FitStatistics { order: order(&poles), ..FitStatistics::default() };
        let residues = [even.clone(), halved(&even)];
        Entry { poles, residues, odd: [odd.clone(), halved(&odd)], constants: [0.0; 2], statistics }
    };
    RationalModel::assemble(elements, Field::Surface, 1e5, 1e-9, (0..=elements / 2).map(entry))
}
