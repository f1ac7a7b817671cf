//! Reference values of established codes, for tests.

use std::fs::File;
use std::io::Read;

use npyz::NpyFile;
use zip::ZipArchive;

use crate::test_models::reference;

/// A `.npz` archive of `tests/reference/rough_contact`.
pub(crate) struct Case(std::path::PathBuf);

impl Case {
    /// `name`: without the extension.
    pub(crate) fn open(name: &str) -> Self {
        Self(reference(&format!("rough_contact/{name}.npz")))
    }

    /// Shape and values, row-major.
    pub(crate) fn array(&self, key: &str) -> (Vec<usize>, Vec<f64>) {
        let mut archive = ZipArchive::new(File::open(&self.0).unwrap()).unwrap();
        let mut bytes = Vec::new();
        archive.by_name(&format!("{key}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
        let npy = NpyFile::new(&bytes[..]).unwrap();
        let shape = npy.shape().iter().map(|&n| n as usize).collect();
        (shape, npy.into_vec().unwrap())
    }

    /// The first value of an array.
    pub(crate) fn scalar(&self, key: &str) -> f64 {
        self.array(key).1[0]
    }
}
