//! From influence functions to the influence between the points in contact within a step: the first weight G0.
//!
//! With the rotation Om, w_(n,0) = H_n(s) = E_n + i O_n at a real s, and G0 is real and not symmetric: its
//! symmetric part is that of the E_n, its skew part that of the O_n. By the energies of the motion |O_n| <= (2 Om/s)
//! E_n, so that the symmetric part is positive definite and G0 has one solution of every contact.
//!
//! Tread laws:
//! - `elastic`: influence functions of the tread surface;
//! - `uncoupled`: the same history, but within a step each point only influences itself (the diagonal of G0, scaled for
//!   an equal static stiffness if that is wanted). G0 falls with the time step, and the omitted part with it: the limit
//!   is `elastic` (tests/suite/convergence.rs), so that differences from it are differences of the time step;
//! - `bedding`: influence functions of the carcass with the tread as mass on it, and one independent spring per element
//!   in series. Without its shear stiffness the tread leaves the carcass softer than the whole tyre is (default tyre,
//!   12 mm: 2587 N with rigid springs, 2767 N elastic), so no spring alone makes both alike: `equal_bedding` scales
//!   the influence functions, too.

use super::error::ContactError;
use super::static_contact::{StaticContact, matched};
use crate::numeric::Ring;
use crate::scene::Tread;

/// Largest |O_n|/E_n of a first weight: each correction of the forces leaves less than this part of the skew part's
/// share, see [`complementarity`](super::complementarity). A tyre has some thousandths.
const MOST_SKEW: f64 = 0.25;

/// Influence between the points in contact within a step.
#[derive(Clone, Debug)]
pub struct ContactKernel {
    law: Tread,
    /// G0 of the element j further on, j = 0..N (periodic) \[m/N\], its symmetric part; springs not included.
    pub instant: Vec<f64>,
    /// Its skew part, likewise; empty at rest.
    pub odd: Vec<f64>,
    /// Spring compliance per element \[m/N\]; 0 without springs.
    pub spring: f64,
    /// Factor of the influence functions, of G0 and of the history alike.
    pub(super) scale: f64,
}

impl ContactKernel {
    /// Kernel of the first weights w_(n,0), n = 0..=N/2 \[m/N\], of N elements, before the bedding scales them: those
    /// of the even and of the odd parts, the latter empty at rest.
    ///
    /// # Errors
    /// [`ContactError::NotPositive`] unless all eigenvalues of the circulant G0 are positive, of a tyre that turns
    /// those of its symmetric part; [`ContactError::TooSkew`] if the odd parts are not small beside them.
    pub fn new(
        law: Tread,
        [first_weights, odd_weights]: [&[f64]; 2],
        elements: usize,
        EqualBedding { scale, spring }: EqualBedding,
    ) -> Result<Self, ContactError> {
        let eigenvalues = first_weights.iter().map(|weight| elements as f64 * (scale * weight) + spring);
        let (smallest, largest) = eigenvalues.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        if !(smallest > 0.0 && largest.is_finite()) {
            return Err(ContactError::NotPositive { smallest, largest });
        }
        let mut ring = Ring::new(elements);
        let instant = ring.elements_of(|n| scale * first_weights[n]).to_vec();
        let mut odd = Vec::new();
        if !odd_weights.is_empty() {
            let of_even = |(even, odd): (&f64, &f64)| odd.abs() / (even + spring / (scale * elements as f64));
            let skewness = first_weights.iter().zip(odd_weights).map(of_even).fold(0.0, f64::max);
            if skewness.is_nan() || skewness >= MOST_SKEW {
                return Err(ContactError::TooSkew { skewness });
            }
            odd = ring.odd_elements_of(|n| scale * odd_weights[n]).to_vec();
        }
        Ok(Self { law, instant, odd, spring, scale })
    }

    /// True if points influence each other within a step.
    pub(crate) fn is_coupled(&self) -> bool {
        self.law != Tread::Uncoupled
    }

    /// Influence within a step on the element j further on, j = 0..N \[m/N\], springs included; of a tyre that turns
    /// the symmetric part.
    pub(crate) fn within_a_step(&self) -> Vec<f64> {
        let mut influence = self.instant.clone();
        influence[0] += self.spring;
        if !self.is_coupled() {
            influence[1..].fill(0.0);
        }
        influence
    }

    /// Skew part of that influence \[m/N\]; empty at rest, and where points do not influence each other.
    pub(crate) fn odd_within_a_step(&self) -> &[f64] {
        if self.is_coupled() { &self.odd } else { &[] }
    }

    /// Addition to G0_ii \[m/N\] with which points that do not influence each other within a step have the static
    /// force `wanted` at its indentation. At rest all steps but the last are history, so the influence is the static
    /// one less G0, plus G0_ii and the addition on its diagonal. The skew part of G0 of a tyre that turns is left out:
    /// the force is even in it.
    ///
    /// # Errors
    /// As [`matched`].
    pub(crate) fn uncoupled_spring(
        &self,
        static_row: &[f64],
        circumference: f64,
        wanted: StaticContact,
    ) -> Result<f64, ContactError> {
        let earlier: Vec<f64> = static_row.iter().zip(&self.instant).map(|(all, now)| all - now).collect();
        let diagonal = matched((1e-6 * static_row[0], 1e6 * static_row[0]), circumference, wanted, |spring| {
            let mut row = earlier.clone();
            row[0] += spring;
            row
        })?;
        Ok(diagonal - self.instant[0])
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
    /// No bedding: influence functions as they are, no spring.
    pub const NONE: Self = Self { scale: 1.0, spring: 0.0 };
}

/// Bedding with the static stiffness of the elastic tread in two respects: that of one element pressed alone, scale
/// carcass_0 + spring = surface_0, and that of the smooth contact, the force `wanted` at its indentation. `carcass`
/// and `surface` are static influence rows \[m/N\].
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
