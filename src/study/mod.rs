//! Many runs: what a single one cannot say.
//!
//! - [`accuracy`]: accuracy against time of every knob, and whether the presets keep what they state;
//! - [`effects`]: contribution of each effect;
//! - [`emission`]: a sweep's sound as models of traffic noise take it;
//! - [`fit_tyre`]: a tyre identified from measured mobilities;
//! - [`sweep`]: a scene at many speeds, loads and roads;
//! - [`loads`]: a tyre under given loads, standing and rolling; [`rolling_waves`]: its waves and critical speeds as it
//!   turns;
//! - [`slices`]: slices of a road by both laws;
//! - [`radiation`]: sound radiation of a tyre that stands on a road;
//! - [`validation`]: a scene compared with published values;
//! - [`calibration`]: what units of work cost on this machine, for forecasts.
//!
//! Comparisons roll by [`trial`], which also compares runs with each other.

pub(crate) mod accuracy;
pub(crate) mod calibration;
pub(crate) mod effects;
pub(crate) mod emission;
pub(crate) mod fit_tyre;
pub(crate) mod loads;
pub(crate) mod radiation;
pub(crate) mod rolling_waves;
pub(crate) mod slices;
pub(crate) mod sweep;
pub(crate) mod trial;
pub(crate) mod validation;
