//! Acoustics of pressures at microphones: weighted levels, the microphones of the standards, a pass-by, sound files.
//!
//! This module does not depend on the source of the pressures: signals \[Pa\] and their spectra are given. In the order
//! of the data flow:
//!
//! - `frame`: positions and sides of a tyre; `receivers`: the microphones of the standards;
//! - `power`: the measurement surfaces of the sound power; `point_source`: the power of the point sources by which
//!   models of traffic noise represent a tyre;
//! - `weighting`: the A-weighting by frequency, `weighting_filter`: as a filter of a signal;
//! - `detector`: level of a sound level meter over time;
//! - `levels`: third octaves and overall levels; `covered`: the bands of these and what is missing above them; `total`:
//!   sums that are compared over common bands; `speed_coefficient`: levels over a range of speeds; `intensity`: sound
//!   intensity by a pair of microphones;
//! - `band_pass`: a signal restricted to a band of frequencies; `resample`: at the rate of a sound file;
//! - `pass_by`: pressure at a microphone beside the road as a tyre rolls by;
//! - `wav`: sound files that contain their calibration.
//!
//! # Frame
//! Origin on the road, below the axle's centre; x forward, in the direction of travel; y to the left; z up. Positions
//! are `[x, y, z]` in metres.

pub(crate) mod band_pass;
pub(crate) mod covered;
pub(crate) mod detector;
pub(crate) mod frame;
pub(crate) mod intensity;
pub(crate) mod levels;
pub(crate) mod pass_by;
pub(crate) mod point_source;
pub(crate) mod power;
pub(crate) mod receivers;
pub(crate) mod resample;
pub(crate) mod speed_coefficient;
pub(crate) mod total;
pub(crate) mod wav;
pub(crate) mod weighting;
pub(crate) mod weighting_filter;

pub use crate::radiation::Air;
pub(crate) use covered::CoveredBands;
pub use detector::{Detector, TimeWeighting, meter_levels};
pub use frame::Side;
pub use levels::{
    REFERENCE_PRESSURE, SoundLevels, energetic_mean, energetic_sum, level, mean_square, spectrum_of_density,
};
pub(crate) use pass_by::PassBy;
pub use power::Iso3744;
pub use receivers::circle::circle;
pub use receivers::coast_by::CoastByLine;
pub use receivers::cpx::close_proximity;
pub(crate) use speed_coefficient::SpeedCoefficient;
pub(crate) use total::Compared;
pub use total::TotalLevel;
pub use wav::{Recording, SampleFormat, WavError, full_scale_for};
pub use weighting::FrequencyWeighting;
pub use weighting_filter::{RateError, WeightingFilter};
