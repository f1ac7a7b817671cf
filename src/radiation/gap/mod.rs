//! Sound in the thin gap between a tyre and the road: grooves that run through the contact patch, and the wedges before
//! and behind it.
//!
//! Where the gap is thin against the wavelength the pressure is even over its height h and follows the gap equation in
//! two dimensions, with the losses in the boundary layers of both walls ([`medium`]). [`sheet`] solves it by finite
//! volumes with [`banded`] factors; [`patch`] cuts the sheet out of a tyre on its road; [`resonance`] finds resonances
//! of its responses.

pub(crate) mod banded;
pub(crate) mod medium;
pub(crate) mod patch;
pub(crate) mod resonance;
pub(crate) mod sheet;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use medium::GapAir;
