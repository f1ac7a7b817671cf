//! Measured third octaves beside computed ones: a table of frequency and sound pressure level, as a sound level meter
//! or a program exports it.

use super::compare::{BandComparison, Comparison};
use crate::response::ThirdOctaveBand;
use crate::results::sound::SOUND_LEVEL;
use crate::sound::FrequencyWeighting;
use crate::storage::separated::SeparatedTable;

/// Words in the title of a frequency's column, and of a level's, in lower case.
const FREQUENCY_WORDS: [&str; 5] = ["freq", "hz", "band", "nominal", "terz"];
const LEVEL_WORDS: [&str; 5] = ["level", "db", "spl", "leq", "pegel"];
/// Symbols of sound pressure levels that begin such titles.
const LEVEL_SYMBOLS: [&str; 3] = ["lp", "la", "lz"];
/// Words that indicate A-weighting in the title of a level's column, in lower case.
const WEIGHTED_WORDS: [&str; 7] = ["(a)", "[a]", "dba", "db_a", "laeq", "a-weighted", "lpa"];
/// Largest relative distance of a frequency from the mid-frequency of its band, nominal or exact.
const NEAR: f64 = 0.02;
/// Range of levels that a microphone can give \[dB\].
const LEVELS: std::ops::RangeInclusive<f64> = -50.0..=200.0;

/// Measured levels of one or more microphones.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeasuredLevels {
    /// Name of the file.
    name: String,
    columns: Vec<LevelColumn>,
    /// Note on how columns were read, and what was left out.
    note: String,
}

#[derive(Clone, Debug, PartialEq)]
struct LevelColumn {
    title: String,
    weighting: FrequencyWeighting,
    /// Levels \[dB\] as written, A-weighted or not.
    levels: Vec<(ThirdOctaveBand, f64)>,
}

impl MeasuredLevels {
    /// Reads a file's bytes.
    ///
    /// # Errors
    /// In words, with line and column.
    pub(crate) fn read(bytes: &[u8], name: String) -> Result<Self, String> {
        let table = SeparatedTable::of(bytes);
        let is_numbers = |cells: &[&str]| cells.iter().filter(|cell| table.number(cell).is_some()).count() >= 2;
        let records: Vec<_> = table.records().collect();
        let first = records.iter().position(|record| is_numbers(&record.cells));
        let first = first.ok_or("no line has a frequency and a level")?;
        let titles: Vec<String> = match first.checked_sub(1) {
            Some(last) => records[last].cells.iter().map(|title| title.to_lowercase()).collect(),
            None => Vec::new(),
        };
        let columns = titles.len().max(records[first].cells.len());
        let is_named = |column: usize, words: &[&str]| {
            titles.get(column).is_some_and(|title| words.iter().any(|word| title.contains(word)))
        };
        let reported = || if titles.is_empty() { "none".to_owned() } else { titles.join(", ") };
        let frequency = (0..columns).find(|&column| is_named(column, &FREQUENCY_WORDS));
        let frequency = frequency.or_else(|| (columns == 2).then_some(0));
        let frequency = frequency.ok_or_else(|| {
            format!(
                "which of its {columns} columns is the frequency? title it frequency_hz; its titles are: {}",
                reported()
            )
        })?;
        let others = || (0..columns).filter(|&column| column != frequency);
        let is_level = |column: &usize| {
            let has_symbol =
                titles.get(*column).is_some_and(|title| LEVEL_SYMBOLS.iter().any(|symbol| title.starts_with(symbol)));
            (is_named(*column, &LEVEL_WORDS) || has_symbol) && !is_named(*column, &FREQUENCY_WORDS)
        };
        let mut levels: Vec<usize> = others().filter(is_level).collect();
        if levels.is_empty() && columns == 2 {
            levels.extend(others());
        }
        if levels.is_empty() {
            return Err(format!(
                "which of its {columns} columns is the level? title it level_db, or level_db_a where it is A-weighted; \
                 its titles are: {}",
                reported()
            ));
        }
        let unit = if is_named(frequency, &["khz"]) { 1e3 } else { 1.0 };
        let title = |column: usize| titles.get(column).cloned().unwrap_or_else(|| format!("column {}", column + 1));
        let empty = |&column: &usize| LevelColumn {
            title: title(column),
            weighting: match is_named(column, &WEIGHTED_WORDS) || title(column).ends_with("_a") {
                true => FrequencyWeighting::A,
                false => FrequencyWeighting::Z,
            },
            levels: Vec::new(),
        };
        let mut read: Vec<LevelColumn> = levels.iter().map(empty).collect();
        let mut left_out = 0;
        for record in &records[first..] {
            let at = |column: usize| record.cells.get(column).and_then(|cell| table.number(cell));
            // Sums over all bands follow the bands: "Total", "A", "L".
            let Some(hertz) = at(frequency).map(|value| unit * value) else {
                left_out += 1;
                continue;
            };
            let line = record.line;
            let band = ThirdOctaveBand::containing(hertz).filter(|band| {
                [band.nominal_frequency(), band.mid_frequency()].iter().any(|mid| (hertz / mid - 1.0).abs() < NEAR)
            });
            let band =
                band.ok_or_else(|| format!("line {line}: {hertz} Hz is not the mid-frequency of a third octave"))?;
            for (column, read) in levels.iter().zip(&mut read) {
                let Some(level) = at(*column) else { continue };
                if !LEVELS.contains(&level) {
                    return Err(format!("line {line}: {level} dB is not the level of a sound"));
                }
                if read.levels.iter().any(|(other, _)| *other == band) {
                    return Err(format!("line {line}: {hertz} Hz is there twice; give one table of levels"));
                }
                read.levels.push((band, level));
            }
        }
        if let Some(empty) = read.iter().find(|column| column.levels.is_empty()) {
            return Err(format!("no level in \"{}\"", empty.title));
        }
        let lines =
            if left_out == 0 { String::new() } else { format!("; {left_out} lines without a frequency left out") };
        let note = format!("\"{}\" is the frequency{lines}", title(frequency));
        Ok(Self { name, columns: read, note })
    }

    /// Inserts the levels into a comparison as its result `number`: each column at the receiver that its title names,
    /// or at the only one.
    ///
    /// # Errors
    /// In words, if receivers and columns do not match.
    pub(crate) fn put_into(&self, comparison: &mut Comparison, number: usize) -> Result<(), String> {
        let receivers: Vec<String> = comparison
            .spectra
            .iter()
            .filter(|spectrum| spectrum.quantity == SOUND_LEVEL)
            .map(|spectrum| spectrum.name.clone())
            .collect();
        let receiver_of = |column: &LevelColumn| {
            let named = receivers.iter().filter(|name| !name.is_empty() && column.title.contains(&name.to_lowercase()));
            let only = || receivers.first().filter(|_| receivers.len() == 1 && self.columns.len() == 1);
            named.max_by_key(|name| name.len()).or_else(only).cloned()
        };
        let mut placed: Vec<(String, &LevelColumn)> = Vec::new();
        for column in &self.columns {
            let receiver = receiver_of(column).ok_or_else(|| match receivers.is_empty() {
                true => "the results have no sound to compare it with".to_owned(),
                false => format!(
                    "whose levels are \"{}\"? name the column after a receiver: {}",
                    column.title,
                    receivers.join(", ")
                ),
            })?;
            if placed.iter().any(|(other, _)| *other == receiver) {
                return Err(format!("two columns of levels at \"{receiver}\": leave one"));
            }
            placed.push((receiver, column));
        }
        comparison.names.insert(number, self.name.clone());
        comparison.settings.iter_mut().for_each(|setting| setting.values.insert(number, String::new()));
        comparison.figures.iter_mut().for_each(|figure| figure.found.insert(number, None));
        let results = comparison.names.len();
        for spectrum in &mut comparison.spectra {
            let column = placed.iter().find(|(name, _)| spectrum.quantity == SOUND_LEVEL && *name == spectrum.name);
            spectrum.bands.iter_mut().for_each(|band| band.levels.insert(number, None));
            for &(band, level) in column.iter().flat_map(|(_, column)| &column.levels) {
                let weighted = column.is_some_and(|(_, column)| column.weighting == FrequencyWeighting::A);
                let add = if weighted { 0.0 } else { FrequencyWeighting::A.decibels(band.mid_frequency()) };
                let nominal_hz = band.nominal_frequency();
                let place = spectrum.bands.partition_point(|band| band.nominal_hz < nominal_hz);
                if spectrum.bands.get(place).is_none_or(|band| band.nominal_hz > nominal_hz) {
                    spectrum
                        .bands
                        .insert(place, BandComparison { nominal_hz, levels: vec![None; results], valid: false });
                }
                spectrum.bands[place].levels[number] = Some(level + add);
            }
        }
        let taken = placed.iter().map(|(receiver, column)| {
            let weighting = match column.weighting {
                FrequencyWeighting::A => "A-weighted, as its title says",
                FrequencyWeighting::Z => {
                    "unweighted, since its title does not say A, and A-weighted here at the mid-frequencies"
                }
            };
            let count = column.levels.len();
            format!(
                "\"{}\" is the sound pressure level in dB re 20 uPa at {receiver}, {weighting}, {count} bands",
                column.title
            )
        });
        comparison.notes.push(format!("{}: {}; {}", self.name, self.note, taken.collect::<Vec<_>>().join("; ")));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::compare::{FigureComparison, FoundFigure, SpectrumComparison};
    use super::*;
    use crate::effects::Figure;
    use crate::response::BandLevel;
    use crate::sound::TotalLevel;

    fn comparison(receivers: &[&str]) -> Comparison {
        let band = |nominal_hz| BandComparison { nominal_hz, levels: vec![Some(60.0)], valid: true };
        let spectrum = |name: &&str| SpectrumComparison {
            quantity: SOUND_LEVEL,
            name: (*name).to_owned(),
            bands: vec![band(500.0), band(1000.0)],
        };
        Comparison {
            names: vec!["run".into()],
            settings: Vec::new(),
            figures: vec![level()],
            spectra: receivers.iter().map(spectrum).collect(),
            notes: Vec::new(),
        }
    }

    /// A level of 60 dB(A), of the band of 1 kHz.
    fn level() -> FigureComparison {
        let band = BandLevel { band: ThirdOctaveBand(0), mean_square: 1.0, level: 60.0, valid: true };
        let figure = Figure::level("level", TotalLevel::of(vec![band])).unwrap();
        let found = vec![Some(FoundFigure { figure, pass_by: None })];
        FigureComparison { name: "level".to_owned(), unit: "dB(A)", found }
    }

    fn beside(text: &str, receivers: &[&str]) -> Result<Comparison, String> {
        let mut all = comparison(receivers);
        MeasuredLevels::read(text.as_bytes(), "meter.csv".to_owned())?.put_into(&mut all, 1)?;
        Ok(all)
    }

    #[test]
    fn measured_bands_stand_beside_computed_ones() {
        let rows = |all: &Comparison, spectrum: usize| {
            all.spectra[spectrum].bands.iter().map(|band| (band.nominal_hz, band.levels[1])).collect::<Vec<_>>()
        };
        let expected = [(500.0, Some(58.5)), (1000.0, Some(61.0)), (2000.0, Some(55.0))];
        for text in [
            "frequency_hz,level_db_a\n500,58.5\n1000,61\n2000,55\n",
            "Meter 3;\nFrequenz [Hz];LAeq [dB]\n500;58,5\n1000;61,0\n2000;55,0\nTotal;63,7\n",
            "f (kHz)\tSPL dB(A)\n0.5\t58.5\n1\t61\n2\t55\n",
        ] {
            let all = beside(text, &["right"]).unwrap_or_else(|wrong| panic!("{text}: {wrong}"));
            assert_eq!(rows(&all, 0), expected, "{text}");
            assert_eq!(all.spectra[0].bands[0].levels, [Some(60.0), Some(58.5)]);
            assert_eq!(all.names, ["run", "meter.csv"]);
            assert!(all.notes[0].contains("at right, A-weighted, as its title says, 3 bands"), "{:?}", all.notes);
        }
        // Without an A in the title they are unweighted: 3.2 dB come off at 500 Hz, nothing at 1 kHz (IEC 61672-1).
        let plain = beside("500,61.75\n1000,61\n", &["right"]).unwrap();
        let found = rows(&plain, 0);
        assert!((found[0].1.unwrap() - 58.5).abs() < 0.06 && (found[1].1.unwrap() - 61.0).abs() < 1e-9, "{found:?}");
        assert!(plain.notes[0].contains("unweighted, since its title does not say A"), "{:?}", plain.notes);
        let two = beside("Hz,level left dB(A),level right dB(A)\n500,50,51\n1000,52,53\n", &["right", "left"]).unwrap();
        assert_eq!([rows(&two, 0)[0].1, rows(&two, 1)[1].1], [Some(51.0), Some(52.0)]);
    }

    #[test]
    fn figures_that_a_measurement_lacks_are_empty() {
        for number in [0, 1] {
            let mut all = comparison(&["right"]);
            let measured = MeasuredLevels::read(b"frequency_hz,level_db_a\n500,58.5\n", "meter.csv".to_owned());
            measured.unwrap().put_into(&mut all, number).unwrap();
            let reported = all.report().to_string();
            let line = reported.lines().find(|line| line.trim_start().starts_with("level [dB(A)]")).unwrap();
            assert!(line.contains("at least 60.00 (error not known), 1 kHz - 1 kHz") && !line.contains('+'), "{line}");
            let figure = &serde_json::json!(all)["figures"][0];
            let places = ["values", "differences", "bands", "errors"].map(|key| figure[key].as_array().unwrap().len());
            assert_eq!((places, figure["values"][number].is_null()), ([2; 4], true), "{figure}");
            let csv = all.csv();
            let columns: Vec<usize> = csv.lines().map(|line| line.split(',').count()).collect();
            assert_eq!(columns, [20; 4], "{csv}");
        }
    }

    #[test]
    fn what_is_no_table_of_third_octaves_is_refused() {
        for (text, receivers, words) in [
            ("", &["a"][..], "no line has a frequency and a level"),
            ("frequency_hz,level_db\n", &["a"], "no line has a frequency and a level"),
            ("x,y,z\n1,2,3\n", &["a"], "which of its 3 columns is the frequency"),
            ("hz,y,z\n500,2,3\n", &["a"], "which of its 3 columns is the level"),
            ("hz,level\n500,60\n501.2,61\n", &["a"], "line 3: 501.2 Hz is there twice"),
            ("hz,level\n500,60\n570,61\n", &["a"], "line 3: 570 Hz is not the mid-frequency"),
            ("hz,level\n500,2e5\n", &["a"], "200000 dB is not the level"),
            ("hz,level\n500,60\n", &[], "no sound to compare it with"),
            ("hz,level\n500,60\n", &["a1", "b1"], "name the column after a receiver: a1, b1"),
            ("hz,level a1,level a1 again\n500,60,61\n", &["a1", "b1"], "two columns of levels at \"a1\""),
        ] {
            let reported = beside(text, receivers).unwrap_err();
            assert!(reported.contains(words), "{text}: {reported}");
        }
    }
}
