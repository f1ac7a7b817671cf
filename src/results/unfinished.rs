//! Finding the folder of an unfinished run, and locking it while a process writes to it.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use super::checkpoint::{CHECKPOINT_FILE, CheckpointError};
use super::summary::SUMMARY_FILE;
use crate::storage::flat_folder::{self, entries};

/// File that is locked while a process writes to the folder.
pub(super) const LOCK_FILE: &str = "lock";
/// Suffix of an unfinished run's folder, after the final name.
pub(super) const PARTIAL: &str = ".partial";

/// Folder of an unfinished run with a checkpoint, by the run's final path or by the folder itself.
///
/// # Errors
/// [`CheckpointError`] unless there is exactly one.
pub(crate) fn unfinished(path: &Path) -> Result<PathBuf, CheckpointError> {
    let has_checkpoint = |folder: &Path| folder.join(CHECKPOINT_FILE).is_file();
    if final_name(path).is_some() && path.is_dir() {
        let path = path.to_owned();
        return if has_checkpoint(&path) { Ok(path) } else { Err(CheckpointError::NoCheckpoint { path }) };
    }
    let mut found = partial_folders(path);
    let without = found.iter().find(|folder| !has_checkpoint(folder)).cloned();
    found.retain(|folder| has_checkpoint(folder));
    match (found.len(), without) {
        (1, _) => Ok(found.remove(0)),
        (0, Some(path)) => Err(CheckpointError::NoCheckpoint { path }),
        (0, None) if path.join(SUMMARY_FILE).is_file() => Err(CheckpointError::Complete { path: path.to_owned() }),
        (0, None) => Err(CheckpointError::Nothing { path: path.to_owned() }),
        _ => Err(CheckpointError::Several { found }),
    }
}

/// Folders of unfinished runs with a final path, sorted.
pub(super) fn partial_folders(target: &Path) -> Vec<PathBuf> {
    let Some(name) = target.file_name() else { return Vec::new() };
    let parent = target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = entries(parent) else { return Vec::new() };
    let name = name.to_string_lossy();
    let mut names: Vec<String> = entries
        .into_iter()
        .filter(|entry| {
            let rest = entry.strip_prefix(name.as_ref()).and_then(|rest| rest.strip_prefix(PARTIAL));
            rest.is_some_and(|rest| rest.is_empty() || (rest.starts_with('-') && !rest.ends_with("-old")))
        })
        .collect();
    names.sort();
    names.into_iter().map(|name| target.with_file_name(name)).filter(|folder| folder.is_dir()).collect()
}

/// Deletes folders of unfinished runs with a final path, unless a process still writes to them.
pub(crate) fn forget_abandoned(target: &Path) {
    for folder in partial_folders(target).into_iter().filter(|folder| !in_use(folder)) {
        // A folder that cannot be deleted does no harm.
        let _ = flat_folder::remove(&folder);
    }
}

/// Final path of an unfinished run's folder; `None` for a folder with another name.
pub(super) fn final_name(folder: &Path) -> Option<PathBuf> {
    let name = folder.file_name()?.to_str()?;
    let (name, rest) = name.rsplit_once(PARTIAL)?;
    (!name.is_empty() && (rest.is_empty() || rest.starts_with('-'))).then(|| folder.with_file_name(name))
}

/// Locks a folder for this process, as long as the file lives; `None` where the file system has no locks.
pub(super) fn lock(folder: &Path) -> Result<Option<File>, CheckpointError> {
    let path = folder.join(LOCK_FILE);
    // The content is changed only by the holder of the lock.
    let options = File::options().write(true).create(true).truncate(false).clone();
    let file = options.open(&path).map_err(|source| CheckpointError::Io { path: path.clone(), source })?;
    match file.try_lock() {
        Ok(()) => file.set_len(0).map(|()| Some(file)).map_err(|source| CheckpointError::Io { path, source }),
        Err(TryLockError::WouldBlock) => Err(CheckpointError::Running { path: folder.to_owned() }),
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

/// True if a process writes to the folder.
pub(super) fn in_use(folder: &Path) -> bool {
    let file = File::open(folder.join(LOCK_FILE));
    file.is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}
