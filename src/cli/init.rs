//! `tyrewave init`: something to begin with.

use std::fs;
use std::path::{Path, PathBuf};

use crate::results::ResultsError;
use crate::scene::{DEFAULT, Scene};
use crate::storage::PendingFile;
use clap::Args;

use super::context::{Context, print};
use super::error::CliError;

const EXAMPLES: &str = "\
Writes scene.toml, the default scene with comments; tyre.toml, a car tyre; and scene.schema.json, a JSON Schema by \
which editors (taplo, Even Better TOML) complete and check the scene. If one of these files exists already, nothing is \
written.

Examples:
  tyrewave init
  tyrewave init trial && tyrewave run trial/scene.toml";

/// The tyre that the scene names.
const TYRE: &str = include_str!("../../scenes/tyres/car.toml");
/// Where the default scene's own tyre begins, and what comes after it.
const TYRE_FROM: &str = "# A car tyre:";
const TYRE_TO: &str = "# An endless random texture";

/// Arguments of `tyrewave init`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct InitArguments {
    /// The folder; it is made if it does not exist.
    #[arg(default_value = ".")]
    folder: PathBuf,
}

impl InitArguments {
    /// Writes the files, none where one of them is there already, and says what to do next.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let schema = format!("{:#}\n", Scene::json_schema());
        let files = [("scene.toml", scene()), ("tyre.toml", TYRE.to_owned()), ("scene.schema.json", schema)];
        let place = |name: &str| self.folder.join(name);
        if let Some((name, _)) = files.iter().find(|(name, _)| place(name).exists()) {
            let place = place(name);
            return Err(CliError::Usage(format!("{} is there already; name another folder", place.display())));
        }
        fs::create_dir_all(&self.folder).map_err(ResultsError::creating(&self.folder))?;
        for (name, text) in &files {
            let path = place(name);
            PendingFile::create(&path).and_then(|file| file.complete(text)).map_err(ResultsError::writing(&path))?;
        }
        if context.options.quiet { Ok(()) } else { print(&next(&place("scene.toml"))) }
    }
}

/// Returns the default scene, its tyre in a file of its own.
fn scene() -> String {
    let parts = DEFAULT.split_once(TYRE_FROM).and_then(|(head, rest)| Some((head, rest.split_once(TYRE_TO)?.1)));
    // A test sees to it that the default scene has both lines.
    let (head, tail) = parts.unwrap_or((DEFAULT, ""));
    format!(
        "#:schema ./scene.schema.json\n{head}tyre = \"tyre.toml\" # or a table [tyre] here: tyrewave keys tyre\n\n\
         {TYRE_TO}{tail}"
    )
}

fn next(scene: &Path) -> String {
    let scene = scene.display();
    format!(
        "{scene} is written, with its tyre beside it. Next:\n\n  \
         tyrewave check {scene}\n  \
         tyrewave run {scene} --report\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scene_to_begin_with_is_the_default_scene() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("tyre.toml"), TYRE).unwrap();
        fs::write(folder.path().join("scene.toml"), scene()).unwrap();
        let written = Scene::load(folder.path().join("scene.toml")).unwrap();
        assert_eq!(written.scene, Scene::from_str(DEFAULT, "default").unwrap().scene);
        assert!(scene().starts_with("#:schema ./scene.schema.json\n#"), "{}", scene());
    }
}
