//! Sound radiation, of the tread and of the sidewalls.

use super::squeeze::found_blocks;
use crate::contact::cells::gaps::PLACES;
use crate::numeric::SplitRule;
use crate::plan::decisions::{Decided, DecisionRow, Decisions, given};
use crate::plan::sound::channels;
use crate::radiation::draft::{DraftError, DraftErrors};
use crate::response::pressure::open_patch::waves_for;
use crate::scene::{AirMotion, PatchAir, Pitches, Radiation, RadiationQuality, Scene, Switch};

/// Rows of the radiation, of the sidewalls, of the air under the patch, and of the squeeze of blocks.
pub(super) static ROWS: [DecisionRow; 4] = [RADIATION, SIDES, PATCH, SQUEEZE];

const RADIATION: DecisionRow = DecisionRow {
    title: "radiation",
    short: "radiation",
    decide: |scene, _| decide(scene),
    switch: Some(|scene, on| {
        scene.effects.radiation = if on { Switch::On } else { Switch::Off };
        if !on {
            (scene.receivers, scene.radiation, scene.air_pumping) = (Vec::new(), Radiation::default(), None);
        }
    }),
    of_cells: false,
};

fn decide(scene: &Scene) -> Decided {
    let given = given(scene.effects.radiation, "radiation");
    if scene.receivers.is_empty() {
        return Decided::off(given.unwrap_or_else(|| "auto: there is no [[receiver]]".to_owned()));
    }
    let radiation = &scene.radiation;
    let air = match radiation.air {
        AirMotion::Road => "air at rest over the road",
        AirMotion::Axle => "air at rest beside the axle",
        AirMotion::WithTread => "air that turns with the tread",
    };
    let path = match radiation.quality {
        RadiationQuality::Full => "boundary elements".to_owned(),
        RadiationQuality::Draft => {
            let width = scene.tyre.width + 2.0 * radiation.shoulder;
            let errors = DraftErrors::of(scene.tyre.radius(), width).map(|errors| errors.of_standards);
            let reported = |error: DraftError| format!("{} dB a third octave and {} dB(A)", error.band, error.level);
            let error = errors.map_or_else(|| "an unknown error".to_owned(), reported);
            format!("draft: monopoles with a fitted horn, within {error} at coast-by and cpx, elsewhere by the place,")
        }
    };
    let form = format!("{path} to {} Hz, {air}", radiation.fmax);
    let reason = given.unwrap_or_else(|| match scene.receivers.len() {
        1 => "auto: there is a [[receiver]]".to_owned(),
        several => format!("auto: there are {several} [[receiver]]"),
    });
    Decided::on(form, reason)
}

const SIDES: DecisionRow = DecisionRow {
    title: "sound of the sidewalls",
    short: "sides",
    decide: |scene, _| decide_sides(scene),
    switch: Some(|scene, on| {
        // Where radiation is switched off, this is, too.
        if scene.effects.radiation != Switch::Off {
            scene.radiation.sides = if on { Switch::On } else { Switch::Off };
        }
    }),
    of_cells: false,
};

fn decide_sides(scene: &Scene) -> Decided {
    let Scene { radiation, tyre, .. } = scene;
    if scene.receivers.is_empty() {
        return Decided::off("auto: there is no [[receiver]]");
    }
    match radiation.sides {
        Switch::Off => return Decided::off("radiation.sides = \"off\""),
        _ if !Radiation::sides_move(tyre) => return Decided::off("auto: the tyre has no sidewalls that move"),
        _ if !radiation.hears_sides(tyre) => return Decided::off("auto: a draft has the sound of the tread alone"),
        Switch::On | Switch::Auto => {}
    }
    let form = format!("shoulders and sides as {} rings a side, as the sidewalls' arcs move them", SplitRule::POINTS);
    let reason = match radiation.sides {
        Switch::On => "radiation.sides = \"on\"",
        _ => "auto: the tyre's sidewalls are arcs",
    };
    Decided::on(form, reason)
}

const PATCH: DecisionRow = DecisionRow {
    title: "air under the patch",
    short: "air",
    decide: |scene, decisions| decide_patch(scene, decisions),
    switch: Some(|scene, on| {
        scene.effects.air_pumping = match (on, &scene.air_pumping) {
            (false, _) => Switch::Off,
            (true, Some(pumping)) if pumping.patch != PatchAir::Sealed => Switch::Auto,
            // Refused later, with the name of the missing key.
            (true, _) => Switch::On,
        };
    }),
    of_cells: true,
};

fn decide_patch(scene: &Scene, decisions: &Decisions) -> Decided {
    let given = given(scene.effects.air_pumping, "air_pumping");
    let is_open = scene.air_pumping.as_ref().is_some_and(|pumping| pumping.patch != PatchAir::Sealed);
    if !is_open {
        return Decided::off(given.unwrap_or_else(|| "auto: the patch is sealed".to_owned()));
    }
    if scene.effects.air_pumping == Switch::Off {
        return Decided::off(given.unwrap_or_default());
    }
    let channels = channels(scene);
    let opens_voids = scene.opens_voids();
    if channels.is_empty() && !opens_voids {
        return Decided::off("its grooves, the sound or the elastic tread are left out");
    }
    let across = decisions.cells_across.filter(|_| opens_voids);
    let needed = waves_for(&channels, scene.tyre.contact_width, across);
    let pitches = scene.pattern().and_then(|pattern| pattern.pitches.as_ref()).map_or(String::new(), |pitches| {
        let count = match pitches {
            Pitches::Equal(count) => *count,
            Pitches::Varied(varied) => varied.in_order().len(),
        };
        let passing = count as f64 * scene.rolling.speed() / scene.tyre.circumference;
        format!(", pitches pass at {passing:.0} Hz")
    });
    let form = match channels.len() {
        _ if opens_voids => format!("all voids at {PLACES} places"),
        1 => "one groove".to_owned(),
        several => format!("{several} grooves"),
    };
    let patch = if opens_voids { "voids" } else { "grooves" };
    let form = format!("{form} through the patch, lateral_waves of {needed} follow its steps{pitches}");
    Decided::on(form, given.unwrap_or_else(|| format!("air_pumping.patch = \"{patch}\"")))
}

const SQUEEZE: DecisionRow = DecisionRow {
    title: "squeeze of blocks",
    short: "squeeze",
    decide: decide_squeeze,
    switch: Some(|scene, on| match &mut scene.air_pumping {
        Some(pumping) => pumping.squeeze = on,
        // Refused later, with the name of the missing key.
        None if on => scene.effects.air_pumping = Switch::On,
        None => {}
    }),
    of_cells: true,
};

fn decide_squeeze(scene: &Scene, decisions: &mut Decisions) -> Decided {
    if !scene.air_pumping.as_ref().is_some_and(|pumping| pumping.squeeze) {
        return Decided::off("air_pumping.squeeze is not set");
    }
    if !scene.squeezes_blocks() {
        return Decided::off("the open patch, its sound or compliant blocks are left out");
    }
    let Some(squeeze) = found_blocks(scene, decisions) else {
        return Decided::off("no cut is deeper than a third of the tread");
    };
    let [blocks, without] = squeeze.counts();
    let without = if without > 0 { format!(", but {without} that have none") } else { String::new() };
    let form =
        format!("{blocks} blocks and ribs press the volume by which they yield into the voids beside them{without}");
    Decided::on(form, "air_pumping.squeeze = true")
}
