//! Fewer breakpoints within a tolerance.
//!
//! The curve f is convex, so a line that stays within f +- tolerance as long as possible starts on the lower edge of
//! that corridor, touches the upper edge from below and leaves through the lower edge again. Following such lines from
//! the origin gives the fewest linear pieces that any curve through the origin within the corridor can have
//! (greedy is optimal for a monotone corridor: Imai and Iri, J. Inf. Process. 9 (1986) 159-162).
//!
//! 1. From the current start (y0, v0), the steepest admissible line has slope min over breakpoints of
//!    (f(y_k) + tolerance - v0)/(y_k - y0): it touches the upper edge.
//! 2. If that is not less than the final slope, the rest is one line of the final slope; done.
//! 3. Otherwise it leaves through the lower edge at the first y with line = f(y) - tolerance: the next breakpoint.
//!
//! Each line supports the convex upper edge, so slopes increase from one to the next and lie between the curve's own
//! least and greatest slope: the result is convex and non-decreasing like the original. Cost: linear in breakpoints.

use super::StiffnessCurve;

/// The curve with the fewest breakpoints within `tolerance` \[m\] of `curve`; its `error` is the largest
/// |S_reduced - S| over all y >= 0, found at the breakpoints of both. `tolerance` <= 0 leaves the curve as it is.
pub(super) fn reduce(curve: StiffnessCurve, tolerance: f64) -> StiffnessCurve {
    if tolerance <= 0.0 || curve.penetration.is_empty() {
        return curve;
    }
    let (y, f) = (&curve.penetration, &curve.displacement);
    let count = y.len();
    let (mut penetration, mut displacement) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut y0, mut v0) = (0.0, 0.0);
    let mut next = 0; // first breakpoint past y0
    // Steps 1 to 3 of the module's head.
    loop {
        let mut slope = curve.final_slope;
        let mut touch = count;
        for k in next..count {
            let to_upper_edge = (f[k] + tolerance - v0) / (y[k] - y0);
            if to_upper_edge < slope {
                (slope, touch) = (to_upper_edge, k);
            } else if touch < k {
                // Seen from a point below it, a convex edge is unimodal in slope.
                break;
            }
        }
        if touch == count {
            break;
        }
        let mut leave = touch + 1;
        while leave < count && v0 + slope * (y[leave] - y0) >= f[leave] - tolerance {
            leave += 1;
        }
        // The line leaves on the piece that starts at breakpoint leave - 1 (>= touch).
        let (y1, f1) = (y[leave - 1], f[leave - 1]);
        let piece = if leave < count { (f[leave] - f1) / (y[leave] - y1) } else { curve.final_slope };
        let above = v0 + slope * (y1 - y0) - (f1 - tolerance);
        let step = above / (piece - slope);
        y0 = y1 + step;
        v0 = f1 + piece * step - tolerance;
        penetration.push(y0);
        displacement.push(v0);
        next = leave;
        while next < count && y[next] <= y0 {
            next += 1;
        }
    }
    if penetration.len() >= count {
        return curve;
    }
    let mut reduced = StiffnessCurve {
        peak: curve.peak,
        penetration: penetration.into(),
        displacement: displacement.into(),
        final_slope: curve.final_slope,
        error: 0.0,
    };
    reduced.error = largest_difference(&curve, &reduced);
    reduced
}

/// Largest difference of two curves of equal final slope: it is attained at a breakpoint of either. Cost: linear in
/// breakpoints.
pub(super) fn largest_difference(a: &StiffnessCurve, b: &StiffnessCurve) -> f64 {
    directed_difference(a, b).max(directed_difference(b, a))
}

/// Largest difference at the breakpoints of `a`.
fn directed_difference(a: &StiffnessCurve, b: &StiffnessCurve) -> f64 {
    let (mut number, mut piece, mut largest) = (0, b.piece(0), 0.0_f64);
    for (&y, &s) in a.penetration.iter().zip(&a.displacement) {
        if y > piece.to {
            while b.penetration.get(number).is_some_and(|&to| y > to) {
                number += 1;
            }
            piece = b.piece(number);
        }
        largest = largest.max((piece.slope * y + piece.intercept - s).abs());
    }
    largest
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::winkler;
    use super::*;

    fn slopes(curve: &StiffnessCurve) -> Vec<f64> {
        let mut slopes = Vec::new();
        let (mut y0, mut s0) = (0.0, 0.0);
        for (&y, &s) in curve.penetration.iter().zip(curve.displacement.iter()) {
            slopes.push((s - s0) / (y - y0));
            (y0, s0) = (y, s);
        }
        slopes.push(curve.final_slope);
        slopes
    }

    proptest! {
        #[test]
        fn stays_within_the_tolerance_convex_and_monotone(
            heights in prop::collection::vec(-5e-3..5e-3f64, 2..150),
            exponent in -9.0..-3.0f64,
        ) {
            let tolerance = 10f64.powf(exponent);
            let curve = winkler::curve(&heights, 0.0, &mut winkler::Scratch::default());
            let reduced = reduce(curve.clone(), tolerance);
            prop_assert!(reduced.error <= tolerance * (1.0 + 1e-6), "{} > {tolerance}", reduced.error);
            prop_assert!(reduced.penetration.len() <= curve.penetration.len());
            for y in (0..500).map(|i| f64::from(i) * 3e-5) {
                let difference = (reduced.displacement_at(y) - curve.displacement_at(y)).abs();
                prop_assert!(difference <= tolerance * (1.0 + 1e-6) + 1e-17);
            }
            let slopes = slopes(&reduced);
            prop_assert!(slopes[0] >= 0.0);
            prop_assert!(slopes.windows(2).all(|pair| pair[0] <= pair[1] + 1e-9));
        }
    }

    /// A parabola over 0..1 of curvature 1: each line spans 4 sqrt(tolerance) of it, the first one (through the origin
    /// instead of the lower edge) a little less.
    #[test]
    fn needs_the_optimal_number_of_breakpoints() {
        let heights: Vec<f64> = (0..4000).map(|i| -f64::from(i) / 4000.0).collect();
        let curve = winkler::curve(&heights, 0.0, &mut winkler::Scratch::default());
        let tolerance = 1e-4;
        let pieces = reduce(curve, tolerance).penetration.len();
        let optimal = (1.0 / (4.0 * tolerance.sqrt())).ceil();
        assert!((pieces as f64) <= optimal + 1.0, "{pieces} pieces, optimum {optimal}");
    }

    #[test]
    fn a_curve_within_the_tolerance_of_a_flat_slice_becomes_flat() {
        let curve = winkler::curve(&[0.0, 1e-7, 2e-7], 0.0, &mut winkler::Scratch::default());
        let reduced = reduce(curve, 1e-6);
        assert!(reduced.penetration.is_empty());
        assert!(reduced.error <= 1e-6);
    }
}
