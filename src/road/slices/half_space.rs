//! Half-space slices: the lines of cells across an element, each pressed into an elastic half-space independently
//! (docs/theory.md 7.2).
//!
//! Uniform pressure on cells of [`CELL_LENGTH`] by the lateral pitch, Love's solution, rigid profile, no friction. Of
//! one line, S_line(y) = F(y)/(force of the flat line pushed in by 1 m on the same grid): S_line(y) = y for a flat
//! line, slope 1 once the whole width is in contact, whatever the modulus and Poisson's ratio. [`GrowingContact`] gives
//! F exactly.
//!
//! For an element, S(y) is the mean over its lines of S_line(y - (z_peak - z_peak,line)): its breakpoints are those of
//! the lines, each later by as much as the line's peak is lower, all of them sorted.

use super::StiffnessCurve;
use crate::half_space::{GrowingContact, LineInfluence};

/// Length along the road of the cells that carry a line's pressure \[m\]: a property of the law, not of the element, or
/// a line would become softer across with every refinement and S would have no limit. Stones of asphalt, and its
/// shortest waves that carry energy, are 4 to 8 mm long; elements were about 4 mm long where both laws were compared.
pub(crate) const CELL_LENGTH: f64 = 4e-3;

/// Half-space curve of finite heights \[m\], line by line, one per cell of `line`; the other arguments are scratch.
pub(super) fn curve(
    line: &LineInfluence,
    heights: &[f64],
    columns: usize,
    depths: &mut Vec<f64>,
    contact: &mut GrowingContact,
    events: &mut Vec<(f64, f64)>,
) -> StiffnessCurve {
    let peak = highest(heights);
    let flat = line.flat_stiffness() * (heights.len() / columns) as f64;
    events.clear();
    for heights in heights.chunks_exact(columns) {
        let later = follow(line, heights, peak, depths, contact);
        events.extend(contact.events().iter().map(|&(touch, weight)| (later + touch, weight / flat)));
    }
    if heights.len() > columns {
        // Stable, so that equal breakpoints are added up in one order.
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    StiffnessCurve::from_events(peak, events.iter().copied())
}

/// Follows one line; returns how far its peak lies under the slice's \[m\].
pub(super) fn follow(
    line: &LineInfluence,
    heights: &[f64],
    peak: f64,
    depths: &mut Vec<f64>,
    contact: &mut GrowingContact,
) -> f64 {
    let top = highest(heights);
    depths.clear();
    depths.extend(heights.iter().map(|&height| top - height));
    contact.follow(line, depths);
    peak - top
}

fn highest(heights: &[f64]) -> f64 {
    heights.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::SliceBuilder;
    use super::super::SliceScratch;
    use super::StiffnessCurve;

    #[test]
    fn a_flat_slice_follows_the_penetration_exactly() {
        let builder = SliceBuilder::half_space(33, 4e-3, 2e-3).unwrap();
        assert_eq!(builder.build(&[1e-3; 33], &mut SliceScratch::default()).unwrap(), StiffnessCurve::flat(1e-3));
    }

    /// Two lines, one of them everywhere half a millimetre lower: each touches when the slice's y reaches its peak.
    #[test]
    fn lines_of_an_element_share_its_force() {
        let line: Vec<f64> = (0..20).map(|i| 1e-3 * (f64::from(i) * 0.7).sin()).collect();
        let both: Vec<f64> = line.iter().copied().chain(line.iter().map(|height| height - 5e-4)).collect();
        let one = SliceBuilder::half_space(20, 4e-3, 2e-3).unwrap();
        let two = one.clone().with_lines(2).unwrap();
        let mut scratch = SliceScratch::default();
        let (one, two) = (one.build(&line, &mut scratch).unwrap(), two.build(&both, &mut scratch).unwrap());
        assert!(one.peak.to_bits() == two.peak.to_bits());
        for y in (1..100).map(|i| f64::from(i) * 4e-5) {
            let expected = 0.5 * (one.displacement_at(y) + one.displacement_at(y - 5e-4).max(0.0));
            // Rounding of some 40 events.
            assert!((two.displacement_at(y) - expected).abs() < 1e-16, "S({y})");
        }
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
