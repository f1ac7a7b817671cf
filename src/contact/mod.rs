//! Rolling contact in the time domain.
//!
//! - [`geometry`]: where tyre elements stand over the road, step by step;
//! - [`kernel`]: what the points in contact feel of each other within a step, by tread law;
//! - [`history`]: displacement left over from past forces;
//! - [`complementarity`]: which points touch, and their forces;
//! - [`cells`]: the same for cells of a zone in three dimensions;
//! - [`local_compliance`]: how much the tread yields to the texture, by formula and by pressing patches of a road;
//! - [`pressed`]: curves of slices from pressing the road in three dimensions;
//! - [`static_contact`]: contact at rest on a smooth road;
//! - [`axle`]: the axle's height, fixed, held to a load or moving;
//! - [`march`]: one time step after the other, [`footprint`] what each of them gives;
//! - [`stability`]: whether a time rule's inverse is stable for a tyre, before the run.

pub mod axle;
pub mod cells;
pub mod complementarity;
mod error;
pub mod footprint;
pub mod geometry;
pub mod history;
pub mod kernel;
pub mod local_compliance;
pub mod march;
pub mod pressed;
mod slices;
pub mod stability;
pub mod static_contact;
pub mod windows;
mod zone;

pub use error::ContactError;
