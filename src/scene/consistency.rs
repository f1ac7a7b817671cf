//! Consistency of a scene across its tables.

use crate::radiation::draft::{self, DraftErrors};

use super::problem::Problem;
use super::table::{Keys, Table};
use super::{
    AirPumping, Axle, BlockModel, Lateral, PatchAir, ProfileRoad, Radiation, RadiationQuality, Receiver, ReceiverPlace,
    Road, Scene, StandardReceiver, Switch, TimeRule, Tread, Vehicle, Vibration, Zone, plausible, tread_pattern,
};

/// Reads a whole scene and checks it; `None` after a complaint.
pub(super) fn scene(table: &mut Table<'_>) -> Option<Scene> {
    let mut scene = Scene::read(table)?;
    plausible::check(&scene, table)?;
    cells(&scene, table)?;
    friction(&mut scene, table)?;
    tread_pattern::check(&scene, table)?;
    let effects = [texture(&scene, table), rotation(&scene, table), vibration_effects(&scene, table)];
    effects.into_iter().collect::<Option<()>>()?;
    vibration(&scene, table)?;
    receiver_names(&scene, table)?;
    sound(&scene, table)?;
    air_pumping(&scene, table)?;
    levels(&scene, table)?;
    sections(&scene, table)?;
    Some(scene)
}

/// Refuses receivers of equal names, which tables and files could not distinguish; `None` after a complaint.
fn receiver_names(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let mut sound = Some(());
    for (index, Receiver { name, .. }) in scene.receivers.iter().enumerate().filter(|(_, at)| !at.name.is_empty()) {
        if let Some(earlier) = scene.receivers[..index].iter().position(|other| other.name == *name) {
            let wrong = format!("\"{name}\" is the name of receiver[{earlier}], too");
            let right = "write a name that no other receiver has, or leave it out";
            sound = table.complain(&format!("receiver[{index}].name"), Problem::new(wrong, right));
        }
    }
    sound
}

/// Refuses what `outputs.levels` does not correct; `None` after a complaint.
fn levels(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let wrong = "only levels of normal force and sound are corrected to the finer mesh";
    let is_asked = scene.outputs.levels.is_some();
    let is_cut = scene.outputs.levels.as_ref().is_some_and(|levels| levels.segments > 1);
    let [in_pieces, key] = ["segments roll side by side: nothing is stored over time", "outputs.levels.segments"];
    let is_heard = !scene.receivers.is_empty() && scene.radiation.audio;
    table.complain_of_each([
        (is_asked && scene.friction.is_some(), "outputs.levels", wrong, "remove it, or [friction]"),
        (is_asked && scene.outputs.vibration.is_some(), "outputs.levels", wrong, "remove it, or [outputs.vibration]"),
        (is_cut && scene.outputs.arrays, key, in_pieces, "1, or outputs.arrays = false"),
        (is_cut && scene.outputs.cells_every.is_some(), key, in_pieces, "1, or no outputs.cells_every"),
        (is_cut && is_heard, key, in_pieces, "1, or radiation.audio = false"),
    ])
}

/// Refuses sections that the run does not roll, or whose levels would be corrected by other roads; `None` after a
/// complaint.
fn sections(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let Some(length) = scene.outputs.sections else { return Some(()) };
    let (speed, key) = (scene.rolling.speed(), "outputs.sections");
    let rolled = speed * scene.rolling.duration;
    let short = format!("the run rolls {rolled:.2} m after its warm-up, less than one section of {length} m");
    let longer = format!("a shorter section, or a rolling.duration of at least {:.3} s", length / speed);
    let elsewhere = "levels of a finer mesh rest on the first piece of the road, and a section's on its own road";
    table.complain_of_each([
        (rolled < length * (1.0 - 1e-9), key, short.as_str(), longer.as_str()),
        (scene.outputs.levels.is_some(), key, elsewhere, "remove it, or outputs.levels"),
    ])
}

/// Refuses what contact over cells does not support yet, or cannot have; `None` after a complaint.
fn cells(scene: &Scene, table: &Table<'_>) -> Option<()> {
    if scene.contact.zone != Zone::Cells {
        let tolerance = scene.outputs.vibration.as_ref().and_then(|vibration| vibration.lateral_tolerance);
        let right = "remove it, or contact.zone = \"cells\"";
        let one_force = "a slice has one force across the width, and no wave that it excites is left out";
        return table.complain_of_each([
            (scene.outputs.cells_every.is_some(), "outputs.cells_every", "there are no cells to write", right),
            (tolerance.is_some(), "outputs.vibration.lateral_tolerance", one_force, right),
        ]);
    }
    let mut sound = Some(());
    if let (Some(terms), Some(across)) = (scene.numerics.lateral_terms, scene.contact.cells_across)
        && terms < across
    {
        let wrong =
            format!("{terms} waves across cannot resolve {across} cells: the influence between them is singular");
        let right = format!("write a whole number of at least {across}, or leave this out");
        sound = table.complain("numerics.lateral_terms", Problem::new(wrong, right));
    }
    let right = "remove it, or contact.zone = \"slices\"";
    let has_mass = matches!(scene.rolling.axle, Axle::Mass { .. });
    let level = "cells have their texture in their heights; a road that is level across is kind = \"profile\"";
    let refused = [
        (has_mass, "rolling.axle.mass", "cells need an axle without a mass", right),
        (scene.effects.texture == Switch::Off, "effects.texture", level, right),
    ];
    table.complain_of_each(refused).and(sound)
}

/// Refuses what friction excludes, and sets the time rule that it needs where the scene leaves that open; `None` after
/// a complaint.
fn friction(scene: &mut Scene, table: &Table<'_>) -> Option<()> {
    let complain = |key: &str, wrong: &str, right: &str| table.complain(key, Problem::new(wrong, right));
    match (&scene.friction, &scene.adhesion) {
        (None, Some(_)) => {
            return complain("adhesion", "adhesion needs friction", "add [friction], mu = 0 at least");
        }
        (None, None) if scene.effects.friction == Switch::On => {
            let right = "\"auto\" or \"off\", or a table [friction] with mu = 0.9";
            return complain("effects.friction", "there is no [friction] that says how large it is", right);
        }
        (None, None) => return Some(()),
        (Some(_), _) if scene.effects.friction == Switch::Off => {
            let wrong = "this needs what effects.friction = \"off\" switches off";
            return complain("friction", wrong, "leave it out, or effects.friction = \"auto\"");
        }
        _ => {}
    }
    if scene.contact.zone != Zone::Cells {
        let wrong = "a slice has one force across the width, which stands for its texture: it neither sticks nor slips";
        return complain("friction", wrong, "remove it, or contact.zone = \"cells\"");
    }
    if !table.gives("numerics.time_rule") {
        scene.numerics.time_rule = TimeRule::Bdf2;
    }
    if !scene.numerics.time_rule.is_stable_with_friction() {
        let name = scene.numerics.time_rule.name();
        let wrong = format!("{name} is not stable with friction: only backward differences dissipate in every step");
        return complain("numerics.time_rule", &wrong, "\"bdf2\" or \"bdf1\"");
    }
    Some(())
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
            "cells across the width have no effect with effects.texture = \"off\"",
            "leave this out, or effects.texture = \"auto\"",
        ),
        Switch::Off | Switch::Auto => Some(()),
    }
}

fn rotation(scene: &Scene, table: &Table<'_>) -> Option<()> {
    if scene.effects.rotation == Switch::On && !scene.tyre.curvature {
        let wrong = "a flat plate does not turn";
        let right = "\"auto\" or \"off\", or a tyre with curvature = true";
        return table.complain("effects.rotation", Problem::new(wrong, right));
    }
    Some(())
}

fn vibration_effects(scene: &Scene, table: &Table<'_>) -> Option<()> {
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
                format!("this needs what effects.{effect} = \"off\" switches off"),
                format!("{output} = false, or effects.{effect} = \"auto\""),
            ),
            (Switch::On, Some(false)) => (
                format!("effects.{effect}"),
                format!("outputs.vibration.{output} = false: it would have no output"),
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

/// Refuses vibration that the tyre or the tread law cannot give; `None` after a complaint.
fn vibration(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let Some(vibration) = &scene.outputs.vibration else { return Some(()) };
    let half = 0.5 * scene.tyre.circumference;
    let outside = vibration.points.iter().enumerate().filter(|(_, position)| position.abs() > half);
    let mut fits = true;
    for (index, position) in outside {
        let wrong = format!("{position} m is outside the tyre, which reaches {half} m to either side of the axle");
        let right = format!("write a position from -{half} to {half} m along the circumference");
        table.complain::<()>(&format!("outputs.vibration.points[{index}]"), Problem::new(wrong, right));
        fits = false;
    }
    if vibration.tangential && scene.contact.tread == Tread::Bedding {
        let wrong = "a bedding's springs have no tangential motion";
        let right = "tangential = false, or contact.tread = \"elastic\"";
        return table.complain("outputs.vibration.tangential", Problem::new(wrong, right));
    }
    fits.then_some(())
}

/// Refuses settings that a draft has no use for, where they differ from the defaults, and tyres, frequencies and places
/// for which no error of a draft is known.
fn draft_quality(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let radiation = &scene.radiation;
    if radiation.quality != RadiationQuality::Draft {
        return Some(());
    }
    let default = Radiation::default();
    let differs = |value: f64, default: f64| (value - default).abs() > 0.0;
    let solved = "a draft solves no equations: there are no elements and no frequencies to choose";
    let sealed = "a draft's horn is fitted to a sealed patch";
    let (tread, right) = ("a draft has the sound of the tread alone", "leave this out, or quality = \"full\"");
    let many_nodes = differs(radiation.nodes_per_wavelength, default.nodes_per_wavelength);
    let tolerant = differs(radiation.frequency_tolerance, default.frequency_tolerance);
    let sound = table.complain_of_each([
        (many_nodes, "radiation.nodes_per_wavelength", solved, right),
        (tolerant, "radiation.frequency_tolerance", solved, right),
        (differs(radiation.acoustic_gap, default.acoustic_gap), "radiation.acoustic_gap", sealed, right),
        (radiation.sides == Switch::On, "radiation.sides", tread, right),
    ]);
    sound.and(stated(scene, table))
}

/// Speed of sound for a draft's highest frequency \[m/s\].
const SOUND_SPEED: f64 = 343.0;

/// Refuses sizes, frequencies and places for which the error of a draft was not measured.
fn stated(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let Scene { tyre, radiation, .. } = scene;
    let (radius, full) = (tyre.radius(), "quality = \"full\"");
    let width = tyre.width + 2.0 * radiation.shoulder;
    let Some(errors) = DraftErrors::of(radius, width) else {
        let [least, _, most] = draft::WIDTHS.map(|width| width * radius);
        let wrong = format!("a draft's error is not known for a tyre {width:.3} m wide with its shoulders");
        let right = format!("{full}, or a width with both shoulders from {least:.3} to {most:.3} m");
        return table.complain("radiation.quality", Problem::new(wrong, right));
    };
    let highest = draft::HIGHEST * SOUND_SPEED / (std::f64::consts::TAU * radius);
    if radiation.fmax > highest {
        let wrong = format!("a draft's error is not known above {highest:.0} Hz with this tyre");
        return table.complain("radiation.fmax", Problem::new(wrong, format!("at most {highest:.0} Hz, or {full}")));
    }
    let mut sound = Some(());
    for (index, receiver) in scene.receivers.iter().enumerate() {
        let Some((key, place)) = receiver.place.judged_by() else { continue };
        if errors.at(place).is_none() {
            let wrong =
                "a draft's error is not known at this place: without the tyre's body it is up to 18 dB off there";
            let right = format!(
                "{full}, or a place that is seen at most {:.0} degrees over the road from the contact and is {:.2} m \
                 or more away from it",
                draft::MOST_ELEVATION,
                draft::LEAST_DISTANCE * radius
            );
            sound = table.complain(&format!("receiver[{index}].{key}"), Problem::new(wrong, right));
        }
    }
    sound
}

/// Refuses sound without a receiver, sound that an effect excludes, and impossible places; `None` after a complaint.
fn sound(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let has_receivers = !scene.receivers.is_empty();
    match scene.effects.radiation {
        Switch::On if !has_receivers => {
            let right = "\"auto\", or a receiver: [[receiver]] with position = [x, y, z]";
            return table.complain("effects.radiation", Problem::new("there is no [[receiver]]", right));
        }
        Switch::Off if has_receivers => {
            let wrong = "this needs what effects.radiation = \"off\" switches off";
            return table.complain("receiver", Problem::new(wrong, "leave it out, or effects.radiation = \"auto\""));
        }
        _ => {}
    }
    if !has_receivers && scene.radiation != Radiation::default() {
        let wrong = "there is no [[receiver]]: this would have no effect";
        return table.complain("radiation", Problem::new(wrong, "add a [[receiver]], or leave this table out"));
    }
    if !has_receivers {
        return Some(());
    }
    let (patch, radius) = (scene.radiation.patch_length.unwrap_or(0.0), scene.tyre.radius());
    if patch >= radius {
        let limit = Problem::exceeds(patch, radius, "the tyre's radius");
        return table.complain("radiation.patch_length", limit);
    }
    if scene.radiation.shoulder >= 0.5 * radius {
        let limit = Problem::exceeds(scene.radiation.shoulder, 0.5 * radius, "half of the tyre's radius");
        return table.complain("radiation.shoulder", limit);
    }
    let mut sound = draft_quality(scene, table);
    if scene.radiation.sides == Switch::On && !Radiation::sides_move(&scene.tyre) {
        let wrong = "the tyre's sidewalls do not move: they are a foundation, or its sides are supported";
        let right = "\"auto\" or \"off\", or a tyre with sidewall = { radius = ..., ... } and sides = \"guided\"";
        sound = table.complain("radiation.sides", Problem::new(wrong, right));
    }
    let half_width = 0.5 * scene.tyre.width + scene.radiation.shoulder;
    for (index, receiver) in scene.receivers.iter().enumerate() {
        if let ReceiverPlace::Standard(StandardReceiver::CoastBy { distance, vehicle: Some(vehicle), .. }) =
            receiver.place
        {
            sound = sound.and(beside(vehicle, distance, half_width, index, table));
        }
        let ReceiverPlace::Position { position: [x, y, z] } = receiver.place else { continue };
        let key = format!("receiver[{index}].position");
        if z < 0.0 {
            let right = "z is the height above the road, 0 or more";
            sound = table.complain(&key, Problem::new(format!("z = {z} m is below the road"), right));
        } else if y.abs() <= half_width && x.hypot(z - radius) <= radius {
            let right = format!(
                "x forward, y to the left, z up from the road under the axle; the tyre reaches {half_width:.2} m to \
                 either side and {:.2} m up",
                2.0 * radius
            );
            sound = table.complain(&key, Problem::new("this is inside the tyre", right));
        }
    }
    sound
}

/// Refuses a vehicle whose left and right tyres overlap, or whose left tyres reach as far as the microphone.
fn beside(vehicle: Vehicle, distance: f64, half_width: f64, index: usize, table: &Table<'_>) -> Option<()> {
    let track = vehicle.track;
    let (least, most) = (2.0 * half_width, 2.0 * (distance - half_width));
    if track > least && track < most {
        return Some(());
    }
    let wrong = if track > least {
        format!("the left tyres of a track of {track} m reach as far as the microphone, {distance} m from its middle")
    } else {
        format!("tyres {least:.2} m wide overlap with a track of {track} m")
    };
    let right = if least < most {
        format!("write a number above {least:.2} and below {most:.2}")
    } else {
        format!("write a number above {least:.2}, and a distance that leaves it room")
    };
    // The table may have left the track to its default: the complaint is placed at the table.
    table.complain(&format!("receiver[{index}].vehicle"), Problem::new(wrong, right))
}

/// Refuses air paths under the patch that the rest of the scene rules out; `None` after a complaint.
fn air_pumping(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let complain =
        |key: &str, wrong: &str, right: &str| table.complain::<()>(key, Problem::new(wrong.to_owned(), right));
    let is_open = matches!(&scene.air_pumping, Some(AirPumping { patch, .. }) if *patch != PatchAir::Sealed);
    let squeezes = scene.air_pumping.as_ref().is_some_and(|pumping| pumping.squeeze);
    if !is_open {
        if squeezes && scene.effects.air_pumping != Switch::Off {
            let wrong = "the patch is sealed: air that blocks press out cannot radiate";
            return complain("air_pumping.squeeze", wrong, "add patch = \"grooves\", or leave this out");
        }
        if scene.effects.air_pumping == Switch::On {
            let right = "\"auto\" or \"off\", or a table [air_pumping] with patch = \"grooves\"";
            return complain("effects.air_pumping", "there is no [air_pumping] that opens the patch", right);
        }
        return Some(());
    }
    if scene.effects.air_pumping == Switch::Off {
        return Some(());
    }
    let sealed = "leave [air_pumping] out";
    if scene.receivers.is_empty() {
        let right = "add a [[receiver]], or leave this out";
        return complain("air_pumping", "there is no [[receiver]] for its sound", right);
    }
    let (radiation, pattern) = (&scene.radiation, scene.tread_pattern.as_ref());
    let has_grooves = pattern.is_some_and(|pattern| pattern.grooves.iter().any(|groove| groove.depth > 0.0));
    let takes_voids = scene.air_pumping.as_ref().is_some_and(|pumping| pumping.patch == PatchAir::Voids);
    let missing = match pattern {
        _ if has_grooves || takes_voids => None,
        Some(pattern) if pattern.file.is_some() => Some("a raster does not say which of its voids run round the tyre"),
        _ => Some("there are no grooves that run round the tyre"),
    };
    let are_compliant = pattern.is_some_and(|pattern| pattern.blocks == BlockModel::Compliant);
    let compliant = "tread_pattern.blocks = \"compliant\", or leave this out";
    let springs = "springs do not conserve volume: the air under them would be moved by more than the tread";
    table.complain_of_each([
        (missing.is_some(), "air_pumping.patch", missing.unwrap_or_default(), "give tread_pattern.grooves"),
        (
            takes_voids && scene.contact.zone != Zone::Cells,
            "air_pumping.patch",
            "slices do not resolve where tread and road touch across",
            "contact.zone = \"cells\", or \"grooves\"",
        ),
        (scene.contact.tread != Tread::Elastic, "contact.tread", springs, "\"elastic\", or leave [air_pumping] out"),
        (
            radiation.acoustic_gap > 0.0,
            "radiation.acoustic_gap",
            "a patch is open by its grooves or by a slit, not by both",
            sealed,
        ),
        (
            radiation.quality == RadiationQuality::Draft,
            "radiation.quality",
            "a draft computes no field at the openings of the grooves",
            "\"full\", or leave [air_pumping] out",
        ),
        (
            squeezes && scene.contact.zone != Zone::Cells,
            "air_pumping.squeeze",
            "slices have no compliant blocks",
            "contact.zone = \"cells\", or leave this out",
        ),
        (
            squeezes && !are_compliant,
            "air_pumping.squeeze",
            "blocks as stiff as an uncut tread press no air out",
            compliant,
        ),
    ])
}
