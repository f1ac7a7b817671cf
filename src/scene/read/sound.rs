//! `[[receiver]]` and `[radiation]`.

use serde::Deserialize;

use super::super::kind::{Bounds, Count, Decibels, Exactly, Flag, OneOf, Text};
use super::super::table::{Each, Nested, Table};
use super::super::{
    AirMotion, Problem, Radiation, RadiationQuality, Receiver, ReceiverPlace, Scene, StandardReceiver, Switch, Vehicle,
};

pub(super) const RECEIVERS: Each<Receiver> =
    Each(Nested { title: "[[receiver]]", wanted: "tables [[receiver]], one for each place", read: receiver });
pub(super) const RADIATION: Nested<Radiation> =
    Nested { title: "[radiation]", wanted: "the table [radiation]", read: radiation };
const VEHICLE: Nested<Vehicle> =
    Nested { title: "the vehicle", wanted: "a table, { wheelbase = 2.7, track = 1.55 }", read: vehicle };

/// What no microphone stands beyond.
const LENGTH: Bounds = Bounds::inside(0.0, 1e4, "m");
const COORDINATE: Bounds = Bounds::between(-1e4, 1e4, "m");

/// From axle to axle of anything that rolls.
const WHEELBASE: Bounds = Bounds::between(0.0, 20.0, "m");
const TRACK: Bounds = Bounds::inside(0.0, 5.0, "m");

/// The words of `standard`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Standard {
    CoastBy,
    Cpx,
    Circle,
    Hemisphere,
}

fn receiver(table: &mut Table<'_>) -> Option<Receiver> {
    let name = table.or("name", &Text, String::new());
    let place = match (table.has("position"), table.has("standard")) {
        (true, false) => {
            let position = table.required("position", &Exactly::<3>(COORDINATE));
            table.refuse(&["standard", "distance", "height", "radius", "vehicle"], "position", "leave this out");
            position.map(|position| ReceiverPlace::Position { position })
        }
        (true, true) => table.complain("standard", Problem::new("`position` is given, too", "one of the two")),
        (false, false) => {
            for key in ["position", "standard", "distance", "height", "radius", "vehicle"] {
                table.take(key);
            }
            // A slip in the key's name is told by itself, with the name that was meant.
            if table.has_unknown() {
                return None;
            }
            let right = "position = [x, y, z] in metres, or standard = \"coast-by\", \"cpx\", \"circle\" or \
                         \"hemisphere\"";
            table.complain_here(Problem::new("it says nowhere where the receiver is", right))
        }
        (false, true) => standard(table).map(ReceiverPlace::Standard),
    };
    if place.is_none() {
        table.be_lenient();
    }
    Some(Receiver { name: name?, place: place? })
}

fn standard(table: &mut Table<'_>) -> Option<StandardReceiver> {
    let standard = table.required("standard", &OneOf::<Standard>::new())?;
    let right = "leave this out";
    Some(match standard {
        Standard::CoastBy => {
            table.refuse(&["radius"], "standard = \"coast-by\"", right);
            let distance = table.or("distance", &LENGTH, StandardReceiver::DISTANCE);
            let height = table.or("height", &LENGTH, StandardReceiver::HEIGHT);
            let vehicle = table.optional("vehicle", &VEHICLE);
            StandardReceiver::CoastBy { distance: distance?, height: height?, vehicle: vehicle? }
        }
        Standard::Cpx => {
            table.refuse(&["radius", "distance", "height", "vehicle"], "standard = \"cpx\"", right);
            StandardReceiver::Cpx
        }
        Standard::Circle => {
            table.refuse(&["distance", "vehicle"], "standard = \"circle\"", right);
            let (radius, height) = (table.required("radius", &LENGTH), table.required("height", &LENGTH));
            StandardReceiver::Circle { radius: radius?, height: height? }
        }
        Standard::Hemisphere => {
            table.refuse(&["distance", "height", "vehicle"], "standard = \"hemisphere\"", right);
            StandardReceiver::Hemisphere { radius: table.required("radius", &LENGTH)? }
        }
    })
}

fn vehicle(table: &mut Table<'_>) -> Option<Vehicle> {
    let default = Vehicle::default();
    let wheelbase = table.or("wheelbase", &WHEELBASE, default.wheelbase);
    let track = table.or("track", &TRACK, default.track);
    Some(Vehicle { wheelbase: wheelbase?, track: track? })
}

fn radiation(table: &mut Table<'_>) -> Option<Radiation> {
    let default = Radiation::default();
    let quality = table.or("quality", &OneOf::<RadiationQuality>::new(), default.quality);
    let fmax = table.or("fmax", &Bounds::between(50.0, 2e4, "Hz"), default.fmax);
    let nodes = table.or("nodes_per_wavelength", &Bounds::between(3.0, 40.0, ""), default.nodes_per_wavelength);
    let tolerance =
        table.or("frequency_tolerance", &Decibels(Bounds::between(1e-3, 6.0, "dB")), default.frequency_tolerance);
    let lateral_waves = table.or("lateral_waves", &Count(1), default.lateral_waves);
    let shoulder = table.or("shoulder", &Bounds::inside(0.0, 1.0, "m"), default.shoulder);
    let patch_length = table.optional("patch_length", &LENGTH);
    let acoustic_gap = table.or("acoustic_gap", &Bounds::between(0.0, 0.05, "m"), default.acoustic_gap);
    let air = table.or("air", &OneOf::<AirMotion>::new(), default.air);
    let temperature = table.or("temperature", &Bounds::between(-50.0, 60.0, "degrees Celsius"), default.temperature);
    let audio = table.or("audio", &Flag, default.audio);
    Some(Radiation {
        quality: quality?,
        fmax: fmax?,
        nodes_per_wavelength: nodes?,
        frequency_tolerance: tolerance?,
        lateral_waves: lateral_waves?,
        shoulder: shoulder?,
        patch_length: patch_length?,
        acoustic_gap: acoustic_gap?,
        air: air?,
        temperature: temperature?,
        audio: audio?,
    })
}

/// Complains about what a draft does not have, where it is not what it is by default.
fn draft(radiation: &Radiation, table: &Table<'_>) -> Option<()> {
    let default = Radiation::default();
    let differs = |value: f64, default: f64| (value - default).abs() > 0.0;
    let solved = "a draft solves no equations: there are no elements and no frequencies to choose";
    let sealed = "a draft's horn is fitted to a sealed patch";
    let contradictions = [
        ("nodes_per_wavelength", differs(radiation.nodes_per_wavelength, default.nodes_per_wavelength), solved),
        ("frequency_tolerance", differs(radiation.frequency_tolerance, default.frequency_tolerance), solved),
        ("acoustic_gap", differs(radiation.acoustic_gap, default.acoustic_gap), sealed),
    ];
    let mut sound = Some(());
    for (key, differs, wrong) in contradictions {
        if differs && radiation.quality == RadiationQuality::Draft {
            let right = "leave this out, or quality = \"full\"";
            sound = table.complain(&format!("radiation.{key}"), Problem::new(wrong, right));
        }
    }
    sound
}

/// Complains about sound that nobody hears, that an effect forbids, or that cannot be; `None` then.
pub(super) fn check(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let heard = !scene.receivers.is_empty();
    match scene.effects.radiation {
        Switch::On if !heard => {
            let right = "\"auto\", or a place to hear it: [[receiver]] with position = [x, y, z]";
            return table.complain("effects.radiation", Problem::new("there is no [[receiver]] to hear it", right));
        }
        Switch::Off if heard => {
            let wrong = "this asks for what effects.radiation = \"off\" leaves out";
            return table.complain("receiver", Problem::new(wrong, "leave it out, or effects.radiation = \"auto\""));
        }
        _ => {}
    }
    if !heard && scene.radiation != Radiation::default() {
        let wrong = "there is no [[receiver]]: nothing of this would be computed";
        return table.complain("radiation", Problem::new(wrong, "add a [[receiver]], or leave this table out"));
    }
    if !heard {
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
    let mut sound = draft(&scene.radiation, table);
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

/// Complains about a vehicle whose left and right tyres overlap, or whose left tyres reach as far as the microphone.
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
    // The table may have left it to the default, and then stands in its place.
    table.complain(&format!("receiver[{index}].vehicle"), Problem::new(wrong, right))
}
