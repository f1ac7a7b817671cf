//! A set of points solved with the factor of another one that differs from it by few points.
//!
//! With S0 the set whose factor is stored, A the points that have come and R those that have gone, F_0 = G_00^-1 (d_0 +
//! E_R lambda - G_0A F_A), where lambda holds the points R at no force, as if they were pulled off. F_R = 0 and the
//! points A give a symmetric system for lambda and F_A,
//!
//! ```text
//! [  Z_RR    -Z_RA                  ] [lambda]   [        -Z_d,R        ]
//! [ -Z_RA^T  -(G_AA - G_A0 Z_A)     ] [ F_A  ] = [ -(d_A - G_A0 Z_d)    ],   Z = G_00^-1 [d_0, E_R, G_0A],
//! ```
//!
//! with a positive definite block and a negative definite one, so that it, too, has factors without exchanges
//! (Vanderbei 1995, *SIAM J. Optim.* 5, 100). Entries of d_0 and G_0A at points that have gone are free: lambda makes
//! up for them; they are zero.
//!
//! Cost: one solution with the stored factor for every point that differs and one more, instead of a factorisation.

use std::cmp::Ordering;

use super::tiles::assemble_entries;
use crate::storage::state::{Evolving, StateError, StateStream, ensure};

/// Most points by which a set may differ.
pub(crate) const MOST_DIFFERENT: usize = 16;
/// Points of a set for each one that may differ: with fewer a factorisation is not more expensive. Measured, bench
/// `linear_solvers`.
const POINTS_TO_A_DIFFERENCE: usize = 8;

/// The set whose factor is stored, and how another one differs from it. Nothing allocates after [`Self::new`].
pub(super) struct NeighbourSet {
    /// Slot of the stored factor, if there is one.
    pub(super) slot: Option<usize>,
    /// S0, rising, by column when its factor was last used; negative ones have left the window since.
    stored: Vec<i64>,
    /// Points of both sets, as positions in S0 and in the set asked for.
    common: Vec<(usize, usize)>,
    /// A, as positions in the set asked for.
    added: Vec<usize>,
    /// R, as positions in S0.
    removed: Vec<usize>,
}

impl NeighbourSet {
    /// Nothing stored, with space for sets of at most `points` points.
    pub(super) fn new(points: usize) -> Self {
        Self {
            slot: None,
            stored: Vec::with_capacity(points),
            common: Vec::with_capacity(points),
            added: Vec::with_capacity(MOST_DIFFERENT + 1),
            removed: Vec::with_capacity(MOST_DIFFERENT + 1),
        }
    }

    /// Keeps a set and the slot of its factor.
    pub(super) fn keep(&mut self, slot: usize, points: &[usize]) {
        self.slot = Some(slot);
        self.stored.clear();
        self.stored.extend(points.iter().map(|&point| point as i64));
    }

    /// Moves on by `by` elements: column i becomes column i - `by`.
    pub(super) fn advance(&mut self, by: usize) {
        self.stored.iter_mut().for_each(|point| *point -= by as i64);
    }

    /// Slot of a factor that serves for the points, if they differ little enough from its set: then A and R are known.
    pub(super) fn serves(&mut self, points: &[usize]) -> Option<usize> {
        let slot = self.slot?;
        let most = (points.len() / POINTS_TO_A_DIFFERENCE).min(MOST_DIFFERENT);
        self.common.clear();
        self.added.clear();
        self.removed.clear();
        let (mut new, mut old) = (0, 0);
        while new < points.len() || old < self.stored.len() {
            if self.added.len() + self.removed.len() > most {
                return None;
            }
            let order = match (points.get(new), self.stored.get(old)) {
                (Some(&point), Some(stored)) => (point as i64).cmp(stored),
                (Some(_), None) => Ordering::Less,
                _ => Ordering::Greater,
            };
            match order {
                Ordering::Less => self.added.push(new),
                Ordering::Greater => self.removed.push(old),
                Ordering::Equal => self.common.push((old, new)),
            }
            new += usize::from(order.is_le());
            old += usize::from(order.is_ge());
        }
        (self.added.len() + self.removed.len() <= most).then_some(slot)
    }

    /// Number of points of S0.
    pub(crate) fn stored_points(&self) -> usize {
        self.stored.len()
    }

    /// Number of points that differ.
    pub(crate) fn different(&self) -> usize {
        self.added.len() + self.removed.len()
    }

    /// Writes d_0 into `column`.
    pub(crate) fn right_side(&self, d: &[f64], column: &mut [f64]) {
        column.fill(0.0);
        for &(old, new) in &self.common {
            column[old] = d[new];
        }
    }

    /// Writes \[d_0, E_R, G_0A\] column by column, each of `stride` numbers.
    pub(crate) fn right_sides(
        &self,
        points: &[usize],
        influence: &[f64],
        d: &[f64],
        stride: usize,
        columns: &mut [f64],
    ) {
        let (first, rest) = columns.split_at_mut(stride);
        self.right_side(d, first);
        rest.fill(0.0);
        let (removed, added) = rest.split_at_mut(stride * self.removed.len());
        for &(old, new) in &self.common {
            for (column, &added) in added.chunks_exact_mut(stride).zip(&self.added) {
                column[old] = influence[points[added].abs_diff(points[new])];
            }
        }
        for (column, &old) in removed.chunks_exact_mut(stride).zip(&self.removed) {
            column[old] = 1.0;
        }
    }

    /// Writes the system for lambda and F_A, to be factorised by [`super::ldlt`], to `matrix` and its right side to
    /// `right`, from Z.
    pub(super) fn system(
        &self,
        points: &[usize],
        influence: &[f64],
        d: &[f64],
        (z, stride): (&[f64], usize),
        matrix: &mut [f64],
        right: &mut [f64],
    ) {
        let (size, removed) = (self.different(), self.removed.len());
        let row = |different: usize, column: usize| self.row(points, influence, (z, stride), different, column);
        let entry = |different: usize, column: usize| {
            let value = row(different, 1 + column);
            match (column < removed, different < removed) {
                (true, true) => value,
                (true, false) => -value,
                _ => {
                    let (a, b) = (self.added[different - removed], self.added[column - removed]);
                    value - influence[points[a].abs_diff(points[b])]
                }
            }
        };
        assemble_entries(size, entry, matrix);
        self.system_right(points, influence, d, (z, stride), right);
    }

    /// Writes the right side of that system alone.
    pub(crate) fn system_right(
        &self,
        points: &[usize],
        influence: &[f64],
        d: &[f64],
        z: (&[f64], usize),
        right: &mut [f64],
    ) {
        for (different, right) in right[..self.different()].iter_mut().enumerate() {
            let value = self.row(points, influence, z, different, 0);
            *right = match different.checked_sub(self.removed.len()) {
                None => -value,
                Some(added) => value - d[self.added[added]],
            };
        }
    }

    /// Value of column `column` of Z in row `different` of the system: at a point that has gone the entry itself, at
    /// one that has come the displacement by it there.
    fn row(
        &self,
        points: &[usize],
        influence: &[f64],
        (z, stride): (&[f64], usize),
        different: usize,
        column: usize,
    ) -> f64 {
        let z = &z[column * stride..(column + 1) * stride];
        match self.removed.get(different) {
            Some(&old) => z[old],
            None => {
                let added = points[self.added[different - self.removed.len()]];
                self.common.iter().map(|&(old, new)| influence[added.abs_diff(points[new])] * z[old]).sum()
            }
        }
    }

    /// Forces in the order of the points asked for, from Z and the solution of the system.
    pub(super) fn forces(&self, (z, stride): (&[f64], usize), solution: &[f64], forces: &mut [f64]) {
        let (lambda, added) = solution[..self.different()].split_at(self.removed.len());
        for &(old, new) in &self.common {
            let columns = |first: usize| z[first * stride..].chunks_exact(stride).map(move |column| column[old]);
            let pulled: f64 = columns(1).zip(lambda).map(|(z, lambda)| z * lambda).sum();
            let pushed: f64 = columns(1 + lambda.len()).zip(added).map(|(z, force)| z * force).sum();
            forces[new] = z[old] + pulled - pushed;
        }
        for (&new, &force) in self.added.iter().zip(added) {
            forces[new] = force;
        }
    }
}

impl Evolving for NeighbourSet {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        let most = self.stored.capacity();
        state.value(&mut self.slot)?;
        state.growing(&mut self.stored)?;
        ensure(self.stored.len() <= most && self.stored.is_sorted())
    }
}

#[cfg(test)]
mod tests {
    use super::super::factors::FactorCache;
    use crate::counters::Meter;

    fn influence(distance: usize) -> f64 {
        if distance == 0 { 1.3 } else { 1.0 / (1.0 + distance as f64 / 3.0).powi(2) }
    }

    /// Largest |G f - d| over the points.
    fn residual(points: &[usize], forces: &[f64], d: &[f64]) -> f64 {
        let at = |i: usize| points.iter().zip(forces).map(|(&j, f)| influence(i.abs_diff(j)) * f).sum::<f64>();
        points.iter().zip(d).map(|(&i, d)| (at(i) - d).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn sets_that_change_and_move_on_are_solved_to_rounding() {
        const COLUMNS: usize = 150;
        let row: Vec<f64> = (0..COLUMNS).map(influence).collect();
        let mut cache = FactorCache::new(64, COLUMNS);
        // Stones that stay where they are while the window passes; some come late or go early.
        let touches = |element: usize, step: usize| {
            let column = element as i64 - step as i64;
            let (rough, late) = (element * 7919, element * 31 + step / (3 + element % 4));
            (20..130).contains(&column) && !rough.is_multiple_of(5) && !late.is_multiple_of(6)
        };
        for step in 0..200 {
            let points: Vec<usize> = (0..COLUMNS).filter(|column| touches(column + step, step)).collect();
            let d: Vec<f64> = points.iter().map(|&point| 1.0 + (point as f64).sin()).collect();
            let mut forces = d.clone();
            cache.solve(&points, &row, &mut forces, &mut Meter::default()).unwrap();
            let error = residual(&points, &forces, &d);
            assert!(error < 1e-13, "{step}: {error:e}");
            cache.advance(1);
        }
        let counts = cache.counts();
        assert_eq!(counts.misses, counts.neighbours + counts.factorisations);
        assert!(counts.neighbours > 20 && counts.factorisations > 20, "both ways are taken: {counts:?}");
    }

    #[test]
    fn points_that_come_at_either_end_go_or_both() {
        const COLUMNS: usize = 60;
        let row: Vec<f64> = (0..COLUMNS).map(influence).collect();
        let stored: Vec<usize> = (10..50).collect();
        let without =
            |removed: &[usize]| stored.iter().copied().filter(|point| !removed.contains(point)).collect::<Vec<_>>();
        let with = |added: &[usize], mut points: Vec<usize>| {
            points.extend(added);
            points.sort_unstable();
            points
        };
        let sets = [
            without(&[10]),
            without(&[23, 49]),
            with(&[9], stored.clone()),
            with(&[5, 50], stored.clone()),
            with(&[8, 55], without(&[10, 30])),
        ];
        for points in sets {
            let mut cache = FactorCache::new(8, COLUMNS);
            cache.solve(&stored, &row, &mut vec![1.0; stored.len()], &mut Meter::default()).unwrap();
            let d: Vec<f64> = points.iter().map(|&point| (point as f64).cos()).collect();
            let mut forces = d.clone();
            cache.solve(&points, &row, &mut forces, &mut Meter::default()).unwrap();
            assert_eq!((cache.counts().neighbours, cache.counts().factorisations), (1, 1));
            assert!(residual(&points, &forces, &d) < 1e-14, "{points:?}");
        }
    }
}
