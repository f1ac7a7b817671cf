//! One full scale for all audio files of a sweep, so that the louder of two variants sounds louder.
//!
//! Each run chooses a full scale that its loudest file fits into. Once all are there, the largest of these is given to
//! every file and to its summary. A file states its full scale, so a sweep that is stopped in between leaves no
//! wrong file, and completes the rest the next time. Where a scene gives
//! `radiation.full_scale` all have it already.

use std::path::{Path, PathBuf};

use crate::results::ResultsError;
use crate::results::sound::AudioSummary;
use crate::results::summary::{SUMMARY_FILE, Summary};
use crate::sound::wav::{full_scale_of, rescaled};
use crate::storage::PendingFile;
use crate::storage::input::{self, TABLE_BYTES};

/// Gives all audio files of some results the largest full scale among them.
///
/// # Errors
/// A file that cannot be written. Folders without results and files of other programs are left alone.
pub(crate) fn share_full_scale(folders: &[PathBuf]) -> Result<(), ResultsError> {
    let known: Vec<(&PathBuf, Summary)> = folders.iter().filter_map(|folder| Some((folder, read(folder)?))).collect();
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

fn read(folder: &Path) -> Option<Summary> {
    serde_json::from_slice(&input::read(&folder.join(SUMMARY_FILE), TABLE_BYTES).ok()?).ok()
}

fn audio(summary: &Summary) -> impl Iterator<Item = &AudioSummary> {
    summary.sound.iter().flat_map(|sound| &sound.receivers).filter_map(|receiver| receiver.audio.as_ref())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), ResultsError> {
    let file = PendingFile::create(path).map_err(ResultsError::creating(path))?;
    file.complete(bytes).map_err(ResultsError::writing(path))
}
