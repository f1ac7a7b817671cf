//! Response to the forces: third-octave levels and spectra, and the vibration of the tyre.
//!
//! In the order of the data flow:
//!
//! - `accumulator`: a record, sample by sample, to its averaged spectrum;
//! - `spectrum`: powers by frequency without loss of energy, and levels of bands;
//! - `third_octave`: the bands of the standard; `band_gain`: gains of bands;
//! - `mesh_correction`: levels of a long run over a coarse mesh, corrected by short ones over two;
//! - `slice_errors`: errors of levels of contact over slices; `level_errors`: the sum of all known errors;
//! - `speed_exponent`: how a level grows with the speed;
//! - `orders`: amplitudes by order of the revolution;
//! - `lateral_forces`: forces on cells, resolved into lateral waves; `squeezed_volumes`: volumes that they displace at
//!   blocks;
//! - `vibration`: the tyre's velocities from the contact forces.

pub(crate) mod accumulator;
pub(crate) mod band_gain;
pub(crate) mod lateral_forces;
pub(crate) mod level_errors;
pub(crate) mod mesh_correction;
pub(crate) mod orders;
pub(crate) mod pressure;
pub(crate) mod slice_errors;
pub(crate) mod spectrum;
pub(crate) mod speed_exponent;
pub(crate) mod squeezed_volumes;
pub(crate) mod third_octave;
pub(crate) mod vibration;

pub use accumulator::SpectrumAccumulator;
pub(crate) use band_gain::{BandGain, gain_at};
pub(crate) use lateral_forces::LateralForces;
pub(crate) use level_errors::LevelErrors;
pub(crate) use mesh_correction::MeshCorrection;
pub(crate) use orders::{Order, Orders};
pub(crate) use slice_errors::SliceErrors;
pub use spectrum::{BandLevel, PowerSpectrum, SpectrumError};
pub(crate) use speed_exponent::SpeedExponent;
pub(crate) use squeezed_volumes::SqueezedVolumes;
pub use third_octave::ThirdOctaveBand;
