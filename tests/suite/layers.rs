//! Each module of the library knows only those before it, in the order that src/lib.rs documents.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Lowest first; modules of one level do not know each other.
const LEVELS: [&[&str]; 12] = [
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
];

fn level(module: &str) -> Option<usize> {
    LEVELS.iter().position(|modules| modules.contains(&module))
}

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Modules named behind every `crate::`, braces included; comments do not count, a `pub(crate)` is none.
fn known(text: &str) -> BTreeSet<String> {
    let code: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap_or("")).collect();
    let code = code.join("\n");
    let name = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut modules = BTreeSet::new();
    for (place, _) in code.match_indices("crate::") {
        let rest = &code[place + "crate::".len()..];
        let Some(group) = rest.strip_prefix('{') else {
            modules.insert(name(rest));
            continue;
        };
        let (mut depth, mut begin) = (0, true);
        for (i, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => begin = true,
                c if begin && !c.is_whitespace() => {
                    modules.insert(name(&group[i..]));
                    begin = false;
                }
                _ => {}
            }
        }
    }
    modules
}

#[test]
fn every_module_of_the_library_has_a_level_and_is_documented_in_that_order() {
    let text = fs::read_to_string(source().join("lib.rs")).unwrap();
    let modules: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    assert!(modules.len() >= 9);
    for module in &modules {
        assert!(level(module).is_some(), "{module} has no level in tests/suite/layers.rs");
        assert!(text.contains(&format!("[`{module}`]")), "src/lib.rs does not say where {module} stands");
    }
    let documented: Vec<usize> = text
        .lines()
        .find(|line| line.contains("->"))
        .unwrap()
        .split('`')
        .skip(1)
        .step_by(2)
        .map(|module| level(module).unwrap_or_else(|| panic!("{module} is documented but not there")))
        .collect();
    assert!(documented.is_sorted(), "the order in src/lib.rs is not that of the test");
}

#[test]
fn no_module_uses_one_that_comes_later() {
    let mut paths = Vec::new();
    files(&source(), &mut paths);
    let (mut looked_at, mut wrong) = (0, Vec::new());
    for path in &paths {
        let relative = path.strip_prefix(source()).unwrap();
        let module = relative.components().next().unwrap().as_os_str().to_string_lossy();
        let Some(own) = level(&module) else { continue };
        for other in known(&fs::read_to_string(path).unwrap()) {
            looked_at += 1;
            let allowed = other == module || level(&other).is_some_and(|level| level < own);
            if !allowed {
                wrong.push(format!("{} uses crate::{other}", relative.display()));
            }
        }
    }
    assert!(looked_at > 50, "only {looked_at} uses were found");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn uses_are_found_in_all_their_forms() {
    let text = "use crate::road::{self, x};\nuse crate::{scene::{Scene, tyre}, tyre::y};\n// crate::cli\n\
        let a = crate::counters::Stage::A;";
    let expected = ["meter", "road", "scene", "tyre"].map(String::from);
    assert_eq!(known(text), BTreeSet::from(expected));
}
