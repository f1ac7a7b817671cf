//! What a scene says, as plain data: one type per table of the TOML file.
//!
//! SI units throughout; a key carries its unit in its name only where people think in another one (`speed_kmh`).
//! Values are as the user wrote them or the documented default; [`Scene::load`] has checked their ranges.

mod contact;
mod effects;
mod material;
mod numerics;
mod road;
mod rolling;
mod sound;
mod tyre;
mod vibration;

use serde::Serialize;

pub use crate::time_rule::TimeRule;

pub use contact::*;
pub use effects::*;
pub use material::*;
pub use numerics::*;
pub use road::*;
pub use rolling::*;
pub use sound::*;
pub use tyre::*;
pub use vibration::*;

/// A complete scene: what rolls, on what, how fast, and what is wanted from it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scene {
    /// Free text, shown in results and plots.
    pub title: String,
    /// The tyre: given in place or, in the file, by the path of a tyre file.
    pub tyre: Tyre,
    /// The road.
    pub road: Road,
    /// Speed, duration and axle.
    pub rolling: Rolling,
    /// Contact law of tread and road slices.
    pub contact: Contact,
    /// What is simulated beside the contact itself.
    pub effects: Effects,
    /// Resolution and tolerances.
    pub numerics: Numerics,
    /// What is written.
    pub outputs: Outputs,
    /// Where the sound pressure is wanted; `[[receiver]]` in the file.
    #[serde(rename = "receiver", skip_serializing_if = "Vec::is_empty")]
    pub receivers: Vec<Receiver>,
    /// How sound gets there.
    #[serde(skip_serializing_if = "is_default")]
    pub radiation: Radiation,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
