//! A rigid rough body: its `map` of heights is pressed into the half-space.
//!
//! `convolution` multiplies pressures with an influence, `gradients` find those that keep the contact
//! conditions; `indentation` is the contact with a free boundary, `periodic` that of a piece repeated for ever.

mod convolution;
mod gradients;
mod indentation;
mod map;
mod periodic;

pub use convolution::{Convolution, Extent};
pub use indentation::{Indentation, IndentationControl, indent};
pub use map::{HeightMap, IndentationLimits};
pub(crate) use periodic::PeriodicContact;
