//! Linear equations of all pressed cells near a guess, solved by generalised minimal residuals.
//!
//! A sticking cell has three unknowns, a slipping one two: its normal force, which carries mu F_z along the slip with
//! it, and tau across. The unknowns are preconditioned by the neighbourhood of a cell in the inverses of the free
//! fields of each component: of all pressed cells for normal forces, of those that stick for tangential ones. The
//! equations are neither symmetric nor definite where friction is large, so that conjugate gradients do not apply
//! (Saad & Schultz 1986, *SIAM J. Sci. Stat. Comput.* 7, 856).

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;

use super::conditions::{CellState, Conditions};
use super::product::{Vector, WindowProduct, transformed};
use crate::contact::cells::filter::Filter;
use crate::tyre::influence::{COMPONENTS, TractionInfluence};

/// Directions that are stored before a restart.
const DIRECTIONS: usize = 60;

/// Equations of the pressed cells.
pub(crate) struct Equations {
    /// Pressed cells with their states, and the places of their first unknowns.
    cells: Vec<(usize, CellState, usize)>,
    unknowns: usize,
    /// Reciprocal diagonal of the equations.
    scale: Vec<f64>,
    right: Vec<f64>,
    directions: Vec<Vec<f64>>,
    /// Part of the window that holds all pressed cells.
    part: Range<usize>,
    forces: Vec<Vector>,
    displacements: Vec<Vector>,
    nearby: NearbyInverse,
    across: usize,
}

pub(crate) struct LinearSolution {
    /// Products with the influence.
    pub products: u64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Equations {
    /// Equations for the window of an influence; `diagonal` is that of a cell on itself \[m/N\].
    pub(crate) fn new(influence: &TractionInfluence, diagonal: Vector) -> Self {
        let cells = influence.cells();
        Self {
            cells: Vec::new(),
            unknowns: 0,
            scale: Vec::new(),
            right: Vec::new(),
            directions: Vec::new(),
            part: 0..cells,
            forces: vec![[0.0; 3]; cells],
            displacements: vec![[0.0; 3]; cells],
            nearby: NearbyInverse::new(influence, diagonal),
            across: influence.across,
        }
    }

    /// Sets the equations up; `diagonal` is the influence of a cell on itself \[m/N\].
    pub(crate) fn set(
        &mut self,
        product: &WindowProduct,
        conditions: &Conditions<'_>,
        states: impl Iterator<Item = (usize, CellState)>,
        diagonal: Vector,
    ) {
        (self.unknowns, self.cells) = (0, std::mem::take(&mut self.cells));
        self.cells.clear();
        self.scale.clear();
        self.right.clear();
        for (cell, state) in states {
            let [sx, sy] = conditions.shift[cell];
            let first = self.unknowns;
            match state {
                CellState::Open => continue,
                CellState::Sticking => {
                    self.right.extend([conditions.required[cell], -sx, -sy]);
                    self.scale.extend([1.0 / diagonal[2], 1.0 / diagonal[0], 1.0 / diagonal[1]]);
                    self.unknowns += 3;
                }
                CellState::Slipping([ex, ey], rest, rigidity) => {
                    let across = diagonal[0] * ey * ey + diagonal[1] * ex * ex;
                    self.right.extend([conditions.required[cell], -rigidity * (ex * sy - ey * sx)]);
                    self.scale.extend([1.0 / diagonal[2], 1.0 / (rest + rigidity * across)]);
                    self.unknowns += 2;
                }
            }
            self.cells.push((cell, state, first));
        }
        if let (Some((first, ..)), Some((last, ..))) = (self.cells.first(), self.cells.last()) {
            self.part = product.part(&(first / self.across..last / self.across + 1));
        }
    }

    /// Forces by cell from the unknowns.
    fn expand(&mut self, friction: &[f64], unknowns: &[f64]) {
        self.forces.fill([0.0; 3]);
        for &(cell, state, first) in &self.cells {
            let z = unknowns[first];
            self.forces[cell] = match state {
                CellState::Slipping([ex, ey], ..) => {
                    let (along, tau) = (friction[cell] * z, unknowns[first + 1]);
                    [along * ex - tau * ey, along * ey + tau * ex, z]
                }
                _ => [unknowns[first + 1], unknowns[first + 2], z],
            };
        }
    }

    /// Left sides of the equations, scaled, for given unknowns.
    fn apply(&mut self, product: &mut WindowProduct, friction: &[f64], unknowns: &[f64], out: &mut [f64]) {
        self.expand(friction, unknowns);
        product.displacement(&self.part, &self.forces, &mut self.displacements);
        self.left_sides(unknowns, out);
    }

    /// The same in single precision, which suffices for directions.
    fn apply_roughly(&mut self, product: &mut WindowProduct, friction: &[f64], unknowns: &[f64], out: &mut [f64]) {
        self.expand(friction, unknowns);
        product.rough_displacement(&self.part, &self.forces, &mut self.displacements);
        self.left_sides(unknowns, out);
    }

    /// Left sides from the displacements by the unknowns.
    fn left_sides(&self, unknowns: &[f64], out: &mut [f64]) {
        for &(cell, state, first) in &self.cells {
            let [x, y, z] = self.displacements[cell];
            out[first] = z * self.scale[first];
            match state {
                CellState::Slipping([ex, ey], rest, rigidity) => {
                    let across = rigidity * (ex * y - ey * x) + rest * unknowns[first + 1];
                    out[first + 1] = across * self.scale[first + 1];
                }
                _ => {
                    out[first + 1] = x * self.scale[first + 1];
                    out[first + 2] = y * self.scale[first + 2];
                }
            }
        }
    }

    /// Unknowns that approximately have these residuals.
    fn precondition(&mut self, residuals: &[f64], out: &mut [f64]) {
        let Self { cells, nearby, part, .. } = self;
        for &(cell, state, first) in &*cells {
            *nearby.ask(cell, 2) = residuals[first];
            if state == CellState::Sticking {
                (*nearby.ask(cell, 0), *nearby.ask(cell, 1)) = (residuals[first + 1], residuals[first + 2]);
            }
        }
        nearby.find(part);
        for &(cell, state, first) in &*cells {
            out[first] = nearby.found(cell, 2);
            match state {
                CellState::Slipping(..) => out[first + 1] = residuals[first + 1],
                _ => (out[first + 1], out[first + 2]) = (nearby.found(cell, 0), nearby.found(cell, 1)),
            }
            (0..COMPONENTS).for_each(|component| *nearby.ask(cell, component) = 0.0);
        }
    }

    /// Solves the equations from a guess, and writes the forces. The residual, as a force, is reduced by a factor
    /// `reduction`, or to `least` \[N\], below which it is of no use.
    pub(crate) fn solve(
        &mut self,
        product: &mut WindowProduct,
        conditions: &Conditions<'_>,
        forces: &mut [Vector],
        [reduction, least]: [f64; 2],
        most: u64,
    ) -> LinearSolution {
        let (count, friction) = (self.unknowns, conditions.friction);
        let mut unknowns = vec![0.0; count];
        for &(cell, state, first) in &self.cells {
            let [x, y, z] = forces[cell];
            unknowns[first] = z;
            match state {
                CellState::Slipping([ex, ey], ..) => unknowns[first + 1] = ex * y - ey * x,
                _ => (unknowns[first + 1], unknowns[first + 2]) = (x, y),
            }
        }
        let (mut residual, mut products) = (vec![0.0; count], 0);
        let mut goal = least;
        while count > 0 && products < most {
            self.apply(product, friction, &unknowns, &mut residual);
            products += 1;
            let right = self.right.iter().zip(&self.scale);
            residual.iter_mut().zip(right).for_each(|(value, (right, scale))| *value = right * scale - *value);
            let first = dot(&residual, &residual).sqrt();
            if products == 1 {
                goal = least.max(reduction * first);
            }
            if first <= goal || !first.is_finite() {
                break;
            }
            let steps = self.minimise(product, friction, (&residual, first), [goal, (most - products) as f64]);
            products += steps.len() as u64;
            let mut change = vec![0.0; count];
            for (step, direction) in steps.iter().zip(&self.directions) {
                change.iter_mut().zip(direction).for_each(|(value, direction)| *value += step * direction);
            }
            self.precondition(&change, &mut residual);
            unknowns.iter_mut().zip(&residual).for_each(|(value, change)| *value += change);
            if steps.len() < DIRECTIONS {
                break;
            }
        }
        self.expand(friction, &unknowns);
        forces.copy_from_slice(&self.forces);
        LinearSolution { products }
    }

    /// Steps along the directions that make a residual smallest.
    fn minimise(
        &mut self,
        product: &mut WindowProduct,
        friction: &[f64],
        (residual, first): (&[f64], f64),
        [goal, most]: [f64; 2],
    ) -> Vec<f64> {
        let most = DIRECTIONS.min(most as usize);
        let mut directions = std::mem::take(&mut self.directions);
        directions.clear();
        directions.push(residual.iter().map(|value| value / first).collect::<Vec<f64>>());
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut turns: Vec<[f64; 2]> = Vec::new();
        let mut right = vec![first];
        while columns.len() < most && right[columns.len()].abs() > goal {
            let place = columns.len();
            let (mut near, mut next) = (vec![0.0; self.unknowns], vec![0.0; self.unknowns]);
            // 1. A direction that is orthogonal to all before (Arnoldi).
            self.precondition(&directions[place], &mut near);
            self.apply_roughly(product, friction, &near, &mut next);
            let mut column = Vec::with_capacity(place + 2);
            for direction in &directions {
                let share = dot(direction, &next);
                next.iter_mut().zip(direction).for_each(|(next, direction)| *next -= share * direction);
                column.push(share);
            }
            let norm = dot(&next, &next).sqrt();
            // 2. Rotations that keep the columns triangular.
            for (row, [cosine, sine]) in turns.iter().enumerate() {
                let [a, b] = [column[row], column[row + 1]];
                (column[row], column[row + 1]) = (cosine * a + sine * b, cosine * b - sine * a);
            }
            let length = column[place].hypot(norm);
            if !length.is_finite() || length <= 0.0 {
                break;
            }
            let [cosine, sine] = [column[place] / length, norm / length];
            column[place] = length;
            let last = right[place];
            right[place] = cosine * last;
            right.push(-sine * last);
            turns.push([cosine, sine]);
            columns.push(column);
            if norm <= 1e-300 {
                break;
            }
            next.iter_mut().for_each(|value| *value /= norm);
            directions.push(next);
        }
        // 3. Back substitution.
        let count = columns.len();
        let mut steps = vec![0.0; count];
        for row in (0..count).rev() {
            let known: f64 = (row + 1..count).map(|column| columns[column][row] * steps[column]).sum();
            steps[row] = (right[row] - known) / columns[row][row];
        }
        self.directions = directions;
        steps
    }
}

/// Cells on either side that the stencil of an inverse covers.
const RADIUS: usize = 2;

/// Forces that approximately displace cells as asked for, from the neighbourhood of each cell: the preconditioner.
///
/// Each component by itself: the middle of the inverse of its free field T, without the tyre's sides.
struct NearbyInverse {
    filters: [Filter<f64>; COMPONENTS],
    /// By component, cell by cell.
    asked: [Vec<f64>; COMPONENTS],
    found: [Vec<f64>; COMPONENTS],
}

/// Middle of the inverses of the free fields T_xx, T_yy and T_zz, by distance along and across, (`RADIUS` + 1)^2,
/// times `diagonal`.
fn inverse_stencils(influence: &TractionInfluence, diagonal: Vector) -> [Vec<f64>; COMPONENTS] {
    /// Floor of the waves of T, as a part of the largest.
    const FLOOR: f64 = 1e-3;
    let (columns, across) = (influence.columns, influence.across);
    let (p, q) = (2 * columns - 1, 2 * across - 1);
    let cosine = |phase: usize, length: usize| (TAU * (phase % length) as f64 / length as f64).cos();
    let of_component = |component: usize| {
        let along = transformed(&influence.pairs[component * (COMPONENTS + 1)].toeplitz, q, columns);
        // T is even along and across.
        let of_wave = |row: &[Complex64]| -> Vec<f64> {
            let value = |l: usize| row.iter().enumerate().map(|(s, t)| t.re * cosine(l * (s + across), q)).sum();
            (0..q).map(value).collect()
        };
        let waves: Vec<f64> = along.chunks_exact(q).flat_map(of_wave).collect();
        let largest = waves.iter().fold(0.0_f64, |largest, wave| largest.max(*wave));
        let near = |i: usize, j: usize| -> f64 {
            let wave = |(place, wave): (usize, &f64)| {
                let (k, l) = (place / q, place % q);
                let sides = if k == 0 { 1.0 } else { 2.0 };
                sides * cosine(k * i, p) * cosine(l * j, q) / wave.max(FLOOR * largest)
            };
            diagonal[component] / (p * q) as f64 * waves.iter().enumerate().map(wave).sum::<f64>()
        };
        (0..=RADIUS).flat_map(|i| (0..=RADIUS).map(move |j| (i, j))).map(|(i, j)| near(i, j)).collect()
    };
    std::array::from_fn(of_component)
}

impl NearbyInverse {
    /// Inverses for an influence; `diagonal` is that of a cell on itself \[m/N\].
    fn new(influence: &TractionInfluence, diagonal: Vector) -> Self {
        let size = [influence.columns, influence.across];
        let fields = || std::array::from_fn(|_| vec![0.0; influence.cells()]);
        let filters = inverse_stencils(influence, diagonal).map(|stencil| Filter::new(size, RADIUS, stencil));
        Self { filters, asked: fields(), found: fields() }
    }

    /// Value that is asked of a component at a cell.
    fn ask(&mut self, cell: usize, component: usize) -> &mut f64 {
        &mut self.asked[component][cell]
    }

    /// Value found for a component at a cell.
    fn found(&self, cell: usize, component: usize) -> f64 {
        self.found[component][cell]
    }

    /// Finds the values in a part of the window, a range of cells, outside which nothing is asked for.
    fn find(&mut self, part: &Range<usize>) {
        for ((filter, asked), found) in self.filters.iter_mut().zip(&self.asked).zip(&mut self.found) {
            filter.apply(&asked[part.clone()], &mut found[part.clone()]);
        }
    }
}
