//! A rigid rough body: its height `map` is pressed into the half-space.
//!
//! `convolution` multiplies pressures by an influence, `gradients` finds those that satisfy the contact conditions;
//! `indentation` is the contact with a free boundary, `periodic` that of a patch repeated without end.

mod convolution;
mod gradients;
mod indentation;
mod map;
mod periodic;

pub use convolution::{Convolution, Extent};
pub use indentation::{Indentation, IndentationControl, indent};
pub use map::{HeightMap, IndentationLimits};
pub(crate) use periodic::PeriodicContact;
