//! Mistakes in the tyre.

use super::super::BASE;
use super::{accepted, material_refused, refused};

#[test]
fn sizes_of_the_tyre() {
    refused("circumference = 1.95", "circumference = 0", 3, "tyre.circumference", "0 is out of range", "above 0 m");
    refused("width = 0.2\n", "width = -0.2\n", 4, "tyre.width", "-0.2 is out of range", "above 0 m");
    refused(
        "contact_width = 0.12",
        "contact_width = 0.21",
        5,
        "tyre.contact_width",
        "0.21 m is more than the tyre's width, 0.2 m",
        "at most 0.2 m",
    );
    refused(
        "thickness = 0.013",
        "thickness = -0.013",
        14,
        "tyre.layers[1].thickness",
        "-0.013 is out of range",
        "write a number above 0 m",
    );
    refused(
        "tension = [6e4, 2e4]",
        "tension = [6e4, -1]",
        10,
        "tyre.layers[0].tension[1]",
        "-1 is out of range",
        "at least 0 N/m",
    );
    refused("normal = 1.8e6", "normal = -1", 6, "tyre.foundation.normal", "-1", "at least 0 N/m^3");
    refused(
        "loss_factor = 0.1 ",
        "loss_factor = 0.1, corner_frequency = 0",
        6,
        "tyre.foundation.corner_frequency",
        "0 is out",
        "above 0 Hz",
    );
    assert!((accepted("contact_width = 0.12", "contact_width = 0.2").tyre.contact_width - 0.2).abs() < 1e-15);
}

#[test]
fn no_layers() {
    let begin = BASE.find("[[tyre.layers]]").unwrap();
    let end = BASE.find("[road]").unwrap();
    refused(&BASE[begin..end], "", 2, "tyre.layers", "missing", "one table [[tyre.layers]]");
    refused(&BASE[begin..end], "layers = []\n", 7, "tyre.layers", "empty", "one table [[tyre.layers]]");
}

#[test]
fn poisson_at_and_past_its_limits() {
    for (poisson, shown) in [("0.5", "0.5"), ("0.7", "0.7"), ("-1.0", "-1"), ("-3", "-3")] {
        refused(
            "poisson = 0.49",
            &format!("poisson = {poisson}"),
            15,
            "tyre.layers[1].material.poisson",
            &format!("{shown} is out of range"),
            "a number above -1 and below 0.5",
        );
    }
    accepted("poisson = 0.49", "poisson = 0.49999999");
    accepted("poisson = 0.49", "poisson = -0.99");
}

#[test]
fn materials() {
    let key = |name: &str| format!("tyre.layers[1].material.{name}");
    material_refused(
        "law = \"elastik\", modulus = 1e6, weights = 3",
        &key("law"),
        "\"elastik\" is not known",
        "did you mean \"elastic\"? accepted: \"elastic\", \"power-law\", \"prony\", \"hysteretic\"",
    );
    material_refused(
        "law = \"rubber\", modulus = 1e6",
        &key("law"),
        "\"rubber\"",
        "accepted: \"elastic\", \"power-law\"",
    );
    material_refused(
        "law = \"elastic\", modulus = 1e6, loss_factor = 0.1",
        &key("loss_factor"),
        "means nothing with law = \"elastic\"",
        "law = \"power-law\"",
    );
    material_refused(
        "modulus = 1e6, weights = [1.0]",
        &key("weights"),
        "means nothing with law = \"power-law\"",
        "law = \"prony\"",
    );
    material_refused(
        "law = \"hysteretic\", modulus = 1e6, corner_frequency = 1",
        &key("corner_frequency"),
        "law = \"hysteretic\"",
        "law = \"power-law\"",
    );
    material_refused(
        "law = \"prony\", modulus = 1e6, weights = [1], times = [1], loss_factor = 0.1",
        &key("loss_factor"),
        "law = \"prony\"",
        "weights and times",
    );
    material_refused(
        "law = \"prony\", modulus = 1e6, weights = [1, 2], times = [1]",
        &key("times"),
        "this has 1 values, `weights` has 2",
        "as many values as in `weights`",
    );
    material_refused(
        "law = \"prony\", modulus = 1e6, weights = [1, 0], times = [1, 2]",
        &key("weights[1]"),
        "0 is out of range",
        "above 0",
    );
    material_refused(
        "law = \"prony\", modulus = 1e6, weights = [1, 2], times = [1, -2]",
        &key("times[1]"),
        "-2 is out of range",
        "above 0 s",
    );
    material_refused("law = \"prony\", modulus = 1e6, weights = [], times = [1]", &key("weights"), "empty", "an array");
    material_refused("law = \"prony\", modulus = 1e6, weights = [1]", &key("times"), "missing", "an array");
    material_refused("modulus = 0", &key("modulus"), "0 is out of range", "above 0 Pa");
    material_refused("modulus = 1e6, loss_factor = -0.1", &key("loss_factor"), "-0.1", "at least 0");
    material_refused("modulus = 1e6, reference_frequency = -1", &key("reference_frequency"), "-1", "above 0 Hz");
    refused("density = 1150", "density = 0", 15, &key("density"), "0 is out of range", "above 0 kg/m^3");
}
