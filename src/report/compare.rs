//! Results held against each other: settings that differ, figures, third octaves.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use crate::effects::stored::{Spectrum, Stored};
use crate::effects::{EFFECTS, Figure};
use crate::response::ThirdOctaveBand;
use crate::results::plots::four_digits;
use crate::results::table::{Report, Table, aligned, csv, words};

/// A setting that is not the same everywhere.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct SettingDifference {
    /// Its key: `numerics.elements`.
    pub key: String,
    /// Its values by result, as a scene would have them; empty where a scene has none.
    pub values: Vec<String>,
}

/// A figure of every result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FigureComparison {
    /// Name of the item.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Its values by result.
    pub values: Vec<Option<f64>>,
}

/// Third octaves of one signal in every result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct SpectrumComparison {
    /// Quantity of the levels, reference included.
    pub quantity: &'static str,
    /// Which signal; empty where there is one of the quantity.
    pub name: String,
    /// The bands, rising.
    pub bands: Vec<BandComparison>,
}

/// A third octave in every result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct BandComparison {
    /// Nominal mid-frequency \[Hz\].
    pub nominal_hz: f64,
    /// Levels by result \[dB\]; none where a result has no such band or nothing in it.
    pub levels: Vec<Option<f64>>,
    /// True if every result vouches for its level.
    pub valid: bool,
}

/// Results side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Comparison {
    /// The results, by their folders' names; the first is what the others are held against.
    pub names: Vec<String>,
    /// Settings that differ.
    pub settings: Vec<SettingDifference>,
    /// Figures that at least one result has.
    pub figures: Vec<FigureComparison>,
    /// Third octaves.
    pub spectra: Vec<SpectrumComparison>,
    /// Notes on what of measured results was taken as what.
    pub notes: Vec<String>,
}

impl Comparison {
    /// Compares some results.
    pub(crate) fn of(all: &[Stored]) -> Self {
        Self {
            names: all.iter().map(Stored::name).collect(),
            settings: settings(all),
            figures: figures(all),
            spectra: spectra(all),
            notes: Vec::new(),
        }
    }

    /// Makes a report for a terminal: what differs, figures, and levels with their differences from the first result.
    pub(crate) fn report(&self) -> Report {
        let mut report = Report::default();
        if self.settings.is_empty() {
            report.text("the same settings\n");
        } else {
            report.table(self.settings_table());
        }
        report.text("\n");
        report.table(self.figures_table());
        for spectrum in &self.spectra {
            report.text("\n");
            report.table(self.spectrum_table(spectrum));
        }
        self.notes.iter().for_each(|note| report.text(format!("\nnote: {note}\n")));
        report
    }

    /// Returns the settings that differ.
    pub(crate) fn settings_table(&self) -> Table {
        let header = std::iter::once("setting".to_owned()).chain(self.names.iter().cloned());
        let rows = self.settings.iter().map(|setting| {
            std::iter::once(setting.key.clone()).chain(setting.values.iter().cloned()).collect::<Vec<_>>()
        });
        words(header, rows)
    }

    /// Returns the figures, each with its difference from the first result in per cent, or in the unit for levels.
    pub(crate) fn figures_table(&self) -> Table {
        let rows = self.figures.iter().map(|figure| {
            let first = figure.values.first().copied().flatten();
            let cell = |value: &Option<f64>| value.map_or(String::new(), four_digits);
            let difference = |value: &Option<f64>| match (first, value) {
                (Some(first), Some(value)) if figure.unit.starts_with("dB") => format!("{:+.2} dB", value - first),
                (Some(first), Some(value)) if first.abs() > 0.0 => format!("{:+.2} %", 100.0 * (value / first - 1.0)),
                _ => String::new(),
            };
            let unit = if figure.unit.is_empty() { String::new() } else { format!(" [{}]", figure.unit) };
            self.row(format!("{}{unit}", figure.name), &figure.values, cell, difference)
        });
        aligned(self.header("figure".to_owned()), rows)
    }

    /// Returns the levels, with their differences from the first result.
    pub(crate) fn spectrum_table(&self, spectrum: &SpectrumComparison) -> Table {
        let title = if spectrum.name.is_empty() { "Hz".to_owned() } else { format!("Hz, {}", spectrum.name) };
        let rows = spectrum.bands.iter().map(|band| {
            let first = band.levels.first().copied().flatten();
            let doubt = |text: String| if band.valid { text } else { format!("({text})") };
            let cell = |level: &Option<f64>| level.map_or(String::new(), |level| doubt(format!("{level:.2}")));
            let difference = |level: &Option<f64>| {
                first.zip(*level).map_or(String::new(), |(first, level)| doubt(format!("{:+.2}", level - first)))
            };
            self.row(band.nominal_hz.to_string(), &band.levels, cell, difference)
        });
        aligned(self.header(format!("{}, {title}", spectrum.quantity)), rows)
    }

    /// Returns the figures and levels in one table: a row each, a column for each result. Numbers are written so that
    /// reading gives the same bits.
    pub(crate) fn csv(&self) -> String {
        let header = ["quantity", "signal", "nominal_hz", "valid"].map(str::to_owned).into_iter();
        let number = |value: &Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let figures = self.figures.iter().map(|figure| {
            let quantity = format!("{} [{}]", figure.name, figure.unit);
            let lead = [quantity, String::new(), String::new(), "1".to_owned()].into_iter();
            lead.chain(figure.values.iter().map(number)).collect::<Vec<_>>()
        });
        let bands = self.spectra.iter().flat_map(|spectrum| {
            spectrum.bands.iter().map(move |band| {
                let valid = u8::from(band.valid).to_string();
                let quantity = spectrum.quantity.to_owned();
                let lead = [quantity, spectrum.name.clone(), band.nominal_hz.to_string(), valid].into_iter();
                lead.chain(band.levels.iter().map(number)).collect::<Vec<_>>()
            })
        });
        csv(header.chain(self.names.iter().cloned()), figures.chain(bands))
    }

    /// Returns the first column's title, the first result, then each other one with its difference.
    fn header(&self, first: String) -> Vec<String> {
        let others = self.names.iter().skip(1).flat_map(|name| [name.clone(), "difference".to_owned()]);
        [first].into_iter().chain(self.names.first().cloned()).chain(others).collect()
    }

    /// Returns a row in the order of [`Self::header`].
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
    let mut keys: Vec<&String> = flat.iter().flat_map(BTreeMap::keys).collect();
    keys.sort_unstable();
    keys.dedup();
    let values = |key: &String| flat.iter().map(|of| of.get(key).cloned().unwrap_or_default()).collect::<Vec<_>>();
    let all = keys.into_iter().map(|key| SettingDifference { key: key.clone(), values: values(key) });
    all.filter(|setting| setting.values.windows(2).any(|pair| pair[0] != pair[1])).collect()
}

/// Collects every value of a JSON tree by its path.
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
    let mut names: Vec<(&str, &'static str)> = Vec::new();
    for Figure { name, unit, .. } in lists.iter().flatten() {
        if !names.iter().any(|(known, _)| known == name) {
            names.push((name, unit));
        }
    }
    let value =
        |list: &Vec<Figure>, wanted: &str| list.iter().find(|figure| figure.name == wanted).map(|figure| figure.value);
    let figure = |(name, unit): (&str, &'static str)| FigureComparison {
        name: name.to_owned(),
        unit,
        values: lists.iter().map(|list| value(list, name)).collect(),
    };
    names.into_iter().map(figure).collect()
}

/// Lists the figures of a run's effects, and its time.
pub(super) fn figures_of(stored: &Stored) -> Vec<Figure> {
    let figures = EFFECTS.into_iter().flat_map(|effect| effect.figures(stored));
    figures.chain(Figure::of("wall time", "s", Some(stored.summary.cost.wall_seconds))).collect()
}

fn spectra(all: &[Stored]) -> Vec<SpectrumComparison> {
    let mut names: Vec<(&'static str, &str)> = Vec::new();
    for spectrum in all.iter().flat_map(|stored| &stored.spectra) {
        if !names.contains(&(spectrum.quantity, spectrum.name.as_str())) {
            names.push((spectrum.quantity, &spectrum.name));
        }
    }
    names.into_iter().map(|(quantity, name)| spectrum(all, quantity, name)).collect()
}

fn spectrum(all: &[Stored], quantity: &'static str, name: &str) -> SpectrumComparison {
    let found: Vec<Option<Spectrum>> = all.iter().map(|stored| stored.spectrum(quantity, name).cloned()).collect();
    let mut bands: Vec<i32> =
        found.iter().flatten().flat_map(|spectrum| spectrum.levels.iter().map(|level| level.band.0)).collect();
    bands.sort_unstable();
    bands.dedup();
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
    use serde_json::json;

    use super::*;

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
                FigureComparison { name: "mean force".into(), unit: "N", values: vec![Some(3400.0), Some(3417.0)] },
                FigureComparison { name: "level at x".into(), unit: "dB(A)", values: vec![Some(70.0), Some(71.5)] },
                FigureComparison { name: "contact area".into(), unit: "cm2", values: vec![None, Some(81.0)] },
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
    fn differences_are_per_cent_and_decibels_and_nothing_where_there_is_nothing() {
        let text = comparison().report().to_string();
        let line = |begin: &str| {
            let found = text.lines().find(|line| line.trim_start().starts_with(begin)).unwrap();
            found.split_whitespace().collect::<Vec<_>>().join(" ")
        };
        assert_eq!(line("mean force"), "mean force [N] 3400 3417 +0.50 %");
        assert_eq!(line("level at x"), "level at x [dB(A)] 70.00 71.50 +1.50 dB");
        assert_eq!(line("contact area"), "contact area [cm2] 81.00");
        assert_eq!(line("100"), "100 10.00 9.00 -1.00");
        assert_eq!(line("125"), "125 (5.00)");
        assert!(line("rolling.speed_kmh").ends_with("80.0 90.0"));
    }

    #[test]
    fn the_csv_has_a_row_for_every_figure_and_band_and_a_column_for_every_result() {
        let text = comparison().csv();
        let rows: Vec<&str> = text.lines().collect();
        assert_eq!(rows[0], "quantity,signal,nominal_hz,valid,a,b");
        assert_eq!(rows[1], "mean force [N],,,1,3400,3417");
        assert_eq!(rows[4], "Contact force level [dB re 1 N],,100,1,10,9");
        assert_eq!((rows[5], rows.len()), ("Contact force level [dB re 1 N],,125,0,5,", 6));
    }

    #[test]
    fn settings_are_told_apart_by_their_paths() {
        let mut keys = BTreeMap::new();
        flatten(String::new(), &json!({"a": {"b": [1, 2], "c": [{"d": "x"}, {"d": 1.5}]}, "e": true}), &mut keys);
        let found: Vec<String> = keys.iter().map(|(key, value)| format!("{key}={value}")).collect();
        assert_eq!(found, ["a.b=[1,2]", "a.c[0].d=\"x\"", "a.c[1].d=1.5", "e=true"]);
    }
}
