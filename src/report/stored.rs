//! Reading of a results folder: its summary, its scene and plan, and the third octaves of its effects.

use std::path::Path;

use serde_json::Value;

use crate::effects::stored::{Spectrum, Stored, StoredError, file, read_text};
use crate::effects::{EFFECTS, Effect, LevelTable};
use crate::plan::Plan;
use crate::results::summary::{FORMAT, FORMAT_VERSION, SUMMARY_FILE, Summary};
use crate::scene::LoadedScene;

impl Stored {
    /// Reads a results folder of `tyrewave run`: summary and tables; arrays and pictures are read on demand. The folder
    /// is not trusted: nothing outside of it is read, whatever its files name, and no link in it is followed.
    ///
    /// # Errors
    /// [`StoredError`].
    pub fn open(folder: &Path) -> Result<Self, StoredError> {
        let path = folder.join(SUMMARY_FILE);
        let content = |reason: String| StoredError::Content { path: path.clone(), reason };
        file(folder, SUMMARY_FILE)?;
        let text = read_text(&path)?;
        let value: Value = serde_json::from_str(&text).map_err(|error| content(format!("not JSON: {error}")))?;
        if value["format"] != FORMAT || value["format_version"] != FORMAT_VERSION {
            return Err(content(format!("no summary of {FORMAT}, version {FORMAT_VERSION}")));
        }
        let summary: Summary =
            serde_json::from_value(value).map_err(|error| content(format!("no summary of a run: {error}")))?;
        if summary.outcome.steps == 0 {
            return Err(content("its command was not `tyrewave run`, or nothing was rolled".to_owned()));
        }
        let sounds =
            summary.sound.iter().flat_map(|sound| &sound.receivers).filter_map(|receiver| receiver.audio.as_ref());
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
            let Some(spectra) = self.levels(file, column)? else { continue };
            let errors = errors(self);
            all.extend(spectra.into_iter().map(|(name, levels)| {
                let errors = errors.clone();
                Spectrum { quantity, name, levels, errors }
            }));
        }
        Ok(all)
    }
}
