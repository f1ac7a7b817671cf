//! Non-negative least squares: minimise |A x - b| with x >= 0.
//!
//! 1. Start with x = 0 and an empty passive set.
//! 2. Move the variable with the largest positive gradient w = A^T (b - A x) to the passive set.
//! 3. Solve the unconstrained problem on the passive set by QR; while a component is not positive, step from the last
//!    feasible point towards the solution until the first component reaches zero, and take that one out again.
//! 4. Repeat until no gradient component exceeds the tolerance.
//!
//! C. L. Lawson, R. J. Hanson, *Solving Least Squares Problems*, chapter 23. The objective falls strictly from one
//! passive set to the next, so no set recurs and the search ends. Cost: O(m n^2) per exchange; meant for n up to some
//! hundred.

use faer::Mat;
use faer::linalg::solvers::SolveLstsq;

/// Minimises |A x - b| over x >= 0. `a` is row-major, `b.len()` rows of `columns` entries.
///
/// Entries must be finite. A numerically dependent column is never taken into the passive set.
pub(super) fn solve(a: &[f64], columns: usize, b: &[f64]) -> Vec<f64> {
    let rows = b.len();
    debug_assert_eq!(a.len(), rows * columns);
    let mut x = vec![0.0; columns];
    let mut passive: Vec<usize> = Vec::new();
    let mut refused = vec![false; columns];
    let scale = a.iter().chain(b).fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let tolerance = 1e-14 * scale * scale * (rows * columns) as f64;
    let mut solves = 0;
    // The theory bounds the exchanges; the cap only guards against rounding that makes two sets look equally good.
    while solves < 10 * columns + 10 {
        // Step 2 of the module's head.
        let gradient = gradient(a, columns, b, &x);
        let best = (0..columns)
            .filter(|&j| !passive.contains(&j) && !refused[j] && gradient[j] > tolerance)
            .max_by(|&i, &j| gradient[i].total_cmp(&gradient[j]));
        let Some(entering) = best else { break };
        passive.push(entering);
        let mut first = true;
        // Step 3.
        while !passive.is_empty() {
            let candidate = least_squares(a, columns, b, &passive);
            solves += 1;
            // The entering column is the last one.
            let entered = candidate[candidate.len() - 1];
            if first && (entered <= 0.0 || !entered.is_finite()) {
                passive.pop();
                refused[entering] = true;
                break;
            }
            first = false;
            if candidate.iter().all(|&value| value > 0.0) {
                for (&j, &value) in passive.iter().zip(&candidate) {
                    x[j] = value;
                }
                refused.fill(false);
                break;
            }
            let mut step = 1.0_f64;
            for (&j, &value) in passive.iter().zip(&candidate) {
                if value <= 0.0 {
                    step = step.min(x[j] / (x[j] - value));
                }
            }
            for (&j, &value) in passive.iter().zip(&candidate) {
                x[j] += step * (value - x[j]);
            }
            let floor = 1e-15 * x.iter().fold(0.0_f64, |largest, &value| largest.max(value));
            passive.retain(|&j| {
                let stays = x[j] > floor;
                if !stays {
                    x[j] = 0.0;
                }
                stays
            });
        }
    }
    x
}

fn residual(a: &[f64], columns: usize, b: &[f64], x: &[f64]) -> Vec<f64> {
    let product = |row: &[f64]| row.iter().zip(x).map(|(entry, value)| entry * value).sum::<f64>();
    a.chunks_exact(columns).zip(b).map(|(row, &right)| right - product(row)).collect()
}

fn gradient(a: &[f64], columns: usize, b: &[f64], x: &[f64]) -> Vec<f64> {
    let mut gradient = vec![0.0; columns];
    for (row, residual) in a.chunks_exact(columns).zip(residual(a, columns, b, x)) {
        for (sum, entry) in gradient.iter_mut().zip(row) {
            *sum += entry * residual;
        }
    }
    gradient
}

fn least_squares(a: &[f64], columns: usize, b: &[f64], passive: &[usize]) -> Vec<f64> {
    let matrix = Mat::from_fn(b.len(), passive.len(), |i, j| a[i * columns + passive[j]]);
    if b.len() < passive.len() {
        return vec![f64::NAN; passive.len()];
    }
    let right = Mat::from_fn(b.len(), 1, |i, _| b[i]);
    let solution = matrix.qr().solve_lstsq(&right);
    (0..passive.len()).map(|j| solution[(j, 0)]).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn norm_of_residual(a: &[f64], columns: usize, b: &[f64], x: &[f64]) -> f64 {
        residual(a, columns, b, x).iter().map(|r| r * r).sum::<f64>().sqrt()
    }

    #[test]
    fn unconstrained_optimum_is_kept_when_it_is_positive() {
        let (a, b) = ([2.0, 0.0, 0.0, 4.0, 1.0, 1.0], [2.0, 8.0, 3.0]);
        let x = solve(&a, 2, &b);
        assert!((x[0] - 1.0).abs() < 1e-13 && (x[1] - 2.0).abs() < 1e-13);
        assert!(norm_of_residual(&a, 2, &b, &x) < 1e-13);
    }

    #[test]
    fn negative_component_is_held_at_zero() {
        // Minimum of (x0 + x1 - 1)^2 + (x0 - x1 - 3)^2 over x >= 0: x1 = 0, x0 = 2.
        let x = solve(&[1.0, 1.0, 1.0, -1.0], 2, &[1.0, 3.0]);
        assert!((x[0] - 2.0).abs() < 1e-13);
        assert_eq!(x[1].to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn dependent_columns_do_not_hang() {
        let (a, b) = ([1.0, 1.0, 2.0, 2.0], [1.0, 2.0]);
        let x = solve(&a, 2, &b);
        assert!(norm_of_residual(&a, 2, &b, &x) < 1e-12 && x.iter().all(|&x| x >= 0.0));
    }

    proptest! {
        /// The Karush-Kuhn-Tucker conditions: x >= 0, gradient <= 0 where x = 0, gradient = 0 where x > 0.
        #[test]
        fn conditions_of_the_optimum_hold(
            a in prop::collection::vec(-1.0..1.0_f64, 24),
            b in prop::collection::vec(-1.0..1.0_f64, 6),
        ) {
            let found = solve(&a, 4, &b);
            for (x, w) in found.iter().zip(gradient(&a, 4, &b, &found)) {
                prop_assert!(*x >= 0.0 && w <= 1e-9, "x {x}, gradient {w}");
                prop_assert!(*x == 0.0 || w.abs() <= 1e-9, "x {x}, gradient {w}");
            }
        }
    }
}
