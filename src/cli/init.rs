//! `tyrewave init`: files to begin with.

use std::fs;
use std::path::{Path, PathBuf};

use crate::results::ResultsError;
use crate::scene::{DEFAULT, Scene};
use crate::storage::PendingFile;
use clap::Args;

use super::context::{Context, print};
use super::error::CliError;
use super::tyre_size::TyreSize;

const EXAMPLES: &str = "\
Writes scene.toml, the default scene with comments; tyre.toml, a car tyre; and scene.schema.json, a JSON Schema by \
which editors (taplo, Even Better TOML) complete and check the scene. If one of these files exists already, nothing is \
written. With --size the tyre has that size and follows the rules of docs/tyres.md; comments in its file say which \
values are published and which are inferred.

Examples:
  tyrewave init
  tyrewave init trial --size 235/45R18 --load-index 98
  tyrewave init trial && tyrewave run trial/scene.toml";

/// Tyre of the scene, unless a size is given.
const TYRE: &str = include_str!("../../scenes/tyres/car.toml");
/// Lines of the default scene before which its tyre begins, and what follows the tyre begins.
const TYRE_FROM: &str = "# A car tyre:";
const TYRE_TO: &str = "# An endless random texture";
/// Its load, up to the comment.
const AXLE: &str = "axle = { load = 3400.0 }        #";

/// Arguments of `tyrewave init`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct InitArguments {
    /// The folder; created if it does not exist.
    #[arg(default_value = ".")]
    folder: PathBuf,
    /// Size of the tyre, such as 235/45R18, or "235/45R18 98Y"; without it the default car tyre is written.
    #[arg(long, value_name = "SIZE", value_parser = str::parse::<TyreSize>)]
    size: Option<TyreSize>,
    /// Load index of the tyre, if the size does not state it.
    #[arg(long, value_name = "INDEX", requires = "size")]
    load_index: Option<u16>,
}

impl InitArguments {
    /// Writes the files, or none if one of them exists, and prints what to do next.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let size = match (self.size, self.load_index) {
            (Some(size), Some(index)) => Some(size.with_index(index).map_err(CliError::Usage)?),
            (size, _) => size,
        };
        let tyre = size.map_or_else(|| TYRE.to_owned(), |size| size.file());
        let schema = format!("{:#}\n", Scene::json_schema());
        let files = [("scene.toml", scene(size)), ("tyre.toml", tyre), ("scene.schema.json", schema)];
        let place = |name: &str| self.folder.join(name);
        if let Some((name, _)) = files.iter().find(|(name, _)| place(name).exists()) {
            let place = place(name);
            return Err(CliError::Usage(format!("{} exists already; name another folder", place.display())));
        }
        fs::create_dir_all(&self.folder).map_err(ResultsError::creating(&self.folder))?;
        for (name, text) in &files {
            let path = place(name);
            PendingFile::create(&path).and_then(|file| file.complete(text)).map_err(ResultsError::writing(&path))?;
        }
        if context.options.quiet { Ok(()) } else { print(&next(&place("scene.toml"), size)) }
    }
}

/// The default scene, its tyre in a separate file, under a load for a tyre of a size.
fn scene(size: Option<TyreSize>) -> String {
    let parts = DEFAULT.split_once(TYRE_FROM).and_then(|(head, rest)| Some((head, rest.split_once(TYRE_TO)?.1)));
    // A test ensures that the default scene has both lines.
    let (head, tail) = parts.unwrap_or((DEFAULT, ""));
    let tail = size.map_or_else(
        || tail.to_owned(),
        |size| {
            let (load, reason) = size.axle_load();
            let axle = format!("axle = {{ load = {load:?} }}");
            tail.replace(AXLE, &format!("# The load is {reason}.\n{axle:<32}#"))
        },
    );
    format!(
        "#:schema ./scene.schema.json\n{head}tyre = \"tyre.toml\" # or a table [tyre] here: tyrewave keys tyre\n\n\
         {TYRE_TO}{tail}"
    )
}

fn next(scene: &Path, size: Option<TyreSize>) -> String {
    let scene = scene.display();
    let tyre = size.map_or_else(
        || ", with its tyre beside it".to_owned(),
        |size| format!(", with a tyre {size} beside it (tyre.toml):\n{}", size.origins().trim_end()),
    );
    format!(
        "{scene} is written{tyre}. Next:\n\n  \
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
        fs::write(folder.path().join("scene.toml"), scene(None)).unwrap();
        let written = Scene::load(folder.path().join("scene.toml")).unwrap();
        assert_eq!(written.scene, Scene::from_str(DEFAULT, "default").unwrap().scene);
        assert!(scene(None).starts_with("#:schema ./scene.schema.json\n#"), "{}", scene(None));
        let of_size = scene("125/80R12 62S".parse().ok());
        assert!(
            of_size.contains("# The load is 0.8 of the 265 kg of load index 62.\naxle = { load = 2100.0 }  "),
            "{of_size}"
        );
    }
}
