//! What several tests need: small scenes, runs in a temporary folder, and reading results back.
#![allow(dead_code)]
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "test code; clippy sees a module of helpers only")]

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use serde_json::Value;
use tempfile::TempDir;
use tyrewave::counters::Watch;
use tyrewave::results::npy::{NpyWriter, Row};
use tyrewave::run::RunReport;
use tyrewave::run::{self, RunError, RunOptions, Unwatched};
use tyrewave::scene::{DEFAULT, LoadedScene, Scene, Tyre};

/// The default tyre's circumference \[m\].
pub const CIRCUMFERENCE: f64 = 1.95;
/// Its contact width \[m\].
pub const CONTACT_WIDTH: f64 = 0.12;

/// The default tyre.
pub fn default_tyre() -> Tyre {
    scene(DEFAULT).scene.tyre
}

/// The tables `[tyre]` and `[[tyre.layers]]` of the default scene.
pub fn tyre_tables() -> String {
    let begin = DEFAULT.find("[tyre]").unwrap();
    let end = DEFAULT.find("[road]").unwrap();
    let lines: Vec<&str> = DEFAULT[begin..end].lines().filter(|line| !line.starts_with('#')).collect();
    lines.join("\n")
}

/// A scene of the default tyre: tables of road and rolling, and further tables. The sums are short: 4 lateral terms, 2
/// aliases.
pub fn scene_text(elements: usize, road: &str, rolling: &str, numerics: &str, more: &str) -> String {
    format!(
        "{}\n[road]\n{road}\n[rolling]\n{rolling}\n[numerics]\nelements = {elements}\nlateral_terms = 4\n\
         wavenumber_aliases = 2\n{numerics}\n{more}\n",
        tyre_tables()
    )
}

/// The text as a scene.
pub fn scene(text: &str) -> LoadedScene {
    Scene::from_str(text, "scene.toml").unwrap_or_else(|error| panic!("{}\n{text}", error.render(false)))
}

/// Results of a run, gone when dropped.
pub struct Results {
    /// Where they are.
    pub folder: TempDir,
    /// What the run handed back.
    pub report: RunReport,
}

/// Runs a scene into a temporary folder.
pub fn try_run(loaded: &LoadedScene) -> Result<Results, RunError> {
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions {
        target: folder.path().join("run"),
        threads: rayon::current_num_threads(),
        watch: Watch::default(),
    };
    let report = run::run(loaded, &options, &AtomicBool::new(false), &mut Unwatched)?;
    Ok(Results { folder, report })
}

/// Runs a scene that must work.
pub fn run(text: &str) -> Results {
    try_run(&scene(text)).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

impl Results {
    /// A file of the results.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join("run").join(name)
    }

    /// A one-dimensional array.
    pub fn array(&self, name: &str) -> Vec<f64> {
        read_array::<f64>(&self.path(name)).1
    }

    /// `patch_force.npy`: rows, columns and values row by row.
    pub fn patch(&self) -> (usize, usize, Vec<f64>) {
        let (shape, values) = read_array::<f64>(&self.path("patch_force.npy"));
        (shape[0], shape[1], values)
    }

    /// `patch_element.npy`.
    pub fn elements(&self) -> Vec<i64> {
        read_array::<i64>(&self.path("patch_element.npy")).1
    }

    /// `summary.json`.
    pub fn summary(&self) -> Value {
        read_summary(&self.folder.path().join("run"))
    }

    /// Fails unless the conditions of the contact held in every step, no search was given up, and all forces are
    /// numbers.
    pub fn assert_sound(&self, name: &str) {
        let contact = &self.report.summary.contact;
        for (what, residual) in [
            ("tension", contact.tension),
            ("penetration", contact.penetration),
            ("complementarity", contact.complementarity),
        ] {
            assert!(residual <= 1e-9, "{name}: largest {what} {residual:e} of the peak");
        }
        assert_eq!(contact.aborted_searches, 0, "{name}");
        let force = self.array("total_force.npy");
        assert_eq!(force.len() as u64, self.report.summary.outcome.steps, "{name}");
        assert!(force.iter().all(|force| force.is_finite() && *force >= 0.0), "{name}");
        let (_, _, patch) = self.patch();
        assert!(patch.iter().all(|force| force.is_finite() && *force >= 0.0), "{name}");
    }
}

/// Shape and values of an `.npy` file.
pub fn read_array<T: npyz::Deserialize>(path: &Path) -> (Vec<usize>, Vec<T>) {
    let file = File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let array = npyz::NpyFile::new(file).unwrap();
    let shape = array.shape().iter().map(|&length| length as usize).collect();
    (shape, array.into_vec::<T>().unwrap())
}

/// A folder's `summary.json`.
pub fn read_summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

/// Writes a height map, row by row.
pub fn write_grid(path: &Path, columns: usize, heights: &[f64]) {
    let mut writer = NpyWriter::<f64>::create(path, Row::Columns(columns)).unwrap();
    for row in heights.chunks_exact(columns) {
        writer.push(row).unwrap();
    }
    writer.finish().unwrap();
}

/// `[road]` keys of a grid at the run's own lattice: used as it is.
pub fn grid_road(path: &Path, elements: usize, columns: usize) -> String {
    format!(
        "kind = \"grid\"\nfile = '{}'\ndx = {:?}\ndy = {:?}",
        path.display(),
        CIRCUMFERENCE / elements as f64,
        CONTACT_WIDTH / columns as f64
    )
}

/// A file of the shared measured roads, or `None` with a printed line.
pub fn shared_road(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/roads")).join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no {}", path.display());
    None
}

/// Mean and standard deviation.
pub fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
    (mean, square.sqrt())
}
