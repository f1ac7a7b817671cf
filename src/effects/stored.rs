//! Results folder of a run, read for effects and reports.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::plan::Plan;
use crate::response::{BandLevel, LevelErrors, ThirdOctaveBand};
use crate::results::summary::Summary;
use crate::results::table::StoredTable;
use crate::scene::{LoadedScene, SceneError};
use crate::storage::array::{Array, ArrayError};
use crate::storage::flat_folder;
use crate::storage::input::{self, InputError, TABLE_BYTES};

/// Error of a results folder.
#[derive(Debug, Error)]
pub enum StoredError {
    /// A file that cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Error of the file system.
        source: std::io::Error,
    },
    /// A file whose content is not what its name says.
    #[error("{}: {reason}", path.display())]
    Content {
        /// Path of the file.
        path: PathBuf,
        /// Fault found.
        reason: String,
    },
    /// Settings that this version of the program does not accept.
    #[error("the settings in {}: {source}", path.display())]
    Settings {
        /// Path of the summary.
        path: PathBuf,
        /// Errors of the settings.
        source: Box<SceneError>,
    },
}

/// Third-octave levels of one signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Quantity of the levels, reference included: that of the effect's table.
    pub quantity: &'static str,
    /// Name of the signal; empty where it is the only one of the quantity.
    pub name: String,
    /// Levels by rising band.
    pub levels: Vec<BandLevel>,
    /// Errors of valid levels.
    pub errors: LevelErrors,
}

/// An array that a run has written.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StoredArray {
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// Numbers, row by row.
    pub values: Vec<f64>,
}

/// Results of a finished or interrupted run.
#[derive(Clone, Debug)]
pub struct Stored {
    /// Path of the folder.
    pub folder: PathBuf,
    /// Summary of the run.
    pub summary: Summary,
    /// The scene as it was run.
    pub loaded: LoadedScene,
    /// Plan of the run, with its reasons.
    pub plan: Plan,
    /// All third octaves: forces, velocities, sound.
    pub(crate) spectra: Vec<Spectrum>,
    /// True if the file of a measured road comes from the caller, and not from the folder.
    pub(crate) knows_road: bool,
}

impl Stored {
    /// Sets the file of the measured road, where a caller knows it: it is not among the results.
    #[must_use]
    pub fn with_road(mut self, file: Option<&Path>) -> Self {
        if let (Some(of_scene), Some(file)) = (self.plan.scene.road.file_mut(), file) {
            file.clone_into(of_scene);
            self.knows_road = true;
        }
        self
    }

    /// Third octaves of a signal, by their quantity and its name.
    pub(crate) fn spectrum(&self, quantity: &str, name: &str) -> Option<&Spectrum> {
        self.spectra.iter().find(|spectrum| spectrum.quantity == quantity && spectrum.name == name)
    }

    /// Name of the run: that of its folder.
    pub fn name(&self) -> String {
        self.folder.file_name().unwrap_or(self.folder.as_os_str()).to_string_lossy().into_owned()
    }

    /// Reads a text file of the folder; `None` where the run has not written it.
    ///
    /// # Errors
    /// [`StoredError::Read`], also for one that is too large or not text.
    pub fn text(&self, name: &str) -> Result<Option<String>, StoredError> {
        file(&self.folder, name)?.map(|path| read_text(&path)).transpose()
    }

    /// Reads the bytes of a file of the folder.
    ///
    /// # Errors
    /// As [`Self::text`].
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>, StoredError> {
        let path = file(&self.folder, name)?.unwrap_or_else(|| self.folder.join(name));
        input::read(&path, TABLE_BYTES).map_err(reading(&path))
    }

    /// Reads a column of numbers from an array of the folder; `None` where the run has not written it.
    ///
    /// # Errors
    /// [`StoredError::Content`] for a file without such a column.
    pub fn column(&self, name: &str) -> Result<Option<Vec<f64>>, StoredError> {
        Ok(self.array(name)?.map(|array| array.values))
    }

    /// Reads an array of the folder; `None` where the run has not written it.
    ///
    /// # Errors
    /// [`StoredError::Content`] for a file without one.
    pub(crate) fn array(&self, name: &str) -> Result<Option<StoredArray>, StoredError> {
        let Some(path) = file(&self.folder, name)? else { return Ok(None) };
        let read = || {
            let array = Array::open(&path)?;
            let shape = array.shape().iter().map(|&length| length as usize).collect();
            Ok(StoredArray { shape, values: array.into_values()? })
        };
        let array: Result<StoredArray, ArrayError> = read();
        array.map(Some).map_err(|error| StoredError::Content { path, reason: error.to_string() })
    }

    /// Reads a table of the folder; `None` where the run has not written it.
    ///
    /// # Errors
    /// [`StoredError`].
    pub(crate) fn table(&self, name: &str) -> Result<Option<StoredTable>, StoredError> {
        let Some(text) = self.text(name)? else { return Ok(None) };
        let wrong = |error| StoredError::Content { path: self.folder.join(name), reason: format!("no table: {error}") };
        StoredTable::parse(&text).map(Some).map_err(wrong)
    }

    /// Reads the third octaves of the signals in a table of the folder, by a column of levels; `None` where the run has
    /// not written it.
    ///
    /// # Errors
    /// [`StoredError`].
    pub(crate) fn levels(&self, name: &str, column: &str) -> Result<Option<NamedLevels>, StoredError> {
        let Some(table) = self.table(name)? else { return Ok(None) };
        let wrong = || StoredError::Content {
            path: self.folder.join(name),
            reason: format!("no table of third octaves with a column {column}"),
        };
        levels(&table, column).ok_or_else(wrong).map(Some)
    }
}

/// Third octaves of several signals, by their names.
pub(crate) type NamedLevels = Vec<(String, Vec<BandLevel>)>;

/// Third octaves of the signals in a table. Silence has no level, and its cell is empty.
pub(crate) fn levels(table: &StoredTable, column: &str) -> Option<NamedLevels> {
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

/// Path of a file of the folder; `None` where there is none.
pub(crate) fn file(folder: &Path, name: &str) -> Result<Option<PathBuf>, StoredError> {
    flat_folder::file(folder, name).map_err(|source| StoredError::Read { path: folder.join(name), source })
}

pub(crate) fn read_text(path: &Path) -> Result<String, StoredError> {
    input::read_text(path, TABLE_BYTES).map_err(reading(path))
}

fn reading(path: &Path) -> impl FnOnce(InputError) -> StoredError {
    |error| StoredError::Read { path: path.to_owned(), source: error.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::LevelErrors;
    use crate::results::spectra::force_levels_csv;

    #[test]
    fn spectra_are_distinguished_by_the_columns_before_frequency() {
        let text = "receiver,nominal_hz,mid_frequency_hz,level_db_a,valid\na,100,100,50,1\na,125,125.9,51.5,0\n\
                    b,100,100,-inf,1\n";
        let read = |text: &str, column: &str| levels(&StoredTable::parse(text).ok()?, column);
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
        let table =
            StoredTable::parse(&force_levels_csv(&[band], &LevelErrors::default(), |_| None, |_| None)).unwrap();
        assert_eq!(levels(&table, "level_db_re_1n").unwrap(), [(String::new(), vec![band])]);
    }
}
