//! Mistakes in receivers and in the radiation.

use super::super::super::{AirMotion, ReceiverPlace, Scene, Setting, StandardReceiver, Vehicle};
use super::{accepted, refused};

/// [`refused`] for tables put before the outputs.
#[track_caller]
fn sound_refused(tables: &str, line: usize, key: &str, wrong: &str, right: &str) {
    refused("[outputs]", &format!("{tables}\n[outputs]"), line, key, wrong, right);
}

/// [`refused`] for a receiver with these keys put before the outputs.
#[track_caller]
fn receiver_refused(keys: &str, line: usize, key: &str, wrong: &str, right: &str) {
    sound_refused(&format!("[[receiver]]\n{keys}"), line, &format!("receiver[0]{key}"), wrong, right);
}

#[test]
fn places() {
    receiver_refused("name = \"left\"", 26, "", "does not say where", "position = [x, y, z] in metres");
    receiver_refused("position = [0, 7.5]", 27, ".position", "has 2 values", "write 3 values");
    receiver_refused("position = [0, 7.5, -1.2]", 27, ".position", "below the road", "0 or more");
    receiver_refused("position = [0.1, 0, 0.3]", 27, ".position", "inside the tyre", "reaches 0.12 m");
    receiver_refused("position = [0, nan, 1]", 27, ".position[1]", "NaN", "at least -10000");
    receiver_refused("position = [0, 7.5, 1.2]\nradius = 2", 28, ".radius", "position", "leave this out");
    receiver_refused("position = [0, 7, 1]\nstandard = \"cpx\"", 28, ".standard", "`position` is given", "one of");
    receiver_refused("posision = [0, 7.5, 1.2]", 27, ".posision", "not a key of [[receiver]]", "`position`");
}

#[test]
fn names_of_receivers() {
    const HERE: &str = "standard = \"cpx\"\nname";
    let long = "x".repeat(300);
    receiver_refused(&format!("{HERE} = \"{long}\""), 28, ".name", "has 300 letters", "at most 80 letters");
    receiver_refused(&format!("{HERE} = \"=1+1\""), 28, ".name", "for a formula", "does not begin with =");
    receiver_refused(&format!("{HERE} = \"a\\u001b[31m\""), 28, ".name", "U+001B", "without control characters");
    let two = |other: &str| format!("{HERE} = \"x\"\n[[receiver]]\n{HERE} = \"{other}\"");
    sound_refused(
        &format!("[[receiver]]\n{}", two("x")),
        31,
        "receiver[1].name",
        "is the name of receiver[0]",
        "leave",
    );
    accepted("[outputs]", &format!("[[receiver]]\n{}\n[outputs]", two("X")));
}

#[test]
fn a_distance_in_millimetres_is_hardly_meant() {
    let beside = "standard = \"coast-by\"";
    receiver_refused(&format!("{beside}\ndistance = 7500"), 28, ".distance", "7500 m is implausible", "another unit");
    receiver_refused(&format!("{beside}\nheight = 1200"), 28, ".height", "1200 m is implausible", "another unit");
    receiver_refused("position = [0, 500, 1.2]", 27, ".position[1]", "from 1e-9 to 100 m is plausible", "another unit");
    receiver_refused("position = [0, 7500, 1.2]", 27, ".position[1]", "7500 m is implausible", "another unit");
}

#[test]
fn standards() {
    receiver_refused("standard = \"coastby\"", 27, ".standard", "\"coastby\" is not known", "coast-by");
    receiver_refused("standard = \"circle\"\nradius = 1", 26, ".height", "is missing", "below 10000 m");
    receiver_refused("standard = \"cpx\"\nradius = 1", 28, ".radius", "cpx", "leave this out");
    receiver_refused("standard = \"hemisphere\"\nradius = 0", 28, ".radius", "0", "above 0");
    let scene = accepted("[outputs]", "[[receiver]]\nstandard = \"coast-by\"\nheight = 1.5\n[outputs]");
    let place = StandardReceiver::CoastBy { distance: 7.5, height: 1.5, vehicle: None, passage: None };
    assert_eq!(scene.receivers[0].place, ReceiverPlace::Standard(place));
    receiver_refused("standard = \"coast-by\"\npassage = 19", 28, ".passage", "19", "at least 20");
    receiver_refused("standard = \"cpx\"\npassage = 40", 28, ".passage", "cpx", "leave this out");
}

#[test]
fn vehicles() {
    const BESIDE: &str = "standard = \"coast-by\"\nvehicle";
    let vehicle_refused = |value: &str, key: &str, wrong: &str, right: &str| {
        receiver_refused(&format!("{BESIDE} = {value}"), 28, &format!(".vehicle{key}"), wrong, right);
    };
    vehicle_refused("{ weelbase = 2.5 }", ".weelbase", "not a key of the vehicle", "did you mean `wheelbase`?");
    vehicle_refused("{ wheelbase = -1 }", ".wheelbase", "-1", "at least 0 and at most 20 m");
    vehicle_refused("4", "", "the whole number 4 is not allowed here", "{ wheelbase = 2.7, track = 1.55 }");
    vehicle_refused("{ track = 0.1 }", "", "overlap with a track of 0.1 m", "above 0.");
    vehicle_refused("{ track = 1.5 }\ndistance = 0.8", "", "reach as far as the microphone, 0.8 m", "below 1.");
    for standard in ["standard = \"cpx\"", "standard = \"hemisphere\"\nradius = 3", "position = [0, 7.5, 1.2]"] {
        let line = 27 + standard.lines().count();
        receiver_refused(&format!("{standard}\nvehicle = {{}}"), line, ".vehicle", "", "leave this out");
    }
    for (value, expected) in [
        ("{}", Vehicle { wheelbase: 2.7, track: 1.55 }),
        ("{ wheelbase = 0 }", Vehicle { wheelbase: 0.0, track: 1.55 }),
        ("{ wheelbase = 5.5, track = 2.0 }", Vehicle { wheelbase: 5.5, track: 2.0 }),
    ] {
        let scene = accepted("[outputs]", &format!("[[receiver]]\n{BESIDE} = {value}\n[outputs]"));
        let place = StandardReceiver::CoastBy { distance: 7.5, height: 1.2, vehicle: Some(expected), passage: None };
        assert_eq!(scene.receivers[0].place, ReceiverPlace::Standard(place));
    }
}

#[test]
fn a_draft_is_refused_where_its_error_is_not_known() {
    const DRAFT: &str = "[radiation]\nquality = \"draft\"";
    let place_refused = |keys: &str, key: &str| {
        let (line, full) = (27 + keys.lines().position(|line| line.starts_with(key)).unwrap(), "quality = \"full\"");
        sound_refused(&format!("[[receiver]]\n{keys}\n{DRAFT}"), line, &format!("receiver[0].{key}"), "draft", full);
    };
    place_refused("position = [0.0, 1.0, 0.9]", "position");
    place_refused("position = [0.1, 0.2, 0.05]", "position");
    place_refused("standard = \"hemisphere\"\nradius = 3", "standard");
    place_refused("standard = \"circle\"\nradius = 2\nheight = 1.5", "height");
    place_refused("standard = \"coast-by\"\ndistance = 2", "standard");
    for place in ["position = [1.0, 0.0, 0.2]", "standard = \"circle\"\nradius = 2\nheight = 0.3", "standard = \"cpx\""]
    {
        accepted("[outputs]", &format!("[[receiver]]\n{place}\n{DRAFT}\n[outputs]"));
    }
    let cpx = "[[receiver]]\nstandard = \"cpx\"";
    sound_refused(&format!("{cpx}\n{DRAFT}\nfmax = 4e3"), 30, "radiation.fmax", "above 25", "at most 25");
    sound_refused(&format!("{cpx}\n{DRAFT}\nshoulder = 0.1"), 29, "radiation.quality", "0.400 m wide", "from 0.15");
}

#[test]
fn ways() {
    const HERE: &str = "[[receiver]]\nstandard = \"cpx\"\n";
    let refused_at = |keys: &str, key: &str, wrong: &str, right: &str| {
        sound_refused(&format!("{HERE}[radiation]\n{keys}"), 29, &format!("radiation.{key}"), wrong, right);
    };
    refused_at("fmax = 0", "fmax", "0", "at least 50");
    refused_at("air = \"axel\"", "air", "\"axel\" is not known", "did you mean \"axle\"?");
    refused_at("frequency_tolerance = 0.1", "frequency_tolerance", "is not allowed here", "in quotes");
    refused_at("shoulder = 0.2", "shoulder", "0.2", "half of the tyre's radius");
    refused_at("shoulder = 1e-17", "shoulder", "implausible: from 0.001 to 1 m", "allow_implausible");
    refused_at("patch_length = 0.5", "patch_length", "0.5", "the tyre's radius");
    refused_at("quality = \"drafty\"", "quality", "\"drafty\" is not known", "did you mean \"draft\"?");
    refused_at("acoustic_gap = 0.001\nquality = \"draft\"", "acoustic_gap", "sealed patch", "quality = \"full\"");
    let nodes = "nodes_per_wavelength = 7.0\nquality = \"draft\"";
    refused_at(nodes, "nodes_per_wavelength", "no equations", "quality = \"full\"");
    refused_at("sides = \"on\"", "sides", "do not move", "sidewall = {");
    refused_at("receivers = 1", "receivers", "not a key of [radiation]", "fmax");
    let no_receiver = "there is no [[receiver]]";
    sound_refused("[radiation]\nfmax = 1000", 26, "radiation", no_receiver, "add a [[receiver]]");
    sound_refused("[effects]\nradiation = \"on\"", 27, "effects.radiation", no_receiver, "position = [x, y, z]");
    sound_refused(&format!("{HERE}[effects]\nradiation = \"off\""), 26, "receiver", "switches off", "\"auto\"");
    let scene = accepted("[outputs]", &format!("{HERE}[radiation]\nair = \"with-tread\"\n[outputs]"));
    assert_eq!(scene.radiation.air, AirMotion::WithTread);
    assert!(!scene.radiation.hears_sides(&scene.tyre), "springs do not radiate");
}

#[test]
fn moving_sidewalls_radiate_unless_off_or_in_a_draft() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/tyres/car.toml");
    let receiver = "{ standard = \"cpx\" }";
    for (settings, expected) in [
        (&[][..], Some(true)),
        (&["radiation.sides=on"], Some(true)),
        (&["radiation.sides=off"], Some(false)),
        (&["radiation.quality=draft"], Some(false)),
        (&["radiation.quality=draft", "radiation.sides=on"], None),
        (&["radiation.sides=on", "tyre.sides=supported"], None),
    ] {
        let receiver = format!("receiver=[{receiver}]");
        let settings = std::iter::once(receiver.as_str()).chain(settings.iter().copied());
        let settings: Vec<Setting> = settings.map(|setting| Setting::parse(setting).unwrap()).collect();
        let found = Scene::with_tyre(path, &settings).map(|loaded| loaded.scene);
        let hears = found.as_ref().ok().map(|scene| scene.radiation.hears_sides(&scene.tyre));
        assert_eq!(hears, expected, "{settings:?}: {:?}", found.err().map(|error| error.problem()));
    }
}
