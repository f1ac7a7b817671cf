//! A scene written as TOML reads back as the same scene.

use std::path::PathBuf;
use std::sync::LazyLock;

use proptest::prelude::*;

use super::super::*;
use super::BASE;
use super::schema::fits;

static SCHEMA: LazyLock<serde_json::Value> = LazyLock::new(Scene::json_schema);

fn positive() -> impl Strategy<Value = f64> {
    around(1.0)
}

/// Numbers within a decade of a typical one, with all digits.
fn around(typical: f64) -> impl Strategy<Value = f64> {
    (-1.0..1.0_f64).prop_map(move |exponent| typical * 10.0_f64.powf(exponent))
}

fn material() -> impl Strategy<Value = Material> {
    let law = prop_oneof![Just(Law::Elastic), Just(Law::PowerLaw), Just(Law::Prony), Just(Law::Hysteretic)];
    let pairs = prop::collection::vec((positive(), positive()), 1..4);
    (law, around(1e6), 0.0..1.0_f64, -0.99..0.499_f64, positive(), positive(), pairs).prop_map(
        |(law, modulus, loss, poisson, density, frequency, pairs)| {
            let power_law = law == Law::PowerLaw;
            let lossy = power_law || law == Law::Hysteretic;
            let (weights, times) = if law == Law::Prony { pairs.into_iter().unzip() } else { (vec![], vec![]) };
            Material {
                law,
                modulus,
                loss_factor: if lossy { loss } else { 0.0 },
                poisson,
                density,
                reference_frequency: if power_law { frequency } else { Material::REFERENCE_FREQUENCY },
                corner_frequency: if power_law { frequency / 7.0 } else { Material::CORNER_FREQUENCY },
                weights,
                times,
            }
        },
    )
}

fn at_end() -> impl Strategy<Value = AtEnd> {
    prop_oneof![Just(AtEnd::Refuse), Just(AtEnd::Repeat), Just(AtEnd::Mirror)]
}

fn file() -> impl Strategy<Value = PathBuf> {
    "[a-z \"'\\\\#ä/]{0,12}x".prop_map(PathBuf::from)
}

fn made() -> impl Strategy<Value = MadeRoad> {
    let levels = prop::collection::vec(-100.0..120.0_f64, 1..9);
    let power_law =
        (positive(), 0.0..10.0_f64, positive(), 0.01..0.99_f64).prop_map(|(rms, exponent, longest, part)| {
            PowerLawTexture { rms, exponent, longest, shortest: longest * part }
        });
    let seed = any::<u64>();
    prop_oneof![
        seed.prop_map(|seed| MadeRoad { seed, ..MadeRoad::default() }),
        (seed, prop::sample::select(&NamedTexture::ALL[..]))
            .prop_map(|(seed, texture)| { MadeRoad { seed, texture: Some(texture), ..MadeRoad::default() } }),
        (levels, positive(), any::<bool>()).prop_map(|(levels, longest, rising)| {
            let bands = 0..levels.len() as i32;
            let mut wavelengths: Vec<_> = bands.map(|band| longest * 0.8_f64.powi(band)).collect();
            let spacing = wavelengths.last().unwrap() / 3.0;
            if rising {
                wavelengths.reverse();
            }
            MadeRoad {
                seed: 1,
                wavelengths: Some(wavelengths),
                levels: Some(levels),
                power_law: None,
                texture: None,
                spacing,
                offset: -1.5,
                skewness: Some(-0.3),
                kurtosis: Some(2.5),
            }
        }),
        (seed, power_law).prop_map(|(seed, texture)| {
            let spacing = texture.shortest / 2.0;
            MadeRoad { seed, wavelengths: None, levels: None, power_law: Some(texture), spacing, ..MadeRoad::default() }
        }),
    ]
}

fn conditioning() -> impl Strategy<Value = (Option<Vec<MissingHeight>>, Levelling, Option<f64>)> {
    let missing =
        prop_oneof![(-9e4..9e4_f64).prop_map(MissingHeight::Number), "[a-z]{1,5}".prop_map(MissingHeight::Word)];
    let level = prop_oneof![Just(Levelling::Slope), Just(Levelling::Mean), Just(Levelling::Off)];
    (prop::option::of(prop::collection::vec(missing, 0..3)), level, prop::option::of(positive()))
}

fn profile() -> impl Strategy<Value = ProfileRoad> {
    let unit = prop_oneof![Just(LengthUnit::Metre), Just(LengthUnit::Millimetre), Just(LengthUnit::Micrometre)];
    let units = (prop::option::of(unit.clone()), prop::option::of(unit));
    let columns = prop::option::of(("[a-z]{1,5}", "[1-9]").prop_map(|(first, second)| vec![first, second]));
    let range = prop::option::of((-9.0..9.0_f64, positive()).prop_map(|(begin, length)| [begin, begin + length]));
    let lateral = prop_oneof![Just(Lateral::Extruded), Just(Lateral::Isotropic)];
    let continued = (lateral, 0..99_u64, at_end());
    (file(), units, columns, range, conditioning(), continued).prop_map(
        |(
            file,
            (distance_unit, height_unit),
            columns,
            range,
            (missing, level, longest_wavelength),
            (lateral, seed, at_end),
        )| ProfileRoad {
            file,
            distance_unit,
            height_unit,
            columns,
            range,
            missing,
            level,
            longest_wavelength,
            lateral,
            seed,
            at_end,
        },
    )
}

fn empty_grid() -> GridRoad {
    let (distance_unit, height_unit, columns) = (None, None, None);
    let (file, at_end, widen) = (PathBuf::new(), AtEnd::Refuse, Widen::Refuse);
    let (dx, dy, missing, level, longest_wavelength) = (None, None, None, Levelling::Slope, None);
    GridRoad { file, dx, dy, distance_unit, height_unit, columns, widen, missing, level, longest_wavelength, at_end }
}

fn road() -> impl Strategy<Value = Road> {
    let opencrg = (file(), prop::option::of(-9.0..9.0_f64), conditioning(), at_end()).prop_map(
        |(file, lateral_position, (missing, level, longest_wavelength), at_end)| {
            Road::OpenCrg(OpenCrgRoad {
                file,
                lateral_position,
                widen: Widen::Mirror,
                missing,
                level,
                longest_wavelength,
                at_end,
            })
        },
    );
    let grid = (file(), positive(), positive(), conditioning(), at_end()).prop_map(
        |(file, dx, dy, (missing, level, longest_wavelength), at_end)| {
            let (file, [dx, dy]) = (file.with_extension("npy"), [dx, dy].map(Some));
            Road::Grid(GridRoad { file, dx, dy, missing, level, longest_wavelength, at_end, ..empty_grid() })
        },
    );
    prop_oneof![Just(Road::Smooth), made().prop_map(Road::Made), profile().prop_map(Road::Profile), opencrg, grid]
}

/// Names that do not begin like a formula.
fn name() -> impl Strategy<Value = String> {
    "\\PC{0,9}".prop_map(|name| name.trim_start_matches(['=', '+', '-', '@']).to_owned())
}

fn tyre() -> impl Strategy<Value = Tyre> {
    let layer =
        (name(), positive(), [0.0..1e5, 0.0..1e5], material()).prop_map(|(name, thickness, tension, material)| Layer {
            name,
            thickness,
            tension,
            material,
            cords: Vec::new(),
            orthotropic: None,
        });
    let sizes = (positive(), positive(), 0.01..1.0_f64);
    let bed = (0.0..1e9_f64, 0.0..1e9_f64, 0.0..1.0_f64, positive(), positive()).prop_map(
        |(normal, tangential, loss_factor, reference_frequency, corner_frequency)| Foundation {
            normal,
            tangential,
            loss_factor,
            reference_frequency,
            corner_frequency,
        },
    );
    let content = (prop::option::of(inflation()), prop::option::of(cavity()), prop::option::of(sidewall()));
    let shape = (any::<[bool; 2]>(), content);
    (sizes, bed, prop::collection::vec(layer, 1..4), shape).prop_map(
        |((circumference, width, part), foundation, mut layers, ([curvature, guided], content))| {
            let (inflation, cavity, sidewall) = content;
            let radius = circumference / std::f64::consts::TAU;
            if curvature {
                let thickest = 0.3 * radius;
                layers.iter_mut().for_each(|layer| layer.thickness = layer.thickness.min(thickest));
            }
            let inner = radius - layers.iter().map(|layer| layer.thickness).sum::<f64>();
            let sidewall = sidewall
                .filter(|_| curvature && inflation.is_some())
                .map(|sidewall| Sidewall { radius: sidewall.radius * inner, ..sidewall });
            let foundation = if sidewall.is_some() { Foundation::default() } else { foundation };
            if sidewall.is_some() {
                // A tension of 0 would be taken for one that was left out, which the sidewalls then give.
                layers[0].tension[0] += 1.0;
            }
            let cavity = cavity.filter(|_| curvature && guided).map(|cavity| Cavity {
                radius: cavity.radius * radius,
                depth: cavity.depth * cavity.radius * radius,
                ..cavity
            });
            let sides = if guided { Sides::Guided } else { Sides::Supported };
            Tyre {
                circumference,
                width,
                contact_width: width * part,
                crown_radius: cavity.as_ref().map(|cavity| cavity.radius),
                load_index: inflation.as_ref().map(|_| 91),
                sides,
                curvature,
                inflation,
                cavity,
                sidewall,
                foundation,
                layers,
                angular_velocity: 0.0,
            }
        },
    )
}

fn inflation() -> impl Strategy<Value = Inflation> {
    around(1e5).prop_map(|pressure| Inflation { pressure })
}

/// Sidewalls whose radius is a part of that of the inner face.
fn sidewall() -> impl Strategy<Value = Sidewall> {
    let arc = (0.05..0.25_f64, 0.5..1.2_f64, 1.0..20.0_f64, 1e3..1e5_f64);
    (arc, prop::option::of(1e5..1e6_f64), 0.0..1.0_f64).prop_map(|((radius, angle, mass, shear), hoop, loss_factor)| {
        Sidewall { radius, angle, mass, shear, hoop, loss_factor }
    })
}

/// Cavities whose radius is a part of the tyre's, and whose depth is a part of that.
fn cavity() -> impl Strategy<Value = Cavity> {
    (0.01..0.99_f64, 0.01..0.99_f64, positive(), 200.0..1e3_f64, 0.0..1e-3_f64).prop_map(
        |(radius, depth, density, sound_speed, relaxation)| Cavity { radius, depth, density, sound_speed, relaxation },
    )
}

fn rolling() -> impl Strategy<Value = Rolling> {
    let load = (around(1e3), 1e-6..0.9_f64).prop_map(|(load, tolerance)| Axle::Load { load, tolerance });
    let mass = (around(1e3), positive(), 0.0..1e6_f64, 0.0..1e4_f64, 1e-6..0.9_f64).prop_map(
        |(load, mass, stiffness, damping, tolerance)| Axle::Mass { load, mass, stiffness, damping, tolerance },
    );
    // A millimetre is less than the radius of the smallest tyre.
    let indentation =
        (1e-9..1e-3_f64, 0.0..1.0_f64).prop_map(|(indentation, ramp)| Axle::Indentation { indentation, ramp });
    (positive(), positive(), 0.0..1.0_f64, prop::option::of(-9.0..9.0_f64), prop_oneof![load, mass, indentation])
        .prop_map(|(speed_kmh, duration, warm_up, start, axle)| Rolling { speed_kmh, duration, warm_up, start, axle })
}

fn contact() -> impl Strategy<Value = Contact> {
    let tread = prop_oneof![
        Just((Tread::Elastic, None)),
        Just((Tread::Uncoupled, None)),
        prop::option::of(around(1e9)).prop_map(|stiffness| (Tread::Bedding, stiffness)),
    ];
    let slices = prop_oneof![Just(Slices::Winkler), Just(Slices::HalfSpace)];
    let couplings = prop_oneof![
        prop::option::of(around(1e-10)).prop_map(|kappa| (SliceCoupling::Local, kappa)),
        Just((SliceCoupling::Explicit, None)),
    ];
    let cells = (prop::option::of(1..1000_usize), prop::option::of(1..9_usize));
    let errors = (0.0..1e-3_f64, prop_oneof![Just(2.0), 0.1..60.0_f64]);
    (tread, slices, (couplings, any::<bool>()), cells, errors).prop_map(
        |((tread, bedding_stiffness), slices, (coupling, equal), (cells_across, cells_along), errors)| {
            let (slice_tolerance, largest_slice_error) = errors;
            Contact {
                zone: Zone::Slices,
                cell: None,
                tread,
                slices,
                slice_coupling: coupling.0,
                local_compliance: coupling.1,
                cells_across,
                cells_along,
                slice_tolerance,
                largest_slice_error,
                bedding_stiffness,
                equal_stiffness: equal && tread == Tread::Uncoupled,
            }
        },
    )
}

fn numerics() -> impl Strategy<Value = Numerics> {
    let rule = prop::sample::select(TimeRule::ALL.to_vec());
    let history = (prop_oneof![Just(History::Direct), Just(History::Modal)], 1e-10..1e-2_f64);
    let sizes = (8..1_000_000_000_usize, 1..9_usize, 1..9999_usize);
    let tolerances = (1e-14..0.1_f64, 1e-15..1e-3_f64);
    let fixed = (prop::option::of(1..999_usize), prop::option::of(0..999_usize));
    (sizes, rule, history, tolerances, fixed, positive(), (positive(), positive())).prop_map(
        |(
            (half, substeps, cached_factors),
            time_rule,
            history,
            tolerances,
            fixed,
            memory,
            (memory_limit, time_limit),
        )| {
            Numerics {
                // It decides about other keys, and has a separate test.
                fmax: None,
                preset: None,
                accuracy: None,
                elements: 16 + 2 * (half % 400_000),
                substeps,
                elements_per_step: 1,
                time_rule,
                history: history.0,
                pole_tolerance: history.1,
                memory,
                influence_tolerance: tolerances.0,
                contact_tolerance: tolerances.1,
                lateral_terms: fixed.0,
                wavenumber_aliases: fixed.1,
                cached_factors,
                memory_limit,
                time_limit,
            }
        },
    )
}

/// Effects that are compatible with any other settings.
fn effects() -> impl Strategy<Value = Effects> {
    let any = prop_oneof![Just(Switch::Auto), Just(Switch::Off)];
    (any.clone(), any.clone(), any).prop_map(|(rotation, radiation, friction)| Effects {
        rotation,
        radiation,
        friction,
        ..Effects::default()
    })
}

fn vibration() -> impl Strategy<Value = Vibration> {
    let frames = prop_oneof![Just(Frames::Both), Just(Frames::Material), Just(Frames::NonRotating)];
    let (points, elements) = (prop::collection::vec(-1.0..1.0_f64, 0..4), prop::collection::vec(0_usize.., 0..4));
    (any::<[bool; 4]>(), frames, points, elements, positive()).prop_map(
        |([tread, belt, tangential, map], frames, points, elements, segment)| Vibration {
            lateral_tolerance: None,
            tread,
            belt,
            tangential,
            frames,
            points: if frames.non_rotating() { points } else { Vec::new() },
            elements: if frames.material() { elements } else { Vec::new() },
            map,
            segment,
        },
    )
}

/// Receivers beside the tyre, and a radiation.
fn sound() -> impl Strategy<Value = (Vec<Receiver>, Radiation)> {
    let length = || 0.01..100.0_f64;
    let place = prop_oneof![
        (length(), 1.0..100.0_f64, length()).prop_map(|(x, y, z)| ReceiverPlace::Position { position: [x, y, z] }),
        (length(), length(), prop::option::of(0.0..20.0_f64)).prop_map(|(distance, height, wheelbase)| {
            let passage = wheelbase.map(|wheelbase| 20.0 + wheelbase);
            let vehicle = wheelbase.map(|wheelbase| Vehicle { wheelbase, ..Vehicle::default() });
            ReceiverPlace::Standard(StandardReceiver::CoastBy { distance, height, vehicle, passage })
        }),
        Just(ReceiverPlace::Standard(StandardReceiver::Cpx)),
        (length(), length())
            .prop_map(|(radius, height)| ReceiverPlace::Standard(StandardReceiver::Circle { radius, height })),
        length().prop_map(|radius| ReceiverPlace::Standard(StandardReceiver::Hemisphere { radius })),
    ];
    let receiver = (name(), place).prop_map(|(name, place)| Receiver { name, place });
    let receivers = prop::collection::vec(receiver, 1..4).prop_map(|mut receivers| {
        // No two have the same name.
        let named = receivers.iter_mut().enumerate().filter(|(_, receiver)| !receiver.name.is_empty());
        named.for_each(|(index, receiver)| receiver.name.push_str(&index.to_string()));
        receivers
    });
    let air = prop_oneof![Just(AirMotion::Road), Just(AirMotion::Axle), Just(AirMotion::WithTread)];
    let radiation = (50.0..2e4_f64, 3.0..40.0_f64, 1e-3..6.0_f64, 1_usize..99, 0.0..0.05_f64, air, any::<bool>())
        .prop_map(|(fmax, nodes_per_wavelength, frequency_tolerance, lateral_waves, acoustic_gap, air, audio)| {
            Radiation {
                fmax,
                nodes_per_wavelength,
                frequency_tolerance,
                lateral_waves,
                acoustic_gap,
                air,
                audio,
                full_scale: audio.then_some(fmax),
                ..Radiation::default()
            }
        });
    prop_oneof![Just((Vec::new(), Radiation::default())), (receivers, radiation)]
}

fn scene() -> impl Strategy<Value = Scene> {
    let outputs = (any::<[bool; 3]>(), 0.0..1e4_f64, prop::option::of(vibration())).prop_map(
        |([arrays, spectra, plots], checkpoint_interval, vibration)| Outputs {
            patch_span: None,
            cells_every: None,
            sections: None,
            levels: None,
            arrays,
            spectra,
            plots,
            checkpoint_interval,
            vibration,
        },
    );
    ("\\PC{0,20}", tyre(), road(), rolling(), contact(), effects(), numerics(), outputs, sound()).prop_map(
        |(title, tyre, road, mut rolling, contact, mut effects, numerics, mut outputs, sound)| {
            let (mut receivers, mut radiation) = sound;
            if let Some(Inflation { pressure }) = &tyre.inflation
                && let Axle::Load { load, .. } | Axle::Mass { load, .. } = &mut rolling.axle
            {
                // Loads that the pressure bears on 0.6 to 60 % of the circumference.
                *load = (6e-5 * *load * pressure * tyre.contact_width * tyre.circumference).max(0.1);
            }
            // The tyre is not larger than life, and its shoulders are smaller than the tyre.
            let reach = tyre.width + 2.0 * tyre.radius();
            receivers.retain(|_| reach < 9.0);
            if receivers.is_empty() {
                radiation = Radiation::default();
            } else {
                radiation.shoulder = 0.1 * tyre.radius();
                effects.radiation = Switch::Auto;
            }
            for receiver in &mut receivers {
                match &mut receiver.place {
                    ReceiverPlace::Position { position } => position[1] += reach,
                    ReceiverPlace::Standard(StandardReceiver::CoastBy { distance, vehicle, .. }) => {
                        // The tyres are side by side, and the microphone is beyond them.
                        *distance += reach;
                        *vehicle = vehicle.filter(|_| reach < 5.0).map(|vehicle| Vehicle { track: reach, ..vehicle });
                    }
                    ReceiverPlace::Standard(_) => {}
                }
            }
            if let Some(vibration) = &mut outputs.vibration {
                // Until here these are parts of the half circumference.
                vibration.points.iter_mut().for_each(|point| *point *= 0.5 * tyre.circumference);
                vibration.elements.iter_mut().for_each(|element| *element %= numerics.elements);
                vibration.tangential &= contact.tread != Tread::Bedding;
                vibration.belt |= !vibration.tangential;
            }
            Scene {
                title,
                allow_implausible: true,
                tyre,
                tread_pattern: None,
                air_pumping: None,
                road,
                rolling,
                contact,
                friction: None,
                adhesion: None,
                effects,
                numerics,
                outputs,
                receivers,
                radiation,
            }
        },
    )
}

proptest! {
    #[test]
    fn writing_and_reading_is_the_identity(scene in scene()) {
        let text = scene.to_toml().unwrap();
        let read = Scene::from_str(&text, "written");
        let read = read.unwrap_or_else(|error| panic!("{}\n{text}", error.render(false)));
        prop_assert_eq!(&read.scene, &scene);
        prop_assert!(fits(&scene.to_json().unwrap(), &SCHEMA), "{}", text);
        prop_assert_eq!(read.settings().unwrap(), scene.to_json().unwrap());
        prop_assert_eq!(super::hash(&LoadedScene::from_scene(&read.scene, "again").unwrap()), super::hash(&read));
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC{0,200}") {
        if let Err(error) = Scene::from_str(&text, "any") {
            let _ = error.render(false);
        }
    }

    #[test]
    fn a_garbled_scene_is_refused_or_read_without_a_panic(
        cut in 0..BASE.len(), length in 0..40_usize, put in "[\\[\\]{}=\",.a0-9\n-]{0,4}",
    ) {
        let mut text = BASE.to_owned();
        text.replace_range(cut..(cut + length).min(BASE.len()), &put);
        if let Err(error) = Scene::from_str(&text, "garbled") {
            prop_assert!(!error.diagnostics().is_empty());
            let _ = error.render(false);
        }
    }
}

#[test]
fn a_scene_put_together_in_a_program_is_checked_like_a_file() {
    let mut scene = Scene::from_str(BASE, "base").unwrap().scene;
    scene.tyre.layers[1].thickness = f64::NAN;
    scene.numerics.elements = 7;
    let error = LoadedScene::from_scene(&scene, "in memory").unwrap_err();
    let keys: Vec<_> = error.diagnostics().iter().map(Diagnostic::key).collect();
    assert_eq!(keys.len(), 2, "{error}");
    assert!(keys.contains(&"tyre.layers[1].thickness") && keys.contains(&"numerics.elements"));
}

#[cfg(unix)]
#[test]
fn a_path_that_is_not_text_cannot_be_written() {
    use std::os::unix::ffi::OsStringExt;
    let file = PathBuf::from(std::ffi::OsString::from_vec(vec![b'a', 0xff]));
    let mut scene = Scene::from_str(BASE, "base").unwrap().scene;
    scene.road = Road::Grid(GridRoad { file, ..empty_grid() });
    assert!(matches!(scene.to_toml(), Err(SceneError::NotToml { .. })));
    assert!(matches!(scene.to_json(), Err(SceneError::NotJson { .. })));
}

#[test]
fn settings_are_plain_json() {
    let settings = Scene::from_str(BASE, "base").unwrap().settings().unwrap();
    assert_eq!(settings["tyre"]["layers"][1]["material"]["law"], "power-law");
    assert_eq!(settings["rolling"]["axle"]["load"], 3400.0);
    assert_eq!(settings["numerics"]["time_rule"], "sdirk2");
    assert_eq!(settings["rolling"]["warm_up"], Rolling::WARM_UP);
    assert_eq!(settings["road"]["kind"], "smooth");
}
