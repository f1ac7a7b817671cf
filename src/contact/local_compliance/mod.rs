//! How much a scene's tread yields to its road's texture, the one parameter of the local contact law.
//!
//! [`formula`] gives it from the tread's modulus and the road's wavenumbers; [`calibrate`](mod@calibrate) by pressing
//! a [`patch`] of the road: by the half-space, and by the local law on a line of elements ([`line_law`]).

pub(crate) mod calibrate;
pub(crate) mod formula;
pub(crate) mod line_law;
pub(crate) mod patch;

pub(crate) use calibrate::{Calibration, CalibrationError, calibrate};
pub use formula::local_compliance;
pub(crate) use formula::{UNCERTAINTY, formula_for};
