//! Folders of files: listing, access by untrusted names, and removal.
//!
//! The standard library's listing of a folder panics where the system cannot close it again, which a broken disk or
//! network may cause; the listing here ignores that.

use std::ffi::OsStr;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Names of everything in a folder, in the order of the file system, without `.` and `..`.
///
/// # Errors
/// Errors of the file system.
#[cfg(unix)]
pub(crate) fn entries(folder: &Path) -> io::Result<Vec<String>> {
    use rustix::fs::{Dir, DirEntry, Mode, OFlags, open};
    let opened = open(folder, OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC, Mode::empty())?;
    let name = |entry: rustix::io::Result<DirEntry>| Ok(entry?.file_name().to_string_lossy().into_owned());
    let names: io::Result<Vec<String>> = Dir::new(opened)?.map(name).collect();
    names.map(|names| names.into_iter().filter(|name| name != "." && name != "..").collect())
}

/// Names of everything in a folder, in the order of the file system.
///
/// # Errors
/// Errors of the file system.
#[cfg(not(unix))]
pub fn entries(folder: &Path) -> io::Result<Vec<String>> {
    fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
}

/// Path of a file in a folder, by a name that may come from an untrusted source: it must lead to no other folder, and
/// to no link. `None` if there is no such file.
///
/// # Errors
/// [`ErrorKind::InvalidInput`] for any other name and for a link; errors of the file system.
pub(crate) fn file(folder: &Path, name: &str) -> io::Result<Option<PathBuf>> {
    entry(folder, name, fs::Metadata::is_file)
}

/// Path of a folder in a folder, by a name restricted as that of a [`file`].
///
/// # Errors
/// As [`file`].
pub(crate) fn subfolder(folder: &Path, name: &str) -> io::Result<Option<PathBuf>> {
    entry(folder, name, fs::Metadata::is_dir)
}

fn entry(folder: &Path, name: &str, is_wanted: fn(&fs::Metadata) -> bool) -> io::Result<Option<PathBuf>> {
    let refused = |why| Err(io::Error::new(ErrorKind::InvalidInput, why));
    if Path::new(name).file_name() != Some(OsStr::new(name)) {
        return refused("it is not the name of a file in this folder, and nothing outside of it is read");
    }
    let path = folder.join(name);
    match fs::symlink_metadata(&path) {
        Ok(found) if found.is_symlink() => refused("it is a link, and links are not followed here"),
        Ok(found) => Ok(is_wanted(&found).then_some(path)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// Refuses a folder with a link in it, through which a foreign file could be overwritten.
///
/// # Errors
/// [`ErrorKind::InvalidInput`], which names the link; errors of the file system.
pub(crate) fn without_links(folder: &Path) -> io::Result<()> {
    for name in entries(folder)? {
        if fs::symlink_metadata(folder.join(&name)).is_ok_and(|found| found.is_symlink()) {
            let why = format!("{name} in it is a link, and links are not followed here");
            return Err(io::Error::new(ErrorKind::InvalidInput, why));
        }
    }
    Ok(())
}

/// Deletes a folder with all files in it; if it contains a folder, both stay. An empty folder is removed even if it
/// cannot be listed.
///
/// # Errors
/// Errors of the file system.
pub(crate) fn remove(folder: &Path) -> io::Result<()> {
    for name in entries(folder).unwrap_or_default() {
        let _ = fs::remove_file(folder.join(name));
    }
    fs::remove_dir(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_to_files_in_the_folder_and_nowhere_else() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("run");
        fs::create_dir_all(folder.join("deeper")).unwrap();
        let secret = place.path().join("secret");
        for path in [&secret, &folder.join("time.npy"), &folder.join("deeper/file")] {
            fs::write(path, "").unwrap();
        }
        assert_eq!(file(&folder, "time.npy").unwrap(), Some(folder.join("time.npy")));
        for none in ["none", "deeper"] {
            assert_eq!(file(&folder, none).unwrap(), None, "{none}");
        }
        assert_eq!(subfolder(&folder, "deeper").unwrap(), Some(folder.join("deeper")));
        assert_eq!(subfolder(&folder, "time.npy").unwrap(), None);
        assert_eq!(subfolder(&folder, "../run").unwrap_err().kind(), ErrorKind::InvalidInput);
        let absolute = secret.to_string_lossy();
        let names = ["", ".", "..", "../secret", "deeper/file", "time.npy/", "deeper/../time.npy", &absolute];
        for name in names {
            assert_eq!(file(&folder, name).unwrap_err().kind(), ErrorKind::InvalidInput, "{name}");
        }
        without_links(&folder).unwrap();
        #[cfg(unix)]
        for target in ["../secret", "time.npy", "nothing"] {
            let link = folder.join("link");
            std::os::unix::fs::symlink(target, &link).unwrap();
            for found in [file(&folder, "link"), subfolder(&folder, "link")] {
                assert!(found.unwrap_err().to_string().contains("link"), "{target}");
            }
            assert!(without_links(&folder).unwrap_err().to_string().starts_with("link in it"), "{target}");
            fs::remove_file(link).unwrap();
        }
    }

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
