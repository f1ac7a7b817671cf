//! Response to the forces: third-octave levels and spectra, and the vibration of the tyre.
//!
//! In the order of the data's way:
//!
//! - [`accumulator`]: a record, sample by sample, to its averaged spectrum;
//! - [`spectrum`]: powers by frequency that lose nothing, and levels of bands;
//! - [`third_octave`]: the bands of the standard;
//! - [`slice_errors`]: how far levels of contact over slices are off; [`level_errors`]: by all that is known;
//! - [`speed_exponent`]: how a level grows with the speed;
//! - [`lateral_forces`]: forces on cells, resolved into lateral waves;
//! - [`vibration`]: the tyre's velocities from the contact forces.

pub mod accumulator;
pub mod lateral_forces;
pub mod level_errors;
pub mod pressure;
pub mod slice_errors;
pub mod spectrum;
pub mod speed_exponent;
pub mod third_octave;
pub mod vibration;

pub use accumulator::{SpectrumAccumulator, SpectrumState};
pub use lateral_forces::LateralForces;
pub use level_errors::LevelErrors;
pub use slice_errors::SliceErrors;
pub use spectrum::{BandLevel, PowerSpectrum, SpectrumError};
pub use speed_exponent::SpeedExponent;
pub use third_octave::ThirdOctaveBand;
