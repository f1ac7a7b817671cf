//! A computed value beside its published range.

use serde::Serialize;

use super::missing::Missing;
use super::published::RangeOrigin;
use crate::counters::catalogue::catalogue;
use crate::scene::NamedTexture;

catalogue! {
    /// Part of the table that a row stands in.
    pub enum Group as "kebab-case",
    /// Heading of the group.
    title {
        /// Properties of the standing tyre.
        Tyre => "tyre, standing",
        /// Third octaves relative to their energy sum at 50 km/h.
        Shape50 => "third octaves, 50 km/h",
        /// The same at 80 km/h.
        Shape80 => "third octaves, 80 km/h",
        /// The same at 110 km/h.
        Shape110 => "third octaves, 110 km/h",
        /// Growth of third octaves with the speed.
        Growth => "growth of third octaves, 50 to 110 km/h",
        /// Overall levels.
        Levels => "overall levels",
        /// Differences of roads.
        Roads => "differences of roads",
        /// Rolling resistance.
        Resistance => "rolling resistance",
        /// Targets that the tyre was fitted to: shown, and no part of the validation.
        Targets => "targets of the fit, no validation",
    }
}

/// A value compared with its range.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValidationRow {
    /// Part of the table.
    pub group: Group,
    /// Name of the quantity.
    pub title: String,
    /// Road of a comparison with fleets of cars; absent where the title names the roads, or none.
    pub road: Option<NamedTexture>,
    /// Unit of value and range.
    pub unit: String,
    /// Computed value; absent where the runs do not give it.
    pub computed: Option<f64>,
    /// Bound of its numerical error, by slices included, where that is known: stated errors of levels, which add up in
    /// differences.
    pub numerical_error: Option<f64>,
    /// How far below and above it the value may lie on roads as they may be; absent where no such road was rolled.
    pub road_spread: Option<[f64; 2]>,
    /// True if it is a lower bound: bands that matter may be missing.
    pub is_lower_bound: bool,
    /// Lowest and highest published value.
    pub range: [f64; 2],
    /// Number of sets of published values.
    pub sets: usize,
    /// Spread in words.
    pub spread: String,
    /// Source of the range.
    pub source: String,
    /// Measured, or a target of a fit.
    pub kind: RangeOrigin,
    /// Physics that the model lacks, and other reasons, that could explain a value outside.
    pub could_explain: Vec<Missing>,
}

/// Judgement of a row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "verdict", content = "by")]
pub(crate) enum Verdict {
    /// Within the range.
    Inside,
    /// Below the range by this much, in the row's unit.
    Below(f64),
    /// Above the range by this much, in the row's unit.
    Above(f64),
    /// Inside on some of the roads as they may be, outside on others.
    CannotBeTold,
    /// Not computed, or a lower bound that is not above the range.
    Unknown,
}

impl ValidationRow {
    /// Name of the quantity, with its road.
    pub(crate) fn name(&self) -> String {
        self.road.map_or_else(|| self.title.clone(), |road| format!("{}, {}", self.title, road.name()))
    }

    /// Judges the value, which may lie anywhere in the spread of its road; one on the edge is inside.
    pub(crate) fn verdict(&self) -> Verdict {
        let Some(value) = self.computed.filter(|value| value.is_finite()) else { return Verdict::Unknown };
        let ([lowest, highest], [below, above]) = (self.range, self.road_spread.unwrap_or_default());
        if value + below > highest {
            Verdict::Above(value - highest)
        } else if self.is_lower_bound {
            Verdict::Unknown
        } else if value + above < lowest {
            Verdict::Below(lowest - value)
        } else if value + below >= lowest && value + above <= highest {
            Verdict::Inside
        } else {
            Verdict::CannotBeTold
        }
    }

    /// True if the value is a lower bound that decides nothing.
    pub(crate) fn is_bound(&self) -> bool {
        self.is_lower_bound && self.computed.is_some() && self.verdict() == Verdict::Unknown
    }

    /// Signed distance from the range: 0 inside, negative below it; `None` where that cannot be told.
    pub(crate) fn outside(&self) -> Option<f64> {
        match self.verdict() {
            Verdict::Inside => Some(0.0),
            Verdict::Below(by) => Some(-by),
            Verdict::Above(by) => Some(by),
            Verdict::CannotBeTold | Verdict::Unknown => None,
        }
    }
}

/// Rows of a group together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct GroupSummary {
    /// Part of the table.
    pub group: Group,
    /// Number of all rows.
    pub rows: usize,
    /// Number of rows inside or outside.
    pub known: usize,
    /// Number of rows that are inside on some of the roads as they may be, outside on others.
    pub cannot_be_told: usize,
    /// Number of rows with a lower bound that decides nothing.
    pub bounds: usize,
    /// Number of rows inside their range.
    pub inside: usize,
    /// Index among all rows of the one farthest outside, relative to the width of its range; `None` if none is outside.
    pub worst: Option<usize>,
}

pub(crate) fn summaries(rows: &[ValidationRow]) -> Vec<GroupSummary> {
    let of = |group: Group| {
        let of_group: Vec<(usize, &ValidationRow)> =
            rows.iter().enumerate().filter(|(_, row)| row.group == group).collect();
        let relative = |row: &ValidationRow| row.outside().map_or(0.0, |by| by.abs() / (row.range[1] - row.range[0]));
        let worst = of_group.iter().filter(|(_, row)| relative(row) > 0.0);
        let worst = worst.max_by(|a, b| relative(a.1).total_cmp(&relative(b.1))).map(|(place, _)| *place);
        let count = |is: &dyn Fn(&ValidationRow) -> bool| of_group.iter().filter(|(_, row)| is(row)).count();
        (!of_group.is_empty()).then(|| GroupSummary {
            group,
            rows: of_group.len(),
            known: count(&|row| row.outside().is_some()),
            cannot_be_told: count(&|row| row.verdict() == Verdict::CannotBeTold),
            bounds: count(&ValidationRow::is_bound),
            inside: count(&|row| row.verdict() == Verdict::Inside),
            worst,
        })
    };
    Group::ALL.into_iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(computed: Option<f64>) -> ValidationRow {
        ValidationRow {
            group: Group::Levels,
            title: "level".to_owned(),
            road: None,
            unit: "dB".to_owned(),
            computed,
            numerical_error: None,
            road_spread: None,
            is_lower_bound: false,
            range: [-1.0, 3.0],
            sets: 2,
            spread: String::new(),
            source: String::new(),
            kind: RangeOrigin::Measured,
            could_explain: Vec::new(),
        }
    }

    #[test]
    fn a_value_is_inside_up_to_the_edge_and_outside_by_its_distance() {
        let outside = |value| row(value).outside();
        assert_eq!([outside(Some(-1.0)), outside(Some(3.0)), outside(Some(0.0))], [Some(0.0); 3]);
        assert_eq!((outside(Some(-3.5)), outside(Some(5.0))), (Some(-2.5), Some(2.0)));
        assert_eq!((outside(None), outside(Some(f64::NAN))), (None, None));
        assert_eq!(row(Some(f64::NAN)).verdict(), Verdict::Unknown);
        // A lower bound may lie anywhere above.
        let bound = |value| ValidationRow { is_lower_bound: true, ..row(Some(value)) }.verdict();
        assert_eq!([bound(-3.5), bound(0.0), bound(5.0)], [Verdict::Unknown, Verdict::Unknown, Verdict::Above(2.0)]);
    }

    #[test]
    fn a_road_as_it_may_be_decides_only_where_all_of_it_agrees() {
        let verdict = |value, spread| ValidationRow { road_spread: Some(spread), ..row(Some(value)) }.verdict();
        assert_eq!(verdict(0.0, [-1.0, 3.0]), Verdict::Inside);
        assert_eq!(verdict(5.0, [-1.0, 3.0]), Verdict::Above(2.0));
        assert_eq!(verdict(-4.0, [-9.0, 2.0]), Verdict::Below(3.0));
        for (value, spread) in [(5.0, [-3.0, 0.0]), (0.0, [-1.5, 0.0]), (0.0, [0.0, 4.0]), (-4.0, [0.0, 9.0])] {
            assert_eq!(verdict(value, spread), Verdict::CannotBeTold, "{value} {spread:?}");
        }
        // A bound is above the range only if it is so on every road.
        let bound =
            |spread| ValidationRow { is_lower_bound: true, road_spread: Some(spread), ..row(Some(5.0)) }.verdict();
        assert_eq!((bound([-1.0, 1.0]), bound([-3.0, 1.0])), (Verdict::Above(2.0), Verdict::Unknown));
    }

    #[test]
    fn a_group_is_summed_up_with_its_worst_row() {
        let mut rows: Vec<ValidationRow> = [Some(0.0), Some(4.0), None, Some(-7.0)].map(row).into();
        rows.push(ValidationRow { group: Group::Tyre, ..row(Some(0.0)) });
        rows.extend([0.0, 9.0].map(|value| ValidationRow {
            is_lower_bound: true,
            group: Group::Roads,
            ..row(Some(value))
        }));
        let [tyre, levels, roads] = &summaries(&rows)[..] else { panic!("three groups") };
        assert_eq!((roads.rows, roads.known, roads.bounds, roads.inside), (2, 1, 1, 0));
        assert_eq!((tyre.group, tyre.rows, tyre.inside, tyre.worst), (Group::Tyre, 1, 1, None));
        assert_eq!((levels.rows, levels.known, levels.inside, levels.worst), (4, 3, 1, Some(3)));
        assert_eq!(levels.bounds, 0);
    }
}
