use super::*;
use crate::road::sources::conditioning::condition;
use crate::road::texture::{ProfileDepth, ProfileSpectrum};
use crate::scene::{AtEnd, GridRoad, Lateral, LengthUnit, Levelling, ProfileRoad, Widen};

pub(super) fn profile(file: PathBuf) -> ProfileRoad {
    ProfileRoad {
        file,
        distance_unit: Some(LengthUnit::Metre),
        height_unit: Some(LengthUnit::Millimetre),
        columns: None,
        range: None,
        missing: None,
        level: Levelling::Slope,
        longest_wavelength: None,
        lateral: Lateral::Extruded,
        seed: 0,
        at_end: AtEnd::Refuse,
    }
}

/// The road of a CAPTIF file, which states its units.
pub(super) fn captif(file: PathBuf) -> ProfileRoad {
    ProfileRoad { distance_unit: None, height_unit: None, ..profile(file) }
}

fn line() -> Lattice {
    Lattice { dx: 0.004, along: 1, dy: 0.14, columns: 1 }
}

#[test]
fn captif_levels_depth_and_dropouts() {
    let published = [50.9, 57.0, 59.0, 55.0, 51.5, 43.9];
    let mut report = RoadReport::default();
    let mut map = crate::road::sources::profile::read(&captif(reference(CHIP_SEAL)), u64::MAX, &mut report).unwrap();
    assert!((map.dx - 3.75e-5).abs() < 1e-7 && (map.end() - 1.808).abs() < 1e-3, "{} {}", map.dx, map.end());
    assert!(report.missing > 2000 && report.missing < 4500, "{}", report.missing);
    let mut spectrum = ProfileSpectrum::new(map.heights.len(), map.dx);
    spectrum.add(&map.heights);
    for (band, expected) in [-10, -13, -17, -20, -23, -27].into_iter().zip(published) {
        let found = spectrum.level(band);
        println!("band {band}: {found:.1} dB, published {expected} dB");
        // At 100 mm there are four lines in the band: the uncertainty of their level is 2 dB.
        let allowed = if band == -10 { 2.2 } else { 1.1 };
        assert!((found - expected).abs() < allowed, "band {band}: {found} dB for {expected} dB");
    }
    // The table of all stations, measured ones, contains this one.
    let table = std::fs::read_to_string(reference("roads/captif_aylesbury_levels.csv")).unwrap();
    for line in table.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert!((spectrum.level(cells[0] as i32) - cells[4]).abs() < 0.051, "{line}");
    }
    let reported = ProfileDepth::of([(&map.heights[..], &map.origins[..])], map.dx);
    assert!(reported.segments == 18 && reported.valid > 9 && reported.reference_surface == Some(false), "{reported:?}");
    assert!((2.9e-3..3.7e-3).contains(&reported.mean.unwrap()), "{reported:?}");
    // Without spikes no segment is valid, as captif-slp 0.22 finds, and the shortest waves lose most.
    condition(&mut map, Levelling::Slope, None, &mut report).unwrap();
    let reported = ProfileDepth::of([(&map.heights[..], &map.origins[..])], map.dx);
    assert!(reported.segments == 18 && reported.valid == 0 && reported.mean.is_none(), "{reported:?}");
    let mut without = ProfileSpectrum::new(map.heights.len(), map.dx);
    without.add(&map.heights);
    for (band, range) in [(-10, -0.5..0.5), (-17, -0.5..0.5), (-20, -0.6..0.2), (-23, -1.6..-0.6), (-27, -6.0..-3.0)] {
        let change = without.level(band) - spectrum.level(band);
        assert!(range.contains(&change), "band {band}: {change} dB");
    }
}

#[test]
fn captif_spike_of_47_mm_counts_as_dropout() {
    let text = std::fs::read_to_string(reference(CHIP_SEAL)).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    let place = lines.len() / 2;
    let cells: Vec<&str> = lines[place].split('\t').collect();
    let spiked = [cells[0], cells[1], "47.0"].join("\t");
    lines[place] = &spiked;
    let folder = tempfile::tempdir().unwrap();
    let file = write(&folder, "spiked.dat", lines.join("\r\n").as_bytes());
    let of = |file: PathBuf| {
        let mut report = RoadReport::default();
        let map = crate::road::sources::profile::read(&captif(file), u64::MAX, &mut report).unwrap();
        let dropped = |note: &RoadNote| if let RoadNote::Outliers { count, .. } = note { *count } else { 0 };
        (map.span(), report.notes.iter().map(dropped).sum::<usize>())
    };
    let ((span, spikes), (clean_span, clean_spikes)) = (of(file), of(reference(CHIP_SEAL)));
    assert_eq!(spikes, clean_spikes + 1);
    assert!(span < 0.02 && (span - clean_span).abs() < 1e-4, "{span} {clean_span}");
}

#[test]
fn captif_isotropic_is_endless_with_the_profiles_levels() {
    let spec = Road::Profile(ProfileRoad { lateral: Lateral::Isotropic, seed: 4, ..captif(reference(CHIP_SEAL)) });
    let mut road = open(&spec, lattice());
    assert!(road.extent().is_none() && road.check_covers(-1e6, 1e6).is_ok());
    let fits = &road.report().bands;
    let worst = fits.iter().map(|band| (band.fitted - band.target).abs()).fold(0.0, f64::max);
    println!("worst band {worst:.2} dB, notes {:?}", road.report().notes);
    assert!(fits.iter().any(|band| (band.wavelength / 0.02 - 1.0).abs() < 0.01 && (band.fitted - 59.0).abs() < 1.1));
    let heights = rows(&mut road, 0, 3000);
    assert!((1e-3..4e-3).contains(&crate::road::texture::rms(&heights)));
}

#[test]
fn csv_with_header_units_names_and_missing_heights() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("# a comment\nid;s [m];z [mm]\n");
    for i in 0..2000 {
        let height = if i % 50 == 7 {
            String::from("NaN")
        } else {
            format!("{}", (i as f64 * 0.01).sin() + 3.0 + 0.001 * i as f64)
        };
        text += &format!("{i};{};{height}\n", 0.001 * i as f64);
    }
    let file = write(&folder, "p.csv", text.as_bytes());
    let spec = ProfileRoad { columns: Some(vec!["s [m]".into(), "3".into()]), ..profile(file) };
    let mut road = open(&Road::Profile(spec.clone()), line());
    assert_eq!(road.report().missing, 40);
    assert_eq!(road.extent().map(|(a, b)| ((a * 1e6).round(), (b * 1e6).round())), Some((0.0, 1_999_000.0)));
    // The wave of 0.63 m stays, with 1 mm amplitude; mean and slope are removed.
    let heights = rows(&mut road, 0, 499);
    let rms = crate::road::texture::rms(&heights);
    assert!((0.5e-3..0.8e-3).contains(&rms), "{rms}");
    assert!(matches!(road.heights(0, 501, &mut vec![0.0; 501]), Err(RoadError::Short { .. })));
    assert!(matches!(road.heights(-1, 1, &mut [0.0]), Err(RoadError::Short { .. })));
    assert!(matches!(road.check_covers(0.0, 2.5), Err(RoadError::Short { .. })));
    assert!(road.check_covers(0.0, 1.99).is_ok());
    let missing_name = ProfileRoad { columns: Some(vec!["1".into(), "height".into()]), ..spec.clone() };
    let message = refused(&Road::Profile(missing_name), line()).to_string();
    assert!(message.contains("s [m]") && message.contains("height"), "{message}");
    let counter = ProfileRoad { columns: Some(vec!["id".into(), "z".into()]), distance_unit: None, ..spec.clone() };
    assert!(refused(&Road::Profile(counter), line()).to_string().contains("distance_unit"));
    let outside = ProfileRoad { range: Some([0.5, 7.0]), ..spec };
    assert!(matches!(refused(&Road::Profile(outside), line()), RoadError::Range { .. }));
}

#[test]
fn holes_of_every_kind_of_file_make_segments_invalid() {
    let folder = tempfile::tempdir().unwrap();
    // A hole of 20 mm in the second of ten segments, one of 6 mm at the end, and every thirtieth point missing in
    // places.
    let hole = |i: usize| (130..150).contains(&i) || i >= 994 || (300..600).contains(&i) && i.is_multiple_of(30);
    let height = |i: usize| 1e-3 * (i as f64 * 0.3).sin();
    let mut text = String::new();
    for i in 0..1000 {
        let written = if hole(i) { String::from("NaN") } else { height(i).to_string() };
        text += &format!("{},{written}\n", 0.001 * i as f64);
    }
    let metres = Some(crate::scene::LengthUnit::Metre);
    let profile = profile(write(&folder, "p.csv", text.as_bytes()));
    let profile = ProfileRoad { distance_unit: metres, height_unit: metres, ..profile };
    let heights = (0..2000).map(|i| if hole(i / 2) && i % 2 == 0 { f64::NAN } else { height(i / 2) });
    let file = write(&folder, "g.npy", &npy(&[1000, 2], npyz::Order::C, heights));
    for (spec, profiles) in [(Road::Profile(profile), 1), (Road::Grid(grid(file, 0.001, 0.07)), 2)] {
        let lattice = Lattice::choose(&spec, 0.004, 0.14, None, None).unwrap();
        let depth = describe(&spec, lattice, 20.0, Limits::default()).unwrap().mean_profile_depth.unwrap();
        assert_eq!((depth.segments, depth.valid), (10 * profiles, 10 * profiles - 2), "{depth:?}");
    }
}

#[test]
fn unsorted_and_repeated_distances_are_mended_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let height = |i: usize| (i as f64 * 0.3).sin();
    let mut sorted = String::new();
    let mut shuffled = String::new();
    for i in 0..500 {
        sorted += &format!("{},{}\n", 0.001 * i as f64, height(i));
        // Blocks of five points, each in reverse order.
        let j = i / 5 * 5 + 4 - i % 5;
        let off = if j.is_multiple_of(25) { 0.1 } else { 0.0 };
        shuffled += &format!("{},{}\n{},{}\n", 0.001 * j as f64, height(j) + off, 0.001 * j as f64, height(j) - off);
    }
    let a = Road::Profile(profile(write(&folder, "a.csv", sorted.as_bytes())));
    let b = Road::Profile(profile(write(&folder, "b.csv", shuffled.as_bytes())));
    let (mut a, mut b) = (open(&a, line()), open(&b, line()));
    for (a, b) in rows(&mut a, 0, 120).iter().zip(&rows(&mut b, 0, 120)) {
        assert!((a - b).abs() < 1e-12);
    }
    let notes = &b.report().notes;
    assert!(notes.contains(&RoadNote::Duplicates { merged: 500 }), "{notes:?}");
    assert!(notes.iter().any(|note| matches!(note, RoadNote::Unsorted { .. })));
}

#[test]
fn faulty_profiles_are_refused_with_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let mut number = 0;
    let mut fault = |text: &[u8]| {
        number += 1;
        refused(&Road::Profile(profile(write(&folder, &format!("{number}.csv"), text))), line())
    };
    assert!(matches!(
        fault(b""),
        RoadError::File { fault: RoadFileFault(FileFault::TooFewPoints { found: 0, .. }), .. }
    ));
    assert!(matches!(
        fault(b"s,z\n"),
        RoadError::File { fault: RoadFileFault(FileFault::TooFewPoints { found: 0, .. }), .. }
    ));
    assert!(matches!(
        fault(b"0,1\n1,2\n"),
        RoadError::File { fault: RoadFileFault(FileFault::TooFewPoints { found: 2, .. }), .. }
    ));
    match fault(b"s,z\n0,1\n0.1,2\n0.2,wet\n") {
        RoadError::File {
            fault: RoadFileFault(FileFault::NotANumber { line: 4, column: 2, role: "height", found, .. }),
            ..
        } => {
            assert_eq!(found, "wet")
        }
        other => panic!("{other}"),
    }
    assert!(matches!(
        fault(b"s,z\n0,1\nfar,2\n"),
        RoadError::File {
            fault: RoadFileFault(FileFault::NotANumber { line: 3, column: 1, role: "distance", .. }),
            ..
        }
    ));
    assert!(matches!(
        fault(b"0,1\n1,inf\n"),
        RoadError::File { fault: RoadFileFault(FileFault::NotANumber { line: 2, column: 2, .. }), .. }
    ));
    assert!(fault(b"\x01\x02garbage\n\x01\x02").to_string().contains("tyrewave.Road.from_topography"));
    let metres: String = (0..100).map(|i| format!("{},{}\n", 0.01 * f64::from(i), 1e3 * f64::from(i % 7))).collect();
    assert!(matches!(
        fault(metres.as_bytes()),
        RoadError::File { fault: RoadFileFault(FileFault::ImplausibleHeights { .. }), .. }
    ));
    let holes: String =
        (0..100).map(|i| format!("{},{}\n", 0.01 * f64::from(i), if i % 2 == 0 { "" } else { "1" })).collect();
    assert!(matches!(
        fault(holes.as_bytes()),
        RoadError::File { fault: RoadFileFault(FileFault::TooManyMissing { missing: 50, .. }), .. }
    ));
    let outlier: String = (0..50).map(|i| format!("{},1\n", if i == 49 { 1e15 } else { f64::from(i) })).collect();
    assert!(
        matches!(
            fault(outlier.as_bytes()),
            RoadError::File { fault: RoadFileFault(FileFault::Jump { line: 50, .. }), .. }
        ),
        "must not be filled with 1e15 points"
    );
    // Millimetres read as metres, as a line and as what an isotropic surface is made after.
    let rows: String = (0..4000).map(|i| format!("{},{}\n", 0.5 * f64::from(i), f64::from(i % 7))).collect();
    assert!(fault(rows.as_bytes()).to_string().contains("is the unit of its distances right"));
    let rows: String = (0..4000).map(|i| format!("{},{}\n", 0.2 * f64::from(i), f64::from(i % 7))).collect();
    let coarse = ProfileRoad { lateral: Lateral::Isotropic, ..profile(write(&folder, "coarse.csv", rows.as_bytes())) };
    let message = refused(&Road::Profile(coarse), line()).to_string();
    assert!(message.contains("0.200 m apart") && message.contains("is the unit of its distances right"), "{message}");
    let absent = Road::Profile(profile(folder.path().join("absent.csv")));
    assert!(refused(&absent, line()).to_string().contains("absent.csv"));
    let directory = Road::Profile(profile(folder.path().to_owned()));
    assert!(matches!(refused(&directory, line()), RoadError::File { fault: RoadFileFault(FileFault::Io(_)), .. }));
    let captif = fault(
        b"Road Name\tCAPTIF\t\n*****DATA*****\t\t\nData Point No:\tDistance (m)\tDepth (mm)\n1\t0.0\t1.0\n2\tx\t1.0\n",
    );
    assert!(
        matches!(
            captif,
            RoadError::File { fault: RoadFileFault(FileFault::NotANumber { line: 5, column: 2, .. }), .. }
        ),
        "{captif}"
    );
    let captif = write(&folder, "furlongs.dat", b"*****DATA*****\t\t\nNo:\tDistance (furlong)\tDepth (mm)\n1\t2\t3\n");
    let no_unit = Road::Profile(ProfileRoad { distance_unit: None, height_unit: None, ..profile(captif) });
    let message = refused(&no_unit, line()).to_string();
    assert!(message.contains("\"furlong\"") && message.contains("ft, mil"), "{message}");
    let large = Road::Profile(profile(write(&folder, "large.csv", b"0,1\n")));
    assert!(matches!(
        RoadSurface::open(&large, line(), Limits { bytes: 3 }),
        Err(RoadError::File { fault: RoadFileFault(FileFault::TooLarge { needed: 96, limit: 3 }), .. })
    ));
}

pub(super) fn grid(file: PathBuf, dx: f64, dy: f64) -> GridRoad {
    let (distance_unit, height_unit, columns) = (None, None, None);
    let (dx, dy, widen, at_end) = (Some(dx), Some(dy), Widen::Refuse, AtEnd::Refuse);
    let (missing, level, longest_wavelength) = (None, Levelling::Off, None);
    GridRoad { file, dx, dy, distance_unit, height_unit, columns, widen, missing, level, longest_wavelength, at_end }
}

#[test]
fn grid_on_the_lattice_is_used_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let heights: Vec<f64> = (0..40 * 6).map(|i| 1e-3 * (i as f64 * 1.7).sin()).collect();
    let c = write(&folder, "c.npy", &npy(&[40, 6], npyz::Order::C, heights.iter().copied()));
    let transposed = (0..6 * 40).map(|i| heights[i % 40 * 6 + i / 40]);
    let f = write(&folder, "f.npy", &npy(&[40, 6], npyz::Order::Fortran, transposed));
    for file in [c, f] {
        let spec = Road::Grid(grid(file, 0.004, 0.025));
        let lattice = Lattice::choose(&spec, 0.004, 0.15, None, None).unwrap();
        assert_eq!(lattice.columns, 6);
        let mut road = open(&spec, lattice);
        assert!(rows(&mut road, 0, 40).iter().zip(&heights).all(|(a, b)| a.to_bits() == b.to_bits()));
        assert!(matches!(road.heights(39, 2, &mut [0.0; 12]), Err(RoadError::Short { .. })));
        // Another element length: columns of about 2 mm.
        assert_eq!(Lattice::choose(&spec, 0.005, 0.15, None, None).unwrap().columns, 75);
        assert_eq!(Lattice::choose(&spec, 0.004, 0.1, None, None).unwrap().columns, 50);
        assert_eq!(Lattice::choose(&spec, 0.004, 0.15, Some(3), None).unwrap().columns, 3);
        assert!(matches!(Lattice::choose(&spec, 0.004, 0.15, Some(0), None), Err(RoadError::NotPositive { .. })));
        assert!(matches!(
            refused(&spec, Lattice { dx: 0.004, along: 1, dy: 0.002, columns: 100 }),
            RoadError::Narrow { .. }
        ));
    }
    let single = write(&folder, "s.npy", &npy(&[40, 6], npyz::Order::C, heights.iter().map(|&z| z as f32)));
    let mut road =
        open(&Road::Grid(grid(single, 0.004, 0.025)), Lattice { dx: 0.004, along: 1, dy: 0.025, columns: 6 });
    assert!(rows(&mut road, 0, 40).iter().zip(&heights).all(|(a, &b)| a.to_bits() == f64::from(b as f32).to_bits()));
}

#[test]
fn faulty_grids_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut number = 0;
    let mut fault = |bytes: &[u8]| {
        number += 1;
        refused(
            &Road::Grid(grid(write(&folder, &format!("{number}.npy"), bytes), 0.004, 0.05)),
            Lattice { dx: 0.004, along: 1, dy: 0.05, columns: 4 },
        )
    };
    let level = |count: usize| (0..count).map(|i| 1e-4 * i as f64);
    let order = npyz::Order::C;
    assert!(matches!(
        fault(&npy(&[40], order, level(40))),
        RoadError::File { fault: RoadFileFault(FileFault::NpyShape { .. }), .. }
    ));
    assert!(matches!(
        fault(&npy(&[2, 5, 4], order, level(40))),
        RoadError::File { fault: RoadFileFault(FileFault::NpyShape { .. }), .. }
    ));
    assert!(matches!(
        fault(&npy(&[10, 4], order, 0..40_i32)),
        RoadError::File { fault: RoadFileFault(FileFault::NpyType { .. }), .. }
    ));
    assert!(matches!(fault(b"not an array"), RoadError::File { fault: RoadFileFault(FileFault::Npy(_)), .. }));
    let whole = npy(&[10, 4], order, level(40));
    assert!(
        matches!(fault(&whole[..whole.len() - 3]), RoadError::File { fault: RoadFileFault(FileFault::Npy(_)), .. }),
        "cut off"
    );
    let with =
        |value: f64| npy(&[10, 4], order, level(40).enumerate().map(move |(i, z)| if i == 22 { value } else { z }));
    assert!(matches!(
        fault(&with(f64::INFINITY)),
        RoadError::File { fault: RoadFileFault(FileFault::Infinite { row: 5, column: 2, .. }), .. }
    ));
    let millimetres = fault(&npy(&[10, 4], order, level(40).map(|z| 1e3 * z)));
    assert!(
        matches!(millimetres, RoadError::File { fault: RoadFileFault(FileFault::ImplausibleHeights { .. }), .. })
            && millimetres.to_string().contains("millimetres")
    );
    assert!(matches!(
        fault(&npy(&[10, 4], order, (0..40).map(|_| f64::NAN))),
        RoadError::File { fault: RoadFileFault(FileFault::TooManyMissing { missing: 40, .. }), .. }
    ));
    let mut complex = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    complex.extend(format!("{:<117}\n", "{'descr': '<c16', 'fortran_order': False, 'shape': (10, 4), }").bytes());
    assert!(matches!(fault(&complex), RoadError::File { fault: RoadFileFault(FileFault::NpyType { .. }), .. }));
    let holes = Road::Grid(grid(write(&folder, "h.npy", &with(f64::NAN)), 0.004, 0.05));
    let mut road = open(&holes, Lattice { dx: 0.004, along: 1, dy: 0.05, columns: 4 });
    assert_eq!(road.report().missing, 1);
    assert!((rows(&mut road, 5, 1)[2] - 22e-4).abs() < 1e-15, "a plane is filled exactly");
    let bad = Road::Grid(GridRoad { dx: Some(-1.0), ..grid(folder.path().join("h.npy"), 0.004, 0.05) });
    assert!(matches!(
        refused(&bad, Lattice { dx: 0.004, along: 1, dy: 0.05, columns: 4 }),
        RoadError::NotPositive { .. }
    ));
    let few = Road::Grid(grid(folder.path().join("h.npy"), 0.004, 0.05));
    assert!(matches!(
        RoadSurface::open(&few, Lattice { dx: 0.004, along: 1, dy: 0.05, columns: 4 }, Limits { bytes: 100 }),
        Err(RoadError::File { fault: RoadFileFault(FileFault::TooLarge { .. }), .. })
    ));
}

#[test]
fn grid_description_measures_what_was_put_in() {
    let folder = tempfile::tempdir().unwrap();
    let wave = |i: usize| 1e-3 * (2.0 * std::f64::consts::PI * (i / 8) as f64 * 0.002 / 0.05).sin();
    let file = write(&folder, "w.npy", &npy(&[3000, 8], npyz::Order::C, (0..24_000).map(wave)));
    let spec = Road::Grid(grid(file, 0.002, 0.02));
    let reported =
        describe(&spec, Lattice::choose(&spec, 0.004, 0.14, None, None).unwrap(), 20.0, Limits::default()).unwrap();
    let level = reported.levels.iter().find(|band| (band.wavelength / 0.05 - 1.0).abs() < 0.01).unwrap().level;
    assert!((level - 56.99).abs() < 0.05, "{level}");
    assert!((reported.rms / (1e-3 / 2_f64.sqrt()) - 1.0).abs() < 0.01);
    assert_eq!(reported.highest_frequency.map(f64::round), Some(2500.0));
    assert_eq!(reported.highest_frequency_of_road.map(f64::round), Some(5000.0));
    // Two cells of 2 mm along each element of 4 mm.
    assert_eq!((reported.sample.rows, reported.sample.columns), (500, 70));
    assert!(serde_json::to_string(&reported).unwrap().contains("levels"));
    // 6 m less a spacing: 0.501 m does not fit 12 times. 2 mm are too coarse for a depth by the standard.
    let longest = reported.levels.iter().find(|band| band.valid).unwrap().wavelength;
    assert!((longest - 0.398).abs() < 1e-3 && reported.levels[0].wavelength > 1.2, "{longest}");
    let depth = reported.mean_profile_depth.unwrap();
    assert!(depth.too_coarse && depth.valid == 8 * 60 && depth.reference_surface.is_none(), "{depth:?}");
    assert!((reported.macrotexture.unwrap().level - level).abs() < 0.1 && reported.megatexture.is_some());
    let smooth = describe(&Road::Smooth, line(), 20.0, Limits::default()).unwrap();
    assert!(smooth.mean_profile_depth.is_none() && smooth.macrotexture.is_none());
    assert!(smooth.levels.is_empty() && smooth.highest_frequency.is_none());
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(200))]

    /// Reading any table must end with a finite road or an error.
    #[test]
    fn arbitrary_tables_never_panic(
        text in "([0-9.e+-]{0,6}[,;\t ]?(NaN|nan|inf|x)?[,\n]){0,60}",
        captif in proptest::prelude::any::<bool>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let head = if captif { "*****DATA*****\nData Point No:\tDistance (mm)\tDepth (mm)\n" } else { "" };
        let body = if captif { text.replace([',', ';'], "\t") } else { text };
        let file = write(&folder, "t.csv", format!("{head}{body}").as_bytes());
        if let Ok(mut road) = RoadSurface::open(&Road::Profile(profile(file)), line(), Limits { bytes: 1 << 24 }) {
            let mut out = [f64::NAN; 1];
            if road.heights(0, 1, &mut out).is_ok() {
                proptest::prop_assert!(out[0].is_finite());
            }
        }
    }
}
