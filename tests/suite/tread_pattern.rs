//! Pattern of the tread: what it does to the contact, what is refused, and what it leaves as it was.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use tyrewave::Plan;
use tyrewave::internals::{
    BlockTerm, CellGrid, CellInfluence, CellSearch, CellSums, CellTruncation, InstantCells, NO_BLOCK, TreadBlock,
    TreadBlocks, edit, scene, scene_text,
};
use tyrewave::run::Simulation;
use tyrewave::scene::{LoadedScene, Scene};

use crate::common::run;

const ELEMENTS: usize = 128;
const ACROSS: usize = 4;
const SPEED: f64 = 80.0 / 3.6;
const AROUND: f64 = 1.95;
const SMOOTH: &str = "kind = \"smooth\"";
const MADE: &str = "kind = \"made\"\nseed = 3";
const CELLS: &str = "zone = \"cells\"\ncells_across = 4";

/// A scene of so many revolutions, with the keys of its contact and other tables after them.
fn rolled(revolutions: f64, road: &str, contact: &str, more: &str) -> String {
    let turn = AROUND / SPEED;
    let rolling = format!(
        "speed_kmh = 80.0\nwarm_up = 0.0\nduration = {:?}\naxle = {{ indentation = 0.014, ramp = 0.01 }}",
        (revolutions + 0.001) * turn
    );
    let numerics = format!("substeps = 1\ntime_rule = \"bdf2\"\nhistory = \"direct\"\nmemory = {:?}", 0.9 * turn);
    scene_text(ELEMENTS, road, &rolling, &numerics, &format!("[contact]\n{contact}\n{more}"))
}

/// Grooves across of one cell's length over half of the strip, in so many equal pitches, moved by parts of a pitch.
fn laterals(pitches: usize, offset: f64, more: &str) -> String {
    let width = AROUND / ELEMENTS as f64;
    format!(
        "[tread_pattern]\npitches = {pitches}\n\
         laterals = [{{ from = -0.06, to = 0.0, width = {width:?}, depth = 0.008, offset = {offset:?} }}]\n{more}"
    )
}

/// Middle of the second cell of a pitch of four.
const MIDDLE: f64 = 0.375;

fn forces(loaded: &LoadedScene) -> Vec<f64> {
    let plan = Plan::of(loaded).unwrap_or_else(|error| panic!("{}", error.render(false)));
    let mut run = Simulation::begin(loaded, &plan, &Default::default()).unwrap();
    let mut forces = Vec::new();
    while let Some(step) = run.step().unwrap() {
        forces.push(step.total_force);
    }
    forces
}

fn bits(forces: &[f64]) -> Vec<u64> {
    forces.iter().map(|force| force.to_bits()).collect()
}

/// Amplitudes of the last revolution by order.
fn orders(forces: &[f64]) -> Vec<f64> {
    let mut last: Vec<Complex64> =
        forces[forces.len() - ELEMENTS..].iter().map(|force| Complex64::new(*force, 0.0)).collect();
    FftPlanner::new().plan_fft_forward(ELEMENTS).process(&mut last);
    last[..=ELEMENTS / 2].iter().map(|amplitude| amplitude.norm() / ELEMENTS as f64).collect()
}

#[test]
fn equal_pitches_on_a_smooth_road_give_their_lines_alone() {
    for (contact, blocks) in [(CELLS, "compliant"), (CELLS, "continuum"), ("slices = \"winkler\"", "compliant")] {
        let pattern = laterals(32, MIDDLE, &format!("blocks = \"{blocks}\""));
        let found = orders(&forces(&scene(&rolled(14.0, SMOOTH, contact, &pattern))));
        assert!(found[0] > 500.0, "{found:?}");
        let line = found[32];
        let other = found.iter().enumerate().filter(|(order, _)| order % 32 != 0).map(|(_, force)| *force);
        let largest = other.fold(0.0, f64::max);
        println!("{contact:?}, {blocks}: mean {:.1} N, line {line:.3} N, other orders {largest:.1e} N", found[0]);
        assert!(line > 0.1 && largest < 1e-6 * line, "{line} N, and {largest:e} N beside");
    }
}

#[test]
fn a_pattern_that_is_moved_by_cells_moves_the_forces() {
    let of = |offset: f64| forces(&scene(&rolled(14.0, SMOOTH, CELLS, &laterals(32, offset, ""))));
    let first = of(MIDDLE);
    // A whole pitch is no move.
    assert_eq!(bits(&first), bits(&of(MIDDLE + 1.0)));
    let moved = of(MIDDLE + 0.25);
    let last = first.len() - ELEMENTS;
    let largest = (0..ELEMENTS - 4).map(|n| (first[last + n] - moved[last + n + 1]).abs()).fold(0.0, f64::max);
    let back = (0..ELEMENTS - 4).map(|n| (first[last + n + 1] - moved[last + n]).abs()).fold(0.0, f64::max);
    let still = (0..ELEMENTS).map(|n| (first[last + n] - moved[last + n]).abs()).fold(0.0, f64::max);
    println!("moved by a step {:.1e} N, not moved {still:.1e} N", largest.min(back));
    assert!(largest.min(back) < 1e-6 && still > 1.0, "{largest:e}, {back:e}, {still:e}");
}

#[test]
fn a_level_pattern_and_one_that_is_off_change_no_bit() {
    let level = "[tread_pattern]\ngrooves = [{ position = 0.0, width = 0.06, depth = 0.0 }]";
    let off = format!("[effects]\ntread_pattern = \"off\"\n{}", laterals(32, MIDDLE, ""));
    for contact in [CELLS, "slices = \"winkler\""] {
        let of = |more: &str| forces(&scene(&rolled(0.6, MADE, contact, more)));
        let without = of("");
        assert!(without.iter().any(|force| *force > 100.0));
        assert_eq!(bits(&without), bits(&of(&off)), "{contact}");
        if contact == CELLS {
            assert_eq!(bits(&without), bits(&of(level)), "{contact}");
        }
        assert_ne!(bits(&without), bits(&of(&laterals(32, MIDDLE, ""))), "{contact}");
    }
}

#[test]
fn threads_change_no_bit_and_files_say_what_the_pattern_is() {
    let text = rolled(2.0, MADE, CELLS, &laterals(32, MIDDLE, ""));
    let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(&text));
    let (one, two) = (on(1), on(2));
    for name in ["total_force.npy", "pattern.csv", "orders.csv"] {
        assert_eq!(std::fs::read(one.path(name)).unwrap(), std::fs::read(two.path(name)).unwrap(), "{name}");
    }
    let pattern = std::fs::read_to_string(one.path("pattern.csv")).unwrap();
    let value = |name: &str| -> f64 {
        let line = pattern.lines().find(|line| line.starts_with(name)).unwrap();
        line.split(',').nth(4).unwrap().parse().unwrap()
    };
    // One cell of four along, over half of the strip.
    assert!((value("void_share,0") - 0.125).abs() < 1e-12 && (value("void_share_on_cells") - 0.125).abs() < 1e-15);
    assert!((value("pitch_amplitude,32,") - 1.0).abs() < 1e-12 && value("pitch_amplitude,31,").abs() < 1e-12);
    assert!(pattern.lines().any(|line| line.starts_with("pitch,31,")));
    let orders = std::fs::read_to_string(one.path("orders.csv")).unwrap();
    assert!(orders.starts_with("order,frequency_hz,force_n,repeated_force_n\n0,0,"), "{orders}");
    assert_eq!(orders.lines().count(), 1 + 65);
}

#[test]
fn equal_pitches_sound_at_their_orders_alone() {
    let receiver = "[[receiver]]\nname = \"beside it\"\nposition = [0.3, 0.6, 0.2]\n\
                 [[receiver]]\nname = \"ahead\"\nposition = [1.0, 0.3, 0.2]\n\
                 [radiation]\nfmax = 500.0\nnodes_per_wavelength = 5.0\nfrequency_tolerance = \"0.5 dB\"\n\
                 audio = false\n";
    let text = rolled(16.0, SMOOTH, "slices = \"winkler\"\ncells_across = 4", &laterals(32, MIDDLE, receiver));
    let results = run(&text);
    let orders = std::fs::read_to_string(results.path("orders.csv")).unwrap();
    let header = "order,frequency_hz,force_n,repeated_force_n,pressure_pa_beside-it,pressure_pa_ahead";
    assert_eq!(orders.lines().next(), Some(header));
    let rows: Vec<Vec<f64>> =
        orders.lines().skip(1).map(|line| line.split(',').map(|value| value.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 65);
    for column in [4, 5] {
        // Pitches pass at 365 Hz; above 500 Hz nothing radiates.
        let line = rows[32][column];
        let beside = rows[24..32].iter().chain(&rows[33..=40]).map(|row| row[column]).fold(0.0, f64::max);
        println!("column {column}: {line:.2e} Pa, beside it {beside:.1e} Pa");
        assert!(line > 30.0 * beside && beside > 0.0, "{column}: {line} Pa, beside it {beside} Pa");
        // Beyond, there is the leak of the first revolutions, in which the tyre comes down on the road.
        assert!(rows[48..].iter().all(|row| row[column] < 1e-2 * line), "{column}: {rows:?}");
    }
}

#[test]
fn what_a_pattern_cannot_be_is_refused_with_its_place() {
    let refusal = |text: &str| {
        let planned = Scene::from_str(text, "scene.toml").and_then(|loaded| Plan::of(&loaded));
        planned.map(|_| String::new()).unwrap_or_else(|error| error.render(false))
    };
    let groove = |position: f64, width: f64, depth: f64| {
        format!("[tread_pattern]\ngrooves = [{{ position = {position:?}, width = {width:?}, depth = {depth:?} }}]")
    };
    let lateral = |keys: &str| format!("[tread_pattern]\npitches = 32\nlaterals = [{{ {keys} }}]");
    let pitches = |keys: &str| format!("[tread_pattern]\npitches = {keys}");
    let half = "from = -0.06, to = 0.0";
    let cases = [
        (pitches("{ lengths = [0.03], sequence = \"random\", count = 50 }"), "tread_pattern.pitches", "1.5000 m long"),
        (pitches("{ lengths = [0.06], sequence = \"ABA\" }"), "tread_pattern.pitches.sequence", "pitch B"),
        (pitches("{ lengths = [0.06], sequence = \"random\" }"), "tread_pattern.pitches.count", "missing"),
        (pitches("{ lengths = [0.06], sequence = \"AA\", seed = 2 }"), "tread_pattern.pitches.seed", "letters"),
        (pitches("33"), "tread_pattern.pitches", "33 pitches on 128"),
        (groove(0.05, 0.0273, 0.008), "tread_pattern.grooves[0].position", "reaches"),
        (groove(0.0, 0.06, 0.0125), "tread_pattern.grooves[0].depth", "too deep"),
        (groove(0.0, 0.06, 0.03), "tread_pattern.grooves[0].depth", "0.03 is out of range"),
        (groove(0.0, 0.06, -0.001), "tread_pattern.grooves[0].depth", "out of range"),
        (groove(0.0, 0.06, f64::NAN), "tread_pattern.grooves[0].depth", "NaN"),
        (groove(0.0, 0.02, 0.008), "tread_pattern.grooves[0].width", "narrower than a cell"),
        (groove(0.0, 0.045, 0.008), "tread_pattern.grooves", "% are void, on cells"),
        (
            "[tread_pattern]\ngrooves = [{ position = 0.0, width = 0.03, depth = 0.008 }, \
             { position = 0.02, width = 0.03, depth = 0.008 }]"
                .to_owned(),
            "tread_pattern.grooves[1].position",
            "overlaps with grooves[0]",
        ),
        (lateral(&format!("{half}, width = 0.004, depth = 0.008")), "tread_pattern.laterals[0].width", "sipes"),
        (lateral(&format!("{half}, width = 0.016, depth = 0.008, angle = 85.0")), "laterals[0].angle", "85"),
        (lateral("from = -0.07, to = 0.0, width = 0.016, depth = 0.008"), "laterals[0].from", "outside"),
        (lateral("from = 0.01, to = 0.0, width = 0.016, depth = 0.008"), "laterals[0].from", "not below"),
        (
            lateral("from = -0.06, to = 0.06, width = 0.015234375, depth = 0.008, offset = 0.375"),
            "tread_pattern.laterals",
            "is solid",
        ),
        (
            "[tread_pattern]\nlaterals = [{ from = -0.06, to = 0.0, width = 0.016, depth = 0.008 }]".to_owned(),
            "tread_pattern.pitches",
            "missing",
        ),
        ("[tread_pattern]\nfile = \"map.png\"".to_owned(), "tread_pattern.depth", "missing"),
        ("[tread_pattern]\nfile = \"map.jpg\"\ndepth = 0.008".to_owned(), "tread_pattern.file", "neither"),
        ("[tread_pattern]\nfile = \"nowhere.npy\"".to_owned(), "tread_pattern.file", "nowhere.npy"),
        ("[effects]\ntread_pattern = \"on\"".to_owned(), "effects.tread_pattern", "there is no [tread_pattern]"),
        (format!("{}\n[air_pumping]\npatch = \"grooves\"", laterals(32, MIDDLE, "")), "air_pumping", "no [[receiver]]"),
        (format!("{}\n[friction]\nmu = 0.9", laterals(32, MIDDLE, "")), "tread_pattern.blocks", "friction"),
        (
            laterals(32, MIDDLE, "blocks = \"continuum\"\nblock_compliance = 1e-10"),
            "tread_pattern.block_compliance",
            "continuum",
        ),
    ];
    for (pattern, key, wrong) in cases {
        let reported = refusal(&rolled(0.5, SMOOTH, CELLS, &pattern));
        assert!(reported.contains(key) && reported.contains(wrong), "{key}, {wrong}: {reported}\n{pattern}");
    }
    // Cells that hold the void are named, and fewer do not.
    let off = groove(0.0, 0.045, 0.008);
    let on = |across: usize| {
        let contact = format!("zone = \"cells\"\ncells_across = {across}");
        refusal(&edit(&rolled(0.5, SMOOTH, &contact, &off), &[("numerics.lateral_terms", "64")]))
    };
    let reported = on(ACROSS);
    let after = reported.split("contact.cells_across = ").nth(1).unwrap_or_else(|| panic!("{reported}"));
    let digits: String = after.chars().take_while(char::is_ascii_digit).collect();
    let enough: usize = digits.parse().unwrap();
    assert!(enough > ACROSS && reported.contains("numerics.elements = 128"), "{reported}");
    assert!((ACROSS..enough).all(|across| on(across).contains("% are void")), "{reported}");
    assert!(!on(enough).contains("void"), "{}", on(enough));
    // Slices by another law have no cells that could be left out.
    let slices = format!("[effects]\ntread_pattern = \"on\"\n{}", laterals(32, MIDDLE, ""));
    let reported = refusal(&rolled(0.5, SMOOTH, "slices = \"half-space\"", &slices));
    assert!(reported.contains("effects.tread_pattern") && reported.contains("winkler"), "{reported}");
    // What is given in these ways is taken.
    for good in [
        groove(0.0, 0.06, 0.008),
        lateral(&format!("{half}, width = 0.015234375, depth = 0.008, offset = 0.375")),
        format!("{}\n[friction]\nmu = 0.9", laterals(32, MIDDLE, "blocks = \"continuum\"")),
    ] {
        assert_eq!(refusal(&rolled(0.5, SMOOTH, CELLS, &good)), "", "{good}");
    }
}

#[test]
fn rasters_are_the_grooves_that_they_show() {
    let folder = tempfile::tempdir().unwrap();
    let of = |pattern: &str| {
        let text = rolled(0.6, SMOOTH, CELLS, pattern);
        forces(&Scene::from_str(&text, "raster").unwrap())
    };
    let grooves = of(&laterals(32, MIDDLE, "blocks = \"continuum\""));
    // The second of four cells along, the two to the right of the middle.
    let is_void = |i: usize, j: usize| i % 4 == 1 && j < 2;
    let mut bytes = Vec::new();
    {
        use npyz::WriterBuilder;
        let shape = [ELEMENTS as u64, ACROSS as u64];
        let mut writer = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(&mut bytes).begin_nd().unwrap();
        for cell in 0..ELEMENTS * ACROSS {
            writer.push(&if is_void(cell / ACROSS, cell % ACROSS) { 0.008_f64 } else { 0.0 }).unwrap();
        }
        writer.finish().unwrap();
    }
    let array = folder.path().join("map.npy");
    std::fs::write(&array, bytes).unwrap();
    let by_array = of(&format!("[tread_pattern]\nfile = '{}'\nblocks = \"continuum\"", array.display()));
    assert_eq!(bits(&by_array), bits(&grooves));
    // One pitch as a picture, of square points: 61 mm by 120 mm at 15.2 mm make 4 x 8, of which 1 x 4 are black.
    let (rows, columns) = (4_usize, 8_usize);
    let mut picture = Vec::new();
    {
        let mut encoder = png::Encoder::new(&mut picture, columns as u32, rows as u32);
        encoder.set_color(png::ColorType::Grayscale);
        let is_black = |point: usize| point / columns == 1 && point % columns < 4;
        let pixels: Vec<u8> = (0..rows * columns).map(|point| if is_black(point) { 0 } else { 255 }).collect();
        encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    }
    let file = folder.path().join("pitch.png");
    std::fs::write(&file, picture).unwrap();
    let reported = |depth: &str, keys: &str| {
        let file = file.display();
        format!("[tread_pattern]\nfile = '{file}'\ndepth = {depth}\nblocks = \"continuum\"\n{keys}")
    };
    let by_picture = of(&reported("0.008", "period = \"pitch\"\npitches = 32"));
    assert_eq!(bits(&by_picture), bits(&grooves));
    // Once round the tyre its points would be half a metre large.
    let text = rolled(0.6, SMOOTH, CELLS, &reported("0.008", ""));
    let error = Scene::from_str(&text, "raster").and_then(|loaded| Plan::of(&loaded)).unwrap_err().render(false);
    assert!(error.contains("tread_pattern.file") && error.contains("square points"), "{error}");
}

/// Cells of the default tyre at rest.
fn influence(columns: usize, across: usize) -> CellInfluence {
    let tyre = Scene::from_str(tyrewave::scene::DEFAULT, "default").unwrap().scene.tyre;
    let grid = CellGrid::new(&tyre, 256, across);
    let truncation = CellTruncation { lateral_terms: None, aliases: None };
    CellSums::new(&tyre, grid, truncation, 1e-6, 0.0).cached_instant(0.0, columns)
}

/// Blocks of 3 x 2 cells of every other four columns, the others without; a ring of two rows with a hole beside them,
/// and ribs of 20 columns of every 24.
fn blocks(elements: usize, across: usize) -> TreadBlocks {
    let mut blocks = TreadBlocks { of_cell: vec![NO_BLOCK; elements * across], cells: Vec::new(), blocks: Vec::new() };
    let inner = across - 3;
    let add = |blocks: &mut TreadBlocks, parts: &[Vec<usize>], length: usize, is_ring: bool| {
        let first = blocks.cells.len() as u32;
        let compliance = 5e-10 * (1.0 + f64::from(first % 3));
        blocks.blocks.push(TreadBlock { first, parts: parts.len() as u32, length: length as u32, is_ring, compliance });
        for cells in parts {
            cells.iter().for_each(|&cell| blocks.of_cell[cell] = blocks.cells.len() as u32);
            blocks.cells.push(cells.len() as u32);
        }
    };
    for (i, j) in (0..elements / 4).flat_map(|i| (0..inner).step_by(2).map(move |j| (4 * i, j))) {
        let cells = (i..i + 3).flat_map(|i| (j..inner.min(j + 2)).map(move |j| i * across + j)).collect();
        add(&mut blocks, &[cells], 1, false);
    }
    let column = |i: usize| (inner..inner + 2).map(move |j| i * across + j).filter(|cell| *cell != 7 * across + inner);
    let ring: Vec<Vec<usize>> = (0..elements).map(|i| column(i).collect()).collect();
    add(&mut blocks, &ring, 5, true);
    for first in (0..elements - 24).step_by(24) {
        let parts: Vec<Vec<usize>> = (first..first + 20).map(|i| vec![i * across + inner + 2]).collect();
        add(&mut blocks, &parts, 5, false);
    }
    blocks
}

#[test]
fn products_with_blocks_are_symmetric_sums_of_entries() {
    let (columns, across, face) = (30, 9, 2.7e-5);
    let term = BlockTerm::new(&blocks(256, across), face, across, columns * across);
    let mut cells = InstantCells::new(influence(columns, across)).with_blocks(Some(term));
    for first in [0, 5, -3, 250] {
        cells.place(first);
        let count = cells.cells();
        let given: Vec<f64> = (0..count).map(|n| (n as f64 * 1.3).cos()).collect();
        let mut u = vec![0.0; count];
        cells.displacement(&given, &mut u);
        let largest = u.iter().fold(0.0_f64, |largest, u| largest.max(u.abs()));
        let single: Vec<f32> = given.iter().map(|force| *force as f32).collect();
        let mut single_u = vec![0.0; count];
        cells.single_displacement(&single, &mut single_u);
        for a in (0..count).step_by(7) {
            let expected: f64 = given.iter().enumerate().map(|(b, force)| cells.entry(a, b) * force).sum();
            assert!((u[a] - expected).abs() < 1e-12 * largest, "{first}, {a}: {} and {expected}", u[a]);
            assert!((f64::from(single_u[a]) - expected).abs() < 1e-5 * largest, "{first}, {a}");
            for b in (0..count).step_by(11) {
                assert!((cells.entry(a, b) - cells.entry(b, a)).abs() < 1e-22);
            }
        }
    }
}

#[test]
fn a_rib_yields_like_the_mean_of_its_blocks_wherever_they_begin() {
    let (elements, across, columns, face, compliance, length) = (96, 2, 24, 2.7e-5, 6e-10, 7);
    let rib = TreadBlock { first: 0, parts: elements as u32, length: length as u32, is_ring: true, compliance };
    let of_cell = (0..elements * across).map(|cell| (cell / across) as u32).collect();
    let ring = TreadBlocks { of_cell, cells: vec![across as u32; elements], blocks: vec![rib] };
    let term = |blocks: &TreadBlocks| Some(BlockTerm::new(blocks, face, across, columns * across));
    let mut with = InstantCells::new(influence(columns, across)).with_blocks(term(&ring));
    // Blocks that begin `shift` columns on; a window that meets no seam.
    let cut = |shift: usize| {
        let block = |cell: usize| ((cell / across + shift) / length) as u32;
        let of_cell: Vec<u32> = (0..elements * across).map(block).collect();
        let count = *of_cell.last().unwrap() as usize + 1;
        let mut blocks = TreadBlocks::whole(of_cell, &vec![compliance; count]);
        // Those that the seam cuts: not met.
        blocks.cells.fill((length * across) as u32);
        InstantCells::new(influence(columns, across)).with_blocks(term(&blocks))
    };
    let mut all: Vec<InstantCells> = (0..length).map(cut).collect();
    for first in [20, 21, 26, 47] {
        with.place(first);
        all.iter_mut().for_each(|cut| cut.place(first));
        for (a, b) in [(0, 0), (0, 1), (5, 7), (5, 16), (30, 17), (30, 16), (47, 47), (47, 36), (47, 34), (2, 40)] {
            let mean = all.iter().map(|cut| cut.entry(a, b)).sum::<f64>() / length as f64;
            let found = with.entry(a, b);
            assert!((found / mean - 1.0).abs() < 1e-12, "{first}: {a}, {b}: {found:e} and {mean:e}");
        }
    }
}

#[test]
fn ribs_without_a_cut_are_as_silent_on_a_smooth_road_as_a_slick() {
    let grooves = "grooves = [{ position = 0.0, width = 0.06, depth = 0.008 }]";
    let pattern = |more: &str| format!("[tread_pattern]\n{grooves}\n{more}");
    let of = |more: &str| {
        let found = orders(&forces(&scene(&rolled(14.0, SMOOTH, CELLS, more))));
        (found[0], found[1..].iter().copied().fold(0.0, f64::max))
    };
    let (slick, ribs) = (of(""), of(&pattern("pitches = 32")));
    let (continuum, _) = of(&pattern("pitches = 32\nblocks = \"continuum\""));
    println!("mean and largest order: slick {slick:?} N, ribs {ribs:?} N");
    // The ribs do yield.
    assert!(ribs.0 < 0.999 * continuum && ribs.1 < 1e-6, "{ribs:?}, {continuum}");
}

#[test]
fn one_block_of_all_cells_is_pressed_in_by_its_mean_pressure() {
    let (columns, across, face, compliance) = (40, 8, 2.7e-5, 6e-10);
    let count = 256 * across;
    let all = TreadBlocks::whole(vec![0; count], &[compliance]);
    for tolerance in [1e-9, 1e-5] {
        let term = BlockTerm::new(&all, face, across, columns * across);
        let mut with =
            CellSearch::new(InstantCells::new(influence(columns, across)).with_blocks(Some(term)), tolerance);
        let mut without = CellSearch::new(InstantCells::new(influence(columns, across)), tolerance);
        let middle = 0.5 * columns as f64;
        let rise = |cell: usize| 1e-5 * ((cell / across) as f64 - middle).powi(2) + 2e-4 * (cell as f64 * 1.7).sin();
        let required: Vec<f64> = (0..columns * across).map(|cell| 2e-3 - rise(cell)).collect();
        let mut forces = vec![0.0; columns * across];
        let residuals = with.solve(&required, &mut forces);
        assert!(residuals.penetration.max(residuals.complementarity) <= tolerance);
        let total: f64 = forces.iter().sum();
        // The same forces press a tread without blocks less far by c F/A.
        let area = count as f64 * face;
        let shifted: Vec<f64> = required.iter().map(|d| d - compliance * total / area).collect();
        let mut plain = vec![0.0; columns * across];
        without.solve(&shifted, &mut plain);
        let largest = plain.iter().fold(0.0_f64, |largest, force| largest.max(*force));
        let off = forces.iter().zip(&plain).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
        println!("tolerance {tolerance:e}: {total:.1} N, {off:.1e}; {} iterations", with.counts().iterations);
        assert!(total > 100.0 && off < 300.0 * tolerance, "{off:e}");
        assert_eq!(with.counts().fallbacks, 0);
    }
}

#[test]
fn blocks_soften_the_tyre_by_a_little() {
    // A pattern with blocks of two by four cells.
    let of = |blocks: &str| {
        let text = rolled(3.0, SMOOTH, CELLS, &laterals(32, MIDDLE, &format!("blocks = \"{blocks}\"")));
        let found = forces(&scene(&text));
        found[found.len() - ELEMENTS..].iter().sum::<f64>() / ELEMENTS as f64
    };
    let (compliant, continuum) = (of("compliant"), of("continuum"));
    println!("{compliant:.1} N with blocks, {continuum:.1} N without");
    assert!(compliant < 0.999 * continuum && compliant > 0.9 * continuum, "{compliant} and {continuum}");
}

#[test]
fn example_tyres_have_the_patterns_that_they_state() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tyres");
    let mut shares = Vec::new();
    for name in ["slick", "summer", "winter"] {
        let loaded = Scene::with_tyre(folder.join(format!("{name}.toml")), &[]).unwrap();
        let written = loaded.scene.to_toml().unwrap();
        let mut cells: toml::Table = written.parse().unwrap();
        cells["contact"] = toml::Value::Table("zone = \"cells\"\ncells_across = 30".parse().unwrap());
        cells["numerics"] = toml::Value::Table("elements = 512".parse().unwrap());
        let text = toml::to_string(&cells).unwrap();
        let plan = Plan::of(&Scene::from_str(&text, name).unwrap());
        let plan = plan.unwrap_or_else(|error| panic!("{name}: {}", error.render(false)));
        let share = plan.tread_map().map_or(0.0, |map| map.void());
        println!("{name}: {:.1} % void", 100.0 * share);
        shares.push(share);
        let blocks = plan.tread().and_then(|(_, blocks)| blocks);
        assert_eq!(blocks.is_some(), name != "slick");
    }
    assert!(shares[0] <= 0.0 && (0.2..0.4).contains(&shares[1]) && (0.2..0.4).contains(&shares[2]), "{shares:?}");
}
