//! Texture measures: [`profile`] has a profile's line and height, [`depth`] its mean profile depth, [`levels`] its
//! third octaves, [`wavenumber`] how fine the surface is.

pub mod depth;
pub mod levels;
pub mod profile;
pub mod wavenumber;

pub use depth::ProfileDepth;
pub use levels::{BandFit, OverallLevel, ProfileSpectrum, TextureLevel, band_edges, bands_between};
pub use levels::{LOWEST_LEVEL, level, line_inside, mean_square, mid_wavelength, nearest_band};
pub use profile::{line_of, remove_line, rms};
