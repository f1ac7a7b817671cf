//! Runs in segments of their road, `outputs.levels.segments`: against runs in one piece, on several threads, and
//! what is refused.

use std::fs;

use tyrewave::internals::scene;
use tyrewave::{Plan, Scene};

use crate::common::run;
use crate::finer_mesh::{CPX, bands, over};

/// A run in `segments` segments over the road of a seed, as long as it can be, with a microphone.
fn in_segments(segments: usize, seed: u32, seconds: f64) -> String {
    let levels = format!("levels = {{ standard_error = 0.05, segments = {segments} }}");
    let sound = CPX.replace("quality", "audio = false\nquality");
    over(96, seconds, &levels, &sound).replace("seed = 3", &format!("seed = {seed}"))
}

/// chi^2 of the differences of levels between runs in four segments and in one piece over the same roads, relative to
/// their standard errors, and the largest one of a level; for force and sound.
fn differences(seeds: std::ops::Range<u32>, seconds: f64) -> [[f64; 2]; 2] {
    let mut found = [[0.0, 0.0]; 2];
    for seed in seeds {
        let four = run(&in_segments(4, seed, seconds));
        let duration = four.summary()["settings"]["rolling"]["duration"].as_f64().unwrap();
        let one = run(&in_segments(1, seed, duration));
        let files = [("spectra.csv", "level_db_re_1n"), ("sound.csv", "level_db_re_20upa")];
        for ((file, level), [chi, largest]) in files.into_iter().zip(&mut found) {
            let [whole, errors] = [level, "standard_error_db"].map(|column| bands(&one, file, column));
            let levels = bands(&four, file, level);
            for (band, level) in levels {
                let difference: f64 = (level - whole[&band]) / errors[&band];
                *chi += difference.powi(2);
                *largest = difference.abs().max(*largest);
            }
        }
    }
    println!("chi^2 and largest difference in standard errors, force and sound: {found:.3?}");
    found
}

#[test]
fn levels_of_segments_are_those_of_a_run_in_one_piece() {
    for [_, largest] in differences(3..5, 4.0) {
        assert!(largest < 0.1, "{largest} standard errors");
    }
}

#[test]
#[ignore = "minutes"]
fn levels_of_segments_agree_over_many_seeds() {
    // 8 bands of 16 seeds: one standard error each would give 128. Both roll the same road.
    for [chi, largest] in differences(1..17, 6.0) {
        assert!(chi < 0.1 && largest < 0.1, "chi^2 = {chi}, {largest} standard errors");
    }
}

#[test]
fn segments_give_the_same_bytes_on_any_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let results = pool.install(|| run(&in_segments(3, 3, 3.0)));
        let tables = ["spectra.csv", "sound.csv"].map(|name| fs::read(results.path(name)).unwrap());
        let summary = results.summary();
        assert_eq!(summary["levels"]["segments"], 3);
        (tables, summary["outcome"].clone(), summary["cost"]["counters"].clone())
    };
    let one = on(1);
    assert!(one.1["mean_force"].as_f64().unwrap() > 100.0 && one.1["rolling_resistance"].is_object(), "{}", one.1);
    assert!(on(2) == one && on(4) == one, "results depend on the threads");
}

#[test]
fn what_segments_cannot_be_is_refused() {
    let refused = |text: &str| Scene::from_str(text, "scene").unwrap_err().to_string();
    let arrays = in_segments(2, 3, 2.0).replace("arrays = false", "arrays = true");
    let reported = refused(&arrays);
    assert!(reported.contains("outputs.levels.segments") && reported.contains("outputs.arrays = false"), "{reported}");
    let reported = refused(&in_segments(2, 3, 2.0).replace("audio = false", "audio = true"));
    assert!(reported.contains("radiation.audio = false"), "{reported}");
    let reported = refused(&in_segments(0, 3, 2.0));
    assert!(reported.contains("outputs.levels.segments") && reported.contains('1'), "{reported}");
    let of = |text: &str| Plan::of(&scene(text)).map(|plan| plan.steps);
    let reported = of(&in_segments(9, 3, 3.0)).unwrap_err().to_string();
    assert!(reported.contains("too short for a spectrum") && reported.contains("at most"), "{reported}");
    // No segment is longer than its share, and the plan counts the warm-ups.
    let [one, three] = [1, 3].map(|segments| of(&in_segments(segments, 3, 3.0)).unwrap());
    assert!(three <= one && three > one * 3 / 4, "{three} of {one} steps");
    let small = in_segments(2, 3, 2.0).replace("[numerics]", "[numerics]\nmemory_limit = 1e-3");
    let loaded = scene(&small);
    let reported = Plan::of(&loaded).unwrap().check(&loaded).unwrap_err().to_string();
    assert!(reported.contains("fewer segments"), "{reported}");
}
