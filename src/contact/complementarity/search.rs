//! The methods to find the forces of a step.

use super::active_set::{ActiveSet, Residuals};
use super::local_set::{LocalSet, SlicesUnder};
use super::pieces::{HeldPiece, LocalSlice};
use super::residue::Unsolved;
use super::sweeps::{SearchCounts, move_on};
use crate::contact::ContactError;
use crate::counters::Meter;
use crate::scene::Numerics;
use crate::storage::state::{Evolving, StateError, StateStream};

/// By how much a slice yields more than the element as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SliceLaw {
    /// As the paper's equation 4 has it: the curve is read at the penetration without the forces of the step.
    Explicit,
    /// In series with the coupled tread, with a compliance \[m/N\] that belongs to tread and texture.
    Local(f64),
}

/// How the forces of a step are found.
pub(crate) enum Search {
    /// All points together, their displacements given: the paper's equation 4.
    Explicit(Box<ActiveSet>),
    /// All points together, each slice yielding in series.
    Local(Box<LocalSet>),
    /// Each point alone, see `LocalSlice`.
    Alone {
        /// G0_ii \[m/N\].
        point_influence: f64,
        slice: LocalSlice,
        /// Where in its curve every column is.
        pieces: Vec<HeldPiece>,
    },
}

impl Search {
    /// The search that tread and slice law require; `influence` is that of a force within its step by distance
    /// \[m/N\], over all points, and `odd` its skew part, empty at rest. Points that are not `coupled` have no
    /// neighbours: by the paper's coupling, each yields with the compliance G0_ii.
    pub(crate) fn new(influence: Vec<f64>, odd: &[f64], coupled: bool, law: SliceLaw, numerics: &Numerics) -> Self {
        let columns = influence.len();
        let (point_influence, tolerance) = (influence[0], numerics.contact_tolerance);
        match (coupled, law) {
            (false, law) => {
                let compliance = match law {
                    SliceLaw::Local(compliance) => compliance,
                    SliceLaw::Explicit => point_influence,
                };
                let pieces = vec![HeldPiece::default(); columns];
                Self::Alone { point_influence, slice: LocalSlice::new(point_influence, compliance), pieces }
            }
            (true, SliceLaw::Explicit) => {
                let search = ActiveSet::new(influence, columns, tolerance, numerics.cached_factors);
                Self::Explicit(Box::new(search.with_skew(odd)))
            }
            (true, SliceLaw::Local(compliance)) => {
                let search = LocalSet::new(influence, compliance, columns, tolerance);
                Self::Local(Box::new(search.with_skew(odd)))
            }
        }
    }

    /// True if [`Self::forces`] takes penetrations y; otherwise required displacements d = S(y).
    pub(crate) fn takes_penetrations(&self) -> bool {
        !matches!(self, Self::Explicit(_))
    }

    /// Moves on by `by` elements: column i becomes column i - `by`.
    pub(crate) fn advance(&mut self, by: usize) {
        match self {
            Self::Explicit(search) => search.advance(by),
            Self::Local(search) => search.advance(by),
            Self::Alone { pieces, .. } => move_on(pieces, by),
        }
    }

    /// Finds the forces at a step \[N\], from penetrations or required displacements \[m\]; leaves the latter in
    /// `required`.
    ///
    /// # Errors
    /// [`ContactError::SingularMatrix`], [`ContactError::Unsettled`].
    pub(crate) fn forces(
        &mut self,
        required: &mut [f64],
        slices: SlicesUnder<'_>,
        forces: &mut [f64],
        step: u64,
        meter: &mut Meter,
    ) -> Result<Residuals, ContactError> {
        let error = |unsolved: Unsolved, points: usize| match unsolved {
            Unsolved::Singular => ContactError::SingularMatrix { points, step },
            Unsolved::Unsettled => ContactError::Unsettled { points, step },
        };
        match self {
            Self::Explicit(search) => search.search(required, forces, meter).map_err(|unsolved| {
                let points = search.active().iter().filter(|&&active| active).count();
                error(unsolved, points)
            }),
            Self::Local(search) => {
                search.search(slices, required, forces, meter).map_err(|unsolved| error(unsolved, search.points()))
            }
            Self::Alone { point_influence, slice, pieces } => {
                let columns = forces.iter_mut().zip(&mut *required).zip(pieces).enumerate();
                for (column, ((force, required), piece)) in columns {
                    *force = piece.force(*required, *slice, || slices.get(column));
                    if *force > 0.0 {
                        *required = *point_influence * *force;
                    }
                }
                Ok(Residuals::default())
            }
        }
    }

    /// Adds the displacements by the forces of the last search \[m\], springs included.
    pub(crate) fn add_displacement(&self, forces: &[f64], out: &mut [f64]) {
        let (factor, displaced) = match self {
            Self::Explicit(search) => (1.0, search.displacement()),
            Self::Local(search) => (1.0, search.displacement()),
            Self::Alone { point_influence, .. } => (*point_influence, forces),
        };
        out.iter_mut().zip(displaced).for_each(|(out, displaced)| *out += factor * displaced);
    }

    pub(crate) fn counts(&self) -> SearchCounts {
        match self {
            Self::Explicit(search) => search.counts(),
            Self::Local(search) => search.counts(),
            Self::Alone { .. } => SearchCounts::default(),
        }
    }
}

impl Evolving for Search {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        match self {
            Self::Explicit(search) => search.state(state),
            Self::Local(search) => search.state(state),
            Self::Alone { .. } => Ok(()),
        }
    }
}
