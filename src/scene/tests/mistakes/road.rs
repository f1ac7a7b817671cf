//! Mistakes in the road.

use super::{accepted, road_refused};

#[test]
fn made_roads() {
    let made = |keys: &str| format!("kind = \"made\"\n{keys}");
    road_refused("kind = \"mad\"\nseed = 1", 17, "road.kind", "\"mad\"", "did you mean \"made\"?");
    road_refused(
        &made("file = \"a\""),
        18,
        "road.file",
        "not a key of a made road",
        "known keys: kind, seed, wavelengths",
    );
    road_refused(&made("seed = -1"), 18, "road.seed", "-1 is too small", "at least 0");
    road_refused(&made("wavelengths = [0.1]"), 16, "road.levels", "missing", "one third-octave level for each");
    road_refused(&made("levels = [40]"), 16, "road.wavelengths", "missing", "mid-wavelength");
    road_refused(
        &made("wavelengths = [0.1, 0.08]\nlevels = [40]"),
        19,
        "road.levels",
        "this has 1 values, `wavelengths` has 2",
        "as many values",
    );
    road_refused(&made("wavelengths = []\nlevels = [1]"), 18, "road.wavelengths", "empty", "an array");
    road_refused(
        &made("wavelengths = [0.1, 0.1]\nlevels = [1, 2]"),
        18,
        "road.wavelengths[1]",
        "0.1 after 0.1 breaks the order",
        "each one once",
    );
    road_refused(
        &made("wavelengths = [0.1, 0.05, 0.06, 0.02]\nlevels = [1, 2, 3, 4]"),
        18,
        "road.wavelengths[2]",
        "0.06 after 0.05",
        "from short to long or from long to short",
    );
    road_refused(
        &made("wavelengths = [0.1, -0.05]\nlevels = [1, 2]"),
        18,
        "road.wavelengths[1]",
        "-0.05 is out",
        "above 0 m",
    );
    road_refused(&made("wavelengths = [0.1, 0.05]\nlevels = [1, nan]"), 19, "road.levels[1]", "NaN", "dB re 1e-6 m");
    road_refused(
        &made("wavelengths = [0.1, 0.05]\nlevels = [1, 400]"),
        19,
        "road.levels[1]",
        "400 is out",
        "at most 120 dB",
    );
    road_refused(
        &made("wavelengths = [0.1, 0.002]\nlevels = [1, 2]"),
        18,
        "road.wavelengths[1]",
        "a wavelength of 0.002 m needs a finer lattice than 0.001 m",
        "spacing to at most 0.00089",
    );
    road_refused(&made("spacing = 0.003"), 18, "road.spacing", "a wavelength of 0.004 m", "at most 0.00178");
    road_refused(&made("spacing = 0"), 18, "road.spacing", "0 is out", "above 0 m");
    road_refused(
        &made(
            "levels = [1]\nwavelengths = [0.1]\n\
             power_law = { rms = 1e-3, exponent = 2, longest = 0.1, shortest = 0.01 }",
        ),
        20,
        "road.power_law",
        "`levels` exclude",
        "either this or `levels`",
    );
    road_refused(
        &made("power_law = { rms = 1e-3, exponent = 2, longest = 0.1, shortest = 0.1 }"),
        18,
        "road.power_law.shortest",
        "0.1 m is not below the longest wavelength",
        "less than 0.1 m",
    );
    road_refused(
        &made("power_law = { rms = 1e-3, exponent = 2, longest = 0.1, shortest = 0.001 }"),
        18,
        "road.power_law.shortest",
        "finer lattice",
        "at most 0.0005 m",
    );
    road_refused(
        &made("power_law = { rms = -1e-3, exponent = 2, longest = 0.1, shortest = 0.01 }"),
        18,
        "road.power_law.rms",
        "-0.001",
        "above 0 m",
    );
    road_refused(
        &made("power_law = { rms = 1e-3, exponent = 50, longest = 0.1, shortest = 0.01 }"),
        18,
        "road.power_law.exponent",
        "50",
        "at most 10",
    );
    accepted("kind = \"smooth\"", &made("wavelengths = [0.01, 0.1]\nlevels = [1, 2]"));
    road_refused(&made("texture = \"sma8\""), 18, "road.texture", "\"sma8\"", "did you mean \"sma-8\"?");
    for (other, found) in [
        ("levels = [1]\nwavelengths = [0.1]", "wavelengths"),
        ("levels = [1]", "levels"),
        ("power_law = { rms = 1e-3, exponent = 2, longest = 0.1, shortest = 0.01 }", "power_law"),
    ] {
        let wrong = format!("`{found}` exclude");
        road_refused(&made(&format!("texture = \"sma-8\"\n{other}")), 18, "road.texture", &wrong, "either this or");
    }
    accepted("kind = \"smooth\"", &made("texture = \"chip-seal\""));
    accepted("kind = \"smooth\"", &made("power_law = { rms = 1e-3, exponent = 2, longest = 0.1, shortest = 0.002 }"));
    accepted("kind = \"smooth\"", &made(""));
}

#[test]
fn measured_roads() {
    let profile = |keys: &str| format!("kind = \"profile\"\nfile = \"road.csv\"\n{keys}");
    road_refused("kind = \"profile\"", 16, "road.file", "missing", "the path of a file, relative to the scene");
    road_refused("kind = \"profile\"\nfile = \"\"", 18, "road.file", "empty", "the path of a file");
    road_refused("kind = \"profile\"\nfile = 3", 18, "road.file", "number 3", "the path of a file");
    road_refused(
        &profile("distance_unit = \"yd\""),
        19,
        "road.distance_unit",
        "\"yd\"",
        "accepted: \"m\", \"mm\", \"um\"",
    );
    road_refused(&profile("columns = [1, 0]"), 19, "road.columns[1]", "0 is too small", "at least 1");
    road_refused(&profile("columns = [\"\", 2]"), 19, "road.columns[0]", "empty", "its number from 1");
    road_refused(&profile("columns = 1.5"), 19, "road.columns", "number 1.5", "its number from 1");
    for old in ["distance_column = 1", "height_column = \"z\""] {
        let key = format!("road.{}", old.split(' ').next().unwrap());
        road_refused(&profile(old), 19, &key, "`road.columns` now", "columns = [");
    }
    road_refused(
        &profile("range = [2.0, 1.0]"),
        19,
        "road.range",
        "2 m is not below the end of the range, 1 m",
        "less than 1 m",
    );
    road_refused(&profile("range = [0, 1, 2]"), 19, "road.range", "3 values", "2 values");
    road_refused(&profile("lateral = \"flat\""), 19, "road.lateral", "\"flat\"", "\"extruded\", \"isotropic\"");
    road_refused(&profile("at_end = \"loop\""), 19, "road.at_end", "\"loop\"", "\"refuse\", \"repeat\", \"mirror\"");
    road_refused(
        "kind = \"opencrg\"\nfile = \"a.crg\"\nlongest_wavelength = 0",
        19,
        "road.longest_wavelength",
        "0 is out",
        "above 0 m",
    );
    road_refused(
        "kind = \"opencrg\"\nfile = \"a.crg\"\nlateral_position = inf",
        19,
        "road.lateral_position",
        "inf",
        "finite",
    );
    road_refused("kind = \"grid\"\nfile = \"a.npy\"\ndx = 0.01", 16, "road.dy", "missing", "above 0 m");
    road_refused("kind = \"grid\"\nfile = \"a.npy\"\ndx = 0.01\ndy = -1", 20, "road.dy", "-1", "above 0 m");
    road_refused("kind = \"open-crg\"\nfile = \"a.npy\"", 17, "road.kind", "\"open-crg\"", "did you mean \"opencrg\"?");
    let text = |keys: &str| format!("kind = \"grid\"\nfile = \"a.xyz\"\n{keys}");
    road_refused(&text("dx = 0.01"), 19, "road.dx", "does not apply with a grid of text", "leave this out");
    road_refused(&text("widen = \"copy\""), 19, "road.widen", "\"copy\"", "\"refuse\", \"mirror\"");
    accepted("kind = \"smooth\"", &text("distance_unit = \"mm\"\nheight_unit = \"um\"\ncolumns = [1, 2, 3]"));
    accepted("kind = \"smooth\"", &profile("columns = [\"x\", 2]\nseed = 3"));
}
