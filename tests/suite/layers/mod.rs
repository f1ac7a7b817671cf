//! The order of the sources: each module of the library knows only those before it, as src/lib.rs documents; no files
//! use each other in a circle; no line is wider than 120 columns; no sentence hides its subject.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use sources::{Source, Uses, rust_files, sources};

mod sentences;
mod sources;

/// Lowest first; modules of one level do not know each other.
const LEVELS: [&[&str]; 19] = [
    &["numeric", "counters"],
    &["storage"],
    &["half_space", "time_rule", "radiation", "sidewall"],
    &["scene"],
    &["tyre", "road"],
    &["contact"],
    &["response"],
    &["sound"],
    &["results"],
    &["plan"],
    &["effects"],
    &["planning"],
    &["run"],
    &["study"],
    &["report"],
    &["performance"],
    &["cli", "python"],
    &["test_models"],
    &["internals"],
];
fn level(module: &str) -> Option<usize> {
    LEVELS.iter().position(|modules| modules.contains(&module))
}

#[test]
fn every_module_is_documented_in_the_order_of_levels() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    let modules: Vec<&str> = text
        .lines()
        .filter_map(|line| line.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';'))
        .collect();
    assert!(modules.len() >= 9);
    for module in &modules {
        assert!(level(module).is_some(), "{module} has no level in tests/suite/layers/mod.rs");
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

#[test]
fn no_module_uses_one_that_comes_later() {
    let sources = sources();
    let uses = Uses::new(&sources);
    let (mut inspected, mut found) = (0, BTreeSet::new());
    for source in &sources {
        let Some((module, level_of_module)) = source.module.first().and_then(|module| Some((module, level(module)?)))
        else {
            continue;
        };
        for (source, of_tests) in [(source, None), (&source.of_tests(), Some("test_models"))] {
            for path in uses.used(source) {
                inspected += 1;
                let other = path.first().unwrap();
                let is_later = other != module && level(other).is_some_and(|level| level >= level_of_module);
                if is_later && of_tests != Some(other) {
                    found.insert(format!("{} uses {}", source.file, path.join("::")));
                }
            }
        }
    }
    assert!(inspected > 1000, "only {inspected} uses were found");
    assert!(found.is_empty(), "uses of later modules: {found:#?}");
}

#[test]
fn plans_and_pages_reach_effects_through_their_list_alone() {
    let sources = sources();
    let uses = Uses::new(&sources);
    let folders =
        sources.iter().filter(|source| source.file.starts_with("effects/") && source.file.ends_with("/mod.rs"));
    let folders: BTreeSet<&str> = folders.filter_map(|source| source.module.get(1).map(String::as_str)).collect();
    assert_eq!(
        folders.len(),
        tyrewave::internals::number_of_effects(),
        "an effect is a folder and a line: {folders:?}"
    );
    let (mut inspected, mut found) = (0, BTreeSet::new());
    for source in &sources {
        let Some("results" | "plan" | "planning" | "report") = source.module.first().map(String::as_str) else {
            continue;
        };
        for path in uses.used(source) {
            inspected += 1;
            if path.len() > 1 && path[0] == "effects" && folders.contains(path[1].as_str()) {
                found.insert(format!("{} uses {}", source.file, path.join("::")));
            }
        }
    }
    assert!(inspected > 100 && found.is_empty(), "effects that are known by name: {found:#?}");
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
    let found = circles(&sources);
    assert!(found.is_empty(), "circles of files: {found:#?}");
}

#[test]
fn circles_are_found_through_faces_and_in_all_forms_of_paths() {
    let found = |b: &str, c: &str| {
        let files = [
            ("a/mod.rs", "mod b;\npub mod c;\nmod d;\npub use b::{B, more};\npub use d::*;\n"),
            ("a/b.rs", b),
            ("a/c.rs", c),
            ("a/d.rs", "pub struct D;\n#[cfg(test)]\nmod tests {\n    use crate::a::c::C;\n}\n"),
            ("e.rs", "use crate::a::{B, c::C};\n"),
        ];
        let sources = files.map(|(file, text)| Source::new(file, text));
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

#[test]
fn no_line_is_wider_than_120_columns() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut wide = BTreeSet::new();
    for path in ["src", "tests", "benches", "examples"].into_iter().flat_map(|folder| rust_files(&root.join(folder))) {
        if fs::read_to_string(&path).unwrap().lines().any(|line| line.chars().count() > 120) {
            wide.insert(path.strip_prefix(root).unwrap().to_str().unwrap().to_owned());
        }
    }
    assert!(wide.is_empty(), "files with lines of more than 120 columns: {wide:#?}");
}
