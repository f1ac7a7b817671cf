//! The archive that is released, unpacked as `.ci/archive.txt` lists it: links between its pages, the commands
//! of its pages and those of `tyrewave help`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use clap::error::ErrorKind::{InvalidSubcommand, UnknownArgument};
use tempfile::TempDir;

use crate::common::tyrewave;
use tyrewave::internals::program;

const LISTED: &str = include_str!("../../.ci/archive.txt");

/// The archive, unpacked into a separate folder.
pub(super) fn unpacked() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for path in LISTED.lines() {
        copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path), &folder.path().join(path));
    }
    folder
}

/// Copies a file, or a folder with all that is in it.
pub(super) fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        for entry in fs::read_dir(from).unwrap() {
            let name = entry.unwrap().file_name();
            copy(&from.join(&name), &to.join(&name));
        }
    } else {
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::copy(from, to).unwrap();
    }
}

/// All pages of the archive: path and text.
fn pages(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut pages = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            pages.extend(self::pages(&path));
        } else if path.extension().is_some_and(|ending| ending == "md") {
            let text = fs::read_to_string(&path).unwrap();
            pages.push((path, text));
        }
    }
    pages
}

/// Name by which a page's heading is linked to.
fn anchor(heading: &str) -> String {
    let letters = heading.trim_start_matches('#').trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    letters.collect::<String>().to_lowercase().replace(' ', "-")
}

#[test]
fn links_between_pages_of_the_archive_lead_somewhere() {
    let folder = unpacked();
    let mut found = 0;
    for (page, text) in pages(folder.path()) {
        let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
        for target in targets.filter(|target| !target.contains("://")) {
            let (file, heading) = target.split_once('#').map_or((target, None), |(file, name)| (file, Some(name)));
            let path = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            assert!(path.exists(), "{}: there is no {target}", page.display());
            if let Some(heading) = heading {
                let linked = fs::read_to_string(&path).unwrap();
                let held = linked.lines().any(|line| line.starts_with('#') && anchor(line) == heading);
                assert!(held, "{}: {target} is no heading", page.display());
            }
            found += 1;
        }
    }
    assert!(found > 60, "{found}");
}

/// Commands of a text in a shell, one a line: what stands behind "tyrewave", without redirection and description.
fn commands(text: &str) -> Vec<String> {
    let mut commands = Vec::new();
    for line in text.replace("\\\n", " ").lines() {
        for part in line.split('#').next().unwrap().split(" && ") {
            let part = part.trim();
            let built = part.split_once(" -- ").filter(|(cargo, _)| cargo.starts_with("cargo run"));
            if let Some(rest) = part.strip_prefix("tyrewave ").or(built.map(|(_, rest)| rest)) {
                commands.push(rest.split(" > ").next().unwrap().trim().to_owned());
            }
        }
    }
    commands
}

/// Words of a command, without the quotes round one.
pub(super) fn words(command: &str) -> impl Iterator<Item = &str> {
    command.split_whitespace().map(|word| word.trim_matches('\''))
}

/// Commands of the examples of `tyrewave help`, for all commands.
fn examples() -> Vec<String> {
    let line = program();
    let mut all = Vec::new();
    for command in line.get_subcommands().chain([&line]) {
        let help = command.get_after_help().unwrap().to_string();
        // A description stands behind two or more blanks.
        let lines = help.replace("\\\n      ", "");
        let lines = lines.lines().filter_map(|line| line.strip_prefix("  ")?.split("  ").next());
        all.extend(commands(&lines.collect::<Vec<_>>().join("\n")));
    }
    all
}

/// The first of the values that a sweep gives a key.
fn first_value(setting: &str) -> String {
    let (key, values) = setting.split_once('=').unwrap();
    format!("{key}={}", values.split("..").next().unwrap().split(',').next().unwrap())
}

/// Arguments executed for a command: its own where it takes no time, else a check of the scenes that it names, with its
/// settings; nothing where it names no scene.
fn executed_of(folder: &Path, command: &str) -> Option<Vec<String>> {
    let words: Vec<&str> = words(command).collect();
    if ["keys", "completions"].contains(&words[0]) {
        return Some(words.into_iter().map(str::to_owned).collect());
    }
    let mut scenes = Vec::new();
    for word in words.iter().filter(|word| word.starts_with("scenes/") && word.ends_with(".toml")) {
        match word.strip_suffix("*.toml") {
            Some(beside) => {
                let files = fs::read_dir(folder.join(beside)).unwrap().map(|entry| entry.unwrap().file_name());
                let files = files.filter_map(|name| name.into_string().ok());
                scenes.extend(files.filter(|name| name.ends_with(".toml")).map(|name| format!("{beside}{name}")));
            }
            None => scenes.push((*word).to_owned()),
        }
    }
    let settings = words.windows(2).filter(|pair| pair[0] == "--set");
    let settings = settings.flat_map(|pair| ["--set".to_owned(), first_value(pair[1])]);
    (!scenes.is_empty()).then(|| ["check".to_owned()].into_iter().chain(scenes).chain(settings).collect())
}

#[test]
fn commands_of_pages_and_help_are_read_and_their_scenes_hold() {
    let folder = unpacked();
    let examples = examples();
    assert!(examples.len() >= 80, "{} examples", examples.len());
    let mut read: Vec<(String, bool)> = examples.into_iter().map(|command| (command, true)).collect();
    for (page, text) in pages(folder.path()) {
        // Records of what was: their commands were those of their time.
        if page.ends_with("CHANGELOG.md") || page.starts_with(folder.path().join("profiles")) {
            continue;
        }
        let blocks = text.split("```").skip(1).step_by(2).filter_map(|block| block.strip_prefix("sh\n"));
        read.extend(blocks.flat_map(commands).map(|command| (command, true)));
        // In a sentence a command may stand without what it needs, and a word for a value.
        let sentences = text.split("```").step_by(2).collect::<String>().replace('\n', " ");
        let named = sentences.split('`').skip(1).step_by(2).flat_map(commands);
        read.extend(named.map(|command| (command, false)));
    }
    assert!(read.len() >= 160, "{} commands", read.len());
    let mut executed = BTreeSet::new();
    let mut wrong = Vec::new();
    for (command, whole) in read.into_iter().filter(|(command, _)| !command.starts_with("help")) {
        match program().try_get_matches_from(["tyrewave"].into_iter().chain(words(&command))) {
            Err(error) if whole || [UnknownArgument, InvalidSubcommand].contains(&error.kind()) => {
                wrong.push(format!("tyrewave {command}: {error}"));
            }
            Err(_) => {}
            // The tutorial makes its scenes.
            Ok(_) => executed.extend(executed_of(folder.path(), &command)),
        }
    }
    assert!(executed.len() >= 19, "{} commands executed", executed.len());
    for command in executed {
        let words: Vec<&str> = command.iter().map(String::as_str).collect();
        let done = tyrewave(folder.path(), &words);
        if !done.status.success() {
            wrong.push(format!("tyrewave {}: {}", command.join(" "), String::from_utf8_lossy(&done.stderr)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
