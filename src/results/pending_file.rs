//! Files that are whole or not there.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::error::ResultsError;

/// A file that takes its name when it is complete. Begun before a long work, so that a place that cannot be written to
/// is refused at once.
#[derive(Debug)]
pub struct PendingFile {
    path: PathBuf,
    temporary: PathBuf,
}

impl PendingFile {
    /// Begins the file; nothing stands under its name yet, or what stood there before.
    ///
    /// # Errors
    /// [`ResultsError::Create`].
    pub fn create(path: &Path) -> Result<Self, ResultsError> {
        if path.is_dir() {
            return Err(ResultsError::creating(path)(std::io::ErrorKind::IsADirectory.into()));
        }
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".{}.tmp", std::process::id()));
        let temporary = path.with_file_name(name);
        File::create(&temporary).map_err(ResultsError::creating(path))?;
        Ok(Self { path: path.to_owned(), temporary })
    }

    /// Completes the file.
    ///
    /// # Errors
    /// [`ResultsError::Write`]; nothing is left of it then.
    pub fn complete(self, text: &str) -> Result<(), ResultsError> {
        File::create(&self.temporary)
            .and_then(|mut file| file.write_all(text.as_bytes()).and_then(|()| file.sync_all()))
            .and_then(|()| fs::rename(&self.temporary, &self.path))
            .map_err(ResultsError::writing(&self.path))
    }
}

impl Drop for PendingFile {
    fn drop(&mut self) {
        // It is gone already where it was completed.
        let _ = fs::remove_file(&self.temporary);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_takes_its_name_when_it_is_complete_and_leaves_nothing_otherwise() {
        let folder = tempfile::tempdir().unwrap();
        let names = || fs::read_dir(folder.path()).unwrap().count();
        let path = folder.path().join("trace.json");
        let pending = PendingFile::create(&path).unwrap();
        assert!(!path.exists() && names() == 1);
        drop(pending);
        assert_eq!(names(), 0);
        PendingFile::create(&path).unwrap().complete("{}").unwrap();
        assert_eq!((fs::read_to_string(&path).unwrap().as_str(), names()), ("{}", 1));
        for wrong in [folder.path().to_owned(), folder.path().join("none/trace.json")] {
            assert!(matches!(PendingFile::create(&wrong), Err(ResultsError::Create { .. })), "{}", wrong.display());
        }
    }
}
