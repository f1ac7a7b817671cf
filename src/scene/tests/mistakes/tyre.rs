//! Mistakes in the tyre.

use super::super::{BASE, complaints, edited};
use super::{Scene, accepted, material_refused, refused};

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
fn cords_and_orthotropic_layers() {
    let belt = |more: &str| format!("thickness = 0.006\n{more}\n");
    let refused = |more: &str, key: &str, wrong: &str, right: &str| {
        let found = complaints(&edited("thickness = 0.006\n", &belt(more)));
        let one = found.iter().find(|complaint| complaint.key == format!("tyre.layers[0].{key}"));
        let one = one.unwrap_or_else(|| panic!("{found:#?}"));
        assert!(one.wrong.contains(wrong) && one.right.contains(right), "{found:#?}");
    };
    refused("cords = [{ angle_deg = 20 }]", "cords[0].stiffness", "missing", "spacing, area and modulus");
    refused(
        "cords = [{ stiffness = 1e9, area = 1e-7, angle_deg = 20 }]",
        "cords[0].area",
        "given as well",
        "leave out",
    );
    refused("cords = [{ area = 1e-7, spacing = 1e-3, angle_deg = 20 }]", "cords[0].modulus", "missing", "positive");
    refused("cords = [{ stiffness = 1e9, angle_deg = 120 }]", "cords[0].angle_deg", "120", "at most 90 degrees");
    refused("cords = [{ stiffness = -1e9, angle_deg = 20 }]", "cords[0].stiffness", "out of range", "above 0 Pa");
    refused("cords = []", "cords", "empty", "stiffness");
    let losses: Vec<String> =
        (1..5).map(|loss| format!("{{ stiffness = 1e9, angle_deg = 0, loss_factor = 0.{loss} }}")).collect();
    refused(&format!("cords = [{}]", losses.join(", ")), "cords", "4 different", "at most 3");
    let moduli = |nu: f64, outwards: f64| {
        format!(
            "orthotropic = {{ E_theta = 1e9, E_y = 1e8, E_r = {outwards:e}, G_y_r = 1e7, G_theta_r = 1e7, \
             G_theta_y = 1e8, nu_theta_y = {nu}, nu_theta_r = 0.3, nu_y_r = 0.4 }}"
        )
    };
    refused(&moduli(0.5, 1e8), "material.modulus", "an orthotropic layer", "leave it out");
    refused(&moduli(4.0, 1e8), "orthotropic.nu_theta_y", "release energy", "between +-3.162");
    refused(&moduli(0.5, 1e9), "orthotropic.E_r", "compliance outwards", "below");
    // Valid layers, with the orthotropic moduli in place of those of the material.
    let belt_material = "modulus = 5e8, loss_factor = 0.08, poisson = 0.3, ";
    let text =
        edited("thickness = 0.006\n", &belt(&moduli(0.5, 1e8))).replacen(belt_material, "loss_factor = 0.08, ", 1);
    let scene = Scene::from_str(&text, "test.toml").unwrap_or_else(|error| panic!("{}\n{text}", error.render(false)));
    assert!((scene.scene.tyre.layers[0].material.modulus - 2e7).abs() < 1e-3);
    let again = toml::to_string(&scene.scene.tyre).unwrap();
    assert!(again.contains("E_theta") && !again.contains("modulus = 2e7"), "{again}");
    let cords = accepted("thickness = 0.006\n", &belt("cords = [{ stiffness = 1e9, angle_deg = -20 }]"));
    assert_eq!(cords.tyre.layers[0].cords.len(), 1);
    // The road must touch isotropic rubber.
    let tread = edited("thickness = 0.013\n", "thickness = 0.013\ncords = [{ stiffness = 1e9, angle_deg = 0 }]\n");
    let found = complaints(&tread);
    assert!(found.len() == 1 && found[0].key == "tyre.layers[1].cords", "{found:#?}");
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
        "does not apply with law = \"elastic\"",
        "law = \"power-law\"",
    );
    material_refused(
        "modulus = 1e6, weights = [1.0]",
        &key("weights"),
        "does not apply with law = \"power-law\"",
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
