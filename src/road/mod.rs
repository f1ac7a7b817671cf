//! Roads: measured or made height maps, brought to the run's elements, and the stiffness curve of each slice.
//!
//! A reader ([`profile`], [`opencrg`], [`grid`]) delivers a [`height_map`]; [`resample`] brings it to the run's
//! [`lattice`] and continues it past its end. [`made`] roads are drawn on that lattice directly. [`surface`] is the one
//! face of all of them; [`texture`] measures, [`describe`](mod@describe) tells.

pub mod describe;
pub mod error;
pub mod grid;
pub mod height_map;
pub mod lattice;
pub mod made;
pub mod opencrg;
pub mod profile;
pub mod read;
pub mod report;
pub mod resample;
pub mod slices;
pub mod surface;
pub mod texture;
pub mod wavenumber;

pub use describe::{RoadDescription, describe};
pub use error::RoadError;
pub use lattice::Lattice;
pub use report::{RoadNote, RoadReport};
pub use surface::{Limits, RoadSurface};

#[cfg(test)]
mod tests;
