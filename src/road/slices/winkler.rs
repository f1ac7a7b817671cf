//! Winkler slices: independent springs under an element.
//!
//! S(y) = mean over the area under the element of max(0, y - (z_peak - z)) (docs/theory.md 7.2). With n cells
//! of equal size it is the mean of max(0, y - depth_i): piecewise linear, with a breakpoint wherever y passes the depth
//! of a cell and a slope there that grows by 1/n. Exact once the depths are sorted.
//!
//! Without a tolerance:
//! 1. Depths z_peak - z_i of all cells, sorted.
//! 2. Each is an event (depth, 1/n) of [`StiffnessCurve::from_events`]. Cost: n log n comparisons.
//!
//! With a tolerance:
//! 1. Depths are put into bins, whose width follows from the tolerance; those of a bin become one event at their mean.
//!    Outside a bin S is then exact, inside it too small by at most (share of the cells in the bin) width/4: when half
//!    of them lie at each edge. Cost: some operations for each cell and for each bin.
//! 2. A slice with too many of its cells in one bin, or with far fewer cells than bins, is sorted after all. Measured
//!    (bench `slices`): omitting more breakpoints costs more than it saves.

use super::StiffnessCurve;

/// Work arrays of a curve.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Bits of the depths: no depth is negative, so the bits sort like the depths.
    depths: Vec<u64>,
    /// Sum of depths and number of cells, by bin.
    bins: Vec<[f64; 2]>,
    events: Vec<(f64, f64)>,
}

/// Part of the tolerance for which bins of the mean number of cells are made: with few cells the fullest bin holds some
/// times as many.
const PART_OF_BINS: f64 = 0.25;
/// Greatest density of depths over their mean density: that of a Gaussian texture with a range of six standard
/// deviations.
const CROWDED: f64 = 2.4;
/// Most bins per cell: with more, sorting is as fast.
const MOST_BINS: usize = 2;

/// Winkler curve of finite heights \[m\] within `tolerance`.
///
/// Without heights there is no highest point: the result is [`StiffnessCurve::flat`] of minus infinity. Callers check
/// before.
pub(super) fn curve(heights: &[f64], tolerance: f64, scratch: &mut Scratch) -> StiffnessCurve {
    let (lowest, peak) = extremes(heights);
    if tolerance > 0.0
        && let Some(curve) = binned(heights, peak, peak - lowest, tolerance, scratch)
    {
        return curve;
    }
    let depths = &mut scratch.depths;
    depths.clear();
    depths.extend(heights.iter().map(|&height| (peak - height).to_bits()));
    depths.sort_unstable();
    let weight = 1.0 / heights.len() as f64;
    StiffnessCurve::from_events(peak, depths.iter().map(|&depth| (f64::from_bits(depth), weight)))
}

/// Curve from bins, with its largest error; `None` where bins cannot be used.
fn binned(heights: &[f64], peak: f64, range: f64, tolerance: f64, scratch: &mut Scratch) -> Option<StiffnessCurve> {
    /// Added to a small number it leaves the nearest whole number in the last bits of the mantissa.
    const ROUND: f64 = (1_u64 << 52) as f64;
    let width = (4.0 * PART_OF_BINS / CROWDED * tolerance * range).sqrt();
    let count = range / width + 2.0;
    // NaN if all cells have the same height.
    if count.is_nan() || count > (MOST_BINS * heights.len()) as f64 {
        return None;
    }
    let Scratch { bins, events, .. } = scratch;
    bins.clear();
    bins.resize(count as usize, [0.0; 2]);
    let inverse = 1.0 / width;
    for height in heights {
        let depth = peak - height;
        // The nearest bin.
        let number = (depth * inverse + ROUND).to_bits() as u32;
        let bin = bins.get_mut(number as usize)?;
        bin[0] += depth;
        bin[1] += 1.0;
    }
    let weight = 1.0 / heights.len() as f64;
    // Entries of empty bins are overwritten by the next: no branch, which could not be predicted.
    events.resize(bins.len(), (0.0, 0.0));
    let (mut used, mut fullest) = (0, 0.0_f64);
    for &[sum, cells] in bins.iter() {
        events[used] = (sum / cells.max(1.0), cells * weight);
        used += usize::from(cells > 0.0);
        // A single cell in a bin is exact.
        fullest = fullest.max(if cells > 1.0 { cells } else { 0.0 });
    }
    events.truncate(used);
    let error = 0.25 * fullest * weight * width;
    (error <= tolerance).then(|| StiffnessCurve { error, ..StiffnessCurve::from_events(peak, events.iter().copied()) })
}

/// Lowest and highest height, lane by lane.
fn extremes(heights: &[f64]) -> (f64, f64) {
    const LANES: usize = 8;
    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    let (whole, rest) = heights.as_chunks::<LANES>();
    for heights in whole {
        for ((low, high), &height) in low.iter_mut().zip(&mut high).zip(heights) {
            *low = if height < *low { height } else { *low };
            *high = if height > *high { height } else { *high };
        }
    }
    (
        low.iter().chain(rest).copied().fold(f64::INFINITY, f64::min),
        high.iter().chain(rest).copied().fold(f64::NEG_INFINITY, f64::max),
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// S(y) by its definition.
    fn brute_force(heights: &[f64], y: f64) -> f64 {
        let peak = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        heights.iter().map(|z| (y - (peak - z)).max(0.0)).sum::<f64>() / heights.len() as f64
    }

    proptest! {
        #[test]
        fn follows_the_integral(
            heights in prop::collection::vec((-40i32..40).prop_map(|z| f64::from(z) * 1e-4), 1..200),
            y in 0.0..0.02,
        ) {
            let curve = curve(&heights, 0.0, &mut Scratch::default());
            let expected = brute_force(&heights, y);
            // Rounding of at most n additions of numbers below y.
            prop_assert!((curve.displacement_at(y) - expected).abs() <= 200.0 * f64::EPSILON * 0.02);
            prop_assert!(curve.penetration.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    proptest! {
        /// For Gaussian, uniform, crowded and few heights curves must be within the tolerance and convex, and their
        /// reported error must be an upper bound.
        #[test]
        fn bins_keep_the_tolerance(
            heights in prop::collection::vec(
                (-1.0..1.0f64, 0..4i32).prop_map(|(z, power)| 2e-3 * z.powi(2 * power + 1)),
                1..300,
            ),
            exponent in -8.0..-4.0f64,
        ) {
            let tolerance = 10f64.powf(exponent);
            let curve = curve(&heights, tolerance, &mut Scratch::default());
            prop_assert!(curve.error <= tolerance * (1.0 + 1e-6));
            // Breakpoints nearer than a picometre are merged; the reported error is that of the bins alone.
            for y in (0..400).map(|i| f64::from(i) * 1.2e-5) {
                let error = (curve.displacement_at(y) - brute_force(&heights, y)).abs();
                prop_assert!(error <= curve.error * (1.0 + 1e-6) + 1e-12, "{error} at {y} for {}", curve.error);
            }
            // Breakpoints are a picometre apart at least, and S is known to some 1e-18 m.
            let step = |values: &[f64], i: usize| values[i] - values[i - 1];
            let slope = |i: usize| step(&curve.displacement, i) / step(&curve.penetration, i);
            prop_assert!((2..curve.penetration.len()).all(|i| slope(i) >= slope(i - 1) - 1e-5));
        }
    }

    #[test]
    fn one_spike_carries_its_own_width_only() {
        let mut heights = vec![0.0; 50];
        heights[17] = 5e-3;
        let curve = curve(&heights, 0.0, &mut Scratch::default());
        assert_eq!(curve.penetration.len(), 1);
        assert!((curve.displacement_at(5e-3) - 5e-3 / 50.0).abs() < 1e-18);
        assert!((curve.displacement_at(6e-3) - (5e-3 / 50.0 + 1e-3)).abs() < 1e-17);
    }
}
