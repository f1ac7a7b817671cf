//! Half-space slices: the slice's profile pressed into an elastic half-space (MODEL.md section 6).
//!
//! Uniform pressure on cells of the element's length by the lateral pitch, Love's solution, rigid profile, no friction.
//! S(y) = F(y)/(force of the flat slice pushed in by 1 m on the same grid): S(y) = y for a flat slice, slope 1 once the
//! whole width is in contact, whatever the modulus and Poisson's ratio. [`GrowingContact`] gives F exactly.

use super::StiffnessCurve;
use crate::half_space::{GrowingContact, LineInfluence};

/// The half-space curve of finite heights \[m\], one per cell of `line`; `depths` and `contact` are scratch.
pub(super) fn curve(
    line: &LineInfluence,
    heights: &[f64],
    depths: &mut Vec<f64>,
    contact: &mut GrowingContact,
) -> StiffnessCurve {
    let peak = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    depths.clear();
    depths.extend(heights.iter().map(|&height| peak - height));
    contact.follow(line, depths, f64::INFINITY);
    let flat = line.flat_stiffness();
    StiffnessCurve::from_events(peak, contact.events().iter().map(|&(touch, weight)| (touch, weight / flat)))
}

#[cfg(test)]
mod tests {
    use super::super::SliceBuilder;
    use super::super::builder::SliceScratch;
    use super::StiffnessCurve;

    #[test]
    fn a_flat_slice_follows_the_penetration_exactly() {
        let builder = SliceBuilder::half_space(33, 4e-3, 2e-3).unwrap();
        assert_eq!(builder.build(&[1e-3; 33], &mut SliceScratch::default()).unwrap(), StiffnessCurve::flat(1e-3));
    }

    #[test]
    fn ties_two_points_and_many_points_end_in_full_contact() {
        for columns in [1usize, 2, 60, 1500] {
            let builder = SliceBuilder::half_space(columns, 4e-3, 0.16 / columns as f64).unwrap();
            // Pairs of equal heights, mirrored: every depth occurs four times.
            let heights: Vec<f64> = (0..columns)
                .map(|i| {
                    let from_edge = i.min(columns - 1 - i);
                    1e-3 * ((from_edge / 2) as f64 * 0.37).sin()
                })
                .collect();
            let curve = builder.build(&heights, &mut SliceScratch::default()).unwrap();
            let slopes_rise = curve
                .displacement
                .windows(2)
                .zip(curve.penetration.windows(2))
                .all(|(s, y)| y[1] > y[0] && s[1] >= s[0]);
            assert!(slopes_rise, "{columns} columns");
            if let (Some(&y), Some(&s)) = (curve.penetration.last(), curve.displacement.last()) {
                // Full contact: S = y - mean depth weighted by the flat pressure, so less than y.
                assert!(s > 0.0 && s < y);
            }
        }
    }
}
