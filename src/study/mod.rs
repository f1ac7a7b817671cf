//! Many runs: what a single one cannot say.
//!
//! - [`accuracy`]: accuracy against time of every knob, and whether the presets keep what they state;
//! - [`effects`]: what each effect is worth; [`rules`]: time rules side by side;
//! - [`fit_tyre`]: a tyre identified from measured mobilities;
//! - [`sweep`]: a scene at many speeds, loads and roads;
//! - [`loads`]: a tyre under given loads, standing and rolling; [`rolling_waves`]: its waves and critical speeds as it
//!   turns;
//! - [`slices`]: slices of a road by both laws;
//! - [`radiation`]: how a tyre radiates that stands on a road;
//! - [`validation`]: a scene held against published values;
//! - [`calibration`]: what units of work cost on this machine, for forecasts.
//!
//! Comparisons roll by [`trial`], which holds runs against each other, too.

pub mod accuracy;
pub mod calibration;
pub mod effects;
pub mod fit_tyre;
pub mod loads;
pub mod radiation;
pub mod rolling_waves;
pub mod rules;
pub mod slices;
pub mod sweep;
pub mod trial;
pub mod validation;
