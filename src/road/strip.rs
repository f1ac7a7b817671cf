//! The road between the tyre's window and the last slice made, slice by slice.

use std::collections::VecDeque;

use super::slices::StiffnessCurve;

/// Consecutive slices by element number. Elements outside have no road: they cannot touch.
#[derive(Clone, Debug, Default)]
pub struct RoadStrip {
    first: i64,
    slices: VecDeque<RoadSlice>,
}

/// The road under an element, in the form that the contact needs.
#[derive(Clone, Debug, PartialEq)]
pub enum RoadSlice {
    /// Curve of the displacement of the slice as a whole.
    Curve(StiffnessCurve),
    /// Heights of its cells \[m\].
    Heights(Box<[f64]>),
}

impl RoadSlice {
    /// The curve; `None` for heights of cells.
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
    /// An empty strip whose first slice will be that of element `first`.
    pub fn starting_at(first: i64) -> Self {
        Self { first, slices: VecDeque::new() }
    }

    /// Element number of the first slice.
    pub fn first(&self) -> i64 {
        self.first
    }

    /// Element number after the last slice.
    pub fn end(&self) -> i64 {
        self.first + self.slices.len() as i64
    }

    /// Appends slices of the following elements.
    pub fn extend<S: Into<RoadSlice>>(&mut self, slices: impl IntoIterator<Item = S>) {
        self.slices.extend(slices.into_iter().map(Into::into));
    }

    /// Removes the slices before `element`.
    pub fn forget_before(&mut self, element: i64) {
        let passed = (element - self.first).clamp(0, self.slices.len() as i64);
        self.slices.drain(..passed as usize);
        self.first += passed;
    }

    /// True if the road consists of curves; also true while it is empty.
    pub fn has_curves(&self) -> bool {
        matches!(self.slices.front(), None | Some(RoadSlice::Curve(_)))
    }

    /// True if the road consists of heights of cells; also true while it is empty.
    pub fn has_heights(&self) -> bool {
        matches!(self.slices.front(), None | Some(RoadSlice::Heights(_)))
    }

    /// Curve of an element's slice; `None` outside the strip and for heights.
    pub fn curve(&self, element: i64) -> Option<&StiffnessCurve> {
        self.slice(element).and_then(RoadSlice::curve)
    }

    /// Heights of the cells under an element \[m\]; `None` outside the strip and for curves.
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
