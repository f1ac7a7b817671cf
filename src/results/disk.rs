//! Operations of the file system that keep results safe.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::error::ResultsError;

/// Writes a file and brings it to the disk.
pub(super) fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ResultsError> {
    let mut file = File::create(path).map_err(ResultsError::creating(path))?;
    file.write_all(bytes).and_then(|()| file.sync_all()).map_err(ResultsError::writing(path))
}

/// Gives `working` the name `target`; returns the path at which an older `target` is now, which may be deleted.
pub(super) fn replace(working: &Path, target: &Path) -> Result<Option<PathBuf>, ResultsError> {
    let old = if fs::symlink_metadata(target).is_err() {
        rename(working, target)?;
        None
    } else if exchange(working, target).is_ok() {
        Some(working.to_owned())
    } else {
        Some(replace_in_two(working, target)?)
    };
    // The new results are in place: a failure from here on does not concern them.
    if let Some(parent) = target.parent().filter(|parent| !parent.as_os_str().is_empty()) {
        let _ = sync_folder(parent);
    }
    Ok(old)
}

/// Temporary name of an older folder that is being replaced.
pub(super) fn aside(working: &Path) -> PathBuf {
    with_suffix(working, "-old")
}

/// The same where names cannot be exchanged: the old folder steps aside, and gets its name back on failure. Between the
/// two renames nothing has the name.
fn replace_in_two(working: &Path, target: &Path) -> Result<PathBuf, ResultsError> {
    let aside = aside(working);
    rename(target, &aside)?;
    if let Err(error) = rename(working, target) {
        rename(&aside, target)?;
        return Err(error);
    }
    Ok(aside)
}

fn rename(from: &Path, to: &Path) -> Result<(), ResultsError> {
    fs::rename(from, to).map_err(|source| ResultsError::Rename { from: from.to_owned(), to: to.to_owned(), source })
}

/// Exchanges two names atomically: at no moment is either of them missing.
#[cfg(any(target_os = "linux", target_os = "macos"))]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

/// Not supported here; the same error as on file systems without it.
#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Parents of `target` that do not exist, innermost first.
pub(super) fn missing_parents(target: &Path) -> Vec<PathBuf> {
    target
        .ancestors()
        .skip(1)
        .take_while(|parent| !parent.as_os_str().is_empty() && !parent.exists())
        .map(Path::to_owned)
        .collect()
}

pub(super) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name: OsString = path.file_name().unwrap_or(OsStr::new("results")).to_owned();
    name.push(suffix);
    path.with_file_name(name)
}

/// Brings the names in a folder to the disk, where the system can do that.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::flat_folder::entries;

    #[test]
    fn a_folder_takes_the_place_of_another_at_once_or_in_two_moves() {
        let place = tempfile::tempdir().unwrap();
        let (new, old) = (place.path().join("run.partial-1"), place.path().join("run"));
        let folder = |path: &Path, content: &str| {
            fs::create_dir(path).unwrap();
            fs::write(path.join("force"), content).unwrap();
        };
        for at_once in [true, false] {
            let way = |working: &Path, target: &Path| match at_once {
                true => replace(working, target),
                false => replace_in_two(working, target).map(Some),
            };
            folder(&new, "new");
            folder(&old, "old");
            let older = way(&new, &old).unwrap().unwrap();
            assert_eq!(fs::read(old.join("force")).unwrap(), b"new");
            assert_eq!(fs::read(older.join("force")).unwrap(), b"old");
            assert_eq!(entries(place.path()).unwrap().len(), 2);
            // Without anything to move the older one keeps its name.
            let error = way(&place.path().join("none"), &old).unwrap_err();
            assert!(matches!(error, ResultsError::Rename { .. }));
            assert_eq!(fs::read(old.join("force")).unwrap(), b"new");
            fs::remove_dir_all(&older).unwrap();
            fs::remove_dir_all(&old).unwrap();
        }
    }
}
