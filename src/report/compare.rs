//! Results compared with each other: settings that differ, figures, third octaves.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use crate::effects::stored::{Spectrum, Stored};
use crate::effects::{EFFECTS, Figure};
use crate::response::ThirdOctaveBand;
use crate::results::pass_by::PassBySummary;
use crate::results::plots::four_digits;
use crate::results::table::{Report, TextTable, aligned, csv, optional, words};
use crate::sound::{Compared, CoveredBands};

/// A setting whose values differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettingDifference {
    /// Key, such as `numerics.elements`.
    pub key: String,
    /// Values by result, in the form of a scene; empty where a scene has none.
    pub values: Vec<String>,
}

/// A figure of every result.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureComparison {
    /// Name of the figure.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// By result; `None` where a result lacks the figure.
    pub found: Vec<Option<FoundFigure>>,
}

/// A figure of one result.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundFigure {
    /// Value, and bands and error of a level.
    pub figure: Figure,
    /// Passages of a maximum.
    pub pass_by: Option<PassBySummary>,
}

impl FoundFigure {
    fn bands(&self) -> Option<CoveredBands> {
        self.figure.total.as_ref()?.covered()
    }

    fn error(&self) -> Option<f64> {
        self.figure.total.as_ref()?.error
    }

    fn passages(&self) -> Option<usize> {
        self.pass_by.as_ref().map(|pass_by| pass_by.passages)
    }

    fn standard_error(&self) -> Option<f64> {
        self.pass_by.as_ref()?.standard_error
    }

    /// The value in words, that of a level with its error, its bands and the passages of a maximum.
    fn text(&self) -> String {
        let value = four_digits(self.figure.value);
        let Some(level) = &self.figure.total else { return value };
        let least = if level.is_lower_bound() { "at least " } else { "" };
        let error = level.error.map_or(" (error not known)".to_owned(), |error| format!(" +- {error:.1}"));
        let passages = self.passages().map_or_else(String::new, |passages| {
            let error = self.standard_error().map_or("not known".to_owned(), |error| format!("{error:.1} dB"));
            format!(", passages: {passages}, standard error {error}")
        });
        format!("{least}{value}{error}, {}{passages}", level.range())
    }
}

impl FigureComparison {
    /// A property by result.
    fn by_result<T>(&self, of: impl Fn(&FoundFigure) -> Option<T>) -> Vec<Option<T>> {
        self.found.iter().map(|found| of(found.as_ref()?)).collect()
    }

    fn values(&self) -> Vec<Option<f64>> {
        self.by_result(|found| Some(found.figure.value))
    }

    /// Difference of a result from the first one, also in words; of levels over common bands, and `None` where these
    /// cannot be compared.
    fn difference(&self, result: usize) -> (Option<f64>, String) {
        let at = |result: usize| Some(&self.found.get(result)?.as_ref()?.figure);
        let Some((first, figure)) = at(0).zip(at(result)) else { return (None, String::new()) };
        let change = figure.value - first.value;
        let levels = first.total.as_ref().zip(figure.total.as_ref());
        match levels.map(|(first, other)| Compared::difference(other, first)) {
            None if self.unit.starts_with("dB") => (Some(change), format!("{change:+.2} dB")),
            None if first.value.abs() > 0.0 => {
                let per_cent = 100.0 * (figure.value / first.value - 1.0);
                (Some(change), format!("{per_cent:+.2} %"))
            }
            None => (Some(change), String::new()),
            Some(Ok((change, None))) => (Some(change), format!("{change:+.2} dB")),
            Some(Ok((change, Some(bands)))) => (Some(change), format!("{change:+.2} dB, {bands}")),
            Some(Err(why)) => (None, why.to_string()),
        }
    }

    /// True if the values are comparable as they are: levels of the same bands, none a lower bound.
    fn is_valid(&self) -> bool {
        let bands: Vec<CoveredBands> = self.by_result(FoundFigure::bands).into_iter().flatten().collect();
        let ends = |of: &CoveredBands| [of.lowest, of.highest].map(f64::to_bits);
        let alike = bands.windows(2).all(|pair| ends(&pair[0]) == ends(&pair[1]));
        alike && bands.iter().all(|bands| !bands.lower_bound)
    }

    /// Cells of [`FIGURE_COLUMNS`] of a result.
    fn cells(&self, result: usize) -> [String; 7] {
        let found = self.found.get(result).and_then(Option::as_ref);
        let bands = found.and_then(FoundFigure::bands);
        [
            optional(found.and_then(FoundFigure::error)),
            optional(found.and_then(FoundFigure::passages)),
            optional(found.and_then(FoundFigure::standard_error)),
            optional(bands.map(|bands| bands.lowest)),
            optional(bands.map(|bands| bands.highest)),
            optional(bands.map(|bands| u8::from(bands.lower_bound))),
            optional(self.difference(result).0),
        ]
    }
}

/// Columns of each result behind the values; the result's name follows, as in `difference_NAME`.
const FIGURE_COLUMNS: [&str; 7] =
    ["level_error_db", "passages", "standard_error_db", "lowest_hz", "highest_hz", "lower_bound", "difference"];

/// Lists by result; of figures that are no levels only values and differences.
impl Serialize for FigureComparison {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let differences: Vec<_> = (0..self.found.len()).map(|result| self.difference(result).0).collect();
        let mut record = json!({
            "name": self.name, "unit": self.unit, "values": self.values(), "differences": differences,
        });
        if self.found.iter().flatten().any(|found| found.figure.total.is_some()) {
            record["bands"] = json!(self.by_result(FoundFigure::bands));
            record["errors"] = json!(self.by_result(FoundFigure::error));
            record["passages"] = json!(self.by_result(FoundFigure::passages));
            record["standard_errors"] = json!(self.by_result(FoundFigure::standard_error));
        }
        record.serialize(serializer)
    }
}

/// Third octaves of one signal in every result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpectrumComparison {
    /// Quantity of the levels, with its reference.
    pub quantity: &'static str,
    /// Name of the signal; empty if the quantity has only one.
    pub name: String,
    /// Bands, rising.
    pub bands: Vec<BandComparison>,
}

/// A third octave in every result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BandComparison {
    /// Nominal mid-frequency \[Hz\].
    pub nominal_hz: f64,
    /// Levels by result \[dB\]; `None` where a result has no such band, or silence in it.
    pub levels: Vec<Option<f64>>,
    /// True if the level is valid in every result.
    pub valid: bool,
}

/// Results side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Names of the results' folders; the others are compared with the first.
    pub names: Vec<String>,
    /// Settings that differ between results.
    pub settings: Vec<SettingDifference>,
    /// Figures that at least one result has.
    pub figures: Vec<FigureComparison>,
    /// Third octaves.
    pub spectra: Vec<SpectrumComparison>,
    /// Notes on how files of measured levels were read.
    pub notes: Vec<String>,
}

impl Comparison {
    /// Compares results with the first of them.
    pub fn of(all: &[Stored]) -> Self {
        Self {
            names: all.iter().map(Stored::name).collect(),
            settings: settings(all),
            figures: figures(all),
            spectra: spectra(all),
            notes: Vec::new(),
        }
    }

    /// Report for a terminal: what differs, figures, and levels with their differences from the first result.
    pub(crate) fn report(&self) -> Report {
        let mut report = Report::default();
        if self.settings.is_empty() {
            report.text("the same settings\n");
        } else {
            report.table(self.settings_table());
        }
        report.titled("\n", self.figures_table());
        for spectrum in &self.spectra {
            report.titled("\n", self.spectrum_table(spectrum));
        }
        self.notes.iter().for_each(|note| report.text(format!("\nnote: {note}\n")));
        report
    }

    pub(crate) fn settings_table(&self) -> TextTable {
        let header = std::iter::once("setting".to_owned()).chain(self.names.iter().cloned());
        let rows = self.settings.iter().map(|setting| {
            std::iter::once(setting.key.clone()).chain(setting.values.iter().cloned()).collect::<Vec<_>>()
        });
        words(header, rows)
    }

    /// Table of the figures, each with its difference from the first result in per cent, for levels in dB.
    pub(crate) fn figures_table(&self) -> TextTable {
        let rows = self.figures.iter().map(|figure| {
            let unit = if figure.unit.is_empty() { String::new() } else { format!(" [{}]", figure.unit) };
            let cell = |result: usize| figure.found[result].as_ref().map_or_else(String::new, FoundFigure::text);
            let others = (1..figure.found.len()).flat_map(|result| [cell(result), figure.difference(result).1]);
            [format!("{}{unit}", figure.name), cell(0)].into_iter().chain(others).collect::<Vec<_>>()
        });
        aligned(self.header("figure".to_owned()), rows)
    }

    /// Table of the levels, with their differences from the first result.
    pub(crate) fn spectrum_table(&self, spectrum: &SpectrumComparison) -> TextTable {
        let title = if spectrum.name.is_empty() { "Hz".to_owned() } else { format!("Hz, {}", spectrum.name) };
        let rows = spectrum.bands.iter().map(|band| {
            let first = band.levels.first().copied().flatten();
            let bracketed = |text: String| if band.valid { text } else { format!("({text})") };
            let cell = |level: &Option<f64>| level.map_or(String::new(), |level| bracketed(format!("{level:.2}")));
            let difference = |level: &Option<f64>| {
                first.zip(*level).map_or(String::new(), |(first, level)| bracketed(format!("{:+.2}", level - first)))
            };
            self.row(band.nominal_hz.to_string(), &band.levels, cell, difference)
        });
        aligned(self.header(format!("{}, {title}", spectrum.quantity)), rows)
    }

    /// Figures and levels in one table: a row each, a column for each result, and behind these for each result
    /// [`FIGURE_COLUMNS`], empty for third octaves. Reading the numbers gives the same bits.
    pub(crate) fn csv(&self) -> String {
        let header = ["quantity", "signal", "nominal_hz", "valid"].map(str::to_owned).into_iter();
        let number = |value: &Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let figures = self.figures.iter().map(|figure| {
            let quantity = format!("{} [{}]", figure.name, figure.unit);
            let valid = u8::from(figure.is_valid()).to_string();
            let lead = [quantity, String::new(), String::new(), valid].into_iter();
            let values = figure.values();
            let more = (0..values.len()).flat_map(|result| figure.cells(result));
            lead.chain(values.iter().map(number)).chain(more).collect::<Vec<_>>()
        });
        let columns = self.names.iter().flat_map(|name| FIGURE_COLUMNS.map(|column| format!("{column}_{name}")));
        let empty = FIGURE_COLUMNS.len() * self.names.len();
        let bands = self.spectra.iter().flat_map(|spectrum| {
            spectrum.bands.iter().map(move |band| {
                let valid = u8::from(band.valid).to_string();
                let quantity = spectrum.quantity.to_owned();
                let lead = [quantity, spectrum.name.clone(), band.nominal_hz.to_string(), valid].into_iter();
                let levels = band.levels.iter().map(number);
                lead.chain(levels).chain(std::iter::repeat_n(String::new(), empty)).collect::<Vec<_>>()
            })
        });
        csv(header.chain(self.names.iter().cloned()).chain(columns), figures.chain(bands))
    }

    /// Titles: the first column's, the first result, then each other one with its difference.
    fn header(&self, first: String) -> Vec<String> {
        let others = self.names.iter().skip(1).flat_map(|name| [name.clone(), "difference".to_owned()]);
        [first].into_iter().chain(self.names.first().cloned()).chain(others).collect()
    }

    /// A row in the order of [`Self::header`].
    fn row(
        &self,
        name: String,
        values: &[Option<f64>],
        cell: impl Fn(&Option<f64>) -> String,
        difference: impl Fn(&Option<f64>) -> String,
    ) -> Vec<String> {
        let others = values.iter().skip(1).flat_map(|value| [cell(value), difference(value)]);
        [name].into_iter().chain(values.first().map(&cell)).chain(others).collect()
    }
}

fn settings(all: &[Stored]) -> Vec<SettingDifference> {
    let flat: Vec<BTreeMap<String, String>> = all
        .iter()
        .map(|stored| {
            let mut keys = BTreeMap::new();
            flatten(String::new(), &stored.summary.settings, &mut keys);
            keys
        })
        .collect();
    let keys: BTreeSet<&String> = flat.iter().flat_map(BTreeMap::keys).collect();
    let values = |key: &String| flat.iter().map(|of| of.get(key).cloned().unwrap_or_default()).collect::<Vec<_>>();
    let all = keys.into_iter().map(|key| SettingDifference { key: key.clone(), values: values(key) });
    all.filter(|setting| setting.values.windows(2).any(|pair| pair[0] != pair[1])).collect()
}

/// Collects every value of a JSON tree by its path, such as `a.c[0].d`.
fn flatten(path: String, value: &Value, keys: &mut BTreeMap<String, String>) {
    match value {
        Value::Object(table) => {
            for (key, value) in table {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                flatten(path, value, keys);
            }
        }
        Value::Array(items) if items.iter().any(Value::is_object) => {
            for (index, value) in items.iter().enumerate() {
                flatten(format!("{path}[{index}]"), value, keys);
            }
        }
        other => {
            keys.insert(path, other.to_string());
        }
    }
}

fn figures(all: &[Stored]) -> Vec<FigureComparison> {
    let lists: Vec<Vec<Figure>> = all.iter().map(figures_of).collect();
    let mut seen = BTreeSet::new();
    let names = lists.iter().flatten().filter(|figure| seen.insert(&figure.name));
    let figure = |Figure { name, unit, .. }: &Figure| {
        let found = |(list, stored): (&Vec<Figure>, &Stored)| {
            let figure = list.iter().find(|figure| figure.name == *name)?.clone();
            let mut receivers = stored.summary.sound.iter().flat_map(|sound| &sound.receivers);
            let passed = receivers.find(|receiver| *name == format!("level at {}, L_AFmax", receiver.name));
            Some(FoundFigure { figure, pass_by: passed.and_then(|receiver| receiver.pass_by.clone()) })
        };
        FigureComparison { name: name.clone(), unit, found: lists.iter().zip(all).map(found).collect() }
    };
    names.map(figure).collect()
}

/// Figures of a run's effects, and its wall time.
pub(super) fn figures_of(stored: &Stored) -> Vec<Figure> {
    let figures = EFFECTS.into_iter().flat_map(|effect| effect.figures(stored));
    figures.chain(Figure::of("wall time", "s", Some(stored.summary.cost.wall_seconds))).collect()
}

fn spectra(all: &[Stored]) -> Vec<SpectrumComparison> {
    let names = all.iter().flat_map(|stored| &stored.spectra).map(|of| (of.quantity, of.name.as_str()));
    let mut seen = BTreeSet::new();
    names.filter(|name| seen.insert(*name)).map(|(quantity, name)| spectrum(all, quantity, name)).collect()
}

fn spectrum(all: &[Stored], quantity: &'static str, name: &str) -> SpectrumComparison {
    let found: Vec<Option<Spectrum>> = all.iter().map(|stored| stored.spectrum(quantity, name).cloned()).collect();
    let bands: BTreeSet<i32> =
        found.iter().flatten().flat_map(|spectrum| spectrum.levels.iter().map(|level| level.band.0)).collect();
    let band = |band: i32| {
        let level =
            |spectrum: &Option<Spectrum>| spectrum.as_ref()?.levels.iter().find(|level| level.band.0 == band).copied();
        let levels: Vec<_> = found.iter().map(level).collect();
        BandComparison {
            nominal_hz: ThirdOctaveBand(band).nominal_frequency(),
            valid: levels.iter().all(|level| level.is_some_and(|level| level.valid)),
            levels: levels
                .iter()
                .map(|level| level.map(|level| level.level).filter(|level| level.is_finite()))
                .collect(),
        }
    };
    SpectrumComparison { quantity, name: name.to_owned(), bands: bands.into_iter().map(band).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::BandLevel;
    use crate::sound::TotalLevel;

    fn comparison_of(name: &str, unit: &'static str, found: [Option<Figure>; 2]) -> FigureComparison {
        let found = found.map(|figure| figure.map(|figure| FoundFigure { figure, pass_by: None }));
        FigureComparison { name: name.to_owned(), unit, found: found.into() }
    }

    fn figure(name: &str, unit: &'static str, values: [Option<f64>; 2]) -> FigureComparison {
        comparison_of(name, unit, values.map(|value| Figure::of(name, unit, value)))
    }

    fn level(name: &str, levels: [TotalLevel; 2]) -> FigureComparison {
        comparison_of(name, "dB(A)", levels.map(|level| Figure::level(name, Some(level))))
    }

    /// Maxima of which the second is of other bands and of two passages, 1 dB apart.
    fn maxima(name: &str) -> FigureComparison {
        let mut found = level(name, [level_of(3, 70.0).at_most(72.0), level_of(-11, 20.0).at_most(21.0)]);
        let second = found.found[1].as_mut().unwrap();
        second.pass_by = Some(PassBySummary::new(String::new(), &[20.5, 21.5], 1, 0.9));
        found
    }

    /// Level whose bands fall by 5 dB each from 800 Hz on, valid up to number `valid_to`.
    fn level_of(valid_to: i32, level: f64) -> TotalLevel {
        let sum = |loudest: f64| {
            let band = |n: i32| {
                let level = loudest - 5.0 * f64::from((n + 1).abs());
                BandLevel { band: ThirdOctaveBand(n), mean_square: 1.0, level, valid: n <= valid_to }
            };
            TotalLevel::of((-16..=4).map(band).collect()).unwrap()
        };
        // Exact to the last digit.
        TotalLevel { level, ..sum(level - sum(0.0).level) }
    }

    fn comparison() -> Comparison {
        let band =
            |nominal_hz, levels: [Option<f64>; 2], valid| BandComparison { nominal_hz, levels: levels.into(), valid };
        Comparison {
            names: vec!["a".into(), "b".into()],
            settings: vec![SettingDifference {
                key: "rolling.speed_kmh".into(),
                values: vec!["80.0".into(), "90.0".into()],
            }],
            figures: vec![
                figure("mean force", "N", [Some(3400.0), Some(3417.0)]),
                level("level at x", [TotalLevel { error: Some(0.2), ..level_of(3, 70.0) }, level_of(3, 71.5)]),
                level("level at y", [level_of(3, 70.0), level_of(-11, 20.0)]),
                maxima("level at z"),
                figure("contact area", "cm2", [None, Some(81.0)]),
            ],
            spectra: vec![SpectrumComparison {
                quantity: "Contact force level [dB re 1 N]",
                name: String::new(),
                bands: vec![band(100.0, [Some(10.0), Some(9.0)], true), band(125.0, [Some(5.0), None], false)],
            }],
            notes: Vec::new(),
        }
    }

    #[test]
    fn differences_are_per_cent_and_decibels() {
        let text = comparison().report().to_string();
        let line = |begin: &str| {
            let found = text.lines().find(|line| line.trim_start().starts_with(begin)).unwrap();
            found.split_whitespace().collect::<Vec<_>>().join(" ")
        };
        assert_eq!(line("mean force"), "mean force [N] 3400 3417 +0.50 %");
        let [all, few] = ["25 Hz - 2 kHz", "25 Hz - 80 Hz"].map(|bands| format!("(error not known), {bands}"));
        let x = format!("level at x [dB(A)] 70.00 +- 0.2, 25 Hz - 2 kHz 71.50 {all} +1.50 dB");
        assert_eq!(line("level at x"), x);
        // Levels of different bands are compared over the common ones, maxima not at all: those of 25 to 80 Hz hold
        // 51.19 dB less than all do, sum of 10^(-k/2) for k from 10 to 15 over that from -15 to 4.
        let sum = format!("level at y [dB(A)] 70.00 {all} at least 20.00 {few} +1.19 dB, 25 Hz - 80 Hz");
        assert_eq!(line("level at y"), sum);
        let passages = "passages: 2, standard error 0.5 dB maxima of different bands";
        assert_eq!(line("level at z"), format!("level at z [dB(A)] 72.00 {all} at least 21.00 {few}, {passages}"));
        assert_eq!(line("contact area"), "contact area [cm2] 81.00");
        assert_eq!(line("100"), "100 10.00 9.00 -1.00");
        assert_eq!(line("125"), "125 (5.00)");
        assert!(line("rolling.speed_kmh").ends_with("80.0 90.0"));
    }

    #[test]
    fn the_csv_has_a_row_for_every_figure_and_band() {
        let text = comparison().csv();
        let rows: Vec<&str> = text.lines().collect();
        let columns = |name: &str| FIGURE_COLUMNS.map(|column| format!("{column}_{name}")).join(",");
        assert_eq!(rows[0], format!("quantity,signal,nominal_hz,valid,a,b,{},{}", columns("a"), columns("b")));
        assert_eq!(rows[1], "mean force [N],,,1,3400,3417,,,,,,,0,,,,,,,17");
        assert_eq!(rows[2], "level at x [dB(A)],,,1,70,71.5,0.2,,,25,2000,0,0,,,,25,2000,0,1.5");
        assert!(rows[3].starts_with("level at y [dB(A)],,,0,70,20,,,,25,2000,0,0,,,,25,80,1,1.187"), "{}", rows[3]);
        assert_eq!(rows[4], "level at z [dB(A)],,,0,72,21,,,,25,2000,0,0,,2,0.5,25,80,1,");
        let none = ",".repeat(2 * FIGURE_COLUMNS.len());
        assert_eq!(rows[6], format!("Contact force level [dB re 1 N],,100,1,10,9{none}"));
        assert_eq!((rows[7], rows.len()), (&*format!("Contact force level [dB re 1 N],,125,0,5,{none}"), 8));
    }

    #[test]
    fn the_json_has_lists_by_result() {
        let record = json!(comparison());
        let [force, _, _, maxima, area] = &record["figures"].as_array().unwrap()[..] else { panic!("five figures") };
        assert_eq!((&force["values"], &force["differences"]), (&json!([3400.0, 3417.0]), &json!([0.0, 17.0])));
        assert_eq!((&area["values"], &area["bands"]), (&json!([null, 81.0]), &Value::Null));
        assert_eq!((&maxima["errors"], &maxima["passages"]), (&json!([null, null]), &json!([null, 2])));
        assert_eq!((&maxima["standard_errors"], &maxima["differences"]), (&json!([null, 0.5]), &json!([0.0, null])));
        assert_eq!(maxima["bands"][1]["highest"], json!(80.0));
    }

    #[test]
    fn settings_are_distinguished_by_their_paths() {
        let mut keys = BTreeMap::new();
        flatten(String::new(), &json!({"a": {"b": [1, 2], "c": [{"d": "x"}, {"d": 1.5}]}, "e": true}), &mut keys);
        let found: Vec<String> = keys.iter().map(|(key, value)| format!("{key}={value}")).collect();
        assert_eq!(found, ["a.b=[1,2]", "a.c[0].d=\"x\"", "a.c[1].d=1.5", "e=true"]);
    }
}
