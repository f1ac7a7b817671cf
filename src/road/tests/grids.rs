//! Height maps as text, and roads narrower than the contact.

use super::*;
use crate::road::sources::grid_stream::GridStream;
use crate::scene::{AtEnd, GridRoad, LengthUnit, Levelling, OpenCrgRoad, Widen};

fn text(file: PathBuf, unit: Option<LengthUnit>) -> GridRoad {
    GridRoad { dx: None, dy: None, distance_unit: unit, height_unit: unit, ..super::measured::grid(file, 1.0, 1.0) }
}

/// Heights of a grid of 30 x 8 places, 2 and 5 mm apart, row-major, with rows along x.
fn heights_of(spec: &GridRoad) -> Vec<f64> {
    let lattice = Lattice { dx: 0.002, along: 1, dy: 0.005, columns: 8 };
    rows(&mut open(&Road::Grid(spec.clone()), lattice), 0, 30)
}

fn height(row: usize, column: usize) -> f64 {
    (0.7 * row as f64).sin() + 0.3 * (1.3 * column as f64 + 0.1 * row as f64).cos()
}

#[test]
fn points_and_esri_grids_are_the_same_road_as_their_array() {
    let folder = tempfile::tempdir().unwrap();
    let place = |at: usize| (at / 8, at % 8);
    let array = npy(&[30, 8], npyz::Order::C, (0..240).map(|at| height(place(at).0, place(at).1)));
    let array = super::measured::grid(write(&folder, "a.npy", &array), 0.002, 0.005);
    let wanted = heights_of(&GridRoad { height_unit: Some(LengthUnit::Millimetre), ..array });
    let point = |at: usize| {
        let (row, column) = place(at * 77 % 240);
        (2 * row, 5 * column, height(row, column))
    };
    let cloud = |titles: &str, line: &dyn Fn((usize, usize, f64)) -> String| {
        titles.to_owned() + &(0..240).map(|at| line(point(at))).collect::<String>()
    };
    let millimetres = Some(LengthUnit::Millimetre);
    let line = |row: usize| (0..30).map(|x| format!(" {}", height(x, 7 - row))).collect::<String>();
    let esri = "NCOLS 30\nNROWS 8\nxllcorner 0\nyllcorner 0\ndx 2\ndy 5\nNODATA_value -9999\n".to_owned()
        + &(0..8).map(|row| line(row) + "\n").collect::<String>();
    for (name, text_of, unit) in [
        ("a.xyz", cloud("", &|(x, y, z)| format!("{x} {y} {z}\n")), millimetres),
        ("b.xyz", cloud("x (mm);y (mm);z (mm)\n", &|(x, y, z)| format!("{x};{y};{z}\n").replace('.', ",")), None),
        ("c.csv", cloud("n,z_mm,y_mm,x_mm\n", &|(x, y, z)| format!("7,{z},{y},{x}\n")), None),
        ("d.asc", esri.clone(), millimetres),
    ] {
        let found = heights_of(&text(write(&folder, name, text_of.as_bytes()), unit));
        assert!(found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{name}");
    }
    let hole = esri.replacen(&format!(" {}", height(5, 7)), " -9999", 1);
    let mut report = RoadReport::default();
    let spec = Road::Grid(text(write(&folder, "hole.asc", hole.as_bytes()), millimetres));
    let lattice = Lattice { dx: 0.002, along: 1, dy: 0.005, columns: 8 };
    crate::road::sources::Source::read(&spec, lattice, u64::MAX, &mut report).unwrap();
    assert_eq!(report.missing, 1);
}

#[test]
fn rounded_coordinates_make_the_grid_before_rounding() {
    let folder = tempfile::tempdir().unwrap();
    let points = (0..4).flat_map(|y| (0..80).map(move |x| (x, y)));
    let line = |(x, y): (usize, usize)| format!("{:.2} {y} {:.4}\n", 0.125 * x as f64, 0.1 * height(x, y));
    let file = write(&folder, "rounded.xyz", points.map(line).collect::<String>().as_bytes());
    let spec = Road::Grid(text(file, Some(LengthUnit::Millimetre)));
    let lattice = Lattice { dx: 0.125e-3, along: 1, dy: 0.001, columns: 4 };
    let read = crate::road::sources::Source::read(&spec, lattice, u64::MAX, &mut RoadReport::default()).unwrap();
    let crate::road::sources::Source::Measured(map, _) = read else { panic!("no measured road") };
    assert_eq!((map.rows(), map.columns), (80, 4));
    assert!((map.dx - 0.125e-3).abs() < 1e-7, "{}", map.dx);
}

#[test]
fn text_that_is_no_grid_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let scan = std::fs::read_to_string(reference("measured/formats/scan.xyz")).unwrap();
    let millimetres = Some(LengthUnit::Millimetre);
    let scattered = |i: i32| format!("{:.3} {:.3} 1\n", 9.0 * f64::from(i).sin(), 5.0 * f64::from(i).cos());
    let esri = "ncols 4\nnrows 3\ncellsize 2\n1 2 3 4\n5 6 7 8\n9 10 11 12\n";
    for (name, text_of, unit, part) in [
        ("a.xyz", scan.clone(), None, "road.distance_unit"),
        ("b.xyz", scan.clone() + "3.4 1.0 2.0\n", millimetres, "line 51: the distance 0.0034 m is not on a grid"),
        ("c.xyz", scan.repeat(2), millimetres, "lines 1 and 51 are points at the same place"),
        ("d.xyz", scan.lines().map(|line| format!("{line} 7\n")).collect(), millimetres, "4 columns"),
        ("rgb.xyz", scan.lines().map(|line| format!("{line} 7 8 9\n")).collect(), millimetres, "columns = [1, 2, 3]"),
        ("scatter.xyz", (0..50).map(scattered).collect(), millimetres, "50 points lie on no grid"),
        ("e.xyz", scan.replace("0.2786", "wet"), millimetres, "line 1, column 3 (height): \"wet\" is not a number"),
        ("f.asc", esri.replace("9 10 11", "9 10"), millimetres, "promises 3 rows of data, 2 are there"),
        ("g.asc", esri.replace("ncols 4", "ncols 4e9"), millimetres, "promises 3 rows"),
        ("h.asc", esri.replace("cellsize 2\n", ""), millimetres, "no cellsize"),
        ("i.asc", esri.to_owned(), None, "road.distance_unit"),
    ] {
        let spec = Road::Grid(text(write(&folder, name, text_of.as_bytes()), unit));
        let message = refused(&spec, Lattice { dx: 0.001, along: 1, dy: 0.001, columns: 3 }).to_string();
        assert!(message.contains(part), "{name}: {message}");
    }
}

#[test]
fn a_narrow_road_is_continued_by_its_mirror_images() {
    let crg = |widen| {
        let (file, at_end) = (reference("measured/width/narrow_100mm.crg"), AtEnd::Refuse);
        let (missing, level) = (None, Levelling::Slope);
        Road::OpenCrg(OpenCrgRoad {
            file,
            lateral_position: None,
            widen,
            missing,
            level,
            longest_wavelength: None,
            at_end,
        })
    };
    let scan = |widen| {
        let millimetres = Some(LengthUnit::Millimetre);
        Road::Grid(GridRoad { widen, ..text(reference("measured/formats/scan.xyz"), millimetres) })
    };
    let lattice = |dx: f64, dy: f64, columns| Lattice { dx, along: 1, dy, columns };
    let crg_lattice = lattice(0.005, 0.005, 35);
    for (road, mirrored, lattice, measured, elements) in [
        (crg(Widen::Refuse), crg(Widen::Mirror), crg_lattice, 21, 400),
        (scan(Widen::Refuse), scan(Widen::Mirror), lattice(0.001, 0.001, 13), 5, 9),
    ] {
        let described = describe(&road, lattice, 20.0, Limits::default()).unwrap();
        assert!(described.rms > 1e-6 && described.lattice.columns <= measured, "{:?}", described.lattice);
        assert!(described.report.notes.iter().any(|note| matches!(note, RoadNote::Narrow { .. })));
        let message = refused(&road, lattice).to_string();
        assert!(message.contains("road.widen = \"mirror\"") && message.contains("at most"), "{message}");
        let mut road = open(&mirrored, lattice);
        assert!(road.report().notes.iter().any(|note| matches!(note, RoadNote::Mirrored { .. })));
        let (columns, edge) = (lattice.columns, (lattice.columns - measured) / 2);
        for row in rows(&mut road, 0, elements).chunks_exact(columns) {
            for beside in 1..=edge {
                let pairs =
                    [[edge - beside, edge + beside], [columns - 1 - edge + beside, columns - 1 - edge - beside]];
                assert!(pairs.iter().all(|&[out, inside]| (row[out] - row[inside]).abs() < 1e-9));
            }
        }
    }
}

/// A grid of 1500 x 12 heights, 4 mm apart, on a slope and with hills, with a hole, a spike and numbers for none.
fn long_grid(folder: &tempfile::TempDir) -> GridRoad {
    let height = |at: usize| {
        let (row, column) = (at / 12, at % 12);
        let texture = 1e-3 * height(row, column) + 1e-5 * row as f64 + 0.01 * (0.008 * row as f64).sin();
        match (row, column) {
            (700..703, 2..5) | (0, 0) => f64::NAN,
            (401, 5) => texture + 0.05,
            (_, 7) if row % 97 == 5 => -9.999,
            _ => texture - 2e-4 * column as f64,
        }
    };
    let array = npy(&[1500, 12], npyz::Order::C, (0..1500 * 12).map(height));
    let grid = super::measured::grid(write(folder, "long.npy", &array), 0.004, 0.004);
    GridRoad { missing: Some(vec![crate::scene::MissingHeight::Number(-9.999)]), ..grid }
}

#[test]
fn a_grid_in_pieces_is_the_grid_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let lattice = Lattice { dx: 0.0037, along: 1, dy: 0.005, columns: 8 };
    for (level, longest_wavelength, at_end) in [
        (Levelling::Slope, None, AtEnd::Refuse),
        (Levelling::Mean, Some(0.1), AtEnd::Repeat),
        (Levelling::Off, None, AtEnd::Mirror),
    ] {
        let spec = GridRoad { level, longest_wavelength, at_end, ..long_grid(&folder) };
        let mut whole = open(&Road::Grid(spec.clone()), lattice);
        let mut report = RoadReport::default();
        let sizes = ([0, 12 * 8 * 160], u64::MAX);
        let stream = GridStream::open(&spec, lattice.width(), sizes, &mut report).unwrap().unwrap();
        assert!(stream.pieces() > 3, "{}", stream.pieces());
        let mut pieces = RoadSurface::in_pieces(lattice, stream, at_end, report).unwrap();
        assert_eq!((whole.extent(), whole.period()), (pieces.extent(), pieces.period()));
        let begin = if at_end == AtEnd::Refuse { 0 } else { -300 };
        // Backwards, too: from the end of the road to its begin.
        for first in [begin, 900, 1200, 200] {
            let (a, b) = (rows(&mut whole, first, 400), rows(&mut pieces, first, 400));
            let worst = a.iter().zip(&b).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
            assert!(worst < 1e-12, "{level:?}: {worst} m from {first} on");
        }
        assert!((whole.highest() - pieces.highest()).abs() < 1e-12);
        let [a, b] = [&whole, &pieces].map(RoadSurface::report);
        assert_eq!((a.points, a.missing, a.length, a.spacing), (b.points, b.missing, b.length, b.spacing));
        let counts = |report: &RoadReport| -> Vec<RoadNote> {
            let is_count = |note: &&RoadNote| {
                matches!(note, RoadNote::NamedMissing { .. } | RoadNote::Filled { .. } | RoadNote::Spikes { .. })
            };
            report.notes.iter().filter(is_count).cloned().collect()
        };
        assert!(counts(a).len() == 3 && counts(a) == counts(b), "{:?} {:?}", counts(a), counts(b));
        // Waves of centimetres have one spectrum whole and in pieces.
        let [a, b] = [whole.macrotexture(), pieces.macrotexture()].map(Option::unwrap);
        assert!((a / b - 1.0).abs() < 0.1, "{a} {b}");
        let profiles = |road: &RoadSurface| {
            let mut profiles = RoadProfiles::of(road, Limits::default()).unwrap().unwrap();
            profiles.between(1.0, 3.0).unwrap()
        };
        let (a, b) = (profiles(&whole), profiles(&pieces));
        assert_eq!((a.len(), a[0].len(), b.len(), b[0].len()), (8, 500, 8, 500));
        assert!(a.concat().iter().zip(&b.concat()).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}

#[test]
fn a_number_for_none_in_a_long_grid_has_to_be_named() {
    let folder = tempfile::tempdir().unwrap();
    let spec = GridRoad { missing: None, ..long_grid(&folder) };
    let refused =
        GridStream::open(&spec, 0.04, ([0, 12 * 8 * 160], u64::MAX), &mut RoadReport::default()).err().unwrap();
    assert!(refused.to_string().contains("road.missing = -9.999"), "{refused}");
    let short = GridStream::open(&spec, 0.04, ([u64::MAX, 1], u64::MAX), &mut RoadReport::default()).unwrap();
    assert!(short.is_none());
    let narrow = GridStream::open(&long_grid(&folder), 0.2, ([0, 1], u64::MAX), &mut RoadReport::default());
    assert!(matches!(narrow, Err(RoadError::Narrow { .. })));
}
