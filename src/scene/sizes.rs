//! Largest sizes of a scene. They are bounded where they are read, before anything is allocated or looped over: finer
//! numbers resolve nothing more, and would be refused for the time or the memory that they take.

/// Largest count of elements, substeps, terms: products of two can be counted.
pub(crate) const MOST: u64 = 1_000_000;
/// Most cells of an element in a direction: finer than any texture.
pub(crate) const MOST_CELLS: u64 = 10_000;
/// Most pitches round a tyre.
pub(crate) const MOST_PITCHES: u64 = 1000;
/// Most grooves across round a tyre: how they overlap is looked at in pairs.
pub(crate) const MOST_GROOVES_ACROSS: usize = 4000;
/// Most cells of a tread's pattern, round the tyre and across: some hundreds of bytes each.
pub(crate) const MOST_TREAD_CELLS: usize = 4_000_000;
