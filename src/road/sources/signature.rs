//! Kinds of road files that are known by what they begin with.

use crate::road::file_fault::FileFault;

/// A mark, how far into a file it is looked for, the file in words, and the kind of road that it makes.
type Signature = (&'static [u8], usize, &'static str, &'static str);

const SIGNATURES: [Signature; 3] = [
    (b"\x93NUMPY", 6, "a .npy array", "grid"),
    (b"$ROAD_CRG", 65_536, "an OpenCRG file", "opencrg"),
    (b"*****DATA*****", 65_536, "a CAPTIF profile", "profile"),
];

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
