//! Measured heights that were rounded coarsely, or cut off at the end of a sensor's range.
//!
//! Plates with a few edges and cleats are neither: their heights change at few places.

use crate::road::report::RoadNote;

/// Finest step that is noted \[m\].
const STEP: f64 = 5e-5;
/// Most heights that differ, of a range of 50 mm in such steps.
const MOST_LEVELS: usize = 1000;
/// Shares of heights that are cut off: fewer are chance, more are a plate.
const CUT_OFF: [f64; 2] = [0.05, 0.5];
/// Least share of neighbours that differ, or that enter what is cut off.
const EDGES: f64 = 0.01;
/// Fewest heights.
const FEWEST: usize = 50;

/// Adds a note on heights in coarse steps, else on those cut off; missing heights are NaN.
pub(super) fn add_notes(heights: impl Iterator<Item = f64>, notes: &mut Vec<RoadNote>) {
    // Without the sign of zero.
    let heights: Vec<f64> = heights.filter(|height| !height.is_nan()).map(|height| height + 0.0).collect();
    let total = heights.len();
    if total < FEWEST {
        return;
    }
    if let Some(step) = step(&heights) {
        notes.push(RoadNote::InSteps { step });
        return;
    }
    for bound in [f64::min, f64::max] {
        let height = heights.iter().copied().fold(heights[0], bound);
        let is_bound = |other: &f64| other.total_cmp(&height).is_eq();
        let count = heights.iter().filter(|other| is_bound(other)).count();
        let share = count as f64 / total as f64;
        if share > CUT_OFF[0] && share < CUT_OFF[1] && edges(&heights, |a, b| !is_bound(a) && is_bound(b)) {
            notes.push(RoadNote::CutOff { count, total, height });
        }
    }
}

/// Smallest step between heights that differ \[m\]; `None` if it is fine, or if they are not rounded.
fn step(heights: &[f64]) -> Option<f64> {
    let mut levels: Vec<f64> = Vec::new();
    for height in heights {
        if let Err(place) = levels.binary_search_by(|level| level.total_cmp(height)) {
            if levels.len() == MOST_LEVELS {
                return None;
            }
            levels.insert(place, *height);
        }
    }
    let step = levels.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let are_few = levels.len() > 2 && 4 * levels.len() <= heights.len();
    (step > STEP && are_few && edges(heights, |a, b| a.total_cmp(b).is_ne())).then_some(step)
}

/// True if many neighbours are as `is_edge` says.
fn edges(heights: &[f64], is_edge: impl Fn(&f64, &f64) -> bool) -> bool {
    let count = heights.windows(2).filter(|pair| is_edge(&pair[0], &pair[1])).count();
    count as f64 >= EDGES * heights.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn notes(height: impl Fn(f64) -> f64) -> Vec<RoadNote> {
        let mut notes = Vec::new();
        add_notes((0..2000).map(|index| height(f64::from(index))), &mut notes);
        notes
    }

    #[test]
    fn rounded_and_cut_heights_are_noted_and_plates_are_not() {
        let rough = |x: f64| 1e-3 * ((0.7 * x).sin() + (0.31 * x + 1.0).sin());
        assert_eq!(notes(rough), []);
        assert_eq!(notes(|x| 1e-6 * (1e6 * rough(x)).round()), [], "steps of a micrometre");
        let coarse = notes(|x| 1e-3 * (1e3 * rough(x)).round());
        assert!(matches!(coarse[..], [RoadNote::InSteps { step }] if (step - 1e-3).abs() < 1e-9), "{coarse:?}");
        let cut = notes(|x| rough(x).max(-5e-4));
        let [RoadNote::CutOff { total: 2000, height, .. }] = cut[..] else { panic!("{cut:?}") };
        assert!((height + 5e-4).abs() < 1e-12);
        assert_eq!(notes(|_| 1e-3), [], "a plate");
        assert_eq!(notes(|x| if (800.0..900.0).contains(&x) { 1e-2 } else { 0.0 }), [], "a cleat");
        assert_eq!(notes(|x| if x < 500.0 { -5e-3 } else { rough(x) }), [], "a constant part");
    }
}
