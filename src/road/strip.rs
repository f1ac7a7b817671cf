//! The road between the tyre's window and what is made so far, slice by slice.

use std::collections::VecDeque;

use super::slices::StiffnessCurve;

/// A run of consecutive slices by element number. Elements outside it have no road: they cannot touch.
#[derive(Clone, Debug, Default)]
pub struct RoadStrip {
    first: i64,
    slices: VecDeque<RoadSlice>,
}

/// The road under an element, as the contact takes it.
#[derive(Clone, Debug, PartialEq)]
pub enum RoadSlice {
    /// How the slice as a whole deforms the tread.
    Curve(StiffnessCurve),
    /// Heights of its cells \[m\].
    Heights(Box<[f64]>),
}

impl RoadSlice {
    /// Returns its curve, if it is told as one.
    pub fn curve(&self) -> Option<&StiffnessCurve> {
        match self {
            Self::Curve(curve) => Some(curve),
            Self::Heights(_) => None,
        }
    }
}

impl From<StiffnessCurve> for RoadSlice {
    fn from(curve: StiffnessCurve) -> Self {
        Self::Curve(curve)
    }
}

impl RoadStrip {
    /// Returns an empty queue whose first slice will be that of element `first`.
    pub fn starting_at(first: i64) -> Self {
        Self { first, slices: VecDeque::new() }
    }

    /// Returns the element number of the first slice.
    pub fn first(&self) -> i64 {
        self.first
    }

    /// Returns the element number after the last slice.
    pub fn end(&self) -> i64 {
        self.first + self.slices.len() as i64
    }

    /// Appends slices.
    pub fn extend<S: Into<RoadSlice>>(&mut self, slices: impl IntoIterator<Item = S>) {
        self.slices.extend(slices.into_iter().map(Into::into));
    }

    /// Forgets the slices before `element`.
    pub fn forget_before(&mut self, element: i64) {
        let passed = (element - self.first).clamp(0, self.slices.len() as i64);
        self.slices.drain(..passed as usize);
        self.first += passed;
    }

    /// Tells whether the road is told as curves; so is one of which nothing is made yet.
    pub fn has_curves(&self) -> bool {
        matches!(self.slices.front(), None | Some(RoadSlice::Curve(_)))
    }

    /// Tells whether it is told as heights of cells; so is one of which nothing is made yet.
    pub fn has_heights(&self) -> bool {
        matches!(self.slices.front(), None | Some(RoadSlice::Heights(_)))
    }

    /// Returns the curve of an element's slice, if there is road there.
    pub fn curve(&self, element: i64) -> Option<&StiffnessCurve> {
        self.slice(element).and_then(RoadSlice::curve)
    }

    /// Returns the heights of the cells under an element \[m\], if there is road there.
    pub fn heights(&self, element: i64) -> Option<&[f64]> {
        match self.slice(element) {
            Some(RoadSlice::Heights(heights)) => Some(heights),
            _ => None,
        }
    }

    fn slice(&self, element: i64) -> Option<&RoadSlice> {
        usize::try_from(element - self.first).ok().and_then(|index| self.slices.get(index))
    }
}
