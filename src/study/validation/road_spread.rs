//! Uncertainty of the roads in a validation: how far its rows lie off on constructed roads as they may be.
//!
//! 1. Each constructed road is rolled as it is stated, with its levels off by their uncertainty, and with each skewness
//!    that was read of rolled surfaces: short runs on the same piece of road.
//! 2. A case of one road changes the rows of that road alone, at all speeds. The least and the largest change over the
//!    levels, and over the skewness, are added, and those of different roads.

use super::compare::compared;
use super::measure::{CaseRun, Measured, ValidationRun};
use super::published::Published;
use super::road_case::RoadCase;
use super::row::ValidationRow;
use crate::scene::NamedTexture;

/// Compares everything measured with everything published, in the order of the table; targets of a fit come last, in a
/// separate group. Rows of speeds and roads that were not rolled have no value, rows of roads that were rolled only as
/// they are stated no spread.
pub fn rows(measured: &Measured, published: &Published) -> Vec<ValidationRow> {
    let mut rows = compared(measured, published);
    for (row, spread) in rows.iter_mut().zip(spreads(measured, published)) {
        row.road_spread = spread;
    }
    rows
}

fn spreads(measured: &Measured, published: &Published) -> Vec<Option<[f64; 2]>> {
    // 1. Rows of the short runs on roads as stated; other roads keep their long runs, which leave differences alone.
    let with = |runs: &mut Vec<ValidationRun>, case: &CaseRun| {
        let is_same = |run: &&mut ValidationRun| {
            run.texture == case.run.texture && (run.speed_kmh - case.run.speed_kmh).abs() < 1e-9
        };
        if let Some(run) = runs.iter_mut().find(is_same) {
            *run = case.run.clone();
        }
    };
    let mut stated = Measured { cases: Vec::new(), ..measured.clone() };
    for case in measured.cases.iter().filter(|of| of.case == RoadCase::Stated) {
        with(&mut stated.runs, case);
    }
    let stated_rows = compared(&stated, published);

    // 2. Changes of the rows for each road, and for its levels and its skewness.
    let mut spreads = vec![None; stated_rows.len()];
    for texture in NamedTexture::ALL {
        for of_levels in [true, false] {
            let cases = RoadCase::of(texture).into_iter().filter(|case| *case != RoadCase::Stated);
            let mut extents = vec![[0.0_f64; 2]; stated_rows.len()];
            for case in cases.filter(|case| case.is_level() == of_levels) {
                let rolled = |of: &&CaseRun| of.case == case && of.run.texture == texture;
                let mut changed = stated.clone();
                measured.cases.iter().filter(rolled).for_each(|case| with(&mut changed.runs, case));
                for (place, row) in compared(&changed, published).into_iter().enumerate() {
                    let Some((value, stated)) = row.computed.zip(stated_rows[place].computed) else { continue };
                    let [below, above] = extents[place];
                    extents[place] = [below.min(value - stated), above.max(value - stated)];
                }
            }
            // 3. Rows that a road does not change have no spread of it.
            for (spread, extent) in
                spreads.iter_mut().zip(extents).filter(|(_, extent)| extent.iter().any(|end| end.abs() > 0.0))
            {
                let [below, above] = spread.unwrap_or([0.0; 2]);
                *spread = Some([below + extent[0], above + extent[1]]);
            }
        }
    }
    spreads
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::super::measure::StandingTyre;
    use super::super::missing::Lacks;
    use super::super::row::Group;
    use super::*;

    /// Run whose bands have one level, with a resistance of 15 N/kN.
    fn run(texture: NamedTexture, speed_kmh: f64, level: f64) -> ValidationRun {
        let bands: BTreeMap<i32, f64> = (-7..=4).map(|band| (band, level)).collect();
        ValidationRun {
            texture,
            speed_kmh,
            coast_by: None,
            pass_by: None,
            cpx: None,
            coast_by_bands: bands.clone(),
            cpx_bands: bands,
            band_errors: Default::default(),
            rolling_resistance: Some(30.0),
        }
    }

    #[test]
    fn changes_by_levels_and_skewness_add_up_for_each_road() {
        let roads = [(NamedTexture::DenseAsphalt11, 1.0), (NamedTexture::StoneMastic8, 2.0)];
        let mut measured = Measured {
            tyre: StandingTyre::default(),
            runs: vec![run(NamedTexture::ChipSeal, 80.0, 90.0)],
            cases: Vec::new(),
            load: 2000.0,
            lacks: Lacks { sidewalls: false, cells: false },
        };
        for (texture, factor) in roads {
            for speed in [50.0, 80.0, 110.0] {
                // Long runs are elsewhere by 7 dB: only short runs are compared with each other.
                measured.runs.push(run(texture, speed, 67.0));
                for case in RoadCase::of(texture) {
                    let change = match case {
                        RoadCase::Stated => 0.0,
                        RoadCase::Offset(offset) => offset.signum() * factor,
                        RoadCase::Skewness(skewness) => 0.25 * (skewness + 1.0).signum() * factor,
                    };
                    let grown = if speed > 100.0 { 2.0 * change } else { change };
                    measured.cases.push(CaseRun { case, run: run(texture, speed, 60.0 + grown) });
                }
            }
        }
        let rows = rows(&measured, &Published::embedded());
        let spread = |group, title: &str, road| {
            let row = rows.iter().find(|row| (row.group, row.road) == (group, road) && row.title.contains(title));
            row.unwrap().road_spread
        };
        // Levels of chip seal less those of sma-8, which change by 2 and by 0.5 dB.
        let [below, above] = spread(Group::Roads, "octave 500 Hz", None).unwrap();
        assert!((below + 2.5).abs() < 1e-9 && (above - 2.5).abs() < 1e-9, "{below} {above}");
        // From 50 to 110 km/h the change grows by itself.
        let decades = (110.0_f64 / 50.0).log10();
        for (texture, factor) in roads {
            let [below, above] = spread(Group::Growth, "500 Hz", Some(texture)).unwrap();
            let expected = 1.25 * factor / decades;
            assert!((below + expected).abs() < 1e-9 && (above - expected).abs() < 1e-9, "{below} {above}");
        }
        // All bands change alike: relative to their sum nothing does.
        let [below, above] = spread(Group::Shape80, "500 Hz", Some(roads[0].0)).unwrap_or_default();
        assert!(below.abs() < 1e-9 && above.abs() < 1e-9, "{below} {above}");
        assert_eq!(spread(Group::Tyre, "air within", None), None);
        measured.cases.clear();
        assert!(super::rows(&measured, &Published::embedded()).iter().all(|row| row.road_spread.is_none()));
    }
}
