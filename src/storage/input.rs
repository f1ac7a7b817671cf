//! Files that are read as a whole: regular ones of a bounded size, nothing else.
//!
//! A named pipe blocks its reader and a device may go on for ever; a file far larger than intended would take all
//! memory before its first line is read.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use thiserror::Error;

/// Largest scene, tyre or road table \[bytes\]: even large ones written by hand have some kilobytes.
pub(crate) const SCENE_BYTES: u64 = 1_000_000;
/// Largest file of cases or measured values \[bytes\].
pub(crate) const TABLE_BYTES: u64 = 100_000_000;

/// Why a file is not read.
#[derive(Debug, Error)]
pub(crate) enum InputError {
    /// The system's reason, or that it is not a regular file.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// It is longer than files of this use may be.
    #[error("it has {found} bytes, and such a file at most {limit}")]
    TooLarge {
        /// Its size \[bytes\], or as much of it as was read.
        found: u64,
        /// Greatest size \[bytes\].
        limit: u64,
    },
}

impl From<InputError> for io::Error {
    fn from(error: InputError) -> Self {
        match error {
            InputError::Io(source) => source,
            InputError::TooLarge { .. } => Self::new(io::ErrorKind::FileTooLarge, error.to_string()),
        }
    }
}

/// Opens a regular file; returns it and its size \[bytes\].
///
/// # Errors
/// Errors of the file system; [`io::ErrorKind::InvalidInput`] for pipes, devices and sockets.
pub(crate) fn open(path: &Path) -> io::Result<(File, u64)> {
    // Checked before it is opened: opening a named pipe waits for a writer.
    let regular = |information: fs::Metadata| match information.is_dir() {
        true => Err(io::ErrorKind::IsADirectory.into()),
        false if information.is_file() => Ok(information.len()),
        false => Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file")),
    };
    regular(fs::metadata(path)?)?;
    let file = File::open(path)?;
    let size = regular(file.metadata()?)?;
    Ok((file, size))
}

/// All bytes of a regular file of at most `limit` bytes.
///
/// # Errors
/// As [`open`], and [`InputError::TooLarge`].
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, InputError> {
    let (file, size) = open(path)?;
    let check = |found| if found > limit { Err(InputError::TooLarge { found, limit }) } else { Ok(()) };
    check(size)?;
    let mut bytes = Vec::with_capacity(size as usize);
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    // The file may have grown meanwhile.
    check(bytes.len() as u64)?;
    Ok(bytes)
}

/// Reads a file as [`read`], but as UTF-8 text.
///
/// # Errors
/// As [`read`]; [`io::ErrorKind::InvalidData`] for bytes that are not UTF-8.
pub(crate) fn read_text(path: &Path, limit: u64) -> Result<String, InputError> {
    let text = String::from_utf8(read(path, limit)?);
    text.map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error.utf8_error()).into())
}

/// Most characters of a file that a message quotes.
const QUOTED: usize = 80;

/// The part of a file's text that a message quotes: its beginning.
pub(crate) fn excerpt(text: &str) -> String {
    beginning(text, QUOTED)
}

/// The text if it has at most `most` characters, else so many of them and three dots.
pub(crate) fn beginning(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_of_a_bounded_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("letters");
        fs::write(&path, "abc").unwrap();
        assert_eq!(read_text(&path, 3).unwrap(), "abc");
        assert!(matches!(read(&path, 2), Err(InputError::TooLarge { found: 3, limit: 2 })));
        let kind = |path: &Path| io::Error::from(read(path, 9).unwrap_err()).kind();
        assert_eq!(kind(folder.path()), io::ErrorKind::IsADirectory);
        assert_eq!(kind(&folder.path().join("none")), io::ErrorKind::NotFound);
        fs::write(&path, [0xff]).unwrap();
        assert_eq!(io::Error::from(read_text(&path, 9).unwrap_err()).kind(), io::ErrorKind::InvalidData);
        if cfg!(unix) {
            assert_eq!(kind(Path::new("/dev/zero")), io::ErrorKind::InvalidInput);
            let pipe = folder.path().join("pipe");
            let made = std::process::Command::new("mkfifo").arg(&pipe).status();
            if made.is_ok_and(|status| status.success()) {
                assert_eq!(kind(&pipe), io::ErrorKind::InvalidInput);
            }
        }
    }
}
