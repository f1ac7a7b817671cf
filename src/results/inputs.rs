//! Files that a scene reads, with hashes of their content. With the scene and the version of the program they are all
//! that results depend on: checkpoints, tasks and summaries record them, and are used with the same inputs only.

use std::collections::HashMap;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::numeric::digest::hexadecimal;
use crate::road::sources::included;
use crate::scene::Scene;
use crate::storage::input;

/// A file that a scene reads.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Input {
    /// Key of the scene with the file's name, also for a file that it includes.
    pub key: String,
    /// Path of the file.
    pub file: PathBuf,
    /// SHA-256 of its content, in hexadecimal.
    pub sha256: String,
}

/// Finds the inputs of scenes, and reads each file once.
#[derive(Default)]
pub(crate) struct Inputs {
    /// Inputs of a file and its includes, by key and file.
    known: HashMap<(&'static str, PathBuf), Vec<Input>>,
}

impl Inputs {
    /// Inputs of a scene, in the order of its keys.
    ///
    /// # Errors
    /// The path of a file that cannot be read, with the error.
    pub(crate) fn of(&mut self, scene: &Scene) -> Result<Vec<Input>, (PathBuf, io::Error)> {
        let mut all = Vec::new();
        for (key, file) in scene.files() {
            let known = (key, file.to_owned());
            if !self.known.contains_key(&known) {
                let included = included(&scene.road, scene.numerics.memory_bytes()).into_iter();
                let included = included.filter(|_| scene.road.file() == Some(file));
                let files = [file.to_owned()].into_iter().chain(included);
                let inputs = files.map(|file| {
                    let sha256 = file_digest(&file).map_err(|source| (file.clone(), source))?;
                    Ok(Input { key: key.to_owned(), file, sha256 })
                });
                self.known.insert(known.clone(), inputs.collect::<Result<_, _>>()?);
            }
            all.extend(self.known.get(&known).into_iter().flatten().cloned());
        }
        Ok(all)
    }
}

/// Path of the first file in which inputs differ from earlier ones.
pub(crate) fn changed<'a>(before: &'a [Input], now: &'a [Input]) -> Option<&'a Path> {
    let missing_in = |others: &'a [Input]| move |input: &&Input| !others.contains(*input);
    let first = before.iter().find(missing_in(now)).or_else(|| now.iter().find(missing_in(before)));
    first.map(|input| input.file.as_path())
}

/// SHA-256 of a file's content, in hexadecimal.
fn file_digest(path: &Path) -> io::Result<String> {
    let mut reader = BufReader::with_capacity(1 << 16, input::open(path)?.0);
    let (mut hash, mut block) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match reader.read(&mut block)? {
            0 => return Ok(hexadecimal(hash.finalize())),
            count => hash.update(&block[..count]),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::scene::{DEFAULT, Setting};

    #[test]
    fn every_file_that_a_scene_reads_identifies_it_by_its_content() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("outer.crg"), "$CT\nx\n$\n$ROAD_CRG_FILE\ninner.crg\n$\n").unwrap();
        fs::write(path("inner.crg"), "$CT\nx\n$\n").unwrap();
        fs::write(path("map.png"), "a map").unwrap();
        let settings = [
            format!("road={{kind=\"opencrg\",file={:?}}}", path("outer.crg")),
            format!("tread_pattern={{depth=0.008,file={:?}}}", path("map.png")),
            "contact={zone=\"cells\",cells_across=8}".to_owned(),
        ];
        let settings: Vec<Setting> = settings.iter().map(|text| Setting::parse(text).unwrap()).collect();
        let loaded = Scene::from_str_with(DEFAULT, "default", &settings).unwrap();
        let of = || Inputs::default().of(&loaded.scene).unwrap();
        let before = of();
        let keys: Vec<&str> = before.iter().map(|input| input.key.as_str()).collect();
        assert_eq!(keys, ["road.file", "road.file", "tread_pattern.file"]);
        assert_eq!(changed(&before, &of()), None);
        for name in ["outer.crg", "inner.crg", "map.png"] {
            let text = fs::read_to_string(path(name)).unwrap();
            fs::write(path(name), format!("{text}* more")).unwrap();
            let now = of();
            let found = changed(&before, &now).unwrap();
            assert_eq!(found.file_name().unwrap(), name);
            fs::write(path(name), text).unwrap();
            assert_eq!(changed(&before, &of()), None);
        }
        // An include that is gone is a change, too; a missing file that the scene itself names is an error.
        fs::remove_file(path("inner.crg")).unwrap();
        assert!(changed(&before, &of()).unwrap().ends_with("inner.crg"));
        fs::remove_file(path("map.png")).unwrap();
        assert!(Inputs::default().of(&loaded.scene).unwrap_err().0.ends_with("map.png"));
    }
}
