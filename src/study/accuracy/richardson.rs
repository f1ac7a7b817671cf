//! Convergence of a sequence of ever finer runs, and the remaining error (Richardson's extrapolation, applied to norms
//! of differences).
//!
//! With an error C h^p a run with step h differs from that with 2 h by d1 = C h^p (2^p - 1) and from that with h/2 by
//! d2 = d1/2^p: p = lg2(d1/d2), and h's own error is d2/(1 - 2^-p).

use serde::Serialize;

/// Below this order the sequence does not converge well enough to extrapolate.
const LEAST_ORDER: f64 = 0.5;

/// Error of the middle one of three runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Richardson {
    /// Difference of the coarser and the middle run.
    pub coarse: f64,
    /// Difference of the middle and the finer run, where that was rolled.
    pub fine: Option<f64>,
    /// Observed order; `None` where both differences vanish.
    pub order: Option<f64>,
    /// Estimated error of the middle run.
    pub error: f64,
    /// False if the differences do not shrink at `LEAST_ORDER` at least: `error` is then the larger difference.
    pub converges: bool,
}

impl Richardson {
    /// Error of the middle run from its differences from one twice as coarse and from one twice as fine.
    pub(crate) fn new(coarse: f64, fine: f64) -> Self {
        let (coarse, fine) = (coarse.abs(), fine.abs());
        if fine == 0.0 {
            let order = (coarse > 0.0).then_some(f64::INFINITY);
            return Self { coarse, fine: Some(fine), order, error: 0.0, converges: true };
        }
        let order = (coarse / fine).log2();
        let converges = order >= LEAST_ORDER;
        let error = if converges { fine / (1.0 - (-order).exp2()) } else { coarse.max(fine) };
        Self { coarse, fine: Some(fine), order: Some(order), error, converges }
    }

    /// Error of a run from its difference from one twice as coarse alone, assuming first order, the lowest of interest:
    /// the error equals the difference. An upper bound for any higher order.
    pub(crate) fn first_order(coarse: f64) -> Self {
        Self { coarse: coarse.abs(), fine: None, order: None, error: coarse.abs(), converges: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_and_errors_of_powers_are_found_and_their_absence_is_said() {
        for order in [1.0, 2.0, 3.0] {
            let error = |h: f64| 0.7 * h.powf(order);
            let found = Richardson::new(error(0.2) - error(0.1), error(0.1) - error(0.05));
            assert!(found.converges && (found.order.unwrap() - order).abs() < 1e-12, "{found:?}");
            assert!((found.error / error(0.1) - 1.0).abs() < 1e-12, "{found:?}");
        }
        let stuck = Richardson::new(0.3, 0.29);
        assert!(!stuck.converges && (stuck.error - 0.3).abs() < 1e-15, "{stuck:?}");
        let worse = Richardson::new(0.1, 0.2);
        assert!(!worse.converges && (worse.error - 0.2).abs() < 1e-15 && worse.order.unwrap() < 0.0);
        let equal = Richardson { converges: true, fine: Some(0.0), ..Richardson::default() };
        assert_eq!(Richardson::new(0.0, 0.0), equal);
        // Of an error that falls faster, the difference from a coarser run alone is a bound.
        let error = |h: f64| 0.7 * h.powi(2);
        let alone = Richardson::first_order(error(0.2) - error(0.1));
        assert!(alone.error >= error(0.1) && alone.fine.is_none(), "{alone:?}");
    }
}
