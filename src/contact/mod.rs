//! Rolling contact in the time domain.
//!
//! - [`geometry`]: where tyre elements stand over the road, step by step;
//! - [`tread`]: influence functions brought to the contact: first weights G0 and kernels of the history;
//! - [`history`]: displacement left over from past forces, by direct convolution in the contact frame (the reference
//!   path);
//! - [`active_set`]: which points touch, and their forces; [`factors`] caches the factorisations, found by
//!   [`pattern_index`];
//! - [`local_set`]: the same with slices that yield by themselves; [`search`] chooses;
//! - [`local_compliance`]: how much the tread yields to the texture, by formula;
//! - [`march`]: one time step after the other;
//! - [`axle`]: axle height, static solution; [`moving_axle`]: an axle with a mass;
//! - [`stability`]: whether a time rule's inverse is stable for a tyre, before the run.

pub mod active_set;
pub mod axle;
pub mod error;
pub mod factors;
pub mod geometry;
pub mod history;
pub mod ldlt;
pub mod local_compliance;
pub mod local_set;
pub mod march;
pub mod moving_axle;
mod neighbour_set;
pub mod pattern_index;
pub mod search;
pub mod slice_queue;
pub mod stability;
mod sweeps;
pub mod tread;
mod windows;

pub use error::ContactError;
