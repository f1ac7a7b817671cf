//! The order of the sources: each module of the library knows only those before it, as src/lib.rs documents; no files
//! use each other in a circle; no line is wider than 120 columns.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use sources::{Source, Uses, rust_files, sources};

mod sources;

/// Lowest first; modules of one level do not know each other.
const LEVELS: [&[&str]; 13] = [
    &["numeric", "counters"],
    &["half_space"],
    &["scene"],
    &["tyre", "road"],
    &["contact"],
    &["response"],
    &["results"],
    &["local_compliance"],
    &["plan"],
    &["run"],
    &["study"],
    &["profile"],
    &["test_models"],
];

fn level(module: &str) -> Option<usize> {
    LEVELS.iter().position(|modules| modules.contains(&module))
}

/// Fails unless what was found is what is known to be there still.
fn assert_known<T: Ord + std::fmt::Debug>(what: &str, found: &BTreeSet<T>, known: &BTreeSet<T>) {
    let new: Vec<&T> = found.difference(known).collect();
    assert!(new.is_empty(), "new {what}: {new:#?}");
    let gone: Vec<&T> = known.difference(found).collect();
    assert!(gone.is_empty(), "{what} that are gone, to take off the list: {gone:#?}");
}

#[test]
fn every_module_of_the_library_has_a_level_and_is_documented_in_that_order() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    let modules: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    assert!(modules.len() >= 9);
    for module in &modules {
        assert!(level(module).is_some(), "{module} has no level in tests/suite/layers.rs");
        assert!(text.contains(&format!("`{module}`")), "src/lib.rs does not say where {module} stands");
    }
    let documented: Vec<usize> = text
        .lines()
        .filter(|line| line.contains("->"))
        .flat_map(|line| line.split('`').skip(1).step_by(2))
        .map(|module| level(module).unwrap_or_else(|| panic!("{module} is documented but not there")))
        .collect();
    assert!(documented.is_sorted(), "the order in src/lib.rs is not that of the test");
}

/// Uses of later modules that are still there. The list may only get shorter.
const KNOWN_LATER: &[&str] = &[
    "local_compliance/calibrate.rs uses run::error::RunError",
    "plan/amounts.rs uses run::road_ahead::CHUNK_ROWS",
    "plan/amounts.rs uses run::to_folder::LENGTHS_DRAWN",
    "plan/amounts.rs uses run::vibration::point_bytes",
    "plan/mod.rs uses run::past::contact_field",
    "plan/mod.rs uses run::past::fit_options",
];

#[test]
fn no_module_uses_one_that_comes_later() {
    let sources = sources();
    let uses = Uses::new(&sources);
    let (mut looked_at, mut found) = (0, BTreeSet::new());
    for source in &sources {
        let Some((module, own)) = source.module.first().and_then(|module| Some((module, level(module)?))) else {
            continue;
        };
        for (source, of_tests) in [(source, None), (&source.of_tests(), Some("test_models"))] {
            for path in uses.used(source) {
                looked_at += 1;
                let other = path.first().unwrap();
                let is_later = other != module && level(other).is_some_and(|level| level >= own);
                if is_later && of_tests != Some(other) {
                    found.insert(format!("{} uses {}", source.file, path.join("::")));
                }
            }
        }
    }
    assert!(looked_at > 1000, "only {looked_at} uses were found");
    assert_known("uses", &found, &KNOWN_LATER.iter().map(|line| (*line).to_owned()).collect());
}

#[test]
fn uses_are_found_in_all_their_forms() {
    let text = "use crate::road::{self, x};\nuse crate::{scene::{Scene, tyre}, tyre::y};\n// crate::cli\n\
        let a = crate::counters::Stage::A; super::here(); pub(crate) fn b();";
    let sources = [Source::new("c/a.rs", text)];
    let mut found: Vec<String> = Uses::new(&sources).used(&sources[0]).iter().map(|path| path.join("::")).collect();
    found.sort();
    assert_eq!(found, ["c::here", "counters::Stage::A", "road", "road::x", "scene::Scene", "scene::tyre", "tyre::y"]);
}

/// Circles of files that are still there. The list may only get shorter.
const KNOWN_CIRCLES: &[&[&str]] = &[
    &[
        "cli/cache.rs",
        "cli/compliance.rs",
        "cli/effects.rs",
        "cli/indent.rs",
        "cli/influence.rs",
        "cli/mobility.rs",
        "cli/mod.rs",
        "cli/plan.rs",
        "cli/profile.rs",
        "cli/profiling.rs",
        "cli/resume.rs",
        "cli/road.rs",
        "cli/rules.rs",
        "cli/run.rs",
        "cli/scaling.rs",
        "cli/slice.rs",
        "cli/slices.rs",
        "cli/study.rs",
        "cli/sweep.rs",
    ],
    &["contact/axle.rs", "contact/moving_axle.rs"],
    &["half_space/gradients.rs", "half_space/rough.rs"],
    &["local_compliance/calibrate.rs", "local_compliance/mod.rs"],
    &[
        "plan/amounts.rs",
        "plan/forecast.rs",
        "plan/mod.rs",
        "run/checkpoint.rs",
        "run/in_memory.rs",
        "run/past.rs",
        "run/prepare.rs",
        "run/record.rs",
        "run/rolling_resistance.rs",
        "run/to_folder.rs",
        "run/vibration/mod.rs",
    ],
    &["response/accumulator.rs", "response/spectrum.rs"],
    &["response/vibration/accumulator.rs", "response/vibration/elements.rs", "response/vibration/points.rs"],
    &["results/checkpoint.rs", "results/folder.rs", "results/unfinished.rs"],
    &["road/grid.rs", "road/lattice.rs"],
    &["road/made/levels.rs", "road/made/synthesis.rs"],
    &[
        "scene/diagnostic.rs",
        "scene/document.rs",
        "scene/error.rs",
        "scene/kind.rs",
        "scene/problem.rs",
        "scene/table.rs",
    ],
    &["study/accuracy/mod.rs", "study/accuracy/presets.rs"],
    &["tyre/influence.rs", "tyre/moments.rs"],
    &["tyre/rational/passivity.rs", "tyre/rational/wavenumber.rs"],
];

/// Files that take from each other, directly or through others.
fn circles(sources: &[Source]) -> BTreeSet<Vec<&str>> {
    let uses = Uses::new(sources);
    let needed: Vec<BTreeSet<usize>> = (0..sources.len()).map(|place| uses.needed(place)).collect();
    let reached = |from: usize| {
        let (mut reached, mut open) = (BTreeSet::new(), vec![from]);
        while let Some(place) = open.pop() {
            open.extend(needed[place].iter().filter(|other| reached.insert(**other)));
        }
        reached
    };
    let reached: Vec<BTreeSet<usize>> = (0..sources.len()).map(reached).collect();
    let together = |a: usize, b: usize| a == b || (reached[a].contains(&b) && reached[b].contains(&a));
    let mut found = BTreeSet::new();
    for place in 0..sources.len() {
        let circle = (0..sources.len()).filter(|&other| together(place, other));
        let circle: Vec<&str> = circle.map(|place| sources[place].file.as_str()).collect();
        if circle.len() > 1 {
            found.insert(circle);
        }
    }
    found
}

#[test]
fn no_files_use_each_other_in_a_circle() {
    let sources = sources();
    let known = KNOWN_CIRCLES.iter().map(|circle| circle.to_vec()).collect();
    assert_known("circles", &circles(&sources), &known);
}

#[test]
fn circles_are_found_through_faces_and_in_all_forms_of_paths() {
    let found = |b: &str, c: &str| {
        let house = [
            ("a/mod.rs", "mod b;\npub mod c;\nmod d;\npub use b::{B, more};\npub use d::*;\n"),
            ("a/b.rs", b),
            ("a/c.rs", c),
            ("a/d.rs", "pub struct D;\n#[cfg(test)]\nmod tests {\n    use crate::a::c::C;\n}\n"),
            ("e.rs", "use crate::a::{B, c::C};\n"),
        ];
        let sources = house.map(|(file, text)| Source::new(file, text));
        circles(&sources).into_iter().flatten().collect::<Vec<_>>().join(" ")
    };
    // A face hands on and is in no circle by that; nor is a test.
    assert_eq!(found("use super::c::C;\npub struct B;", "use crate::a::D;\npub struct C;"), "");
    for (b, c) in [
        ("use super::c::C;\npub struct B;", "use crate::a::B;\npub struct C;"),
        ("use super::c::C;\npub struct B;", "use super::{D, B as Other};\npub struct C;"),
        ("use crate::{a::{D, c::{self, C}}};\npub struct B;", "pub struct C(super::b::B);"),
        ("pub fn more() -> crate::a::c::C {}", "pub fn less() {\n    super::more()\n}"),
    ] {
        assert_eq!(found(b, c), "a/b.rs a/c.rs", "{b}\n{c}");
    }
}

/// Files with lines that are too wide still. The list may only get shorter.
const KNOWN_WIDE: &[&str] = &[
    "src/cli/cache.rs",
    "src/cli/compliance.rs",
    "src/cli/effects.rs",
    "src/cli/error.rs",
    "src/cli/heights.rs",
    "src/cli/indent.rs",
    "src/cli/influence.rs",
    "src/cli/mobility.rs",
    "src/cli/mod.rs",
    "src/cli/plan.rs",
    "src/cli/profile.rs",
    "src/cli/resume.rs",
    "src/cli/road.rs",
    "src/cli/rules.rs",
    "src/cli/run.rs",
    "src/cli/slice.rs",
    "src/cli/slices.rs",
    "src/cli/study.rs",
    "src/cli/study_report.rs",
    "src/cli/sweep.rs",
    "src/contact/active_set.rs",
    "src/contact/error.rs",
    "src/contact/moving_axle.rs",
    "src/contact/neighbour_set.rs",
    "src/half_space/error.rs",
    "src/plan/decisions.rs",
    "src/plan/mod.rs",
    "src/profile/report.rs",
    "src/response/vibration/contact_power.rs",
    "src/response/vibration/elements.rs",
    "src/response/vibration/mod.rs",
    "src/response/vibration/share.rs",
    "src/response/vibration/transfer.rs",
    "src/results/checkpoint.rs",
    "src/results/error.rs",
    "src/results/npy.rs",
    "src/results/plots/heat_map.rs",
    "src/results/trace.rs",
    "src/road/error.rs",
    "src/road/opencrg/error.rs",
    "src/road/opencrg/header.rs",
    "src/road/report.rs",
    "src/road/slices/error.rs",
    "src/road/slices/winkler.rs",
    "src/road/tests/crg.rs",
    "src/road/tests/measured.rs",
    "src/run/error.rs",
    "src/run/past.rs",
    "src/run/prepare.rs",
    "src/run/to_folder.rs",
    "src/run/vibration/mod.rs",
    "src/scene/error.rs",
    "src/scene/read/axle.rs",
    "src/scene/read/numerics.rs",
    "src/scene/tests/mistakes/road.rs",
    "src/study/accuracy/front.rs",
    "src/tyre/influence.rs",
    "src/tyre/influence_view.rs",
    "src/tyre/rational/fit.rs",
    "src/tyre/rational/mod.rs",
];

#[test]
fn no_line_is_wider_than_120_columns() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut wide = BTreeSet::new();
    for path in ["src", "tests", "benches"].into_iter().flat_map(|folder| rust_files(&root.join(folder))) {
        if fs::read_to_string(&path).unwrap().lines().any(|line| line.chars().count() > 120) {
            wide.insert(path.strip_prefix(root).unwrap().to_str().unwrap().to_owned());
        }
    }
    assert_known("files with wide lines", &wide, &KNOWN_WIDE.iter().map(|file| (*file).to_owned()).collect());
}
