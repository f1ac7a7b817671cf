//! The reference command against independent values.

use num_complex::Complex64;
use serde_json::{Value, json};

use crate::radiation::cases::evaluate;
use crate::test_models;

const MEMORY: u64 = 1 << 30;

fn reference(file: &str) -> Value {
    let text = std::fs::read_to_string(test_models::reference(&format!("radiation/{file}"))).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn complex(values: &Value) -> Vec<Complex64> {
    let number = |value: &Value| value.as_f64().unwrap();
    values.as_array().unwrap().iter().map(|pair| Complex64::new(number(&pair[0]), number(&pair[1]))).collect()
}

/// Largest difference over the largest exact value.
fn error(found: &[Complex64], exact: &[Complex64]) -> f64 {
    assert_eq!(found.len(), exact.len());
    let largest = exact.iter().map(|value| value.norm()).fold(0.0, f64::max);
    found.iter().zip(exact).map(|(a, b)| (a - b).norm() / largest).fold(0.0, f64::max)
}

/// Checks the spheres over the plane at the wavenumbers for which `wanted` holds: pulsating, heaving, swaying, at
/// receivers and on the surface, their power, G_N on the surface for two sources.
fn spheres_over_the_plane(nodes_per_wavelength: f64, bound: f64, wanted: impl Fn(f64, f64) -> bool) {
    let reference = reference("sphere_plane.json");
    for entry in reference["plane"].as_array().unwrap() {
        let (height, k) = (entry["h"].as_f64().unwrap(), entry["k"].as_f64().unwrap());
        if !wanted(height, k) {
            continue;
        }
        let receivers = entry["receivers"].as_array().unwrap();
        let surface: Vec<Value> = (entry["surface_alpha_from_south_phi_deg"].as_array().unwrap().iter())
            .map(|angles| {
                let [alpha, phi] = [0, 1].map(|index| angles[index].as_f64().unwrap().to_radians());
                json!([alpha.sin() * phi.cos(), alpha.sin() * phi.sin(), height - alpha.cos()])
            })
            .collect();
        let motions = [("uniform", "pulsating"), ("heave", "heave"), ("sway", "sway_x")];
        let case = |rest: Value| {
            let body = json!({ "shape": "sphere", "radius": 1.0, "height": height });
            let mut case = json!({ "name": "sphere", "body": body, "plane": true, "wavenumber": k });
            case.as_object_mut().unwrap().extend(rest.as_object().unwrap().clone());
            case
        };
        let points: Vec<Value> = receivers.iter().chain(&surface).cloned().collect();
        let mut cases: Vec<Value> =
            motions.iter().map(|(motion, _)| case(json!({ "velocity": motion, "receivers": points }))).collect();
        let sources = [0, 3];
        cases.extend(sources.map(|source| case(json!({ "source": receivers[source], "points": surface }))));
        let file = json!({ "density": 1.0, "sound_speed": 1.0, "nodes_per_wavelength": nodes_per_wavelength,
            "cases": cases });
        let answer = evaluate(&file.to_string(), MEMORY, &|| false).unwrap();
        for (index, (motion, name)) in motions.iter().enumerate() {
            let found = complex(&answer["cases"][index]["pressure"]);
            let exact = &entry[name];
            let (air, body) = found.split_at(receivers.len());
            let errors = [error(air, &complex(&exact["p_receivers"])), error(body, &complex(&exact["p_surface"]))];
            let power = answer["cases"][index]["power"].as_f64().unwrap() / exact["power"].as_f64().unwrap() - 1.0;
            assert!(errors.iter().all(|&error| error < bound), "{motion}, h {height}, k {k}: {errors:?}");
            assert!(power.abs() < bound, "{motion}, h {height}, k {k}: power {power}");
        }
        for (index, source) in sources.iter().enumerate() {
            let found = complex(&answer["cases"][motions.len() + index]["green"]);
            let exact = complex(&entry["green"][format!("source_receiver_{source}")]["G_surface"]);
            let error = error(&found, &exact);
            assert!(error < bound, "source {source}, h {height}, k {k}: {error}");
        }
    }
}

#[test]
fn spheres_over_the_plane_to_3e_minus_4() {
    spheres_over_the_plane(12.0, 3e-4, |height, k| (k < 0.9 || (k > 3.0 && k < 3.2)) && height < 1.2);
}

#[test]
#[ignore = "a minute"]
fn spheres_over_the_plane_to_3e_minus_4_at_every_wavenumber() {
    spheres_over_the_plane(12.0, 3e-4, |_, _| true);
}

/// Checks a tyre's body in the free field: all reference cases up to a frequency.
fn tyre_body(highest: f64, orders: &[u32], nodes_per_wavelength: f64) {
    let reference = reference("tyre_body_free_field.json");
    for entry in reference["cases"].as_array().unwrap() {
        if entry["f"].as_f64().unwrap() > highest {
            continue;
        }
        // The reference's axis is z, this one's y.
        let mut receivers: Vec<Value> = (entry["receivers"].as_array().unwrap().iter())
            .map(|point| json!([point[0], point[2], -point[1].as_f64().unwrap()]))
            .collect();
        receivers.push(json!([0.31, 0.0, 0.0]));
        let body = json!({ "shape": "tyre", "radius": 0.31, "width": 0.2, "shoulder": 0.02 });
        let cases: Vec<Value> = (orders.iter())
            .map(|order| {
                json!({ "name": format!("order {order}"), "body": body, "plane": false, "wavenumber": entry["k"],
                    "velocity": { "circumferential": order, "across": 1 }, "receivers": receivers })
            })
            .collect();
        // For rho c = 1.
        let file = json!({ "density": 1.0, "sound_speed": 1.0, "nodes_per_wavelength": nodes_per_wavelength,
            "cases": cases });
        let answer = evaluate(&file.to_string(), MEMORY, &|| false).unwrap();
        for (order, found) in orders.iter().zip(answer["cases"].as_array().unwrap()) {
            let exact = &entry["modes"][format!("m={order}")];
            let pressure = complex(&found["pressure"]);
            let (air, surface) = pressure.split_at(receivers.len() - 1);
            let far = error(air, &complex(&exact["p_over_rho_c_receivers"]));
            let near = error(surface, &complex(&json!([exact["p_surface_tread_centre_phi0"]])));
            let power = found["power"].as_f64().unwrap() / exact["power_over_rho_c"].as_f64().unwrap() - 1.0;
            assert!(far < 1e-3 && near < 2e-3, "order {order} at {}: {far} {near}", entry["f"]);
            // The highest order radiates 1e-11 of a plane wave of the same velocity: below the error of any quadrature.
            if exact["power_over_rho_c"].as_f64().unwrap() > 1e-9 {
                assert!(power.abs() < 1e-3, "order {order} at {}: power {power}", entry["f"]);
            }
        }
    }
}

#[test]
fn tyre_body_in_free_field_to_1e_minus_3() {
    tyre_body(600.0, &[0, 5], 8.0);
}

#[test]
#[ignore = "half a minute"]
fn tyre_body_in_free_field_to_1e_minus_3_in_every_case() {
    tyre_body(3000.0, &[0, 2, 5, 10], 10.0);
}

/// Error message for a file with one case, made from a valid one by a change.
fn refused(change: impl Fn(&mut Value)) -> String {
    let mut case = json!({ "name": "one", "body": { "shape": "tyre", "radius": 0.3, "width": 0.2, "shoulder": 0.02,
        "height": 0.29 }, "plane": true, "wavenumber": 3.0, "source": [0.0, 2.0, 1.0], "points": [[0.0, 0.0, 0.59]] });
    change(&mut case);
    let file = json!({ "density": 1.2, "sound_speed": 343.0, "nodes_per_wavelength": 6.0, "cases": [case] });
    evaluate(&file.to_string(), MEMORY, &|| false).unwrap_err().to_string()
}

#[test]
fn mistakes_are_answered_by_case_and_reason() {
    let cases: [(&str, Value, &str); 15] = [
        ("/body/radius", json!(-1.0), "radius is -1"),
        ("/body/shoulder", json!(0.15), "shoulder of 0.15"),
        ("/body/shoulder", json!(1e-17), "0 or at least 3e-5 m"),
        ("/body/shoulder", json!(1e-300), "0 or at least"),
        ("/body/width", json!(1e300), "width is 1e300 m: from 0.001 to 100 m"),
        ("/body/width", json!(1e-300), "from 0.001 to 100 m"),
        ("/body/radius", json!(1e200), "from 0.001 to 100 m"),
        ("/wavenumber", json!(1e300), "bytes"),
        ("/body/height", json!(0.3), "cut by the road or clear of it"),
        ("/body/height", json!(-0.1), "above the road"),
        ("/wavenumber", json!(0.0), "wavenumber is 0"),
        ("/wavenumber", json!(1e6), "bytes"),
        ("/source", json!([0.0, 0.0, 0.3]), "inside the body"),
        ("/source", json!([0.0, 3.0, -0.1]), "below the road"),
        ("/points", json!([[0.0, 0.0, 0.7]]), "not on the body's surface"),
    ];
    for (place, value, expected) in cases {
        let message = refused(|case| *case.pointer_mut(place).unwrap() = value.clone());
        assert!(message.contains("case 0 'one'") && message.contains(expected), "{place}: {message}");
    }
    let message = refused(|case| *case.pointer_mut("/body").unwrap() = json!({ "shape": "cube" }));
    assert!(message.contains("cube"), "{message}");
    let message = refused(|case| {
        case.as_object_mut().unwrap().remove("points");
    });
    assert!(message.contains("either velocity and receivers"), "{message}");
}

#[test]
fn a_field_that_is_no_number_is_refused() {
    let message = refused(|case| {
        let case = case.as_object_mut().unwrap();
        case.retain(|key, _| !["source", "points"].contains(&key.as_str()));
        case.insert("velocity".to_owned(), json!("uniform"));
        case.insert("receivers".to_owned(), json!([[-1e308, 2.0, 1.0]]));
    });
    assert!(message.contains("case 0 'one'") && message.contains("not finite"), "{message}");
}
