//! Sound of short runs: levels and files, the same bytes whatever was cached and on how many threads, a pass-by
//! measured.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use tyrewave::internals::{edit, full_scale_of, implausible, scene, scene_text, with_all_terms, without};

use crate::common::{command, read_summary, run};

const MODAL: &str = "history = \"modal\"\npole_tolerance = 1e-4";
/// Low frequencies alone: boundary elements of a second.
const LOW: &str = "[radiation]\nfmax = 300.0\nnodes_per_wavelength = 5.0\nfrequency_tolerance = \"0.5 dB\"";

fn rolling(duration: f64) -> String {
    format!("speed_kmh = 80.0\nwarm_up = 0.3\nduration = {duration:?}\naxle = {{ load = 3000.0 }}")
}

/// The program with a separate cache in the folder.
fn program(folder: &Path, arguments: &[&str]) -> Output {
    let output = command(folder, arguments).env("TYREWAVE_CACHE_DIR", folder.join("cache")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

#[test]
fn cold_and_warm_on_one_thread_and_on_two_are_the_same_bytes() {
    let receivers = "[[receiver]]\nname = \"beside\"\nposition = [0.0, 3.0, 1.2]\n[[receiver]]\nstandard = \"cpx\"\n\
                     [[receiver]]\nstandard = \"hemisphere\"\nradius = 3.0";
    let text = scene_text(128, "kind = \"made\"\nseed = 4", &rolling(1.2), MODAL, &format!("{receivers}\n{LOW}"));
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("loud.toml"), text).unwrap();
    let reported = program(folder.path(), &["run", "loud.toml", "--out", "cold", "--threads", "1"]);
    let reported = String::from_utf8_lossy(&reported.stdout).into_owned();
    assert!(reported.contains("cpx") && reported.contains("dB(A)") && reported.contains("sound power"), "{reported}");
    program(folder.path(), &["run", "loud.toml", "--out", "warm", "--threads", "2"]);
    let files = ["sound.csv", "sound_narrow.csv", "sound_beside.wav", "sound_cpx.wav", "sound_spectrum.svg"];
    for file in files {
        let [cold, warm] = ["cold", "warm"].map(|run| fs::read(folder.path().join(run).join(file)).unwrap());
        assert!(cold == warm, "{file} differs");
    }
    let [cold, warm] = ["cold", "warm"].map(|run| read_summary(&folder.path().join(run))["sound"].clone());
    let solved = |sound: &Value| sound["body"]["solved"].as_u64().unwrap();
    assert!(solved(&cold) > 3 && solved(&warm) == 0, "{} and {}", solved(&cold), solved(&warm));
    let level = |receiver: usize| cold["receivers"][receiver]["level"].as_f64().unwrap();
    // Closer is louder, and a smooth tyre's levels are not absurd.
    assert!(level(1) > level(0) + 6.0 && (40.0..120.0).contains(&level(1)), "{cold:#}");
    let power = cold["receivers"][2]["power_level_a"].as_f64().unwrap();
    // W = p^2/(rho c) 2 pi r^2 for the mean over the hemisphere; p_0^2/W_0 is 400 Pa s/m, rho c of air 413.
    let mean = cold["receivers"][2]["level_a"].as_f64().unwrap();
    assert!((power - mean - 10.0 * (TAU * 9.0 * 400.0 / 413.3).log10()).abs() < 0.01, "{power} {mean}");
    let wav = fs::read(folder.path().join("cold/sound_cpx.wav")).unwrap();
    assert_eq!(full_scale_of(&wav), cold["receivers"][1]["audio"]["full_scale"].as_f64());
    assert_eq!(hound::WavReader::new(wav.as_slice()).unwrap().spec().channels, 2);
    let listed = program(folder.path(), &["cache", "list"]);
    assert!(!String::from_utf8_lossy(&listed.stdout).contains("not usable"));
}

/// A washboard of 0.1 m, which makes a tone of V/0.1 m = 222.2 Hz.
fn washboard(folder: &Path) -> String {
    washboard_of(folder, 0.1)
}

/// A washboard of a wavelength \[m\].
fn washboard_of(folder: &Path, wavelength: f64) -> String {
    let rows = (0..40_000).map(|n| {
        let x = f64::from(n) * 0.005;
        format!("{x:.4},{:.9}\n", 2e-4 * (TAU * x / wavelength).sin())
    });
    fs::write(folder.join("washboard.csv"), format!("x,z\n{}", rows.collect::<String>())).unwrap();
    "kind = \"profile\"\nfile = \"washboard.csv\"\ndistance_unit = \"m\"\nheight_unit = \"m\"\n\
     at_end = \"repeat\"\nlateral = \"extruded\""
        .to_owned()
}

#[test]
fn four_tyres_far_away_are_6_db_louder_than_one() {
    let way = "[radiation]\nfmax = 300.0\nquality = \"draft\"";
    let beside = |name: &str, keys: &str| format!("[[receiver]]\nname = \"{name}\"\nstandard = \"coast-by\"\n{keys}\n");
    let vehicle = "vehicle = { wheelbase = 2.5, track = 1.5 }";
    let receivers = [
        beside("one", "distance = 300.0\npassage = 20"),
        beside("four", &format!("distance = 300.0\npassage = 20\n{vehicle}")),
        beside("left", "distance = 6.75\npassage = 32"),
        beside("right", "distance = 8.25\npassage = 32"),
        beside("near", &format!("passage = 32\n{vehicle}")),
    ];
    let folder = tempfile::tempdir().unwrap();
    let road = washboard(folder.path());
    for (name, duration, tyres) in [("long", 8.0, 4), ("short", 4.5, 1)] {
        let text = scene_text(128, &road, &rolling(duration), MODAL, &format!("{}{way}", receivers.concat()));
        // A microphone 300 m away.
        fs::write(folder.path().join(format!("{name}.toml")), implausible(&text)).unwrap();
        let reported = program(folder.path(), &["run", &format!("{name}.toml"), "--out", name]);
        let reported = String::from_utf8_lossy(&reported.stdout).into_owned();
        assert!(reported.contains("L_AFmax as the vehicle passes") && reported.contains("4 tyres"), "{reported}");
        let sound = read_summary(&folder.path().join(name))["sound"].clone();
        let number = |receiver: usize, pointer: &str| sound["receivers"][receiver].pointer(pointer).unwrap().as_f64();
        let [level, maximum] = ["/level", "/pass_by/maximum"]
            .map(|pointer| (0..5).map(|receiver| number(receiver, pointer).unwrap()).collect::<Vec<f64>>());
        // Four equal tyres as far away as each other, whenever sound arrives: the washboard sounds the same all along.
        for levels in [&level, &maximum] {
            let gain = levels[1] - levels[0];
            assert!((gain - 10.0 * 4.0_f64.log10()).abs() < 0.1, "{name}: {gain} dB");
        }
        // Two on the near side and two on the far one, each pair a separate line.
        let pairs = |levels: &[f64]| 10.0 * (10.0_f64.powf(0.1 * levels[2]) + 10.0_f64.powf(0.1 * levels[3])).log10();
        let apart = level[4] - pairs(&level) - 10.0 * 2.0_f64.log10();
        // Its lines are longer by half the wheelbase at either end.
        assert!((-0.4..0.0).contains(&apart), "{name}: {apart} dB");
        // A pair is loudest when both are 1.25 m from the microphone, a little less than one abreast.
        let apart = maximum[4] - pairs(&maximum) - 10.0 * 2.0_f64.log10();
        assert!((-0.8..0.0).contains(&apart), "{name}: {apart} dB at most");
        assert_eq!(sound["receivers"][1]["tyres"], 4);
        assert_eq!(sound["receivers"][1]["audio"]["tyres"], tyres);
        assert!(sound["receivers"][0].get("tyres").is_none() && sound["receivers"][0]["audio"].get("tyres").is_none());
        let table = fs::read_to_string(folder.path().join(name).join("pass_by_near.csv")).unwrap();
        let mut rows = table.lines();
        assert_eq!(rows.next(), Some("time_s,vehicle_ahead_of_microphone_m,level_db_a_fast"));
        let places: Vec<f64> = rows.map(|row| row.split(',').nth(1).unwrap().parse().unwrap()).collect();
        assert!((places[0] + 16.0).abs() < 0.01 && (places[places.len() - 1] - 16.0).abs() < 0.2, "{places:?}");
    }
}

#[test]
fn draft_pass_by_and_vehicle_depend_on_the_air_of_the_road() {
    // A washboard of 40 mm, a tone of 556 Hz, that the tread takes on and that stands on the road.
    let receivers = "[[receiver]]\nname = \"near\"\nstandard = \"cpx\"\n\
                     [[receiver]]\nname = \"one\"\nstandard = \"coast-by\"\n\
                     [[receiver]]\nname = \"four\"\nstandard = \"coast-by\"\nvehicle = {}\n";
    let folder = tempfile::tempdir().unwrap();
    let road = washboard_of(folder.path(), 0.04);
    let levels = |name: &str, air: &str| {
        let way = format!("[radiation]\nfmax = 700.0\nquality = \"draft\"\naudio = false\n{air}");
        let text = scene_text(256, &road, &rolling(3.0), MODAL, &format!("{receivers}{way}"));
        fs::write(folder.path().join(format!("{name}.toml")), text).unwrap();
        program(folder.path(), &["run", &format!("{name}.toml"), "--out", name]);
        let sound = read_summary(&folder.path().join(name))["sound"].clone();
        let number = |pointer: &str| sound.pointer(pointer).unwrap().as_f64().unwrap();
        ["/receivers/0/level", "/receivers/1/level", "/receivers/1/pass_by/maximum", "/receivers/2/pass_by/maximum"]
            .map(number)
    };
    // The air stands on the road unless the scene says otherwise.
    let road = levels("road", "");
    let [axle, with_tread] = [levels("axle", "air = \"axle\""), levels("with-tread", "air = \"with-tread\"")];
    println!("axle {axle:.2?}, road {road:.2?}, with-tread {with_tread:.2?} dB");
    for ((axle, road), with_tread) in axle.into_iter().zip(road).zip(with_tread) {
        assert!(axle - road > 2.0 && (road - with_tread).abs() < 0.5, "{axle}, {road}, {with_tread} dB");
    }
}

#[test]
fn a_pass_by_has_the_doppler_ratio_of_its_speed() {
    let folder = tempfile::tempdir().unwrap();
    let receiver = "[[receiver]]\nstandard = \"coast-by\"";
    let text = scene_text(128, &washboard(folder.path()), &rolling(3.0), MODAL, &format!("{receiver}\n{LOW}"));
    fs::write(folder.path().join("tone.toml"), text).unwrap();
    program(folder.path(), &["run", "tone.toml", "--out", "tone"]);
    let wav = fs::read(folder.path().join("tone/sound_coast-by.wav")).unwrap();
    let scale = full_scale_of(&wav).unwrap();
    let samples = hound::WavReader::new(wav.as_slice()).unwrap().into_samples::<i32>();
    let pressure: Vec<f64> = samples.map(|sample| scale * f64::from(sample.unwrap()) / 8_388_608.0).collect();
    let (speed, sound_speed, tone) = (80.0 / 3.6, 343.2, 80.0 / 3.6 / 0.1);
    // The file is as long as the passage, which ends at three times the least distance.
    let half = 3.0 * 7.5_f64.hypot(1.2);
    assert!((pressure.len() as f64 / 48_000.0 - 2.0 * half / speed).abs() < 0.001, "{} samples", pressure.len());
    for x in [9.0_f64, -9.0] {
        // The microphone is at x in the tyre's frame (half - x)/V after the first sample.
        let centre = ((half - x) / speed * 48_000.0) as usize;
        let found = peak_frequency(&pressure[centre - 4000..centre + 4000], tone);
        let mach = speed / sound_speed;
        let aside_squared = 7.5_f64.powi(2) + 1.2_f64.powi(2);
        let shortened = (x * x + (1.0 - mach * mach) * aside_squared).sqrt();
        let ratio = (shortened + mach * x) / (1.0 - mach * mach) / shortened;
        assert!((found / tone / ratio - 1.0).abs() < 0.004, "at {x} m: {found} Hz, {} expected", ratio * tone);
    }
    // The level that the summary states is that of the table.
    let table = fs::read_to_string(folder.path().join("tone/pass_by_coast-by.csv")).unwrap();
    let levels = table.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse::<f64>().unwrap());
    let levels: Vec<f64> = levels.collect();
    let highest = levels.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // The detector has settled where the curve begins: from silence it would rise by 10 dB in the first 13 ms. The
    // tread ahead of the patch radiates this tone forwards: it rises by 5.4 dB and falls by 12.
    assert!((levels[4] - levels[0]).abs() < 1.0 && levels[0] < highest - 5.0, "{levels:?}");
    assert!(levels[levels.len() - 1] < highest - 10.0, "{levels:?}");
    let reported = &read_summary(&folder.path().join("tone"))["sound"]["receivers"][0]["pass_by"];
    assert!((reported["maximum"].as_f64().unwrap() - highest).abs() < 1.0, "{reported} {highest}");
}

#[test]
fn a_draft_solves_nothing_and_states_its_error() {
    let way = "[radiation]\nfmax = 300.0\nquality = \"draft\"";
    let numerics = format!("{MODAL}\ntime_rule = \"bdf2\"");
    let receiver = "[[receiver]]\nstandard = \"cpx\"\n";
    let text = scene_text(64, "kind = \"made\"\nseed = 4", &rolling(0.9), &numerics, receiver);
    let folder = tempfile::tempdir().unwrap();
    for (name, way) in [("draft", way), ("full", LOW)] {
        // So many elements that the run has valid bands for which the draft's error is stated.
        let bearing = "[contact]\nlargest_slice_error = \"60 dB\"";
        let text = edit(&format!("{text}\n{way}\n{bearing}\n"), &[("numerics.elements", "256")]);
        fs::write(folder.path().join(format!("{name}.toml")), text).unwrap();
        program(folder.path(), &["run", &format!("{name}.toml"), "--out", name]);
    }
    let [draft, full] = ["draft", "full"].map(|run| read_summary(&folder.path().join(run))["sound"].clone());
    assert_eq!((&draft["body"]["quality"], draft["body"]["solved"].as_u64()), (&"draft".into(), Some(0)));
    let number = |sound: &Value, pointer: &str| sound.pointer(pointer).unwrap().as_f64().unwrap();
    let [rough, fine] = [&draft, &full].map(|sound| number(sound, "/error/way"));
    // So coarse a mesh is no better than the draft, and says so.
    assert!(rough > 1.0 && fine > 1.0 && draft["error"]["forces"].is_null(), "{rough} {fine}");
    let apart = number(&draft, "/receivers/0/level") - number(&full, "/receivers/0/level");
    assert!(apart.abs() < 3.0 && apart.abs() > 1e-6, "{apart} dB between the qualities");
    let table = fs::read_to_string(folder.path().join("draft/sound.csv")).unwrap();
    assert!(table.lines().next().unwrap().ends_with("valid,error_db,slice_error_db,standard_error_db"), "{table}");
    fs::write(folder.path().join("coarse.toml"), format!("{text}\n{way}\n")).unwrap();
    let reported = program(folder.path(), &["effects", "coarse.toml", "--out", "effects", "--duration", "0.9"]);
    let reported = String::from_utf8_lossy(&reported.stdout).into_owned();
    for row in ["+ radiation", "- radiation", "silent", "air with the axle", "air with the tread"] {
        assert!(reported.contains(row), "{row} is missing\n{reported}");
    }
    let table = fs::read_to_string(folder.path().join("effects/effects.csv")).unwrap();
    assert!(
        table.lines().next().unwrap().ends_with("level_db_a_cpx,level_error_db_cpx,highest_hz_cpx,lower_bound_cpx"),
        "{table}"
    );
}

/// Third octaves of a run at a receiver: nominal frequency \[Hz\], level \[dB\], whether it is valid, and its error.
fn bands(folder: &Path) -> Vec<(f64, f64, bool, String)> {
    let table = fs::read_to_string(folder.join("sound.csv")).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[1].parse().unwrap(), cells[3].parse().unwrap(), cells[5] == "1", cells[6].to_owned())
    };
    table.lines().skip(1).map(row).collect()
}

/// Level of a third octave of a signal at 48 kHz \[dB\]: one transform of all of it, faded in and out.
fn level_between(signal: &[f64], band: std::ops::Range<f64>) -> f64 {
    let fade = |n: usize| {
        let part = (n.min(signal.len() - 1 - n) as f64 / 12_000.0).min(1.0);
        (0.5 * std::f64::consts::PI * part).sin().powi(2)
    };
    let mut series: Vec<f64> = signal.iter().enumerate().map(|(n, value)| fade(n) * value).collect();
    let weight: f64 = (0..signal.len()).map(|n| fade(n).powi(2)).sum();
    let transform = realfft::RealFftPlanner::new().plan_fft_forward(signal.len());
    let mut lines = transform.make_output_vec();
    transform.process(&mut series, &mut lines).unwrap();
    let frequency = |line: usize| line as f64 * 48_000.0 / signal.len() as f64;
    let inside = (0..lines.len()).filter(|&line| band.contains(&frequency(line)));
    let power = inside.map(|line| 2.0 * lines[line].norm_sqr()).sum::<f64>() / signal.len() as f64 / weight;
    10.0 * (power / 4e-10).log10()
}

fn pressures(path: &Path) -> Vec<f64> {
    let wav = fs::read(path).unwrap();
    let scale = full_scale_of(&wav).unwrap();
    let samples = hound::WavReader::new(wav.as_slice()).unwrap().into_samples::<i32>();
    samples.map(|sample| scale * f64::from(sample.unwrap()) / 8_388_608.0).collect()
}

#[test]
fn levels_and_sound_file_agree_in_every_valid_band() {
    let receiver = "[[receiver]]\nname = \"near\"\nposition = [0.2, 0.4, 0.1]\n[radiation]\nquality = \"draft\"";
    let text = scene_text(256, "kind = \"made\"\nseed = 4", &rolling(6.0), MODAL, &format!("{receiver}\nfmax = 800.0"));
    let folder = tempfile::tempdir().unwrap();
    let [wide, narrow] = ["800.0", "200.0"].map(|fmax| {
        fs::write(folder.path().join("scene.toml"), edit(&text, &[("radiation.fmax", fmax)])).unwrap();
        program(folder.path(), &["run", "scene.toml", "--out", fmax]);
        let run = folder.path().join(fmax);
        let (bands, pressure) = (bands(&run), pressures(&run.join("sound_near.wav")));
        for (nominal, level, valid, error) in &bands {
            assert!(error.is_empty(), "{nominal} Hz: {error} dB, but no preset states that of the forces");
            let band = tyrewave::response::ThirdOctaveBand::containing(*nominal).unwrap();
            let found = level_between(&pressure, band.lower_edge()..band.upper_edge());
            if *valid {
                assert!((found - level).abs() < 0.3, "fmax {fmax}, {nominal} Hz: {level} dB, file {found} dB");
            } else if band.lower_edge() > 1.2 * fmax.parse::<f64>().unwrap() {
                // Nothing that is not in the level is in the file.
                let loudest = bands.iter().map(|band| band.1).fold(f64::NEG_INFINITY, f64::max);
                assert!(found < loudest - 60.0, "fmax {fmax}, {nominal} Hz: {found} of {loudest} dB");
            }
        }
        let receiver = read_summary(&run)["sound"]["receivers"][0].clone();
        (bands, receiver)
    });
    let valid = |bands: &[(f64, f64, bool, String)]| bands.iter().filter(|band| band.2).count();
    assert!(valid(&narrow.0) == 9 && valid(&wide.0) >= 12, "25 to 160 Hz, and more");
    for (one, other) in wide.0.iter().zip(&narrow.0).filter(|(_, other)| other.2) {
        assert!((one.1 - other.1).abs() < 0.3, "{} Hz: {} and {} dB", one.0, one.1, other.1);
    }
    // The level of a part of the bands says so.
    let reported = &narrow.1["bands"];
    assert_eq!((reported["lowest"].as_f64(), reported["highest"].as_f64()), (Some(25.0), Some(160.0)));
    assert_eq!(reported["lower_bound"], true, "{reported}");
    assert!(narrow.1["level_a"].as_f64() < wide.1["level_a"].as_f64());
}

#[test]
fn an_error_that_no_preset_states_is_not_known() {
    let folder = tempfile::tempdir().unwrap();
    let receiver = "[[receiver]]\nstandard = \"cpx\"\n[radiation]\nquality = \"draft\"\nfmax = 400.0\naudio = false";
    let text = scene_text(512, &washboard(folder.path()), &rolling(1.2), MODAL, receiver);
    let text = with_all_terms(&text);
    fs::write(folder.path().join("scene.toml"), text).unwrap();
    let reported = |name: &str, settings: &[&str]| {
        let mut arguments = vec!["run", "scene.toml", "--out", name];
        arguments.extend(settings.iter().flat_map(|setting| ["--set", setting]));
        let reported = program(folder.path(), &arguments);
        let receiver = read_summary(&folder.path().join(name))["sound"]["receivers"][0].clone();
        let errors: Vec<f64> = bands(&folder.path().join(name)).iter().filter_map(|band| band.3.parse().ok()).collect();
        (String::from_utf8_lossy(&reported.stdout).replace('\n', " "), receiver, errors)
    };
    let (words, receiver, errors) = reported("no-preset", &[]);
    assert!(words.contains("numerical error not known: take a preset, or `tyrewave study`"), "{words}");
    assert!(receiver["level_a_error"].is_null() && errors.is_empty(), "{receiver} {errors:?}");
    // With a preset it is that of the forces, 1 dB, and that of the draft: 3.5 dB, and 0.01 of waves left out.
    let preset = ["numerics.preset=standard", "numerics.fmax=400"];
    let (words, receiver, errors) = reported("preset", &preset);
    let error = receiver["level_a_error"].as_f64().unwrap();
    assert!((error - 4.51).abs() < 0.005 && words.contains(&format!(" +- {error:.1} dB(A)")), "{words} {receiver}");
    assert!(!errors.is_empty() && errors.iter().all(|error| *error > 2.0), "{errors:?}");
    // Elements set in the scene that are longer than the preset's.
    let (words, receiver, errors) = reported("coarse", &[&preset[..], &["numerics.elements=256"]].concat());
    assert!(words.contains("numerics.elements is coarser than that of the preset"), "{words}");
    assert!(receiver["level_a_error"].is_null() && errors.is_empty(), "{receiver} {errors:?}");
}

#[test]
fn files_to_listen_to_of_one_sweep_have_one_full_scale() {
    let receivers = "[[receiver]]\nname = \"near\"\nposition = [0.2, 0.4, 0.1]\n[[receiver]]\nname = \"far\"\n\
                     position = [0.0, 7.5, 1.2]\n[radiation]\nquality = \"draft\"\nfmax = 300.0";
    let text = scene_text(64, "kind = \"made\"\nseed = 4", &rolling(0.9), MODAL, receivers);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), text).unwrap();
    program(folder.path(), &["sweep", "scene.toml", "--speed", "30,130", "--out", "both"]);
    let scales = |run: &Path| {
        let summary = read_summary(run);
        ["near", "far"]
            .into_iter()
            .enumerate()
            .map(move |(receiver, name)| {
                let reported = summary["sound"]["receivers"][receiver]["audio"]["full_scale"].as_f64().unwrap();
                let wav = fs::read(run.join(format!("sound_{name}.wav"))).unwrap();
                assert_eq!(full_scale_of(&wav), Some(reported), "{name}");
                reported
            })
            .collect::<Vec<f64>>()
    };
    let variants = fs::read_dir(folder.path().join("both")).unwrap().map(|entry| entry.unwrap().path());
    let found: Vec<f64> = variants.filter(|path| path.is_dir()).flat_map(|path| scales(&path)).collect();
    assert!(found.len() == 4 && found.iter().all(|scale| (scale / found[0] - 1.0).abs() < 1e-12), "{found:?}");
    // A scene may say it, too loud a sound or not.
    for (given, louder) in [("50", false), ("1e-4", true)] {
        let set = format!("radiation.full_scale={given}");
        program(folder.path(), &["run", "scene.toml", "--set", &set, "--out", given]);
        let audio = read_summary(&folder.path().join(given))["sound"]["receivers"][0]["audio"].clone();
        assert_eq!(audio["full_scale"].as_f64(), given.parse().ok());
        assert_eq!(audio.get("louder").is_some(), louder, "{audio}");
    }
}

#[test]
fn a_run_too_short_for_a_passage_says_how_long_it_must_be() {
    let receiver =
        "[[receiver]]\nstandard = \"coast-by\"\npassage = 20\n[radiation]\nquality = \"draft\"\nfmax = 300.0";
    let text = |duration: f64| scene_text(64, "kind = \"made\"\nseed = 4", &rolling(duration), MODAL, receiver);
    let needed = |text: &str| {
        let reported = text.split("rolling.duration of ").nth(1).unwrap();
        reported.split(' ').next().unwrap().parse::<f64>().unwrap()
    };
    let short = run(&text(0.1));
    let most = needed(&short.report.summary.warnings.join("\n"));
    let longer = run(&text(1.0));
    let receiver = longer.summary()["sound"]["receivers"][0].clone();
    let least = needed(receiver["no_pass_by"].as_str().unwrap());
    assert!(least <= most && most < least + 0.6, "{least} and {most} s");
    let enough = run(&text(least)).summary()["sound"]["receivers"][0].clone();
    assert!(enough.get("no_pass_by").is_none() && enough["pass_by"]["passages"] == 1, "{enough}");
}

/// The frequency near `expected` at which a stretch of 48 kHz has most power.
fn peak_frequency(signal: &[f64], expected: f64) -> f64 {
    let power = |frequency: f64| {
        let step = TAU * frequency / 48_000.0;
        let window = |n: usize| (std::f64::consts::PI * n as f64 / signal.len() as f64).sin().powi(2);
        let parts = signal.iter().enumerate().map(|(n, p)| (p * window(n), step * n as f64));
        let (re, im) = parts.fold((0.0, 0.0), |(re, im), (p, turn)| (re + p * turn.cos(), im + p * turn.sin()));
        re * re + im * im
    };
    (0..400).map(|k| expected * (0.9 + 0.0005 * f64::from(k))).max_by(|a, b| power(*a).total_cmp(&power(*b))).unwrap()
}

#[test]
fn too_short_a_run_is_reported_and_no_receiver_no_sound() {
    let receiver = format!("[[receiver]]\nposition = [0.0, 3.0, 1.2]\n{LOW}");
    let text = scene_text(64, "kind = \"smooth\"", &rolling(0.1), MODAL, &receiver);
    let short = run(&text);
    assert!(short.report.summary.warnings.iter().any(|warning| warning.contains("too short for sound")));
    assert!(short.report.summary.sound.is_none() && !short.path("sound.csv").exists());
    let silent = run(&edit(&without(&text, &["receiver", "radiation"]), &[("rolling.duration", "0.1")]));
    assert!(silent.summary().get("sound").is_none());
    assert_eq!(scene(&text).scene.receivers.len(), 1);
}

/// AASHTO T 360: two probes at the edges of the patch, beside a microphone in the middle of the first.
#[test]
fn on_board_intensity_is_that_of_two_probes_at_the_patch() {
    let folder = tempfile::tempdir().unwrap();
    let receivers = "[[receiver]]\nstandard = \"obsi\"\n[[receiver]]\nstandard = \"cpx\"";
    let way = "[radiation]\nfmax = 800.0\nnodes_per_wavelength = 5.0\nfrequency_tolerance = \"0.5 dB\"\naudio = false\n\
               [contact]\nlargest_slice_error = \"60 dB\"";
    let text = scene_text(256, "kind = \"made\"\nseed = 4", &rolling(2.0), MODAL, &format!("{receivers}\n{way}"));
    fs::write(folder.path().join("probe.toml"), text).unwrap();
    program(folder.path(), &["run", "probe.toml", "--out", "out"]);
    let summary = read_summary(&folder.path().join("out"));
    let sound = &summary["sound"]["receivers"];
    let [obsi, cpx] = [0, 1].map(|receiver| &sound[receiver]);
    assert_eq!((obsi["name"].as_str(), obsi["points"].as_u64()), (Some("obsi"), Some(4)));
    assert!(cpx["intensity"].is_null() && obsi["audio"].is_null(), "{sound:#}");
    let intensity = &obsi["intensity"];
    let [leading, trailing] = ["leading", "trailing"].map(|probe| intensity["probes"][probe].as_f64().unwrap());
    let mean = 10.0 * (0.5 * (10.0_f64.powf(0.1 * leading) + 10.0_f64.powf(0.1 * trailing))).log10();
    assert!((intensity["level_a"].as_f64().unwrap() - mean).abs() < 1e-9, "{intensity:#}");
    assert_eq!(intensity["bands"]["lowest"], 400.0);
    assert_eq!(intensity["bands"]["lower_bound"], true, "it ends below 1 kHz");
    let table = fs::read_to_string(folder.path().join("out").join(intensity["file"].as_str().unwrap())).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    // 400 Hz to 5 kHz, as far as the time step holds them.
    assert!(rows.len() >= 2 * 6 && rows.iter().all(|row| row[0] == "leading" || row[0] == "trailing"), "{table}");
    let valid: Vec<&Vec<&str>> = rows.iter().filter(|row| row[6] == "1").collect();
    assert_eq!(valid.iter().map(|row| row[1]).collect::<Vec<_>>(), ["400", "500", "400", "500"]);
    for row in valid {
        // Power leaves the tyre, and no more of it than travelling waves of that pressure carry.
        let [watt, level, index]: [f64; 3] = [2, 3, 5].map(|column: usize| row[column].parse().unwrap());
        assert!(watt > 0.0 && (level - 10.0 * (watt / 1e-12).log10()).abs() < 1e-6, "{row:?}");
        assert!((-1.0..20.0).contains(&index), "{row:?}");
    }
}

#[test]
fn moving_sidewalls_sound_the_same_on_any_threads() {
    let tyre = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tyres/car.toml");
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        "tyre = '{}'\n[road]\nkind = \"made\"\nseed = 4\n[rolling]\nspeed_kmh = 80.0\nwarm_up = 0.3\nduration = 1.2\n\
         axle = {{ indentation = 0.012 }}\n[numerics]\nelements = 128\n{MODAL}\n[effects]\nrotation = \"off\"\n\
         [[receiver]]\nname = \"beside\"\nposition = [0.0, 3.0, 1.2]\n[[receiver]]\nstandard = \"cpx\"\n{LOW}\n",
        tyre.display()
    );
    fs::write(folder.path().join("loud.toml"), text).unwrap();
    let run = |out: &str, more: &[&str]| {
        let arguments = [&["run", "loud.toml", "--allow-outside", "--out", out][..], more].concat();
        program(folder.path(), &arguments);
        let summary = read_summary(&folder.path().join(out));
        let evaluations = summary["cost"]["counters"]["compliance_evaluations"].as_u64().unwrap_or(0);
        assert_eq!(evaluations == 0, out == "warm", "{out}: {evaluations}");
        summary["sound"].clone()
    };
    let cold = run("cold", &["--threads", "1"]);
    let planned = program(folder.path(), &["plan", "loud.toml", "--allow-outside"]);
    assert!(String::from_utf8_lossy(&planned.stdout).contains("sound of the sidewalls"));
    let silent = run("off", &["--threads", "2", "--set", "radiation.sides=off"]);
    let warm = run("warm", &["--threads", "2"]);
    let solved = |sound: &Value| sound["body"]["solved"].as_u64().unwrap();
    assert!(solved(&cold) > 3 && solved(&silent) > 3 && solved(&warm) == 0, "each has separate entries");
    for file in ["sound.csv", "sound_narrow.csv", "sound_cpx.wav"] {
        let [cold, warm, silent] =
            ["cold", "warm", "off"].map(|run| fs::read(folder.path().join(run).join(file)).unwrap());
        assert!(cold == warm && cold != silent, "{file}");
    }
    // Sidewalls move against the belt: the lowest bands, of a whole belt that moves, lose 1.7 to 2.0 dB by them.
    let [all, tread] = ["cold", "off"].map(|run| bands(&folder.path().join(run)));
    let changes = all.iter().zip(&tread).filter(|(all, _)| (63.0..=80.0).contains(&all.0));
    let changes: Vec<f64> = changes.map(|(all, tread)| all.1 - tread.1).collect();
    assert!(changes.len() == 4 && changes.iter().all(|change| (-2.5..-1.2).contains(change)), "{changes:?}");
}

#[test]
fn microphones_of_a_file_have_their_names_in_tables_and_sounds() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("array.csv"), "name,x,y,z\nnear left,0,2,0.5\nfar,0,4,0.5\n").unwrap();
    let way = "[[receiver]]\nfile = \"array.csv\"\n[radiation]\nfmax = 300.0\nquality = \"draft\"";
    let text = scene_text(64, "kind = \"made\"\nseed = 4", &rolling(1.2), MODAL, way);
    fs::write(folder.path().join("loud.toml"), text).unwrap();
    let planned = program(folder.path(), &["plan", "loud.toml"]);
    assert!(planned.status.success());
    program(folder.path(), &["run", "loud.toml", "--out", "run"]);
    let run = folder.path().join("run");
    let table = fs::read_to_string(run.join("sound.csv")).unwrap();
    for name in ["near left", "far"] {
        assert!(table.contains(&format!("\n{name},100,")), "{table}");
        assert!(run.join(format!("sound_{}.wav", name.replace(' ', "-"))).is_file());
    }
    let summary = read_summary(&run);
    let level = |receiver: usize| summary["sound"]["receivers"][receiver]["level"].as_f64().unwrap();
    assert!(level(0) > level(1), "{summary:#}");
    assert_eq!(summary["settings"]["receiver"][1]["position"][1].as_f64(), Some(4.0));
    // A report reads the run without the file.
    fs::remove_file(folder.path().join("array.csv")).unwrap();
    program(folder.path(), &["report", "run"]);
}
