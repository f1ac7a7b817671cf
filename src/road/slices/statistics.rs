//! Spread of the slices of a road: S and contact fraction over the road at given penetrations.

use serde::Serialize;

use super::StiffnessCurve;

/// Spread of one quantity over the slices of a road.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct SliceSpread {
    /// Arithmetic mean.
    pub mean: f64,
    /// 5 % quantile.
    pub low: f64,
    /// 50 % quantile.
    pub median: f64,
    /// 95 % quantile.
    pub high: f64,
}

/// The slices of a road at one penetration, each past its highest point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct LevelStatistics {
    /// Penetration y \[m\].
    pub penetration: f64,
    /// S(y) \[m\].
    pub displacement: SliceSpread,
    /// Normalised stiffness s(y): for independent springs the share of the width in contact, on the half-space the
    /// stiffness of the cells in contact relative to the flat slice's.
    pub stiffness: SliceSpread,
}

/// Statistics of curves at each of `penetrations` \[m\]; `None` without curves.
pub(crate) fn statistics(curves: &[StiffnessCurve], penetrations: &[f64]) -> Option<Vec<LevelStatistics>> {
    let mut values = Vec::with_capacity(curves.len());
    penetrations
        .iter()
        .map(|&penetration| {
            let mut of = |value: fn(&StiffnessCurve, f64) -> f64| {
                values.clear();
                values.extend(curves.iter().map(|curve| value(curve, penetration)));
                spread(&mut values)
            };
            let displacement = of(StiffnessCurve::displacement_at)?;
            let stiffness = of(StiffnessCurve::stiffness_at)?;
            Some(LevelStatistics { penetration, displacement, stiffness })
        })
        .collect()
}

/// Spread of the values, which get sorted; quantiles are those of the nearest rank. `None` without values.
fn spread(values: &mut [f64]) -> Option<SliceSpread> {
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    let quantile = |share: f64| values[(share * last as f64).round() as usize];
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    Some(SliceSpread { mean, low: quantile(0.05), median: quantile(0.5), high: quantile(0.95) })
}

#[cfg(test)]
mod tests {
    use super::super::SliceBuilder;
    use super::*;

    #[test]
    fn a_ramp_of_steps_spreads_as_counted() {
        // Slice k has one column at 0 and one k/100 mm below: full contact from that depth on.
        let heights: Vec<f64> = (0..101).flat_map(|k| [0.0, -1e-5 * f64::from(k)]).collect();
        let curves = SliceBuilder::winkler(2).unwrap().build_rows(&heights).unwrap();
        let levels = statistics(&curves, &[5.05e-4]).unwrap();
        let SliceSpread { mean, low, median, high } = levels[0].stiffness;
        // Slices 0 to 50 touch with both columns, 51 to 100 with one.
        assert!((mean - (51.0 + 0.5 * 50.0) / 101.0).abs() < 1e-12);
        assert!((low - 0.5).abs() < 1e-12 && (median - 1.0).abs() < 0.51 && (high - 1.0).abs() < 1e-12);
        assert!(levels[0].displacement.low < levels[0].displacement.high);
        assert!(statistics(&[], &[1e-3]).is_none());
    }
}
