//! From influence functions to what the points in contact feel of each other within a step: the first weight G0.
//!
//! Tread laws:
//! - `elastic`: influence functions of the tread surface;
//! - `uncoupled`: the same history, but within a step each point only feels itself (the diagonal of G0, scaled for an
//!   equal static stiffness if that is wanted). G0 falls with the time step, and what is left out with it: the limit is
//!   `elastic` (tests/suite/convergence.rs), so that differences from it are differences of the time step;
//! - `bedding`: influence functions of the carcass with the tread as mass on it, and one independent spring per element
//!   in series. Without its shear stiffness the tread leaves the carcass softer than the whole tyre is (default tyre,
//!   12 mm: 2587 N with rigid springs, 2767 N elastic), so no spring alone makes both alike: `equal_bedding` scales
//!   the influence functions, too.

use super::error::ContactError;
use super::static_contact::{StaticContact, matched};
use crate::numeric::Ring;
use crate::scene::Tread;

/// Influence between the points in contact within a step.
#[derive(Clone, Debug)]
pub struct ContactKernel {
    law: Tread,
    /// G0 of the element j further on, j = 0..N (periodic) \[m/N\]; springs not included.
    pub instant: Vec<f64>,
    /// Spring compliance per element \[m/N\]; 0 without springs.
    pub spring: f64,
    /// Factor of the influence functions, of G0 and of the history alike.
    pub(super) scale: f64,
}

impl ContactKernel {
    /// From the first weights w_(n,0), n = 0..=N/2 \[m/N\], of N elements, before the bedding scales them.
    ///
    /// # Errors
    /// [`ContactError::NotPositive`] unless all eigenvalues of the circulant G0 are positive.
    pub fn new(
        law: Tread,
        first_weights: &[f64],
        elements: usize,
        EqualBedding { scale, spring }: EqualBedding,
    ) -> Result<Self, ContactError> {
        let eigenvalues = first_weights.iter().map(|weight| elements as f64 * (scale * weight) + spring);
        let (smallest, largest) = eigenvalues.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        if !(smallest > 0.0 && largest.is_finite()) {
            return Err(ContactError::NotPositive { smallest, largest });
        }
        let instant = Ring::new(elements).elements_of(|n| scale * first_weights[n]).to_vec();
        Ok(Self { law, instant, spring, scale })
    }

    /// Tells whether points feel each other within a step.
    pub(crate) fn is_coupled(&self) -> bool {
        self.law != Tread::Uncoupled
    }

    /// Returns the influence within a step on the element j further on, j = 0..N \[m/N\], springs included.
    pub(crate) fn within_a_step(&self) -> Vec<f64> {
        let mut influence = self.instant.clone();
        influence[0] += self.spring;
        if !self.is_coupled() {
            influence[1..].fill(0.0);
        }
        influence
    }

    /// Returns the addition to G0_ii \[m/N\] for points that do not feel each other within a step to have the static
    /// force `wanted` at its indentation, from the static influence: at rest all steps but the last are history, so the
    /// influence is the static one less G0, and G0_ii and the addition on its diagonal.
    ///
    /// # Errors
    /// As [`matched`].
    pub(crate) fn uncoupled_spring(
        &self,
        static_row: &[f64],
        circumference: f64,
        wanted: StaticContact,
    ) -> Result<f64, ContactError> {
        let past: Vec<f64> = static_row.iter().zip(&self.instant).map(|(all, now)| all - now).collect();
        let own = matched((1e-6 * static_row[0], 1e6 * static_row[0]), circumference, wanted, |spring| {
            let mut row = past.clone();
            row[0] += spring;
            row
        })?;
        Ok(own - self.instant[0])
    }
}

/// Scale of the influence functions and spring of a bedding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EqualBedding {
    /// Factor of the carcass's influence functions.
    pub scale: f64,
    /// Spring compliance per element \[m/N\].
    pub spring: f64,
}

impl EqualBedding {
    /// Nothing: no bedding.
    pub const NONE: Self = Self { scale: 1.0, spring: 0.0 };
}

/// The bedding with the static stiffness of the elastic tread twice over: that of one element pressed alone, scale
/// carcass_0 + spring = surface_0, and that of the smooth contact, the force `wanted` at its indentation. `carcass` and
/// `surface` are static influence rows.
///
/// # Errors
/// As [`matched`].
pub(crate) fn equal_bedding(
    carcass: &[f64],
    surface: &[f64],
    circumference: f64,
    wanted: StaticContact,
) -> Result<EqualBedding, ContactError> {
    let most = surface[0] / carcass[0];
    let scale = matched((1e-3 * most, most), circumference, wanted, |scale| {
        let mut row: Vec<f64> = carcass.iter().map(|influence| scale * influence).collect();
        row[0] = surface[0];
        row
    })?;
    Ok(EqualBedding { scale, spring: surface[0] - scale * carcass[0] })
}
