//! Model of a scene: one type per table of the TOML file, each with its keys and the conditions between them.
//!
//! SI units throughout; a key carries its unit in its name only where another unit is customary (`speed_kmh`). Values
//! are as the user wrote them or the documented default; [`Scene::load`] has checked their ranges.

mod conditioning;
mod contact;
mod cords;
mod effects;
mod friction;
mod inflation;
mod made_road;
mod material;
mod named_texture;
mod numerics;
mod road;
mod rolling;
mod scene;
mod sound;
mod tread_pattern;
mod tyre;
mod vibration;

pub use crate::time_rule::TimeRule;

pub use conditioning::{Levelling, MissingHeight};
pub use contact::*;
pub use cords::*;
pub use effects::*;
pub use friction::*;
pub use inflation::*;
pub use made_road::*;
pub use material::*;
pub use named_texture::*;
pub use numerics::*;
pub use road::*;
pub use rolling::*;
pub use scene::*;
pub(in crate::scene) use sound::array_placement;
pub use sound::{
    AirMotion, AirPumping, PatchAir, Radiation, RadiationQuality, Receiver, ReceiverPlace, StandardReceiver, Vehicle,
};
pub use tread_pattern::*;
pub use tyre::*;
pub use vibration::*;
