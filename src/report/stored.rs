//! A results folder, read again.

use std::path::{Path, PathBuf};

use serde_json::Value;
use thiserror::Error;

use super::table::Table;
use crate::plan::Plan;
use crate::plan::front::FrontRow;
use crate::response::{BandLevel, ThirdOctaveBand};
use crate::results::sound::{SOUND_FILE, SOUND_LEVEL};
use crate::results::spectra::{FORCE_LEVEL, SPECTRA_FILE};
use crate::results::summary::{FORMAT, FORMAT_VERSION, SUMMARY_FILE, Summary};
use crate::results::vibration::{VELOCITY_LEVEL, VIBRATION_FILE};
use crate::scene::{LoadedScene, SceneError};
use crate::storage::array::{Array, ArrayError};
use crate::storage::flat_folder;
use crate::storage::input::{self, InputError, TABLE_BYTES};

/// Why a folder cannot be reported on.
#[derive(Debug, Error)]
pub enum StoredError {
    /// A file that cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// A file that is not what its name says.
    #[error("{}: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Fault of the file.
        reason: String,
    },
    /// Settings that this version of the program does not take.
    #[error("the settings in {}: {source}", path.display())]
    Settings {
        /// The summary.
        path: PathBuf,
        /// Faults of the settings.
        source: Box<SceneError>,
    },
}

/// Third-octave levels of one signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Quantity of the levels, reference included: [`FORCE_LEVEL`], [`VELOCITY_LEVEL`] or [`SOUND_LEVEL`].
    pub quantity: &'static str,
    /// Which signal; empty where there is one of the quantity.
    pub name: String,
    /// The levels, bands rising.
    pub levels: Vec<BandLevel>,
    /// The frequency \[Hz\] from which on it is known how far off valid levels may be, and how far that is \[dB\].
    pub error: Option<(f64, f64)>,
}

/// An array that a run has written.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredArray {
    /// Its lengths.
    pub shape: Vec<usize>,
    /// Its numbers, row by row.
    pub values: Vec<f64>,
}

/// Results that a finished or interrupted run has left.
#[derive(Clone, Debug)]
pub struct Stored {
    /// The folder.
    pub folder: PathBuf,
    /// Its summary.
    pub summary: Summary,
    /// The scene as it was run.
    pub loaded: LoadedScene,
    /// Plan of the run, with its reasons.
    pub plan: Plan,
    /// All third octaves: forces, velocities, sound.
    pub spectra: Vec<Spectrum>,
    /// True if the file of a measured road comes from the caller: the folder's own word on it is not taken.
    pub(super) knows_road: bool,
}

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

    /// With the file of the measured road, where a caller knows it: it is not among the results.
    #[must_use]
    pub fn with_road(mut self, file: Option<&Path>) -> Self {
        if let (Some(own), Some(file)) = (self.plan.scene.road.file_mut(), file) {
            file.clone_into(own);
            self.knows_road = true;
        }
        self
    }

    /// The third octaves of a signal, by their quantity and its name.
    pub fn spectrum(&self, quantity: &str, name: &str) -> Option<&Spectrum> {
        self.spectra.iter().find(|spectrum| spectrum.quantity == quantity && spectrum.name == name)
    }

    /// The run's name: its folder's.
    pub fn name(&self) -> String {
        self.folder.file_name().unwrap_or(self.folder.as_os_str()).to_string_lossy().into_owned()
    }

    /// A text file of the folder; `None` where the run has not written it.
    ///
    /// # Errors
    /// [`StoredError::Read`], also of one that is too large or no text.
    pub fn text(&self, name: &str) -> Result<Option<String>, StoredError> {
        file(&self.folder, name)?.map(|path| read_text(&path)).transpose()
    }

    /// The bytes of a file of the folder.
    ///
    /// # Errors
    /// As [`Self::text`].
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>, StoredError> {
        let path = file(&self.folder, name)?.unwrap_or_else(|| self.folder.join(name));
        input::read(&path, TABLE_BYTES).map_err(reading(&path))
    }

    /// A column of numbers from an array of the folder; `None` where the run has not written it.
    ///
    /// # Errors
    /// [`StoredError::Content`] of a file that holds no such column.
    pub fn column(&self, name: &str) -> Result<Option<Vec<f64>>, StoredError> {
        Ok(self.array(name)?.map(|array| array.values))
    }

    /// An array of the folder; `None` where the run has not written it.
    ///
    /// # Errors
    /// [`StoredError::Content`] of a file that holds none.
    pub fn array(&self, name: &str) -> Result<Option<StoredArray>, StoredError> {
        let Some(path) = file(&self.folder, name)? else { return Ok(None) };
        let read = || {
            let array = Array::open(&path)?;
            let shape = array.shape().iter().map(|&length| length as usize).collect();
            Ok(StoredArray { shape, values: array.into_values()? })
        };
        let array: Result<StoredArray, ArrayError> = read();
        array.map(Some).map_err(|error| StoredError::Content { path, reason: error.to_string() })
    }

    /// A table of the folder; `None` where the run has not written it.
    ///
    /// # Errors
    /// [`StoredError`].
    pub(super) fn table(&self, name: &str) -> Result<Option<Table>, StoredError> {
        let Some(text) = self.text(name)? else { return Ok(None) };
        let wrong = |error| StoredError::Content { path: self.folder.join(name), reason: format!("no table: {error}") };
        Table::parse(&text).map(Some).map_err(wrong)
    }

    fn read_spectra(&self) -> Result<Vec<Spectrum>, StoredError> {
        let stated = FrontRow::stated_error(&self.plan.scene.numerics);
        let sound = self.summary.sound.as_ref().map(|sound| sound.error.of_bands());
        let tables = [
            (SPECTRA_FILE, FORCE_LEVEL, "level_db_re_1n", stated),
            (VIBRATION_FILE, VELOCITY_LEVEL, "level_db_re_1m_s", None),
            (SOUND_FILE, SOUND_LEVEL, "level_db_a", sound),
        ];
        let mut all = Vec::new();
        for (file, quantity, column, error) in tables {
            let Some(table) = self.table(file)? else { continue };
            let spectra = levels(&table, column).ok_or_else(|| StoredError::Content {
                path: self.folder.join(file),
                reason: format!("no table of third octaves with a column {column}"),
            })?;
            all.extend(spectra.into_iter().map(|(name, levels)| Spectrum { quantity, name, levels, error }));
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

/// The path of a file of the folder; `None` where there is none.
fn file(folder: &Path, name: &str) -> Result<Option<PathBuf>, StoredError> {
    flat_folder::file(folder, name).map_err(|source| StoredError::Read { path: folder.join(name), source })
}

fn read_text(path: &Path) -> Result<String, StoredError> {
    input::read_text(path, TABLE_BYTES).map_err(reading(path))
}

fn reading(path: &Path) -> impl FnOnce(InputError) -> StoredError {
    |error| StoredError::Read { path: path.to_owned(), source: error.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        let table = Table::parse(&force_levels_csv(&[band])).unwrap();
        assert_eq!(levels(&table, "level_db_re_1n").unwrap(), [(String::new(), vec![band])]);
    }
}
