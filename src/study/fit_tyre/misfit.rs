//! How far the mobilities of a tyre lie from measured ones, in units of their uncertainty.

use std::sync::atomic::{AtomicBool, Ordering};

use num_complex::Complex64;

use super::measured::MeasuredPoint;
use crate::scene::Tyre;
use crate::tyre::influence::mobility::driving_point;

/// Decibels of a factor e.
pub(super) const DECIBELS: f64 = 20.0 * std::f64::consts::LOG10_E;

/// Standard deviations of the measured values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Standard deviation of levels \[dB\].
    pub level: f64,
    /// Standard deviation of phases, in degrees.
    pub phase: f64,
}

/// Measured values, grouped so that a tyre's mobilities take few sums: patches measured at the same frequencies go
/// together.
#[derive(Clone, Debug)]
pub(super) struct Misfit<'a> {
    points: &'a [MeasuredPoint],
    uncertainty: Uncertainty,
    groups: Vec<PatchGroup>,
    /// Group, row (frequency) and column (patch) of each point.
    places: Vec<(usize, usize, usize)>,
}

#[derive(Clone, Debug)]
struct PatchGroup {
    patches: Vec<f64>,
    frequencies: Vec<f64>,
}

/// Distinct values, rising.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| a.total_cmp(b).is_eq());
    values
}

/// Index of a value among rising ones that contain it.
fn place(values: &[f64], value: f64) -> usize {
    values.partition_point(|other| other.total_cmp(&value).is_lt())
}

impl<'a> Misfit<'a> {
    pub(super) fn new(points: &'a [MeasuredPoint], uncertainty: Uncertainty) -> Self {
        let mut groups: Vec<PatchGroup> = Vec::new();
        for patch in distinct(points.iter().map(|point| point.patch)) {
            let of_patch = points.iter().filter(|point| point.patch.total_cmp(&patch).is_eq());
            let frequencies = distinct(of_patch.map(|point| point.frequency));
            match groups.iter_mut().find(|group| group.frequencies == frequencies) {
                Some(group) => group.patches.push(patch),
                None => groups.push(PatchGroup { patches: vec![patch], frequencies }),
            }
        }
        let find = |point: &MeasuredPoint| {
            let holds = |group: &PatchGroup| group.patches.iter().any(|patch| patch.total_cmp(&point.patch).is_eq());
            let number = groups.iter().position(holds).unwrap_or(0);
            let PatchGroup { patches, frequencies } = &groups[number];
            (number, place(frequencies, point.frequency), place(patches, point.patch))
        };
        let places = points.iter().map(find).collect();
        Self { points, uncertainty, groups, places }
    }

    /// Mobilities of a tyre at the measured points, in their order \[m/(N s)\].
    pub(super) fn mobilities(&self, tyre: &Tyre) -> Vec<Complex64> {
        let computed = |group: &PatchGroup| driving_point(tyre, &group.patches, &group.frequencies).values;
        let values: Vec<Vec<Vec<Complex64>>> = self.groups.iter().map(computed).collect();
        self.places.iter().map(|&(group, row, column)| values[group][row][column]).collect()
    }

    /// Residuals of a tyre; NaN without computing any sum once `stop` is set.
    pub(super) fn residuals_unless(&self, stop: &AtomicBool, tyre: &Tyre) -> Vec<f64> {
        if stop.load(Ordering::Relaxed) {
            return vec![f64::NAN; 2 * self.points.len()];
        }
        self.residuals(&self.mobilities(tyre))
    }

    /// Differences of level and phase, computed less measured, over their uncertainties: two for each point. The phase
    /// difference is taken within +-180 degrees.
    pub(super) fn residuals(&self, mobilities: &[Complex64]) -> Vec<f64> {
        let pairs = self.points.iter().zip(mobilities).flat_map(|(point, mobility)| {
            let difference = (mobility / point.mobility).ln();
            let level = DECIBELS * difference.re / self.uncertainty.level;
            [level, difference.im.to_degrees() / self.uncertainty.phase]
        });
        pairs.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::plate_tyre;

    #[test]
    fn patches_of_equal_frequencies_are_grouped() {
        let tyre = plate_tyre();
        let at = |frequency, patch| MeasuredPoint { frequency, patch, mobility: Complex64::new(1.0, 0.0) };
        let points = [at(90.0, 0.05), at(70.0, 0.02), at(70.0, 0.05), at(90.0, 0.02), at(80.0, 0.03), at(70.0, 0.02)];
        let misfit = Misfit::new(&points, Uncertainty { level: 1.0, phase: 1.0 });
        assert_eq!(misfit.groups.iter().map(|group| group.patches.len()).collect::<Vec<_>>(), [2, 1]);
        for (point, value) in points.iter().zip(misfit.mobilities(&tyre)) {
            let alone = driving_point(&tyre, &[point.patch], &[point.frequency]).values[0][0];
            // The sums end at the smallest patch's lobes: one more patch changes no more than rounding.
            assert!((value - alone).norm() < 1e-6 * alone.norm(), "{point:?}");
        }
    }

    #[test]
    fn nothing_is_summed_once_the_end_is_asked_for() {
        let points = [MeasuredPoint { frequency: 90.0, patch: 0.05, mobility: Complex64::new(1.0, 0.0) }];
        let misfit = Misfit::new(&points, Uncertainty { level: 1.0, phase: 1.0 });
        let [going_on, asked] =
            [false, true].map(|stop| misfit.residuals_unless(&AtomicBool::new(stop), &plate_tyre()));
        assert!(going_on.iter().all(|residual| residual.is_finite()), "{going_on:?}");
        assert!(asked.len() == going_on.len() && asked.iter().all(|residual| residual.is_nan()), "{asked:?}");
    }

    #[test]
    fn residuals_are_in_decibels_and_the_smaller_angle() {
        let point = |degrees: f64| MeasuredPoint {
            frequency: 100.0,
            patch: 0.05,
            mobility: Complex64::from_polar(2.0, degrees.to_radians()),
        };
        let points = [point(10.0), point(-179.0)];
        let misfit = Misfit::new(&points, Uncertainty { level: 0.5, phase: 3.0 });
        let found = misfit.residuals(&[Complex64::from_polar(20.0, 0.0), Complex64::from_polar(2.0, 3.0)]);
        let expected = [40.0, -10.0 / 3.0, 0.0, (3.0_f64.to_degrees() - 181.0) / 3.0];
        found.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-9, "{found:?}"));
    }
}
