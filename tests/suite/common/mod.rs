//! Shared parts of several tests: runs in a temporary folder, in memory or by the program, and reading results back.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "test code; clippy sees a module of helpers only")]

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::AtomicBool;

use serde_json::Value;
use tempfile::TempDir;
use tyrewave::internals::{ArrayRow, NpyWriter, read_force_levels, scene};
use tyrewave::response::BandLevel;
use tyrewave::run;
use tyrewave::run::{Job, RunError, RunOptions, RunReport, Unwatched};
use tyrewave::scene::{LoadedScene, Material};

pub(super) mod hard_case;

/// Results of a run, gone when dropped.
pub(super) struct Results {
    /// Where they are.
    pub folder: TempDir,
    /// Report of the run.
    pub report: RunReport,
}

/// Runs a scene into a temporary folder.
pub(super) fn try_run(loaded: &LoadedScene) -> Result<Results, RunError> {
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions { target: folder.path().join("run"), threads: rayon::current_num_threads() };
    let report = run::run(loaded, &options, Job::new(&AtomicBool::new(false), &mut Unwatched))?;
    Ok(Results { folder, report })
}

/// Runs a scene that must work.
pub(super) fn run(text: &str) -> Results {
    try_run(&scene(text)).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

impl Results {
    /// A file of the results.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join("run").join(name)
    }

    /// Fails if contact was at the end of the window of cells, or of slices.
    pub(super) fn assert_window_held(&self, name: &str) {
        assert_eq!(self.summary()["cost"]["counters"]["window_edge_contacts"], 0, "{name}");
    }

    /// A one-dimensional array.
    pub(super) fn array(&self, name: &str) -> Vec<f64> {
        read_array::<f64>(&self.path(name)).1
    }

    /// The third-octave levels of the total force.
    pub(super) fn force_levels(&self) -> Vec<BandLevel> {
        read_force_levels(&fs::read_to_string(self.path("spectra.csv")).unwrap()).unwrap()
    }

    /// `patch_force.npy`: rows, columns and values row by row.
    pub(super) fn patch(&self) -> (usize, usize, Vec<f64>) {
        let (shape, values) = read_array::<f64>(&self.path("patch_force.npy"));
        (shape[0], shape[1], values)
    }

    /// `patch_element.npy`.
    pub(super) fn elements(&self) -> Vec<i64> {
        read_array::<i64>(&self.path("patch_element.npy")).1
    }

    /// `summary.json`.
    pub(super) fn summary(&self) -> Value {
        read_summary(&self.folder.path().join("run"))
    }

    /// Fails unless the conditions of the contact held in every step, no search was given up, and all forces are
    /// numbers.
    pub(super) fn assert_sound(&self, name: &str) {
        let contact = &self.report.summary.contact;
        let largest = contact.tension.max(contact.penetration).max(contact.complementarity);
        hard_case::measured(format!("{name}: contact conditions"), "1e-9 of the peak", format!("{largest:.1e}"));
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
pub(super) fn read_array<T: npyz::Deserialize>(path: &Path) -> (Vec<usize>, Vec<T>) {
    let file = File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let array = npyz::NpyFile::new(file).unwrap();
    let shape = array.shape().iter().map(|&length| length as usize).collect();
    (shape, array.into_vec::<T>().unwrap())
}

/// A folder's `summary.json`.
pub(super) fn read_summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

/// The folder of this build: the program and, in `deps`, this test.
fn build() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    test.ancestors().nth(2).unwrap().to_owned()
}

/// The program of this build, which `cargo test` makes for the tests beside the library's.
pub(super) fn program() -> PathBuf {
    let program = build().join("tyrewave").with_extension(std::env::consts::EXE_EXTENSION);
    assert!(program.exists(), "there is no {}: build the program first: cargo build", program.display());
    program
}

/// The program with its arguments in a folder; what it says is captured.
pub(super) fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(program());
    command.args(arguments).current_dir(folder).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// The same, run to its end.
pub(super) fn tyrewave(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

/// A folder with a scene in it, `scene.toml`.
pub(super) fn folder_with(scene: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    folder
}

/// Names of all that is in a folder, sorted.
pub(super) fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Writes a height map, row by row.
pub(super) fn write_grid(path: &Path, columns: usize, heights: &[f64]) {
    let mut writer = NpyWriter::<f64>::create(path, ArrayRow::Columns(columns)).unwrap();
    for row in heights.chunks_exact(columns) {
        writer.push(row).unwrap();
    }
    writer.finish().unwrap();
}

/// Contact over cells with the map of a tread in the file `map.npy`, for scenes of 64 elements.
pub(super) const TREAD_MAP: &str = "\n[contact]\nzone = \"cells\"\ncells_across = 4\n\
                                    [tread_pattern]\nfile = \"map.npy\"\nblocks = \"continuum\"\n";

/// Writes the map of a tread on 64 x 4 cells, a quarter of them grooves of a depth \[m\].
pub(super) fn write_tread_map(path: &Path, depth: f64) {
    let depths: Vec<f64> = (0..64 * 4).map(|cell| if cell % 4 == 1 { depth } else { 0.0 }).collect();
    write_grid(path, 4, &depths);
}

pub(super) fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
    (mean, square.sqrt())
}

/// Reports that a test is left out on this machine, and why: printed, and noted for the end of `.ci/run`.
pub(super) fn skipped(why: &str) {
    println!("skipped: {why}");
    let folder = build().with_file_name("tmp");
    fs::create_dir_all(&folder).unwrap();
    let list = folder.join("skipped.txt");
    let test = std::thread::current().name().unwrap_or_default().to_owned();
    let file = fs::OpenOptions::new().create(true).append(true).open(list);
    file.and_then(|mut file| file.write_all(format!("{test}: {why}\n").as_bytes())).unwrap();
}

/// A viscoelastic material whose modulus follows the power law at the default frequencies.
pub(super) fn rubber(modulus: f64, loss_factor: f64, poisson: f64, density: f64) -> Material {
    Material::power_law(modulus, loss_factor, poisson, density)
}
