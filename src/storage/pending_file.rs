//! Files that are complete or absent.

use std::fs::{self, File};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// A file that gets its name when it is complete. It is begun before a long computation, so that a place that cannot be
/// written to is reported at once. Dropped before that, it leaves nothing.
#[derive(Debug)]
pub struct PendingFile {
    path: PathBuf,
    temporary: PathBuf,
}

impl PendingFile {
    /// Creates the file under a temporary name, unique to this writer; what stood under its final name before stays
    /// until the file is complete.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn create(path: &Path) -> io::Result<Self> {
        // Files of a process differ by a count, processes by a number that the standard library draws at random for
        // each of them: process ids would not do, as machines that share a disk may have processes of the same id.
        static PROCESS: LazyLock<u64> = LazyLock::new(|| RandomState::new().hash_one(0));
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        Self::create_as(path, &format!(".{:016x}-{count}.tmp", *PROCESS))
    }

    /// Creates a file as [`Self::create`], its temporary name being the final one with `suffix` appended: for a file
    /// that only one process can write.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn create_as(path: &Path, suffix: &str) -> io::Result<Self> {
        if path.is_dir() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(suffix);
        let temporary = path.with_file_name(name);
        File::create(&temporary)?;
        Ok(Self { path: path.to_owned(), temporary })
    }

    /// The final path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path until it is complete.
    pub fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// Writes the content, brings it to the disk, then gives the file its name.
    ///
    /// # Errors
    /// Errors of the file system; the temporary file is removed then.
    pub fn complete(self, content: impl AsRef<[u8]>) -> io::Result<()> {
        let mut file = File::create(&self.temporary)?;
        file.write_all(content.as_ref())?;
        file.sync_all()?;
        self.publish()
    }

    /// Gives the file its name; its content must have been brought to the disk before.
    ///
    /// # Errors
    /// Errors of the file system; the temporary file is removed then.
    pub fn publish(self) -> io::Result<()> {
        fs::rename(&self.temporary, &self.path)
    }
}

impl Drop for PendingFile {
    fn drop(&mut self) {
        // There is none where it was completed.
        let _ = fs::remove_file(&self.temporary);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_takes_its_name_only_when_it_is_complete() {
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
            assert!(PendingFile::create(&wrong).is_err(), "{}", wrong.display());
        }
    }

    #[test]
    fn processes_of_one_id_on_two_machines_do_not_write_to_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let of = || PendingFile::create(&folder.path().join("table.csv")).unwrap();
        let (one, other) = (of(), of());
        assert_ne!(one.temporary(), other.temporary());
        let name = one.temporary().file_name().unwrap().to_string_lossy().into_owned();
        assert!(!name.contains(&format!(".{}-", std::process::id())), "{name}");
    }
}
