//! Which points touch, and with which forces.
//!
//! Find F with F >= 0, G0 F >= d and F.(G0 F - d) = 0. G0 is symmetric positive definite, so there is exactly one F.
//!
//! Block principal pivoting (Judice & Pires 1994, *Computers & Operations Research* 21, 587):
//! 1. guess the set of points in contact: the previous step's forces, moved with the road, brought near today's by two
//!    sweeps of projected Gauss-Seidel; where they are positive there is contact;
//! 2. solve G0 F = d on the set (cached factors); points with F < 0 leave, points with G0 F < d join: the exchange of
//!    the paper;
//! 3. while the number of such points falls, or for ten rounds in which it does not, exchange all of them at once;
//! 4. otherwise exchange only the last of them (least-index pivoting, Murty 1974), until the number is below the lowest
//!    so far. For a positive definite matrix this must happen within finitely many exchanges, so the whole search
//!    always ends. Uses are counted.
//!
//! Cost: one solve with cached factors (2 m^2 flops) and m x columns multiply-adds per round.
//!
//! With rotation, G0 = G_s + G_a has a skew part, and there is still one F: G_s is positive definite, so that every
//! principal minor of G0 is positive (a P-matrix; Cottle, Pang & Stone 1992, *The Linear Complementarity Problem*, 3.3
//! and 4.2), and the search ends as above. Factors stay those of G_s. On the set F is found by corrections,
//!
//! ```text
//! F <- F + G_s^-1 (d - G0 F),
//! ```
//!
//! from the guess. Each leaves at most max |O_n|/E_n of the error, in the norm of G_s, on any set: |x^H G_a x| is
//! below that part of x^H G_s x for the ring, and so for each of its sets. They end where half of the tolerance is
//! met, or where they no longer halve the error in that norm, which is then rounding ([`Residue`]).

use serde::{Deserialize, Serialize};

use super::factors::FactorCache;
use super::residue::{Residue, Unsolved};
use super::sweeps::{PATIENCE, PointLaw, SearchCounts, Surface};
use crate::counters::Meter;
use crate::numeric::largest_or_zero;
use crate::storage::state::{Evolving, StateError, StateStream};

/// Sweeps of the guess: each costs about half a cached solve; two settle which points enter and leave at the ends of
/// the patch.
const SWEEPS: usize = 2;

/// Corrections that a tyre that turns is expected to take at a tolerance of 1e-12, beyond the first solution.
pub(super) const CORRECTIONS: f64 = 3.0;

/// Expected work of a search for the forces, for each instant of the search.
#[derive(Clone, Copy, Debug)]
pub struct ExpectedSearch {
    /// Points in contact to be visited.
    pub points: f64,
    /// Multiply-adds.
    pub multiply_adds: f64,
    /// Linear solves.
    pub solves: f64,
    /// Factorisations.
    pub factorisations: f64,
    /// Factorisations of a band.
    pub bands: f64,
}

/// How far the contact conditions are missed, at worst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Residuals {
    /// max(-F) \[N\].
    pub tension: f64,
    /// max(d - u) \[m\].
    pub penetration: f64,
    /// max |F (u - d)| \[N m\].
    pub complementarity: f64,
}

impl Residuals {
    /// Residuals of forces \[N\] and u = G0 F \[m\] where d \[m\] is required.
    pub(crate) fn of(d: &[f64], forces: &[f64], displacement: &[f64]) -> Self {
        let mut residuals = Self::default();
        for ((&force, &d), &u) in forces.iter().zip(d).zip(displacement) {
            residuals.tension = residuals.tension.max(-force);
            residuals.penetration = residuals.penetration.max(d - u);
            if force > 0.0 {
                residuals.complementarity = residuals.complementarity.max((force * (u - d)).abs());
            }
        }
        residuals
    }

    pub(crate) fn worst(self, other: Self) -> Self {
        Self {
            tension: self.tension.max(other.tension),
            penetration: self.penetration.max(other.penetration),
            complementarity: self.complementarity.max(other.complementarity),
        }
    }
}

/// The search with its scratch.
pub struct ActiveSet {
    surface: Surface,
    tolerance: f64,
    patience: u32,
    factors: FactorCache,
    active: Vec<bool>,
    points: Vec<usize>,
    values: Vec<f64>,
}

impl ActiveSet {
    /// Search over `columns` points; `influence[j]` is G0 of points j apart \[m/N\], springs included in
    /// `influence[0]`. `tolerance` is how far d may exceed G0 F off the set, relative to the largest d;
    /// at most `cached_factors` factors are cached.
    pub fn new(influence: Vec<f64>, columns: usize, tolerance: f64, cached_factors: usize) -> Self {
        Self {
            surface: Surface::new(influence, columns),
            tolerance,
            patience: PATIENCE,
            factors: FactorCache::new(cached_factors, columns),
            active: vec![false; columns],
            points: Vec::with_capacity(columns),
            values: Vec::with_capacity(columns),
        }
    }

    /// Adds a skew part of G0 by distance, of a tyre that turns; empty at rest.
    #[must_use]
    pub fn with_skew(mut self, odd: &[f64]) -> Self {
        self.surface.add_skew(odd);
        self
    }

    /// Estimates the search for `points` points in contact. Guess, solution and displacement take some windows of
    /// multiply-adds for each of them, factorisations on rough roads included (counted on roads of all kinds);
    /// corrections where the tyre `turns`.
    pub fn expected(points: f64, columns: f64, smooth: bool, turns: bool) -> ExpectedSearch {
        let (windows, solves, factorisations) = if smooth { (2.0, 1.0, 0.0) } else { (3.5, 1.1, 0.15) };
        let corrections = if turns { CORRECTIONS } else { 0.0 };
        let correction = corrections * points * (points + columns);
        ExpectedSearch {
            points,
            multiply_adds: windows * points * columns + correction,
            solves: solves + corrections,
            factorisations,
            bands: 0.0,
        }
    }

    /// Moves on by `by` elements: column i becomes column i - `by`.
    pub fn advance(&mut self, by: usize) {
        self.surface.advance(by);
        self.factors.advance(by.min(self.active.len()));
    }

    /// Brings the estimate of the forces near the solution for `d` and takes its positive ones for the set.
    fn guess(&mut self, d: &[f64]) {
        let stiffness = self.surface.influence[0].recip();
        let reach = self.surface.reach(d);
        let _ = self.surface.sweep(Prescribed { stiffness }, SWEEPS, d, reach.clone(), false);
        if self.surface.is_skew() {
            self.surface.displaced_within(d, reach);
        }
        for (active, &force) in self.active.iter_mut().zip(&self.surface.estimate) {
            *active = force > 0.0;
        }
    }

    /// Finds the forces \[N\] for the required displacements `d` \[m\]; -infinity marks a point that cannot touch.
    /// Returns the residuals.
    ///
    /// # Errors
    /// `Unsolved`.
    pub fn search(&mut self, d: &[f64], forces: &mut [f64], meter: &mut Meter) -> Result<Residuals, Unsolved> {
        let largest = largest_or_zero(d);
        let tolerance = self.tolerance * largest;
        forces.fill(0.0);
        if largest <= 0.0 {
            self.active.fill(false);
            self.surface.rest();
            return Ok(Residuals::default());
        }
        self.guess(d);
        let is_skew = self.surface.is_skew();
        if is_skew {
            // Columns off the set have none.
            forces.copy_from_slice(&self.surface.estimate);
        }
        let (mut lowest, mut patience, mut solves, mut fell_back) = (usize::MAX, self.patience, 0, false);
        loop {
            let mut residue = Residue::new(largest, tolerance, fell_back);
            if is_skew {
                solves += self.correct(d, &mut residue, forces, meter)?;
            } else {
                self.solve(d, meter)?;
                solves += 1;
                for (&point, &force) in self.points.iter().zip(&self.values) {
                    forces[point] = force;
                }
                self.surface.displace(forces);
            }
            let (wrong, last) =
                self.broken(d, forces, tolerance).fold((0, 0), |(count, _), column| (count + 1, column));
            if wrong == 0 {
                residue.settled()?;
                break;
            }
            if wrong < lowest {
                lowest = wrong;
                patience = self.patience;
            } else if patience > 0 {
                patience -= 1;
            } else {
                // 4. Least-index pivoting: the last one alone.
                fell_back = true;
                self.active[last] = !self.active[last];
                forces[last] = 0.0;
                self.begin_again(forces);
                continue;
            }
            // 3. Exchange of all of them.
            self.points.clear();
            let mut points = std::mem::take(&mut self.points);
            points.extend(self.broken(d, forces, tolerance));
            for &column in &points {
                self.active[column] = !self.active[column];
                forces[column] = 0.0;
            }
            self.points = points;
            self.begin_again(forces);
        }
        self.surface.found(forces, solves, fell_back);
        Ok(Residuals::of(d, forces, &self.surface.displacement))
    }

    #[cfg(test)]
    pub(super) fn start_from(&mut self, forces: &[f64]) {
        self.surface.start_from(forces);
    }

    /// True if each column is in the set found by the last search.
    pub fn active(&self) -> &[bool] {
        &self.active
    }

    /// u = G0 F of the last search, springs included \[m\].
    pub fn displacement(&self) -> &[f64] {
        &self.surface.displacement
    }

    /// Work counts so far.
    pub fn counts(&self) -> SearchCounts {
        let (factors, factorisation) = (self.factors.counts(), self.factors.making());
        let mut counts = SearchCounts { factors, factorisation, ..self.surface.counts.clone() };
        counts.work += self.factors.work();
        counts
    }

    /// Columns that violate a condition: on the set F < 0, off it d - u > tolerance.
    fn broken<'a>(&'a self, d: &'a [f64], forces: &'a [f64], tolerance: f64) -> impl Iterator<Item = usize> + 'a {
        (0..d.len()).filter(move |&column| {
            if self.active[column] {
                forces[column] < 0.0
            } else {
                d[column] - self.surface.displacement[column] > tolerance
            }
        })
    }

    /// Prepares for another round after forces have been removed: corrections with a skew part need the displacement
    /// by all forces.
    fn begin_again(&mut self, forces: &[f64]) {
        if self.surface.is_skew() {
            self.surface.displace(forces);
        }
    }

    fn list_points(&mut self) {
        self.points.clear();
        self.points.extend(self.active.iter().enumerate().filter_map(|(column, &active)| active.then_some(column)));
    }

    /// F on the set, in the order of its points, in `values`.
    fn solve(&mut self, d: &[f64], meter: &mut Meter) -> Result<(), Unsolved> {
        self.list_points();
        self.values.clear();
        self.values.extend(self.points.iter().map(|&point| d[point]));
        Ok(self.factors.solve(&self.points, &self.surface.influence, &mut self.values, meter)?)
    }

    /// Finds F on the set with a skew part of G0, by corrections of forces on it whose displacement is known; returns
    /// their number.
    fn correct(
        &mut self,
        d: &[f64],
        residue: &mut Residue,
        forces: &mut [f64],
        meter: &mut Meter,
    ) -> Result<usize, Unsolved> {
        self.list_points();
        let Self { surface, factors, points, values, .. } = self;
        if points.is_empty() {
            surface.displace(forces);
            return Ok(0);
        }
        let mut solves = 0;
        loop {
            values.clear();
            values.extend(points.iter().map(|&point| d[point] - surface.displacement[point]));
            if residue.is_small(values.iter().copied()) {
                return Ok(solves);
            }
            if solves == 0 {
                factors.solve(points, &surface.influence, values, meter)?;
            } else {
                factors.solve_again(points, &surface.influence, values)?;
            }
            solves += 1;
            let changes = || points.iter().zip(&*values);
            if residue.stalls(changes().map(|(&point, change)| change * (d[point] - surface.displacement[point])).sum())
            {
                return Ok(solves);
            }
            changes().for_each(|(&point, change)| forces[point] += change);
            surface.displace(forces);
        }
    }
}

impl Evolving for ActiveSet {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        self.surface.state(state)?;
        self.factors.state(&self.surface.influence, state)
    }
}

/// A point alone, its displacement prescribed.
#[derive(Clone, Copy)]
struct Prescribed {
    /// 1/G0_ii.
    stiffness: f64,
}

impl PointLaw for Prescribed {
    #[inline(always)]
    fn force(&mut self, _: usize, force: f64, residual: f64) -> f64 {
        (force + residual * self.stiffness).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Reference: projected Gauss-Seidel to rounding (Cryer 1971): slow, simple, convergent for positive definite
    /// matrices.
    fn projected_gauss_seidel(influence: &[f64], d: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0_f64; d.len()];
        for _ in 0..200_000 {
            let mut change = 0.0_f64;
            for i in 0..d.len() {
                let u: f64 = forces.iter().enumerate().map(|(j, f)| influence[i.abs_diff(j)] * f).sum();
                let next = (forces[i] + (d[i] - u) / influence[0]).max(0.0);
                change = change.max((next - forces[i]).abs());
                forces[i] = next;
            }
            if change < 1e-15 {
                break;
            }
        }
        forces
    }

    fn decaying(columns: usize, reach: f64) -> Vec<f64> {
        (0..columns).map(|j| (-(j as f64) / reach).exp() + if j == 0 { 0.3 } else { 0.0 }).collect()
    }

    proptest! {
        #[test]
        fn finds_the_one_solution_from_any_guess(
            d in prop::collection::vec(-1.0..1.0_f64, 12),
            guess in prop::collection::vec(any::<bool>(), 12),
            reach in 0.3..3.0_f64,
        ) {
            let influence = decaying(12, reach);
            let mut search = ActiveSet::new(influence.clone(), 12, 1e-13, 64);
            search.active.copy_from_slice(&guess);
            let mut forces = vec![0.0; 12];
            let residuals = search.search(&d, &mut forces, &mut Meter::default()).unwrap();
            prop_assert!(residuals.tension <= 0.0 && residuals.penetration < 1e-12);
            prop_assert!(residuals.complementarity < 1e-12);
            for (force, exact) in forces.iter().zip(projected_gauss_seidel(&influence, &d)) {
                prop_assert!((force - exact).abs() < 1e-9, "{force} {exact}");
            }
        }
    }

    #[test]
    fn nothing_touches_when_nothing_is_required() {
        let mut search = ActiveSet::new(decaying(8, 1.0), 8, 1e-12, 4);
        let mut forces = vec![1.0; 8];
        let residuals = search
            .search(&[-1.0, 0.0, -0.5, f64::NEG_INFINITY, -2.0, -1.0, 0.0, -3.0], &mut forces, &mut Meter::default())
            .unwrap();
        assert_eq!(forces, vec![0.0; 8]);
        assert_eq!(residuals, Residuals::default());
        assert_eq!(search.counts().histogram[0], 1);
    }

    #[test]
    fn one_point_and_all_points_in_contact() {
        let influence = decaying(16, 0.5);
        let mut search = ActiveSet::new(influence.clone(), 16, 1e-12, 4);
        let mut d = vec![-1.0; 16];
        d[5] = 0.2;
        let mut forces = vec![0.0; 16];
        search.search(&d, &mut forces, &mut Meter::default()).unwrap();
        assert_eq!(forces.iter().filter(|&&force| force > 0.0).count(), 1);
        assert!((forces[5] - 0.2 / influence[0]).abs() < 1e-15);
        search.search(&[1.0; 16], &mut forces, &mut Meter::default()).unwrap();
        assert!(forces.iter().all(|&force| force > 0.0));
    }

    #[test]
    fn ties_and_nearly_identical_neighbours_end_without_cycling() {
        // Hard case: a nearly singular G0 (smooth kernel on a fine grid) with exactly equal and nearly equal
        // requirements.
        let influence: Vec<f64> =
            (0..40).map(|j| 1.0 / (1.0 + (j as f64 / 12.0).powi(2)) + if j == 0 { 1e-9 } else { 0.0 }).collect();
        let mut search = ActiveSet::new(influence, 40, 1e-12, 16);
        let mut forces = vec![0.0; 40];
        for round in 0..50 {
            let d: Vec<f64> =
                (0..40).map(|i| if (i + round) % 7 < 3 { 1.0 } else { 1.0 - 1e-14 * (i % 3) as f64 }).collect();
            let residuals = search.search(&d, &mut forces, &mut Meter::default()).unwrap();
            assert!(residuals.tension <= 0.0 && residuals.penetration < 1e-9 && residuals.complementarity < 1e-6);
        }
    }

    #[test]
    fn the_fallback_alone_finds_the_solution_too() {
        // Without patience every exchange that does not reduce the number of broken points is followed by least-index
        // ones.
        let influence = decaying(10, 6.0);
        let d: Vec<f64> = (0..10).map(|i| if i % 2 == 0 { 1.0 } else { -0.9 }).collect();
        let exact = projected_gauss_seidel(&influence, &d);
        let mut search = ActiveSet::new(influence, 10, 1e-13, 64);
        search.patience = 0;
        let mut forces = vec![0.0; 10];
        for lowest_start in [true, false] {
            search.active.fill(lowest_start);
            search.search(&d, &mut forces, &mut Meter::default()).unwrap();
        }
        for (force, exact) in forces.iter().zip(exact) {
            assert!((force - exact).abs() < 1e-9);
        }
    }
}
