//! Files to be written that are named on the command line.
//!
//! The rule: an output replaces an earlier output of its kind, recognised by its beginning, or an empty file. A scene,
//! a device, a link, other files stay. Where a kind cannot be recognised by its beginning, an option of the user
//! permits the replacement of a file, but never of an input.

use std::fs::{self, File, Metadata};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use crate::results::ResultsError;
use crate::storage::PendingFile;

use super::error::CliError;

/// Files that may be replaced.
#[derive(Clone, Copy, Debug)]
pub(super) enum Replaces<'a> {
    /// Files that begin like this.
    Beginning(&'static str),
    /// Any file but the inputs.
    AllBut(&'a [&'a Path]),
    /// Nothing; holds the option that would permit it.
    Nothing(&'static str),
}

/// A file that gets its name when it is complete.
#[derive(Debug)]
pub(super) struct OutputFile<'a> {
    file: PendingFile,
    replaces: Replaces<'a>,
}

impl<'a> OutputFile<'a> {
    /// Creates it before any work is done: a name that is taken or cannot be written to is refused now.
    ///
    /// # Errors
    /// [`CliError::Usage`] for what must not be replaced, [`ResultsError::Create`].
    pub(super) fn begin(path: &Path, replaces: Replaces<'a>) -> Result<Self, CliError> {
        check(path, replaces)?;
        let file = PendingFile::create(path).map_err(ResultsError::creating(path))?;
        Ok(Self { file, replaces })
    }

    /// Path at which another writer may put the content, before [`Self::publish`].
    pub(super) fn temporary(&self) -> &Path {
        self.file.temporary()
    }

    /// Writes the content and gives the file its name.
    ///
    /// # Errors
    /// [`CliError::Usage`] for a file that has appeared meanwhile and must not be replaced, [`ResultsError::Write`].
    pub(super) fn complete(self, content: &(impl AsRef<[u8]> + ?Sized)) -> Result<(), CliError> {
        let path = self.file.path().to_owned();
        check(&path, self.replaces)?;
        Ok(self.file.complete(content).map_err(ResultsError::writing(&path))?)
    }

    /// Gives the file its name; its content must be complete and on the disk.
    ///
    /// # Errors
    /// As [`Self::complete`].
    pub(super) fn publish(self) -> Result<(), CliError> {
        let path = self.file.path().to_owned();
        check(&path, self.replaces)?;
        Ok(self.file.publish().map_err(ResultsError::writing(&path))?)
    }
}

/// Creates two files, as far as they are wanted, that replace what begins like them; the same name twice is refused.
///
/// # Errors
/// As [`OutputFile::begin`].
pub(super) fn begin_both(
    files: [(Option<PathBuf>, &'static str); 2],
) -> Result<[Option<OutputFile<'static>>; 2], CliError> {
    let [(one, head_of_one), (other, head_of_other)] = files;
    check_apart(one.as_deref(), other.as_deref())?;
    let begin = |path: Option<PathBuf>, head: &'static str| {
        path.map(|path| OutputFile::begin(&path, Replaces::Beginning(head))).transpose()
    };
    Ok([begin(one, head_of_one)?, begin(other, head_of_other)?])
}

/// Refuses two outputs with the same name.
fn check_apart(one: Option<&Path>, other: Option<&Path>) -> Result<(), CliError> {
    match one.zip(other) {
        Some((one, other)) if place(one) == place(other) => {
            Err(CliError::Usage(format!("{} is named twice as a file to be written", one.display())))
        }
        _ => Ok(()),
    }
}

/// Canonical path of the folder, joined with the file's name; the file need not exist.
fn place(path: &Path) -> Option<PathBuf> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some(fs::canonicalize(parent).ok()?.join(path.file_name()?))
}

/// Refuses a path where something stands that must not be replaced.
pub(super) fn check(path: &Path, replaces: Replaces<'_>) -> Result<(), CliError> {
    let present = match fs::symlink_metadata(path) {
        Ok(present) => present,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(CliError::Read { path: path.to_owned(), source }),
    };
    let refused = |why: &str| Err(CliError::Usage(format!("{} {why}; it is left alone", path.display())));
    if !present.is_file() {
        return refused("is not a regular file");
    }
    match replaces {
        Replaces::AllBut(inputs) if inputs.iter().any(|input| is_same(path, &present, input)) => refused("is an input"),
        Replaces::AllBut(_) => Ok(()),
        _ if present.len() == 0 => Ok(()),
        Replaces::Beginning(head) if begins_with(path, head) => Ok(()),
        Replaces::Beginning(_) => refused("exists and is not an earlier output of this kind"),
        Replaces::Nothing(option) => refused(&format!("exists ({option} would replace it)")),
    }
}

fn begins_with(path: &Path, head: &str) -> bool {
    let mut found = vec![0; head.len()];
    File::open(path).and_then(|mut file| file.read_exact(&mut found)).is_ok() && found == head.as_bytes()
}

fn is_same(path: &Path, present: &Metadata, other: &Path) -> bool {
    #[cfg(unix)]
    if let Ok(other) = fs::metadata(other) {
        use std::os::unix::fs::MetadataExt;
        return (present.dev(), present.ino()) == (other.dev(), other.ino());
    }
    let _ = present;
    matches!((fs::canonicalize(path), fs::canonicalize(other)), (Ok(one), Ok(two)) if one == two)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_earlier_outputs_and_empty_files_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.json");
        let head = Replaces::Beginning("{\"trace\"");
        let write = |text: &str| OutputFile::begin(&path, head).and_then(|file| file.complete(text));
        write("{\"trace\": 1}").unwrap();
        write("{\"trace\": 2}").unwrap();
        fs::write(&path, "").unwrap();
        write("{\"trace\": 3}").unwrap();
        for text in ["title = \"a scene\"", "{", "{\"record\": 1}"] {
            fs::write(&path, text).unwrap();
            let error = write("{\"trace\": 4}").unwrap_err();
            assert!(matches!(&error, CliError::Usage(why) if why.contains("trace.json") && why.contains("left alone")));
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        // A file that appears later is as safe.
        fs::remove_file(&path).unwrap();
        let begun = OutputFile::begin(&path, head).unwrap();
        fs::write(&path, "notes").unwrap();
        assert!(matches!(begun.complete("{\"trace\": 5}"), Err(CliError::Usage(_))));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(OutputFile::begin(folder.path(), head).is_err());
    }

    #[test]
    fn an_input_is_never_replaced_by_whatever_name_it_has() {
        let folder = tempfile::tempdir().unwrap();
        let [input, other, again] = ["heights.npy", "other.npy", "again.npy"].map(|name| folder.path().join(name));
        fs::write(&input, "heights").unwrap();
        fs::write(&other, "others").unwrap();
        fs::hard_link(&input, &again).unwrap();
        let below = folder.path().join("./heights.npy");
        for path in [&input, &again, &below] {
            assert!(OutputFile::begin(path, Replaces::AllBut(&[&other, &input])).is_err(), "{}", path.display());
        }
        assert!(OutputFile::begin(&other, Replaces::Nothing("--force")).is_err());
        OutputFile::begin(&other, Replaces::AllBut(&[&input])).unwrap().complete("new").unwrap();
        assert_eq!((fs::read(&input).unwrap(), fs::read(&other).unwrap()), (b"heights".to_vec(), b"new".to_vec()));
        assert!(check_apart(Some(&input), Some(&below)).is_err() && check_apart(Some(&input), Some(&other)).is_ok());
    }

    #[test]
    #[cfg(unix)]
    fn devices_and_links_are_no_files() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("nowhere", &link).unwrap();
        for path in [link.as_path(), Path::new("/dev/null")] {
            let error = OutputFile::begin(path, Replaces::Beginning("")).unwrap_err();
            assert!(error.to_string().contains("not a regular file"), "{error}");
        }
    }
}
