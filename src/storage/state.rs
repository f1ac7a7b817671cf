//! A saved state against what it is restored into.
//!
//! A state is a plain structure of named fields with serde's traits, made by a `save` and given to the `restore` of an
//! equal, freshly prepared object. Its content is what a file has said: `restore` checks it before it is used.

use thiserror::Error;

/// Why a state does not fit what it is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StateError {
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
}

/// Puts saved values in the place of present ones.
///
/// # Errors
/// [`StateError::Length`] for another number of them.
pub fn fill<T: Copy>(values: &mut [T], saved: &[T]) -> Result<(), StateError> {
    if values.len() != saved.len() {
        return Err(StateError::Length { expected: values.len(), found: saved.len() });
    }
    values.copy_from_slice(saved);
    Ok(())
}

/// As [`fill`], list by list.
///
/// # Errors
/// [`StateError::Length`] for another number of lists, or of values in one of them.
pub fn fill_all<'a, T: Copy + 'a>(
    lists: impl ExactSizeIterator<Item = &'a mut [T]>,
    saved: &[Vec<T>],
) -> Result<(), StateError> {
    if lists.len() != saved.len() {
        return Err(StateError::Length { expected: lists.len(), found: saved.len() });
    }
    lists.zip(saved).try_for_each(|(values, saved)| fill(values, saved))
}

/// Restores a part that some have and others have not.
///
/// # Errors
/// [`StateError::Value`] unless there are both, part and state, or neither; those of `restore`.
pub fn restore_part<T, S>(
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

/// A state as it comes back from its bytes.
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
