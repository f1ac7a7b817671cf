//! Centrifugal tension of the belt.

use super::row::{Decided, Row};
use super::values::Decisions;
use crate::scene::{Layer, Scene, Switch, Tyre};

/// Share of the belt's tension from which `auto` takes centrifugal tension in: the speed of belt waves then changes by
/// 5 %.
const CENTRIFUGAL_SHARE: f64 = 0.1;
/// Share of the belt's tension from which a run without centrifugal tension says so.
const WORTH_TELLING: f64 = 0.5;

pub(super) const TENSION: Row = Row {
    title: "centrifugal tension",
    short: "tension",
    decide,
    switch: Some(|scene, on| scene.effects.centrifugal_tension = if on { Switch::On } else { Switch::Off }),
    of_cells: true,
};

fn decide(scene: &Scene, decisions: &mut Decisions) -> Decided {
    let (tyre, switch) = (&scene.tyre, scene.effects.centrifugal_tension);
    let speed = scene.rolling.speed();
    // The hoop tension of a thin ring.
    let mass_per_area: f64 = tyre.layers.iter().map(|layer| layer.material.density * layer.thickness).sum();
    let added = mass_per_area * speed * speed;
    let carried: f64 = tyre.layers.iter().map(|layer| layer.tension[0]).sum();
    let share = added / carried;
    let would = if carried > 0.0 {
        format!(
            "m'' V^2 = {:.1} kN/m is {:.1} % of the tension at {} km/h",
            1e-3 * added,
            100.0 * share,
            scene.rolling.speed_kmh
        )
    } else {
        format!("m'' V^2 = {:.1} kN/m at {} km/h", 1e-3 * added, scene.rolling.speed_kmh)
    };
    let limit = 100.0 * CENTRIFUGAL_SHARE;
    let (on, reason) = match switch {
        Switch::On => (true, would.clone()),
        Switch::Off => (false, format!("not asked for; {would}")),
        Switch::Auto if share > CENTRIFUGAL_SHARE => (true, format!("auto: {would}, more than {limit} %")),
        Switch::Auto => (false, format!("auto: {would}, not more than {limit} %")),
    };
    if !on && share > WORTH_TELLING {
        decisions.notes.push(format!("{would}: effects.centrifugal_tension = \"auto\" would take it in"));
    }
    if on {
        decisions.tyre = spinning(tyre, added, carried);
    }
    Decided { on, form: if on { "belt tension raised" } else { "" }.to_owned(), reason }
}

/// The tyre with tension added along its circumference \[N/m\]: the layers under tension carry it, each in proportion
/// to its own; where there is none, the layer of the largest stiffness E h does, which holds the others.
fn spinning(tyre: &Tyre, added: f64, carried: f64) -> Tyre {
    let mut tyre = tyre.clone();
    if carried > 0.0 {
        for layer in &mut tyre.layers {
            layer.tension[0] *= 1.0 + added / carried;
        }
    } else {
        let stiffer = |a: &&mut Layer, b: &&mut Layer| a.hoop_stiffness().total_cmp(&b.hoop_stiffness());
        if let Some(belt) = tyre.layers.iter_mut().max_by(stiffer) {
            belt.tension[0] += added;
        }
    }
    tyre
}
