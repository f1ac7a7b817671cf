//! Mistakes possible in any table: keys that are unknown, missing, doubled, or of another type.

use super::super::super::Scene;
use super::super::{BASE, complaints, edited};
use super::{axle_refused, material_refused, refused, road_refused};
use crate::test_models::replaced;

#[test]
fn the_base_scene_is_accepted() {
    assert!(Scene::from_str(BASE, "test.toml").is_ok());
}

#[test]
fn unknown_keys() {
    refused(
        "thickness = 0.013",
        "thicknes = 0.013\nthickness = 1",
        14,
        "tyre.layers[1].thicknes",
        "not a key of a layer",
        "known keys: name",
    );
    refused("[contact]", "[contakt]", 22, "contakt", "not a key of a scene", "did you mean `contact`?");
    refused("plots = true", "plot = true", 27, "outputs.plot", "not a key of [outputs]", "did you mean `plots`?");
    refused(
        "speed_kmh = 80",
        "speed_kmh = 80\nelements = 3",
        20,
        "rolling.elements",
        "not a key of [rolling]",
        "duration, warm_up, start, axle",
    );
    for (key, right) in [("preset = \"draft\"", "`numerics.preset`"), ("zone = \"cells\"", "`contact.zone`")] {
        let name = format!("rolling.{}", &key[..key.find(' ').unwrap()]);
        let right = format!("did you mean {right}? known keys: speed_kmh");
        refused("speed_kmh = 80", &format!("speed_kmh = 80\n{key}"), 20, &name, "not a key of [rolling]", &right);
    }
    refused("normal = 1.8e6", "normal = 1.8e6, \"b.ad\" = 1", 6, "tyre.foundation.\"b.ad\"", "not a key", "tangential");
    road_refused("kind = \"smooth\"\nseed = 1", 18, "road.seed", "not a key of a smooth road", "known keys: kind");
}

#[test]
fn a_title_stands_in_one_line_and_drives_no_terminal() {
    for (sign, code) in [("\\u001b", "U+001B"), ("\\n", "U+000A"), ("\\u009b", "U+009B"), ("\\ufffe", "U+FFFE")] {
        let title = format!("title = \"a{sign}b\"");
        refused("title = \"base\"", &title, 1, "title", code, "in one line and without control characters");
    }
}

#[test]
fn a_misspelt_key_is_named_with_the_one_it_leaves_missing() {
    let found = complaints(&edited("thickness = 0.013", "thicknes = 0.013"));
    let keys: Vec<_> = found.iter().map(|complaint| (complaint.line, complaint.key.as_str())).collect();
    assert_eq!(keys, [(12, "tyre.layers[1].thickness"), (14, "tyre.layers[1].thicknes")]);
    assert_eq!(found[1].right, "did you mean `thickness`?");
}

#[test]
fn missing_keys() {
    refused("width = 0.2\n", "", 2, "tyre.width", "missing", "add it: a number above 0 m");
    refused("name = \"belt\"\n", "", 7, "tyre.layers[0].name", "missing", "a text");
    refused("tangential = 1e6, ", "", 6, "tyre.foundation.tangential", "missing", "a number of at least 0 N/m^3");
    refused("duration = 1.5\n", "", 18, "rolling.duration", "missing", "above 0 s");
    refused("axle = { load = 3400 }\n", "", 18, "rolling.axle", "missing", "{ load = ... } in N, or { indentation");
    road_refused("", 16, "road.kind", "missing", "\"smooth\", \"made\", \"profile\", \"opencrg\", \"grid\"");
    material_refused("loss_factor = 0.1", "tyre.layers[1].material.modulus", "missing", "above 0 Pa");
}

#[test]
fn missing_tables() {
    let found = complaints("title = \"nothing else\"\n");
    let keys: Vec<_> = found.iter().map(|complaint| (complaint.line, complaint.key.as_str())).collect();
    assert_eq!(keys, [(1, "tyre"), (1, "rolling")]);
    assert!(found[0].right.contains("the table [tyre]"));
    assert_eq!(complaints("").len(), 2, "an empty file");
}

#[test]
fn wrong_types() {
    refused("width = 0.2\n", "width = \"0.2\"\n", 4, "tyre.width", "the text \"0.2\"", "write a number above 0 m");
    refused("title = \"base\"", "title = 3", 1, "title", "the whole number 3", "a text");
    refused("elements = 512", "elements = 512.0", 25, "numerics.elements", "the number 512.0", "whole number");
    refused("elements = 512", "elements = 1e9", 25, "numerics.elements", "the number 1e9", "whole number");
    refused("plots = true", "plots = \"yes\"", 27, "outputs.plots", "the text \"yes\"", "true or false");
    refused("tension = [6e4, 2e4]", "tension = 6e4", 10, "tyre.layers[0].tension", "the number 6e4", "[a, b]");
    refused("tension = [6e4, 2e4]", "tension = [6e4]", 10, "tyre.layers[0].tension", "1 values", "2 values");
    refused("tension = [6e4, 2e4]", "tension = [6e4, true]", 10, "tyre.layers[0].tension[1]", "true", "a number");
    refused(
        "tread = \"elastic\"",
        "tread = 1",
        23,
        "contact.tread",
        "number 1",
        "\"elastic\", \"uncoupled\", \"bedding\"",
    );
    refused("[contact]\ntread = \"elastic\"", "[[contact]]", 22, "contact", "an array", "[contact]");
    refused("speed_kmh = 80", "speed_kmh = 1979-05-27", 19, "rolling.speed_kmh", "the time 1979-05-27", "km/h");
    axle_refused("3400", "rolling.axle", "the whole number 3400", "{ load = ... }");
    refused(
        &BASE[BASE.find("[road]").unwrap()..BASE.find("[rolling]").unwrap()],
        "[[road]]\n",
        16,
        "road",
        "an array",
        "[road]",
    );
}

#[test]
fn one_table_where_an_array_of_tables_belongs() {
    let belt = "[[tyre.layers]]\nname = \"belt\"\nthickness = 0.006\ntension = [6e4, 2e4]\n\
        material = { modulus = 5e8, loss_factor = 0.08, poisson = 0.3, density = 1300 }\n";
    let found = complaints(&replaced(BASE, &[(belt, ""), ("[[tyre.layers]]", "[tyre.layers]")]));
    assert_eq!((found.len(), found[0].line, found[0].key.as_str()), (1, 7, "tyre.layers"));
    assert!(found[0].right.contains("[[tyre.layers]]"));
}

#[test]
fn not_finite_and_too_large() {
    refused("width = 0.2\n", "width = nan\n", 4, "tyre.width", "NaN is not a finite number", "above 0 m");
    refused("duration = 1.5", "duration = inf", 20, "rolling.duration", "inf is not a finite", "above 0 s");
    refused("duration = 1.5", "duration = -inf", 20, "rolling.duration", "-inf is not a finite", "above 0 s");
    refused("duration = 1.5", "duration = 1e999", 20, "rolling.duration", "1e999 is too large", "fits");
    refused("duration = 1.5", "duration = 1.5\nstart = nan", 21, "rolling.start", "NaN is not", "a finite number m");
    refused(
        "elements = 512",
        "elements = 99999999999999999999",
        25,
        "numerics.elements",
        "too large",
        "at most 1000000",
    );
    axle_refused("{ load = nan }", "rolling.axle.load", "NaN", "above 0 N");
}

#[test]
fn syntax_errors() {
    refused("width = 0.2\n", "width = 0.2 m\n", 4, "tyre.width", "must be quoted", "texts in quotes");
    refused("width = 0.2\n", "width = = 0.2\n", 4, "tyre.width", "extra `=`", "key = value");
    refused("width = 0.2\n", "width = 0.2\nwidth = 0.3\n", 5, "tyre.width", "given twice", "once");
    refused("[contact]", "[rolling]", 22, "rolling", "given twice", "once");
    refused("[contact]", "[contact", 22, "", "unclosed table", "TOML");
    refused("title = \"base\"", "title = \"base", 1, "title", "invalid basic string", "TOML");
}

#[test]
fn a_long_file_that_is_no_scene_is_refused_shortly() {
    let found = complaints(&"0.125;-0.25\n".repeat(200_000));
    assert!((1..=16).contains(&found.len()), "{}", found.len());
    assert_eq!(found[0].line, 1);
}

#[test]
fn independent_mistakes_are_reported_in_the_order_of_the_file() {
    let changes = [
        ("width = 0.2\n", "width = -0.2\n"),
        ("thickness = 0.013", "thickness = 0"),
        ("poisson = 0.3,", "poisson = 0.5,"),
        ("speed_kmh = 80", "speed_kmh = nan"),
        ("elements = 512", "elements = 513\nsubstep = 2"),
        ("kind = \"smooth\"", "kind = \"made\"\nlevels = [1, \"a\", nan]"),
    ];
    let found = complaints(&replaced(BASE, &changes));
    let places: Vec<_> = found.iter().map(|complaint| (complaint.line, complaint.key.as_str())).collect();
    let expected = [
        (4, "tyre.width"),
        (11, "tyre.layers[0].material.poisson"),
        (14, "tyre.layers[1].thickness"),
        (18, "road.levels[1]"),
        (18, "road.levels[2]"),
        (20, "rolling.speed_kmh"),
        (26, "numerics.elements"),
        (27, "numerics.substep"),
    ];
    assert_eq!(places, expected);
}
