//! Reference values of established codes, for tests; absent ones skip their test with a printed line.

use std::fs::File;
use std::io::Read;

use npyz::NpyFile;
use zip::ZipArchive;

/// One `.npz` archive of ../shared/reference/rough_contact.
pub(crate) struct Case(std::path::PathBuf);

impl Case {
    /// None, and a line, where the archive is absent.
    pub(crate) fn open(name: &str) -> Option<Self> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/reference/rough_contact");
        let path = std::path::Path::new(folder).join(name).with_extension("npz");
        if path.exists() {
            return Some(Self(path));
        }
        println!("skipped: no reference {}", path.display());
        None
    }

    /// Shape and values of an array, row-major.
    pub(crate) fn array(&self, key: &str) -> (Vec<usize>, Vec<f64>) {
        let mut archive = ZipArchive::new(File::open(&self.0).unwrap()).unwrap();
        let mut bytes = Vec::new();
        archive.by_name(&format!("{key}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
        let npy = NpyFile::new(&bytes[..]).unwrap();
        let shape = npy.shape().iter().map(|&n| n as usize).collect();
        (shape, npy.into_vec().unwrap())
    }

    /// A single number.
    pub(crate) fn scalar(&self, key: &str) -> f64 {
        self.array(key).1[0]
    }
}
