//! The paper: "no significant difference" between slices as independent springs and as an elastic half-space. Shown with numbers: third-octave levels of the
//! contact force at equal load on dense asphalt, chip seal and cobbles.
//!
//! `cargo test --release --test slice_laws -- --ignored --nocapture`
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failing test may panic, in its helpers, too")]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use tyrewave::pipeline::{RunOptions, Unwatched, run};
use tyrewave::scene::{DEFAULT, Scene};

/// Third-octave levels by nominal frequency, the mean force and the contact length.
fn levels(road: &str, law: &str, folder: &Path) -> (Vec<(String, f64)>, f64, f64) {
    let begin = DEFAULT.find("[road]").unwrap();
    let end = DEFAULT.find("[rolling]").unwrap();
    let scene = format!("{}{road}\n{}", &DEFAULT[..begin], &DEFAULT[end..])
        .replace("slices = \"winkler\"", &format!("slices = \"{law}\""));
    let mut loaded = Scene::from_str(&scene, "slice laws").unwrap();
    loaded.scene.numerics.elements = 256;
    loaded.scene.numerics.memory = 0.35;
    loaded.scene.numerics.influence_tolerance = 1e-5;
    loaded.scene.rolling.duration = 2.0;
    loaded.scene.outputs.plots = false;
    let options = RunOptions { target: folder.join(law), threads: rayon::current_num_threads() };
    let report = run(&loaded, &options, &AtomicBool::new(false), &mut Unwatched).unwrap();
    let table = std::fs::read_to_string(report.folder.join("spectra.csv")).unwrap();
    let rows = table.lines().skip(1).map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[0].to_owned(), cells[5].parse().unwrap())
    });
    let outcome = &report.summary.outcome;
    (rows.collect(), outcome.mean_force.unwrap(), outcome.mean_contact_length.unwrap())
}

#[test]
#[ignore = "six runs of 2.5 s rolled: minutes"]
fn both_slice_laws_on_three_roads() {
    let shared = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/roads/");
    let roads = [
        ("dense asphalt", "[road]\nkind = \"made\"\nseed = 1".to_owned(), None),
        (
            "chip seal",
            format!(
                "[road]\nkind = \"profile\"\nfile = \"{shared}captif_aylesbury_station_10.dat\"\nlateral = \"isotropic\"\nseed = 1"
            ),
            Some(format!("{shared}captif_aylesbury_station_10.dat")),
        ),
        (
            "cobbles",
            format!(
                "[road]\nkind = \"opencrg\"\nfile = \"{shared}belgian_block.crg\"\nlongest_wavelength = 1.0\nat_end = \"mirror\""
            ),
            Some(format!("{shared}belgian_block.crg")),
        ),
    ];
    for (name, road, file) in roads {
        if let Some(file) = file.filter(|file| !Path::new(file).exists()) {
            println!("skipped {name}: no {file}");
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let (winkler, mean_w, length_w) = levels(&road, "winkler", folder.path());
        let (half_space, mean_h, length_h) = levels(&road, "half-space", folder.path());
        println!(
            "{name}: mean force {mean_w:.0} and {mean_h:.0} N, contact {:.1} and {:.1} mm",
            1e3 * length_w,
            1e3 * length_h
        );
        println!("   band [Hz]   winkler   half-space   difference [dB]");
        let mut largest = 0.0_f64;
        for ((band, a), (_, b)) in winkler.iter().zip(&half_space) {
            println!("   {band:>9}   {a:7.1}      {b:7.1}           {:+5.1}", b - a);
            largest = largest.max((b - a).abs());
        }
        println!("   largest difference {largest:.1} dB");
        assert!(largest.is_finite() && (mean_w - mean_h).abs() < 0.05 * mean_w);
    }
}
