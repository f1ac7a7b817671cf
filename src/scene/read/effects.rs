//! `[effects]`, and whether it fits the rest of the scene.

use super::super::kind::OneOf;
use super::super::table::{Nested, Table};
use super::super::{Effects, Lateral, Problem, ProfileRoad, Road, Scene, Switch, Tread, Vibration};

pub(super) const EFFECTS: Nested<Effects> = Nested { title: "[effects]", wanted: "the table [effects]", read: effects };

fn effects(table: &mut Table<'_>) -> Option<Effects> {
    let default = Effects::default();
    let mut switch = |key, default| table.or(key, &OneOf::<Switch>::new(), default);
    let texture = switch("texture", default.texture);
    let tread_vibration = switch("tread_vibration", default.tread_vibration);
    let belt_vibration = switch("belt_vibration", default.belt_vibration);
    let tangential_motion = switch("tangential_motion", default.tangential_motion);
    let centrifugal_tension = switch("centrifugal_tension", default.centrifugal_tension);
    let radiation = switch("radiation", default.radiation);
    let friction = switch("friction", default.friction);
    if friction == Some(Switch::On) {
        let wrong = "tangential friction in the contact is not there yet: this version has normal forces only";
        let right = "\"off\", or \"auto\", which takes it in once it is there";
        table.complain::<()>("friction", Problem::new(wrong, right));
    }
    Some(Effects {
        texture: texture?,
        tread_vibration: tread_vibration?,
        belt_vibration: belt_vibration?,
        tangential_motion: tangential_motion?,
        centrifugal_tension: centrifugal_tension?,
        radiation: radiation?,
        friction: friction.filter(|&given| given != Switch::On)?,
    })
}

/// Checks effects against what the scene holds; `None` after a complaint.
pub(super) fn check(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let checks = [texture(scene, table), centrifugal_tension(scene, table), vibration(scene, table)];
    checks.into_iter().collect()
}

fn vibration(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let Scene { effects, outputs, contact, .. } = scene;
    let asked = |field: fn(&Vibration) -> bool| outputs.vibration.as_ref().map(field);
    let fields = [
        ("tread_vibration", effects.tread_vibration, "tread", asked(|vibration| vibration.tread)),
        ("belt_vibration", effects.belt_vibration, "belt", asked(|vibration| vibration.belt)),
        ("tangential_motion", effects.tangential_motion, "tangential", asked(|vibration| vibration.tangential)),
    ];
    let mut sound = Some(());
    for (effect, switch, output, asked) in fields {
        let (key, wrong, right) = match (switch, asked) {
            (Switch::Off, Some(true)) => (
                format!("outputs.vibration.{output}"),
                format!("this asks for what effects.{effect} = \"off\" leaves out"),
                format!("{output} = false, or effects.{effect} = \"auto\""),
            ),
            (Switch::On, Some(false)) => (
                format!("effects.{effect}"),
                format!("outputs.vibration.{output} = false: nothing of it would be seen"),
                format!("\"auto\", or outputs.vibration.{output} = true"),
            ),
            (Switch::On, _) if output == "tangential" && contact.tread == Tread::Bedding => (
                format!("effects.{effect}"),
                "a bedding's springs have no tangential motion".to_owned(),
                "\"off\", or contact.tread = \"elastic\"".to_owned(),
            ),
            _ => continue,
        };
        sound = table.complain(&key, Problem::new(wrong, right));
    }
    sound
}

fn texture(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let complain = |key: &str, wrong: &str, right: &str| table.complain(key, Problem::new(wrong, right));
    match scene.effects.texture {
        Switch::On => {
            let right = "\"off\", \"auto\", or a road with texture across";
            match &scene.road {
                Road::Smooth => complain("effects.texture", "a smooth road has no texture", right),
                Road::Profile(ProfileRoad { lateral: Lateral::Extruded, .. }) => {
                    complain("effects.texture", "a profile that is the same all across has no texture across", right)
                }
                _ if scene.contact.cells_across == Some(1) => complain(
                    "effects.texture",
                    "one cell across (contact.cells_across) holds no texture",
                    "more cells, or \"off\"",
                ),
                _ => Some(()),
            }
        }
        Switch::Off if scene.contact.cells_across.is_some_and(|points| points > 1) => complain(
            "contact.cells_across",
            "cells across the width mean nothing with effects.texture = \"off\"",
            "leave this out, or effects.texture = \"auto\"",
        ),
        Switch::Off | Switch::Auto => Some(()),
    }
}

fn centrifugal_tension(scene: &Scene, table: &Table<'_>) -> Option<()> {
    if scene.effects.centrifugal_tension == Switch::Auto && !scene.tyre.is_tense_along() {
        let wrong = "no layer carries tension along the circumference: there is nothing to compare m'' V^2 with";
        let right = "\"on\" or \"off\", or a layer with tension";
        return table.complain("effects.centrifugal_tension", Problem::new(wrong, right));
    }
    Some(())
}
