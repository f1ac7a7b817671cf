//! Rows of the plan on the velocities of belt and tread.

use crate::plan::decisions::{Decided, DecisionRow, given};
use crate::scene::{Effects, Scene, Switch, Vibration};

/// A velocity's row, with its settings among the effects and the outputs.
macro_rules! row {
    ($title:literal, $short:literal, $effect:ident, $output:ident) => {
        DecisionRow {
            title: $title,
            short: $short,
            decide: |scene, _| velocity(scene, scene.effects.$effect, stringify!($effect), |wanted| wanted.$output),
            switch: Some(|scene, on| {
                scene.effects.$effect = if on { Switch::On } else { Switch::Off };
                want(scene, on, |vibration| &mut vibration.$output);
            }),
            of_cells: false,
        }
    };
}

/// Rows of tread, belt and tangential motion.
pub(super) static ROWS: [DecisionRow; 3] = [
    row!("tread vibration", "vibration", tread_vibration, tread),
    row!("belt vibration", "belt", belt_vibration, belt),
    row!("tangential motion", "tangential", tangential_motion, tangential),
];

/// Vibration that the outputs ask for; without outputs, the default for the effects that are on.
pub(super) fn wanted(scene: &Scene) -> Option<Vibration> {
    let Effects { tread_vibration, belt_vibration, tangential_motion, .. } = scene.effects;
    let [tread, belt, tangential] =
        [tread_vibration, belt_vibration, tangential_motion].map(|switch| switch == Switch::On);
    let asked_by_effects =
        || (tread || belt || tangential).then(|| Vibration { tread, belt, tangential, ..Vibration::default() });
    scene.outputs.vibration.clone().or_else(asked_by_effects)
}

fn velocity(scene: &Scene, switch: Switch, key: &str, field: fn(&Vibration) -> bool) -> Decided {
    let on = wanted(scene).as_ref().is_some_and(field);
    let asked = if on { "auto: outputs.vibration asks for it" } else { "auto: no output asks for it" };
    let reason = given(switch, key).unwrap_or_else(|| asked.to_owned());
    let form = if on { "per wavenumber, from the forces" } else { "" }.to_owned();
    Decided { on, form, reason }
}

/// Adds or removes a velocity; the settings go if none is left.
fn want(scene: &mut Scene, on: bool, field: fn(&mut Vibration) -> &mut bool) {
    let none = Vibration { tread: false, belt: false, tangential: false, ..Vibration::default() };
    let vibration = scene.outputs.vibration.get_or_insert(none);
    *field(vibration) = on;
    if !(vibration.tread || vibration.belt || vibration.tangential) {
        scene.outputs.vibration = None;
    }
}
