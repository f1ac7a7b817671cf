//! Texture measures: [`profile`] has a profile's line, height and depth, [`levels`] its third octaves, [`wavenumber`]
//! how fine the surface is.

pub mod levels;
pub mod profile;
pub mod wavenumber;

pub use levels::{BandFit, ProfileSpectrum, TextureLevel, band_edges, bands_between};
pub use levels::{LOWEST_LEVEL, level, line_inside, mean_square, mid_wavelength, nearest_band};
pub use profile::{line_of, mean_profile_depth, remove_line, rms};
