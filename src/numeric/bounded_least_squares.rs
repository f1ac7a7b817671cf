//! Non-linear least squares in a box: Levenberg-Marquardt steps, cut to the box.
//!
//! Minimises |r(x)|^2, lower <= x <= upper, for unknowns of about equal scale (logarithms):
//! 1. J, the differences of r at x: one evaluation an unknown, in parallel;
//! 2. unknowns at a bound that the gradient J^T r presses them against stand still;
//! 3. the others solve min |J d + r|^2 + lambda |D d|^2 by QR, D the norms of J's columns (Marquardt 1963);
//! 4. x + d is cut to the box. A decrease is taken, and lambda follows the gain over the linear model's promise
//!    (Nielsen 1999); else lambda grows and step 3 is done again;
//! 5. the end: with little damping the linear model promises next to nothing, or lambda has outgrown every step.
//!
//! A model that has no value somewhere (NaN) is not stepped to.

use std::ops::{ControlFlow, Range};

use faer::Mat;

use super::in_parallel;
use super::rational::least_squares::{back_substitute, eliminate};

/// Step of the differences: large enough for sums with a relative error of 1e-8, small beside a narrow resonance.
const DIFFERENCE: f64 = 1e-4;
/// The damping at first, below which the linear model is trusted, and beyond which no step is left.
const FIRST_DAMPING: f64 = 1e-2;
const LITTLE_DAMPING: f64 = 1e-3;
const MOST_DAMPING: f64 = 1e10;

/// When a minimisation ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct IterationLimits {
    /// Most steps taken.
    pub steps: usize,
    /// Decrease of |r|^2 that does not justify a further step.
    pub decrease: f64,
}

/// Solution of a least-squares problem.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Minimum {
    /// Point x of the solution.
    pub point: Vec<f64>,
    /// Residuals r(x).
    pub residuals: Vec<f64>,
    /// Steps taken.
    pub steps: usize,
    /// True at a minimum; false where the steps ran out or the watcher stopped.
    pub converged: bool,
}

impl Minimum {
    /// |r(x)|^2.
    pub(crate) fn squares(&self) -> f64 {
        squares(&self.residuals)
    }
}

/// |r|^2; infinite where it is not a finite number.
pub(crate) fn squares(residuals: &[f64]) -> f64 {
    let sum = residuals.iter().map(|residual| residual * residual).sum::<f64>();
    if sum.is_finite() { sum } else { f64::INFINITY }
}

/// Jacobian by one-sided differences, one row per residual; an unknown at its upper bound is stepped downwards.
pub(crate) fn jacobian(
    residuals: &(impl Fn(&[f64]) -> Vec<f64> + Sync),
    point: &[f64],
    at_point: &[f64],
    bounds: &[Range<f64>],
) -> Mat<f64> {
    let columns: Vec<Vec<f64>> = in_parallel::made(point.len(), |column| {
        let outside = point[column] + DIFFERENCE > bounds[column].end;
        let step = if outside { -DIFFERENCE } else { DIFFERENCE };
        let mut moved = point.to_vec();
        moved[column] += step;
        residuals(&moved).iter().zip(at_point).map(|(there, here)| (there - here) / step).collect()
    });
    Mat::from_fn(at_point.len(), point.len(), |row, column| columns[column][row])
}

/// Minimises from a start inside the box. Before every step the watcher gets the number of steps taken and |r|^2; it
/// may stop.
pub(crate) fn minimise(
    residuals: &(impl Fn(&[f64]) -> Vec<f64> + Sync),
    start: &[f64],
    bounds: &[Range<f64>],
    limits: IterationLimits,
    watch: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
) -> Minimum {
    let mut found =
        Minimum { point: start.to_vec(), residuals: residuals(start), steps: 0, converged: start.is_empty() };
    let (mut damping, mut growth) = (FIRST_DAMPING, 2.0);
    while !found.converged && found.steps < limits.steps {
        let slopes = jacobian(residuals, &found.point, &found.residuals, bounds);
        loop {
            let before = found.squares();
            if watch(found.steps, before).is_break() {
                return found;
            }
            let next = damped_step(&slopes, &found, bounds, damping);
            let promised = before - promised_squares(&slopes, &found, &next);
            let moved = next.iter().zip(&found.point).any(|(to, from)| (to - from).abs() > 0.0);
            if damping > MOST_DAMPING || !moved || (promised < limits.decrease && damping <= LITTLE_DAMPING) {
                found.converged = before.is_finite();
                return found;
            }
            let there = residuals(&next);
            let gained = before - squares(&there);
            if gained > 0.0 {
                // The gain over the promise sets the damping, within [1/10, 2] (Nielsen 1999).
                let gain = gained / promised.max(f64::MIN_POSITIVE);
                damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(0.1, 2.0);
                growth = 2.0;
                found = Minimum { point: next, residuals: there, steps: found.steps + 1, converged: false };
                break;
            }
            damping *= growth;
            growth *= 2.0;
        }
    }
    found
}

/// End point of a damped step, cut to the box (steps 2 to 4 of the head).
fn damped_step(slopes: &Mat<f64>, from: &Minimum, bounds: &[Range<f64>], damping: f64) -> Vec<f64> {
    let rows = slopes.nrows();
    let dot = |column: usize, other: &dyn Fn(usize) -> f64| {
        (0..rows).map(|row| slopes[(row, column)] * other(row)).sum::<f64>()
    };
    // Unknowns that the gradient presses against a bound stand still.
    let moves = |&column: &usize| {
        let gradient = dot(column, &|row| from.residuals[row]);
        let (at, Range { start, end }) = (from.point[column], &bounds[column]);
        !(at <= *start && gradient > 0.0 || at >= *end && gradient < 0.0)
    };
    let moving: Vec<usize> = (0..from.point.len()).filter(moves).collect();
    let count = moving.len();
    // The damped problem as one least-squares system: J over sqrt(lambda) D, right-hand side -r in the last column.
    let mut system = Mat::<f64>::zeros(rows + count, count + 1);
    for (place, &column) in moving.iter().enumerate() {
        for row in 0..rows {
            system[(row, place)] = slopes[(row, column)];
        }
        let norm = dot(column, &|row| slopes[(row, column)]).sqrt();
        system[(rows + place, place)] = damping.sqrt() * norm;
    }
    for (row, residual) in from.residuals.iter().enumerate() {
        system[(row, count)] = -residual;
    }
    eliminate(system.as_mut(), count);
    let mut step = vec![0.0; count];
    back_substitute(&system, count, count, &mut step);
    let mut next = from.point.clone();
    for (&column, step) in moving.iter().zip(step) {
        next[column] = (next[column] + step).clamp(bounds[column].start, bounds[column].end);
    }
    next
}

/// |r + J d|^2 of the linear model, d = `next` - x.
fn promised_squares(slopes: &Mat<f64>, from: &Minimum, next: &[f64]) -> f64 {
    let step: Vec<f64> = next.iter().zip(&from.point).map(|(to, from)| to - from).collect();
    let row = |row: usize| from.residuals[row] + (0..step.len()).map(|j| slopes[(row, j)] * step[j]).sum::<f64>();
    (0..slopes.nrows()).map(|index| row(index).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: IterationLimits = IterationLimits { steps: 100, decrease: 1e-20 };

    fn rosenbrock(x: &[f64]) -> Vec<f64> {
        vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]
    }

    fn found(bounds: [Range<f64>; 2]) -> Minimum {
        minimise(&rosenbrock, &[-1.2, 1.0], &bounds, LIMITS, &mut |_, _| ControlFlow::Continue(()))
    }

    #[test]
    fn the_bottom_of_a_curved_valley_is_found() {
        let found = found([-5.0..5.0, -5.0..5.0]);
        assert!(found.converged && found.steps < 40, "{found:?}");
        assert!(found.point.iter().all(|x| (x - 1.0).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn a_bound_is_kept_and_the_best_point_on_it_found() {
        // At x = 0.5 the best is y = 0.25, with (1 - 0.5)^2 left.
        let found = found([-5.0..0.5, -5.0..5.0]);
        assert!(found.converged && (found.squares() - 0.25).abs() < 1e-9, "{found:?}");
        assert!((found.point[0] - 0.5).abs() < 1e-12 && (found.point[1] - 0.25).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_hole_in_the_model_is_stepped_round_and_a_watcher_obeyed() {
        let holed = |x: &[f64]| if x[0] > 0.9 && x[1] < 0.5 { vec![f64::NAN; 2] } else { rosenbrock(x) };
        let bounds = [-5.0..5.0, -5.0..5.0];
        let found = minimise(&holed, &[-1.2, 1.0], &bounds, LIMITS, &mut |_, _| ControlFlow::Continue(()));
        assert!(found.squares() < 1e-9, "{found:?}");
        let stop = &mut |steps, _| if steps == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let stopped = minimise(&holed, &[-1.2, 1.0], &bounds, LIMITS, stop);
        assert!(stopped.steps == 3 && !stopped.converged, "{stopped:?}");
    }

    #[test]
    fn differences_turn_at_the_upper_bound() {
        let bounds = [0.0..1.0, 0.0..1.0];
        let inside = |x: &[f64]| vec![if x[0] > 1.0 { f64::NAN } else { 3.0 * x[0] - 2.0 * x[1] }];
        let slopes = jacobian(&inside, &[1.0, 0.0], &inside(&[1.0, 0.0]), &bounds);
        assert!((slopes[(0, 0)] - 3.0).abs() < 1e-9 && (slopes[(0, 1)] + 2.0).abs() < 1e-9);
    }
}
