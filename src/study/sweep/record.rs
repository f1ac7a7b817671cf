//! `sweep.json`: the variants of a sweep, by which a page finds their results again.
//!
//! One full scale for all audio files of a sweep, so that the louder of two variants sounds louder.
//!
//! Each run chooses a full scale that its loudest file fits into. Once all are there, the largest of these is given to
//! every file and to its summary. A file states its full scale, so a sweep that is stopped in between leaves no
//! wrong file, and completes the rest the next time. Where a scene gives
//! `radiation.full_scale` all have it already.

use std::path::{Path, PathBuf};

use crate::effects::stored::{Stored, StoredError, file, read_text};
use crate::results::ResultsError;
use crate::results::sound::AudioSummary;
use crate::results::summary::{SUMMARY_FILE, Summary, read_summary};
use crate::sound::wav::{full_scale_of, rescaled};
use crate::storage::PendingFile;
use crate::storage::flat_folder::subfolder;
use crate::storage::input::{self, TABLE_BYTES};
use crate::study::sweep::variants::Label;
use serde::{Deserialize, Serialize};

/// File beside the variants' folders.
pub(crate) const RECORD_FILE: &str = "sweep.json";
/// Format and version that the file states.
const FORMAT: &str = "tyrewave sweep";
const FORMAT_VERSION: u32 = 1;

/// A variant of a sweep.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct Recorded {
    /// Name, group and choices in the tables.
    #[serde(flatten)]
    pub label: Label,
    /// True if the folder of this name holds its results.
    pub done: bool,
}

/// All variants of a sweep.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct SweepRecord {
    format: String,
    format_version: u32,
    /// Title of the scene that is varied.
    pub title: String,
    /// All variants, in their order.
    pub variants: Vec<Recorded>,
}

impl SweepRecord {
    pub(crate) fn new(title: String, variants: Vec<Recorded>) -> Self {
        Self { format: FORMAT.to_owned(), format_version: FORMAT_VERSION, title, variants }
    }

    /// Text of the file.
    pub(crate) fn to_json(&self) -> String {
        format!("{:#}\n", serde_json::json!(self))
    }

    /// Parses the text of the file.
    ///
    /// # Errors
    /// In words, for a text that is no record of this version.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let wrong = |error: serde_json::Error| format!("not a list of a sweep's variants: {error}");
        let record: Self = serde_json::from_str(text).map_err(wrong)?;
        if (record.format.as_str(), record.format_version) != (FORMAT, FORMAT_VERSION) {
            return Err(format!("no {FORMAT}, version {FORMAT_VERSION}"));
        }
        let factors = |of: &Recorded| -> Vec<(String, bool)> {
            of.label.choices.iter().map(|choice| (choice.factor.clone(), choice.repeats)).collect()
        };
        let alike = record.variants.windows(2).all(|pair| factors(&pair[0]) == factors(&pair[1]));
        if !alike || record.variants.is_empty() || record.variants.iter().any(|of| of.label.speed <= 0.0) {
            return Err("no variants of the same keys, each with a speed above 0".to_owned());
        }
        Ok(record)
    }
}

/// Results of a sweep in a folder.
pub(crate) struct StoredSweep {
    /// Title of the scene that is varied.
    pub title: String,
    /// Variants in their order; `None` for those that are not finished.
    pub variants: Vec<(Label, Option<Stored>)>,
}

impl StoredSweep {
    /// Reads a folder of `tyrewave sweep`; `None` if it is not one. Nothing outside of it is read.
    ///
    /// # Errors
    /// [`StoredError`].
    pub(crate) fn open(folder: &Path) -> Result<Option<Self>, StoredError> {
        let Some(path) = file(folder, RECORD_FILE)? else { return Ok(None) };
        let content = |reason| StoredError::Content { path: path.clone(), reason };
        let record = SweepRecord::parse(&read_text(&path)?).map_err(content)?;
        let mut variants = Vec::new();
        for recorded in record.variants {
            let name = &recorded.label.name;
            let place = subfolder(folder, name).map_err(|error| content(format!("its variant {name}: {error}")))?;
            let place = place.filter(|place| recorded.done && place.join(SUMMARY_FILE).exists());
            variants.push((recorded.label, place.as_deref().map(Stored::open).transpose()?));
        }
        Ok(Some(Self { title: record.title, variants }))
    }
}

/// Gives all audio files of some results the largest full scale among them.
///
/// # Errors
/// A file that cannot be written. Folders without results and files of other programs are left alone.
pub(crate) fn share_full_scale(folders: &[PathBuf]) -> Result<(), ResultsError> {
    let known: Vec<(&PathBuf, Summary)> =
        folders.iter().filter_map(|folder| Some((folder, read_summary(folder)?))).collect();
    let all = known.iter().flat_map(|(_, summary)| audio(summary));
    // Files louder than the requested full scale hold floats; their full scale is the requested one.
    let largest = all.map(|audio| audio.full_scale).fold(0.0, f64::max);
    for (folder, mut summary) in known {
        let mut changed = false;
        for audio in summary.sound.iter_mut().flat_map(|sound| &mut sound.receivers).filter_map(|of| of.audio.as_mut())
        {
            // A plain file name: nothing outside the folder is touched.
            let Some(name) = Path::new(&audio.file).file_name().filter(|name| *name == audio.file.as_str()) else {
                continue;
            };
            let path = folder.join(name);
            let Ok(bytes) = input::read(&path, TABLE_BYTES) else { continue };
            if full_scale_of(&bytes).is_some_and(|scale| scale < largest)
                && let Some(Ok(bytes)) = rescaled(&bytes, largest)
            {
                write(&path, &bytes)?;
            }
            changed |= audio.full_scale < largest;
            audio.full_scale = largest;
        }
        if changed {
            let path = folder.join(SUMMARY_FILE);
            write(&path, summary.to_json(&path)?.as_bytes())?;
        }
    }
    Ok(())
}

fn audio(summary: &Summary) -> impl Iterator<Item = &AudioSummary> {
    summary.sound.iter().flat_map(|sound| &sound.receivers).filter_map(|receiver| receiver.audio.as_ref())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), ResultsError> {
    let file = PendingFile::create(path).map_err(ResultsError::creating(path))?;
    file.complete(bytes).map_err(ResultsError::writing(path))
}
