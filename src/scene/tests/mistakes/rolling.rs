//! Mistakes in rolling, contact and numerics.

use super::super::super::{Axle, Vibration};
use super::super::{complaints, edited};
use super::{accepted, axle_refused, refused};
use crate::test_models::replaced;

#[test]
fn rolling() {
    refused("speed_kmh = 80", "speed_kmh = 0", 19, "rolling.speed_kmh", "0 is out of range", "above 0 km/h");
    refused("speed_kmh = 80", "speed_kmh = -80", 19, "rolling.speed_kmh", "-80", "above 0 km/h");
    refused("duration = 1.5", "duration = 0.0", 20, "rolling.duration", "0 is out of range", "above 0 s");
    refused("duration = 1.5", "duration = 1.5\nwarm_up = -0.1", 21, "rolling.warm_up", "-0.1", "at least 0 s");
    accepted("duration = 1.5", "duration = 1.5\nwarm_up = 0\nstart = -3");
}

#[test]
fn axles() {
    axle_refused("{ lod = 3 }", "rolling.axle.lod", "not a key of the axle", "did you mean `load`?");
    axle_refused("{ weight = 3 }", "rolling.axle.weight", "not a key of the axle", "known keys: load, indentation");
    axle_refused(
        "{ load = 3, indentation = 0.01 }",
        "rolling.axle.indentation",
        "this and `load` exclude each other",
        "either this or `load`",
    );
    axle_refused("{}", "rolling.axle", "empty", "{ load = ... } in N, or { indentation");
    axle_refused("{ ramp = 1 }", "rolling.axle", "empty", "{ load = ... }");
    axle_refused("{ load = -3400 }", "rolling.axle.load", "-3400", "above 0 N");
    axle_refused("{ load = \"3400 N\" }", "rolling.axle.load", "the text \"3400 N\"", "above 0 N");
    axle_refused(
        "{ load = 3400, ramp = 0.1 }",
        "rolling.axle.ramp",
        "does not apply with a load",
        "give an indentation",
    );
    axle_refused(
        "{ load = 3400, tolerance = 1 }",
        "rolling.axle.tolerance",
        "1 is out of range",
        "above 0 and below 1",
    );
    axle_refused("{ indentation = -0.01 }", "rolling.axle.indentation", "-0.01", "at least 0 m");
    axle_refused(
        "{ indentation = 0.25 }",
        "rolling.axle.indentation",
        "0.25 m is implausible: from 0 to 0.093 m",
        "allow_implausible = true",
    );
    accepted("axle = { load = 3400 }", "axle = { indentation = 0.09 }");
    axle_refused(
        "{ indentation = 0.32 }",
        "rolling.axle.indentation",
        "is more than the tyre's radius",
        "at most 0.31",
    );
    axle_refused("{ indentation = 0.01, ramp = -1 }", "rolling.axle.ramp", "-1", "at least 0 s");
    axle_refused("{ indentation = 0.01, tolerance = 0.1 }", "rolling.axle.tolerance", "an indentation", "give a load");
    accepted("axle = { load = 3400 }", "axle = { indentation = 0 }");
}

#[test]
fn axles_with_a_mass() {
    axle_refused("{ mass = 40 }", "rolling.axle.load", "missing", "above 0 N");
    axle_refused("{ load = 3400, mass = 0 }", "rolling.axle.mass", "0 is out of range", "above 0 kg");
    axle_refused("{ load = 3400, mass = -1 }", "rolling.axle.mass", "-1", "above 0 kg");
    axle_refused("{ load = 3400, mass = 40, stiffness = -1 }", "rolling.axle.stiffness", "-1", "at least 0 N/m");
    axle_refused("{ load = 3400, mass = 40, damping = -1 }", "rolling.axle.damping", "-1", "at least 0 N s/m");
    axle_refused("{ load = 3400, stiffness = 1e4 }", "rolling.axle.stiffness", "without a mass", "give its mass");
    axle_refused("{ load = 3400, damping = 1e3 }", "rolling.axle.damping", "without a mass", "give its mass");
    axle_refused("{ load = 3400, mass = 40, ramp = 1 }", "rolling.axle.ramp", "does not apply with a load", "remove");
    axle_refused("{ load = 3400, mas = 40 }", "rolling.axle.mas", "not a key of the axle", "did you mean `mass`?");
    axle_refused("{ indentation = 0.01, mass = 40 }", "rolling.axle.mass", "an indentation", "give a load");
    axle_refused("{ indentation = 0.01, damping = 4 }", "rolling.axle.damping", "an indentation", "give a load");
    let scene = accepted("axle = { load = 3400 }", "axle = { load = 3400, mass = 40 }");
    let expected =
        Axle::Mass { load: 3400.0, mass: 40.0, stiffness: 0.0, damping: 0.0, tolerance: Axle::LOAD_TOLERANCE };
    assert_eq!(scene.rolling.axle, expected);
}

#[test]
fn contact_laws() {
    refused(
        "tread = \"elastic\"",
        "tread = \"Elastic\"",
        23,
        "contact.tread",
        "\"Elastic\" is not known",
        "did you mean \"elastic\"?",
    );
    refused(
        "tread = \"elastic\"",
        "slices = \"half-plane\"",
        23,
        "contact.slices",
        "\"half-plane\"",
        "accepted: \"winkler\", \"half-space\"",
    );
    refused(
        "tread = \"elastic\"",
        "slices = \"none\"",
        23,
        "contact.slices",
        "\"none\" is no longer a choice",
        "cells_across = 1 and cells_along = 1",
    );
    refused("tread = \"elastic\"", "cells_across = 0", 23, "contact.cells_across", "0 is too small", "at least 1");
    refused(
        "tread = \"elastic\"",
        "bedding_stiffness = 1e7",
        23,
        "contact.bedding_stiffness",
        "tread = \"elastic\"",
        "tread = \"bedding\"",
    );
    refused(
        "tread = \"elastic\"",
        "tread = \"bedding\"\nbedding_stiffness = 0",
        24,
        "contact.bedding_stiffness",
        "0 is out",
        "above 0 N/m^3",
    );
    accepted("tread = \"elastic\"", "tread = \"bedding\"\nbedding_stiffness = 1e9");
    refused(
        "tread = \"elastic\"",
        "slice_coupling = \"explizit\"",
        23,
        "contact.slice_coupling",
        "\"explizit\"",
        "did you mean \"explicit\"?",
    );
    refused(
        "tread = \"elastic\"",
        "slice_coupling = \"implicit\"",
        23,
        "contact.slice_coupling",
        "\"implicit\" is no longer a choice",
        "\"explicit\", the paper's equation 4",
    );
    refused(
        "tread = \"elastic\"",
        "local_compliance = -1e-10",
        23,
        "contact.local_compliance",
        "-1e-10 is out",
        "above 0 m/Pa",
    );
    refused(
        "tread = \"elastic\"",
        "slice_coupling = \"explicit\"\nlocal_compliance = 5e-10",
        24,
        "contact.local_compliance",
        "whose compliance is G0_ii",
        "slice_coupling = \"local\"",
    );
    accepted("tread = \"elastic\"", "slice_coupling = \"local\"\nlocal_compliance = 5e-10");
    for (tread, right) in [("elastic", "are scaled to this one"), ("bedding", "unless bedding_stiffness")] {
        refused(
            "tread = \"elastic\"",
            &format!("tread = \"{tread}\"\nequal_stiffness = true"),
            24,
            "contact.equal_stiffness",
            &format!("tread = \"{tread}\""),
            right,
        );
    }
    accepted("tread = \"elastic\"", "tread = \"uncoupled\"\nequal_stiffness = true");
    accepted("tread = \"elastic\"", "tread = \"bedding\"\nslice_coupling = \"explicit\"");
}

#[test]
fn numerics() {
    refused("elements = 512", "elements = 511", 25, "numerics.elements", "511 is odd", "such as 510");
    refused("elements = 512", "elements = 14", 25, "numerics.elements", "14 is too small", "at least 16");
    refused("elements = 512", "elements = -512", 25, "numerics.elements", "-512 is too small", "at least 16");
    refused("elements = 512", "substeps = 0", 25, "numerics.substeps", "0 is too small", "at least 1");
    let key = "numerics.elements_per_step";
    let both = "substeps = 2\nelements_per_step = 4";
    refused("elements = 512", both, 26, key, "a part of one", "either this or `substeps`");
    let odd = "elements = 512\nelements_per_step = 3";
    refused("elements = 512", odd, 26, key, "no multiple of twice 3", "1, or elements = 516");
    refused(
        "elements = 512",
        "time_rule = \"bdf3\"",
        25,
        "numerics.time_rule",
        "\"bdf3\"",
        "\"bdf1\", \"bdf2\", \"sdirk2\", \"sdirk3\"",
    );
    for (rule, instead) in [("trapezoidal", "ring"), ("first-order-hold", "grows")] {
        let written = format!("time_rule = \"{rule}\"");
        let place = "numerics.time_rule";
        refused("elements = 512", &written, 25, place, "is no longer a choice", "\"sdirk2\", of the same order");
        refused("elements = 512", &written, 25, place, rule, instead);
    }
    refused("elements = 512", "fmax = 0", 25, "numerics.fmax", "0 is out", "above 0 Hz");
    refused("elements = 512", "memory = 0", 25, "numerics.memory", "0 is out", "above 0 s");
    refused("elements = 512", "memory_limit = -1", 25, "numerics.memory_limit", "-1", "above 0 GB");
    refused(
        "elements = 512",
        "influence_tolerance = 0",
        25,
        "numerics.influence_tolerance",
        "0 is out",
        "of at least 1e-14 and at most 0.1",
    );
    refused("elements = 512", "influence_tolerance = 1", 25, "numerics.influence_tolerance", "1 is out", "at most 0.1");
    refused("elements = 512", "contact_tolerance = 1e-20", 25, "numerics.contact_tolerance", "1e-20", "at least 1e-15");
    refused("elements = 512", "lateral_terms = 0", 25, "numerics.lateral_terms", "0 is too small", "at least 1");
    refused("elements = 512", "wavenumber_aliases = -1", 25, "numerics.wavenumber_aliases", "-1", "at least 0");
    for more in ["1000002", "100_000_000", "1_000_000_000_000_000_000", "4_600_000_000_000_000_000"] {
        refused("elements = 512", &format!("elements = {more}"), 25, "numerics.elements", "too large", "most 1000000");
    }
    refused("elements = 512", "cached_factors = 0", 25, "numerics.cached_factors", "0 is too small", "at least 1");
    // Whether so many fit into memory is checked by the plan.
    assert_eq!(accepted("elements = 512", "elements = 1_000_000").numerics.elements, 1_000_000);
    assert_eq!(accepted("elements = 512", "wavenumber_aliases = 0").numerics.wavenumber_aliases, Some(0));
}

#[test]
fn vibration() {
    let vibration = |keys: &str| format!("plots = true\n[outputs.vibration]\n{keys}");
    let wrong = |keys: &str, line: usize, key: &str, wrong: &str, right: &str| {
        refused("plots = true", &vibration(keys), line, key, wrong, right);
    };
    wrong("points = [0.1, -0.98]", 29, "outputs.vibration.points[1]", "outside the tyre", "from -0.975 to 0.975 m");
    wrong("points = []", 29, "outputs.vibration.points", "empty", "an array");
    wrong(
        "frames = \"material\"\npoints = [0.1]",
        30,
        "outputs.vibration.points",
        "does not apply with frames = \"material\"",
        "frames = \"both\"",
    );
    wrong("elements = [3, -1]", 29, "outputs.vibration.elements[1]", "-1 is too small", "at least 0");
    wrong("elements = [0.5]", 29, "outputs.vibration.elements[0]", "", "a whole number of at least 0");
    wrong("elements = []", 29, "outputs.vibration.elements", "empty", "a whole number");
    wrong(
        "frames = \"non-rotating\"\nelements = [0]",
        30,
        "outputs.vibration.elements",
        "does not apply with frames = \"non-rotating\"",
        "frames = \"both\"",
    );
    wrong("frames = \"road\"", 29, "outputs.vibration.frames", "\"road\" is not known", "\"non-rotating\"");
    wrong("tread = false\nbelt = false", 28, "outputs.vibration", "neither tread, belt", "leave the table out");
    wrong("segment = 0", 29, "outputs.vibration.segment", "0 is out of range", "above 0 s");
    wrong("belts = true", 29, "outputs.vibration.belts", "not a key of [outputs.vibration]", "`belt`");
    let bedding = edited("tread = \"elastic\"", "tread = \"bedding\"");
    let text = replaced(&bedding, &[("plots = true", &vibration("tangential = true"))]);
    let found = complaints(&text);
    assert_eq!((found.len(), found[0].line, found[0].key.as_str()), (1, 29, "outputs.vibration.tangential"));
    assert!(found[0].wrong.contains("bedding"), "{}", found[0].wrong);
    let scene = accepted("plots = true", &vibration("tangential = true\npoints = [0.975, 0]\nelements = [511, 0]"));
    let (points, elements) = (vec![0.975, 0.0], vec![511, 0]);
    let expected = Vibration { tangential: true, points, elements, ..Vibration::default() };
    assert_eq!(scene.outputs.vibration, Some(expected));
    assert_eq!(accepted("plots = true", "plots = false").outputs.vibration, None, "nothing is computed unasked");
}
