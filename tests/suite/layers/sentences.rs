//! Sentences that a reader understands at the first reading: a type or a field opens with its noun, a function with a
//! verb in the third person.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use super::sources::rust_files;

/// Openings that hide the subject of a sentence.
const OPENINGS: [&str; 9] = ["What", "Whether", "Who", "Whoever", "Whose", "Of", "That", "Nobody", "Somebody"];
/// Subjects that are never named.
const UNNAMED: [&str; 5] = ["nobody", "somebody", "whoever", "anybody", "everybody"];

/// The word of a comment or of a text that should not be there.
fn riddle(line: &str) -> Option<&'static str> {
    let words = || line.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let first = line.trim_start_matches(['-', '*', '#', '>', ' ']).split(|c: char| !c.is_alphanumeric()).next();
    let opening = OPENINGS.into_iter().find(|&opening| Some(opening) == first);
    opening.or_else(|| UNNAMED.into_iter().find(|unnamed| words().any(|word| word.eq_ignore_ascii_case(unnamed))))
}

/// A documentation comment's text.
fn documentation(line: &str) -> Option<&str> {
    let line = line.trim_start();
    line.strip_prefix("///").or(line.strip_prefix("//!"))
}

/// Verbs that open the comments of functions; a new one is added to the file.
const VERBS: &str = include_str!("verbs.txt");

fn is_verb(word: &str) -> bool {
    VERBS.split_whitespace().any(|verb| verb == word)
}

/// Returns the functions of a source file whose comments do not open with a verb: line and first word.
fn without_verb(text: &str) -> Vec<(usize, String)> {
    let (mut opening, mut found) = (None, Vec::new());
    for (number, line) in text.lines().enumerate() {
        let line = line.trim_start();
        if let Some(comment) = line.strip_prefix("///") {
            let first = comment.split_whitespace().next().unwrap_or_default();
            opening.get_or_insert_with(|| first.trim_end_matches([',', ':', '.']).to_owned());
        } else if !line.starts_with(['#', ')', ']']) {
            let is_function = line.split_whitespace().take(5).any(|word| word == "fn") && !line.starts_with("//");
            let word = opening.take().filter(|_| is_function);
            found.extend(word.filter(|word| !is_verb(word)).map(|word| (number + 1, word)));
        }
    }
    found
}

/// Documents beside the sources, with paragraphs instead of comments.
fn documents(root: &Path) -> Vec<std::path::PathBuf> {
    let folders = [root.to_owned(), root.join("docs"), root.join("profiles"), root.join("python"), root.join("tests")];
    let files = folders.iter().flat_map(|folder| fs::read_dir(folder).into_iter().flatten());
    files.map(|entry| entry.unwrap().path()).filter(|path| path.extension().is_some_and(|kind| kind == "md")).collect()
}

#[test]
fn no_sentence_hides_its_subject() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut looked_at, mut found) = (0, BTreeSet::new());
    let mut look = |path: &Path, number: usize, text: &str| {
        looked_at += 1;
        if let Some(word) = riddle(text) {
            found.insert(format!("{}:{}: {word}", path.strip_prefix(root).unwrap().display(), number + 1));
        }
    };
    for path in ["src", "tests", "benches", "examples"].into_iter().flat_map(|folder| rust_files(&root.join(folder))) {
        for (number, line) in fs::read_to_string(&path).unwrap().lines().enumerate() {
            documentation(line).into_iter().for_each(|text| look(&path, number, text));
        }
    }
    for path in documents(root) {
        for (number, line) in fs::read_to_string(&path).unwrap().lines().enumerate() {
            look(&path, number, line);
        }
    }
    assert!(looked_at > 5000, "only {looked_at} lines were found");
    assert!(found.is_empty(), "{} sentences hide their subject: {found:#?}", found.len());
}

#[test]
fn sentences_that_hide_their_subject_are_found() {
    for (text, word) in [
        (" What happened when.", Some("What")),
        (" - Whether it is.", Some("Whether")),
        (" Steps that nobody sees.", Some("nobody")),
        (" Timeline of what happened, or whether it did.", None),
        (" Offers whatever is there.", None),
    ] {
        assert_eq!(riddle(text), word, "{text}");
    }
}

#[test]
fn comments_of_functions_open_with_a_verb() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = BTreeSet::new();
    for path in rust_files(&root.join("src")) {
        let name = path.strip_prefix(root).unwrap().display().to_string();
        let text = fs::read_to_string(&path).unwrap();
        found.extend(without_verb(&text).into_iter().map(|(line, word)| format!("{name}:{line}: {word}")));
    }
    assert!(found.is_empty(), "no verbs of tests/suite/layers/verbs.txt, {}: {found:#?}", found.len());
}

#[test]
fn functions_without_a_verb_are_found() {
    let text = "/// Length \\[m\\].\n///\n/// More.\n#[must_use]\npub(crate) const fn length() {}\n\
                /// Length.\nlength: f64,\n/// Returns it.\nfn it() {}\n/// Reads, writes.\npub fn both() {}\n";
    assert_eq!(without_verb(text), [(5, "Length".to_owned())]);
}
