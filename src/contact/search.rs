//! The ways to find the forces of a step.

use super::active_set::{ActiveSet, Residuals, SearchCounts};
use super::error::ContactError;
use super::implicit_set::{ImplicitSet, SlicesUnder, Unsolved};
use super::tread::ContactKernel;
use crate::meter::{Clocks, Spent};
use crate::numeric::{StateError, StateReader, StateWriter};
use crate::scene::{Numerics, SliceCoupling, Tread};

/// How the forces of a step are found.
pub enum Search {
    /// All points together, their displacements given: the paper's equation 4.
    Explicit(Box<ActiveSet>),
    /// All points together, each slice's spring in series.
    Implicit(Box<ImplicitSet>),
    /// Each point by itself: F_i = max(0, d_i)/G0_ii.
    Alone {
        /// G0_ii \[m/N\].
        own: f64,
    },
}

impl Search {
    /// The search that tread law and coupling ask for. Points by themselves have no neighbours: both couplings are one.
    pub fn new(kernel: &ContactKernel, coupling: SliceCoupling, columns: usize, numerics: &Numerics) -> Self {
        let mut influence = kernel.instant[..columns].to_vec();
        influence[0] += kernel.spring;
        let tolerance = numerics.contact_tolerance;
        match (kernel.law, coupling) {
            (Tread::Uncoupled, _) => Self::Alone { own: influence[0] },
            (_, SliceCoupling::Implicit) => Self::Implicit(Box::new(ImplicitSet::new(influence, columns, tolerance))),
            (_, SliceCoupling::Explicit) => {
                let search = ActiveSet::new(influence, columns, tolerance, numerics.cached_factors);
                Self::Explicit(Box::new(search))
            }
        }
    }

    /// Whether [`Self::forces`] wants penetrations y; otherwise required displacements d = S(y).
    pub fn takes_penetrations(&self) -> bool {
        matches!(self, Self::Implicit(_))
    }

    /// Moves on by a number of elements: what was column i is column i - `by`.
    pub fn advance(&mut self, by: usize) {
        match self {
            Self::Explicit(search) => search.advance(by),
            Self::Implicit(search) => search.advance(by),
            Self::Alone { .. } => {}
        }
    }

    /// The forces at a step, from penetrations or required displacements; leaves the latter in `required`.
    ///
    /// # Errors
    /// [`ContactError::SingularMatrix`], [`ContactError::Unsettled`].
    pub fn forces(
        &mut self,
        required: &mut [f64],
        slices: SlicesUnder<'_>,
        forces: &mut [f64],
        step: u64,
    ) -> Result<Residuals, ContactError> {
        match self {
            Self::Explicit(search) => search.search(required, forces).map_err(|_| {
                let points = search.active().iter().filter(|&&active| active).count();
                ContactError::SingularMatrix { points, step }
            }),
            Self::Implicit(search) => search.search(slices, required, forces).map_err(|unsolved| match unsolved {
                Unsolved::Singular => ContactError::SingularMatrix { points: search.points(), step },
                Unsolved::Unsettled => ContactError::Unsettled { points: search.points(), step },
            }),
            Self::Alone { own } => {
                for (force, &required) in forces.iter_mut().zip(&*required) {
                    *force = required.max(0.0) / *own;
                }
                Ok(Residuals::default())
            }
        }
    }

    /// What was done so far.
    pub fn counts(&self) -> SearchCounts {
        match self {
            Self::Explicit(search) => search.counts(),
            Self::Implicit(search) => search.counts(),
            Self::Alone { .. } => SearchCounts::default(),
        }
    }

    /// Which clocks are read from now on; none at first.
    pub fn set_clocks(&mut self, clocks: Clocks) {
        match self {
            Self::Explicit(search) => search.set_clocks(clocks),
            Self::Implicit(search) => search.set_clocks(clocks),
            Self::Alone { .. } => {}
        }
    }

    /// Time of the factorisations since it was last taken.
    pub fn take_factorisation_time(&mut self) -> Spent {
        match self {
            Self::Explicit(search) => search.take_factorisation_time(),
            Self::Implicit(search) => search.take_factorisation_time(),
            Self::Alone { .. } => Spent::default(),
        }
    }

    /// Takes the state down.
    pub fn save(&self, state: &mut StateWriter) {
        match self {
            Self::Explicit(search) => search.save(state),
            Self::Implicit(search) => search.save(state),
            Self::Alone { .. } => {}
        }
    }

    /// Goes on from the state of an equal search.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        match self {
            Self::Explicit(search) => search.restore(state),
            Self::Implicit(search) => search.restore(state),
            Self::Alone { .. } => Ok(()),
        }
    }
}
