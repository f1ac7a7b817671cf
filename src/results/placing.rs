//! Giving a working folder its final name, and tidying up where a process was killed in the middle of that.
//!
//! 1. The lock file of the working folder, whose content is whole by then, gets the folder's name: the mark.
//! 2. The folder gets its new name ([`super::disk`]): names are exchanged, or, where the file system cannot do that,
//!    the older folder steps aside first.
//! 3. The older folder is deleted, under the working folder's name or aside; last the service files, the lock last of
//!    all.
//!
//! So a mark that is its folder's name shows that the move was begun: it is carried out. Any other mark shows that
//! the move was done and names the remainder of the older folder: it is deleted.
//!
//! Finding the folder of an unfinished run, and locking it while a process writes to it.

use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::storage::flat_folder::{self, entries};

use super::checkpoint::{CHECKPOINT_FILE, CheckpointError, SCENE_FILE, TEMPORARY_FILE};
use super::disk::{aside, replace, with_suffix, write_file};
use super::error::ResultsError;
use super::summary::{FORMAT, Marker, SUMMARY_FILE, read_summary};

/// Files that an unfinished run needs and a finished one does not; the lock is deleted last.
pub(super) const SERVICE_FILES: [&str; 4] = [CHECKPOINT_FILE, TEMPORARY_FILE, SCENE_FILE, LOCK_FILE];

/// Gives a working folder its new name; an older folder there is deleted.
///
/// # Errors
/// [`ResultsError::Create`], [`ResultsError::Write`], [`ResultsError::Rename`].
pub(super) fn place(working: &Path, target: &Path) -> Result<(), ResultsError> {
    let name = working.file_name().unwrap_or_default().to_string_lossy();
    write_file(&working.join(LOCK_FILE), name.as_bytes())?;
    // Of an older folder: with its lock it would look like one that a process writes to.
    let _ = fs::remove_file(target.join(LOCK_FILE));
    if let Some(old) = replace(working, target)? {
        let _ = flat_folder::remove(&old);
    }
    Ok(())
}

/// Removes the service files from finished results; if one cannot be removed the lock stays, too, which marks the rest
/// as written by tyrewave.
pub(super) fn tidy_up(target: &Path) {
    let gone = |name: &&str| match fs::remove_file(target.join(name)) {
        Err(error) => error.kind() == ErrorKind::NotFound,
        Ok(()) => true,
    };
    let _ = SERVICE_FILES.iter().all(gone);
}

/// Tidies up after processes that were killed while results took the name `target`; returns that path if whole results
/// are there that have not been reported yet.
///
/// # Errors
/// [`ResultsError`] where whole results cannot get their name: foreign files are there, or the file system refuses it.
pub(super) fn put_in_order(target: &Path) -> Result<Option<PathBuf>, ResultsError> {
    let partial = with_suffix(target, PARTIAL);
    let mut reported = clear_after(target);
    if reported {
        tidy_up(target);
    }
    if clear_after(&partial) {
        let _ = fs::remove_file(partial.join(LOCK_FILE));
    }
    for folder in partial_folders(target) {
        if in_use(&folder) || mark(&folder).is_none_or(|mark| mark != folder) {
            continue;
        }
        if marker(&folder).is_some_and(|marker| marker.complete) {
            check_replaceable(target)?;
            place(&folder, target)?;
            clear_after(target);
            tidy_up(target);
            reported = true;
        } else if check_replaceable(&partial).is_ok() && !in_use(&partial) && place(&folder, &partial).is_ok() {
            clear_after(&partial);
            let _ = fs::remove_file(partial.join(LOCK_FILE));
        }
    }
    Ok(reported.then(|| target.to_owned()))
}

/// Deletes the remainder of an older folder whose name this one has taken; true if there was such a move.
fn clear_after(folder: &Path) -> bool {
    let Some(before) = mark(folder).filter(|before| before != folder && !in_use(folder)) else { return false };
    for old in [aside(&before), before] {
        // A run that is or was in progress has a lock; an older folder has none.
        if old.is_dir() && !old.join(LOCK_FILE).exists() {
            let _ = flat_folder::remove(&old);
        }
    }
    true
}

/// Folder that a mark names: one beside it, of a run with the same final path.
fn mark(folder: &Path) -> Option<PathBuf> {
    let name = fs::read_to_string(folder.join(LOCK_FILE))
        .ok()
        .filter(|name| !name.is_empty() && !name.contains(['/', '\\']))?;
    let marked = folder.with_file_name(name);
    let target = final_name(folder).unwrap_or_else(|| folder.to_owned());
    (final_name(&marked)? == target).then_some(marked)
}

/// Part of a folder's summary that identifies it, if the folder is one of tyrewave's.
fn marker(folder: &Path) -> Option<Marker> {
    read_summary(folder).filter(|marker: &Marker| marker.format == FORMAT)
}

/// Accepts nothing, an empty folder, or an untouched results folder at `target`.
pub(super) fn check_replaceable(target: &Path) -> Result<(), ResultsError> {
    let present = match fs::symlink_metadata(target) {
        Ok(metadata) if metadata.is_dir() => entries(target).map_err(ResultsError::creating(target))?,
        Ok(_) => return Err(ResultsError::NotOurs { path: target.to_owned() }),
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(ResultsError::Create { path: target.to_owned(), source }),
    };
    if present.is_empty() {
        return Ok(());
    }
    let marker = marker(target).ok_or_else(|| ResultsError::NotOurs { path: target.to_owned() })?;
    // Whole results without a lock have no service files: a scene among them is a foreign file.
    let service = !marker.complete || target.join(LOCK_FILE).exists();
    let ours = |name: &String| {
        name == SUMMARY_FILE || marker.files.contains(name) || service && SERVICE_FILES.contains(&name.as_str())
    };
    match present.into_iter().find(|name| !ours(name)) {
        Some(entry) => Err(ResultsError::ForeignEntry { path: target.to_owned(), entry }),
        None => Ok(()),
    }
}

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
fn partial_folders(target: &Path) -> Vec<PathBuf> {
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

#[cfg(test)]
mod tests {
    use super::super::checkpoint;
    use super::super::folder::ResultsFolder;
    use super::super::folder::tests::names;
    use super::super::summary::Summary;
    use super::super::summary::tests::example;
    use super::*;

    /// A folder with a summary, a file of that content, optionally a lock with a mark, and a checkpoint if it is not
    /// complete.
    fn folder(path: &Path, content: &str, complete: bool, mark: Option<&str>) {
        fs::create_dir(path).unwrap();
        let files = vec!["force".to_owned(), SUMMARY_FILE.to_owned(), CHECKPOINT_FILE.to_owned()];
        let summary = Summary { complete, files, ..example() };
        fs::write(path.join(SUMMARY_FILE), summary.to_json(path).unwrap()).unwrap();
        fs::write(path.join("force"), content).unwrap();
        if let Some(mark) = mark {
            fs::write(path.join(LOCK_FILE), mark).unwrap();
        }
        if !complete {
            checkpoint::write(path, &content).unwrap();
        }
    }

    const NEW: &str = "run.partial-7";
    const OLD: &str = "run.partial-7-old";

    /// Every state in which a kill may leave the end of a run: name, content and mark of each folder.
    fn states() -> Vec<Vec<(&'static str, &'static str, Option<&'static str>)>> {
        vec![
            // Before the move, with and without older results.
            vec![(NEW, "new", Some(NEW))],
            vec![(NEW, "new", Some(NEW)), ("run", "old", None)],
            // Names exchanged, the older folder not deleted, half deleted, gone; service files left.
            vec![("run", "new", Some(NEW)), (NEW, "old", None)],
            vec![("run", "new", Some(NEW)), (NEW, "", None)],
            vec![("run", "new", Some(NEW))],
            // In two moves: after the first, after the second.
            vec![(NEW, "new", Some(NEW)), (OLD, "old", None)],
            vec![("run", "new", Some(NEW)), (OLD, "old", None)],
            vec![("run", "new", Some(NEW)), (OLD, "", None)],
        ]
    }

    /// Creates a state, with the final name `run` or, for an interrupted run, `run.partial`.
    fn set_up(place: &Path, state: &[(&str, &str, Option<&str>)], complete: bool) {
        for &(name, content, mark) in state {
            let name = if name == "run" && !complete { "run.partial" } else { name };
            match content {
                "" => {
                    fs::create_dir(place.join(name)).unwrap();
                    fs::write(place.join(name).join("force"), "half").unwrap();
                }
                _ => folder(&place.join(name), content, complete, mark),
            }
        }
    }

    #[test]
    fn every_state_that_a_kill_may_leave_is_put_in_order() {
        for state in states() {
            let place = tempfile::tempdir().unwrap();
            let target = place.path().join("run");
            set_up(place.path(), &state, true);
            assert_eq!(put_in_order(&target).unwrap().as_ref(), Some(&target), "{state:?}");
            assert_eq!(names(place.path()), ["run"], "{state:?}");
            assert_eq!(fs::read(target.join("force")).unwrap(), b"new", "{state:?}");
            assert_eq!(names(&target), ["force", "summary.json"], "{state:?}");
            assert_eq!(put_in_order(&target).unwrap(), None, "once");
        }
        for state in states() {
            // A new run to that path tidies up as well.
            let place = tempfile::tempdir().unwrap();
            let target = place.path().join("run");
            set_up(place.path(), &state, true);
            drop(ResultsFolder::create(&target).unwrap());
            assert_eq!(names(place.path()), ["run"], "{state:?}");
        }
    }

    #[test]
    fn so_is_every_state_of_an_interrupted_run() {
        for state in states() {
            let place = tempfile::tempdir().unwrap();
            let target = place.path().join("run");
            folder(&target, "finished before", true, None);
            set_up(place.path(), &state, false);
            assert_eq!(put_in_order(&target).unwrap(), None);
            assert_eq!(names(place.path()), ["run", "run.partial"], "{state:?}");
            let again = ResultsFolder::reopen(&target).unwrap();
            assert_eq!(fs::read(again.path("force")).unwrap(), b"new", "{state:?}");
            assert_eq!(fs::read(target.join("force")).unwrap(), b"finished before");
        }
    }

    #[test]
    fn a_scene_put_into_finished_results_is_foreign() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("run");
        folder(&target, "old", true, None);
        fs::write(target.join(SCENE_FILE), "somebody's").unwrap();
        assert!(
            matches!(check_replaceable(&target), Err(ResultsError::ForeignEntry { entry, .. }) if entry == SCENE_FILE)
        );
        fs::write(target.join(LOCK_FILE), "").unwrap();
        check_replaceable(&target).unwrap();
    }

    #[test]
    fn busy_unmarked_and_foreign_folders_are_left_alone() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("run");
        // A folder renamed by the user, a run that was killed, one that goes on, and a mark that points elsewhere.
        folder(&place.path().join("run.partial-kept"), "kept", true, None);
        folder(&place.path().join("run.partial-1"), "killed", false, Some(""));
        let working = ResultsFolder::create(&target).unwrap();
        fs::write(working.path(LOCK_FILE), working.working().file_name().unwrap().to_str().unwrap()).unwrap();
        for wrong in ["../thesis", "thesis", "other.partial-1"] {
            folder(&target, "old", true, Some(wrong));
            let before = names(place.path());
            assert_eq!(put_in_order(&target).unwrap(), None);
            assert_eq!(names(place.path()), before, "{wrong}");
            fs::remove_dir_all(&target).unwrap();
        }
        // Whole results do not get a name under which there are foreign files.
        folder(&place.path().join(NEW), "new", true, Some(NEW));
        folder(&target, "old", true, None);
        fs::write(target.join("notes.txt"), "precious").unwrap();
        assert!(matches!(put_in_order(&target), Err(ResultsError::ForeignEntry { .. })));
        assert_eq!(fs::read(place.path().join(NEW).join("force")).unwrap(), b"new");
        drop(working);
    }
}
