//! What is heard of the forces: third-octave levels and spectra, and the vibration of the tyre.

pub mod accumulator;
pub mod spectrum;
pub mod speed_exponent;
pub mod third_octave;
pub mod vibration;

pub use accumulator::{SpectrumAccumulator, SpectrumState};
pub use spectrum::{BandLevel, PowerSpectrum, SpectrumError};
pub use speed_exponent::SpeedExponent;
pub use third_octave::ThirdOctaveBand;
