//! Tables as found in practice: columns, units, encodings, and files that are no roads.

use super::*;
use crate::road::sources::conditioning::condition;
use crate::road::sources::height_map::RoadHeightMap;
use crate::road::texture::HeightOrigin;
use crate::scene::{LengthUnit, ProfileRoad};

const MILLIMETRES: [Option<LengthUnit>; 2] = [Some(LengthUnit::Millimetre); 2];

fn profile(file: PathBuf, [distance_unit, height_unit]: [Option<LengthUnit>; 2]) -> ProfileRoad {
    ProfileRoad { distance_unit, height_unit, ..super::measured::profile(file) }
}

fn read(spec: &ProfileRoad) -> Result<(RoadHeightMap, Vec<RoadNote>), RoadError> {
    let mut report = RoadReport::default();
    let mut map = crate::road::sources::profile::read(spec, u64::MAX, &mut report)?;
    condition(&mut map, spec.level, spec.longest_wavelength, &mut report)?;
    map.check_smoothness(false, &mut report.notes)?;
    Ok((map, report.notes))
}

fn columns_reported(notes: &[RoadNote]) -> String {
    notes.iter().find(|note| matches!(note, RoadNote::FileColumns { .. })).unwrap().to_string()
}

/// Lines of distance and height in the same unit, with a delimiter and a decimal sign.
fn lines(delimiter: &str, decimal: &str) -> String {
    let number = |value: f64| format!("{value:.3}").replace('.', decimal);
    let line = |i| format!("{}{delimiter}{}\n", number(0.5 * f64::from(i)), number((0.7 * f64::from(i)).sin()));
    (0..40).map(line).collect()
}

#[test]
fn a_counter_beside_distance_and_height_is_no_height() {
    for (name, reported) in [
        (
            "number_distance_height",
            "distance from column 2 \"distance_mm\" in mm, height from column 3 \"height_mm\" in mm",
        ),
        ("title_says_mm", "distance from column 1 \"Distance (mm)\" in mm, height from column 2 \"Height (mm)\" in mm"),
    ] {
        let spec = profile(reference(&format!("measured/columns/{name}.csv")), [None; 2]);
        assert!(columns_reported(&read(&spec).unwrap().1).contains(reported));
        let road = Road::Profile(spec);
        let lattice = Lattice::choose(&road, 0.004, 0.14, None, None).unwrap();
        let depth = describe(&road, lattice, 20.0, Limits::default()).unwrap().mean_profile_depth.unwrap();
        assert!((depth.mean.unwrap() - 1.243e-3).abs() < 1e-6, "{name}: {depth:?}");
    }
}

#[test]
fn tables_of_all_shapes_hold_the_same_heights() {
    let measured = |name: &str| reference(&format!("measured/formats/{name}"));
    let (wanted, _) = read(&profile(measured("units_row.csv"), [None; 2])).unwrap();
    assert_eq!((wanted.rows(), wanted.dx), (40, 0.5e-3));
    for (name, units) in [
        ("decimal_comma.csv", MILLIMETRES),
        ("preamble.csv", [None; 2]),
        ("profile.erd", [None; 2]),
        ("whitespace.txt", MILLIMETRES),
    ] {
        let (map, _) = read(&profile(measured(name), units)).unwrap();
        assert!(map.heights.iter().zip(&wanted.heights).all(|(a, b)| (a - b).abs() < 1e-12), "{name}");
        assert!((map.dx - wanted.dx).abs() < 1e-12 && map.rows() == 40 && map.origins.is_empty(), "{name}");
    }
    let (words, notes) = read(&profile(measured("bad_word.csv"), [None; 2])).unwrap();
    let text = std::fs::read_to_string(measured("bad_word.csv")).unwrap();
    assert!(
        words.origins.iter().filter(|origin| **origin == HeightOrigin::Missing).count() == text.matches("Bad").count(),
        "{notes:?}"
    );
}

#[test]
fn titles_units_encodings_and_comments_are_understood() {
    let folder = tempfile::tempdir().unwrap();
    let plain = |titles: &str, delimiter: &str, decimal: &str| titles.to_owned() + &lines(delimiter, decimal);
    let tables = [
        plain("distance_mm;height_mm\n", ";", ","),
        plain("Weg [mm]\tH\u{f6}he [mm]\n", "\t", ","),
        plain("Distance (mm) Height (mm)\n", "  ", "."),
        plain("# distance_mm height_mm\n", " ", "."),
        plain("% made by a program\n% Distance (mm)\tHeight (mm)\n", "\t", "."),
        plain("sep=;\n\"Distance (mm)\";\"Height (mm)\"\n", ";", ","),
        plain("// line 1\nx;z\n[mm];[mm]\n", ";", "."),
        plain("Operator;M\u{fc}ller\nLane;2\n\nx in mm;z in mm;\n", ";", ",").replace('\n', ";\n"),
        plain("Date,Time\n2024-03-01,12:30\ndistance (mm),height (mm)\n", ",", "."),
        lines(",", ".").lines().fold("height_mm,distance_mm\n".to_owned(), |text, line| {
            let (distance, height) = line.split_once(',').unwrap();
            text + &format!("{height},{distance}\n")
        }),
        lines(",", ".").lines().fold("Time,Distance (mm),Quality,Height (mm)\n".to_owned(), |text, line| {
            let (distance, height) = line.split_once(',').unwrap();
            text + &format!("12:00:01,{distance},ok,{height}\n")
        }),
        lines(" ", ".").lines().fold("distance_m height_m\n".to_owned(), |text, line| {
            let (distance, height) = line.split_once(' ').unwrap();
            text + &format!("{distance}D-3 {height}d-03\n")
        }),
    ];
    let (wanted, _) = read(&profile(write(&folder, "plain.csv", lines(",", ".").as_bytes()), MILLIMETRES)).unwrap();
    for text in tables {
        let latin: Vec<u8> = text.chars().map(|sign| u8::try_from(u32::from(sign)).unwrap()).collect();
        let wide: Vec<u8> = format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect();
        let returns = text.replace('\n', "\r\n");
        for bytes in [text.as_bytes(), &latin, &wide, returns.as_bytes()] {
            let (map, _) = read(&profile(write(&folder, "table", bytes), [None; 2])).unwrap();
            assert!(map.heights.iter().zip(&wanted.heights).all(|(a, b)| (a - b).abs() < 1e-12), "{text}");
            assert!(map.rows() == wanted.rows() && (map.dx - wanted.dx).abs() < 1e-12, "{text}");
        }
    }
    for (titles, along, up) in
        [("Distance (in),Height (mil)\n", 25.4, 0.0254), ("distance_ft,height [cm]\n", 304.8, 10.0)]
    {
        let (map, _) = read(&profile(write(&folder, "feet", plain(titles, ",", ".").as_bytes()), [None; 2])).unwrap();
        assert!((map.dx / wanted.dx - along).abs() < 1e-9 && (map.heights[3] / wanted.heights[3] - up).abs() < 1e-9);
    }
}

#[test]
fn ambiguous_tables_are_refused_with_the_choice() {
    let folder = tempfile::tempdir().unwrap();
    let message = |text: &str, units: [Option<LengthUnit>; 2]| {
        read(&profile(write(&folder, "table", text.as_bytes()), units)).unwrap_err().to_string()
    };
    let pass = lines(",", ".");
    let back: String = pass.lines().rev().map(|line| format!("{line}\n")).collect();
    let far: String = (0..40).map(|i| format!("{:.1},0.{i}\n", 5e3 + 0.5 * f64::from(i))).collect();
    let three = |titles: &str| {
        pass.lines().enumerate().fold(titles.to_owned(), |text, (number, line)| text + &format!("{number},{line}\n"))
    };
    let counted = (0..40).fold("n,z\n".to_owned(), |text, i| text + &format!("{i},{:.3}\n", f64::from(i).sin()));
    for (text, units, parts) in [
        (three(""), MILLIMETRES, ["3 columns", "columns = [2, 3]"]),
        (three("a,b,c\n"), MILLIMETRES, ["\"a, b, c\"", "--columns 2,3"]),
        (three("x,height left,height right\n"), MILLIMETRES, ["3 columns", "distance, height"]),
        (counted.clone(), MILLIMETRES, ["column 1 \"n\"", "counts"]),
        ("distance,height\n".to_owned() + &lines(",", ","), MILLIMETRES, ["4 cells", "decimal"]),
        (lines(",", ","), MILLIMETRES, ["line 1", "export it with ;"]),
        (pass.repeat(3), MILLIMETRES, ["line 41", "3 passes"]),
        (pass.clone() + &back, MILLIMETRES, ["line ", "2 passes"]),
        (format!("x,z\n{pass}\nx,z\n{pass}"), MILLIMETRES, ["line 43", "2 passes"]),
        (format!("Run 1\nx,z\n{pass}Run 2\nx,z\n{pass}"), MILLIMETRES, ["line 43", "2 passes"]),
        (pass.clone() + &far, MILLIMETRES, ["line 41: the distance jumps", "several passes"]),
        (
            "x (m),z (um)\n".to_owned() + &pass,
            MILLIMETRES,
            ["line 1: the title \"x (m)\" says m", "road.distance_unit = \"mm\""],
        ),
        ("x,z\nmm,um\n".to_owned() + &pass, MILLIMETRES, ["\"z\" says um", "road.height_unit = \"mm\""]),
        ("x (mm),z (um)\n".to_owned() + &pass, [None; 2], ["it is flat", "road.height_unit"]),
        ("x,z (um)\n".to_owned() + &pass, [None; 2], ["road.distance_unit", "\"ft\""]),
        (
            pass.lines().map(|line| line.split_once(',').unwrap().1.to_owned() + "\n").collect(),
            MILLIMETRES,
            ["one column", "distance"],
        ),
        ("A page of prose.\nIt has no numbers, none.\n".to_owned(), MILLIMETRES, ["Read are", "ESRI"]),
        ("PK\u{3}\u{4}\u{14}".to_owned(), MILLIMETRES, ["X3P and Excel", "Read are"]),
        ("ERDFILEV2.00\n1, 4, -1, 4, 1, 0.25, -1\nEND\n".to_owned(), MILLIMETRES, ["binary data", "as text"]),
    ] {
        let message = message(&text, units);
        assert!(parts.iter().all(|part| message.contains(part)), "{message}\n{text:.300}");
    }
    let chosen = |columns: [&str; 2], text: &str| {
        let file = write(&folder, "table", text.as_bytes());
        read(&ProfileRoad { columns: Some(columns.map(str::to_owned).to_vec()), ..profile(file, MILLIMETRES) })
    };
    let (wanted, _) = read(&profile(write(&folder, "plain", pass.as_bytes()), MILLIMETRES)).unwrap();
    for (columns, titles) in [(["2", "3"], ""), (["b", "c"], "a,b,c\n"), (["B", "3"], "a,b (mm),c\n")] {
        assert_eq!(chosen(columns, &three(titles)).unwrap().0.heights, wanted.heights);
    }
    assert!(chosen(["1", "2"], &counted).is_ok(), "what is chosen may count");
    let (_, notes) = read(&profile(write(&folder, "table", &counted.as_bytes()[4..]), MILLIMETRES)).unwrap();
    assert!(notes.contains(&RoadNote::Counts { column: 1, unit: "mm" }), "{notes:?}");
    assert!(chosen(["1", "4"], &three("")).unwrap_err().to_string().contains("3 columns without titles"));
}

/// Returns a table with another line in place of one, counted from 1.
fn with_line(text: &str, number: usize, line: &str) -> String {
    text.lines().zip(1..).map(|(old, at)| format!("{}\n", if at == number { line } else { old })).collect()
}

#[test]
fn titles_of_other_quantities_or_units_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let of = |text: &str| read(&profile(write(&folder, "table", text.as_bytes()), MILLIMETRES));
    let pass = lines(",", ".");
    for (titles, part) in [
        ("Chainage (km),Height (mm)\n", "\"km\", the unit of the column \"Chainage (km)\""),
        ("distance_km,height_mm\n", "\"km\""),
        ("Time (s),Height (mm)\n", "\"s\""),
        ("Distance (mm),Signal (V)\n", "\"V\""),
        ("Distance (mm),Height (0.1 mm)\n", "\"0.1 mm\""),
        ("Distance (mm),Level (dB re 1 mm)\n", "\"dB re 1 mm\""),
        ("Distance,Height\nkm,mm\n", "\"km\""),
        ("Distance (mm),Height (mm)\nmm,um\n", "\"Height (mm)\" says mm, the row of units below it um"),
        ("Distance (mm),Depth (mm)\n", "columns = [1, 2]"),
        ("Weg (mm),Tiefe (mm)\n", "column 2 \"Tiefe (mm)\" may count downwards"),
        ("raw (mm),filtered (mm)\n", "2 columns"),
        ("Elevation (mm),Odometer (mm)\n", "columns = [2, 1]"),
        ("Weg (mm),Abstand (mm)\n", "2 columns"),
    ] {
        let message = of(&(titles.to_owned() + &pass)).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
    let counted = (100..140).fold("Sample,Height (mm)\n".to_owned(), |text, i| text + &format!("{i},{}\n", i % 3));
    let message = of(&counted).unwrap_err().to_string();
    assert!(message.contains("column 1 \"Sample\"") && message.contains("counts"), "{message}");
    // What names another quantity drops out; a length in millimetres may count.
    let (wanted, _) = of(&pass).unwrap();
    for titles in [
        ["time_s,distance_mm,height_mm\n", "7"],
        ["Profile no.,Distance (mm),Height (mm)\n", "1"],
        ["Lateral position (mm),Position (mm),Height (in mm)\n", "0"],
    ] {
        let text = pass.lines().fold(titles[0].to_owned(), |text, line| text + &format!("{},{line}\n", titles[1]));
        assert_eq!(of(&text).unwrap().0.heights, wanted.heights, "{titles:?}");
    }
    let whole: String = (0..40).map(|i| format!("{i},{:.3}\n", f64::from(i).sin())).collect();
    assert!((of(&whole).unwrap().0.dx - 1e-3).abs() < 1e-12);
}

#[test]
fn lines_that_do_not_fit_are_refused_with_their_number() {
    let folder = tempfile::tempdir().unwrap();
    let of = |text: &str| read(&profile(write(&folder, "table", text.as_bytes()), MILLIMETRES));
    let [blanks, commas, semicolons] = [" ", ",", ";"].map(|delimiter| lines(delimiter, "."));
    let beside = commas.lines().fold(String::new(), |text, line| {
        let (distance, height) = line.split_once(',').unwrap();
        text + &format!("{line}\n{distance},{:.3}\n", height.parse::<f64>().unwrap() + 0.5)
    });
    let thousands: String = (0..40).map(|i| format!("{};{},{}\n", 2 * i, 1 + i % 3, 100 + i)).collect();
    for (text, part) in [
        (with_line(&blanks, 21, "10.0 1.0 7"), "line 21 has 3"),
        (with_line(&blanks, 21, "10.0"), "line 21 has 1"),
        (with_line(&commas, 21, "10.0,1,048"), "line 21 has 3"),
        (with_line(&commas, 1, "0.0,0.1,0.2"), "line 1 has 3"),
        ("0.5 40\n".to_owned() + &blanks, "line 1: \"0.5 40\" is out of the order"),
        ("40 0.5\n".to_owned() + &blanks, "seems to state their number"),
        (beside, "40 of 80 points lie at the distance of another one"),
        (thousands, "line 1: \"1,100\""),
    ] {
        let message = of(&text).unwrap_err().to_string();
        assert!(message.contains(part), "{message}\n{text:.300}");
    }
    // Cells at the end that are empty may be more or fewer.
    for line in ["10.0;1.0;;", "10.0;", "10.0"] {
        assert!(of(&with_line(&semicolons, 21, line)).is_ok(), "{line}");
    }
}

#[test]
fn channels_of_an_erd_file_are_chosen_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let numbers: String = (0..20).map(|i| format!("{:.3}, {:.3}\n", f64::from(i).sin(), f64::from(i).cos())).collect();
    let header = "ERDFILEV2.00\n 2, 20, -1, 1, 5, 0.25, -1,\nTITLE   Lane 1\nSHORTNAMLElev.  RElev.  \n\
                  UNITSNAMin      in\nXLABEL  Distance\nXUNITS  ft\nEND\n";
    let file = write(&folder, "two.erd", (header.to_owned() + &numbers).as_bytes());
    let message = read(&profile(file.clone(), [None; 2])).unwrap_err().to_string();
    assert!(message.contains("LElev. (in), RElev. (in)") && message.contains("columns = [2]"), "{message}");
    for (name, height) in [("LElev.", f64::sin as fn(f64) -> f64), ("2", f64::cos)] {
        let (map, notes) =
            read(&ProfileRoad { columns: Some(vec![name.into()]), ..profile(file.clone(), [None; 2]) }).unwrap();
        assert!((map.dx - 0.25 * 0.3048).abs() < 1e-12 && map.rows() == 20, "{notes:?}");
        let step = |at: usize| map.heights[at + 1] - 2.0 * map.heights[at] + map.heights[at - 1];
        let wanted = |at: usize| 0.0254 * (height(at as f64 + 1.0) - 2.0 * height(at as f64) + height(at as f64 - 1.0));
        assert!((1..19).all(|at| (step(at) - wanted(at)).abs() < 1e-4), "{name}");
    }
    let cut = write(&folder, "cut.erd", (header.replace(" 2, 20", " 2, 21") + &numbers).as_bytes());
    let cut =
        read(&ProfileRoad { columns: Some(vec!["1".into()]), ..profile(cut, [None; 2]) }).unwrap_err().to_string();
    assert!(cut.contains("promises 21 rows") && cut.contains("20 are there"), "{cut}");
}
