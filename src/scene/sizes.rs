//! Largest sizes in a scene. They are bounded when they are read, before anything is allocated or looped over: larger
//! numbers resolve nothing more, and would be refused for the time or the memory that they take.

/// Largest number of elements, substeps or terms: products of two do not overflow.
pub(crate) const MOST: u64 = 1_000_000;
/// Most cells of an element in a direction: finer than any texture.
pub(crate) const MOST_CELLS: u64 = 10_000;
/// Most pitches round a tyre.
pub(crate) const MOST_PITCHES: u64 = 1000;
/// Most grooves across round a tyre: their overlap is checked in pairs.
pub(crate) const MOST_GROOVES_ACROSS: usize = 4000;
/// Most crossings of grooves across times their number: each crossing is a bend of the void over the width, at which
/// all of them are looked at; some 30 ns each.
pub(crate) const MOST_OVERLAPS: f64 = 1e8;
/// Most cells of a tread pattern, round the tyre and across: some hundred bytes each.
pub(crate) const MOST_TREAD_CELLS: usize = 4_000_000;
