//! The references: finite elements of the section.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::belt::Resolution;
use super::reference_models::{belt, complex, document, number, parity};
use crate::tyre::layers::cases::evaluate;

/// Errors of one case: of C over sqrt(C_ii C_jj), and of the strip.
struct CaseErrors {
    label: String,
    n: i64,
    waves: f64,
    strip: Option<f64>,
}

fn errors(resolution: Resolution) -> Vec<CaseErrors> {
    let document = document();
    let belts: BTreeMap<&String, _> =
        document["tyres"].as_object().unwrap().iter().map(|(name, tyre)| (name, belt(tyre, resolution))).collect();
    let case = |case: &Value| {
        let name = case["tyre"].as_str().unwrap();
        let (belt, tyre) = (&belts[&name.to_owned()], &document["tyres"][name]);
        let (n, s) = (case["n"].as_i64().unwrap(), complex(&case["s"]));
        let correction = belt.section(n, parity(&case["parity"])).at(s);
        let waves: Vec<usize> =
            case["waves"].as_array().unwrap().iter().map(|m| m.as_u64().unwrap() as usize).collect();
        let wanted = |i: usize, j: usize| complex(&case["C_waves"][i][j]);
        let mut largest = 0.0_f64;
        for (i, &m) in waves.iter().enumerate() {
            for (j, &other) in waves.iter().enumerate() {
                let found = correction.compliance(m, other).unwrap();
                let size = (wanted(i, i).norm() * wanted(j, j).norm()).sqrt();
                largest = largest.max((found - wanted(i, j)).norm() / size);
            }
        }
        let strip = case.get("H_strip").map(|wanted| {
            let wanted = complex(wanted);
            (belt.strip(n, s, number(&tyre["bc"])) - wanted).norm() / wanted.norm()
        });
        let label = format!("{name}, n = {n}, s = {s}, {}", case["parity"]);
        CaseErrors { label, n, waves: largest, strip }
    };
    document["cases"].as_array().unwrap().iter().map(case).collect()
}

/// Bounds of waves and strip at n = 0 and elsewhere.
fn check(resolution: Resolution, bounds: [[f64; 2]; 2]) {
    let found = errors(resolution);
    assert_eq!(found.len(), 28);
    let mut worst = [[0.0_f64; 2]; 2];
    for CaseErrors { label, n, waves, strip } in &found {
        println!("{label}: waves {waves:.1e}, strip {:.1e}", strip.unwrap_or(0.0));
        let worst = &mut worst[usize::from(*n != 0)];
        *worst = [worst[0].max(*waves), worst[1].max(strip.unwrap_or(0.0))];
    }
    println!("worst of waves and strip, n = 0: {:?}, elsewhere: {:?}", worst[0], worst[1]);
    for (worst, bounds) in worst.iter().zip(bounds) {
        assert!(worst.iter().zip(bounds).all(|(&worst, bound)| worst < bound), "{worst:?} over {bounds:?}");
    }
}

#[test]
fn waves_and_strips_are_the_references() {
    check(Resolution::RUN, [[3e-3, 1e-3], [3e-3, 2e-3]]);
}

#[test]
fn a_finer_section_is_closer_to_the_references() {
    check(Resolution::FINE, [[1e-3, 2e-4], [1e-3, 5e-4]]);
}

/// A tyre of the references as the entry of a file of cases.
fn entry(name: &str, tyre: &Value) -> Value {
    let layer = |(index, layer): (usize, &Value)| {
        let thickness = number(&layer["h"]);
        let [along, across] = ["S_theta", "S_y"].map(|key| number(&tyre["used"][key][index]) * thickness);
        json!({
            "thickness": thickness, "modulus": layer["E"], "loss_factor": layer["eta"], "poisson": layer["nu"],
            "density": layer["rho"], "cords": layer["cords"], "tension": [along, across],
        })
    };
    let layers: Vec<Value> = tyre["layers"].as_array().unwrap().iter().enumerate().map(layer).collect();
    let radius = number(&tyre["R"]);
    let mut entry = json!({
        "name": name, "curved": true, "sides": "free", "circumference": std::f64::consts::TAU * radius,
        "width": tyre["B"], "contact_width": tyre["bc"], "edge_zone": tyre["be"], "pressure": tyre["p"],
        "layers": layers, "speed": number(&tyre["Om"]) * radius, "centrifugal_tension": "given",
    });
    if tyre["sidewalls"] == true {
        let (side, air) = (&tyre["side"], &tyre["cav"]);
        entry["sidewall"] = json!({
            "radius": side["r"], "angle": side["phi"], "mass": side["m"], "shear": side["G"],
            "loss_factor": side["eta"],
        });
        entry["cavity"] = json!({
            "radius": air["radius"], "depth": air["depth"], "density": air["rho"], "sound_speed": air["c"],
            "relaxation": air["tau"],
        });
    }
    entry
}

/// The references as a file of cases, without their answers.
fn file() -> Value {
    let document = document();
    let tyres: Vec<Value> =
        document["tyres"].as_object().unwrap().iter().map(|(name, tyre)| entry(name, tyre)).collect();
    let cases = document["cases"].as_array().unwrap().iter();
    let asked = ["tyre", "n", "s", "parity", "waves"];
    let case = |case: &Value| asked.map(|key| (key, case[key].clone())).into_iter().collect::<Value>();
    json!({ "tyres": tyres, "cases": cases.map(case).collect::<Vec<_>>() })
}

#[test]
fn a_file_of_cases_gets_the_references() {
    let answers = evaluate(&file().to_string()).unwrap();
    let document = document();
    let cases = document["cases"].as_array().unwrap();
    for (found, wanted) in answers["cases"].as_array().unwrap().iter().zip(cases) {
        let matrix = |case: &Value, i: usize, j: usize| complex(&case["C_waves"][i][j]);
        for i in 0..wanted["waves"].as_array().unwrap().len() {
            let error = (matrix(found, i, i) - matrix(wanted, i, i)).norm() / matrix(wanted, i, i).norm();
            assert!(error < 1e-3, "{}, wave {i}: {error:.1e}", wanted["tyre"]);
        }
        assert_eq!(found.get("H_strip").is_some(), wanted.get("H_strip").is_some());
        if let Some(strip) = wanted.get("H_strip") {
            let error = (complex(&found["H_strip"]) - complex(strip)).norm() / complex(strip).norm();
            assert!(error < 5e-4, "{}: {error:.1e}", wanted["tyre"]);
        }
    }
}

#[test]
fn waves_beyond_the_edges_reach_are_guided_ones() {
    let mut file = file();
    let cases = file["cases"].as_array_mut().unwrap();
    cases.truncate(1);
    cases[0]["waves"] = json!([46, 48, 50, 52]);
    let answers = evaluate(&file.to_string()).unwrap();
    let at = |i: usize, j: usize| complex(&answers["cases"][0]["C_waves"][i][j]);
    for i in 0..3 {
        // The corrected waves up to m = 48 and the others go on into each other.
        let ratio = at(i + 1, i + 1).norm() / at(i, i).norm();
        assert!(ratio > 0.9 && ratio < 1.0, "{i}: {ratio}");
    }
    // The edge of the tread itself couples short waves, too, in proportion to 1/m: the error of leaving them.
    let coupling = at(0, 1).norm() / at(0, 0).norm();
    assert!(coupling > 1e-3 && coupling < 1e-2, "{coupling:e}");
    assert!(at(1, 2).norm() == 0.0 && at(2, 3).norm() == 0.0);
}

#[test]
fn cases_of_free_edges_that_make_no_sense_are_refused() {
    type Change = fn(&mut Value);
    let changes: [(Change, &str); 12] = [
        (|file| file["tyres"][0]["sides"] = json!("guided"), "unknown variant"),
        (|file| file["tyres"][0]["contact_width"] = json!(0.2), "contact_width"),
        (|file| file["tyres"][0]["edge_zone"] = json!(0.07), "zone"),
        (|file| file["tyres"][0]["sidewall"]["angle"] = json!(3.5), "angle"),
        (|file| file["tyres"][0]["sidewall"]["shear"] = json!(-1.0), "shear"),
        (|file| file["tyres"][0]["sidewall_mass"] = json!(1.0), "sidewall_mass"),
        (|file| file["tyres"][0]["sidewall"] = Value::Null, "need sidewalls"),
        (|file| file["tyres"][0]["layers"][2]["thickness"] = json!(1e-7), "too thin"),
        (
            |file| {
                file["tyres"][0]["speed"] = json!(30.0);
                file["tyres"][0].as_object_mut().unwrap().remove("centrifugal_tension");
            },
            "centrifugal_tension",
        ),
        (|file| file["cases"][0]["waves"] = json!([0, 1]), "even lateral numbers"),
        (|file| file["cases"][0]["n"] = json!(100_000_000), "too short"),
        (|file| file["cases"][0]["parity"] = Value::Null, "n, parity and waves"),
    ];
    let tyre = document()["tyres"]["default"].clone();
    let file = json!({
        "tyres": [entry("default", &tyre)],
        "cases": [{ "tyre": "default", "n": 2, "s": [0.0, 600.0], "parity": "even", "waves": [0, 2] }],
    });
    evaluate(&file.to_string()).unwrap();
    for (change, message) in changes {
        let mut changed = file.clone();
        change(&mut changed);
        let error = evaluate(&changed.to_string()).unwrap_err().to_string();
        assert!(error.contains(message), "{error} has no {message}");
    }
}
