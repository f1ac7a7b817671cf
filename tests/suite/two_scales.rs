//! Cells whose sub-cells touch the road, `contact.sub_cells`: against cells as small as these, and what is refused.

use std::fs;

use tyrewave::Plan;
use tyrewave::internals::{scene, scene_text, with_all_terms};

use crate::common::{Results, run};

const ROUGH: &str = "kind = \"made\"\nseed = 3";

/// A scene of cells; `contact` says how large they are.
fn over(elements: usize, contact: &str, road: &str, numerics: &str, more: &str) -> String {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.15\naxle = { indentation = 0.012, ramp = 0.03 }";
    let numerics = format!("pole_tolerance = 1e-3\ncontact_tolerance = 1e-4\n{numerics}");
    let contact = format!("[contact]\nzone = \"cells\"\n{contact}\n[outputs]\nplots = false\n{more}");
    scene_text(elements, road, rolling, &numerics, &contact)
}

/// Such a scene with its sums as a whole.
fn whole(elements: usize, contact: &str, road: &str, numerics: &str, more: &str) -> String {
    with_all_terms(&over(elements, contact, road, numerics, more))
}

const SUB_CELLS: &str = "cells_across = 4\nsub_cells = 3";

/// Mean force and its variation after the warm-up \[N\], contact area \[m^2\], power \[W\].
fn outcome(results: &Results) -> [f64; 4] {
    let summary = results.summary();
    let number = |path: &str| summary.pointer(path).and_then(serde_json::Value::as_f64).unwrap();
    [
        number("/outcome/mean_force"),
        number("/outcome/rms_force_variation"),
        number("/outcome/cells/mean_area"),
        number("/outcome/rolling_resistance/power"),
    ]
}

#[test]
fn sub_cells_touch_as_cells_as_small_do() {
    let of = |elements, contact: &str, q: &str| run(&whole(elements, contact, ROUGH, q, ""));
    let results = of(256, "cells_across = 24\nsub_cells = 3", "substeps = 3");
    let coarse = outcome(&of(256, "cells_across = 24", "substeps = 3"));
    let (sub_cells, fine) = (outcome(&results), outcome(&of(768, "cells_across = 72", "")));
    println!("256 x 24 cells {coarse:?}\nwith 3 x 3 sub-cells {sub_cells:?}\n768 x 72 cells {fine:?}");
    let errors = |found: [f64; 4]| [0, 1, 2, 3].map(|place| (found[place] / fine[place] - 1.0).abs());
    let ([force, variation, area, power], before) = (errors(sub_cells), errors(coarse));
    assert!(force < 0.01 && variation < 0.04 && area < 0.05 && power < 0.05, "{sub_cells:?} {fine:?}");
    assert!(force < 0.6 * before[0] && variation < 0.4 * before[1] && area < 0.2 * before[2], "{coarse:?} {fine:?}");
    results.assert_sound("sub-cells");
    // Forces of columns are those of their sub-cells: none pulls.
    let (_, columns, patch) = results.patch();
    let total = results.array("total_force.npy");
    assert!(patch.iter().all(|force| *force >= 0.0));
    for (total, patch) in total.iter().zip(patch.chunks_exact(columns)) {
        assert!((patch.iter().sum::<f64>() - total).abs() <= 1e-9 * total.max(1.0));
    }
}

#[test]
fn sub_cells_are_the_same_on_one_and_two_threads() {
    let text = whole(96, SUB_CELLS, ROUGH, "substeps = 2", "");
    let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(&text));
    let [one, two] = [on(1), on(2)];
    for name in ["total_force.npy", "row_force.npy", "contact_area.npy", "peak_pressure.npy", "spectra.csv"] {
        assert!(fs::read(one.path(name)).unwrap() == fs::read(two.path(name)).unwrap(), "{name}");
    }
}

#[test]
fn sub_cells_roll_alike_by_direct_sums_and_by_every_rule() {
    let smooth =
        |elements, numerics: &str| outcome(&run(&whole(elements, SUB_CELLS, "kind = \"smooth\"", numerics, "")));
    let errors = |found: [f64; 4], expected: [f64; 4]| [0, 2, 3].map(|n: usize| (found[n] / expected[n] - 1.0).abs());
    for rule in ["bdf2", "sdirk2"] {
        let rule = format!("time_rule = \"{rule}\"");
        let direct = smooth(48, &format!("{rule}\nhistory = \"direct\"\nmemory = 0.21"));
        let [force, area, power] = errors(smooth(48, &rule), direct);
        println!("{rule}, poles less direct sums: {force:.1e} {area:.1e} {power:.1e}");
        assert!(force < 1e-3 && area < 2e-3 && power < 2e-3, "{rule}: {force:e} {area:e} {power:e}");
    }
    let expected = smooth(128, "substeps = 6");
    for (rule, substeps) in [("bdf2", 12), ("sdirk3", 4)] {
        let found = smooth(128, &format!("time_rule = \"{rule}\"\nsubsteps = {substeps}"));
        let [force, area, power] = errors(found, expected);
        println!("{rule} less sdirk2: {force:.1e} {area:.1e} {power:.1e}");
        assert!(force < 1e-2 && area < 5e-2 && power < 6e-2, "{rule}: {found:?} {expected:?}");
    }
}

#[test]
fn what_has_no_sub_cells_is_refused() {
    let refused = |text: &str| tyrewave::Scene::from_str(text, "scene").unwrap_err().to_string();
    let friction = whole(64, SUB_CELLS, ROUGH, "", "[friction]\nmu = 0.8\n");
    let truncated = over(64, SUB_CELLS, ROUGH, "", "");
    let too_many = whole(64, "sub_cells = 9", ROUGH, "", "");
    let slices = whole(64, "sub_cells = 3", ROUGH, "", "").replace("zone = \"cells\"\n", "");
    for (text, reasons) in [
        (friction, ["contact.sub_cells", "friction"]),
        (truncated, ["contact.sub_cells", "lateral_terms"]),
        (too_many, ["contact.sub_cells", "8"]),
        (slices, ["contact.sub_cells", "zone = \"cells\""]),
    ] {
        let reported = refused(&text);
        assert!(reasons.iter().all(|reason| reported.contains(reason)), "{reported}");
    }
}

/// A preset has sub-cells unless the scene has what they cannot have, or gives their number.
#[test]
fn presets_have_sub_cells_where_they_can() {
    let chosen = |contact: &str, more: &str| {
        let text = whole(64, contact, ROUGH, "preset = \"standard\"\nfmax = 500.0", more);
        let text = text.replace("elements = 64\n", "");
        let plan = Plan::of(&scene(&text)).unwrap();
        (plan.scene.contact.sub_cells, plan.scene.numerics.elements)
    };
    let (with, without) = (chosen("", ""), chosen("sub_cells = 1", ""));
    assert_eq!(with.0, Some(3));
    assert!(without.0 == Some(1) && without.1 >= 2 * with.1, "{with:?} {without:?}");
    assert_eq!(chosen("", "[friction]\nmu = 0.8\n").0, Some(1));
}
