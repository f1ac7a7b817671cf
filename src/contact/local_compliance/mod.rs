//! How much a scene's tread yields to its road's texture, the one parameter of the local contact law.
//!
//! [`formula`] has it from the tread's modulus and the road's wavenumbers; [`calibrate`](mod@calibrate) presses: a
//! [`patch`] of the road by the half-space, and by the local law on a line of elements ([`line_law`]).

pub mod calibrate;
pub mod formula;
pub mod line_law;
pub mod patch;

pub use calibrate::{Calibration, CalibrationError, calibrate};
pub use formula::{DOUBTS, formula_for, local_compliance};
