//! Rolling contact in the time domain.
//!
//! - [`geometry`]: where tyre elements stand over the road, step by step;
//! - [`kernel`]: influence between the points in contact within a step, by tread law;
//! - [`history`]: displacement by past forces;
//! - [`complementarity`]: which points touch, and their forces;
//! - [`cells`]: the same for cells of a zone in three dimensions;
//! - [`friction`]: the same with tangential forces, sticking and slipping;
//! - [`local_compliance`]: how much the tread yields to the texture, by formula and by pressing patches of a road;
//! - [`pressed`]: curves of slices from pressing the road in three dimensions;
//! - [`static_contact`]: contact at rest on a smooth road;
//! - [`axle`]: the axle's height, fixed, held to a load or moving;
//! - [`tread`]: the undeformed tread, crown and pattern;
//! - [`march`]: one time step after the other, [`footprint`] the forces and displacements of each;
//! - [`stability`]: whether a time rule's inverse is stable for a tyre, before the run.

pub(crate) mod axle;
pub(crate) mod cells;
pub(crate) mod complementarity;
pub(crate) mod error;
pub(crate) mod footprint;
pub(crate) mod friction;
pub(crate) mod geometry;
pub(crate) mod history;
pub(crate) mod kernel;
pub(crate) mod local_compliance;
pub(crate) mod march;
pub(crate) mod pressed;
mod slices;
pub(crate) mod stability;
pub(crate) mod static_contact;
pub(crate) mod tread;
pub(crate) mod windows;
pub(crate) mod zone;

pub use error::ContactError;
