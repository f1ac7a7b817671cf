//! Saved states, and checks whether a state fits what it is restored into.
//!
//! A state is a plain structure of named fields with serde's traits, made by a `save` and given to the `restore` of an
//! equal, freshly prepared object. Its content comes from a file: `restore` checks it before it is used.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Reason why a state does not fit the object that it is restored into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StateError {
    /// A list has another length than its target.
    #[error("its state holds {found} numbers where {expected} are needed")]
    Length {
        /// Length of the target.
        expected: usize,
        /// Length in the state.
        found: usize,
    },
    /// A field holds a value that it cannot have.
    #[error("its state is invalid")]
    Value,
}

/// Bytes of a state whose parts are written one after the other, and read in the same order.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(crate) struct SavedState(Vec<u8>);

/// Encodes the parts of a [`SavedState`].
#[derive(Debug, Default)]
pub struct StateWriter(Vec<u8>);

/// Decodes the parts of a [`SavedState`].
#[derive(Clone, Debug)]
pub struct StateReader<'a>(&'a [u8]);

impl StateWriter {
    /// Appends a value.
    ///
    /// # Errors
    /// [`StateError::Value`] if it cannot be encoded.
    pub(crate) fn put<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), StateError> {
        self.0 = postcard::to_extend(value, std::mem::take(&mut self.0)).map_err(|_| StateError::Value)?;
        Ok(())
    }

    pub(crate) fn finish(self) -> SavedState {
        SavedState(self.0)
    }
}

impl SavedState {
    pub(crate) fn reader(&self) -> StateReader<'_> {
        StateReader(&self.0)
    }
}

impl StateReader<'_> {
    /// Decodes the next value.
    ///
    /// # Errors
    /// [`StateError::Value`] where the bytes do not encode one.
    pub(crate) fn take<T: DeserializeOwned>(&mut self) -> Result<T, StateError> {
        let (value, rest) = postcard::take_from_bytes(self.0).map_err(|_| StateError::Value)?;
        self.0 = rest;
        Ok(value)
    }

    /// Checks that all bytes have been read.
    ///
    /// # Errors
    /// [`StateError::Value`] otherwise.
    pub(crate) fn finish(self) -> Result<(), StateError> {
        if self.0.is_empty() { Ok(()) } else { Err(StateError::Value) }
    }
}

/// Replaces values by saved ones.
///
/// # Errors
/// [`StateError::Length`] for another number of them.
pub(crate) fn fill<T: Copy>(values: &mut [T], saved: &[T]) -> Result<(), StateError> {
    if values.len() != saved.len() {
        return Err(StateError::Length { expected: values.len(), found: saved.len() });
    }
    values.copy_from_slice(saved);
    Ok(())
}

/// Fills values as [`fill`], list by list.
///
/// # Errors
/// [`StateError::Length`] for another number of lists, or of values in one of them.
pub(crate) fn fill_all<'a, T: Copy + 'a>(
    lists: impl ExactSizeIterator<Item = &'a mut [T]>,
    saved: &[Vec<T>],
) -> Result<(), StateError> {
    if lists.len() != saved.len() {
        return Err(StateError::Length { expected: lists.len(), found: saved.len() });
    }
    lists.zip(saved).try_for_each(|(values, saved)| fill(values, saved))
}

/// Restores a part that only some objects have.
///
/// # Errors
/// [`StateError::Value`] if only one of part and state is there; the errors of `restore`.
pub(crate) fn restore_part<T, S>(
    part: &mut Option<T>,
    state: Option<S>,
    restore: impl FnOnce(&mut T, S) -> Result<(), StateError>,
) -> Result<(), StateError> {
    match (part, state) {
        (Some(part), Some(state)) => restore(part, state),
        (None, None) => Ok(()),
        _ => Err(StateError::Value),
    }
}

/// A state after encoding and decoding.
#[cfg(test)]
pub(crate) fn read_back<T: serde::Serialize + serde::de::DeserializeOwned>(state: &T) -> T {
    postcard::from_bytes(&postcard::to_stdvec(state).unwrap()).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_come_back() {
        let numbers = vec![f64::from_bits(0x7ff8_0000_0000_0001), 1.5, -0.0, f64::NEG_INFINITY, 5e-324];
        let (counts, wholes) = (vec![u64::MAX, 3], vec![i64::MIN, -7]);
        let (back, same_counts, same_wholes, text): (Vec<f64>, Vec<u64>, Vec<i64>, String) =
            read_back(&(numbers.clone(), counts.clone(), wholes.clone(), "größer".to_owned()));
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&back), bits(&numbers));
        assert_eq!((same_counts, same_wholes, text.as_str()), (counts, wholes, "größer"));
    }

    #[test]
    fn parts_are_taken_in_the_order_in_which_they_were_put_and_none_is_left() {
        let mut writer = StateWriter::default();
        writer.put(&3_u64).unwrap();
        writer.put(&[1.5, -0.0]).unwrap();
        let saved = writer.finish();
        let mut reader = saved.reader();
        assert_eq!(reader.take::<u64>(), Ok(3));
        assert_eq!(reader.clone().finish(), Err(StateError::Value), "something is left");
        assert_eq!(reader.take::<[f64; 2]>().map(|pair| pair.map(f64::to_bits)), Ok([1.5, -0.0].map(f64::to_bits)));
        assert_eq!(reader.clone().take::<u64>(), Err(StateError::Value), "nothing is left");
        assert_eq!(reader.finish(), Ok(()));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut values = [0.0; 3];
        assert_eq!(fill(&mut values, &[0.0; 2]), Err(StateError::Length { expected: 3, found: 2 }));
        assert_eq!(fill_all([&mut values[..]].into_iter(), &[]), Err(StateError::Length { expected: 1, found: 0 }));
        assert_eq!(fill_all([&mut values[..]].into_iter(), &[vec![1.0; 3]]), Ok(()));
        assert_eq!(values.map(f64::to_bits), [1.0; 3].map(f64::to_bits));
    }

    #[test]
    fn a_length_that_the_bytes_do_not_hold_is_refused_without_a_large_allocation() {
        let endless = postcard::to_stdvec(&(u64::MAX, 1.0)).unwrap();
        assert!(postcard::from_bytes::<Vec<f64>>(&endless).is_err());
    }
}
