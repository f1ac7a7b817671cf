//! Stiffness curves of the slices between the tyre's window and the road made so far.

use std::collections::VecDeque;

use crate::road::slices::StiffnessCurve;

/// A run of consecutive slices by element number. Elements outside it have no road: they cannot touch.
#[derive(Clone, Debug, Default)]
pub struct SliceQueue {
    first: i64,
    curves: VecDeque<StiffnessCurve>,
}

impl SliceQueue {
    /// An empty queue whose first slice will be that of element `first`.
    pub fn starting_at(first: i64) -> Self {
        Self { first, curves: VecDeque::new() }
    }

    /// Element number of the first slice.
    pub fn first(&self) -> i64 {
        self.first
    }

    /// Element number after the last slice.
    pub fn end(&self) -> i64 {
        self.first + self.curves.len() as i64
    }

    /// Appends slices.
    pub fn extend(&mut self, curves: impl IntoIterator<Item = StiffnessCurve>) {
        self.curves.extend(curves);
    }

    /// Forgets the slices before `element`.
    pub fn forget_before(&mut self, element: i64) {
        let passed = (element - self.first).clamp(0, self.curves.len() as i64);
        self.curves.drain(..passed as usize);
        self.first += passed;
    }

    /// The slice of an element, if there is road there.
    pub fn get(&self, element: i64) -> Option<&StiffnessCurve> {
        usize::try_from(element - self.first).ok().and_then(|index| self.curves.get(index))
    }
}
