//! Arrays of a run: each is a channel of an effect, and holds what it says.

use tyrewave::internals::{CIRCUMFERENCE, channel, channels, scene_text};

use crate::common::run;

/// Elements round the tyre.
const ELEMENTS: usize = 128;

#[test]
fn the_contact_spans_all_elements_that_carry_force() {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.1\naxle = { indentation = 0.014, ramp = 0.02 }";
    let results = run(&scene_text(ELEMENTS, "kind = \"made\"", rolling, "", ""));
    let (lengths, forces) = (results.array("contact_length.npy"), results.array("patch_force.npy"));
    let columns = forces.len() / lengths.len();
    let element = CIRCUMFERENCE / ELEMENTS as f64;
    for (step, (length, forces)) in lengths.iter().zip(forces.chunks_exact(columns)).enumerate() {
        let carries_force = |force: &f64| *force > 0.0;
        let ends = forces.iter().position(carries_force).zip(forces.iter().rposition(carries_force));
        let extent = ends.map_or(0, |(first, last)| last + 1 - first);
        assert!((length - extent as f64 * element).abs() < 1e-12, "step {step}");
    }
    let counted = &lengths[lengths.len() / 3..];
    assert!(counted.iter().all(|&length| length > 0.05), "the tyre stands on a few elements");
    let summary = results.summary();
    let warm_up = results.array("time.npy").iter().filter(|&&time| time < 0.05 - 1e-9).count();
    let mean = lengths[warm_up..].iter().sum::<f64>() / (lengths.len() - warm_up) as f64;
    let reported = summary["outcome"]["mean_contact_length"].as_f64().unwrap();
    assert!((reported - mean).abs() < 1e-2 * mean, "{reported} m in the summary, {mean} m in the array");
}

#[test]
fn channels_have_unique_names_and_cover_every_array() {
    let names: Vec<&str> = channels().map(|channel| channel.name).collect();
    for (number, name) in names.iter().enumerate() {
        assert!(!names[..number].contains(name), "two channels are named {name}");
    }
    let contact = "[contact]\nzone = \"cells\"\ncells_across = 3\n[outputs]\ncells_every = 0.01\n[friction]\nmu = 0.5\n\
                   [adhesion]\nstress = 1e4\nrange = 1e-5";
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.0\nduration = 0.05\naxle = { indentation = 0.01, ramp = 0.02 }";
    let results = run(&scene_text(ELEMENTS, "kind = \"made\"", rolling, "memory = 0.06", contact));
    let summary = results.summary();
    let files = summary["files"].as_array().unwrap().iter().filter_map(|file| file.as_str()?.strip_suffix(".npy"));
    let files: Vec<&str> = files.collect();
    for file in &files {
        assert!(channel(file).is_some(), "{file}.npy is no channel");
    }
    let wanted = channels().filter(|channel| !channel.is_written_at_the_end() && channel.name != "axle");
    for channel in wanted {
        assert!(files.contains(&channel.name), "{}.npy is missing", channel.name);
        assert!(!channel.unit.is_empty() && !channel.meaning.is_empty());
    }
}
