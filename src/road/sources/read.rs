//! Reading whole files within a bound of memory.

use std::fs::File;
use std::io::{Error, ErrorKind, Read};
use std::path::Path;

use crate::road::file_fault::FileFault;

/// All bytes of a file of at most `limit` bytes.
///
/// # Errors
/// The file cannot be read, is no regular file, or is larger.
pub fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, FileFault> {
    let file = File::open(path)?;
    let information = file.metadata()?;
    if !information.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "not a regular file").into());
    }
    let needed = information.len();
    if needed > limit {
        return Err(FileFault::TooLarge { needed, limit });
    }
    let mut bytes = Vec::with_capacity(needed as usize);
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    // The file may have grown meanwhile.
    if bytes.len() as u64 > limit {
        return Err(FileFault::TooLarge { needed: bytes.len() as u64, limit });
    }
    Ok(bytes)
}
