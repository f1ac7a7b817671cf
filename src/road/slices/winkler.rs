//! Winkler slices: independent springs under an element.
//!
//! S(y) = mean over the area under the element of max(0, y - (z_peak - z)) (MODEL.md sections 6 and 11). With n cells of equal size
//! it is the mean of max(0, y - depth_i): piecewise linear, with a breakpoint wherever y passes the depth of a cell
//! and a slope there that grows by 1/n. Exact once the depths are sorted.
//!
//! 1. Depths z_peak - z_i of all cells, sorted.
//! 2. Each is an event (depth, 1/n) of [`StiffnessCurve::from_events`].
//!
//! Cost: n log n comparisons.

use super::StiffnessCurve;

/// The Winkler curve of finite heights \[m\]; `depths` is scratch, overwritten.
///
/// No heights have no highest point: they give [`StiffnessCurve::flat`] of minus infinity. Callers check first.
pub(super) fn curve(heights: &[f64], depths: &mut Vec<f64>) -> StiffnessCurve {
    let peak = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    depths.clear();
    depths.extend(heights.iter().map(|&height| peak - height));
    // Equal depths are equal bits, so an unstable sort gives one result.
    depths.sort_unstable_by(f64::total_cmp);
    let weight = 1.0 / heights.len() as f64;
    StiffnessCurve::from_events(peak, depths.iter().map(|&depth| (depth, weight)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The integral itself.
    fn brute_force(heights: &[f64], y: f64) -> f64 {
        let peak = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        heights.iter().map(|z| (y - (peak - z)).max(0.0)).sum::<f64>() / heights.len() as f64
    }

    proptest! {
        #[test]
        fn follows_the_integral(heights in prop::collection::vec((-40i32..40).prop_map(|z| f64::from(z) * 1e-4), 1..200), y in 0.0..0.02) {
            let curve = curve(&heights, &mut Vec::new());
            let expected = brute_force(&heights, y);
            // Rounding of at most n additions of numbers below y.
            prop_assert!((curve.displacement_at(y) - expected).abs() <= 200.0 * f64::EPSILON * 0.02);
            prop_assert!(curve.penetration.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn one_spike_carries_its_own_width_only() {
        let mut heights = vec![0.0; 50];
        heights[17] = 5e-3;
        let curve = curve(&heights, &mut Vec::new());
        assert_eq!(curve.penetration.len(), 1);
        assert!((curve.displacement_at(5e-3) - 5e-3 / 50.0).abs() < 1e-18);
        assert!((curve.displacement_at(6e-3) - (5e-3 / 50.0 + 1e-3)).abs() < 1e-17);
    }
}
