//! Rational models of the influence functions: one compact object that serves every speed, time step and road.
//!
//! From samples to models:
//!
//! - `ladder`: the points at which the exact functions may be sampled;
//! - `tree`: which wavenumber starts from which;
//! - `sampled`: the exact functions of one wavenumber on the ladder, and a model's errors there;
//! - `passivity`: whether a model generates energy, and its mending;
//! - `wavenumber`: the adaptive fit of one wavenumber; [`error`]: why it was refused;
//! - [`fit`](mod@fit): all wavenumbers, each started from a neighbour, in parallel;
//! - [`pole_model`]: poles and residues of a list of functions; [`model`]: of every wavenumber;
//! - `row`: a row of fits, each started from its neighbour;
//! - [`cache`]: models in the cache on disk;
//! - [`cells`]: fits of single waves, the history of contact cells;
//! - [`tractions`]: all components of tractions, over common poles; [`traction_model`]: the stored part of them;
//! - [`lateral`]: models of the waves of one lateral number, both faces;
//! - `tangential`: sideways motion of the surface under normal forces, over the same poles;
//!
//! Meaning of the tolerance: the error at s is relative to |H_n(s)|, or to 0.003 of the largest |H_n| over the band
//! where that is more: the contact feels G0, H_n far from its resonances, where it is small. A model within the
//! tolerance t is then within t of the largest |H_n| everywhere, and three hundred times better where H_n is smallest.
//! The carcass under a bedding has springs in series: its errors are relative to the whole tyre's H_n at rest where
//! that is more.
//!
//! H_n and its model are analytic and bounded for Re s >= 0 (all poles are stable) and vanish or become constant at
//! infinity, so by the maximum principle the error anywhere in the right half plane is at most the largest on the
//! imaginary axis. The axis is sampled up to the top frequency only; what lies beyond acts on a point s of the right
//! half plane with the harmonic measure 1 - (2/pi) atan(top/|s|) (two-constants theorem), which is small for |s| << top
//! but not near it: so the positive real axis, where G0 is evaluated, is sampled, fitted and checked as well.

pub(crate) mod cache;
pub(crate) mod cells;
pub(crate) mod error;
pub(crate) mod expected_fit;
pub(crate) mod fit;
mod ladder;
pub(crate) mod lateral;
pub(crate) mod model;
pub(crate) mod modes;
mod passivity;
pub(crate) mod pole_model;
mod row;
mod sampled;
mod tangential;
pub(crate) mod traction_model;
pub(crate) mod tractions;
mod tree;
#[cfg(test)]
pub(crate) mod turning_ring;
mod wavenumber;

pub use error::FitError;
#[cfg(test)]
pub(crate) use fit::fit;
pub use fit::fit_unless_stopped;
pub(crate) use fit::{FitOptions, FitTimes, fit_timed};
pub(crate) use model::RationalModel;
pub use modes::Direction;
pub(crate) use modes::WaveModes;
pub(crate) use tangential::{TangentialModel, lateral_tangential_model, tangential_model};
