//! Numbers that are possible but implausible.

use super::super::{complaints, edited};
use crate::scene::{DEFAULT, Scene, Setting};

#[test]
fn a_load_in_kilonewtons_is_asked_about() {
    let text = edited("load = 3400", "load = 3.4");
    let [complaint] = &complaints(&text)[..] else { panic!("{:?}", complaints(&text)) };
    assert_eq!((complaint.key.as_str(), complaint.line), ("rolling.axle.load", 21));
    assert_eq!(complaint.wrong, "3.4 N is implausible: from 10 to 1e7 N is plausible");
    assert!(complaint.right.contains("another unit?") && complaint.right.contains("allow_implausible = true"));
}

#[test]
fn implausible_values_are_asked_about_and_may_be_tried() {
    for (key, from, implausible, absurd) in [
        ("tyre.circumference", "circumference = 1.95", "circumference = 195.0", "circumference = 1.8e19"),
        ("tyre.layers[1].thickness", "thickness = 0.013", "thickness = 1e-5", "thickness = 1e-9"),
        ("tyre.layers[1].material.modulus", "modulus = 8e6", "modulus = 80.0", "modulus = 8e-3"),
        ("tyre.layers[1].material.density", "density = 1150", "density = 0.115", "density = 1e300"),
        ("rolling.speed_kmh", "speed_kmh = 80", "speed_kmh = 8e4", "speed_kmh = 8e8"),
        ("rolling.axle.load", "load = 3400", "load = 3.4", "load = 1e-9"),
    ] {
        let allowed = |text: &str| format!("allow_implausible = true\n{}", edited(from, text));
        for text in [edited(from, implausible), edited(from, absurd), allowed(absurd)] {
            let found = complaints(&text);
            assert!(
                found.iter().any(|complaint| complaint.key == key && complaint.wrong.contains("plausible")),
                "{text}"
            );
        }
        let loaded = Scene::from_str(&allowed(implausible), "trial").unwrap();
        assert!(loaded.scene.allow_implausible);
        assert!(loaded.scene.to_toml().unwrap().contains("allow_implausible = true"));
    }
    let toy = [("circumference = 1.95", "circumference = 0.06"), ("width = 0.2", "width = 0.02")];
    let toy = toy.iter().fold(super::super::BASE.to_owned(), |text, (from, to)| text.replacen(from, to, 1));
    let toy = toy.replace("contact_width = 0.12", "contact_width = 0.01").replace("load = 3400", "load = 0.5");
    Scene::from_str(&toy, "toy").unwrap();
}

#[test]
fn kilohertz_kilonewtons_and_millimetres_are_asked_about() {
    for setting in [
        "numerics={ preset = \"draft\", fmax = 1 }",
        "tyre.sidewall.shear=3",
        "road={ kind = \"made\", levels = [40.0, 40.0], wavelengths = [100.0, 80.0] }",
    ] {
        let reported = about(setting);
        assert!(reported.contains("implausible") && reported.contains("another unit?"), "{setting}: {reported}");
    }
}

/// Complaints about the default scene with a setting.
fn about(setting: &str) -> String {
    let setting = [Setting::parse(setting).unwrap()];
    Scene::from_str_with(DEFAULT, "default", &setting).map_or_else(|error| error.to_string(), |_| String::new())
}

#[test]
fn a_load_in_kilograms_is_asked_about() {
    let reported = about("rolling.axle={ load = 350.0 }");
    assert!(
        reported.contains("350 N is implausible: from 580 to 14000 N") && reported.contains("350 kg weigh 3434 N"),
        "{reported}"
    );
    // A tyre that is loaded ten times as much would stand on its rim.
    let reported = about("rolling.axle={ load = 34000.0 }");
    assert!(reported.contains("34000 N is implausible") && !reported.contains("kg weigh"), "{reported}");
    for load in [1000.0, 3400.0, 9000.0] {
        assert_eq!(about(&format!("rolling.axle={{ load = {load} }}")), "");
    }
}

#[test]
fn tyres_of_trucks_and_bicycles_and_flat_ones_bear_their_loads() {
    let of = |size: [f64; 3], pressure: f64, load: f64| {
        let [circumference, width, contact_width] = size;
        let tyre = [("circumference", circumference), ("width", width), ("contact_width", contact_width)];
        let tyre = tyre.map(|(key, value)| format!("tyre.{key}={value}"));
        let more = [format!("tyre.inflation.pressure={pressure}"), format!("rolling.axle={{ load = {load:?} }}")];
        let settings: Vec<Setting> = tyre.iter().chain(&more).map(|text| Setting::parse(text).unwrap()).collect();
        Scene::from_str_with(DEFAULT, "default", &settings).err().map(|error| error.to_string()).unwrap_or_default()
    };
    let (truck, bicycle, car) = ([3.2, 0.28, 0.24], [2.1, 0.148, 0.02], [1.95, 0.148, 0.109]);
    for (size, pressure, load, is_meant) in [
        (truck, 8.5e5, 5000.0, true),
        (truck, 8.5e5, 30000.0, true),
        (truck, 8.5e5, 3000.0, false),
        (bicycle, 6e5, 300.0, true),
        (bicycle, 6e5, 40.0, false),
        (car, 0.5e5, 3400.0, true),
        (car, 0.5e5, 34000.0, false),
    ] {
        let reported = of(size, pressure, load);
        let asked = reported.lines().any(|line| line.contains("rolling.axle.load") && line.contains("implausible"));
        assert_eq!(asked, !is_meant, "{load} N: {reported}");
    }
}

#[test]
fn grooves_that_cross_too_often_are_refused() {
    let lateral = |n: i32| {
        let angle = if n % 2 == 0 { 80 } else { -80 };
        format!("{{ from = -0.05, to = 0.05, width = 0.0003, depth = 0.006, angle = {angle}, offset = 0.0{n} }}")
    };
    let laterals = (1..=9).map(lateral).collect::<Vec<_>>().join(", ");
    let of = |pitches: &str| {
        let text = format!("{DEFAULT}\n[tread_pattern]\npitches = {pitches}\nlaterals = [{laterals}]\n");
        Scene::from_str(&text, "crossing").map_or_else(|error| error.to_string(), |_| String::new())
    };
    let reported = of("{ lengths = [0.0065], sequence = \"random\", count = 300 }");
    assert!(reported.contains("tread_pattern.laterals") && reported.contains("cross each other"), "{reported}");
    assert_eq!(of("300"), "");
}

#[test]
fn air_without_pressure_in_an_inflated_tyre_is_asked_about() {
    let reported = about("tyre.cavity.density=1.2");
    assert!(reported.contains("1.2 kg/m^3 is implausible") && reported.contains("air at 220000 Pa"), "{reported}");
    assert_eq!(about("tyre.cavity.density=4.3"), "");
}

#[test]
fn angles_in_radians_are_asked_about_where_degrees_are_meant() {
    for angle in ["1.5708", "-0.4363", "1.309", "0.35", "1.2217"] {
        let reported = about(&format!("tyre.layers[0].cords[0].angle_deg={angle}"));
        assert!(reported.contains("from 1.6 to 90 degrees"), "{reported}");
    }
    for angle in ["0.0", "1", "1.5", "-0.1", "1.1"] {
        assert_eq!(about(&format!("tyre.layers[0].cords[0].angle_deg={angle}")), "");
    }
}
