//! Memory that begins on a cache line.

/// Bytes to a cache line.
const LINE_BYTES: usize = 64;

/// Zeros that begin on a cache line; pages that are never written to take no memory.
pub struct Aligned<T = f64> {
    memory: Vec<T>,
    begin: usize,
}

impl<T: Copy + Default> Aligned<T> {
    /// `length` zeros.
    pub fn new(length: usize) -> Self {
        let spare = LINE_BYTES / size_of::<T>().max(1);
        let memory = vec![T::default(); length + spare];
        let begin = memory.as_ptr().align_offset(LINE_BYTES).min(spare);
        Self { memory, begin }
    }

    /// Elements `first`..`first` + `length`; panics where they reach past the end.
    pub fn part(&mut self, first: usize, length: usize) -> &mut [T] {
        &mut self.memory[self.begin + first..self.begin + first + length]
    }
}
