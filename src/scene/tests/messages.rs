//! Form of error messages.

use super::super::{Scene, SceneError};
use super::edited;

fn error(from: &str, to: &str) -> SceneError {
    Scene::from_str(&edited(from, to), "my scene.toml").unwrap_err()
}

#[test]
fn the_line_is_shown_and_the_value_marked() {
    let rendered = error("thickness = 0.013", "thickness = -0.013").render(false);
    let expected = "\
error: tyre.layers[1].thickness: -0.013 is out of range
  --> my scene.toml:14:13
   |
14 | thickness = -0.013
   |             ^^^^^^ write a number above 0 m";
    assert_eq!(rendered, expected);
}

#[test]
fn an_unknown_key_is_marked_itself() {
    let rendered = error("plots = true", "plot = true").render(false);
    let expected = "\
error: outputs.plot: this is not a key of [outputs]
  --> my scene.toml:27:1
   |
27 | plot = true
   | ^^^^ did you mean `plots`?";
    assert_eq!(rendered, expected);
}

#[test]
fn colour_only_when_asked_for() {
    let error = error("plots = true", "plot = true");
    assert!(!error.render(false).contains('\u{1b}'));
    assert!(error.render(true).contains('\u{1b}'));
    let missing = Scene::load("no such scene.toml").unwrap_err();
    assert!(!missing.render(false).contains('\u{1b}'));
    assert!(missing.render(true).contains('\u{1b}'));
    assert_eq!(missing.render(false), "error: there is no file \"no such scene.toml\"");
}

#[test]
fn display_has_one_line_per_mistake() {
    let error = error("plots = true", "plot = true\narray = 1");
    let expected = "\
my scene.toml:27:1: outputs.plot: this is not a key of [outputs] (did you mean `plots`?)
my scene.toml:28:1: outputs.array: this is not a key of [outputs] (did you mean `arrays`?)";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn control_characters_of_the_file_do_not_reach_the_terminal() {
    let error = error("plots = true", "\"\\u001b[31m\" = \"\\u001b[31m\"\nplots = \"\\u001b[31m\"");
    assert_eq!(error.diagnostics().len(), 2);
    assert!(!error.render(false).contains('\u{1b}'));
    assert!(!error.to_string().contains('\u{1b}'));
}

#[test]
fn columns_count_characters() {
    let error = error("title = \"base\"", "title = \"R\u{e4}der\" extra");
    let diagnostic = &error.diagnostics()[0];
    assert_eq!((diagnostic.line(), diagnostic.column()), (1, 17));
}

#[test]
fn windows_line_ends_and_a_byte_order_mark_do_not_shift_lines() {
    let text = format!("\u{feff}{}", edited("thickness = 0.013", "thickness = -0.013").replace('\n', "\r\n"));
    let error = Scene::from_str(&text, "test.toml").unwrap_err();
    let diagnostic = &error.diagnostics()[0];
    assert_eq!((diagnostic.line(), diagnostic.column()), (14, 13));
}
