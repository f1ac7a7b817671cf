//! The sources of the library and the program: their modules, and what each takes from others.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A path of names, as `crate::contact::Axle`, or a module from the root, as `contact`.
pub(super) type Names = Vec<String>;

pub(super) fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.append(&mut rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// A file of `src`.
pub(super) struct Source {
    /// Below `src`.
    pub file: String,
    pub module: Names,
    /// Without comments and tests.
    pub code: String,
    /// Its tests; all of it, where only tests have it.
    pub tests: String,
}

/// All files of `src`.
pub(super) fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut found, mut of_tests) = (Vec::new(), Vec::new());
    for path in rust_files(&root) {
        let text = fs::read_to_string(&path).unwrap();
        let source = Source::new(path.strip_prefix(&root).unwrap().to_str().unwrap(), &text);
        let folder = source.file.rsplit_once('/').map_or("", |(folder, _)| folder);
        of_tests.extend(modules_of_tests(&text).into_iter().map(|module| format!("{folder}/{module}")));
        found.push(source);
    }
    for source in &mut found {
        let stem = source.file.trim_end_matches(".rs");
        if of_tests.iter().any(|module| stem == module || stem.starts_with(&format!("{module}/"))) {
            source.tests.push_str(&std::mem::take(&mut source.code));
        }
    }
    found
}

/// Files of modules behind `#[cfg(test)]`, without their ending.
fn modules_of_tests(text: &str) -> Vec<&str> {
    text.split("#[cfg(test)]\n")
        .skip(1)
        .filter_map(|rest| match rest.strip_prefix("#[path = \"") {
            Some(path) => path.split(".rs\"").next(),
            None => rest.lines().next()?.strip_suffix(';')?.split("mod ").nth(1),
        })
        .collect()
}

impl Source {
    pub(super) fn new(file: &str, text: &str) -> Self {
        let module = file.trim_end_matches(".rs").split('/').filter(|name| !["mod", "lib", "main"].contains(name));
        let (mut code, mut tests, mut in_tests) = (String::new(), String::new(), false);
        for line in text.lines() {
            in_tests |= line.ends_with("mod tests {") && !line.starts_with(' ');
            let part = if in_tests { &mut tests } else { &mut code };
            part.push_str(line.split("//").next().unwrap_or(""));
            part.push('\n');
            in_tests &= line != "}";
        }
        Self { file: file.to_owned(), module: module.map(str::to_owned).collect(), code, tests }
    }

    /// Its tests as a separate source.
    pub(super) fn of_tests(&self) -> Self {
        let inside =
            if self.code.is_empty() { self.module.clone() } else { [&self.module[..], &["tests".into()]].concat() };
        Self { file: self.file.clone(), module: inside, code: self.tests.clone(), tests: String::new() }
    }

    /// A folder's face: `mod.rs` hands on what the folder's files define.
    fn is_face(&self) -> bool {
        self.file.ends_with("mod.rs") || self.file == "lib.rs"
    }

    fn defines(&self, name: &str) -> bool {
        ["struct", "enum", "fn", "const", "static", "type", "trait"]
            .iter()
            .any(|kind| words_after(&self.code, &format!("{kind} ")).iter().any(|(_, word)| *word == name))
    }
}

/// Places behind every occurrence of a beginning that is no part of a longer path or name, with the word there.
fn words_after<'a>(text: &'a str, beginning: &str) -> Vec<(usize, &'a str)> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let whole =
        text.match_indices(beginning).filter(|(place, _)| !text[..*place].ends_with(|c| is_part(c) || c == ':'));
    whole
        .map(|(place, _)| place + beginning.len())
        .map(|behind| (behind, text[behind..].split(|c| !is_part(c)).next().unwrap_or("")))
        .collect()
}

/// The paths of a use tree, with the names that they get.
fn expanded(tree: &str) -> Vec<(Names, String)> {
    let Some((head, group)) = tree.split_once('{') else {
        let (path, name) = tree.split_once(" as ").unwrap_or((tree, ""));
        let mut path: Names = path.split("::").map(|name| name.trim().to_owned()).collect();
        path.retain(|name| !name.is_empty());
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        let name = if name.is_empty() { path.last().cloned().unwrap_or_default() } else { name.trim().to_owned() };
        return vec![(path, name)];
    };
    let (mut depth, mut begin, mut found) = (0, 0, Vec::new());
    for (place, c) in group.char_indices() {
        if depth == 0 && (c == ',' || c == '}') {
            if !group[begin..place].trim().is_empty() {
                found.extend(expanded(&format!("{head}{}", group[begin..place].trim())));
            }
            begin = place + 1;
        }
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            _ => {}
        }
    }
    found
}

/// Paths that a face hands on with their names, paths of its other `use`s, and the rest of the code.
fn statements(source: &Source) -> (Vec<(Names, String)>, Vec<Names>, String) {
    let (mut handed_on, mut used, mut rest) = (Vec::new(), Vec::new(), String::new());
    let mut lines = source.code.lines();
    while let Some(line) = lines.next() {
        let words = line.trim_start();
        let unrestricted = words.strip_prefix("pub(crate) ").or(words.strip_prefix("pub(super) ")).unwrap_or(words);
        let Some(tree) = unrestricted.strip_prefix("pub ").unwrap_or(unrestricted).strip_prefix("use ") else {
            rest.push_str(line);
            rest.push('\n');
            continue;
        };
        let mut tree = tree.to_owned();
        while !tree.ends_with(';') {
            tree.push_str(lines.next().unwrap_or(";").trim());
        }
        let paths = expanded(tree.trim_end_matches(';'));
        if words.starts_with("pub") && source.is_face() {
            handed_on.extend(paths);
        } else {
            used.extend(paths.into_iter().map(|(path, _)| path));
        }
    }
    (handed_on, used, rest)
}

/// Uses between modules.
pub(super) struct Uses<'a> {
    sources: &'a [Source],
    places: BTreeMap<&'a [String], usize>,
    /// By face: names handed on with their paths; `*` is all of a module.
    handed_on: Vec<Vec<(Names, String)>>,
}

impl<'a> Uses<'a> {
    pub(super) fn new(sources: &'a [Source]) -> Self {
        let places = sources.iter().enumerate().filter(|(_, source)| source.file != "main.rs");
        let places = places.map(|(place, source)| (source.module.as_slice(), place)).collect();
        let mut uses = Self { sources, places, handed_on: Vec::new() };
        uses.handed_on = sources.iter().map(|source| uses.handed_on(source)).collect();
        uses
    }

    /// Paths that a face hands on, with their names.
    fn handed_on(&self, source: &Source) -> Vec<(Names, String)> {
        let handed_on = statements(source).0;
        handed_on.into_iter().filter_map(|(path, name)| Some((self.absolute(source, &path)?, name))).collect()
    }

    /// Paths that the code uses, but for those that it only hands on.
    pub(super) fn used(&self, source: &Source) -> Vec<Names> {
        let (handed_on, mut used, rest) = statements(source);
        let is_used = |name: &str| words_after(&rest, name).iter().any(|(_, more)| more.is_empty());
        used.extend(handed_on.into_iter().filter(|(_, name)| is_used(name)).map(|(path, _)| path));
        let children = self.places.keys().filter(|module| source.is_face() && module.len() == source.module.len() + 1);
        let children =
            children.filter(|module| module.starts_with(&source.module)).map(|module| module.last().unwrap());
        for beginning in ["crate", "super"].into_iter().chain(children.map(String::as_str)) {
            for (behind, _) in words_after(&rest, &format!("{beginning}::")) {
                let path = rest[behind..].split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':').next().unwrap();
                used.push([beginning].into_iter().chain(path.split("::")).map(str::to_owned).collect());
            }
        }
        used.iter().filter_map(|path| self.absolute(source, path)).collect()
    }

    /// The files that a file needs, by place.
    pub(super) fn needed(&self, place: usize) -> BTreeSet<usize> {
        let used = self.used(&self.sources[place]);
        used.iter().filter_map(|path| self.target(path)).filter(|other| *other != place).collect()
    }

    /// A path as it is from the root, if it is one of this project.
    fn absolute(&self, source: &Source, path: &[String]) -> Option<Names> {
        let supers = path.iter().take_while(|name| *name == "super").count();
        let first = path.first()?;
        let (base, rest) = match first.as_str() {
            "crate" => (&[][..], &path[1..]),
            "self" => (&source.module[..], &path[1..]),
            "super" => (&source.module[..source.module.len().checked_sub(supers)?], &path[supers..]),
            _ => (&source.module[..], path),
        };
        let found = [base, rest].concat();
        let is_child = || source.is_face() && self.places.contains_key(&found[..base.len() + 1]);
        (["crate", "self", "super"].contains(&first.as_str()) || is_child()).then_some(found)
    }

    /// The file that a path from the root leads to, through faces.
    fn target(&self, path: &[String]) -> Option<usize> {
        let length = (0..=path.len()).rev().find(|&length| self.places.contains_key(&path[..length]))?;
        let place = self.places[&path[..length]];
        let Some(name) = path.get(length) else { return Some(place) };
        let named = self.handed_on[place].iter().find(|(_, other)| other == name);
        if let Some((further, _)) = named {
            return self.target(&[further, &path[length + 1..]].concat());
        }
        let all = self.handed_on[place].iter().filter(|(_, other)| other == "*");
        let mut within = all.filter_map(|(module, _)| {
            let found = self.target(&[&module[..module.len() - 1], &path[length..]].concat())?;
            self.sources[found].defines(name).then_some(found)
        });
        within.next().or(Some(place))
    }
}
