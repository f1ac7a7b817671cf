//! Results of a sweep in a folder, opened again by its [record](super::record).

use std::path::Path;

use super::record::{RECORD_FILE, SweepRecord};
use super::variants::Label;
use crate::effects::stored::{Stored, StoredError, file, read_text};
use crate::results::summary::SUMMARY_FILE;
use crate::storage::flat_folder::subfolder;

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
