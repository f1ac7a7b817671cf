//! Steps on the file system that results are kept safe by.

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

/// Gives `working` the name `target`; what stood there is deleted after that, or gets its name back on failure.
pub(super) fn replace(working: &Path, target: &Path) -> Result<(), ResultsError> {
    let rename = |from: &Path, to: &Path| {
        fs::rename(from, to).map_err(|source| ResultsError::Rename { from: from.to_owned(), to: to.to_owned(), source })
    };
    let old = if fs::symlink_metadata(target).is_ok() {
        let aside = with_suffix(working, "-old");
        rename(target, &aside)?;
        Some(aside)
    } else {
        None
    };
    if let Err(error) = rename(working, target) {
        if let Some(aside) = old {
            rename(&aside, target)?;
        }
        return Err(error);
    }
    // The new results are in place: trouble from here on is none of theirs.
    if let Some(parent) = target.parent().filter(|parent| !parent.as_os_str().is_empty()) {
        let _ = sync_folder(parent);
    }
    if let Some(aside) = old {
        let _ = fs::remove_dir_all(aside);
    }
    Ok(())
}

/// Names of what is in a folder.
pub(super) fn entries(folder: &Path) -> io::Result<Vec<String>> {
    fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
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

/// A path with more at the end of its name.
pub(super) fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name: OsString = path.file_name().unwrap_or(OsStr::new("results")).to_owned();
    name.push(suffix);
    path.with_file_name(name)
}

/// Brings the names in a folder to the disk, where the system can do that.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}
