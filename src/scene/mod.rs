//! Scene files, parsed and checked, with every complaint pointing into the file.
//!
//! [`Scene::load`] reads a file, [`Scene::from_str`] a text; both return a [`LoadedScene`], which later stages use to
//! complain about a key ([`LoadedScene::complain`]). All mistakes of a file are collected in one [`SceneError`].

mod consistency;
mod document;
mod error;
mod keys;
mod kind;
mod load;
mod microphone_array;
pub(crate) mod model;
mod plausible;
mod problem;
mod receiver_file;
pub(crate) mod schema;
mod setting;
pub(crate) mod sizes;
mod table;
#[cfg(test)]
pub(crate) mod tests;
mod tread_pattern;

pub use error::SceneError;
pub(crate) use error::SetUpError;
pub use load::LoadedScene;
pub(crate) use load::{Reach, settings_hash};
pub use model::*;
pub(crate) use plausible::GRAVITY;
pub use problem::Diagnostic;
pub(crate) use problem::{Problem, short};
pub use setting::Setting;
pub(crate) use tread_pattern::deepest_groove;

/// The default scene, `scenes/default.toml`.
pub const DEFAULT: &str = include_str!("../../scenes/default.toml");
/// The same with a flat tyre, `scenes/plate.toml`.
pub const PLATE: &str = include_str!("../../scenes/plate.toml");
