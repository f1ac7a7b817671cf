//! Sentences that a reader understands at the first reading: none hides its subject.

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

/// Documents beside the sources, with paragraphs instead of comments.
fn documents(root: &Path) -> Vec<std::path::PathBuf> {
    let folders = [root.to_owned(), root.join("docs"), root.join("profiles"), root.join("python"), root.join("tests")];
    let files = folders.iter().flat_map(|folder| fs::read_dir(folder).into_iter().flatten());
    files.map(|entry| entry.unwrap().path()).filter(|path| path.extension().is_some_and(|kind| kind == "md")).collect()
}

#[test]
fn no_sentence_hides_its_subject() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut inspected, mut found) = (0, BTreeSet::new());
    let mut inspect = |path: &Path, number: usize, text: &str| {
        inspected += 1;
        if let Some(word) = riddle(text) {
            found.insert(format!("{}:{}: {word}", path.strip_prefix(root).unwrap().display(), number + 1));
        }
    };
    for path in ["src", "tests", "benches", "examples"].into_iter().flat_map(|folder| rust_files(&root.join(folder))) {
        for (number, line) in fs::read_to_string(&path).unwrap().lines().enumerate() {
            documentation(line).into_iter().for_each(|text| inspect(&path, number, text));
        }
    }
    for path in documents(root) {
        for (number, line) in fs::read_to_string(&path).unwrap().lines().enumerate() {
            inspect(&path, number, line);
        }
    }
    assert!(inspected > 5000, "only {inspected} lines were found");
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
