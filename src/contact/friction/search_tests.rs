//! Tests of the search: products by definition, rolling half-spaces, rough cells.

use std::f64::consts::PI;

use super::conditions::{Conditions, onto_disc};
use super::product::{TractionProduct, Vector};
use super::search::FrictionSearch;
use crate::tyre::influence::{PairTables, TractionInfluence, UniformTables};

/// Length of the logarithm's constant in half widths: the shorter, the sooner rolling is steady.
const REACH: f64 = 4.0;

/// A table with all parts, made up of decaying waves; symmetric under exchange of two cells.
fn made_up(columns: usize, across: usize, with_uniform: bool) -> TractionInfluence {
    let mut influence = TractionInfluence::zeros(columns, across);
    let width = influence.width();
    let rows = influence.distances();
    let of = |a: usize, b: usize, hankel: bool| -> Vec<f64> {
        (0..rows * width)
            .map(|place| {
                let (i, s) = ((place / width) as f64 + 1.0 - columns as f64, place % width);
                let j = if hankel { s as f64 + 1.5 } else { s as f64 + 1.0 - across as f64 };
                let decay = (-0.7 * (i * i + j * j).sqrt()).exp();
                match (a == b, a, b) {
                    (true, ..) => decay * if hankel { 0.2 } else { 1.0 + 0.1 * a as f64 },
                    (_, 0, 2) => 0.2 * decay * i,
                    (_, 2, 0) => -0.2 * decay * i,
                    _ => 0.05 * decay * i * j,
                }
            })
            .collect()
    };
    for (place, pair) in influence.pairs.iter_mut().enumerate() {
        let (a, b) = (place / 3, place % 3);
        *pair = PairTables { toeplitz: of(a, b, false), hankel: of(a, b, true) };
    }
    if with_uniform {
        let table = |c: f64| (0..rows * across).map(|place| 0.01 * (c * place as f64).sin()).collect::<Vec<_>>();
        influence.uniform = Some(Box::new(UniformTables {
            driven: [table(0.3), table(0.7), table(1.1)],
            observed: [table(0.4), table(0.9), table(1.3)],
        }));
    }
    influence
}

#[test]
fn products_are_those_with_the_blocks() {
    for (columns, across, with_uniform) in [(1, 1, false), (1, 4, true), (5, 1, false), (7, 3, true), (12, 9, false)] {
        let influence = made_up(columns, across, with_uniform);
        let cells = influence.cells();
        let forces: Vec<Vector> = (0..cells).map(|n| [0.3, 1.1, 2.3].map(|c: f64| (c * n as f64 + c).cos())).collect();
        let mut u = vec![[7.0; 3]; cells];
        TractionProduct::<f64>::new(&influence).displacement(&forces, &mut u);
        for (a, u) in u.iter().enumerate() {
            let mut expected = [0.0; 3];
            for (b, force) in forces.iter().enumerate() {
                for (out, row) in expected.iter_mut().zip(influence.block(a, b)) {
                    *out += row.iter().zip(force).map(|(entry, force)| entry * force).sum::<f64>();
                }
            }
            for (u, expected) in u.iter().zip(expected) {
                assert!((u - expected).abs() < 1e-12 * (1.0 + expected.abs()), "{columns} x {across}: {u} {expected}");
            }
        }
    }
}

/// Displacement of the middle of a cell by unit pressure on another one, x and y away, over 1/(pi G): xx, xy, yy, zz.
fn cerruti(x: f64, y: f64, [a, b]: [f64; 2], poisson: f64) -> [f64; 4] {
    let corners = |f: fn(f64, f64, f64) -> f64| {
        let at = |x: f64, y: f64| f(x, y, x.hypot(y));
        at(x + a, y + b) - at(x - a, y + b) - at(x + a, y - b) + at(x - a, y - b)
    };
    let along = corners(|x, y, r| y * (x + r).ln());
    let across = corners(|x, y, r| x * (y + r).ln());
    let mixed = corners(|_, _, r| -r);
    let whole = along + across;
    [
        (1.0 - poisson) * whole + poisson * along,
        poisson * mixed,
        (1.0 - poisson) * whole + poisson * across,
        (1.0 - poisson) * whole,
    ]
}

/// Influence of two equal half-spaces of combined shear modulus 1: cells of size dx, forces in place of pressures.
fn half_spaces(columns: usize, across: usize, dx: f64, poisson: f64) -> TractionInfluence {
    let mut influence = TractionInfluence::zeros(columns, across);
    let scale = 1.0 / (PI * dx * dx);
    for row in 0..influence.distances() {
        for s in 0..influence.width() {
            let x = (row as f64 + 1.0 - columns as f64) * dx;
            let y = (s as f64 + 1.0 - across as f64) * dx;
            let [xx, xy, yy, zz] = cerruti(x, y, [0.5 * dx; 2], poisson).map(|value| scale * value);
            for (pair, value) in [(0, xx), (1, xy), (3, xy), (4, yy), (8, zz)] {
                influence.pairs[pair].toeplitz.push(value);
            }
        }
    }
    influence
}

/// Rolls over a smooth body by second-order backward differences.
struct Rolling<'a> {
    influence: &'a TractionInfluence,
    dx: f64,
    /// Required displacement of a point of the window.
    required: &'a dyn Fn(f64, f64) -> f64,
    friction: f64,
    /// Creep velocity over the rolling speed.
    creep: &'a dyn Fn(f64, f64) -> [f64; 2],
    /// Steps in which the window moves on by a column.
    substeps: usize,
    columns_rolled: usize,
}

impl Rolling<'_> {
    /// Mean sum of the forces over the last column rolled, and the search.
    fn forces(&self) -> (Vector, FrictionSearch) {
        let (columns, across, substeps) = (self.influence.columns, self.influence.across, self.substeps);
        let cells = columns * across;
        let mut search = FrictionSearch::new(self.influence.clone(), 1e-9);
        let mut forces = vec![[0.0; 3]; cells];
        let mut previous = [vec![[0.0; 2]; cells], vec![[0.0; 2]; cells]];
        let friction = vec![self.friction; cells];
        let mut mean = [0.0; 3];
        for step in 0..self.columns_rolled * substeps {
            let substep = step % substeps;
            if step > 0 && substep == 0 {
                // Cells are material; the contact stays where it is, and with it the guess.
                previous.iter_mut().for_each(|previous| previous.copy_within(across.., 0));
            }
            let place = |cell: usize| {
                let moved = substep as f64 / substeps as f64;
                let x = (cell / across) as f64 - 0.5 * (columns as f64 - 1.0) - moved;
                [x * self.dx, ((cell % across) as f64 - 0.5 * (across as f64 - 1.0)) * self.dx]
            };
            let required: Vec<f64> = (0..cells).map(place).map(|[x, y]| (self.required)(x, y)).collect();
            let shift: Vec<[f64; 2]> = (0..cells)
                .map(|cell| {
                    let [x, y] = place(cell);
                    let creep = (self.creep)(x, y).map(|creep| creep * self.dx / (1.5 * substeps as f64));
                    [0, 1].map(|c| creep[c] - (4.0 * previous[0][cell][c] - previous[1][cell][c]) / 3.0)
                })
                .collect();
            let conditions = Conditions { required: &required, shift: &shift, friction: &friction };
            let residuals = search.solve(&conditions, &mut forces);
            assert!(!search.is_unsettled(), "step {step}: {residuals:?}");
            previous.swap(0, 1);
            previous[0].iter_mut().zip(search.displacements()).for_each(|(previous, u)| *previous = [u[0], u[1]]);
            if step >= (self.columns_rolled - 1) * substeps {
                for force in &forces {
                    mean.iter_mut().zip(force).for_each(|(mean, force)| *mean += force / substeps as f64);
                }
            }
        }
        (mean, search)
    }
}

#[test]
fn rolling_cylinders_have_carters_creep() {
    // Plane strain, E* = 1: both components by -2/(pi E*) ln|x|, per length.
    let (half_width, radius, columns) = (32.0_f64, 1000.0, 72);
    let mut influence = TractionInfluence::zeros(columns, 1);
    let log = |x: f64| {
        // Mean over a cell of the mean over a cell of ln|x|.
        let part = |s: f64| if s.abs() > 0.0 { 0.5 * s * s * s.abs().ln() - 0.75 * s * s } else { 0.0 };
        part(x + 1.0) - 2.0 * part(x) + part(x - 1.0)
    };
    for row in 0..influence.distances() {
        let x = row as f64 + 1.0 - columns as f64;
        let value = -2.0 / PI * (log(x) - (REACH * half_width).ln());
        for pair in [0, 4, 8] {
            influence.pairs[pair].toeplitz.push(value);
        }
    }
    let friction = 0.3;
    // The approach that belongs to the constant of the logarithm.
    let load = PI * half_width * half_width / (4.0 * radius);
    let approach = 2.0 * load / PI * ((2.0 * REACH).ln() + 0.5);
    let required = |x: f64, _: f64| approach - x * x / (2.0 * radius);
    let mut worst = 0.0_f64;
    for share in [0.1, 0.3, 0.5, 0.8] {
        let wanted_creep = share * friction * half_width / radius;
        let creep = |_: f64, _: f64| [wanted_creep, 0.0];
        let rolling = Rolling {
            influence: &influence,
            dx: 1.0,
            required: &required,
            friction,
            creep: &creep,
            substeps: 1,
            columns_rolled: 400,
        };
        let ([tangential, _, normal], search) = rolling.forces();
        let width = (4.0 * normal * radius / PI).sqrt();
        let exact = 1.0 - (1.0 - wanted_creep * radius / (friction * width)).powi(2);
        let error = -tangential / (friction * normal) - exact;
        println!("{share}: half width {width:.2}, {exact:.4}, error {error:.1e}, {:?}", search.counts());
        worst = worst.max(error.abs());
    }
    assert!(worst <= 0.006, "{worst:e}");
}

#[test]
fn rolling_spheres_have_kalkers_creep_coefficients() {
    let (poisson, half_width, radius, columns, across) = (0.25, 16.0, 300.0, 40, 36);
    let influence = half_spaces(columns, across, 1.0, poisson);
    let required = |x: f64, y: f64| (half_width * half_width - 0.5 * (x * x + y * y)) / radius;
    // Creep so small that nearly all sticks.
    let small = 3e-5;
    for (name, exact, direction, creep) in [
        ("C11", 4.12, 0, &(|_: f64, _: f64| [small, 0.0]) as &dyn Fn(f64, f64) -> [f64; 2]),
        ("C22", 3.67, 1, &|_, _| [0.0, small]),
        ("C23", 1.47, 1, &|x: f64, y: f64| [-small / half_width * y, small / half_width * x]),
    ] {
        let rolling = Rolling {
            influence: &influence,
            dx: 1.0,
            required: &required,
            friction: 0.3,
            creep,
            substeps: 1,
            columns_rolled: 90,
        };
        let (forces, search) = rolling.forces();
        let normal = forces[2];
        // a of Hertz from the load: F = 4 E* a^3/(3 R), E* = G/(1 - nu).
        let width = (0.75 * normal * (1.0 - poisson) * radius).cbrt();
        let force = forces[direction];
        let scale = if name == "C23" { width.powi(3) / half_width } else { width * width };
        let found = -force / (small * scale);
        println!("{name}: a = {width:.2}, {found:.3}, {:.1} %, {:?}", 100.0 * (found / exact - 1.0), search.counts());
        assert!((found / exact - 1.0).abs() < 0.025, "{name}: {found}");
    }
}

/// Rough cells rolling over bumps: the hard part of the search.
fn rough(columns: usize, across: usize, friction: f64, steps: usize) -> FrictionSearch {
    let influence = made_up(columns, across, false);
    let cells = columns * across;
    let mut search = FrictionSearch::new(influence, 1e-9);
    let mut forces = vec![[0.0; 3]; cells];
    let mut previous = [vec![[0.0; 2]; cells], vec![[0.0; 2]; cells]];
    let friction = vec![friction; cells];
    for step in 0..steps {
        let random = |n: usize, c: f64| ((c * n as f64).sin() * 43758.5453).fract();
        let required: Vec<f64> = (0..cells)
            .map(|cell| {
                let x = ((cell / across) as f64 - 0.5 * (columns as f64 - 1.0)) / (0.5 * columns as f64);
                1.0 - 2.5 * x * x + random(cell + step * across, 12.9898)
            })
            .collect();
        let shift: Vec<[f64; 2]> = (0..cells)
            .map(|cell| {
                [0, 1].map(|c| 0.1 * (1.0 - c as f64) - (4.0 * previous[0][cell][c] - previous[1][cell][c]) / 3.0)
            })
            .collect();
        let conditions = Conditions { required: &required, shift: &shift, friction: &friction };
        let residuals = search.solve(&conditions, &mut forces);
        assert!(!search.is_unsettled(), "step {step}: {residuals:?}, {:?}", search.counts());
        assert!(residuals.dissipation.abs() < 1e-5, "{residuals:?}");
        for (cell, force) in forces.iter().enumerate() {
            let [x, y] = onto_disc([force[0], force[1]], friction[cell] * force[2]);
            assert!(force[2] >= 0.0 && (x - force[0]).hypot(y - force[1]) <= 1e-12 * (1.0 + force[2]));
        }
        previous.swap(0, 1);
        previous[0].iter_mut().zip(search.displacements()).for_each(|(previous, u)| *previous = [u[0], u[1]]);
        previous.iter_mut().for_each(|previous| previous.copy_within(across.., 0));
        forces.copy_within(across.., 0);
        forces[cells - across..].fill([0.0; 3]);
    }
    search
}

#[test]
fn rough_cells_settle_at_small_and_large_friction() {
    for friction in [0.1, 0.9, 2.0, 4.0] {
        let search = rough(24, 12, friction, 60);
        println!("mu = {friction}: {:?}", search.counts());
    }
}
