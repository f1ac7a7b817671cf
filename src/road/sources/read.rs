//! Reading whole files within a bound of memory.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::road::error::RoadError;

/// All bytes of a file of at most `limit` bytes.
///
/// # Errors
/// The file cannot be read, is no regular file, or is larger.
pub fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, RoadError> {
    let fault = |source| RoadError::Io { path: path.to_owned(), source };
    let file = File::open(path).map_err(fault)?;
    let information = file.metadata().map_err(fault)?;
    if !information.is_file() {
        return Err(fault(std::io::Error::new(std::io::ErrorKind::InvalidInput, "not a regular file")));
    }
    let needed = information.len();
    if needed > limit {
        return Err(RoadError::TooLarge { path: path.to_owned(), needed, limit });
    }
    let mut bytes = Vec::with_capacity(needed as usize);
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(fault)?;
    // The file may have grown meanwhile.
    if bytes.len() as u64 > limit {
        return Err(RoadError::TooLarge { path: path.to_owned(), needed: bytes.len() as u64, limit });
    }
    Ok(bytes)
}
