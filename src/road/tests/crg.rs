use super::*;
use crate::road::sources::opencrg::Crg;
use crate::scene::{AtEnd, Levelling, OpenCrgRoad, Widen};
use crate::test_models::replaced;

fn spec(file: PathBuf) -> OpenCrgRoad {
    OpenCrgRoad {
        file,
        lateral_position: None,
        widen: Widen::Refuse,
        missing: None,
        level: Levelling::Slope,
        longest_wavelength: None,
        at_end: AtEnd::Refuse,
    }
}

fn read(path: &std::path::Path) -> Crg {
    Crg::read(path, 1 << 30, None).unwrap()
}

/// One of the small roads that come with OpenCRG.
fn handmade(name: &str) -> PathBuf {
    reference(&format!("roads/handmade_{name}.crg"))
}

fn fault(path: &std::path::Path) -> FileFault {
    match Crg::read(path, 1 << 30, None) {
        Err(RoadError::File { fault, .. }) => fault.0,
        other => panic!("{other:?}"),
    }
}

const ROWS: usize = 30;
const COLUMNS: usize = 9;

fn height(row: usize, column: usize) -> f64 {
    f64::from((1e-3 * ((row * 3 + column * 5) as f64).sin()) as f32)
}

/// A file of one of the formats, with `extra` sections in the header, and with a missing height at `hole`.
fn make(format: &str, extra: &str, hole: Option<(usize, usize)>) -> Vec<u8> {
    let mut text = format!(
        "$CT\nmade by a test\n$\n$ROAD_CRG\nreference_line_start_u = 100\nreference_line_end_u = {}\n\
         reference_line_increment = 0.1\nlong_section_v_increment = 0.05\n$\n{extra}$KD_Definition\n#:{format}\n",
        100.0 + 0.1 * (ROWS - 1) as f64
    );
    for column in 1..=COLUMNS {
        text += &format!("D:long section {column},m\n");
    }
    text += "$\n$$$$$$$$\n";
    let mut bytes = text.into_bytes();
    let value = |row: usize, column: usize| if hole == Some((row, column)) { f64::NAN } else { height(row, column) };
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let z = value(row, column);
            match format {
                "KRBI" => bytes.extend((z as f32).to_be_bytes()),
                "KDBI" => bytes.extend(z.to_be_bytes()),
                "LRFI" => {
                    bytes.extend(if z.is_nan() { String::from(" *missing*") } else { format!("{z:10.7}") }.bytes())
                }
                _ => {
                    bytes.extend(if z.is_nan() { format!("{:>20}", "*missing*") } else { format!("{z:20.17}") }.bytes())
                }
            }
            let per_record = if format == "LRFI" { 8 } else { 4 };
            if format.ends_with("FI") && (column + 1 == COLUMNS || (column + 1) % per_record == 0) {
                bytes.push(b'\n');
            }
        }
    }
    if format.ends_with("BI") {
        let nan: &[u8] = if format == "KRBI" { &[0x7f, 0xc0, 0, 0] } else { &[0x7f, 0xf8, 0, 0, 0, 0, 0, 0] };
        let size = if format == "KRBI" { 4 } else { 8 };
        while (ROWS * COLUMNS * size + bytes.len()) % 80 != (ROWS * COLUMNS * size + header_length(&bytes)) % 80 {
            bytes.extend(nan);
        }
    }
    bytes
}

fn header_length(bytes: &[u8]) -> usize {
    bytes.windows(9).position(|w| w == b"$$$$$$$$\n").unwrap() + 9
}

#[test]
fn all_four_formats_hold_the_same_road() {
    let folder = tempfile::tempdir().unwrap();
    for (format, tolerance) in [("LRFI", 6e-8), ("LDFI", 1e-16), ("KRBI", 1e-16), ("KDBI", 1e-16)] {
        let road = read(&write(&folder, &format!("{format}.crg"), &make(format, "", Some((4, 0)))));
        assert_eq!((road.rows(), road.v.len()), (ROWS, COLUMNS), "{format}");
        assert!((road.v[0] + 0.2).abs() < 1e-12, "centred by default");
        for row in 0..ROWS {
            for column in 0..COLUMNS {
                let z = road.elevation(row, column);
                assert!(z.is_nan() == ((row, column) == (4, 0)), "{format} {row} {column}");
                assert!(z.is_nan() || (z - height(row, column)).abs() <= tolerance, "{format} {row} {column}: {z}");
            }
        }
    }
}

#[test]
fn damaged_files_are_refused_with_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let binary = make("KDBI", "", None);
    let cut = fault(&write(&folder, "cut.crg", &binary[..binary.len() - 200]));
    assert!(
        matches!(cut, FileFault::Payload { rows: 30, channels: 9, expected: 2160, padded: 2160, found: 1960, .. }),
        "{cut}"
    );
    assert!(cut.to_string().contains("cut off"));
    let mut longer = binary.clone();
    longer.extend([0; 80]);
    assert!(matches!(fault(&write(&folder, "long.crg", &longer)), FileFault::Payload { found: 2240, .. }));
    let text = make("LRFI", "", None);
    let short = fault(&write(&folder, "short.crg", &text[..text.len() - 92 * 2]));
    assert!(matches!(short, FileFault::Rows { expected: 30, found: 28 }), "{short}");
    assert!(matches!(fault(&write(&folder, "field.crg", &text[..text.len() - 5])), FileFault::Record { .. }));
    let header = header_length(&text);
    assert!(matches!(fault(&write(&folder, "header.crg", &text[..header - 20])), FileFault::NoData));
    assert!(matches!(fault(&write(&folder, "empty.crg", b"")), FileFault::NoData));
    let text = String::from_utf8(text).unwrap();
    let fault_of = |from: &str, to: &str| fault(&write(&folder, "x.crg", replaced(&text, &[(from, to)]).as_bytes()));
    assert!(matches!(fault_of("_increment = 0.1", "_increment = ten"), FileFault::HeaderNumber { .. }));
    assert!(matches!(fault_of("reference_line_increment = 0.1\n", ""), FileFault::Missing { .. }));
    assert!(matches!(fault_of("_increment = 0.1", "_increment = -0.1"), FileFault::NotPositive { .. }));
    assert!(matches!(fault_of("_increment = 0.1", "_increment = 0.07"), FileFault::RowCount { .. }));
    assert!(matches!(fault_of("end_u = 102.9", "end_u = 1e300"), FileFault::RowCount { .. }));
    assert!(matches!(fault_of("end_u = 102.9", "end_u = 1e9"), FileFault::Rows { found: 30, .. }));
    assert!(matches!(fault_of("section 9", "section 8"), FileFault::Sections { .. }));
    assert!(matches!(fault_of("section 9", "section at v = 1"), FileFault::Sections { .. }));
    assert!(matches!(
        fault_of(
            "long_section_v_increment = 0.05",
            "long_section_v_right = -1\nlong_section_v_left = 1\nlong_section_v_increment = 0.05"
        ),
        FileFault::SectionCount { found: 9, .. }
    ));
    assert!(matches!(fault_of("long_section_v_increment = 0.05\n", ""), FileFault::Missing { .. }));
    let mut absurd = binary;
    let start = header_length(&absurd);
    absurd[start + 72..start + 80].copy_from_slice(&1e38_f64.to_be_bytes());
    assert!(matches!(fault(&write(&folder, "absurd.crg", &absurd)), FileFault::Absurd { row: 1, channel: 1, .. }));
}

#[test]
fn a_file_of_another_kind_says_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("road.csv");
    std::fs::write(&file, make("LRFI", "", None)).unwrap();
    let lattice = Lattice { dx: 0.004, along: 1, dy: 0.14, columns: 1 };
    let text = format!("kind = \"profile\"\nfile = '{}'", file.display());
    let scene = crate::test_models::scene(&crate::test_models::with_road(crate::scene::PLATE, &text)).scene;
    let error = refused(&scene.road, lattice);
    assert!(error.is_of_another_kind() && error.to_string().contains("kind = \"opencrg\""), "{error}");
    std::fs::write(&file, b"\x93NUMPY\x01\x00").unwrap();
    assert!(refused(&scene.road, lattice).to_string().contains("kind = \"grid\""));
    assert!(refused(&Road::OpenCrg(spec(file)), lattice).to_string().contains("kind = \"grid\""));
}

#[test]
fn range_and_rms_of_a_road_are_those_of_the_same_heights() {
    // A long wave of 20 mm, of which the drawn metre shows little.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("waves.csv");
    let row = |row: u32| format!("{},{}\n", f64::from(row) * 0.05, 10.0 * (f64::from(row) * 0.05 * 0.3).sin());
    std::fs::write(&file, (0..2000).map(row).collect::<String>()).unwrap();
    let text = format!("kind = \"profile\"\nfile = '{}'\ndistance_unit = \"m\"\nheight_unit = \"mm\"", file.display());
    let scene = crate::test_models::scene(&crate::test_models::with_road(crate::scene::PLATE, &text)).scene;
    let lattice = Lattice { dx: 0.004, along: 1, dy: 0.14, columns: 1 };
    let road = describe(&scene.road, lattice, 22.0, Limits::default()).unwrap();
    assert!(road.span > 0.019 && (road.span / road.rms - 8.0_f64.sqrt()).abs() < 0.3, "{} {}", road.span, road.rms);
    let plane = describe(&Road::Smooth, lattice, 22.0, Limits::default()).unwrap();
    assert!(plane.span.abs() < 1e-15 && plane.rms.abs() < 1e-15);
}

#[test]
fn damaged_belgian_block_is_refused_with_the_likely_cause() {
    let whole = std::fs::read(reference(COBBLES)).unwrap();
    let start = header_length(&whole);
    // Some heights contain the bytes of a CR LF: a transfer as text removes one byte each.
    let mut damaged = whole[..start].to_vec();
    for (place, &byte) in whole.iter().enumerate().skip(start) {
        if byte != b'\r' || whole.get(place + 1) != Some(&b'\n') {
            damaged.push(byte);
        }
    }
    assert!(damaged.len() < whole.len());
    let folder = tempfile::tempdir().unwrap();
    let error = fault(&write(&folder, "damaged.crg", &damaged));
    println!("{error}");
    assert!(matches!(
        error,
        FileFault::Payload { rows: 1001, channels: 342, expected: 1_369_368, padded: 1_369_440, .. }
    ));
    assert!(error.to_string().contains("CR LF became LF"));
}

#[test]
fn belgian_block_is_read_and_cut() {
    let file = reference(COBBLES);
    let road = read(&file);
    assert_eq!((road.rows(), road.v.len()), (1001, 341));
    let missing = road.grid.iter().filter(|z| z.is_nan()).count() as f64 / road.grid.len() as f64;
    assert!((missing - 0.0651).abs() < 5e-4, "{missing}");
    assert!(road.grid.iter().filter(|z| !z.is_nan()).all(|z| (2.0..2.2).contains(z)));
    let scene = Road::OpenCrg(spec(file));
    let reported = describe(&scene, lattice(), 80.0 / 3.6, Limits::default()).unwrap();
    let extent = reported.extent.unwrap();
    assert!(extent.0.abs() < 1e-12 && (extent.1 - 10.0).abs() < 1e-9);
    for (wavelength, published) in [(0.1, 61.8), (0.05, 55.0)] {
        let found =
            reported.levels.iter().find(|band| (band.wavelength / wavelength - 1.0).abs() < 0.01).unwrap().level;
        println!("{wavelength} m: {found:.1} dB, published for the whole width {published} dB");
        assert!((found - published).abs() < 2.0);
    }
    assert_eq!(reported.highest_frequency.map(f64::round), Some(1111.0));
    assert!(reported.report.notes.iter().any(|note| matches!(note, RoadNote::Coarse { .. })));
    assert!(
        reported.report.notes.iter().any(|note| matches!(note, RoadNote::Columns { total: 341, incomplete: 33, .. }))
    );
}

#[test]
fn belgian_block_levels_over_all_complete_columns() {
    let road = read(&reference(COBBLES));
    let mut spectrum = crate::road::texture::ProfileSpectrum::new(1001, 0.01);
    for column in 33..341 {
        spectrum.add(&(0..1001).map(|row| road.elevation(row, column)).collect::<Vec<f64>>());
    }
    for (band, published) in [(-10, 61.8), (-13, 55.0), (-17, 40.2)] {
        let found = spectrum.level(band);
        println!("band {band}: {found:.2} dB, published {published} dB");
        assert!((found - published).abs() < 0.3, "{found} for {published}");
    }
}

#[test]
fn handmade_straight_roads_are_one_road() {
    let names = ["straight", "straight_minimalist", "straight_double"];
    let [straight, minimalist, double] = &names.map(|name| read(&handmade(name)));
    let bits =
        |road: &Crg| road.grid.iter().map(|z| if z.is_nan() { None } else { Some(z.to_bits()) }).collect::<Vec<_>>();
    assert_eq!(bits(straight), bits(minimalist));
    assert_eq!(bits(straight), bits(double));
    assert_eq!(straight.v, minimalist.v);
    assert_eq!(straight.v, double.v);
    assert_eq!((straight.rows(), straight.v.len()), (23, 7));
    assert_eq!(straight.grid.iter().filter(|z| z.is_nan()).count(), 3);
    assert!((straight.elevation(14, 6) + 0.022_222_2).abs() < 1e-12);
    assert!(straight.elevation(0, 3).abs() < 1e-12 && straight.elevation(7, 6).is_nan());
}

#[test]
fn handmade_slopes_bankings_and_circles() {
    let road = read(&handmade("sloped"));
    // Rows 0 to 4 of the text: slopes unused, 0, 0.011, 0.022, 0.033.
    assert!((road.line[4] - 0.066).abs() < 1e-12 && road.line[0].abs() < 1e-12);
    assert!((road.elevation(3, 3) - (0.033 + 0.011_111_1)).abs() < 1e-12);
    assert_eq!(road.v, [-1.5, -1.25, -1.0, 0.0, 1.0, 1.25, 1.5]);
    let road = read(&handmade("curved_banked_sloped"));
    assert_eq!(road.grid.iter().filter(|z| z.is_nan()).count(), 3);
    // Row 2: banking 0.011, slope sum 0.011, v = 1: 0.0111111 in the grid.
    assert!((road.elevation(2, 4) - (0.011_111_1 + 0.011 + 0.011)).abs() < 1e-12);
    assert!((road.elevation(2, 6) - (0.011 + 0.011 * 1.5)).abs() < 1e-12);
    assert_eq!(read(&handmade("circle")).rows(), 25);
    let road = read(&handmade("platform"));
    assert!((road.elevation(1, 3) - 1.5).abs() < 1e-12 && (road.elevation(2, 3) - 0.999_999_9).abs() < 1e-12);
    assert!(road.line.iter().all(|z| z.abs() < 1e-12));
}

#[test]
fn strip_of_an_uneven_road_is_interpolated_and_levelled() {
    let mut road = open(
        &Road::OpenCrg(OpenCrgRoad { lateral_position: Some(0.5), ..spec(handmade("sloped")) }),
        Lattice { dx: 0.25, along: 1, dy: 0.02, columns: 10 },
    );
    assert!(road.report().notes.iter().any(|note| matches!(note, RoadNote::UnevenColumns { .. })));
    assert!(road.check_covers(0.0, 22.0).is_ok() && road.check_covers(0.0, 22.1).is_err());
    assert!(rows(&mut road, 0, 89).iter().all(|z| z.abs() < 1.0));
}

#[test]
fn columns_with_holes_are_avoided() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(&folder, "hole.crg", &make("KDBI", "", Some((4, 0))));
    let at = |position: Option<f64>| Road::OpenCrg(OpenCrgRoad { lateral_position: position, ..spec(file.clone()) });
    let narrow = Lattice { dx: 0.1, along: 1, dy: 0.01, columns: 10 };
    let road = open(&at(None), narrow);
    let expected = |note: &RoadNote| match note {
        RoadNote::Columns { total: 9, incomplete: 1, missing_points: 1, lateral_position, .. } => {
            (lateral_position - 0.025).abs() < 1e-9
        }
        _ => false,
    };
    assert!(road.report().notes.iter().any(expected), "{:?}", road.report().notes);
    // At the border the column with one missing height in thirty is needed, and filled.
    assert!(
        open(&at(Some(-0.15)), narrow)
            .report()
            .notes
            .iter()
            .any(|note| matches!(note, RoadNote::Filled { missing: 1, .. }))
    );
    assert!(matches!(refused(&at(Some(0.18)), narrow), RoadError::LateralPosition { .. }));
    assert!(matches!(refused(&at(Some(f64::NAN)), narrow), RoadError::LateralPosition { .. }));
    assert!(matches!(
        refused(&at(None), Lattice { dx: 0.1, along: 1, dy: 0.05, columns: 10 }),
        RoadError::Narrow { .. }
    ));
}

#[test]
fn modifiers_scale_and_fill() {
    let folder = tempfile::tempdir().unwrap();
    let extra =
        "$ROAD_CRG_MODS\nscale_z_grid = 2\ngrid_nan_mode = 2.000+e00\ngrid_nan_offset = 0.5\nrefline_offset_x = 3\n$\n";
    let road = read(&write(&folder, "mods.crg", &make("KDBI", extra, Some((4, 0)))));
    assert!((road.elevation(4, 0) - (2.0 * height(4, 1) + 0.5)).abs() < 1e-12);
    assert!((road.elevation(7, 3) - 2.0 * height(7, 3)).abs() < 1e-15);
    assert!(road.notes.contains(&RoadNote::MissingByModifier { count: 1, mode: "nearest across" }));
    assert!(road.notes.contains(&RoadNote::Ignored { key: String::from("$ROAD_CRG_MODS refline_offset_x") }));
}

#[test]
fn includes_stay_inside_the_folder() {
    let outer = tempfile::tempdir().unwrap();
    let inner = outer.path().join("scene");
    std::fs::create_dir_all(inner.join("deep")).unwrap();
    let put = |place: PathBuf, text: &[u8]| {
        std::fs::write(&place, text).unwrap();
        place
    };
    let include = |name: &str| {
        format!("$CT\nx\n$\n$ROAD_CRG_MODS\nscale_z_grid = 3\n$\n$ROAD_CRG_FILE\n{name}\n$\n").into_bytes()
    };
    put(inner.join("deep/real.crg"), &make("KDBI", "", None));
    put(outer.path().join("secret.crg"), &make("KDBI", "", None));
    let road = read(&put(inner.join("a.crg"), &include("deep/real.crg")));
    assert!((road.elevation(7, 3) - 3.0 * height(7, 3)).abs() < 1e-15, "the outer file's modifiers count");
    for escape in [
        "../secret.crg".to_owned(),
        "deep/../../secret.crg".to_owned(),
        outer.path().join("secret.crg").display().to_string(),
    ] {
        let error = fault(&put(inner.join("b.crg"), &include(&escape)));
        assert!(matches!(error, FileFault::IncludeOutside { .. }), "{error}");
    }
    put(inner.join("deep/up.crg"), &include("../c.crg"));
    assert!(matches!(fault(&put(inner.join("c.crg"), &include("deep/up.crg"))), FileFault::IncludeCycle { .. }));
    assert!(matches!(fault(&put(inner.join("d.crg"), &include("d.crg"))), FileFault::IncludeCycle { .. }));
    assert!(matches!(fault(&put(inner.join("e.crg"), &include("absent.crg"))), FileFault::Include { .. }));
}

#[test]
fn repeated_and_mirrored_cobbles_continue() {
    for at_end in [AtEnd::Repeat, AtEnd::Mirror] {
        let mut road = open(&Road::OpenCrg(OpenCrgRoad { at_end, ..spec(reference(COBBLES)) }), lattice());
        assert!(road.extent().is_none());
        assert!(rows(&mut road, 100_000, 50).iter().all(|z| z.abs() < 0.2));
    }
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(300))]

    /// Reading a mangled file must end with a road or an error.
    #[test]
    fn mangled_files_never_panic(
        format in 0..4_usize,
        changes in proptest::collection::vec((0..100_000_usize, proptest::prelude::any::<u8>()), 0..12),
        cut in 0..100_000_usize,
        keep_whole in proptest::prelude::any::<bool>(),
        position in -0.5..0.5_f64,
    ) {
        let format = ["LRFI", "LDFI", "KRBI", "KDBI"][format];
        let mut bytes = make(format, "$ROAD_CRG_MODS\nscale_width = 1\n$\n", Some((4, 0)));
        let length = bytes.len();
        for (place, value) in changes {
            bytes[place % length] = value;
        }
        if !keep_whole {
            bytes.truncate(cut % length);
        }
        let folder = tempfile::tempdir().unwrap();
        let file = write(&folder, "m.crg", &bytes);
        let scene =
            OpenCrgRoad { lateral_position: Some(position), longest_wavelength: Some(1.0), ..spec(file) };
        let lattice = Lattice { dx: 0.05, along: 1, dy: 0.01, columns: 10 };
        if let Ok(mut road) = RoadSurface::open(&Road::OpenCrg(scene), lattice, Limits { bytes: 1 << 24 }) {
            let mut out = [f64::NAN; 30];
            if road.heights(0, 3, &mut out).is_ok() {
                proptest::prop_assert!(out.iter().all(|z| z.is_finite()));
            }
        }
    }
}
