//! Roads: measured or made height maps, brought to the run's elements, and the stiffness curve of each slice.
//!
//! The data flow: `sources` read a file or a design; `resample` brings a measured height map to the run's lattice and
//! continues it past its end, a made texture is drawn on that lattice directly. `surface` is the common interface of
//! all of them. `slices` turn its heights into curves; `strip` is the part that lies under the tyre and is made;
//! `ahead` has the next part made in time, by its `maker`. `texture` measures, [`describe`](fn@describe) reports.
//! `profiles` are those along the road at its own spacing. `report` has what was found meanwhile, `error` why a road
//! cannot be used, `file_fault` what is wrong with its file.

mod across;
pub(crate) mod ahead;
mod describe;
mod error;
mod file_fault;
mod lattice;
pub(crate) mod maker;
mod piece_rows;
mod profiles;
mod report;
pub(crate) mod resample;
pub(crate) mod slices;
pub(crate) mod sources;
pub(crate) mod strip;
mod surface;
pub(crate) mod texture;

pub use describe::{RoadDescription, describe};
pub use error::{RoadError, RoadFileFault};
pub use lattice::Lattice;
pub(crate) use profiles::RoadProfiles;
pub use report::RoadReport;
pub use slices::builder::{SliceBuilder, SliceScratch};
pub use slices::{SliceError, StiffnessCurve};
pub use surface::{Limits, RoadSurface};
pub use texture::depth::ProfileDepth;
pub use texture::levels::TextureLevel;

#[cfg(test)]
mod tests;
