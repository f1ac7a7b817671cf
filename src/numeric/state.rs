//! The state of what evolves, as bytes: little-endian 64-bit fields, lists with their length in front. Bits are kept:
//! what is read is what was written.

use std::time::Duration;

use thiserror::Error;

/// Why a state does not fit what it is read into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StateError {
    /// The bytes end too early.
    #[error("its state ends too early")]
    Short,
    /// A list has another length than the one it is for.
    #[error("its state holds {found} numbers where {expected} are needed")]
    Length {
        /// Numbers needed.
        expected: usize,
        /// Numbers found.
        found: usize,
    },
    /// A field holds what it cannot.
    #[error("its state makes no sense")]
    Value,
    /// There is more than was asked for.
    #[error("its state has {bytes} bytes left over")]
    Surplus {
        /// Bytes that nobody has read.
        bytes: usize,
    },
}

/// A time as it is kept in a state.
pub fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

/// Takes a state down, field by field.
#[derive(Clone, Debug, Default)]
pub struct StateWriter(Vec<u8>);

impl StateWriter {
    /// A count.
    pub fn count(&mut self, value: u64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// A whole number.
    pub fn whole(&mut self, value: i64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// A number.
    pub fn number(&mut self, value: f64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// A list of numbers.
    pub fn numbers(&mut self, values: &[f64]) {
        self.count(values.len() as u64);
        values.iter().for_each(|&value| self.number(value));
    }

    /// A list of counts.
    pub fn counts(&mut self, values: &[u64]) {
        self.count(values.len() as u64);
        values.iter().for_each(|&value| self.count(value));
    }

    /// A list of whole numbers.
    pub fn wholes(&mut self, values: &[i64]) {
        self.count(values.len() as u64);
        values.iter().for_each(|&value| self.whole(value));
    }

    /// A text, padded to whole fields.
    pub fn text(&mut self, text: &str) {
        self.count(text.len() as u64);
        self.0.extend_from_slice(text.as_bytes());
        self.0.resize(self.0.len().next_multiple_of(8), 0);
    }

    /// What was taken down.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0
    }
}

/// Reads a state in the order in which it was taken down.
#[derive(Clone, Debug)]
pub struct StateReader<'a>(&'a [u8]);

impl<'a> StateReader<'a> {
    /// A reader of a writer's bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    fn field(&mut self) -> Result<[u8; 8], StateError> {
        let (field, rest) = self.0.split_first_chunk::<8>().ok_or(StateError::Short)?;
        self.0 = rest;
        Ok(*field)
    }

    /// A count.
    pub fn count(&mut self) -> Result<u64, StateError> {
        Ok(u64::from_le_bytes(self.field()?))
    }

    /// A count that is a size in memory.
    pub fn size(&mut self) -> Result<usize, StateError> {
        usize::try_from(self.count()?).map_err(|_| StateError::Value)
    }

    /// A whole number.
    pub fn whole(&mut self) -> Result<i64, StateError> {
        Ok(i64::from_le_bytes(self.field()?))
    }

    /// A number.
    pub fn number(&mut self) -> Result<f64, StateError> {
        Ok(f64::from_le_bytes(self.field()?))
    }

    /// Length of a list that the bytes left can hold.
    fn length(&mut self) -> Result<usize, StateError> {
        let length = self.size()?;
        if length > self.0.len() / 8 { Err(StateError::Short) } else { Ok(length) }
    }

    /// A list of numbers of known length.
    pub fn numbers_into(&mut self, values: &mut [f64]) -> Result<(), StateError> {
        self.fill(values, Self::number)
    }

    fn fill<T>(&mut self, values: &mut [T], read: fn(&mut Self) -> Result<T, StateError>) -> Result<(), StateError> {
        let found = self.length()?;
        if found != values.len() {
            return Err(StateError::Length { expected: values.len(), found });
        }
        for value in values {
            *value = read(self)?;
        }
        Ok(())
    }

    /// A list of numbers.
    pub fn numbers(&mut self) -> Result<Vec<f64>, StateError> {
        (0..self.length()?).map(|_| self.number()).collect()
    }

    /// A list of counts.
    pub fn counts(&mut self) -> Result<Vec<u64>, StateError> {
        (0..self.length()?).map(|_| self.count()).collect()
    }

    /// A list of counts of known length.
    pub fn counts_into(&mut self, values: &mut [u64]) -> Result<(), StateError> {
        self.fill(values, Self::count)
    }

    /// A list of whole numbers.
    pub fn wholes(&mut self) -> Result<Vec<i64>, StateError> {
        (0..self.length()?).map(|_| self.whole()).collect()
    }

    /// A text.
    pub fn text(&mut self) -> Result<&'a str, StateError> {
        let length = self.size()?;
        let padded = length.checked_next_multiple_of(8).ok_or(StateError::Short)?;
        let (text, rest) = self.0.split_at_checked(padded).ok_or(StateError::Short)?;
        self.0 = rest;
        std::str::from_utf8(&text[..length]).map_err(|_| StateError::Value)
    }

    /// Bytes not yet read.
    pub fn left(&self) -> usize {
        self.0.len()
    }

    /// Ok if everything has been read.
    pub fn end(self) -> Result<(), StateError> {
        if self.0.is_empty() { Ok(()) } else { Err(StateError::Surplus { bytes: self.0.len() }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Vec<u8> {
        let mut writer = StateWriter::default();
        writer.count(u64::MAX);
        writer.whole(-7);
        writer.number(f64::from_bits(0x7ff8_0000_0000_0001));
        writer.numbers(&[1.5, -0.0]);
        writer.counts(&[3, 4]);
        writer.wholes(&[i64::MIN]);
        writer.text("größer");
        writer.into_bytes()
    }

    #[test]
    fn bits_come_back() {
        let bytes = example();
        let mut reader = StateReader::new(&bytes);
        assert_eq!(reader.count(), Ok(u64::MAX));
        assert_eq!(reader.whole(), Ok(-7));
        assert_eq!(reader.number().unwrap().to_bits(), 0x7ff8_0000_0000_0001);
        let mut numbers = [0.0; 2];
        reader.numbers_into(&mut numbers).unwrap();
        assert_eq!(numbers.map(f64::to_bits), [1.5, -0.0].map(f64::to_bits));
        let mut counts = [0; 2];
        reader.counts_into(&mut counts).unwrap();
        assert_eq!((counts, reader.wholes().unwrap()), ([3, 4], vec![i64::MIN]));
        assert_eq!(reader.text(), Ok("größer"));
        assert_eq!(reader.end(), Ok(()));
    }

    #[test]
    fn what_does_not_fit_is_refused_without_a_large_allocation() {
        let bytes = example();
        assert_eq!(StateReader::new(&bytes[..5]).count(), Err(StateError::Short));
        assert_eq!(StateReader::new(&bytes).numbers(), Err(StateError::Short), "a length of 2^64 - 1");
        let list = [2_u64.to_le_bytes(), [0; 8], [0; 8]].concat();
        let wrong = StateReader::new(&list).numbers_into(&mut [0.0; 3]);
        assert_eq!(wrong, Err(StateError::Length { expected: 3, found: 2 }));
        assert_eq!(StateReader::new(&list).end(), Err(StateError::Surplus { bytes: 24 }));
    }
}
