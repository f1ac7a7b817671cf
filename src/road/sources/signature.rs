//! Kinds of road files that are recognised by their first bytes.

use crate::road::file_fault::FileFault;

/// A mark, the number of bytes in which it is looked for, the kind of file in words, and the kind of road it makes.
type Signature = (&'static [u8], usize, &'static str, &'static str);

const SIGNATURES: [Signature; 3] = [
    (b"\x93NUMPY", 6, "a .npy array", "grid"),
    (b"$ROAD_CRG", 65_536, "an OpenCRG file", "opencrg"),
    (b"*****DATA*****", 65_536, "a CAPTIF profile", "profile"),
];

/// First bytes of files that are not read, and what they are.
const UNREADABLE: [(&[u8], &str); 12] = [
    (b"DIGITAL SURF", "a topography of the form SUR"),
    (b"DSCOMPRESSED", "a topography of the form SUR"),
    (b"PK\x03\x04", "a ZIP archive, as X3P and Excel files are"),
    (b"\xd0\xcf\x11\xe0", "an Excel file or another compound document"),
    (b"\x89HDF", "an HDF5 file"),
    (b"MATLAB 5.0", "a MATLAB file"),
    (b"aISO-1.0", "a topography of the form SDF"),
    (b"bISO-1.0", "a topography of the form SDF"),
    (b"LASF", "a LAS point cloud"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"\x89PNG", "a PNG picture"),
];

/// Refuses a file of a known kind from which no road is read.
///
/// # Errors
/// [`FileFault::Unreadable`].
pub(super) fn refuse_unreadable(bytes: &[u8]) -> Result<(), FileFault> {
    let found = UNREADABLE.iter().find(|(mark, _)| bytes.starts_with(mark));
    found.map_or(Ok(()), |&(_, found)| Err(FileFault::Unreadable { found }))
}

/// Refuses a file that is plainly one for another kind of road.
///
/// # Errors
/// [`FileFault::OtherKind`].
pub(super) fn refuse_other_kinds(bytes: &[u8], wanted: &str) -> Result<(), FileFault> {
    let is_found = |&(mark, within, ..): &Signature| {
        let head = &bytes[..bytes.len().min(within)];
        head.windows(mark.len()).any(|window| window == mark)
    };
    match SIGNATURES.into_iter().find(is_found) {
        Some((_, _, found, kind)) if kind != wanted => Err(FileFault::OtherKind { found, kind }),
        _ => Ok(()),
    }
}
