//! The scene that a command is about.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use crate::scene::Setting;
use clap::Args;

/// A scene, and settings in place of its own.
#[derive(Clone, Debug, Args)]
pub(crate) struct SceneFile {
    /// The scene, a TOML file.
    pub scene: PathBuf,
    /// Set a key in place of the scene's value, such as rolling.speed_kmh=110, numerics.preset=draft or
    /// receiver[0].height=1.5; KEY= removes the key; may be repeated. Paths are relative to the scene's file.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = Setting::parse)]
    pub settings: Vec<Setting>,
}

impl SceneFile {
    /// Name of the scene: its file's, without the ending.
    pub(crate) fn name(&self) -> OsString {
        self.scene.file_stem().unwrap_or(OsStr::new("scene")).to_owned()
    }
}
