//! Numbers that are possible and hardly meant.

use super::super::{complaints, edited};
use crate::scene::Scene;

#[test]
fn a_load_in_kilonewtons_is_asked_about() {
    let text = edited("load = 3400", "load = 3.4");
    let [complaint] = &complaints(&text)[..] else { panic!("{:?}", complaints(&text)) };
    assert_eq!((complaint.key.as_str(), complaint.line), ("rolling.axle.load", 21));
    assert_eq!(complaint.wrong, "3.4 N is hardly meant: from 10 to 1e7 N is plausible");
    assert!(complaint.right.contains("another unit?") && complaint.right.contains("allow_implausible = true"));
}

#[test]
fn what_no_tyre_has_is_asked_about_and_may_be_tried_within_bounds() {
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
