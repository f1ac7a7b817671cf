//! Folders of files: what is in them, and their end.
//!
//! The standard library's way to list a folder panics where the system cannot close it again, which a broken disk or
//! network may bring about; here that is nothing.

use std::fs;
use std::io;
use std::path::Path;

/// Names of what is in a folder.
///
/// # Errors
/// Errors of the file system.
#[cfg(unix)]
pub fn entries(folder: &Path) -> io::Result<Vec<String>> {
    use rustix::fs::{Dir, DirEntry, Mode, OFlags, open};
    let opened = open(folder, OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC, Mode::empty())?;
    let name = |entry: rustix::io::Result<DirEntry>| Ok(entry?.file_name().to_string_lossy().into_owned());
    let names: io::Result<Vec<String>> = Dir::new(opened)?.map(name).collect();
    names.map(|names| names.into_iter().filter(|name| name != "." && name != "..").collect())
}

/// Names of what is in a folder.
///
/// # Errors
/// Errors of the file system.
#[cfg(not(unix))]
pub fn entries(folder: &Path) -> io::Result<Vec<String>> {
    fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
}

/// Deletes a folder with all files in it; one that holds a folder stays, with that folder in it. An empty one need not
/// be listed.
///
/// # Errors
/// Errors of the file system.
pub fn remove(folder: &Path) -> io::Result<()> {
    for name in entries(folder).unwrap_or_default() {
        let _ = fs::remove_file(folder.join(name));
    }
    fs::remove_dir(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_listed_and_removed_unless_it_holds_another() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("run");
        fs::create_dir_all(folder.join("thesis")).unwrap();
        fs::write(folder.join("time.npy"), "").unwrap();
        let mut names = entries(&folder).unwrap();
        names.sort();
        assert_eq!(names, ["thesis", "time.npy"]);
        assert!(remove(&folder).is_err());
        assert_eq!(entries(&folder).unwrap(), ["thesis"]);
        fs::remove_dir(folder.join("thesis")).unwrap();
        remove(&folder).unwrap();
        assert_eq!(entries(&folder).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
