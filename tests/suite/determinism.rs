//! Hard case 9: the same bytes whatever the number of threads.

use std::fs;

use tyrewave::internals::scene_text;

use crate::common::hard_case::measured;
use crate::common::{Results, run};

const ARRAYS: [&str; 5] = ["time.npy", "total_force.npy", "patch_force.npy", "patch_element.npy", "spectra.csv"];

fn bytes(results: &Results) -> Vec<Vec<u8>> {
    ARRAYS.iter().map(|name| fs::read(results.path(name)).unwrap()).collect()
}

fn run_on(threads: usize, text: &str) -> Results {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(text))
}

fn assert_same_on_all(text: &str) {
    let one = run_on(1, text);
    one.assert_sound("one thread");
    let expected = bytes(&one);
    assert!(expected[2].len() > 10_000);
    for threads in [2, 3, 1] {
        let other = run_on(threads, text);
        assert_eq!(other.summary()["cost"]["threads"], threads);
        for ((name, expected), found) in ARRAYS.iter().zip(&expected).zip(bytes(&other)) {
            assert!(*expected == found, "{name} differs on {threads} threads");
        }
        let counters = |results: &Results| results.summary()["cost"]["counters"].clone();
        assert_eq!(counters(&one), counters(&other), "the work depends on the threads");
    }
    measured("bytes of the results on 1, 2 and 3 threads", "the same", "the same");
}

const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.2\naxle = { load = 3400.0 }";

#[test]
fn hard_case_9_a_smooth_road_on_one_two_and_three_threads() {
    assert_same_on_all(&scene_text(128, "kind = \"smooth\"", ROLLING, "memory = 0.25", ""));
}

#[test]
fn hard_case_9_a_made_road_on_one_two_and_three_threads() {
    // Several chunks of made road: 0.3 s at 80 km/h are 6.7 m.
    let text = scene_text(128, "kind = \"made\"\nseed = 3", ROLLING, "memory = 0.25\nsubsteps = 2", "");
    assert_same_on_all(&text);
}

#[test]
fn hard_case_9_the_papers_coupling_on_one_two_and_three_threads() {
    let contact = "[contact]\nslice_coupling = \"explicit\"";
    assert_same_on_all(&scene_text(128, "kind = \"made\"\nseed = 3", ROLLING, "memory = 0.25", contact));
}

#[test]
fn another_seed_is_another_road() {
    let text = |seed: u32| {
        let road = format!("kind = \"made\"\nseed = {seed}");
        scene_text(64, &road, ROLLING, "memory = 0.1", "")
    };
    assert_ne!(bytes(&run(&text(1)))[1], bytes(&run(&text(2)))[1]);
}

#[test]
fn what_the_cache_of_factors_holds_changes_no_bit() {
    // Nothing is ever found but the set of the step before, against everything: a resumed run makes its factors again.
    let with = |factors: u32| {
        let numerics = format!("memory = 0.1\nhistory = \"modal\"\ncached_factors = {factors}");
        // Slices that yield by themselves keep no factors.
        let contact = "[contact]\nslice_coupling = \"explicit\"";
        run(&scene_text(128, "kind = \"made\"\nseed = 3", ROLLING, &numerics, contact))
    };
    let (one, many) = (with(1), with(4096));
    let made = |results: &Results| results.summary()["cost"]["counters"]["factorisations"].as_u64().unwrap();
    assert!(made(&one) > made(&many) + 10, "{} and {} factorisations", made(&one), made(&many));
    assert!(bytes(&one) == bytes(&many));
}
