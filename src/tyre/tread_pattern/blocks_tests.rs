use super::*;
use crate::test_models::reference;
use crate::tyre::tread_pattern::map::TreadCells;

/// Map of a pattern on the default tyre, `across` cells over its strip.
fn map(columns: usize, across: usize, pattern: &str) -> (TreadMap, Scene) {
    let text = format!("{}\n[tread_pattern]\n{pattern}", crate::scene::DEFAULT);
    let scene = Scene::from_str(&text, "pattern").unwrap().scene;
    let map = TreadMap::new(scene.pattern().unwrap(), &scene, TreadCells { columns, across });
    (map.unwrap(), scene)
}

#[test]
fn ribs_are_as_soft_as_finite_elements_say() {
    let text = std::fs::read_to_string(reference("tread/ref_block.json")).unwrap();
    let known: serde_json::Value = serde_json::from_str(&text).unwrap();
    let cases = known["cases"].as_array().unwrap();
    let number = |case: &serde_json::Value, key: &str| case[key].as_f64().unwrap();
    let (thickness, modulus) = (0.013, 6.8e6);
    let mut errors = Vec::new();
    for case in cases.iter().filter(|case| case["road"] == "smooth") {
        let [rib, groove, depth] = ["rib", "groove", "depth"].map(|key| number(case, key));
        // Three ribs on cells of a millimetre; a groove narrower than that on cells of its width.
        let cell = if groove < 1e-3 { groove } else { 1e-3 };
        let (wide, gap) = ((rib / cell).round() as usize, (groove / cell).round() as usize);
        let across = 3 * (wide + gap);
        let columns = 60;
        let is_void = |j: usize| j % (wide + gap) >= wide;
        let depths: Vec<f64> =
            (0..columns * across).map(|cell| if is_void(cell % across) { depth } else { 0.0 }).collect();
        let groove_of = depths.iter().map(|depth| u32::from(*depth > 0.0)).collect();
        let none = || vec![0; columns * across];
        let map = TreadMap {
            columns,
            across,
            size: [cell; 2],
            depths,
            groove_of,
            sipes: [none(), none()],
            sipe_lines: Vec::new(),
            cuts: vec![[0.0; 2], [depth, 0.0]],
            train: None,
            exact_void: 0.0,
        };
        let blocks = TreadBlocks::of(&map, thickness, modulus, None);
        // The rib in the middle has cuts on both sides; a cut of 4 mm is less than a third of the tread deep and
        // divides nothing.
        let block = blocks.of_cell[wide + gap];
        assert_eq!(block == NO_BLOCK, depth < thickness / 3.0);
        let found = blocks.blocks.iter().find(|rib| (rib.first..rib.first + rib.parts).contains(&block));
        let found = match found {
            Some(rib) => rib.compliance,
            None => compliance(rib, 2.0, depth, true, modulus),
        };
        let error = found / number(case, "extra_compliance") - 1.0;
        let shape = rib / (4.0 * depth);
        let expected = depth / (4.0 / 3.0 * (1.0 + shape * shape) * modulus);
        assert!((found / expected - 1.0).abs() < 1e-12, "{found:e} and {expected:e}");
        println!("rib {rib}, groove {groove}, depth {depth}: {:+.1} %", 100.0 * error);
        // The known bounds are whole per cent.
        let bounds = if depth > 0.45 * thickness { -0.255..=0.055 } else { -0.445..=0.0 };
        assert!(bounds.contains(&error), "rib {rib}, groove {groove}, depth {depth}: {error}");
        errors.push(error);
    }
    assert_eq!(errors.len(), 6);
}

#[test]
fn grooves_and_sipes_divide_the_tread_into_blocks() {
    // 64 pitches of 8 cells; a rib between two grooves, whose sipes cut it once in each pitch, and shoulders.
    let grooves = "grooves = [{ position = -0.0218, width = 0.0109, depth = 0.008 }, \
                   { position = 0.0218, width = 0.0109, depth = 0.008 }]";
    let (ribs, scene) = map(512, 20, &format!("pitches = 64\n{grooves}"));
    assert!((ribs.void() - 0.2).abs() < 1e-12 && (ribs.exact_void - 0.2).abs() < 1e-9, "{}", ribs.exact_void);
    let blocks = TreadBlocks::new(&ribs, scene.pattern().unwrap(), &scene).unwrap();
    // Each of the three ribs yields by lengths of three depths along; none is wide enough for a cut across.
    let across = |width: f64| (width / 0.024).round().max(1.0) as usize;
    let cell = 0.109 / 20.0;
    assert_eq!(blocks.blocks.len(), across(6.0 * cell) + 2 * across(5.0 * cell));
    let length = (0.024_f64 / (1.95 / 512.0)).round() as u32;
    assert!(blocks.blocks.iter().all(|rib| rib.is_ring && rib.parts == 512 && rib.length == length));
    assert_eq!(blocks.cells.len(), 512 * blocks.blocks.len());
    let solid = blocks.of_cell.iter().filter(|block| **block != NO_BLOCK).count();
    assert_eq!(solid, 512 * 16);
    assert_eq!(blocks.cells.iter().sum::<u32>() as usize, solid);

    let sipe = "sipes = [{ from = -0.0164, to = 0.0164, width = 0.0006, depth = 0.006, angle = 20.0, offset = 0.3 }]";
    let (siped, scene) = map(512, 20, &format!("pitches = 64\n{grooves}\n{sipe}"));
    assert_eq!(siped.void().to_bits(), ribs.void().to_bits());
    let blocks = TreadBlocks::new(&siped, scene.pattern().unwrap(), &scene).unwrap();
    let mut numbers: Vec<u32> = (0..512).map(|i| blocks.of_cell[i * 20 + 10]).collect();
    numbers.sort_unstable();
    numbers.dedup();
    // As many blocks of 8 cells by 6 as pitches, 33 mm across: each is divided once more at lengths of some 21 mm.
    assert_eq!(numbers.len(), 64);
    assert!(numbers.iter().all(|number| blocks.cells[*number as usize] == 24), "{:?}", &blocks.cells[..4]);

    // A sipe that is less deep than a third of the tread divides nothing.
    let shallow = sipe.replace("depth = 0.006", "depth = 0.004");
    let (shallow, scene) = map(512, 20, &format!("pitches = 64\n{grooves}\n{shallow}"));
    let shallow = TreadBlocks::new(&shallow, scene.pattern().unwrap(), &scene).unwrap();
    assert_eq!(shallow, TreadBlocks::new(&ribs, scene.pattern().unwrap(), &scene).unwrap());
}

#[test]
fn a_slanted_cut_is_as_long_as_its_line() {
    // Lateral grooves at 30 degrees over the whole strip: each block has two sides of b/cos 30.
    let lateral = "laterals = [{ from = -0.0545, to = 0.0545, width = 0.012, depth = 0.008, angle = 30.0 }]";
    let (cut, _) = map(2048, 109, &format!("pitches = 32\n{lateral}"));
    let pieces = pieces(&cut, 0.013 / 3.0);
    assert_eq!(pieces.len(), 32);
    let expected = 2.0 * 0.109 / 30.0_f64.to_radians().cos();
    for piece in pieces {
        assert!(
            (piece.perimeter(&cut.cuts) / expected - 1.0).abs() < 0.01,
            "{} and {expected}",
            piece.perimeter(&cut.cuts)
        );
    }
}

#[test]
fn what_has_no_cut_yields_no_more_than_the_layers() {
    let (level, scene) = map(512, 20, "pitches = 64\ngrooves = [{ position = 0.0, width = 0.0109, depth = 0.0 }]");
    assert!(level.is_level() && level.exact_void < 1e-15);
    assert_eq!(TreadBlocks::new(&level, scene.pattern().unwrap(), &scene), None);
}
