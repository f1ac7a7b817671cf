//! Findings of a sweep of settings: means over seeds with their 95 % confidence intervals, for every combination of the
//! other settings.
//!
//! With n values x_i of mean m, s^2 = sum (x_i - m)^2/(n - 1) and t the two-sided 95 % quantile of Student's
//! distribution for n - 1 degrees of freedom, the expected value lies within m +- t s/sqrt(n) in 95 % of cases. Levels
//! are averaged in dB, overall ones over the bands that are valid for all seeds; in pictures over those valid in all
//! runs.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value as Json, json};

use crate::numeric::quantile_of_student;
use crate::response::ThirdOctaveBand;
use crate::results::pass_by::PassBySummary;
use crate::results::table::{self, Report, aligned, optional};
use crate::sound::{Compared, TotalLevel};
use crate::study::sweep::run::Done;
use crate::study::sweep::variants::Label;

mod pictures;

/// Name of the level of the force over all bands.
const OVERALL: &str = "force, all bands";
const FORCE_UNIT: &str = "dB re 1 N";
const SOUND_UNIT: &str = "dB(A)";

/// A mean over seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mean {
    /// Number of values.
    pub runs: usize,
    /// Arithmetic mean.
    pub mean: f64,
    /// Half the width of its 95 % interval; `None` for a single value.
    pub interval: Option<f64>,
    /// Lowest value.
    pub lowest: f64,
    /// Highest value.
    pub highest: f64,
}

impl Mean {
    /// Mean of the finite values; `None` without any.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        let (first, count) = (*values.first()?, values.len() as f64);
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let interval =
            quantile_of_student(values.len() - 1).map(|quantile| quantile * (squares / (count - 1.0) / count).sqrt());
        let fold = |least: fn(f64, f64) -> f64| values.iter().copied().fold(first, least);
        Some(Self { runs: values.len(), mean, interval, lowest: fold(f64::min), highest: fold(f64::max) })
    }

    /// Formats as `70.12 +- 0.31`.
    fn text(&self, decimals: usize) -> String {
        let interval = self.interval.map_or_else(String::new, |interval| format!(" +- {interval:.decimals$}"));
        format!("{:.decimals$}{interval}", self.mean)
    }
}

/// A quantity that runs find.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Quantity {
    /// Order in the tables: kind (see [`FORCE`]), and the number of a band.
    rank: (u8, i32),
    name: String,
    unit: &'static str,
}

/// Bands, bound, error and passages behind a mean overall level.
#[derive(Clone, Debug, PartialEq)]
struct MeanBands {
    /// Nominal mid-frequencies of the lowest and the highest band \[Hz\].
    ends: [f64; 2],
    /// The range in words, if some levels have other bands too, or if the levels are lower bounds.
    range: Option<String>,
    /// True if bands that matter may be missing.
    lower_bound: bool,
    /// Largest numerical error of the levels \[dB\], if that of each is known.
    error: Option<f64>,
    /// Fewest passages of a maximum.
    passages: Option<usize>,
    /// Largest standard error of a maximum \[dB\], if that of each is known.
    standard_error: Option<f64>,
}

impl MeanBands {
    /// A mean in words with what must be known of a level; the force's errors are not among its results.
    fn text(&self, mean: &str, of_sound: bool) -> String {
        let number = |error: Option<f64>| error.map_or("not known".to_owned(), |error| format!("{error:.1}"));
        let mut text = format!("{}{mean}", if self.lower_bound { "at least " } else { "" });
        if of_sound {
            text.push_str(&format!(", error {}", number(self.error)));
        }
        if let Some(passages) = self.passages {
            text.push_str(&format!(", passages {passages}, standard error {}", number(self.standard_error)));
        }
        self.range.iter().for_each(|range| text.push_str(&format!(", {range}")));
        text
    }

    /// Cells of [`BANDS`].
    fn cells(&self) -> [String; 6] {
        let [lowest, highest] = self.ends.map(|end| end.to_string());
        let bound = u8::from(self.lower_bound).to_string();
        [lowest, highest, bound, optional(self.error), optional(self.passages), optional(self.standard_error)]
    }
}

/// Columns of an overall level.
const BANDS: [&str; 6] = ["lowest_hz", "highest_hz", "lower_bound", "level_error_db", "passages", "standard_error_db"];

/// Mean of a quantity, with its bands if it is an overall level.
type BandedMean = (Mean, Option<MeanBands>);

/// Value of a quantity in a run: a number, or an overall level and the passages of a maximum.
#[derive(Clone, Debug)]
enum Value {
    Number(f64),
    Total(TotalLevel, Option<PassBySummary>),
}

/// Largest of some errors; `None` if one of them is not known.
pub(crate) fn largest(errors: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    errors.reduce(|one, other| Some(one?.max(other?))).flatten()
}

/// Values and, for overall levels, their common bands.
///
/// # Errors
/// Why the levels cannot be compared.
fn over_common(values: &[&Value]) -> Result<(Vec<f64>, Option<MeanBands>), String> {
    let number = |value: &&Value| match value {
        Value::Number(number) => *number,
        Value::Total(total, _) => total.level,
    };
    let total = |value: &&Value| match value {
        Value::Number(_) => None,
        Value::Total(total, pass_by) => Some((total.clone(), pass_by.clone())),
    };
    let (totals, passed): (Vec<TotalLevel>, Vec<Option<PassBySummary>>) = values.iter().filter_map(total).unzip();
    if totals.is_empty() {
        return Ok((values.iter().map(number).collect(), None));
    }
    let compared = Compared::of(&totals.iter().collect::<Vec<_>>()).map_err(|why| why.to_string())?;
    let [lowest, highest] = compared.bands;
    let is_bound = |total: &TotalLevel| {
        let common = total.bands.iter().filter(|of| (lowest..=highest).contains(&of.band)).copied();
        TotalLevel::of(common.collect()).is_none_or(|common| common.is_lower_bound())
    };
    let lower_bound = !compared.hold_loudest || totals.iter().any(is_bound);
    let passed = || passed.iter().flatten();
    let bands = MeanBands {
        ends: compared.bands.map(ThirdOctaveBand::nominal_frequency),
        range: (lower_bound || !compared.all).then(|| compared.range()),
        lower_bound,
        error: largest(totals.iter().map(|total| total.error)),
        passages: passed().map(|pass_by| pass_by.passages).min(),
        standard_error: largest(passed().map(|pass_by| pass_by.standard_error)),
    };
    Ok((compared.levels, Some(bands)))
}

/// Mean of values; `None` without any.
///
/// # Errors
/// Why the levels cannot be compared.
fn mean_of(values: &[Value]) -> Result<Option<BandedMean>, String> {
    let (values, bands) = over_common(&values.iter().collect::<Vec<_>>())?;
    Ok(Mean::of(values).map(|mean| (mean, bands)))
}

/// Means of each combination over the bands that are valid in all runs.
fn means_to_draw(found: &[Values]) -> Vec<BTreeMap<Quantity, BandedMean>> {
    let mut drawn = vec![BTreeMap::new(); found.len()];
    let quantities: BTreeSet<&Quantity> = found.iter().flat_map(|(_, _, values)| values.keys()).collect();
    for quantity in quantities {
        let all: Vec<&Value> = found.iter().filter_map(|(_, _, values)| values.get(quantity)).flatten().collect();
        let Ok((levels, bands)) = over_common(&all) else { continue };
        let mut levels = levels.into_iter();
        for (means, (_, _, values)) in drawn.iter_mut().zip(found) {
            let count = values.get(quantity).map_or(0, Vec::len);
            if let Some(mean) = Mean::of(levels.by_ref().take(count)) {
                means.insert(quantity.clone(), (mean, bands.clone()));
            }
        }
    }
    drawn
}

/// One combination of the varied settings, except seeds.
#[derive(Clone, Debug)]
pub(crate) struct RepeatedRow {
    /// Values, in the order of the table's factors.
    pub values: Vec<String>,
    /// Number of runs that were asked for.
    pub planned: usize,
    means: BTreeMap<Quantity, BandedMean>,
    /// Why levels have no mean.
    apart: BTreeMap<Quantity, String>,
    /// Means over the bands that are valid in all runs: those that pictures compare.
    drawn: BTreeMap<Quantity, BandedMean>,
}

/// A combination, its number of planned runs, and the values of those that are done.
type Values = (Vec<String>, usize, BTreeMap<Quantity, Vec<Value>>);

/// Means of all combinations of a sweep.
#[derive(Clone, Debug, Default)]
pub(crate) struct RepeatedTable {
    /// Names of the factors, except seeds.
    pub factors: Vec<String>,
    /// The combinations, in the order of the sweep.
    pub rows: Vec<RepeatedRow>,
    quantities: Vec<Quantity>,
    /// Sentences on levels that could not be read.
    unread: Vec<String>,
}

impl RepeatedTable {
    /// Table of a sweep's variants and results; `None` if nothing but road, load and speed is varied.
    pub(crate) fn new(runs: &[(Label, Option<Done>)]) -> Option<Self> {
        runs.first().filter(|(label, _)| label.is_of_a_design()).map(|_| Self::of(runs))
    }

    /// Table of a sweep's variants and results.
    pub(crate) fn of(runs: &[(Label, Option<Done>)]) -> Self {
        let varied = |label: &Label| label.choices.iter().filter(|choice| !choice.repeats).cloned().collect::<Vec<_>>();
        let first = runs.first().map_or_else(Vec::new, |(label, _)| varied(label));
        let factors = first.into_iter().map(|choice| choice.factor).collect();
        let mut order: BTreeMap<Vec<String>, usize> = BTreeMap::new();
        let mut found: Vec<Values> = Vec::new();
        for (label, done) in runs {
            let values: Vec<String> = varied(label).into_iter().map(|choice| choice.value).collect();
            let row = *order.entry(values.clone()).or_insert_with(|| {
                found.push((values, 0, BTreeMap::new()));
                found.len() - 1
            });
            found[row].1 += 1;
            for (quantity, value) in done.as_ref().map(quantities).unwrap_or_default() {
                found[row].2.entry(quantity).or_default().push(value);
            }
        }
        let drawn = means_to_draw(&found);
        let row = |((values, planned, found), drawn): (Values, BTreeMap<Quantity, BandedMean>)| {
            let mut row = RepeatedRow { values, planned, means: BTreeMap::new(), apart: BTreeMap::new(), drawn };
            for (quantity, values) in found {
                match mean_of(&values) {
                    Ok(mean) => row.means.extend(mean.map(|mean| (quantity, mean))),
                    Err(why) => row.apart.extend([(quantity, why)]),
                }
            }
            row
        };
        let rows: Vec<RepeatedRow> = found.into_iter().zip(drawn).map(row).collect();
        let quantities: BTreeSet<Quantity> =
            rows.iter().flat_map(|row| row.means.keys().chain(row.apart.keys()).cloned()).collect();
        let reported = |(label, done): &(Label, Option<Done>)| {
            let unread = done.iter().flat_map(|done| &done.unread);
            unread.map(|reported| format!("{}: {reported}\n", label.name)).collect::<Vec<_>>()
        };
        Self { factors, rows, quantities: Vec::from_iter(quantities), unread: runs.iter().flat_map(reported).collect() }
    }

    /// Report for people: a line per combination, without third octaves, which are in the files.
    pub(crate) fn report(&self) -> Report {
        let shown: Vec<&Quantity> = self.quantities.iter().filter(|quantity| quantity.rank.0 < BAND).collect();
        let titles = shown.iter().map(|quantity| format!("{}, {}", quantity.name, quantity.unit));
        let header = self.factors.iter().cloned().chain(["runs".to_owned()]).chain(titles);
        let row = |row: &RepeatedRow| -> Vec<String> {
            let cell = |quantity: &&Quantity| {
                let decimals = if quantity.rank.0 == RESISTANCE { 5 } else { 2 };
                match (row.means.get(*quantity), row.apart.get(*quantity)) {
                    (Some((mean, Some(bands))), _) => bands.text(&mean.text(decimals), quantity.rank.0 == SOUND),
                    (Some((mean, None)), _) => mean.text(decimals),
                    (None, Some(why)) => why.clone(),
                    (None, None) => "-".to_owned(),
                }
            };
            let runs = row.means.values().map(|(mean, _)| mean.runs).max().unwrap_or(0);
            let runs = if runs == row.planned { runs.to_string() } else { format!("{runs} of {}", row.planned) };
            row.values.iter().cloned().chain([runs]).chain(shown.iter().map(cell)).collect()
        };
        let mut report = Report::from(aligned(header, self.rows.iter().map(row)));
        if self.rows.iter().any(|row| row.means.values().any(|(mean, _)| mean.interval.is_some())) {
            report.text("means over seeds +- half of their 95 % interval\n");
        }
        if shown.iter().any(|quantity| quantity.rank.0 == SOUND) {
            let largest = "error: largest numerical error of a run in dB; of a maximum fewest passages";
            report.text(format!("{largest} and largest standard error of a run\n"));
        }
        self.unread.iter().for_each(|reported| report.text(reported));
        report
    }

    /// Every mean, with its row and quantity.
    fn lines(&self) -> impl Iterator<Item = (&RepeatedRow, &Quantity, &BandedMean)> {
        self.rows.iter().flat_map(|row| row.means.iter().map(move |(quantity, mean)| (row, quantity, mean)))
    }

    /// Every mean: the values of the factors, the quantity's name and unit, and the mean itself.
    pub(crate) fn values(&self) -> impl Iterator<Item = (&[String], &str, &'static str, f64)> {
        self.lines().map(|(row, quantity, (mean, _))| (&row.values[..], &quantity.name[..], quantity.unit, mean.mean))
    }

    /// Every mean as CSV: the factors, quantity, unit, runs, mean, half of its 95 % interval, lowest and highest value,
    /// and for an overall level its lowest and highest band, 1 where it is a lower bound, its largest numerical error,
    /// fewest passages and largest standard error of a maximum.
    pub(crate) fn csv(&self) -> String {
        let columns = ["quantity", "unit", "runs", "mean", "interval_95", "lowest", "highest"];
        let columns = columns.into_iter().chain(BANDS);
        let header = self.factors.iter().cloned().chain(columns.map(str::to_owned));
        let line = |(row, quantity, (mean, bands)): (&RepeatedRow, &Quantity, &BandedMean)| -> Vec<String> {
            let interval = mean.interval.map_or_else(String::new, |interval| interval.to_string());
            let [middle, lowest, highest] = [mean.mean, mean.lowest, mean.highest].map(|number| number.to_string());
            let names = [quantity.name.clone(), quantity.unit.to_owned(), mean.runs.to_string()];
            let numbers = [middle, interval, lowest, highest];
            let bands = bands.as_ref().map_or_else(Default::default, MeanBands::cells);
            row.values.iter().cloned().chain(names).chain(numbers).chain(bands).collect()
        };
        table::csv(header, self.lines().map(line))
    }

    /// Every mean as JSON: an array of objects.
    pub(crate) fn to_json(&self) -> Json {
        let line = |(row, quantity, (mean, bands)): (&RepeatedRow, &Quantity, &BandedMean)| {
            let factors: serde_json::Map<String, Json> = self
                .factors
                .iter()
                .cloned()
                .zip(row.values.iter().map(|value| match value.parse::<f64>() {
                    Ok(number) => json!(number),
                    Err(_) => json!(value),
                }))
                .collect();
            json!({
                "factors": factors, "quantity": quantity.name, "unit": quantity.unit, "runs": mean.runs,
                "mean": mean.mean, "interval_95": mean.interval, "lowest": mean.lowest, "highest": mean.highest,
                "lowest_hz": bands.as_ref().map(|bands| bands.ends[0]),
                "highest_hz": bands.as_ref().map(|bands| bands.ends[1]),
                "lower_bound": bands.as_ref().map(|bands| bands.lower_bound),
                "level_error_db": bands.as_ref().and_then(|bands| bands.error),
                "passages": bands.as_ref().and_then(|bands| bands.passages),
                "standard_error_db": bands.as_ref().and_then(|bands| bands.standard_error),
            })
        };
        self.lines().map(line).collect()
    }
}

/// Kinds of quantities, in the order of the tables.
const FORCE: u8 = 0;
const SOUND: u8 = 1;
const RESISTANCE: u8 = 2;
const BAND: u8 = 3;
const SOUND_BAND: u8 = 4;

/// Quantities of a run; only the bands that are valid in it.
fn quantities(done: &Done) -> Vec<(Quantity, Value)> {
    let mut found = Vec::new();
    let mut add = |rank: (u8, i32), name: &str, unit, value| {
        found.push((Quantity { rank, name: name.to_owned(), unit }, value));
    };
    let known = || done.levels.iter().filter(|level| level.valid);
    if let Some(force) = TotalLevel::of(done.levels.clone()).filter(|force| force.level.is_finite()) {
        add((FORCE, 0), OVERALL, FORCE_UNIT, Value::Total(force, None));
    }
    // In the order of their names: a run may be too short for some.
    for (name, level) in &done.sound {
        add((SOUND, 0), &done.label_of(name), SOUND_UNIT, Value::Total(level.clone(), done.pass_by(name).cloned()));
    }
    if let Some(resistance) = done.rolling_resistance {
        add((RESISTANCE, 0), "rolling resistance", "coefficient", Value::Number(resistance.coefficient));
    }
    for level in known() {
        let name = format!("force, {} Hz", level.band.nominal_frequency());
        add((BAND, level.band.0), &name, FORCE_UNIT, Value::Number(level.level));
    }
    for (name, level) in &done.sound {
        for of_band in level.bands.iter().filter(|band| band.valid) {
            let name = format!("{}, {} Hz", done.label_of(name), of_band.band.nominal_frequency());
            add((SOUND_BAND, of_band.band.0), &name, SOUND_UNIT, Value::Number(of_band.level));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::BandLevel;
    use crate::study::sweep::variants::{Choice, SPEED};

    #[test]
    fn a_mean_has_the_interval_of_the_tables() {
        // By hand: mean 2, s = 1, t = 4.303 for two degrees of freedom.
        let mean = Mean::of([1.0, 2.0, 3.0, f64::NEG_INFINITY]).unwrap();
        assert_eq!(
            (mean.runs, mean.lowest.to_bits(), mean.highest.to_bits()),
            (3, 1.0_f64.to_bits(), 3.0_f64.to_bits())
        );
        assert!((mean.mean - 2.0).abs() < 1e-15 && (mean.interval.unwrap() - 4.303 / 3.0_f64.sqrt()).abs() < 1e-3);
        assert_eq!(Mean::of([5.0]).unwrap().interval, None);
        assert_eq!(Mean::of([]), None);
        assert_eq!(mean.text(1), "2.0 +- 2.5");
    }

    /// Level whose bands are loudest at 800 Hz and valid up to one of them; bands up to 2 kHz have a level.
    fn sum(valid_to: i32, level: f64) -> TotalLevel {
        let made = |valid_to: i32, loudest: f64| {
            let band = |n: i32| {
                let level = loudest - 4.0 * f64::from((n + 1).abs());
                BandLevel { band: ThirdOctaveBand(n), mean_square: 1.0, level, valid: n <= valid_to }
            };
            TotalLevel::of((-16..=4).map(band).collect()).unwrap()
        };
        made(valid_to, level - made(3, 0.0).level)
    }

    #[test]
    fn means_are_over_the_bands_valid_for_all_seeds() {
        let mut runs = at_receivers(1);
        let (_, done) = &mut runs[0];
        done.as_mut().unwrap().sound[1].1 = sum(-11, 56.0);
        done.as_mut().unwrap().sound[0].1 = sum(-11, 0.0).at_most(11.5);
        let near = &mut runs[1].1.as_mut().unwrap().sound[0].1;
        *near = near.clone().at_most(near.level);
        let table = RepeatedTable::of(&runs);
        let text = table.report().to_string();
        // Seeds of 56 and 57 dB(A) whose bands of 25 to 80 Hz have as much less each.
        assert!(text.contains("at least ") && text.contains("25 Hz - 80 Hz") && !text.contains("11.5"), "{text}");
        assert!(text.contains("maxima of different bands") && text.contains("error not known"), "{text}");
        let csv = table.csv();
        let row = csv.lines().find(|row| row.contains("50,far")).unwrap();
        assert!(row.ends_with(",25,80,1,,,"), "{row}");
        let other = csv.lines().find(|row| row.contains("80,far")).unwrap();
        assert!(other.ends_with(",25,2000,0,,,"), "{other}");
        // Maxima of different bands have no mean: the other speed alone does, and no picture holds them together.
        assert!(!csv.contains("50,near") && csv.contains("80,near"), "{csv}");
        let curves = table.curves("t").concat();
        assert!(curves.contains("25 Hz - 80 Hz") && !curves.contains("near"), "{curves}");
    }

    #[test]
    fn any_number_of_receivers_has_third_octaves() {
        let mut runs = at_receivers(1);
        runs.truncate(1);
        let level = sum(3, 70.0);
        let bands = level.bands.iter().filter(|band| band.valid).count();
        runs[0].1.as_mut().unwrap().sound = (0..300).map(|number| (format!("m{number}"), level.clone())).collect();
        let table = RepeatedTable::of(&runs);
        assert_eq!(table.values().filter(|(_, quantity, ..)| quantity.starts_with('m')).count(), 300 * (1 + bands));
    }

    #[test]
    fn means_of_lower_bounds_are_lower_bounds() {
        let with = |errors: [Option<f64>; 2]| {
            let mut runs = at_receivers(1);
            runs.truncate(2);
            for ((_, done), (error, maxima)) in
                runs.iter_mut().zip(errors.into_iter().zip([&[70.0, 71.0][..], &[70.0]]))
            {
                let done = done.as_mut().unwrap();
                // It ends where it is loudest, at 800 Hz.
                let level = TotalLevel { error, ..sum(-1, 70.0).at_most(70.0) };
                done.sound = vec![("near".to_owned(), level)];
                done.pass_bys = vec![("near".to_owned(), PassBySummary::new(String::new(), maxima, 1, 0.9))];
            }
            RepeatedTable::of(&runs)
        };
        let known = with([Some(0.3), Some(8.5)]);
        let reported = known.report().to_string();
        let cell = "at least 70.00 +- 0.00, error 8.5, passages 1, standard error not known, 25 Hz - 800 Hz";
        assert!(reported.contains(cell), "{reported}");
        assert!(known.csv().lines().any(|row| row.contains("near") && row.ends_with(",25,800,1,8.5,1,")));
        let record = &known.to_json()[0];
        assert_eq!((&record["level_error_db"], &record["lower_bound"]), (&json!(8.5), &json!(true)));
        assert_eq!((&record["passages"], &record["standard_error_db"]), (&json!(1), &Json::Null));
        let unknown = with([Some(0.3), None]);
        assert!(unknown.report().to_string().contains("error not known, passages"));
        assert!(unknown.csv().lines().any(|row| row.contains("near") && row.ends_with(",25,800,1,,1,")));
    }

    /// Every combination of `loads` loads and the speeds with two seeds, at two receivers.
    fn at_receivers(loads: u32) -> Vec<(Label, Option<Done>)> {
        let mut runs = Vec::new();
        for (load, speed, seed) in (0..loads)
            .flat_map(|load| [50.0, 80.0].into_iter().flat_map(move |v| [1.0, 2.0].map(|seed| (load, v, seed))))
        {
            let choice = |factor: &str, value: String, repeats| Choice { factor: factor.to_owned(), value, repeats };
            let load = 3000.0 + 100.0 * f64::from(load);
            let choices = vec![
                choice("load N", load.to_string(), false),
                choice("road.seed", seed.to_string(), true),
                choice(SPEED, speed.to_string(), false),
            ];
            let level = 0.01 * load + 0.5 * speed + seed;
            let sound = vec![("near".to_owned(), sum(3, 20.0 + level)), ("far".to_owned(), sum(3, level))];
            let label = Label { name: String::new(), group: String::new(), speed, choices };
            runs.push((label, Some(Done { sound, ..Done::default() })));
        }
        runs
    }

    #[test]
    fn levels_over_speed_are_lines_or_points_if_too_many() {
        let curves = |runs: &[_]| RepeatedTable::of(runs).curves("t");
        let [both] = &curves(&at_receivers(2))[..] else { panic!("one picture") };
        // 30 + 25 + (1 + 2)/2; half the interval is 12.706 sqrt(0.5)/sqrt(2).
        for reported in ["3000 N, near", "3100 N, far", "speed km/h: 50\n3000 N, far: 56.50 \u{b1} 6.353"] {
            assert!(both.contains(reported), "{reported}: {both}");
        }
        let apart = curves(&at_receivers(7));
        assert!(apart.len() == 2 && apart[0].contains("3600 N, far") && !apart[0].contains("near"), "{apart:?}");
        assert!(curves(&at_receivers(8)).is_empty() && curves(&[]).is_empty());
        assert!(RepeatedTable::of(&at_receivers(8)).plots("t").len() == 2);
    }
}
