//! Forces where each slice yields by a compliance in series with the coupled tread: the local law.
//!
//! A slice that takes up the force f is pressed into the tread by p_i(f) = S_i^-1(c f) - c f more than the element as
//! a whole yields. The compliance c belongs to the tread under the stones: it is kappa/(dx b), the same whatever the
//! time step.
//!
//! ```text
//! G0 F + p(F) = y on the set, F >= 0, G0 F >= y off it;    with v = y - G0 F + c F:    c F = S(v).
//! ```
//!
//! 1. Guess v by a sweep of non-linear Gauss-Seidel from the previous step's forces moved with the road. A point alone
//!    has w + (G0_ii/c - 1) S(w) = y_i - sum over j != i of G0_ij F_j, monotone and piecewise linear in w, and F_i =
//!    S(w)/c.
//! 2. On the pieces S_i = s_i v + o_i that hold v, semismooth Newton (Qi & Sun 1993, *Mathematical Programming* 58,
//!    353) is the linear system, on the points with s_i > 0,
//!    ```text
//!    (G0_ij + c (1/s_i - 1) delta_ij) F_j = y_i + o_i/s_i,
//!    ```
//!    symmetric and positive definite; that a soft slice makes a large diagonal is harmless, because L D L^T does not
//!    depend on how rows and columns are scaled. A piece with s_i = 0 carries nothing.
//! 3. Points whose v has left their piece take the one that holds it, all at once, while their number falls or for ten
//!    rounds in which it does not.
//! 4. Otherwise 4, 8, 16, ... sweeps of step 1 go before every Newton step; their uses are counted.
//!
//! There is exactly one F for any c > 0: p_i grows with f because the slope of S_i is at most 1, and G0 is positive
//! definite, so the conditions are those of the minimum of the strictly convex 1/2 F.G0 F - y.F + sum of the integrals
//! of p_i. The sweeps converge to it from anywhere (Luo & Tseng 1992, *SIAM J. Control Optim.* 30, 408), and next to
//! it, where every piece at hand holds it, one Newton step is exact: the search ends. With S(y) = y, p = 0 and this is
//! the paper's equation 4.
//!
//! With rotation, G0 = G_s + G_a has a skew part. There is still one F: p_i grows with f, and x.G0 x > 0. The sweeps
//! of step 4 are those of G_s with the displacements by G_a as they were before them: each time max |O_n|/E_n of the
//! error remains, and the distance to the minimum that they have not covered.
//!
//! The equations of step 2 are solved by corrections of the forces of step 1,
//!
//! ```text
//! F <- F + P^-1 r,    r_i = (S_i(v_i) - c F_i)/s_i,
//! ```
//!
//! until S(v) - c F, taken from the whole G0, is below half of the tolerance. P is symmetric. The influence of a force
//! reaches c_P/s within a time step (s = c'/dt), some elements whatever their length, so a band of the matrix is as
//! good a P as the whole: it leaves out some thousandths of G0_ii as a sum over a row, less beside soft slices, and
//! each correction leaves that and max |O_n|/E_n of the error. Small sets take the whole matrix, and so does a set
//! whose band does not halve the error in the norm of P: then max |O_n|/E_n remains, as in `active_set`, so that the
//! search is certain to end.
//!
//! Nothing is carried from step to step but the forces. A stored factor of the whole matrix has other slopes, and
//! the older it is, the larger the error that a correction leaves: bench `linear_solvers`.
//!
//! Cost of a round of m points and a band of w columns: m w^2/2 multiply-adds for the factors (m^3/6 of the whole
//! matrix), for each correction 2 m w and m^2, for the last m x columns.

use std::ops::Range;

use super::active_set::{CORRECTIONS, ExpectedSearch, Residuals};
use super::ldlt::Ldlt;
use super::pieces::{HeldPiece, LocalSlice};
use super::residue::{Residue, Unsolved};
use super::sweeps::{PATIENCE, PointLaw, SearchCounts, Surface, move_on};
use super::tiles::{LINE, add_to_diagonal, packed_length};
use crate::counters::{Meter, Stage, Work};
use crate::numeric::{Aligned, largest_or_zero};
use crate::road::slices::StiffnessCurve;
use crate::road::strip::RoadStrip;
use crate::storage::state::evolving;

/// Sweeps of the guess. A second one costs more than the solves that it saves: an instant of dense asphalt takes 2.00
/// solves without sweeps, 1.11 (N = 512) and 1.08 (N = 1024) with one, 1.00 with two.
const SWEEPS: usize = 1;
/// Rest outside a band as part of G0_ii: with slices that are soft beside G0 each correction leaves less than this
/// part. From 0.001 to 0.006 the search takes the same time; a skew part leaves as much.
const REST_OF_A_BAND: f64 = 0.003;
/// Points for each block of a band from which on the band is cheaper than the whole matrix. Measured, bench
/// `linear_solvers`.
const POINTS_OF_A_BAND: usize = 16;
/// Doublings of the fallback's sweeps: 4 to 2^17.
const MOST_ROUNDS: u32 = 16;

/// Slices under the columns of a window.
#[derive(Clone, Copy)]
pub(crate) struct SlicesUnder<'a> {
    /// Road that holds the slices.
    pub slices: &'a RoadStrip,
    /// Element number of the first column.
    pub first_element: i64,
}

impl<'a> SlicesUnder<'a> {
    /// Slice under a column; `None` where there is no road.
    pub(crate) fn get(&self, column: usize) -> Option<&'a StiffnessCurve> {
        self.slices.curve(self.first_element + column as i64)
    }
}

/// The search with its scratch.
pub(crate) struct LocalSet {
    surface: Surface,
    /// Compliance c of a slice \[m/N\].
    compliance: f64,
    tolerance: f64,
    /// Rounds of plain exchange that may fail; `None`: sweeps go before every round but the first.
    patience: Option<u32>,
    law: LocalSlice,
    /// Piece of every column.
    pieces: Vec<HeldPiece>,
    /// Columns that may carry force.
    reach: Range<usize>,
    /// Columns whose piece carries force, rising.
    points: Vec<usize>,
    /// Scratch for those of the next round.
    next_points: Vec<usize>,
    /// c (1/s_i - 1) of the points \[m/N\].
    diagonal: Vec<f64>,
    /// (S(v) - c F)/s of the points \[m\].
    residual: Vec<f64>,
    /// Blocks of columns of a band of the matrix that serves in place of the whole.
    band: usize,
    matrix: Aligned,
    right: Aligned,
    solver: Ldlt,
}

/// Blocks of columns of the band outside which the rest, as a sum over a row, is a small part of G0_ii.
fn blocks_of_band(influence: &[f64]) -> usize {
    let mut rest = 0.0;
    let far = influence.iter().rposition(|value| {
        rest += 2.0 * value.abs();
        rest > REST_OF_A_BAND * influence[0]
    });
    far.unwrap_or(0).div_ceil(LINE)
}

/// Columns of a row of a band, on average.
fn band_width(rows: usize, band: usize) -> u64 {
    rows.min(LINE * band + LINE / 2) as u64
}

/// Entries of a band on both sides of the diagonal.
fn band_entries(rows: usize, band: usize) -> u64 {
    let width = band_width(rows, band);
    width * (2 * rows as u64 - width)
}

impl LocalSet {
    /// Search over `columns` points, as [`super::active_set::ActiveSet::new`], with slices of a compliance c \[m/N\]
    /// in series.
    pub(crate) fn new(influence: Vec<f64>, compliance: f64, columns: usize, tolerance: f64) -> Self {
        let band = blocks_of_band(&influence);
        Self {
            law: LocalSlice::new(influence[0], compliance),
            surface: Surface::new(influence, columns),
            compliance,
            tolerance,
            patience: Some(PATIENCE),
            pieces: vec![HeldPiece::default(); columns],
            reach: 0..0,
            points: Vec::with_capacity(columns),
            next_points: Vec::with_capacity(columns),
            diagonal: Vec::with_capacity(columns),
            residual: Vec::with_capacity(columns),
            band,
            matrix: Aligned::new(packed_length(columns)),
            right: Aligned::new(columns.next_multiple_of(LINE)),
            solver: Ldlt::new(columns),
        }
    }

    /// Adds a skew part of G0 by distance, of a tyre that turns; empty at rest.
    #[must_use]
    pub(crate) fn with_skew(mut self, odd: &[f64]) -> Self {
        self.surface.add_skew(odd);
        self
    }

    /// Estimates the search for `points` points in contact: a sweep, and rounds of a matrix each, with pieces of
    /// curves to be looked up. Counted on dense asphalt: 2.4, 1.88, 1.11, 1.09 rounds for 4, 10, 35, 68 points.
    /// Corrections where a band serves, and where the tyre `turns`.
    pub(crate) fn expected(points: f64, columns: f64, smooth: bool, turns: bool) -> ExpectedSearch {
        let rounds = if smooth { 1.0 } else { (1.05 + 80.0 / points.powi(2)).min(2.4) };
        // As most tyres have it: two blocks.
        let (rows, band) = (points as usize, 2);
        let banded = rows >= POINTS_OF_A_BAND * band;
        let [width, entries] = [band_width(rows, band), band_entries(rows, band)].map(|count| count as f64);
        let (factor, entries) =
            if banded { (0.5 * points * width * width, entries) } else { (points.powi(3) / 6.0, points * points) };
        let corrections = if banded || turns { CORRECTIONS } else { 0.0 };
        let of_a_round = factor + entries + points * columns;
        ExpectedSearch {
            points: 3.0 * points,
            multiply_adds: points * columns + rounds * of_a_round + corrections * (2.0 * entries + points * points),
            solves: rounds + corrections,
            factorisations: if banded { 0.0 } else { rounds },
            bands: if banded { rounds } else { 0.0 },
        }
    }

    /// Moves on by `by` elements: column i becomes column i - `by`.
    pub(crate) fn advance(&mut self, by: usize) {
        self.surface.advance(by);
        move_on(&mut self.pieces, by);
    }

    /// Finds the forces \[N\] for the penetrations y \[m\] in `required`, -infinity where nothing can touch. On return
    /// `required` holds d_i = y_i - p_i(F_i), the displacement that equation 4 would have to require for the same
    /// forces.
    pub(crate) fn search(
        &mut self,
        slices: SlicesUnder<'_>,
        required: &mut [f64],
        forces: &mut [f64],
        meter: &mut Meter,
    ) -> Result<Residuals, Unsolved> {
        forces.fill(0.0);
        let largest = largest_or_zero(required);
        let tolerance = self.tolerance * largest;
        if largest <= 0.0 {
            self.points.clear();
            self.reach = 0..0;
            self.surface.rest();
        } else {
            self.settle(slices, required, tolerance, forces, meter)?;
        }
        for column in self.reach.clone() {
            let v = self.felt(column, required[column], forces[column]);
            // No v < 0 is finite where there is no road.
            if v > 0.0 {
                let piece = &mut self.pieces[column];
                piece.go_to(v, self.law, || slices.get(column));
                required[column] += piece.displacement(v) - v;
            }
        }
        let reach = self.reach.clone();
        Ok(Residuals::of(&required[reach.clone()], &forces[reach.clone()], &self.surface.displacement[reach]))
    }

    fn settle(
        &mut self,
        slices: SlicesUnder<'_>,
        y: &[f64],
        tolerance: f64,
        forces: &mut [f64],
        meter: &mut Meter,
    ) -> Result<(), Unsolved> {
        self.reach = self.surface.reach(y);
        self.sweep(slices, y, SWEEPS, false);
        forces.copy_from_slice(&self.surface.estimate);
        self.surface.displaced_within(y, self.reach.clone());
        self.begin_again(forces, false);
        let largest = largest_or_zero(y);
        let (mut lowest, mut patience, mut solves, mut rounds) = (usize::MAX, self.patience, 0, 0);
        loop {
            let mut residue = Residue::new(largest, tolerance, rounds > 0);
            solves += self.solve(y, &mut residue, forces, meter)?;
            let wrong = self.exchange(slices, y, tolerance, forces);
            if wrong == 0 {
                // At rest a solution with the whole matrix is as accurate as it gets.
                if self.surface.is_skew() {
                    residue.settled()?;
                }
                break;
            }
            self.begin_again(forces, false);
            if patience.is_some() && wrong < lowest {
                lowest = wrong;
                patience = self.patience;
            } else if let Some(tries) = patience.and_then(|patience| patience.checked_sub(1)) {
                patience = Some(tries);
            } else if rounds < MOST_ROUNDS {
                self.surface.displace_estimate();
                self.sweep(slices, y, 4 << rounds, true);
                rounds += 1;
                forces.copy_from_slice(&self.surface.estimate);
                self.begin_again(forces, true);
            } else {
                return Err(Unsolved::Unsettled);
            }
        }
        self.surface.found(forces, solves, rounds > 0);
        Ok(())
    }

    /// v = y - G0 F + c F \[m\].
    fn felt(&self, column: usize, y: f64, force: f64) -> f64 {
        y - (self.surface.displacement[column] - self.compliance * force)
    }

    /// Prepares for another round after the points have changed, and the forces too if they are `new`: removes forces
    /// off the points, and finds the displacements within reach if anything has changed.
    fn begin_again(&mut self, forces: &mut [f64], new: bool) {
        let mut points = self.points.iter().copied().peekable();
        let mut changed = new;
        for (column, force) in forces.iter_mut().enumerate() {
            if points.next_if_eq(&column).is_none() && *force != 0.0 {
                *force = 0.0;
                changed = true;
            }
        }
        if changed {
            self.surface.displace_within(forces, &self.reach);
        }
    }

    /// Sweeps from the estimate, and finds the pieces that hold the results; `lagged`: with the displacements by a
    /// skew part of G0 as they were before the sweeps.
    fn sweep(&mut self, slices: SlicesUnder<'_>, y: &[f64], sweeps: usize, lagged: bool) {
        let Self { law, pieces, surface, reach, points, .. } = self;
        let (influence, law) = (surface.influence[0], *law);
        points.clear();
        let alone = SliceAlone { influence, law, slices, pieces: &mut *pieces };
        let (forces, residual) = surface.sweep(alone, sweeps, y, reach.clone(), lagged);
        for (column, (residual, force)) in reach.clone().zip(residual.iter().zip(forces)) {
            let v = residual + self.compliance * force;
            if v > 0.0 && pieces[column].go_to(v, law, || slices.get(column)) {
                points.push(column);
            }
        }
    }

    /// Gives every point whose v has left its piece by more than the tolerance the one that holds it; returns the
    /// number of such points.
    fn exchange(&mut self, slices: SlicesUnder<'_>, y: &[f64], tolerance: f64, forces: &[f64]) -> usize {
        self.reach_for_broken(y);
        let mut wrong = 0;
        let mut held = self.points.iter().copied().peekable();
        self.next_points.clear();
        for column in self.reach.clone() {
            let v = self.felt(column, y[column], forces[column]);
            let piece = &mut self.pieces[column];
            let carries = if held.next_if_eq(&column).is_some() {
                let stays = v > 0.0 && piece.holds(v)
                    || forces[column] >= 0.0 && piece.from - tolerance <= v && v <= piece.to + tolerance;
                wrong += usize::from(!stays);
                stays || v > 0.0 && piece.go_to(v, self.law, || slices.get(column))
            } else {
                let mut found = *piece;
                let joins =
                    v > 0.0 && found.go_to(v, self.law, || slices.get(column)) && found.displacement(v) > tolerance;
                if joins {
                    *piece = found;
                    wrong += 1;
                }
                joins
            };
            if carries {
                self.next_points.push(column);
            }
        }
        std::mem::swap(&mut self.points, &mut self.next_points);
        wrong
    }

    /// Extends the reach to columns that others lift off less than they are pressed down: to none where no influence
    /// is negative.
    fn reach_for_broken(&mut self, y: &[f64]) {
        let broken = |column: &usize| y[*column] > self.surface.displacement[*column];
        let (first, last) = ((0..self.reach.start).find(broken), (self.reach.end..y.len()).rfind(broken));
        self.reach = first.unwrap_or(self.reach.start)..last.map_or(self.reach.end, |last| last + 1);
    }

    /// Finds F on the pieces, then u everywhere, by corrections of forces on the points whose displacement is known;
    /// returns their number.
    fn solve(
        &mut self,
        y: &[f64],
        residue: &mut Residue,
        forces: &mut [f64],
        meter: &mut Meter,
    ) -> Result<usize, Unsolved> {
        let rows = self.points.len();
        if rows == 0 {
            forces.fill(0.0);
            self.surface.displace(forces);
            return Ok(0);
        }
        self.diagonal.clear();
        self.diagonal
            .extend(self.points.iter().map(|&point| self.compliance * (self.pieces[point].slope.recip() - 1.0)));
        let mut band = if rows < POINTS_OF_A_BAND * self.band { rows } else { self.band };
        self.factorise(band, meter)?;
        let mut solves = 0;
        loop {
            if self.is_solved(y, residue, forces) {
                break;
            }
            let stride = rows.next_multiple_of(LINE);
            let (matrix, right) = (self.matrix.part(0, packed_length(rows)), self.right.part(0, stride));
            right[..rows].copy_from_slice(&self.residual);
            self.solver.solve_band(matrix, right, stride, rows, band)?;
            let entries = band_entries(rows, band);
            self.surface.counts.work += Work { multiply_adds: 2 * entries, bytes: 8 * entries };
            solves += 1;
            if residue.stalls(right.iter().zip(&self.residual).map(|(change, residual)| change * residual).sum()) {
                if band >= rows {
                    break;
                }
                band = rows;
                residue.restart();
                self.surface.counts.factors.refactorisations += 1;
                self.factorise(band, meter)?;
                continue;
            }
            self.points.iter().zip(&*right).for_each(|(&point, change)| forces[point] += change);
            self.surface.displace_within(forces, &self.reach);
        }
        self.surface.displace_beside(forces, &self.reach);
        Ok(solves)
    }

    /// Finds (S(v) - c F)/s of the points and returns whether S(v) - c F is small enough.
    fn is_solved(&mut self, y: &[f64], residue: &mut Residue, forces: &[f64]) -> bool {
        let Self { surface, compliance, pieces, points, residual, .. } = self;
        residual.clear();
        residue.is_small(points.iter().map(|&point| {
            let (piece, taken) = (&pieces[point], *compliance * forces[point]);
            let missing = piece.displacement(y[point] - (surface.displacement[point] - taken)) - taken;
            residual.push(missing / piece.slope);
            missing
        }))
    }

    /// Factorises the matrix of the points, or a band of it.
    fn factorise(&mut self, band: usize, meter: &mut Meter) -> Result<(), Unsolved> {
        let rows = self.points.len();
        let mut laps = meter.laps();
        let matrix = self.matrix.part(0, packed_length(rows));
        self.solver.assemble_band(&self.points, &self.surface.influence, matrix, band);
        add_to_diagonal(matrix, &self.diagonal);
        self.solver.factorise_band(matrix, rows, band)?;
        meter.lap(&mut laps, Stage::Factorisation);
        let width = band_width(rows, band);
        let multiply_adds = width * width * (3 * rows as u64 - 2 * width) / 6;
        let factorisation = Work { multiply_adds, bytes: 8 * band_entries(rows, band) };
        let counts = &mut self.surface.counts;
        *(if band < rows { &mut counts.factors.bands } else { &mut counts.factors.factorisations }) += 1;
        counts.factorisation += factorisation;
        counts.work += factorisation;
        Ok(())
    }

    pub(crate) fn counts(&self) -> SearchCounts {
        self.surface.counts.clone()
    }

    /// u = G0 F of the last search, springs included \[m\].
    pub(crate) fn displacement(&self) -> &[f64] {
        &self.surface.displacement
    }

    /// Number of points of the last linear system.
    pub(crate) fn points(&self) -> usize {
        self.points.len()
    }
}

evolving!(LocalSet: surface);

/// The law of a point alone.
struct SliceAlone<'a> {
    /// G0_ii.
    influence: f64,
    law: LocalSlice,
    slices: SlicesUnder<'a>,
    pieces: &'a mut [HeldPiece],
}

impl PointLaw for SliceAlone<'_> {
    #[inline(always)]
    fn force(&mut self, column: usize, force: f64, residual: f64) -> f64 {
        let slices = self.slices;
        self.pieces[column].force(residual + self.influence * force, self.law, || slices.get(column))
    }
}

#[cfg(test)]
#[path = "local_tests.rs"]
mod tests;
