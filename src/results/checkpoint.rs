//! `checkpoint`: the state of an unfinished run, beside its arrays.
//!
//! Layout, little-endian:
//!
//! ```text
//! 8 bytes  magic "TWAVECHK"          4 bytes  format version          8 bytes  length of the body
//! body: program version, scene, road, state (see the writer)          32 bytes SHA-256 of all before
//! ```
//!
//! It is written to a temporary file, brought to the disk and renamed: at any moment, also of a power cut or a full
//! disk, there is a whole checkpoint, the new one or the one before. The arrays are brought to the disk before it, so
//! they hold at least the rows that it counts; what is behind those is cut off.

use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use thiserror::Error;

use super::error::ResultsError;
use super::folder::sync_folder;
use crate::numeric::StateError;

/// Name of the checkpoint in the folder of an unfinished run.
pub const CHECKPOINT_FILE: &str = "checkpoint";
/// Name while it is being written.
pub(super) const TEMPORARY_FILE: &str = "checkpoint.tmp";
/// Name of the effective scene in the folder of an unfinished run.
pub const SCENE_FILE: &str = "scene.toml";
/// First bytes of a checkpoint.
const MAGIC: &[u8; 8] = b"TWAVECHK";
/// Version of the layout and of what is stored: raise it whenever a state means something else.
pub const VERSION: u32 = 4;
/// Bytes before the body and after it.
const HEADER: usize = 8 + 4 + 8;
const TRAILER: usize = 32;

/// Why a run cannot be gone on with.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// No unfinished run of that name.
    #[error("nothing to resume: there is no unfinished run {} (looked for {}.partial and {}.partial-*)", path.display(), path.display(), path.display())]
    Nothing {
        /// The place named by the caller.
        path: PathBuf,
    },
    /// The run has reached its end.
    #[error("nothing to resume: {} is complete", path.display())]
    Complete {
        /// The results.
        path: PathBuf,
    },
    /// Stopped before the first checkpoint.
    #[error("{} holds no checkpoint: the run was stopped before its first one; start it again with `tyrewave run`", path.display())]
    NoCheckpoint {
        /// The unfinished run.
        path: PathBuf,
    },
    /// More than one unfinished run of that name.
    #[error("several runs of that name are unfinished, name one of them: {}", listed(found))]
    Several {
        /// Their folders.
        found: Vec<PathBuf>,
    },
    /// Another process has it.
    #[error("{} is being written by a process that is still running", path.display())]
    Running {
        /// The unfinished run.
        path: PathBuf,
    },
    /// The file does not check out.
    #[error("{} cannot be used: {reason}", path.display())]
    Unusable {
        /// The checkpoint.
        path: PathBuf,
        /// What is wrong with it.
        reason: Unusable,
    },
    /// The system does not let us.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// What is wrong with a checkpoint.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum Unusable {
    /// Shorter than it says it is.
    #[error("it is truncated")]
    Truncated,
    /// Something else.
    #[error("it is not a checkpoint")]
    Foreign,
    /// Of another layout.
    #[error("it has format version {found}, this program reads {VERSION}")]
    Format {
        /// The version found.
        found: u32,
    },
    /// The checksum does not fit.
    #[error("it is damaged")]
    Damaged,
    /// Written by another version of the program.
    #[error("tyrewave {found} has written it, this is {}; the same bits cannot be promised", env!("CARGO_PKG_VERSION"))]
    Program {
        /// The version found.
        found: String,
    },
    /// Belongs to another scene.
    #[error("it belongs to another scene than the {SCENE_FILE} beside it")]
    Scene,
    /// The road's file has another content.
    #[error("the road file {} has changed since the run began", file.display())]
    Road {
        /// The file.
        file: PathBuf,
    },
    /// The influence functions came out with other bits.
    #[error("the tyre's influence functions come out differently here: another machine or library")]
    Influence,
    /// Checked out, but does not fit.
    #[error("{0}")]
    State(#[from] StateError),
}

fn listed(paths: &[PathBuf]) -> String {
    paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// Puts a body into a folder as its checkpoint; the one before stays whole until the new one is.
///
/// # Errors
/// [`ResultsError::Create`], [`ResultsError::Write`], [`ResultsError::Rename`].
pub fn write(folder: &Path, body: &[u8]) -> Result<(), ResultsError> {
    let mut bytes = Vec::with_capacity(HEADER + body.len() + TRAILER);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(body.len() as u64).to_le_bytes());
    bytes.extend_from_slice(body);
    let checksum: [u8; 32] = Sha256::digest(&bytes).into();
    bytes.extend_from_slice(&checksum);
    let (temporary, path) = (folder.join(TEMPORARY_FILE), folder.join(CHECKPOINT_FILE));
    let written = File::create(&temporary)
        .map_err(ResultsError::creating(&temporary))
        .and_then(|mut file| {
            file.write_all(&bytes).and_then(|()| file.sync_all()).map_err(ResultsError::writing(&temporary))
        })
        .and_then(|()| {
            let failed = |source| ResultsError::Rename { from: temporary.clone(), to: path.clone(), source };
            fs::rename(&temporary, &path).map_err(failed)
        });
    if written.is_err() {
        // It would take room on a full disk; if that fails too there is nothing more to do.
        let _ = fs::remove_file(&temporary);
    }
    written?;
    sync_folder(folder).map_err(ResultsError::writing(folder))
}

/// The body of a folder's checkpoint.
///
/// # Errors
/// [`CheckpointError::NoCheckpoint`], [`CheckpointError::Io`], [`CheckpointError::Unusable`].
pub fn read(folder: &Path) -> Result<Vec<u8>, CheckpointError> {
    let path = folder.join(CHECKPOINT_FILE);
    let mut bytes = fs::read(&path).map_err(|source| match source.kind() {
        ErrorKind::NotFound => CheckpointError::NoCheckpoint { path: folder.to_owned() },
        _ => CheckpointError::Io { path: path.clone(), source },
    })?;
    let length = body_length(&bytes).map_err(|reason| CheckpointError::Unusable { path, reason })?;
    bytes.truncate(HEADER + length);
    bytes.drain(..HEADER);
    Ok(bytes)
}

/// Length of the body of a checkpoint whose header and checksum are right.
fn body_length(bytes: &[u8]) -> Result<usize, Unusable> {
    if !bytes.starts_with(&MAGIC[..bytes.len().min(8)]) {
        return Err(Unusable::Foreign);
    }
    let version = bytes.get(8..12).and_then(|field| field.try_into().ok()).map(u32::from_le_bytes);
    match version.ok_or(Unusable::Truncated)? {
        VERSION => {}
        found => return Err(Unusable::Format { found }),
    }
    let length = bytes.get(12..HEADER).and_then(|field| field.try_into().ok()).map(u64::from_le_bytes);
    let rest = (bytes.len() - HEADER.min(bytes.len())) as u64;
    let length = length.ok_or(Unusable::Truncated)?;
    match length.checked_add(TRAILER as u64) {
        Some(wanted) if wanted == rest => {}
        Some(wanted) if wanted < rest => return Err(Unusable::Damaged),
        _ => return Err(Unusable::Truncated),
    }
    let (content, checksum) = bytes.split_at(bytes.len() - TRAILER);
    if Sha256::digest(content).as_slice() == checksum { Ok(length as usize) } else { Err(Unusable::Damaged) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cut_and_every_flipped_byte_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), b"a state of some length").unwrap();
        assert_eq!(read(folder.path()).unwrap(), b"a state of some length");
        let path = folder.path().join(CHECKPOINT_FILE);
        let good = fs::read(&path).unwrap();
        let refused = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            match read(folder.path()).unwrap_err() {
                CheckpointError::Unusable { reason, .. } => reason,
                other => panic!("{other}"),
            }
        };
        for length in 0..good.len() {
            assert_eq!(refused(&good[..length]), Unusable::Truncated, "{length}");
        }
        for place in 0..good.len() {
            let mut bytes = good.clone();
            bytes[place] ^= 1;
            let reason = refused(&bytes);
            match place {
                0..8 => assert_eq!(reason, Unusable::Foreign),
                8..12 => assert!(matches!(reason, Unusable::Format { .. })),
                12..20 => assert!(matches!(reason, Unusable::Truncated | Unusable::Damaged)),
                _ => assert_eq!(reason, Unusable::Damaged),
            }
        }
        assert_eq!(refused(&[good.as_slice(), b"x"].concat()), Unusable::Damaged);
        assert_eq!(refused(b"something else"), Unusable::Foreign);
    }

    #[test]
    fn a_checkpoint_that_cannot_be_written_leaves_the_one_before() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), b"first").unwrap();
        // A folder in the way of the temporary file stands for a disk that refuses it.
        fs::create_dir(folder.path().join(TEMPORARY_FILE)).unwrap();
        assert!(write(folder.path(), b"second").is_err());
        assert_eq!(read(folder.path()).unwrap(), b"first");
        let empty = tempfile::tempdir().unwrap();
        assert!(matches!(read(empty.path()), Err(CheckpointError::NoCheckpoint { .. })));
    }
}
