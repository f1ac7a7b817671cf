//! Sound of a tyre beside the road: third octaves and dB(A) at a receiver, and an audio file, in the given folder or in
//! the system's for temporary files.
//!
//! `cargo run --release --example receiver -- FOLDER`
#![allow(clippy::print_stdout, reason = "an example shows what it found")]

use std::error::Error;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use tyrewave::run::{Job, Unwatched, run_in_memory};
use tyrewave::scene::{PLATE, RadiationQuality, Receiver, ReceiverPlace};
use tyrewave::{LoadedScene, Scene};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(std::env::temp_dir, PathBuf::from);
    // The shipped scene of a flat tyre, coarser and shorter, with a receiver and a draft of the radiation.
    let mut scene = Scene::from_str(PLATE, "plate")?.scene;
    (scene.numerics.elements, scene.numerics.pole_tolerance) = (128, 1e-3);
    (scene.rolling.warm_up, scene.rolling.duration) = (0.2, 1.0);
    let place = ReceiverPlace::Position { position: [0.0, 3.0, 1.2] };
    scene.receivers.push(Receiver { name: "beside".to_owned(), place });
    (scene.radiation.quality, scene.radiation.fmax) = (RadiationQuality::Draft, 1000.0);
    let loaded = LoadedScene::from_scene(&scene, "heard")?;

    let found = run_in_memory(&loaded, Job::new(&AtomicBool::new(false), &mut Unwatched))?;
    let sound = found.summary.sound.ok_or("the run is too short for sound")?;
    for receiver in &sound.receivers {
        println!("{}: {:.1} dB, {:.1} dB(A)", receiver.name, receiver.level, receiver.level_a);
    }
    // Files that a run into a folder would write: tables as text, sounds as they are.
    let table = found.files.get("sound.csv").ok_or("no third octaves")?;
    for row in String::from_utf8_lossy(table).lines().skip(1) {
        if let [_, nominal, _, level, weighted, ..] = row.split(',').collect::<Vec<_>>()[..] {
            let [level, weighted]: [f64; 2] = [level.parse()?, weighted.parse()?];
            println!("{nominal:>6} Hz {level:7.1} dB {weighted:7.1} dB(A)");
        }
    }
    for (name, bytes) in found.files.iter().filter(|(name, _)| name.ends_with(".wav")) {
        let path = folder.join(name);
        std::fs::write(&path, bytes)?;
        println!("{}", path.display());
    }
    Ok(())
}
