//! Texture measures: [`depth`] has a profile's mean profile depth, [`levels`] its line, height and third octaves,
//! [`wavenumber`] how fine the surface is.

pub(crate) mod depth;
pub(crate) mod levels;
pub(crate) mod wavenumber;

pub(crate) use depth::{HeightOrigin, ProfileDepth};
pub(crate) use levels::{
    BandFit, LOWEST_LEVEL, OverallLevel, ProfileSpectrum, TextureLevel, band_edges, bands_between, level, line_inside,
    line_of, mean_square, mid_wavelength, nearest_band, rms,
};
