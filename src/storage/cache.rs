//! Results that take long, stored on disk for the next run.
//!
//! An entry is a sealed file `<key>.<extension>`, the extension that of its kind and the key a SHA-256 of everything
//! that the value depends on, the version of its kind included. It gets its name when it is complete, so a reader sees
//! all of an entry or nothing, and two processes may store the same one at once.
//!
//! An unusable entry (truncated, damaged, another version, another key) is no error: the caller gets the reason, makes
//! the value again and replaces it. When the entries exceed the size limit the least recently used ones are removed
//! first, including those left by older versions. The limit follows the free space on the disk: a solved sound takes a
//! gigabyte, and a sweep comes back to those of all its speeds.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::flat_folder::entries;
use super::pending_file::PendingFile;
use super::sealed_file::{Body, Format, Unusable};
use crate::numeric::digest::hexadecimal;

/// Limit of the size of all entries together \[bytes\]: the least, allowed on any disk, and the greatest.
const BOUNDS: [u64; 2] = [2 << 30, 32 << 30];
/// Entries may fill one part in so many of the disk's free space, their present size added to it.
const SHARE_OF_FREE_SPACE: u64 = 8;

/// Reason why the cache cannot be used.
#[derive(Debug, Error)]
pub enum CacheError {
    /// No folder: the environment names none and the platform's is unknown.
    #[error("no cache folder: set TYREWAVE_CACHE_DIR")]
    NoFolder,
    /// The folder or an entry cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder that failed.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
}

impl CacheError {
    /// Converts an error of the file system at a path, for `map_err`.
    fn of(path: &Path) -> impl Fn(std::io::Error) -> Self + use<'_> {
        |source| Self::Io { path: path.to_owned(), source }
    }
}

/// A kind of entry: its file name extension and its format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CacheKind {
    /// Extension of its files, without the dot.
    pub extension: &'static str,
    /// Their format. Its version is also that of the algorithm: raise it whenever the same input may give another
    /// value.
    pub format: Format,
}

/// A value that the cache keeps.
pub trait Cached: Serialize + DeserializeOwned {
    /// File extension and format of such values.
    const KIND: CacheKind;

    /// True if a value that was read is valid, as all its numbers being finite.
    fn is_valid(&self) -> bool;
}

/// Key of a value: SHA-256 over the version of its kind and all that it depends on, in JSON (numbers are written with
/// all digits).
///
/// # Errors
/// If the content cannot be written as JSON.
pub(crate) fn key<T: Cached>(content: &impl Serialize) -> serde_json::Result<[u8; 32]> {
    Ok(Sha256::digest(serde_json::to_vec(&(T::KIND.format.version, content))?).into())
}

/// One entry, as listed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CacheEntry {
    /// The entry's file.
    pub path: PathBuf,
    /// Size of the file \[bytes\].
    pub bytes: u64,
    /// Usability: complete, of this version, with the right checksum.
    pub(crate) usable: Result<(), Unusable>,
}

/// An entry's file, not yet checked.
struct EntryFile {
    /// When it was last read or written.
    used: SystemTime,
    path: PathBuf,
    bytes: u64,
}

/// A folder of entries with a bounded total size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cache {
    folder: PathBuf,
    /// Largest size of all entries together \[bytes\]; `None`: according to the free space on the disk.
    limit: Option<u64>,
}

impl Cache {
    /// The user's cache: `TYREWAVE_CACHE_DIR`, else a folder in the platform's cache folder (`XDG_CACHE_HOME`,
    /// `LOCALAPPDATA`, `~/Library/Caches`, `~/.cache`). Its limit follows the free space on the disk.
    ///
    /// # Errors
    /// [`CacheError::NoFolder`] if none of these is known.
    pub fn open() -> Result<Self, CacheError> {
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let subfolder = |base: PathBuf| base.join("tyrewave");
        let home = |below: &str| variable("HOME").map(|home| home.join(below));
        let platform = if cfg!(target_os = "macos") { home("Library/Caches") } else { home(".cache") };
        variable("TYREWAVE_CACHE_DIR")
            .or_else(|| variable("XDG_CACHE_HOME").map(subfolder))
            .or_else(|| variable("LOCALAPPDATA").map(subfolder))
            .or_else(|| platform.map(subfolder))
            .map(|folder| Self { folder, limit: None })
            .ok_or(CacheError::NoFolder)
    }

    /// A cache in a given folder, bounded to `limit` bytes.
    pub fn at(folder: PathBuf, limit: u64) -> Self {
        Self { folder, limit: Some(limit) }
    }

    /// The folder of the entries; it need not exist.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// File of the entry with this key, whether it exists or not.
    pub fn path<T: Cached>(&self, key: &[u8; 32]) -> PathBuf {
        self.folder.join(hexadecimal(key)).with_extension(T::KIND.extension)
    }

    /// Reads an entry, which counts as its use; `None` if there is none.
    ///
    /// # Errors
    /// If the file exists and cannot be read.
    pub fn load<T: Cached>(&self, key: &[u8; 32]) -> Result<Option<Result<T, Unusable>>, CacheError> {
        let path = self.path::<T>(key);
        let body = match T::KIND.format.read(&path) {
            Ok(body) => body,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(CacheError::of(&path)(error)),
        };
        // Where the time cannot be set the entry is only dropped earlier than it should be.
        let _ = File::options().append(true).open(&path).and_then(|file| file.set_modified(SystemTime::now()));
        Ok(Some(body.and_then(|body| value(body, key))))
    }

    /// Writes an entry and drops the least recently used ones beyond the size limit.
    ///
    /// # Errors
    /// [`CacheError::Io`] for a folder or file that cannot be written.
    pub fn store<T: Cached>(&self, key: &[u8; 32], value: &T) -> Result<(), CacheError> {
        let path = self.path::<T>(key);
        fs::create_dir_all(&self.folder).map_err(CacheError::of(&self.folder))?;
        let file = PendingFile::create(&path).map_err(CacheError::of(&path))?;
        T::KIND.format.write(file, &(key, value)).map_err(CacheError::of(&path))?;
        self.shrink(&path)
    }

    /// Reads a value if its entry is there and valid, else makes and stores it. Trouble with the cache only ever gives
    /// warnings.
    ///
    /// # Errors
    /// Errors of making the value.
    pub fn fetch<T: Cached, E>(
        &self,
        key: &[u8; 32],
        warnings: &mut Vec<String>,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        if let Some(value) = self.get(key, warnings) {
            return Ok(value);
        }
        let value = make()?;
        self.keep(key, &value, warnings);
        Ok(value)
    }

    /// Value of an entry that is there and valid; an unusable entry or an unreadable cache gives a warning.
    pub fn get<T: Cached>(&self, key: &[u8; 32], warnings: &mut Vec<String>) -> Option<T> {
        match self.load(key) {
            Ok(Some(Ok(value))) => return Some(value),
            Ok(Some(Err(reason))) => {
                warnings.push(format!("cache entry {} is rebuilt: {reason}", self.path::<T>(key).display()));
            }
            Ok(None) => {}
            Err(error) => warnings.push(format!("cache not read: {error}")),
        }
        None
    }

    /// Stores a value; where that fails there is a warning.
    pub fn keep<T: Cached>(&self, key: &[u8; 32], value: &T, warnings: &mut Vec<String>) {
        if let Err(error) = self.store(key, value) {
            warnings.push(format!("cache not written: {error}"));
        }
    }

    /// Drops the least recently used entries until the rest fits the limit; the one just written stays in any case.
    fn shrink(&self, keep: &Path) -> Result<(), CacheError> {
        let mut entries = self.files()?;
        entries.sort_by(|a, b| (a.used, &a.path).cmp(&(b.used, &b.path)));
        let mut total: u64 = entries.iter().map(|entry| entry.bytes).sum();
        let limit = self.limit.unwrap_or_else(|| limit_by_free_space(total, free_bytes(&self.folder)));
        for EntryFile { path, bytes, .. } in entries {
            if total <= limit {
                break;
            }
            if path != keep {
                remove(&path)?;
                total -= bytes;
            }
        }
        Ok(())
    }

    /// Files of all entries, of whatever kind, known by names that are keys.
    fn files(&self) -> Result<Vec<EntryFile>, CacheError> {
        let names = match entries(&self.folder) {
            Ok(names) => names,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(CacheError::of(&self.folder)(error)),
        };
        let is_key = |name: &str| name.len() == 64 && name.bytes().all(|byte| byte.is_ascii_hexdigit());
        let mut files = Vec::new();
        for name in names {
            let path = self.folder.join(name);
            if path.file_stem().and_then(|stem| stem.to_str()).is_some_and(is_key) {
                // Another process may have dropped it meanwhile.
                let Ok(metadata) = fs::metadata(&path) else { continue };
                let used = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                files.push(EntryFile { used, path, bytes: metadata.len() });
            }
        }
        Ok(files)
    }

    /// All entries, checked, sorted by path; those of none of these kinds are listed as foreign.
    ///
    /// # Errors
    /// [`CacheError::Io`] for a folder that cannot be read.
    pub fn list(&self, kinds: &[CacheKind]) -> Result<Vec<CacheEntry>, CacheError> {
        let check = |path: &Path| {
            let extension = path.extension().unwrap_or_default();
            let kind = kinds.iter().find(|kind| extension == kind.extension);
            let kind = kind.ok_or(Unusable::Foreign { wanted: "an entry of this program" })?;
            kind.format.read(path).unwrap_or(Err(Unusable::Damaged)).map(|_| ())
        };
        let entries = self.files()?.into_iter();
        let mut entries: Vec<CacheEntry> =
            entries.map(|EntryFile { path, bytes, .. }| CacheEntry { usable: check(&path), path, bytes }).collect();
        entries.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(entries)
    }

    /// Removes all entries that can be removed; returns how many, and why others stayed. Other files in the folder
    /// stay.
    ///
    /// # Errors
    /// [`CacheError::Io`] of a folder that cannot be read.
    pub fn clear(&self) -> Result<(usize, Vec<CacheError>), CacheError> {
        let files = self.files()?;
        let failed: Vec<CacheError> = files.iter().filter_map(|file| remove(&file.path).err()).collect();
        Ok((files.len() - failed.len(), failed))
    }
}

fn remove(path: &Path) -> Result<(), CacheError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(CacheError::of(path)(error)),
        _ => Ok(()),
    }
}

/// Value in the body of an entry, if the entry has the right key and the value is valid.
fn value<T: Cached>(mut body: Body, key: &[u8; 32]) -> Result<T, Unusable> {
    if body.take::<[u8; 32]>()? != *key {
        return Err(Unusable::Key);
    }
    body.finish().and_then(|value: T| if value.is_valid() { Ok(value) } else { Err(Unusable::Damaged) })
}

/// Limit \[bytes\] for entries that take `entries` bytes on a disk with `free` free ones, if those are known.
fn limit_by_free_space(entries: u64, free: Option<u64>) -> u64 {
    let [least, most] = BOUNDS;
    free.map_or(least, |free| (entries.saturating_add(free) / SHARE_OF_FREE_SPACE).clamp(least, most))
}

/// Bytes free to this user on a folder's disk, if the system reports them.
#[cfg(unix)]
fn free_bytes(folder: &Path) -> Option<u64> {
    let disk = rustix::fs::statvfs(folder).ok()?;
    Some(disk.f_bavail.saturating_mul(disk.f_frsize))
}

#[cfg(not(unix))]
fn free_bytes(_folder: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize, PartialEq, Serialize)]
    struct Weather(Vec<f64>);

    impl Cached for Weather {
        const KIND: CacheKind =
            CacheKind { extension: "weather", format: Format { magic: b"TWAVEWTR", version: 2, name: "the weather" } };

        fn is_valid(&self) -> bool {
            self.0.iter().all(|value| value.is_finite())
        }
    }

    #[test]
    fn the_least_recently_used_goes_first_and_what_is_read_is_used() {
        let folder = tempfile::tempdir().unwrap();
        let roomy = Cache::at(folder.path().to_owned(), u64::MAX);
        let weather = Weather(vec![1.5; 100]);
        let now = SystemTime::now();
        for name in 0..3_u8 {
            roomy.store(&[name; 32], &weather).unwrap();
            let file = File::options().append(true).open(roomy.path::<Weather>(&[name; 32])).unwrap();
            file.set_modified(now - Duration::from_secs(100 - u64::from(name))).unwrap();
        }
        fs::write(folder.path().join("notes.weather"), "somebody's").unwrap();
        assert_eq!(roomy.load(&[0; 32]).unwrap(), Some(Ok(Weather(vec![1.5; 100]))));
        let size = roomy.list(&[Weather::KIND]).unwrap()[0].bytes;
        Cache::at(folder.path().to_owned(), 3 * size).store(&[3; 32], &weather).unwrap();
        let remain = [0, 1, 2, 3].map(|name| roomy.load::<Weather>(&[name; 32]).unwrap().is_some());
        assert_eq!(remain, [true, false, true, true]);
        assert!(roomy.list(&[]).unwrap().iter().all(|entry| entry.usable.is_err()), "of no known kind");
        // A folder in the place of the first entry is no file to remove.
        fs::create_dir(folder.path().join("0".repeat(64))).unwrap();
        let (removed, failed) = roomy.clear().unwrap();
        assert_eq!((removed, failed.len()), (3, 1), "it goes on past what it cannot remove");
        assert!(failed[0].to_string().contains(&"0".repeat(64)), "{}", failed[0]);
        assert!(folder.path().join("notes.weather").exists());
    }

    #[test]
    fn the_cache_holds_the_sounds_of_a_sweep_on_a_large_disk() {
        const SOUND: u64 = 930_000_000;
        const GIB: u64 = 1 << 30;
        assert_eq!(limit_by_free_space(0, None), 2 * GIB);
        assert_eq!(limit_by_free_space(GIB, Some(GIB)), 2 * GIB, "a small disk");
        assert!(limit_by_free_space(2 * SOUND, Some(60 * GIB)) > 8 * SOUND);
        // What is stored takes nothing from the limit; no disk is so large that all of it is filled.
        assert_eq!(
            limit_by_free_space(2 * SOUND, Some(60 * GIB)),
            limit_by_free_space(4 * SOUND, Some(60 * GIB - 2 * SOUND))
        );
        assert_eq!(limit_by_free_space(0, Some(u64::MAX)), 32 * GIB);
        let folder = tempfile::tempdir().unwrap();
        assert!(!cfg!(unix) || free_bytes(folder.path()).is_some_and(|free| free > 0));
    }

    #[test]
    fn invalid_values_are_damaged_and_versions_have_their_keys() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::at(folder.path().to_owned(), u64::MAX);
        cache.store(&[7; 32], &Weather(vec![f64::NAN])).unwrap();
        assert_eq!(cache.load::<Weather>(&[7; 32]).unwrap(), Some(Err(Unusable::Damaged)));
        assert_ne!(key::<Weather>(&"rain").unwrap(), key::<Weather>(&"snow").unwrap());
    }
}
