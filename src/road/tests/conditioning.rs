//! Missing heights, spikes and slopes, the same for every kind of road.

use super::measured::{captif, grid};
use super::*;
use crate::scene::{AtEnd, GridRoad, Levelling, MissingHeight, OpenCrgRoad, ProfileRoad, Widen};

/// Contact width \[m\].
const WIDTH: f64 = 0.1;

fn reported(spec: &Road) -> Result<RoadDescription, RoadError> {
    let lattice = Lattice::choose(spec, 0.004, WIDTH, None, None)?;
    describe(spec, lattice, 20.0, Limits::default())
}

fn csv(name: &str) -> ProfileRoad {
    captif(reference(&format!("measured/{name}")))
}

fn depth(road: &RoadDescription) -> f64 {
    road.mean_profile_depth.as_ref().unwrap().mean.unwrap()
}

fn taken(road: &RoadDescription) -> Vec<(f64, usize)> {
    let note = |note: &RoadNote| match *note {
        RoadNote::TakenForMissing { value, count } => Some((value, count)),
        _ => None,
    };
    road.report.notes.iter().filter_map(note).collect()
}

fn spikes(road: &RoadDescription) -> usize {
    let note = |note: &RoadNote| if let RoadNote::Spikes { count, .. } = *note { count } else { 0 };
    road.report.notes.iter().map(note).sum()
}

const ROWS: usize = 300;
const COLUMNS: usize = 61;

/// Height of a surface on 2 mm, no two rows or columns of which are the same; rms some 0.5 mm.
fn texture(row: usize, column: usize) -> f64 {
    let (x, y) = (row as f64, column as f64);
    0.5e-3 * (0.31 * x + 0.2 * y).sin() + 0.5e-3 * (0.17 * x - 0.4 * y).cos()
}

/// Files of two kinds with the same surface: a grid and an OpenCRG file.
fn maps(folder: &tempfile::TempDir, height: impl Fn(usize, usize) -> f64) -> [Road; 2] {
    let heights: Vec<f64> = (0..ROWS * COLUMNS).map(|i| height(i / COLUMNS, i % COLUMNS)).collect();
    let shape = [ROWS as u64, COLUMNS as u64];
    let npy = write(folder, "m.npy", &npy(&shape, npyz::Order::C, heights.iter().copied()));
    let mut crg = format!(
        "$CT\nmade by a test\n$\n$ROAD_CRG\nreference_line_start_u = 0\nreference_line_end_u = {}\n\
         reference_line_increment = 0.002\nlong_section_v_increment = 0.002\n$\n$KD_Definition\n#:KDBI\n",
        0.002 * (ROWS - 1) as f64
    );
    (1..=COLUMNS).for_each(|column| crg += &format!("D:long section {column},m\n"));
    let mut crg = (crg + "$\n$$$$$$$$\n").into_bytes();
    crg.extend(heights.iter().flat_map(|height| height.to_be_bytes()));
    let crg = write(folder, "m.crg", &crg);
    let crg = OpenCrgRoad {
        file: crg,
        lateral_position: None,
        widen: Widen::Refuse,
        missing: None,
        level: Levelling::Slope,
        longest_wavelength: None,
        at_end: AtEnd::Refuse,
    };
    [Road::Grid(GridRoad { level: Levelling::Slope, ..grid(npy, 0.002, 0.002) }), Road::OpenCrg(crg)]
}

#[test]
fn a_number_for_missing_heights_gives_the_road_of_empty_cells() {
    let empty = reported(&Road::Profile(csv("dropouts/as_nan.csv"))).unwrap();
    let coded = reported(&Road::Profile(csv("dropouts/minus_99_99.csv"))).unwrap();
    assert!((depth(&empty) - 1.242e-3).abs() < 2e-6 && (depth(&coded) - depth(&empty)).abs() < 1e-9);
    assert_eq!(taken(&coded), [(-99.99, 12)]);
    assert_eq!((coded.report.missing, empty.report.missing), (12, 12));
    assert!((coded.rms - empty.rms).abs() < 1e-12 && coded.levels == empty.levels);
    let named = vec![MissingHeight::Number(-99.99)];
    let named =
        reported(&Road::Profile(ProfileRoad { missing: Some(named), ..csv("dropouts/minus_99_99.csv") })).unwrap();
    assert!((depth(&named) - depth(&empty)).abs() < 1e-9 && taken(&named).is_empty());
}

#[test]
fn numbers_for_missing_heights_are_found_in_maps() {
    let folder = tempfile::tempdir().unwrap();
    let hole = |row: usize, column: usize| (row * COLUMNS + column) % 97 == 5;
    let of = |value: f64| maps(&folder, |row, column| if hole(row, column) { value } else { texture(row, column) });
    let right = of(f64::NAN).map(|road| reported(&road).unwrap().rms);
    for value in [-9999.0, -0.09999, 30.0] {
        for (road, rms) in of(value).iter().zip(right) {
            let road = reported(road).unwrap();
            assert_eq!(taken(&road), [(value, ROWS * COLUMNS / 97 + 1)]);
            assert!((road.rms - rms).abs() < 1e-9, "{} for {rms}", road.rms);
        }
    }
}

#[test]
fn words_that_the_scene_names_are_missing_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let line = |i: usize| match i % 40 {
        7 => format!("{i},wet\n"),
        9 => format!("{i},N/A\n"),
        _ => format!("{i},{}\n", (0.3 * i as f64).sin()),
    };
    let text = (0..400).map(line).fold(String::from("distance_mm,height_mm\n"), |text, line| text + &line);
    let unknown = captif(write(&folder, "wet.csv", text.as_bytes()));
    let refused = reported(&Road::Profile(unknown.clone())).unwrap_err().to_string();
    assert!(refused.contains("line 9") && refused.contains("wet"), "{refused}");
    let named = ProfileRoad { missing: Some(vec![MissingHeight::Word("wet".into())]), ..unknown };
    let road = reported(&Road::Profile(named)).unwrap();
    let words = RoadNote::WordsForMissing { words: [("N/A".into(), 10), ("wet".into(), 10)].into() };
    assert!(road.report.notes.contains(&words) && road.report.missing == 20, "{:?}", road.report.notes);
}

#[test]
fn spikes_of_a_profile_change_neither_depth_nor_levels() {
    let clean = reported(&Road::Profile(csv("spikes/clean.csv"))).unwrap();
    let spiked = reported(&Road::Profile(csv("spikes/three_spikes.csv"))).unwrap();
    assert_eq!((spikes(&clean), spikes(&spiked)), (0, 9));
    assert!((depth(&spiked) - depth(&clean)).abs() < 0.01e-3, "{} {}", depth(&spiked), depth(&clean));
    for (with, without) in
        spiked.levels.iter().zip(&clean.levels).filter(|(_, clean)| clean.valid && clean.level > 30.0)
    {
        assert!((with.level - without.level).abs() < 0.3, "{with:?} {without:?}");
    }
    assert!((spiked.span - clean.span).abs() < 0.1e-3);
}

#[test]
fn spikes_of_several_points_are_removed_at_any_spacing() {
    let folder = tempfile::tempdir().unwrap();
    for (spacing, width, spike) in [
        (0.02_f64, 1, 12.0),
        (0.05, 1, 12.0),
        (0.05, 4, 12.0),
        (0.05, 71, 4.0),
        (0.1, 1, 12.0),
        (0.1, 9, 12.0),
        (0.1, 37, 4.0),
        (0.25, 1, 12.0),
        (0.25, 3, 12.0),
        (0.4, 1, 12.0),
        (0.5, 1, 12.0),
        (0.5, 3, 4.0),
        (0.5, 4, 12.0),
        (0.5, 8, -4.0),
        (1.0, 1, 12.0),
        (1.0, 2, 12.0),
        (1.0, 4, 4.0),
        (2.0, 1, 12.0),
    ] {
        let count = (600.0 / spacing) as usize;
        let of = |spiked: bool| {
            let height = |i: usize| {
                let x = spacing * i as f64;
                let texture = 0.8 * (0.3 * x).sin() + 0.4 * (0.13 * x).cos();
                let in_spike = |at: f64| ((at / spacing) as usize..(at / spacing) as usize + width).contains(&i);
                texture + if spiked && [130.0, 270.0, 480.0].into_iter().any(in_spike) { spike } else { 0.0 }
            };
            let text: String = (0..count).map(|i| format!("{:.3},{:.4}\n", spacing * i as f64, height(i))).collect();
            let file = write(&folder, "s.csv", ("distance_mm,height_mm\n".to_owned() + &text).as_bytes());
            reported(&Road::Profile(captif(file))).unwrap()
        };
        let (clean, spiked) = (of(false), of(true));
        assert!(spikes(&clean) == 0 && spikes(&spiked) >= 3 * width, "{spacing} {width}: {}", spikes(&spiked));
        assert!((spiked.span - clean.span).abs() < 0.3e-3, "{spacing} {width}: {}", spiked.span);
        let valid = |road: &RoadDescription| road.mean_profile_depth.as_ref().unwrap().valid;
        assert!(valid(&clean) == 6 && (3..=6).contains(&valid(&spiked)));
        let differs = (depth(&spiked) - depth(&clean)).abs() > 0.06e-3;
        assert!(valid(&spiked) < 6 || !differs, "{spacing} {width}: {}", depth(&spiked));
    }
    // Heights of few digits, finely sampled, are no spikes.
    let tenth = |i: i32| format!("{:.2},{:.1}\n", 0.02 * f64::from(i), (0.012 * f64::from(i)).sin());
    let text = (0..10_000).fold(String::from("distance_mm,height_mm\n"), |text, i| text + &tenth(i));
    assert_eq!(spikes(&reported(&Road::Profile(captif(write(&folder, "tenths.csv", text.as_bytes())))).unwrap()), 0);
    // A spike every 15 mm makes 10 % of every segment.
    let text: String = (0..1200)
        .map(|i| {
            format!("{:.1},{}\n", 0.5 * f64::from(i), (0.2 * f64::from(i)).sin() + if i % 30 == 0 { 9.0 } else { 0.0 })
        })
        .collect();
    let file = write(&folder, "many.csv", ("distance_mm,height_mm\n".to_owned() + &text).as_bytes());
    let road = reported(&Road::Profile(captif(file))).unwrap();
    let depth = road.mean_profile_depth.unwrap();
    assert!(depth.valid == 0 && depth.mean.is_none() && depth.reference_surface.is_none(), "{depth:?}");
}

#[test]
fn outliers_of_maps_are_interpolated_along_and_across() {
    let folder = tempfile::tempdir().unwrap();
    let is_outlier = |row: usize, column: usize| (row * COLUMNS + column) % 883 == 400;
    let outlier = |row, column| texture(row, column) + if is_outlier(row, column) { 0.02 } else { 0.0 };
    let clean = maps(&folder, texture).map(|road| reported(&road).unwrap());
    let spiked = maps(&folder, outlier).map(|road| reported(&road).unwrap());
    for (spiked, clean) in spiked.iter().zip(&clean) {
        assert!(spikes(clean) == 0 && spikes(spiked) >= 50, "{}", spikes(spiked));
        assert!((spiked.rms - clean.rms).abs() < 0.01e-3 && (spiked.span - clean.span).abs() < 0.2e-3);
    }
}

#[test]
fn tilted_maps_are_levelled_and_reported() {
    let right = |road: &RoadDescription, wanted: f64| {
        assert!((road.rms - wanted).abs() < 0.005e-3, "{} for {wanted}", road.rms);
    };
    let of = |name: &str, level| {
        let file = reference(&format!("measured/levelling/{name}.npy"));
        reported(&Road::Grid(GridRoad { level, ..grid(file, 0.002, 0.002) })).unwrap()
    };
    let (level, tilted) = (of("level", Levelling::Slope), of("tilted_3_and_5_percent", Levelling::Slope));
    right(&level, 0.3e-3);
    right(&tilted, 0.3e-3);
    for (a, b) in tilted.levels.iter().zip(&level.levels) {
        assert!((a.level - b.level).abs() < 0.01, "{a:?} {b:?}");
    }
    let slopes = |note: &RoadNote| match *note {
        RoadNote::Levelled { along, across: Some(across), .. } => {
            (along.abs() - 0.03).abs() < 1e-3 && (across.abs() - 0.05).abs() < 2e-3
        }
        _ => false,
    };
    assert!(tilted.report.notes.iter().any(slopes), "{:?}", tilted.report.notes);
    let unlevelled = of("tilted_3_and_5_percent", Levelling::Off);
    assert!(unlevelled.rms > 3e-3 && unlevelled.report.notes.contains(&RoadNote::NotLevelled));
    assert!(of("tilted_3_and_5_percent", Levelling::Mean).rms > 3e-3);
    // Other slopes, on both kinds of map.
    let folder = tempfile::tempdir().unwrap();
    let flat = maps(&folder, texture).map(|road| reported(&road).unwrap());
    let slope = |row, column| texture(row, column) + 0.012 * 0.002 * row as f64 - 0.08 * 0.002 * column as f64 + 0.03;
    for (road, flat) in maps(&folder, slope).iter().zip(&flat) {
        let road = reported(road).unwrap();
        assert!((road.rms - flat.rms).abs() < 1e-9 && (road.span - flat.span).abs() < 1e-9);
    }
}

#[test]
fn long_waves_are_removed_of_every_kind() {
    let folder = tempfile::tempdir().unwrap();
    let hill = |row: usize| 0.02 * (2.0 * std::f64::consts::PI * row as f64 / (ROWS - 1) as f64).cos();
    let flat = maps(&folder, texture).map(|road| reported(&road).unwrap().rms);
    for (mut road, flat) in maps(&folder, |row, column| texture(row, column) + hill(row)).into_iter().zip(flat) {
        if let Road::Grid(GridRoad { longest_wavelength, .. }) | Road::OpenCrg(OpenCrgRoad { longest_wavelength, .. }) =
            &mut road
        {
            *longest_wavelength = Some(0.2);
        }
        let road = reported(&road).unwrap();
        assert!(road.report.notes.contains(&RoadNote::Detrended { longest_wavelength: 0.2 }));
        assert!(road.rms < 3.0 * flat, "{} {flat}", road.rms);
    }
    let text: String = (0..ROWS).map(|i| format!("{},{}\n", 2 * i, 1e3 * (texture(i, 0) + hill(i)))).collect();
    let file = write(&folder, "h.csv", ("distance_mm,height_mm\n".to_owned() + &text).as_bytes());
    let road = reported(&Road::Profile(ProfileRoad { longest_wavelength: Some(0.2), ..captif(file) })).unwrap();
    assert!(road.rms < 3.0 * flat[0], "{}", road.rms);
}

#[test]
fn an_opencrg_road_in_millimetres_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for road in maps(&folder, |row, column| 1e3 * texture(row, column)) {
        let refused = reported(&road).unwrap_err().to_string();
        assert!(refused.contains("millimetres"), "{refused}");
    }
}
