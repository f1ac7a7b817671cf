//! Slices of a pressed road: in runs, and beside contact over cells at rest.

use std::f64::consts::{PI, TAU};
use std::fs;

use tyrewave::Plan;
use tyrewave::internals::{
    CHIP_SEAL, CellGrid, CellSearch, CellSums, CellTruncation, InstantCells, PressedRoad, StripCurves, decisions,
    line_influence, local_compliance, reference, scene, scene_text, tread_modulus, with_road,
};
use tyrewave::road::{Limits, RoadSurface, SliceBuilder, StiffnessCurve};
use tyrewave::scene::{DEFAULT, Law, LoadedScene, Scene, Tyre};

use crate::common::run;

const MADE: &str = "kind = \"made\"\nseed = 3";
const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.1\naxle = { load = 3400.0 }";
const NUMERICS: &str = "history = \"modal\"\npole_tolerance = 1e-3\ntime_rule = \"sdirk2\"";
const PRESSED: &str = "[contact]\nslices = \"pressed\"\ncells_across = 12\ncells_along = 2";

#[test]
fn a_pressed_road_has_the_same_bytes_on_any_threads() {
    let text = scene_text(128, MADE, ROLLING, NUMERICS, PRESSED);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let results = pool.install(|| run(&text));
        results.assert_sound("pressed");
        let force = fs::read(results.path("patch_force.npy")).unwrap();
        let contact = results.summary()["contact"].clone();
        assert!(contact["local_compliance"].is_null(), "{contact}");
        let error = contact["slice_error"].as_f64().unwrap();
        assert!(error < 3e-4, "{error}");
        (force, results.report.summary.outcome.mean_force.unwrap())
    };
    let (one, force) = on(1);
    assert!(one == on(2).0);
    assert!((force / 3400.0 - 1.0).abs() < 0.05, "{force}");
    let springs = run(&text.replace("\"pressed\"", "\"winkler\""));
    assert_ne!(one, fs::read(springs.path("patch_force.npy")).unwrap());
}

#[test]
fn mistakes_about_pressed_slices_are_answered_with_their_keys() {
    let answer = |more: &str| {
        let text = scene_text(128, MADE, ROLLING, NUMERICS, &format!("{PRESSED}\n{more}"));
        Scene::from_str(&text, "scene.toml").map_err(|error| error.render(false))
    };
    answer("slice_coupling = \"local\"").unwrap();
    answer("tread = \"uncoupled\"").unwrap();
    for (more, key, word) in [
        ("local_compliance = 5e-10", "local_compliance", "pressed"),
        ("slice_coupling = \"explicit\"", "slice_coupling", "pressed"),
        ("tread = \"bedding\"", "tread", "elastic"),
    ] {
        let text = answer(more).unwrap_err();
        assert!(text.contains(key) && text.contains(word), "{more}: {text}");
    }
    let cells = scene_text(128, MADE, ROLLING, NUMERICS, "[contact]\nzone = \"cells\"\nslices = \"pressed\"");
    assert!(Scene::from_str(&cells, "scene.toml").is_err());
}

#[test]
fn measured_roads_have_cells_of_two_millimetres_by_default() {
    let seal = reference(CHIP_SEAL).display().to_string();
    let road = format!("kind = \"profile\"\nfile = '{seal}'\nlateral = \"isotropic\"");
    let of = |contact: &str| {
        let text = scene_text(256, &road, ROLLING, NUMERICS, &format!("[contact]\n{contact}"));
        let plan = Plan::of(&scene(&text)).unwrap();
        (decisions(&plan).cells_across.unwrap_or(0), decisions(&plan).cells_along.unwrap_or(0), plan)
    };
    let (across, along, plan) = of("slices = \"pressed\"");
    let width = plan.scene.tyre.contact_width;
    assert!((width / across as f64) <= 2e-3 && (width / across as f64) > 1.9e-3);
    assert!((plan.element / along as f64) <= 2e-3 && (plan.element / along as f64) > 1e-3);
    let (across, along, _) = of("slices = \"pressed\"\ncells_across = 20\ncells_along = 3");
    assert_eq!((across, along), (20, 3));
    // So are springs; other couplings resolve the road as it is.
    let (across, along, _) = of("slices = \"winkler\"");
    assert_eq!((across, along), ((width / 2e-3).round() as usize, (plan.element / 2e-3).ceil() as usize));
    let (across, along, _) = of("slice_coupling = \"explicit\"");
    assert_eq!((across, along), (0, 0));
}

#[test]
fn plans_of_a_pressed_road_know_its_work() {
    let plan = Plan::of(&scene(&scene_text(128, MADE, ROLLING, NUMERICS, PRESSED))).unwrap();
    let texture = decisions(&plan).rows.iter().find(|row| row.form.contains("pressed")).unwrap();
    assert!(texture.on, "{texture:?}");
    assert!(plan.notes().any(|note| note.contains("pressed")));
}

/// Elements of a window, and cells along each.
const WINDOW: usize = 56;
const ALONG: usize = 2;
const ACROSS: usize = 57;

/// Forces of a window's slices by the local law, improved one by one from those before.
fn slices(influence: &[f64], c: f64, curves: &[StiffnessCurve], heights: &[f64], forces: &mut [f64]) {
    for _ in 0..2000 {
        let (mut change, mut largest) = (0.0_f64, 0.0_f64);
        for i in 0..forces.len() {
            let others = (0..forces.len()).filter(|&j| j != i).map(|j| influence[i.abs_diff(j)] * forces[j]);
            let y = heights[i] + curves[i].peak - others.sum::<f64>();
            // w + (G0/c - 1) S(w) = y, c F = S(w).
            let excess = influence[0] / c - 1.0;
            let piece = curves[i].piece(curves[i].segment_index_in_series(y, excess, 0));
            let w = (y - excess * piece.intercept) / (1.0 + excess * piece.slope);
            let force = if y > 0.0 { (piece.slope * w + piece.intercept) / c } else { 0.0 };
            change = change.max((force - forces[i]).abs());
            largest = largest.max(force);
            forces[i] = force;
        }
        if change < 1e-7 * largest {
            return;
        }
    }
}

/// Root mean square of a list in the third octave of wavelengths about `middle` \[m\], faded in and out.
fn band(values: &[f64], spacing: f64, middle: f64) -> f64 {
    let (count, mean) = (values.len(), values.iter().sum::<f64>() / values.len() as f64);
    let fade = |i: usize| (PI * (i as f64 + 0.5) / count as f64).sin().powi(2);
    let length = count as f64 * spacing;
    let (from, to) = (length / (middle * 10_f64.powf(0.05)), length / (middle * 10_f64.powf(-0.05)));
    let numbers = (1..count / 2).filter(|&n| n as f64 > from && n as f64 <= to);
    let square = |n: usize| {
        let sum = |wave: fn(f64) -> f64| {
            let term = |(i, value): (usize, &f64)| {
                (value - mean) * fade(i) * wave(TAU * (n * i % count) as f64 / count as f64)
            };
            values.iter().enumerate().map(term).sum::<f64>()
        };
        sum(f64::cos).powi(2) + sum(f64::sin).powi(2)
    };
    numbers.map(square).sum::<f64>().sqrt()
}

/// A tyre at rest whose tread has the modulus that texture is pressed with.
fn at_rest(tyre: &Tyre) -> Tyre {
    let mut tyre = Tyre { angular_velocity: 0.0, crown_radius: None, ..tyre.clone() };
    let effective = tread_modulus(&tyre).unwrap();
    let material = &mut tyre.layers.last_mut().unwrap().material;
    (material.law, material.modulus) = (Law::Elastic, effective * (1.0 - material.poisson * material.poisson));
    tyre
}

/// Laws of slices against cells under a tyre that stands element by element on `metres` of road: misfit of the lines'
/// forces, and of third octaves from 200 to 25 mm \[dB\].
fn compared(name: &str, loaded: &LoadedScene, indentation: f64, crowned: bool, metres: f64) -> [[f64; 2]; 2] {
    let plan = Plan::new(&loaded.scene);
    let (lattice, tyre) = (plan.lattice().unwrap(), &decisions(&plan).tyre);
    assert_eq!((lattice.along, lattice.columns), (ALONG, ACROSS));
    let mut surface = RoadSurface::open(&loaded.scene.road, lattice, Limits::default()).unwrap();
    let (first, elements) = (100, (metres / lattice.dx) as usize);
    let mut heights = vec![0.0; elements * lattice.cells()];
    surface.heights(first, elements, &mut heights).unwrap();
    let crown: Vec<f64> = (0..ACROSS).map(|column| plan.crown(lattice.y(column))).collect();
    let pressed_crown = crown.iter().map(|crown| if crowned { *crown } else { 0.0 }).collect();
    let mut pressed = PressedRoad::new(tyre, lattice, pressed_crown).unwrap().uncached();
    let begin = std::time::Instant::now();
    let curves = pressed.curves(&mut surface, first..first + elements as i64).unwrap();
    let seconds = begin.elapsed().as_secs_f64();
    let kappa = local_compliance(tyre, &surface).unwrap();
    let springs = SliceBuilder::winkler(ACROSS).unwrap().with_lines(ALONG).unwrap().build_rows(&heights).unwrap();
    let laws = [(kappa / (lattice.dx * lattice.width()), springs), (pressed.spring(), curves)];

    let grid = CellGrid::new(&at_rest(tyre), loaded.scene.numerics.elements * ALONG, ACROSS);
    let truncation = CellTruncation { lateral_terms: None, aliases: None };
    let influence = CellSums::new(&at_rest(tyre), grid, truncation, 1e-5, 1.0).cached_instant(0.0, WINDOW * ALONG);
    let line = {
        // The lines' images, too: the mean over j + j' of H.
        let mut folded = influence.clone();
        for (toeplitz, hankel) in folded.toeplitz.chunks_mut(ACROSS).zip(influence.hankel.chunks(2 * ACROSS - 1)) {
            let pairs = |sum: usize| (sum + 1).min(2 * ACROSS - 1 - sum) as f64;
            let mean: f64 = hankel.iter().enumerate().map(|(sum, value)| pairs(sum) * value).sum();
            toeplitz.iter_mut().for_each(|value| *value += mean / (ACROSS * ACROSS) as f64);
        }
        line_influence(&folded, lattice)
    };
    let mut search = CellSearch::new(InstantCells::new(influence), 1e-5);
    let rise = |x: f64| tyre.radius() - (tyre.radius().powi(2) - x * x).sqrt();
    let middle = |count: usize, i: usize| i as f64 - 0.5 * (count as f64 - 1.0);
    let mut cells = vec![0.0; WINDOW * lattice.cells()];
    let mut required = cells.clone();
    let mut lines = [vec![0.0; WINDOW], vec![0.0; WINDOW]];
    let (mut totals, mut missed, mut squares) = ([vec![], vec![], vec![]], [0.0; 2], 0.0);
    for position in 0..elements - WINDOW {
        let under = &heights[position * lattice.cells()..][..cells.len()];
        for (row, (required, heights)) in required.chunks_mut(ACROSS).zip(under.chunks(ACROSS)).enumerate() {
            let above = rise(middle(WINDOW * ALONG, row) * lattice.cell());
            for ((required, height), crown) in required.iter_mut().zip(heights).zip(&crown) {
                *required = indentation - above - crown + height;
            }
        }
        search.solve(&required, &mut cells);
        let found: Vec<f64> = cells.chunks(lattice.cells()).map(|cells| cells.iter().sum()).collect();
        totals[0].push(found.iter().sum::<f64>());
        squares += found.iter().map(|force| force * force).sum::<f64>();
        let chord: Vec<f64> = (0..WINDOW).map(|i| indentation - rise(middle(WINDOW, i) * lattice.dx)).collect();
        for (law, ((c, curves), forces)) in laws.iter().zip(&mut lines).enumerate() {
            slices(&line, *c, &curves[position..][..WINDOW], &chord, forces);
            totals[law + 1].push(forces.iter().sum());
            missed[law] += found.iter().zip(&*forces).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let count = totals[0].len();
    println!("{name}: {count} positions, crown pressed {crowned}, {:.0} ms for a metre", 1e3 * seconds / metres);
    std::array::from_fn(|law| {
        let of = |values: &[f64], number: i32| band(values, lattice.dx, 0.2 * 10_f64.powf(-0.1 * f64::from(number)));
        let level = |number| 20.0 * (of(&totals[law + 1], number) / of(&totals[0], number)).log10();
        let levels: Vec<f64> = (0..10).map(level).filter(|level| level.is_finite()).collect();
        let rms = mean(&levels.iter().map(|level| level * level).collect::<Vec<_>>()).sqrt();
        let lines = (missed[law] / squares).sqrt();
        let name = ["winkler", "pressed"][law];
        let means = [&totals[0], &totals[law + 1]].map(|values| mean(values));
        println!("  {name}: {:.0} N for {:.0} N, lines {lines:.3}, bands {rms:.2} dB {levels:.1?}", means[1], means[0]);
        [lines, rms]
    })
}

#[test]
#[ignore = "some thousand solutions of contact over cells: a minute"]
fn pressed_curves_are_nearer_to_cells_than_springs_are() {
    let chip = format!("kind = \"profile\"\nlateral = \"isotropic\"\nseed = 1\nfile = {:?}", reference(CHIP_SEAL));
    let seal =
        "kind = \"made\"\nseed = 3\npower_law = { rms = 0.0012, exponent = 2.0, longest = 0.1, shortest = 0.005 }";
    for (name, road) in [("default", "kind = \"made\"\nseed = 1"), ("seal", seal), ("station", &chip)] {
        let mut loaded = scene(&with_road(DEFAULT, road));
        let contact = &mut loaded.scene.contact;
        (contact.cells_along, contact.cells_across) = (Some(ALONG), Some(ACROSS));
        for indentation in [0.0145, 0.005] {
            for crowned in [true, false] {
                let [springs, pressed] = compared(name, &loaded, indentation, crowned, 3.0);
                assert!(pressed[0] < 1.1 * springs[0], "{name}: {pressed:?} {springs:?}");
            }
        }
    }
}
