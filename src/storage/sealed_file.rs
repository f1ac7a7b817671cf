//! Sealed files: one value in a file that identifies itself and shows whether it is complete.
//!
//! Layout, little-endian:
//!
//! ```text
//! 8 bytes  magic        4 bytes  version        8 bytes  length of the body
//! body: the value in the postcard format        32 bytes  SHA-256 of all before
//! ```
//!
//! The body is decoded only if length and checksum are right. It is read into memory as a whole, and what is decoded
//! from it is bounded by it: no list is believed to be longer than the bytes present.

use std::io;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::input;
use super::pending_file::PendingFile;

/// Bytes before the body: magic, version and length.
const HEADER: usize = 8 + 4 + 8;
const TRAILER: usize = 32;
/// Limit of a file's size \[bytes\]: more than any state of a run that fits in memory.
const LARGEST: u64 = 16_000_000_000;

/// Reason why a sealed file is not used.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Unusable {
    /// Shorter than its header states.
    #[error("it is truncated")]
    Truncated,
    /// It does not begin with the magic of the format.
    #[error("it is not {wanted}")]
    Foreign {
        /// Name of the expected kind.
        wanted: &'static str,
    },
    /// Another version of the format.
    #[error("it has format version {found}, this program reads {wanted}")]
    Version {
        /// The version in the file.
        found: u32,
        /// The version that this program reads.
        wanted: u32,
    },
    /// Checksum or content is wrong.
    #[error("it is damaged")]
    Damaged,
    /// It belongs to another key than the one looked up.
    #[error("it belongs to another key")]
    Key,
}

/// A kind of sealed file: magic, version and name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format {
    /// First bytes of the file.
    pub magic: &'static [u8; 8],
    /// Version of the content: to be raised whenever the same bytes would mean something else.
    pub version: u32,
    /// Name for messages, with its article, as "a checkpoint".
    pub name: &'static str,
}

impl Format {
    /// Writes a value into a file that was begun, and completes it: afterwards it is on the disk under its name.
    ///
    /// # Errors
    /// Errors of the file, which is absent then; [`io::ErrorKind::InvalidData`] for a value that cannot be encoded.
    pub fn write(&self, file: PendingFile, value: &impl Serialize) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(HEADER);
        bytes.extend_from_slice(self.magic);
        bytes.extend_from_slice(&self.version.to_le_bytes());
        bytes.extend_from_slice(&[0; 8]);
        let mut bytes = postcard::to_extend(value, bytes)
            .map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error.to_string()))?;
        let length = (bytes.len() - HEADER) as u64;
        bytes[12..HEADER].copy_from_slice(&length.to_le_bytes());
        let checksum = Sha256::digest(&bytes);
        bytes.extend_from_slice(&checksum);
        file.complete(&bytes)
    }

    /// Body of a file, if the file is complete and of this format.
    ///
    /// # Errors
    /// Errors of the file system, or a file that is too large.
    pub(crate) fn read(&self, path: &Path) -> io::Result<Result<Body, Unusable>> {
        let bytes = input::read(path, LARGEST)?;
        Ok(self.check(&bytes).map(|()| Body { bytes, next: HEADER }))
    }

    /// Checks header and checksum.
    fn check(&self, bytes: &[u8]) -> Result<(), Unusable> {
        if !bytes.starts_with(&self.magic[..bytes.len().min(8)]) {
            return Err(Unusable::Foreign { wanted: self.name });
        }
        let (_, rest) = bytes.split_at_checked(8).ok_or(Unusable::Truncated)?;
        let (version, rest) = rest.split_first_chunk().ok_or(Unusable::Truncated)?;
        let found = u32::from_le_bytes(*version);
        if found != self.version {
            return Err(Unusable::Version { found, wanted: self.version });
        }
        let (length, rest) = rest.split_first_chunk().ok_or(Unusable::Truncated)?;
        match u64::from_le_bytes(*length).checked_add(TRAILER as u64) {
            Some(wanted) if wanted == rest.len() as u64 => {}
            Some(wanted) if wanted < rest.len() as u64 => return Err(Unusable::Damaged),
            _ => return Err(Unusable::Truncated),
        }
        let (content, checksum) = bytes.split_at(bytes.len() - TRAILER);
        if Sha256::digest(content).as_slice() == checksum { Ok(()) } else { Err(Unusable::Damaged) }
    }
}

/// Content of a checked file.
#[derive(Clone, Debug)]
pub struct Body {
    bytes: Vec<u8>,
    /// Position of the next value.
    next: usize,
}

impl Body {
    /// Decodes the next of the values that were written as a tuple.
    ///
    /// # Errors
    /// [`Unusable::Damaged`] where the bytes do not encode such a value.
    pub(crate) fn take<T: DeserializeOwned>(&mut self) -> Result<T, Unusable> {
        let body = &self.bytes[self.next..self.bytes.len() - TRAILER];
        let (value, rest) = postcard::take_from_bytes(body).map_err(|_| Unusable::Damaged)?;
        self.next += body.len() - rest.len();
        Ok(value)
    }

    /// Decodes the last value.
    ///
    /// # Errors
    /// As [`Self::take`], and if bytes are left after it.
    pub(crate) fn finish<T: DeserializeOwned>(mut self) -> Result<T, Unusable> {
        let value = self.take()?;
        if self.next == self.bytes.len() - TRAILER { Ok(value) } else { Err(Unusable::Damaged) }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const LETTER: Format = Format { magic: b"TWAVELET", version: 3, name: "a letter" };

    #[test]
    fn every_cut_and_every_flipped_byte_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("letter");
        let content = ("a state of some length".to_owned(), vec![1.5, -0.0]);
        LETTER.write(PendingFile::create(&path).unwrap(), &content).unwrap();
        let read = || LETTER.read(&path).unwrap().and_then(Body::finish::<(String, Vec<f64>)>);
        assert_eq!(read(), Ok(content));
        let good = fs::read(&path).unwrap();
        let refused = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            read().unwrap_err()
        };
        let foreign = Unusable::Foreign { wanted: "a letter" };
        for length in 0..good.len() {
            assert_eq!(refused(&good[..length]), Unusable::Truncated, "{length}");
        }
        for place in 0..good.len() {
            let mut bytes = good.clone();
            bytes[place] ^= 1;
            let reason = refused(&bytes);
            match place {
                0..8 => assert_eq!(reason, foreign),
                8..12 => assert!(matches!(reason, Unusable::Version { wanted: 3, .. })),
                12..20 => assert!(matches!(reason, Unusable::Truncated | Unusable::Damaged)),
                _ => assert_eq!(reason, Unusable::Damaged),
            }
        }
        assert_eq!(refused(&[good.as_slice(), b"x"].concat()), Unusable::Damaged);
        assert_eq!(refused(b"something else"), foreign);
        fs::write(&path, &good).unwrap();
        let too_little = LETTER.read(&path).unwrap().and_then(Body::finish::<String>);
        assert_eq!(too_little, Err(Unusable::Damaged), "a value that leaves bytes over");
    }
}
