//! The paper: "no significant difference" between slices as independent springs and as an elastic half-space. Shown
//! with numbers: third-octave levels of the contact force at equal load on dense asphalt, chip seal and cobbles.
//!
//! `cargo test --release --test suite slice_laws -- --ignored --nocapture`

use std::path::Path;
use std::sync::atomic::AtomicBool;

use tyrewave::internals::{CHIP_SEAL, COBBLES, edit, plate_scene, reference, scene, with_road};
use tyrewave::run::{Job, RunOptions, Unwatched, run};
use tyrewave::scene::PLATE;

use crate::common::write_grid;

/// Third-octave levels by nominal frequency, the mean force and the contact length.
fn levels(road: &str, law: &str, folder: &Path) -> (Vec<(String, f64)>, f64, f64) {
    let text = edit(&with_road(PLATE, road), &[("contact.slices", &format!("\"{law}\""))]);
    let mut loaded = scene(&text);
    loaded.scene.numerics.elements = 256;
    loaded.scene.numerics.memory = 0.35;
    loaded.scene.numerics.influence_tolerance = 1e-5;
    loaded.scene.rolling.duration = 2.0;
    loaded.scene.outputs.plots = false;
    let options = RunOptions { target: folder.join(law), threads: rayon::current_num_threads() };
    let report = run(&loaded, &options, Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap();
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
    let profile = "kind = \"profile\"\nlateral = \"isotropic\"\nseed = 1\n";
    let cobbles = "kind = \"opencrg\"\nlongest_wavelength = 1.0\nat_end = \"mirror\"\n";
    for (name, road, file) in [
        ("dense asphalt", "kind = \"made\"\nseed = 1\n", None),
        ("chip seal", profile, Some(CHIP_SEAL)),
        ("cobbles", cobbles, Some(COBBLES)),
    ] {
        let mut road = road.to_owned();
        if let Some(file) = file {
            road.push_str(&format!("file = {:?}", reference(file)));
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

#[test]
fn resolution_along_and_across_changes_s_less_and_less() {
    use tyrewave::road::{Lattice, Limits, RoadSurface, SliceBuilder};
    let road = plate_scene().road;
    let width = 0.12;
    let penetration = 1e-3;
    // Mean of S(y)/y over 2 m of dense asphalt by both laws.
    let mean = |dx: f64, dy: f64| {
        let columns = (width / dy).round() as usize;
        let mut surface = RoadSurface::open(&road, Lattice { dx, along: 1, dy, columns }, Limits::default()).unwrap();
        let rows = (2.0 / dx) as usize;
        let mut heights = vec![0.0; rows * columns];
        surface.heights(0, rows, &mut heights).unwrap();
        let builders = [SliceBuilder::winkler(columns).unwrap(), SliceBuilder::half_space(columns, dx, dy).unwrap()];
        builders.map(|builder| {
            let curves = builder.build_rows(&heights).unwrap();
            curves.iter().map(|curve| curve.displacement_at(penetration)).sum::<f64>() / (rows as f64 * penetration)
        })
    };
    println!("mean S(y)/y at y = 1 mm, dense asphalt: dx [mm], dy [mm], winkler, half-space");
    let mut across = Vec::new();
    for dy in [4e-3, 2e-3, 1e-3, 0.5e-3] {
        let [winkler, half_space] = mean(3.809e-3, dy);
        println!("   {:6.3}   {:5.2}   {winkler:.4}   {half_space:.4}", 3.809, 1e3 * dy);
        across.push([winkler, half_space]);
    }
    for elements in [256.0, 1024.0] {
        let dx = 1.95 / elements;
        let [winkler, half_space] = mean(dx, 2e-3);
        println!("   {:6.3}   {:5.2}   {winkler:.4}   {half_space:.4}", 1e3 * dx, 2.0);
        assert!(winkler > 0.0 && half_space > winkler && half_space < 1.0);
    }
    for law in 0..2 {
        let step = |a: usize, b: usize| (across[a][law] - across[b][law]).abs();
        assert!(step(2, 3) < step(0, 1), "law {law}: {across:?}");
    }
}

#[test]
fn a_repeated_road_has_its_slices_made_once() {
    let folder = tempfile::tempdir().unwrap();
    let elements = 64;
    let dx = 1.95 / f64::from(elements);
    // A grid at the run's elements: 20 rows, passed over many times.
    let heights: Vec<f64> = (0..20 * 6).map(|i| 5e-4 * f64::from((i * 7 % 11) as u8)).collect();
    let file = folder.path().join("grid.npy");
    write_grid(&file, 6, &heights);
    let road = format!("kind = \"grid\"\nfile = {file:?}\ndx = {dx}\ndy = 0.02\nat_end = \"repeat\"");
    let mut loaded = scene(&with_road(PLATE, &road));
    loaded.scene.numerics.elements = elements as usize;
    loaded.scene.numerics.memory = 0.05;
    loaded.scene.rolling.warm_up = 0.05;
    loaded.scene.rolling.duration = 1.5;
    loaded.scene.outputs.plots = false;
    let options = RunOptions { target: folder.path().join("out"), threads: 1 };
    let report = run(&loaded, &options, Job::new(&AtomicBool::new(false), &mut Unwatched)).unwrap();
    let made = report.meter.counted(tyrewave::counters::Counter::Slices);
    let steps = report.meter.counted(tyrewave::counters::Counter::Steps);
    assert!(made == 512 && steps > 2 * made, "{made} slices for {steps} steps");
}
