//! Linear equations of all pressed cells near a guess, solved by generalised minimal residuals.
//!
//! A sticking cell has three unknowns, a slipping one two: its normal force, which carries mu F_z along the slip with
//! it, and tau across. The unknowns are preconditioned by what is near a cell in the inverses of the free fields of
//! each component: of all pressed cells for normal forces, of those that stick for tangential ones. The equations are
//! neither symmetric nor definite where friction is large, so that no conjugate gradients serve (Saad & Schultz 1986,
//! *SIAM J. Sci. Stat. Comput.* 7, 856).

use std::ops::Range;

use super::conditions::{Conditions, State};
use super::product::{TractionProduct, Vector};
use crate::counters::Work;
use crate::tyre::influence::{COMPONENTS, TractionInfluence};

/// Directions that are kept.
const DIRECTIONS: usize = 60;

/// Columns by which windows of products differ.
const COLUMNS: usize = 8;
/// Cells on either side that an inverse is taken of.
const RADIUS: usize = 2;

/// Equations of the pressed cells.
pub(crate) struct Equations {
    /// Pressed cells with their states, and the places of their first unknowns.
    cells: Vec<(usize, State, usize)>,
    unknowns: usize,
    /// Reciprocal diagonal of the equations.
    scale: Vec<f64>,
    right: Vec<f64>,
    directions: Vec<Vec<f64>>,
    /// Products with the influence between columns that hold all pressed cells, by their number; made as needed.
    products: Vec<Option<TractionProduct>>,
    /// First cell of these columns and past the last, and which product is theirs.
    range: Range<usize>,
    which: usize,
    /// Work of products.
    work: Work,
    forces: Vec<Vector>,
    displacements: Vec<Vector>,
    /// Inverses of the free fields nearby by component.
    stencils: [Vec<f64>; COMPONENTS],
    across: usize,
    /// Forces to be preconditioned, with room round the window.
    padded: Vec<Vector>,
}

/// Result of a solution.
pub(crate) struct Solved {
    /// Products with the influence.
    pub products: u64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Equations {
    /// Makes room for the window of an influence with its product; `own` is the influence of a cell on itself \[m/N\].
    pub(crate) fn new(influence: &TractionInfluence, product: &TractionProduct, own: Vector) -> Self {
        let TractionInfluence { columns, across, .. } = *influence;
        let cells = columns * across;
        let padded = (columns + 2 * RADIUS) * (across + 2 * RADIUS);
        Self {
            cells: Vec::new(),
            unknowns: 0,
            scale: Vec::new(),
            right: Vec::new(),
            directions: Vec::new(),
            products: (0..columns.div_ceil(COLUMNS)).map(|_| None).collect(),
            range: 0..cells,
            which: 0,
            work: Work::default(),
            forces: vec![[0.0; 3]; cells],
            displacements: vec![[0.0; 3]; cells],
            stencils: product.inverse_stencils(RADIUS, own),
            across,
            padded: vec![[0.0; 3]; padded],
        }
    }

    /// Takes out the work of all products since this was last done.
    pub(crate) fn take_work(&mut self) -> Work {
        std::mem::take(&mut self.work)
    }

    /// Finds the columns of all pressed cells, and their product.
    fn take_columns(&mut self, influence: &TractionInfluence) {
        let (Some((first, ..)), Some((last, ..))) = (self.cells.first(), self.cells.last()) else { return };
        let (first, last) = (first / self.across, last / self.across);
        self.which = (last - first) / COLUMNS;
        let columns = influence.columns.min((self.which + 1) * COLUMNS);
        let first = first.min(influence.columns - columns);
        self.range = first * self.across..(first + columns) * self.across;
        let made = &mut self.products[self.which];
        made.get_or_insert_with(|| TractionProduct::new(&influence.narrowed(columns)));
    }

    /// Sets the equations up; `own` is the influence of a cell on itself \[m/N\].
    pub(crate) fn set(
        &mut self,
        influence: &TractionInfluence,
        conditions: &Conditions<'_>,
        states: impl Iterator<Item = State>,
        own: Vector,
    ) {
        (self.unknowns, self.cells) = (0, std::mem::take(&mut self.cells));
        self.cells.clear();
        self.scale.clear();
        self.right.clear();
        for (cell, state) in states.enumerate() {
            let [sx, sy] = conditions.shift[cell];
            let first = self.unknowns;
            match state {
                State::Open => continue,
                State::Sticking => {
                    self.right.extend([conditions.required[cell], -sx, -sy]);
                    self.scale.extend([1.0 / own[2], 1.0 / own[0], 1.0 / own[1]]);
                    self.unknowns += 3;
                }
                State::Slipping([ex, ey], rest, rigidity) => {
                    let across = own[0] * ey * ey + own[1] * ex * ex;
                    self.right.extend([conditions.required[cell], -rigidity * (ex * sy - ey * sx)]);
                    self.scale.extend([1.0 / own[2], 1.0 / (rest + rigidity * across)]);
                    self.unknowns += 2;
                }
            }
            self.cells.push((cell, state, first));
        }
        self.take_columns(influence);
    }

    /// Finds the forces of unknowns.
    fn expand(&mut self, friction: &[f64], unknowns: &[f64]) {
        self.forces.fill([0.0; 3]);
        for &(cell, state, first) in &self.cells {
            let z = unknowns[first];
            self.forces[cell] = match state {
                State::Slipping([ex, ey], ..) => {
                    let (along, tau) = (friction[cell] * z, unknowns[first + 1]);
                    [along * ex - tau * ey, along * ey + tau * ex, z]
                }
                _ => [unknowns[first + 1], unknowns[first + 2], z],
            };
        }
    }

    /// Finds the left sides of the equations, scaled, for unknowns.
    fn apply(&mut self, friction: &[f64], unknowns: &[f64], out: &mut [f64]) {
        self.expand(friction, unknowns);
        let Self { products, range, which, work, forces, displacements, .. } = self;
        if let Some(product) = &mut products[*which] {
            product.displacement(&forces[range.clone()], &mut displacements[range.clone()]);
            *work += product.work();
        }
        for &(cell, state, first) in &self.cells {
            let [x, y, z] = self.displacements[cell];
            out[first] = z * self.scale[first];
            match state {
                State::Slipping([ex, ey], rest, rigidity) => {
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

    /// Returns the place of a cell with room round the window.
    fn place(&self, cell: usize) -> usize {
        (cell / self.across + RADIUS) * (self.across + 2 * RADIUS) + cell % self.across + RADIUS
    }

    /// Finds unknowns that nearly have these residuals.
    fn precondition(&mut self, residuals: &[f64], out: &mut [f64]) {
        for &(cell, state, first) in &self.cells {
            let (place, z) = (self.place(cell), residuals[first]);
            self.padded[place] = match state {
                State::Slipping(..) => [0.0, 0.0, z],
                _ => [residuals[first + 1], residuals[first + 2], z],
            };
        }
        let (width, row) = (2 * RADIUS + 1, self.across + 2 * RADIUS);
        let [sx, sy, sz] = &self.stencils;
        for &(cell, state, first) in &self.cells {
            let corner = self.place(cell) - RADIUS * (row + 1);
            let mut sum = [0.0; COMPONENTS];
            for a in 0..width {
                let near = &self.padded[corner + a * row..][..width];
                let weights = sx[a * width..].iter().zip(&sy[a * width..]).zip(&sz[a * width..]);
                for ([x, y, z], ((wx, wy), wz)) in near.iter().zip(weights) {
                    sum = [sum[0] + wx * x, sum[1] + wy * y, sum[2] + wz * z];
                }
            }
            out[first] = sum[2];
            match state {
                State::Slipping(..) => out[first + 1] = residuals[first + 1],
                _ => (out[first + 1], out[first + 2]) = (sum[0], sum[1]),
            }
        }
        for &(cell, ..) in &self.cells {
            let place = self.place(cell);
            self.padded[place] = [0.0; COMPONENTS];
        }
    }

    /// Solves the equations from a guess, and writes the forces. The residual, as a force, comes down by a `reduction`,
    /// or to the `least` \[N\] that is of use.
    pub(crate) fn solve(
        &mut self,
        conditions: &Conditions<'_>,
        forces: &mut [Vector],
        [reduction, least]: [f64; 2],
        most: u64,
    ) -> Solved {
        let (count, friction) = (self.unknowns, conditions.friction);
        let mut unknowns = vec![0.0; count];
        for &(cell, state, first) in &self.cells {
            let [x, y, z] = forces[cell];
            unknowns[first] = z;
            match state {
                State::Slipping([ex, ey], ..) => unknowns[first + 1] = ex * y - ey * x,
                _ => (unknowns[first + 1], unknowns[first + 2]) = (x, y),
            }
        }
        let (mut residual, mut products) = (vec![0.0; count], 0);
        let mut goal = least;
        while count > 0 && products < most {
            self.apply(friction, &unknowns, &mut residual);
            products += 1;
            let right = self.right.iter().zip(&self.scale);
            residual.iter_mut().zip(right).for_each(|(own, (right, scale))| *own = right * scale - *own);
            let first = dot(&residual, &residual).sqrt();
            if products == 1 {
                goal = least.max(reduction * first);
            }
            if first <= goal || !first.is_finite() {
                break;
            }
            let steps = self.minimise(friction, (&residual, first), goal, most - products);
            products += steps.len() as u64;
            let mut change = vec![0.0; count];
            for (step, direction) in steps.iter().zip(&self.directions) {
                change.iter_mut().zip(direction).for_each(|(own, direction)| *own += step * direction);
            }
            self.precondition(&change, &mut residual);
            unknowns.iter_mut().zip(&residual).for_each(|(own, change)| *own += change);
            if steps.len() < DIRECTIONS {
                break;
            }
        }
        self.expand(friction, &unknowns);
        forces.copy_from_slice(&self.forces);
        Solved { products }
    }

    /// Finds the steps along the directions that make a residual smallest.
    fn minimise(&mut self, friction: &[f64], (residual, first): (&[f64], f64), goal: f64, most: u64) -> Vec<f64> {
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
            self.precondition(&directions[place], &mut near);
            self.apply(friction, &near, &mut next);
            let mut column = Vec::with_capacity(place + 2);
            for direction in &directions {
                let share = dot(direction, &next);
                next.iter_mut().zip(direction).for_each(|(next, direction)| *next -= share * direction);
                column.push(share);
            }
            let norm = dot(&next, &next).sqrt();
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
