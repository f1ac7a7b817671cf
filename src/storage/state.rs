//! The part of a run that evolves, saved and restored in place.
//!
//! [`Evolving::state`] goes through everything that later steps depend on, always in the same order. A [`StateStream`]
//! either saves what it meets, or replaces it by what was saved, in an equal, freshly prepared object. Whatever the
//! scene determines stays as it is: kernels, transforms, lengths of lists. The saved bytes come from a file: lengths
//! are compared, and a type with an index or a count in its state checks it. After an error the object is of no use.

use num_complex::Complex;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::numeric::RunningMoments;

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

/// Something of which a part evolves from step to step.
pub trait Evolving {
    /// Saves or restores all that evolves.
    ///
    /// # Errors
    /// [`StateError`].
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError>;
}

/// Implements [`Evolving`] for a type of which the named parts evolve.
macro_rules! evolving {
    ($type:ty: $($part:ident),+) => {
        impl $crate::storage::state::Evolving for $type {
            fn state(
                &mut self,
                state: &mut $crate::storage::state::StateStream<'_>,
            ) -> Result<(), $crate::storage::state::StateError> {
                state.all([$(&mut self.$part),+])
            }
        }
    };
}
pub(crate) use evolving;

/// Bytes of a saved state.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct SavedState(Vec<u8>);

impl SavedState {
    /// Saves what evolves of an object.
    ///
    /// # Errors
    /// [`StateError::Value`] if it cannot be encoded.
    pub fn of(object: &mut (impl Evolving + ?Sized)) -> Result<Self, StateError> {
        let mut bytes = Vec::new();
        object.state(&mut StateStream(Direction::Save(&mut bytes)))?;
        Ok(Self(bytes))
    }

    /// Restores an equal object.
    ///
    /// # Errors
    /// [`StateError`], also if not all bytes are read.
    pub fn restore(&self, object: &mut (impl Evolving + ?Sized)) -> Result<(), StateError> {
        let mut state = StateStream(Direction::Restore(&self.0));
        object.state(&mut state)?;
        ensure(matches!(state, StateStream(Direction::Restore([]))))
    }
}

/// A state that is being saved or restored.
#[derive(Debug)]
pub struct StateStream<'a>(Direction<'a>);

#[derive(Debug)]
enum Direction<'a> {
    /// Bytes so far.
    Save(&'a mut Vec<u8>),
    /// Bytes still to be read.
    Restore(&'a [u8]),
}

impl StateStream<'_> {
    pub(crate) fn is_restoring(&self) -> bool {
        matches!(self.0, Direction::Restore(_))
    }

    /// A value that is replaced as a whole.
    ///
    /// # Errors
    /// [`StateError::Value`] where it cannot be encoded, or where the bytes do not encode one.
    pub(crate) fn value<T: Serialize + DeserializeOwned>(&mut self, value: &mut T) -> Result<(), StateError> {
        match &mut self.0 {
            Direction::Save(bytes) => {
                **bytes = postcard::to_extend(value, std::mem::take(*bytes)).map_err(|_| StateError::Value)?;
            }
            Direction::Restore(bytes) => {
                (*value, *bytes) = postcard::take_from_bytes(bytes).map_err(|_| StateError::Value)?;
            }
        }
        Ok(())
    }

    /// A value that the scene determines: the saved one must be the same.
    ///
    /// # Errors
    /// [`StateError::Value`] for another one.
    pub(crate) fn same<T: Clone + DeserializeOwned + PartialEq + Serialize>(
        &mut self,
        value: &T,
    ) -> Result<(), StateError> {
        let mut saved = value.clone();
        self.value(&mut saved)?;
        ensure(saved == *value)
    }

    /// A list of a given length.
    ///
    /// # Errors
    /// [`StateError::Length`] for another length, errors of the items.
    pub(crate) fn list<T: Evolving>(&mut self, list: &mut [T]) -> Result<(), StateError> {
        let (expected, mut found) = (list.len(), list.len());
        self.value(&mut found)?;
        if found != expected {
            return Err(StateError::Length { expected, found });
        }
        list.iter_mut().try_for_each(|item| item.state(self))
    }

    /// A list whose length evolves. It keeps its memory, so that no step has to allocate.
    ///
    /// # Errors
    /// As [`Self::value`].
    pub(crate) fn growing<T>(&mut self, list: &mut Vec<T>) -> Result<(), StateError>
    where
        T: Clone + DeserializeOwned + Serialize,
    {
        if !self.is_restoring() {
            return self.value(list);
        }
        let mut saved = Vec::new();
        self.value(&mut saved)?;
        list.clone_from(&saved);
        Ok(())
    }

    /// Parts, one after the other.
    ///
    /// # Errors
    /// Those of the parts.
    pub(crate) fn all<const N: usize>(&mut self, parts: [&mut dyn Evolving; N]) -> Result<(), StateError> {
        parts.into_iter().try_for_each(|part| part.state(self))
    }
}

/// [`StateError::Value`] unless the condition `holds`.
pub(crate) fn ensure(holds: bool) -> Result<(), StateError> {
    if holds { Ok(()) } else { Err(StateError::Value) }
}

/// A part that is replaced as a whole, see [`StateStream::value`].
pub(crate) struct StateValue<'a, T>(pub &'a mut T);

impl<T: Serialize + DeserializeOwned> Evolving for StateValue<'_, T> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.value(self.0)
    }
}

/// Implements [`Evolving`] for types that are replaced as a whole.
macro_rules! values {
    ($($of:ty),*) => {
        $(impl Evolving for $of {
            fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
                state.value(self)
            }
        })*
    };
}

values!(bool, f32, f64, i64, u32, u64, usize, RunningMoments);

impl<T: Evolving> Evolving for Complex<T> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.re, &mut self.im])
    }
}

impl<T: Evolving> Evolving for Vec<T> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.list(self)
    }
}

impl<T: Evolving, const N: usize> Evolving for [T; N] {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        self.iter_mut().try_for_each(|item| item.state(state))
    }
}

impl<A: Evolving, B: Evolving> Evolving for (A, B) {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.0, &mut self.1])
    }
}

impl<T: Evolving + ?Sized> Evolving for Box<T> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        (**self).state(state)
    }
}

/// A part that only some scenes have.
impl<T: Evolving> Evolving for Option<T> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.same(&self.is_some())?;
        self.as_mut().map_or(Ok(()), |part| part.state(state))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_come_back() {
        let numbers = vec![f64::from_bits(0x7ff8_0000_0000_0001), 1.5, -0.0, f64::NEG_INFINITY, 5e-324];
        let mut whole = ((numbers.clone(), vec![u64::MAX, 3]), (vec![i64::MIN, -7], [1.5_f32, f32::NAN]));
        let saved = SavedState::of(&mut whole).unwrap();
        let mut back = ((vec![0.0; 5], vec![0; 2]), (vec![0; 2], [0.0; 2]));
        saved.restore(&mut back).unwrap();
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&back.0.0), bits(&numbers));
        assert_eq!((back.0.1, &back.1.0), (whole.0.1, &whole.1.0));
        assert_eq!(back.1.1.map(f32::to_bits), whole.1.1.map(f32::to_bits));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let saved = SavedState::of(&mut (vec![1.0, 2.0], Some(3_u64))).unwrap();
        let restored = |object: &mut dyn Evolving| saved.restore(object);
        assert_eq!(restored(&mut (vec![0.0; 2], Some(0_u64))), Ok(()));
        assert_eq!(restored(&mut (vec![0.0; 3], Some(0_u64))), Err(StateError::Length { expected: 3, found: 2 }));
        assert_eq!(restored(&mut (vec![0.0; 2], None::<u64>)), Err(StateError::Value), "a part is missing");
        assert_eq!(restored(&mut vec![0.0; 2]), Err(StateError::Value), "something is left");
        assert_eq!(restored(&mut ((vec![0.0; 2], Some(0_u64)), 0_u64)), Err(StateError::Value), "nothing is left");
    }

    #[test]
    fn a_list_that_grows_keeps_its_memory() {
        let bytes = postcard::to_stdvec(&[1.0, 2.0][..]).unwrap();
        let mut list = Vec::with_capacity(7);
        StateStream(Direction::Restore(&bytes)).growing(&mut list).unwrap();
        assert_eq!(
            list.iter().map(|value: &f64| value.to_bits()).collect::<Vec<_>>(),
            [1.0_f64, 2.0].map(f64::to_bits)
        );
        assert_eq!(list.capacity(), 7);
    }

    #[test]
    fn a_length_beyond_the_bytes_is_refused_without_allocation() {
        let endless = postcard::to_stdvec(&(u64::MAX, 1.0)).unwrap();
        assert!(StateStream(Direction::Restore(&endless)).growing(&mut Vec::<f64>::new()).is_err());
    }
}
