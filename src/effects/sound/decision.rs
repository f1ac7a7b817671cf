//! Sound radiation, of the tread and of the sidewalls.

use crate::numeric::SplitRule;
use crate::plan::decisions::{Decided, Row, given};
use crate::radiation::draft::{DraftError, DraftErrors};
use crate::scene::{AirMotion, Radiation, RadiationQuality, Scene, Switch};

/// Rows of the radiation and of what radiates beside the tread.
pub(super) static ROWS: [Row; 2] = [RADIATION, SIDES];

const RADIATION: Row = Row {
    title: "radiation",
    short: "radiation",
    decide: |scene, _| decide(scene),
    switch: Some(|scene, on| {
        scene.effects.radiation = if on { Switch::On } else { Switch::Off };
        if !on {
            (scene.receivers, scene.radiation) = (Vec::new(), Radiation::default());
        }
    }),
    of_cells: false,
};

fn decide(scene: &Scene) -> Decided {
    let given = given(scene.effects.radiation, "radiation");
    if scene.receivers.is_empty() {
        let reason = given.unwrap_or_else(|| "auto: there is no [[receiver]]".to_owned());
        return Decided { on: false, form: String::new(), reason };
    }
    let radiation = &scene.radiation;
    let air = match radiation.air {
        AirMotion::Road => "air at rest over the road",
        AirMotion::Axle => "air at rest beside the axle",
        AirMotion::WithTread => "air that turns with the tread",
    };
    let way = match radiation.quality {
        RadiationQuality::Full => "boundary elements".to_owned(),
        RadiationQuality::Draft => {
            let width = scene.tyre.width + 2.0 * radiation.shoulder;
            let errors = DraftErrors::of(scene.tyre.radius(), width).map(|errors| errors.of_standards);
            let told = |error: DraftError| format!("{} dB a third octave and {} dB(A)", error.band, error.level);
            let error = errors.map_or_else(|| "an unknown error".to_owned(), told);
            format!("draft: monopoles with a fitted horn, within {error} at coast-by and cpx, elsewhere by the place,")
        }
    };
    let form = format!("{way} to {} Hz, {air}", radiation.fmax);
    let reason = given.unwrap_or_else(|| match scene.receivers.len() {
        1 => "auto: there is a [[receiver]]".to_owned(),
        several => format!("auto: there are {several} [[receiver]]"),
    });
    Decided { on: true, form, reason }
}

const SIDES: Row = Row {
    title: "sound of the sidewalls",
    short: "sides",
    decide: |scene, _| decide_sides(scene),
    switch: Some(|scene, on| {
        // Where radiation is taken away, this is, too.
        if scene.effects.radiation != Switch::Off {
            scene.radiation.sides = if on { Switch::On } else { Switch::Off };
        }
    }),
    of_cells: false,
};

fn decide_sides(scene: &Scene) -> Decided {
    let Scene { radiation, tyre, .. } = scene;
    let off = |reason: &str| Decided { on: false, form: String::new(), reason: reason.to_owned() };
    if scene.receivers.is_empty() {
        return off("auto: there is no [[receiver]]");
    }
    match radiation.sides {
        Switch::Off => return off("radiation.sides = \"off\""),
        _ if !Radiation::sides_move(tyre) => return off("auto: the tyre has no sidewalls that move"),
        _ if !radiation.hears_sides(tyre) => return off("auto: a draft has the sound of the tread alone"),
        Switch::On | Switch::Auto => {}
    }
    let form = format!("shoulders and sides as {} rings a side, as the sidewalls' arcs move them", SplitRule::POINTS);
    let reason = match radiation.sides {
        Switch::On => "radiation.sides = \"on\"",
        _ => "auto: the tyre's sidewalls are arcs",
    };
    Decided { on: true, form, reason: reason.to_owned() }
}
