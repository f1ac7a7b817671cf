//! Fitted models on disk.
//!
//! An entry is a file `<key>.influence`, the key the SHA-256 of everything that the model depends on (tyre, options,
//! format and algorithm version). It is written to a temporary file of its own and renamed, so a reader sees all of an
//! entry or nothing, and two processes may store the same one at once. Layout, little-endian:
//!
//! ```text
//! 8 bytes  magic "TWAVEINF"          4 bytes  format version        32 bytes  key
//! 8 bytes  length of the body        body (see `encode`)            32 bytes  SHA-256 of all before
//! ```
//!
//! Whatever does not check out (truncated, damaged, another version, another key) is no error: the caller gets the
//! reason as a warning, fits again and replaces it. When the entries exceed the size limit the least recently written
//! ones go first.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::SystemTime;

use serde::Serialize;
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::codec::{decode, encode};
use super::fit::{FitError, FitOptions, FitTimes, fit_timed};
use super::model::RationalModel;
use crate::numeric::digest::hexadecimal;
use crate::scene::Tyre;

/// First bytes of an entry.
const MAGIC: &[u8; 8] = b"TWAVEINF";
/// Version of the layout and of the algorithm: raise it whenever a fit of the same input may come out differently.
pub const VERSION: u32 = 6;
/// Largest size of all entries together unless set otherwise \[bytes\].
pub const DEFAULT_LIMIT: u64 = 512 << 20;
/// Extension of an entry.
const EXTENSION: &str = "influence";
/// Bytes before the body and after it.
const HEADER: usize = 8 + 4 + 32 + 8;
const TRAILER: usize = 32;

/// What stops the cache from being used.
#[derive(Debug, Error)]
pub enum CacheError {
    /// No folder: the environment names none and the platform's is unknown.
    #[error("no cache folder: set TYREWAVE_CACHE_DIR")]
    NoFolder,
    /// The folder or an entry cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Why an entry was not used.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Unusable {
    /// Shorter than it says it is.
    #[error("it is truncated")]
    Truncated,
    /// Not an entry.
    #[error("it is not an influence model")]
    Foreign,
    /// Of another version.
    #[error("it has version {found}, this program writes {VERSION}")]
    Version {
        /// The version found.
        found: u32,
    },
    /// Belongs to another model.
    #[error("it belongs to another model")]
    Key,
    /// The checksum or the content does not fit.
    #[error("it is damaged")]
    Damaged,
}

/// A model with where it came from.
#[derive(Debug)]
pub struct Fetched {
    /// The model.
    pub model: RationalModel,
    /// Whether it was read from the cache.
    pub warm: bool,
    /// What the fit took, where it was fitted.
    pub times: Option<FitTimes>,
    /// What went wrong with the cache on the way; the model is right all the same.
    pub warnings: Vec<String>,
}

/// One entry, as listed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CacheEntry {
    /// The file.
    pub path: PathBuf,
    /// Its size \[bytes\].
    pub bytes: u64,
    /// When it was written.
    pub modified: SystemTime,
    /// Whether it can be used: complete, of this version, checksum right.
    pub usable: Result<(), Unusable>,
}

/// A folder of models.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cache {
    folder: PathBuf,
    limit: u64,
}

/// A model's key: SHA-256 over the version, the tyre and the options in their JSON form (numbers are written with all
/// digits).
pub fn key(tyre: &Tyre, options: &FitOptions) -> Result<[u8; 32], FitError> {
    #[derive(Serialize)]
    struct Content<'a> {
        version: u32,
        tyre: &'a Tyre,
        options: &'a FitOptions,
    }
    let content = serde_json::to_vec(&Content { version: VERSION, tyre, options }).map_err(|_| FitError::Options {
        what: "tyre",
        value: f64::NAN,
        wanted: "finite numbers",
    })?;
    Ok(Sha256::digest(content).into())
}

impl Cache {
    /// The user's cache: `TYREWAVE_CACHE_DIR`, else the platform's cache folder (`XDG_CACHE_HOME`, `LOCALAPPDATA`,
    /// `~/Library/Caches`, `~/.cache`).
    pub fn open() -> Result<Self, CacheError> {
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let own = |base: PathBuf| base.join("tyrewave");
        let home = |below: &str| variable("HOME").map(|home| home.join(below));
        let platform = if cfg!(target_os = "macos") { home("Library/Caches") } else { home(".cache") };
        variable("TYREWAVE_CACHE_DIR")
            .or_else(|| variable("XDG_CACHE_HOME").map(own))
            .or_else(|| variable("LOCALAPPDATA").map(own))
            .or_else(|| platform.map(own))
            .map(|folder| Self::at(folder, DEFAULT_LIMIT))
            .ok_or(CacheError::NoFolder)
    }

    /// A cache in a given folder, bounded to `limit` bytes.
    pub fn at(folder: PathBuf, limit: u64) -> Self {
        Self { folder, limit }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file of a key.
    pub fn path(&self, key: &[u8; 32]) -> PathBuf {
        let name = hexadecimal(key);
        self.folder.join(name).with_extension(EXTENSION)
    }

    /// The model, from the cache if it is there and sound, else fitted, unless `stop` is set on the way, and stored.
    /// Trouble with the cache only ever gives warnings.
    ///
    /// # Errors
    /// As [`fit_timed`].
    pub fn fetch(&self, tyre: &Tyre, options: &FitOptions, stop: &AtomicBool) -> Result<Fetched, FitError> {
        let key = key(tyre, options)?;
        let mut warnings = Vec::new();
        match self.load(&key) {
            Ok(Some(Ok(model))) => return Ok(Fetched { model, warm: true, times: None, warnings }),
            Ok(Some(Err(reason))) => {
                warnings.push(format!("cache entry {} is rebuilt: {reason}", self.path(&key).display()));
            }
            Ok(None) => {}
            Err(error) => warnings.push(format!("cache not read: {error}")),
        }
        let (model, times) = fit_timed(tyre, options, stop)?;
        if let Err(error) = self.store(&key, &model) {
            warnings.push(format!("cache not written: {error}"));
        }
        Ok(Fetched { model, warm: false, times: Some(times), warnings })
    }

    /// Reads an entry: `None` where there is none.
    pub fn load(&self, key: &[u8; 32]) -> Result<Option<Result<RationalModel, Unusable>>, CacheError> {
        let path = self.path(key);
        match fs::read(&path) {
            Ok(bytes) => Ok(Some(body(&bytes, Some(key)).and_then(|body| decode(body).ok_or(Unusable::Damaged)))),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(CacheError::Io { path, source }),
        }
    }

    /// Writes an entry and drops old ones past the size limit.
    pub fn store(&self, key: &[u8; 32], model: &RationalModel) -> Result<(), CacheError> {
        let path = self.path(key);
        let io = |path: &Path| {
            let path = path.to_path_buf();
            move |source| CacheError::Io { path, source }
        };
        fs::create_dir_all(&self.folder).map_err(io(&self.folder))?;
        let body = encode(model);
        let mut bytes = Vec::with_capacity(HEADER + body.len() + TRAILER);
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(key);
        bytes.extend_from_slice(&(body.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&body);
        let checksum: [u8; 32] = Sha256::digest(&bytes).into();
        bytes.extend_from_slice(&checksum);
        // A name of its own for every writer: processes by number, threads by a count.
        static COUNT: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
        let count = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let temporary = path.with_extension(format!("{}-{count}.tmp", std::process::id()));
        let written = fs::File::create(&temporary)
            .and_then(|mut file| file.write_all(&bytes).and_then(|()| file.sync_all()))
            .and_then(|()| fs::rename(&temporary, &path));
        if let Err(source) = written {
            // What could not be finished should not stay; if that fails too there is nothing more to do.
            let _ = fs::remove_file(&temporary);
            return Err(CacheError::Io { path, source });
        }
        self.shrink(&path)
    }

    /// Drops the oldest entries until the rest fits the limit; the one just written stays.
    fn shrink(&self, keep: &Path) -> Result<(), CacheError> {
        let mut entries = self.files()?;
        entries.sort_by(|a, b| a.2.cmp(&b.2).then(a.0.cmp(&b.0)));
        let mut total: u64 = entries.iter().map(|entry| entry.1).sum();
        for (path, bytes, _) in entries {
            if total <= self.limit {
                break;
            }
            if path != keep {
                remove(&path)?;
                total -= bytes;
            }
        }
        Ok(())
    }

    /// Entries' files with size and time of writing.
    fn files(&self) -> Result<Vec<(PathBuf, u64, SystemTime)>, CacheError> {
        let io = |source| CacheError::Io { path: self.folder.clone(), source };
        let folder = match fs::read_dir(&self.folder) {
            Ok(folder) => folder,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(source) => return Err(io(source)),
        };
        let mut files = Vec::new();
        for entry in folder {
            let path = entry.map_err(io)?.path();
            if path.extension().is_some_and(|extension| extension == EXTENSION) {
                // Another process may just have dropped it.
                let Ok(metadata) = fs::metadata(&path) else { continue };
                files.push((path, metadata.len(), metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH)));
            }
        }
        files.sort();
        Ok(files)
    }

    /// All entries, checked, by name.
    pub fn list(&self) -> Result<Vec<CacheEntry>, CacheError> {
        let entries = self.files()?.into_iter().map(|(path, bytes, modified)| {
            let usable = match fs::read(&path) {
                Ok(content) => body(&content, None).map(|_| ()),
                Err(_) => Err(Unusable::Damaged),
            };
            CacheEntry { path, bytes, modified, usable }
        });
        Ok(entries.collect())
    }

    /// Removes all entries; how many there were. Other files in the folder stay.
    pub fn clear(&self) -> Result<usize, CacheError> {
        let files = self.files()?;
        for (path, ..) in &files {
            remove(path)?;
        }
        Ok(files.len())
    }
}

fn remove(path: &Path) -> Result<(), CacheError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(CacheError::Io { path: path.to_path_buf(), source })
        }
        _ => Ok(()),
    }
}

/// The body of an entry whose header and checksum are right.
fn body<'a>(bytes: &'a [u8], key: Option<&[u8; 32]>) -> Result<&'a [u8], Unusable> {
    if !bytes.starts_with(&MAGIC[..bytes.len().min(8)]) {
        return Err(Unusable::Foreign);
    }
    let version = bytes.get(8..12).and_then(|field| field.try_into().ok()).map(u32::from_le_bytes);
    let version = version.ok_or(Unusable::Truncated)?;
    if version != VERSION {
        return Err(Unusable::Version { found: version });
    }
    let found = bytes.get(12..44).ok_or(Unusable::Truncated)?;
    let length = bytes.get(44..HEADER).and_then(|field| field.try_into().ok()).map(u64::from_le_bytes);
    let length = length.ok_or(Unusable::Truncated)?;
    let rest = (bytes.len() - HEADER) as u64;
    if length.checked_add(TRAILER as u64).is_none_or(|needed| rest < needed) {
        return Err(Unusable::Truncated);
    }
    if rest != length + TRAILER as u64 {
        return Err(Unusable::Damaged);
    }
    let end = bytes.len() - TRAILER;
    if Sha256::digest(&bytes[..end])[..] != bytes[end..] {
        return Err(Unusable::Damaged);
    }
    if key.is_some_and(|key| key[..] != *found) {
        return Err(Unusable::Key);
    }
    Ok(&bytes[HEADER..end])
}
