//! Upper triangles of symmetric 6x6 matrices, which relate the two faces of a layer.

/// Entries of the upper triangle of a symmetric 6x6 matrix.
pub(super) const ENTRIES: usize = 21;
/// Modes or poles whose terms are added together: their coefficients stay in the processor's first cache.
pub(super) const BLOCK: usize = 8;

/// Rows and columns of the upper triangle, row by row.
pub(super) fn upper_places() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|row| (row..6).map(move |column| (row, column)))
}

/// Entries of the upper triangle by row and column, row by row.
pub(super) fn upper(entry: impl Fn(usize, usize) -> f64) -> [f64; ENTRIES] {
    let mut entries = [0.0; ENTRIES];
    for (value, (row, column)) in entries.iter_mut().zip(upper_places()) {
        *value = entry(row, column);
    }
    entries
}
