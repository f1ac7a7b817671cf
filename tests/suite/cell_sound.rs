//! Sound of contact over cells: its sides, against that of slices, and its bytes.

use std::fs;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tyrewave::Plan;
use tyrewave::counters::Counter;
use tyrewave::internals::{choices, edit, grid_road, scene, scene_text, with_all_terms};

use crate::common::{Results, run, write_grid};

const ACROSS: usize = 4;
const ELEMENTS: usize = 96;
const DRAFT: &str = "[radiation]\nfmax = 800.0\nquality = \"draft\"\naudio = false\n";
/// Low frequencies alone: boundary elements of a second.
const LOW: &str = "[radiation]\nfmax = 300.0\nnodes_per_wavelength = 5.0\nfrequency_tolerance = \"0.5 dB\"\n";
const BOTH_SIDES: &str = "[[receiver]]\nname = \"left\"\nposition = [0.1, 1.0, 0.3]\n\
                          [[receiver]]\nname = \"right\"\nposition = [0.1, -1.0, 0.3]\n";

fn rolling(duration: f64) -> String {
    format!(
        "start = 1.0\nspeed_kmh = 80.0\nwarm_up = 0.2\nduration = {duration:?}\n\
         axle = {{ indentation = 0.012, ramp = 0.05 }}"
    )
}

/// A scene of cells with three waves across for each of them.
fn cells(across: usize, road: &str, duration: f64, more: &str) -> String {
    let contact = format!("[contact]\nzone = \"cells\"\ncells_across = {across}\n[outputs]\nplots = false\n{more}");
    let text = scene_text(ELEMENTS, road, &rolling(duration), "pole_tolerance = 1e-4", &contact);
    edit(&text, &[("numerics.lateral_terms", &(3 * across).to_string())])
}

/// Levels of the receivers \[dB\].
fn levels(results: &Results) -> Vec<f64> {
    results.assert_window_held("levels");
    let summary = results.summary();
    let receivers = summary["sound"]["receivers"].as_array().unwrap();
    receivers.iter().map(|receiver| receiver["level"].as_f64().unwrap()).collect()
}

/// A road with bumps in these columns alone, 0 the rightmost one, as long as three revolutions.
fn bumpy(folder: &std::path::Path, name: &str, columns: &[usize]) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let path = folder.join(name);
    let rows = (0..3 * ELEMENTS).map(|_| random.random_range(0.0..1.5e-3));
    let heights: Vec<f64> = rows
        .flat_map(|height: f64| (0..ACROSS).map(move |column| if columns.contains(&column) { height } else { 0.0 }))
        .collect();
    write_grid(&path, ACROSS, &heights);
    format!("{}\nat_end = \"repeat\"", grid_road(&path, ELEMENTS, ACROSS))
}

#[test]
fn bumps_on_one_side_sound_different_at_both_sides() {
    let folder = tempfile::tempdir().unwrap();
    let of_bumps = |name: &str, columns: &[usize], way: &str| {
        let road = bumpy(folder.path(), name, columns);
        levels(&run(&cells(ACROSS, &road, 0.8, &format!("{BOTH_SIDES}{way}"))))
    };
    for way in [DRAFT, LOW] {
        let (one, other) = (of_bumps("one.npy", &[3], way), of_bumps("other.npy", &[0], way));
        println!("bumps on one side {one:.2?} dB, on the other {other:.2?} dB");
        // Left and right change places; single precision and the search's tolerance are between them.
        for (one, mirrored) in one.iter().zip(other.iter().rev()) {
            assert!((one - mirrored).abs() < 0.01, "{one} and {mirrored} dB");
        }
        assert!((one[0] - one[1]).abs() > 0.1, "{one:?}: odd waves are not heard");
        let even = of_bumps("even.npy", &[0, 3], way);
        assert!((even[0] - even[1]).abs() < 0.01, "{even:?}: bumps on both sides");
    }
}

#[test]
fn one_row_of_cells_sounds_as_a_slice_does() {
    let made = "kind = \"made\"\nseed = 4";
    let more = format!("{BOTH_SIDES}{DRAFT}");
    let one = run(&with_all_terms(&cells(1, made, 0.8, &more)));
    let slices = "[contact]\ncells_across = 1\ncells_along = 1\n[outputs]\nplots = false\n";
    let text = scene_text(ELEMENTS, made, &rolling(0.8), "pole_tolerance = 1e-4", &format!("{slices}{more}"));
    let other = run(&with_all_terms(&text));
    let (one, other) = (levels(&one), levels(&other));
    println!("cells {one:.3?} dB, slices {other:.3?} dB");
    for (one, other) in one.iter().zip(&other) {
        assert!((one - other).abs() < 0.05, "{one} and {other} dB");
    }
}

#[test]
fn sound_of_cells_has_the_same_bytes_on_two_threads() {
    let made = "kind = \"made\"\nseed = 4";
    let text = cells(ACROSS, made, 0.6, &format!("{BOTH_SIDES}{DRAFT}"));
    let on = |threads: usize, text: &str| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(text))
    };
    let (one, two) = (on(1, &text), on(2, &text));
    for name in ["sound.csv", "sound_narrow.csv"] {
        assert!(fs::read(one.path(name)).unwrap() == fs::read(two.path(name)).unwrap(), "{name}");
    }
    let silent = run(&cells(ACROSS, made, 0.6, ""));
    for counter in [Counter::SoundTransforms, Counter::RadiationKernels] {
        assert_eq!(silent.report.meter.counted(counter), 0, "{counter:?}");
    }
    assert!(silent.summary().get("sound").is_none());
    for name in ["total_force.npy", "patch_force.npy", "row_force.npy"] {
        assert!(fs::read(one.path(name)).unwrap() == fs::read(silent.path(name)).unwrap(), "{name}");
    }
}

#[test]
fn plans_count_odd_waves_and_both_sides() {
    let made = "kind = \"made\"\nseed = 4";
    let more = format!("{BOTH_SIDES}{LOW}");
    let plan = Plan::of(&scene(&cells(ACROSS, made, 0.8, &more))).unwrap();
    let slices = Plan::of(&scene(&scene_text(ELEMENTS, made, &rolling(0.8), "", &more))).unwrap();
    assert_eq!((plan.sound().unwrap().path.lateral, slices.sound().unwrap().path.lateral), (11, 6));
    let counted = |plan: &Plan, counter: Counter| {
        plan.amounts().counters.iter().find(|known| known.0 == counter).map_or(0.0, |known| known.1)
    };
    // Four symmetries to be solved for instead of two.
    let kernels = [&plan, &slices].map(|plan| counted(plan, Counter::RadiationSolves));
    assert!(kernels[0] > 0.0 && (kernels[0] - kernels[1]).abs() < 1e-9, "{kernels:?}");
    let choice = choices(&plan).iter().find(|choice| choice.key == "radiation.lateral_waves").unwrap();
    assert!(choice.reason.contains("11"), "{choice:?}");
}
