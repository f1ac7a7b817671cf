//! Compact lists of task numbers, as batch systems read them: `3,7-9`.

use std::fmt;

/// Distinct numbers, rising.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Numbers(Vec<u64>);

impl Numbers {
    /// Collects numbers in any order; duplicates count once.
    pub(crate) fn new(numbers: impl IntoIterator<Item = u64>) -> Self {
        let mut numbers: Vec<u64> = numbers.into_iter().collect();
        numbers.sort_unstable();
        numbers.dedup();
        Self(numbers)
    }

    pub(crate) fn as_slice(&self) -> &[u64] {
        &self.0
    }
}

impl fmt::Display for Numbers {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, run) in self.0.chunk_by(|one, other| other - one == 1).enumerate() {
            let comma = if index > 0 { "," } else { "" };
            match run {
                [first, .., last] => write!(formatter, "{comma}{first}-{last}")?,
                _ => write!(formatter, "{comma}{}", run[0])?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_said_as_job_arrays_read_them() {
        for (numbers, text) in
            [(&[9, 3, 8, 7, 7][..], "3,7-9"), (&[0], "0"), (&[0, 1], "0-1"), (&[0, 2, 4], "0,2,4"), (&[], "")]
        {
            assert_eq!(Numbers::new(numbers.iter().copied()).to_string(), text);
        }
    }
}
