//! Roads that are made: isotropic Gaussian random texture with a given profile spectrum.
//!
//! [`target`] turns levels or a power law into band energies of a profile, [`rings`] finds the two-dimensional spectrum whose
//! profiles have them, [`sizes`] says how large that is, [`synthesis`] draws the surface piece by piece, with the inner loops of `noise`.

mod noise;
pub mod rings;
pub mod sizes;
pub mod synthesis;
pub mod target;

pub use rings::RingSpectrum;
pub use sizes::Sizes;
pub use synthesis::{ChunkWork, Texture};
pub use target::{Band, BandFit, TargetSpectrum};
