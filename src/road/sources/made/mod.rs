//! Roads that are made: isotropic random texture with a given profile spectrum, Gaussian or skewed.
//!
//! `target` turns levels or a power law into band energies of a profile, `rings` finds the two-dimensional spectrum
//! whose profiles have them, `sizes` divides it into levels of some octaves and computes their sizes, `levels` draws
//! each in patches, `synthesis` sums them row by row; `rows` has their inner loop.
//! `shape` gives heights their skewness and kurtosis, `translation` finds the Gaussian spectrum that the shape
//! transforms into the wanted one.

mod levels;
mod nnls;
mod rings;
mod rows;
mod shape;
mod sizes;
mod synthesis;
pub(crate) mod target;
mod translation;

pub use rings::RingSpectrum;
pub(crate) use shape::HeightShape;
pub(crate) use sizes::Sizes;
pub(crate) use synthesis::{Patches, RoadDesign, Texture};
pub(crate) use target::{PEAK_FACTOR, TargetSpectrum};
