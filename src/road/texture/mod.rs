//! Texture measures: [`profile`] has a profile's line and height, [`depth`] its mean profile depth, [`levels`] its
//! third octaves, [`wavenumber`] how fine the surface is.

pub(crate) mod depth;
pub(crate) mod levels;
pub(crate) mod profile;
pub(crate) mod wavenumber;

pub(crate) use depth::{HeightOrigin, ProfileDepth};
pub(crate) use levels::{
    BandFit, LOWEST_LEVEL, OverallLevel, ProfileSpectrum, TextureLevel, band_edges, bands_between, level, line_inside,
    mean_square, mid_wavelength, nearest_band,
};
pub(crate) use profile::{line_of, rms};
