//! Reading of a results folder: its summary, its scene and plan, and the third octaves of its effects.

use std::path::Path;

use serde_json::Value;

use crate::effects::stored::{Spectrum, Stored, StoredError, file, read_text};
use crate::effects::{EFFECTS, Effect, LevelTable};
use crate::plan::Plan;
use crate::response::{BandLevel, ThirdOctaveBand};
use crate::results::read_table::Table;
use crate::results::summary::{FORMAT, FORMAT_VERSION, SUMMARY_FILE, Summary};
use crate::scene::LoadedScene;

impl Stored {
    /// Reads a results folder of `tyrewave run`: summary and tables; arrays and pictures are read when they are asked
    /// for. A folder may come from anywhere: nothing outside of it is read, whatever its files name, and no link in it
    /// is followed.
    ///
    /// # Errors
    /// [`StoredError`].
    pub fn open(folder: &Path) -> Result<Self, StoredError> {
        let path = folder.join(SUMMARY_FILE);
        let content = |reason: String| StoredError::Content { path: path.clone(), reason };
        file(folder, SUMMARY_FILE)?;
        let text = read_text(&path)?;
        let value: Value = serde_json::from_str(&text).map_err(|error| content(format!("no JSON: {error}")))?;
        if value["format"] != FORMAT || value["format_version"] != FORMAT_VERSION {
            return Err(content(format!("no summary of {FORMAT}, version {FORMAT_VERSION}")));
        }
        let summary: Summary =
            serde_json::from_value(value).map_err(|error| content(format!("no summary of a run: {error}")))?;
        if summary.outcome.steps == 0 {
            return Err(content("its command was not `tyrewave run`, or nothing was rolled".to_owned()));
        }
        let sounds = summary.sound.iter().flat_map(|sound| &sound.receivers).filter_map(|heard| heard.audio.as_ref());
        for name in summary.files.iter().chain(sounds.map(|audio| &audio.file)) {
            file(folder, name)?;
        }
        let settings = |source| StoredError::Settings { path: path.clone(), source: Box::new(source) };
        let scene = toml::to_string(&summary.settings).map_err(|source| content(format!("its settings: {source}")))?;
        let name = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy();
        let mut loaded = LoadedScene::recorded(&scene, &name).map_err(settings)?;
        loaded.scene.title.clone_from(&summary.title);
        let plan = Plan::of(&loaded).map_err(settings)?;
        let mut stored =
            Self { folder: folder.to_owned(), summary, loaded, plan, spectra: Vec::new(), knows_road: false };
        stored.spectra = stored.read_spectra()?;
        Ok(stored)
    }

    fn read_spectra(&self) -> Result<Vec<Spectrum>, StoredError> {
        let mut all = Vec::new();
        for LevelTable { file, quantity, column, errors } in EFFECTS.into_iter().flat_map(Effect::levels) {
            let Some(table) = self.table(file)? else { continue };
            let spectra = levels(&table, column).ok_or_else(|| StoredError::Content {
                path: self.folder.join(file),
                reason: format!("no table of third octaves with a column {column}"),
            })?;
            let errors = errors(self);
            all.extend(spectra.into_iter().map(|(name, levels)| {
                let errors = errors.clone();
                Spectrum { quantity, name, levels, errors }
            }));
        }
        Ok(all)
    }
}

/// Third octaves of the signals in a table. Silence has no level, and its cell is empty.
fn levels(table: &Table, column: &str) -> Option<Vec<(String, Vec<BandLevel>)>> {
    let [middles, levels, valid] = ["mid_frequency_hz", column, "valid"].map(|name| table.numbers(name));
    let (middles, levels, valid) = (middles?, levels?, valid?);
    let band = |row: usize| {
        let band = ThirdOctaveBand::containing(middles[row])?;
        let level = if levels[row].is_nan() { f64::NEG_INFINITY } else { levels[row] };
        Some(BandLevel { band, mean_square: 10.0_f64.powf(0.1 * level), level, valid: valid[row] > 0.0 })
    };
    let spectra = table.signals().into_iter();
    spectra.map(|(name, rows)| Some((name, rows.map(band).collect::<Option<_>>()?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::LevelErrors;
    use crate::results::spectra::force_levels_csv;

    #[test]
    fn spectra_are_told_apart_by_the_columns_before_the_frequencies() {
        let text = "receiver,nominal_hz,mid_frequency_hz,level_db_a,valid\na,100,100,50,1\na,125,125.9,51.5,0\n\
                    b,100,100,-inf,1\n";
        let read = |text: &str, column: &str| levels(&Table::parse(text).ok()?, column);
        let spectra = read(text, "level_db_a").unwrap();
        let names: Vec<(&str, usize)> = spectra.iter().map(|(name, levels)| (name.as_str(), levels.len())).collect();
        assert_eq!(names, [("a", 2), ("b", 1)]);
        assert!(spectra[0].1[0].valid && !spectra[0].1[1].valid);
        assert!((spectra[0].1[1].level - 51.5).abs() < 1e-12 && spectra[1].1[0].level.is_infinite());
        assert!(read(text, "level_db").is_none() && read("a,b\n1,2\n", "level_db_a").is_none());
        assert!(read(&text.replace("51.5", "loud"), "level_db_a").is_none());
    }

    #[test]
    fn silence_is_read_as_it_is_written() {
        let band = BandLevel { band: ThirdOctaveBand(-10), mean_square: 0.0, level: f64::NEG_INFINITY, valid: true };
        let table = Table::parse(&force_levels_csv(&[band], &LevelErrors::default())).unwrap();
        assert_eq!(levels(&table, "level_db_re_1n").unwrap(), [(String::new(), vec![band])]);
    }
}
