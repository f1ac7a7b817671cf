//! Comparison of measured and published values: arithmetic alone.

use super::measure::{Measured, StandingTyre, ValidationRun};
use super::missing::{Compared, Lacks};
use super::published::{BANDS, FLEET_ROADS, PUBLISHED_SPEEDS, Published, RangeOrigin, bands, decades, energy_sum};
use super::row::{Group, ValidationRow};
use crate::numeric::StraightLine;
use crate::response::ThirdOctaveBand;
use crate::scene::NamedTexture;
use crate::sound::{Compared as TotalsCompared, TotalLevel};

/// Roads whose difference represents hot rolled asphalt less stone mastic asphalt.
const COARSE_LESS_FINE: [NamedTexture; 2] = [NamedTexture::ChipSeal, NamedTexture::StoneMastic8];
/// Octaves by their name among the quantities, with their third octaves; that of 2 kHz as far as radiation is solved.
const OCTAVES: [(&str, std::ops::RangeInclusive<i32>); 5] =
    [("hra_250", -7..=-5), ("hra_500", -4..=-2), ("hra_1000", -1..=1), ("hra_2000", 2..=3), ("hra_4000", 5..=7)];

/// The rows without the uncertainty of their roads, always of the same quantities.
pub(super) fn compared(measured: &Measured, published: &Published) -> Vec<ValidationRow> {
    let table = Table { measured, published, lacks: measured.lacks };
    let mut rows = table.tyre();
    for road in FLEET_ROADS {
        let of_road = rows.len();
        for (speed, group) in [Group::Shape50, Group::Shape80, Group::Shape110].into_iter().enumerate() {
            rows.extend(table.shape(road, speed, group));
        }
        rows.extend(table.growth(road));
        rows.extend(table.levels(road));
        rows[of_road..].iter_mut().for_each(|row| row.road = Some(road));
    }
    rows.extend(table.roads());
    rows.extend(table.resistance());
    for row in rows.iter_mut().filter(|row| row.kind == RangeOrigin::Target) {
        row.group = Group::Targets;
    }
    rows.sort_by_key(|row| row.group);
    rows
}

/// Third octaves of one tyre at the coast-by microphone, of a published set or computed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TyreLevels {
    /// Name of the set, or of the road.
    pub name: String,
    /// Computed, not published.
    pub is_computed: bool,
    /// Levels from 200 Hz to 2 kHz, where known \[dB(A)\].
    pub levels: Vec<Option<f64>>,
}

/// Levels of one tyre at 80 km/h: each published set, then those computed on the roads for fleets, whose mean third
/// octaves are shifted together to the maximum of the coast-by.
pub(crate) fn levels_of_one_tyre(measured: &Measured, published: &Published) -> Vec<TyreLevels> {
    let table = Table { measured, published, lacks: measured.lacks };
    let sets = published.sets.iter().map(|set| TyreLevels {
        name: set.source.clone(),
        is_computed: false,
        levels: bands().map(|band| set.level(1, band)).collect(),
    });
    let computed = FLEET_ROADS.map(|road| {
        let run = table.run(road, 1);
        let shift = run.and_then(|run| Some(run.coast_by.as_ref()?.level - energy_of(run, BANDS)?));
        TyreLevels {
            name: format!("computed, {}", road.name()),
            is_computed: true,
            levels: bands().map(|band| Some(run?.coast_by_band(band)? + shift?)).collect(),
        }
    });
    sets.chain(computed).collect()
}

/// A computed value with its numerical error, where that is known.
#[derive(Clone, Copy, Debug)]
struct Computed {
    value: f64,
    error: Option<f64>,
}

impl Computed {
    const fn without_error(value: f64) -> Self {
        Self { value, error: None }
    }

    fn of(total: &TotalLevel) -> Self {
        Self { value: total.level, error: total.error }
    }

    /// A difference: errors add up.
    fn less(self, other: Self) -> Self {
        let error = self.error.zip(other.error).map(|(one, other)| one + other);
        Self { value: self.value - other.value, error }
    }

    fn over(self, divisor: f64) -> Self {
        Self { value: self.value / divisor, error: self.error.map(|error| error / divisor) }
    }
}

struct Table<'a> {
    measured: &'a Measured,
    published: &'a Published,
    lacks: Lacks,
}

impl Table<'_> {
    /// Run on a road at the published speed of this index.
    fn run(&self, texture: NamedTexture, speed: usize) -> Option<&ValidationRun> {
        let of =
            |run: &&ValidationRun| run.texture == texture && (run.speed_kmh - PUBLISHED_SPEEDS[speed]).abs() < 1e-9;
        self.measured.runs.iter().find(of)
    }

    /// Row of a single quantity; empty for a name without one.
    fn single(
        &self,
        group: Group,
        of: Compared,
        name: &str,
        frequency: Option<f64>,
        value: Option<Computed>,
    ) -> Vec<ValidationRow> {
        let Some(quantity) = self.published.quantity(name) else { return Vec::new() };
        let row = ValidationRow {
            group,
            title: quantity.title.clone(),
            road: None,
            unit: quantity.unit.clone(),
            computed: value.map(|computed| computed.value).filter(|value| value.is_finite()),
            numerical_error: value.and_then(|computed| computed.error),
            road_spread: None,
            is_lower_bound: false,
            range: [quantity.lowest, quantity.highest],
            sets: quantity.sets,
            spread: quantity.spread.clone(),
            source: quantity.source.clone(),
            kind: quantity.kind,
            could_explain: Vec::new(),
        };
        vec![self.explained(row, of, frequency)]
    }

    fn explained(&self, mut row: ValidationRow, of: Compared, frequency: Option<f64>) -> ValidationRow {
        row.could_explain = self.lacks.reasons(of, frequency, row.outside().unwrap_or_default());
        row
    }

    fn tyre(&self) -> Vec<ValidationRow> {
        let StandingTyre { stiffness, patches, modes, breathing, cavity } = &self.measured.tyre;
        let mut values = vec![("stiffness".to_owned(), stiffness.map(|stiffness| 1e-3 * stiffness))];
        let patches = ["patch_300", "patch_350", "patch_400"].into_iter().zip(patches);
        values.extend(patches.map(|(name, length)| (name.to_owned(), length.map(|length| 1e3 * length))));
        values.extend(modes.iter().enumerate().map(|(place, mode)| (format!("mode_{}", place + 1), *mode)));
        values.extend([("breathing".to_owned(), *breathing), ("cavity".to_owned(), *cavity)]);
        let row = |(name, value): (String, Option<f64>)| {
            self.single(Group::Tyre, Compared::Tyre, &name, None, value.map(Computed::without_error))
        };
        values.into_iter().flat_map(row).collect()
    }

    fn shape(&self, road: NamedTexture, speed: usize, group: Group) -> Vec<ValidationRow> {
        let run = self.run(road, speed);
        let sum = run.and_then(|run| energy_of(run, BANDS));
        let row = |band: ThirdOctaveBand| {
            let level = run.and_then(|run| run.coast_by_band(band)).zip(sum);
            let range = self.published.shape_range(speed, band);
            let error = run.and_then(|run| run.band_errors[0].get(&band.0).copied());
            let row =
                self.band_row(group, band, level.map(|(level, sum)| Computed { value: level - sum, error }), range);
            self.explained(row, Compared::Shape, Some(band.nominal_frequency()))
        };
        bands().map(row).collect()
    }

    fn growth(&self, road: NamedTexture) -> Vec<ValidationRow> {
        let ends = self.run(road, 0).zip(self.run(road, 2));
        let row = |band: ThirdOctaveBand| {
            let level = |run: &ValidationRun| {
                Some(Computed { value: run.coast_by_band(band)?, error: run.band_errors[0].get(&band.0).copied() })
            };
            let levels = ends.and_then(|(slow, fast)| level(slow).zip(level(fast)));
            let growth = levels.map(|(slow, fast)| fast.less(slow).over(decades()));
            let row = self.band_row(Group::Growth, band, growth, self.published.growth_range(band));
            self.explained(row, Compared::Growth, Some(band.nominal_frequency()))
        };
        bands().map(row).collect()
    }

    fn band_row(&self, group: Group, band: ThirdOctaveBand, value: Option<Computed>, range: [f64; 2]) -> ValidationRow {
        let widening = if group == Group::Growth { &self.published.growth } else { &self.published.shape };
        let sources: Vec<&str> = self.published.sets.iter().map(|set| set.source.as_str()).collect();
        ValidationRow {
            group,
            title: format!("{} Hz", band.nominal_frequency()),
            road: None,
            unit: widening.unit.clone(),
            computed: value.map(|computed| computed.value).filter(|value| value.is_finite()),
            numerical_error: value.and_then(|computed| computed.error),
            road_spread: None,
            is_lower_bound: false,
            range,
            sets: self.published.sets.len(),
            spread: format!("+-{} {}: {}", widening.spread, widening.unit, widening.reason),
            source: sources.join("; "),
            kind: RangeOrigin::Measured,
            could_explain: Vec::new(),
        }
    }

    fn levels(&self, road: NamedTexture) -> Vec<ValidationRow> {
        let mut rows = Vec::new();
        let runs = [0, 1, 2].map(|speed| self.run(road, speed));
        let level = |speed: usize| runs[speed].and_then(|run| run.coast_by.as_ref());
        for (speed, name) in ["level_50", "level_80", "level_110"].into_iter().enumerate() {
            let total = level(speed);
            let is_lower_bound = total.is_some_and(TotalLevel::is_lower_bound);
            let found = self.single(Group::Levels, Compared::Level, name, None, total.map(Computed::of));
            rows.extend(
                found
                    .into_iter()
                    .map(|row| self.explained(ValidationRow { is_lower_bound, ..row }, Compared::Level, None)),
            );
        }
        let growth = level(0).zip(level(2)).and_then(|(slow, fast)| Some(less(fast, slow)?.over(decades())));
        rows.extend(self.single(Group::Levels, Compared::Growth, "overall_growth", None, growth));
        let loudest = runs[1].and_then(|run| {
            let known = bands().filter_map(|band| Some((band, run.coast_by_band(band)?)));
            known.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(band, _)| band.nominal_frequency())
        });
        let shape = Compared::Shape;
        // A loudest band that lies too low means that a low one is too loud.
        let mut loudest_row =
            self.single(Group::Levels, shape, "loudest_band", loudest, loudest.map(Computed::without_error));
        for row in &mut loudest_row {
            let outside = row.outside().unwrap_or_default();
            row.could_explain = self.lacks.reasons(shape, loudest, -outside);
        }
        rows.extend(loudest_row);
        for speed in 0..3 {
            // The errors of the forces, which are those of one run, cancel out: no bound is known.
            let less = runs[speed].and_then(|run| less(run.cpx.as_ref()?, run.coast_by.as_ref()?));
            let less = less.map(|less| Computed::without_error(less.value));
            let found = self.single(Group::Levels, Compared::Receivers, "cpx_less_coast_by", None, less);
            rows.extend(found.into_iter().map(|row| {
                let title = format!("{}, {} km/h", row.title, PUBLISHED_SPEEDS[speed]);
                ValidationRow { title, ..row }
            }));
        }
        rows
    }

    fn roads(&self) -> Vec<ValidationRow> {
        let mut rows = Vec::new();
        for (name, mastic) in
            [("sma_8_less_dac_11", NamedTexture::StoneMastic8), ("sma_11_less_dac_11", NamedTexture::StoneMastic11)]
        {
            let runs = self.run(mastic, 1).zip(self.run(NamedTexture::DenseAsphalt11, 1));
            let less = runs.and_then(|(mastic, dense)| less(mastic.coast_by.as_ref()?, dense.coast_by.as_ref()?));
            rows.extend(self.single(Group::Roads, Compared::Roads, name, None, less));
        }
        let [coarse, fine] = COARSE_LESS_FINE.map(|texture| self.run(texture, 1));
        for (name, octave) in OCTAVES {
            let middle = ThirdOctaveBand(octave.start() + 1).nominal_frequency();
            let level = |run: &ValidationRun| {
                let levels: Option<Vec<f64>> = octave.clone().map(|band| run.cpx_bands.get(&band).copied()).collect();
                let errors = octave.clone().map(|band| run.band_errors[1].get(&band).copied());
                let error = errors.collect::<Option<Vec<f64>>>().map(|errors| errors.into_iter().fold(0.0, f64::max));
                levels.map(|levels| Computed { value: energy_sum(levels), error })
            };
            let less = coarse.zip(fine).and_then(|(coarse, fine)| Some(level(coarse)?.less(level(fine)?)));
            rows.extend(self.single(Group::Roads, Compared::Roads, name, Some(middle), less));
        }
        rows
    }

    fn resistance(&self) -> Vec<ValidationRow> {
        let of = |texture| self.run(texture, 1).and_then(|run| run.rolling_resistance);
        let per_load = |resistance: f64| 1e3 * resistance / self.measured.load;
        let smooth = of(NamedTexture::Iso10844).map(per_load).map(Computed::without_error);
        let mut rows = self.single(Group::Resistance, Compared::Resistance, "rolling_resistance", None, smooth);
        let points: Vec<(f64, f64)> = NamedTexture::ALL
            .into_iter()
            .filter_map(|texture| Some((1e3 * texture.depth()[0], per_load(of(texture)?))))
            .collect();
        let line = if points.len() > 1 { StraightLine::through(&points) } else { None };
        let slope = line.map(|line| Computed::without_error(line.slope));
        let name = "rolling_resistance_per_depth";
        rows.extend(self.single(Group::Resistance, Compared::Resistance, name, None, slope));
        rows
    }
}

/// A level less another one \[dB\]; `None` if their common bands do not include the loudest one: published differences
/// are of complete levels.
fn less(one: &TotalLevel, other: &TotalLevel) -> Option<Computed> {
    let compared = TotalsCompared::for_growth(&[one, other]).ok()?;
    let computed = |place: usize, total: &TotalLevel| Computed { value: compared.levels[place], error: total.error };
    Some(computed(0, one).less(computed(1, other)))
}

/// Level of all bands together \[dB(A)\]; `None` if one is not known.
fn energy_of(run: &ValidationRun, bands: std::ops::RangeInclusive<i32>) -> Option<f64> {
    let levels: Option<Vec<f64>> = bands.map(|band| run.coast_by_band(ThirdOctaveBand(band))).collect();
    levels.map(energy_sum)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::response::BandLevel;
    use crate::study::validation::published::{ROADS, is_compared};
    use crate::study::validation::row::{Verdict, summaries};

    /// Run with levels that fall by 2 dB per band from 200 Hz on and grow by 30 dB per decade.
    fn run(texture: NamedTexture, speed: usize, shift: f64) -> ValidationRun {
        let grown = 30.0 * (PUBLISHED_SPEEDS[speed] / 80.0).log10() + shift;
        let bands: BTreeMap<i32, f64> = (-7..=4).map(|band| (band, 60.0 - 2.0 * f64::from(band) + grown)).collect();
        ValidationRun {
            texture,
            speed_kmh: PUBLISHED_SPEEDS[speed],
            coast_by: Some(total(4, 70.0 + grown).at_most(70.0 + grown)),
            pass_by: None,
            cpx: Some(total(4, 98.0 + grown)),
            coast_by_bands: bands.clone(),
            cpx_bands: bands,
            band_errors: Default::default(),
            rolling_resistance: Some(30.0 + 2.0e3 * texture.depth()[0]),
        }
    }

    /// Level whose bands are loudest at 800 Hz and valid up to one of them.
    fn total(valid_to: i32, level: f64) -> TotalLevel {
        let band = |n: i32| {
            let level = 60.0 - 4.0 * f64::from((n + 1).abs());
            BandLevel { band: ThirdOctaveBand(n), mean_square: 1.0, level, valid: n <= valid_to }
        };
        TotalLevel { level, error: Some(0.5), ..TotalLevel::of((-7..=4).map(band).collect()).unwrap() }
    }

    #[test]
    fn levels_of_few_bands_are_bounds_without_differences() {
        let published = Published::embedded();
        let mut few = measured();
        few.runs[2].coast_by = Some(total(-6, 11.5).at_most(11.5));
        let rows = compared(&few, &published);
        let unknown = |title: &str| {
            let row = rows.iter().find(|row| row.title == title).unwrap();
            row.verdict() == Verdict::Unknown
        };
        assert!(unknown("growth of coast-by, L_AFmax, 50 to 110 km/h"));
        assert!(unknown("cpx less coast-by, L_AFmax, 110 km/h"));
        let bounds: Vec<&ValidationRow> = rows.iter().filter(|row| row.is_lower_bound).collect();
        assert!(bounds.len() == 1 && bounds[0].verdict() == Verdict::Unknown, "{bounds:?}");
    }

    fn measured() -> Measured {
        let fleet = |shift: f64, road| (0..3).map(move |speed| run(road, speed, shift));
        let mut runs: Vec<ValidationRun> = fleet(0.0, FLEET_ROADS[0]).chain(fleet(-1.0, FLEET_ROADS[1])).collect();
        runs.extend([
            run(NamedTexture::StoneMastic11, 1, 0.5),
            run(NamedTexture::ChipSeal, 1, 4.0),
            run(NamedTexture::Iso10844, 1, -2.0),
        ]);
        let tyre = StandingTyre {
            stiffness: Some(1.9e5),
            patches: [Some(0.097), Some(0.12), None],
            modes: [Some(68.0), None, None, None, None, Some(230.0)],
            breathing: Some(517.0),
            cavity: Some(238.0),
        };
        Measured { tyre, runs, cases: Vec::new(), load: 2000.0, lacks: Lacks { sidewalls: true, cells: true } }
    }

    fn value(rows: &[ValidationRow], title: &str) -> f64 {
        rows.iter().find(|row| row.title == title).and_then(|row| row.computed).unwrap_or(f64::NAN)
    }

    #[test]
    fn values_are_those_of_the_runs() {
        let rows = compared(&measured(), &Published::embedded());
        assert!((value(&rows, "growth of coast-by, L_AFmax, 50 to 110 km/h") - 30.0).abs() < 1e-9);
        assert!((value(&rows, "cpx less coast-by, L_AFmax, 80 km/h") - 28.0).abs() < 1e-9);
        assert!((value(&rows, "sma-8 less dac-11, coast-by, 80 km/h") + 1.0).abs() < 1e-9);
        assert!((value(&rows, "sma-11 less dac-11, coast-by, 80 km/h") - 0.5).abs() < 1e-9);
        assert!((value(&rows, "chip-seal less sma-8, cpx, octave 1 kHz") - 5.0).abs() < 1e-9);
        assert!((value(&rows, "loudest A-weighted band, 80 km/h") - 200.0).abs() < 1e-9);
        // (30 + 2 d) N for 2 kN, d in mm: 15.5 N/kN at 0.5 mm, 1 N/kN per mm.
        assert!((value(&rows, "rolling resistance on iso-10844, 80 km/h") - 15.5).abs() < 1e-9);
        assert!((value(&rows, "its growth with the mean profile depth") - 1.0).abs() < 1e-9);
        assert!((value(&rows, "stiffness at 350 kg") - 190.0).abs() < 1e-9);
        let growth: Vec<f64> =
            rows.iter().filter(|row| row.group == Group::Growth).filter_map(|row| row.computed).collect();
        assert!(growth.len() == 22 && growth.iter().all(|growth| (growth - 30.0).abs() < 1e-9), "{growth:?}");
        let is_shape = |row: &&ValidationRow| row.group == Group::Shape80 && row.road == Some(FLEET_ROADS[1]);
        let shape: Vec<&ValidationRow> = rows.iter().filter(is_shape).collect();
        // Errors of 0.5 dB at each end.
        let error = |title: &str| rows.iter().find(|row| row.title == title).and_then(|row| row.numerical_error);
        assert_eq!(error("sma-11 less dac-11, coast-by, 80 km/h"), Some(1.0));
        assert_eq!((error("coast-by, L_AFmax, 80 km/h"), shape[0].numerical_error), (Some(0.5), None));
        assert_eq!(shape[0].name(), "200 Hz, sma-8");
        assert!(energy_sum(shape.iter().filter_map(|row| row.computed)).abs() < 1e-9);
        // Third octaves of one tyre add up to the maximum of its coast-by, here of dac-11.
        let of_tyre = levels_of_one_tyre(&measured(), &Published::embedded());
        let computed: Vec<&TyreLevels> = of_tyre.iter().filter(|levels| levels.is_computed).collect();
        assert_eq!((of_tyre.len(), computed.len()), (7, 2));
        assert!((energy_sum(computed[0].levels.iter().flatten().copied()) - 70.0).abs() < 1e-9);
        assert!(matches!(shape[0].verdict(), Verdict::Above(by) if by > 10.0));
        assert!(matches!(shape[10].verdict(), Verdict::Below(_)) && !shape[10].could_explain.is_empty());
    }

    #[test]
    fn targets_of_the_fit_are_not_counted_as_validation() {
        let rows = compared(&measured(), &Published::embedded());
        assert!(rows.iter().all(|row| (row.kind == RangeOrigin::Target) == (row.group == Group::Targets)));
        assert!(rows.is_sorted_by_key(|row| row.group), "groups stand together");
        let found = summaries(&rows);
        let [tyre, targets] = [Group::Tyre, Group::Targets].map(|group| found.iter().find(|of| of.group == group));
        assert_eq!((tyre.unwrap().rows, targets.unwrap().rows), (1, 11));
    }

    #[test]
    fn a_value_that_the_runs_lack_is_an_unknown_row() {
        let published = Published::embedded();
        let mut nothing = measured();
        nothing.runs.clear();
        let (all, none) = (compared(&measured(), &published), compared(&nothing, &published));
        let titles = |rows: &[ValidationRow]| rows.iter().map(|row| row.title.clone()).collect::<Vec<_>>();
        assert_eq!(titles(&all), titles(&none));
        let known = none
            .iter()
            .filter(|row| ![Group::Tyre, Group::Targets].contains(&row.group) && row.computed.is_some())
            .count();
        assert_eq!(known, 0);
        // An octave of which a third is missing is unknown.
        assert!(all.iter().any(|row| row.title.contains("4 kHz") && row.computed.is_none()));
    }

    #[test]
    fn runs_that_are_not_compared_change_no_row() {
        let published = Published::embedded();
        let needed = measured();
        assert!(needed.runs.iter().all(|run| is_compared(run.texture, run.speed_kmh)));
        let mut more = needed.clone();
        for texture in ROADS {
            let missing = (0..3).filter(|speed| !is_compared(texture, PUBLISHED_SPEEDS[*speed]));
            more.runs.extend(missing.map(|speed| run(texture, speed, 7.0)));
        }
        assert_eq!(more.runs.len(), 15);
        assert_eq!(compared(&needed, &published), compared(&more, &published));
    }

    #[test]
    fn a_band_that_is_not_valid_takes_the_sum_with_it() {
        let mut partly = measured();
        partly.runs[1].coast_by_bands.remove(&3);
        let rows = compared(&partly, &Published::embedded());
        let shape = rows.iter().filter(|row| row.group == Group::Shape80);
        assert!(shape.clone().all(|row| row.computed.is_none() == (row.road == Some(FLEET_ROADS[0]))));
        assert_eq!(shape.count(), 22);
    }
}
