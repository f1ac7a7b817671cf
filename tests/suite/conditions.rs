//! The three conditions of the contact problem, derived again from what a run has written, by the longest way there is:
//! weights from a plain double sum over wavenumbers and lateral terms, the history element by element round the tyre,
//! slices cell by cell.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::{Arc, Mutex};

use num_complex::Complex64;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tyrewave::internals::{
    CHIP_SEAL, CIRCUMFERENCE, COBBLES, CONTACT_WIDTH, grid_road, reference, scene, scene_text, transforms,
};
use tyrewave::road::{Lattice, Limits, RoadSurface};
use tyrewave::scene::Tyre;
use tyrewave::tyre::Stack;

use crate::common::{Results, run, write_grid};

const SPEED: f64 = 80.0 / 3.6;
/// As in [`scene_text`].
const LATERAL_TERMS: usize = 4;
const ALIASES: i64 = 2;

struct Case {
    elements: usize,
    substeps: usize,
    start: f64,
    indentation: f64,
    ramp: f64,
    /// True on one cell under an element: its slice is flat.
    flat: bool,
    law: SliceLaw,
}

/// By how much a slice yields more than its element.
#[derive(Clone, Copy, Debug)]
enum SliceLaw {
    Explicit,
    /// kappa \[m/Pa\].
    Local(f64),
}

use SliceLaw::{Explicit, Local};

impl SliceLaw {
    /// A slice's compliance in series with the tread \[m/N\]; equation 4 has none.
    fn compliance(self, element: f64) -> Option<f64> {
        match self {
            Explicit => None,
            Local(kappa) => Some(kappa / (element * CONTACT_WIDTH)),
        }
    }
}

/// The [`weights`] of elements, substeps and lags, which the cases of all tests here share: their tyre is the same.
fn known_weights(tyre: &Tyre, case: &Case, lags: usize) -> Arc<Vec<f64>> {
    type Known = BTreeMap<(usize, usize, usize), Arc<Vec<f64>>>;
    static KNOWN: Mutex<Known> = Mutex::new(Known::new());
    let mut known = KNOWN.lock().unwrap();
    known.entry((case.elements, case.substeps, lags)).or_insert_with(|| Arc::new(weights(tyre, case, lags))).clone()
}

/// w_p(j) for lags 0..lags and j = 0..N, BDF2: row p, column j.
fn weights(tyre: &Tyre, case: &Case, lags: usize) -> Vec<f64> {
    let elements = case.elements as i64;
    let (element, width) = (CIRCUMFERENCE / elements as f64, tyre.width);
    let time_step = element / (case.substeps as f64 * SPEED);
    // Another circle than the program's: four times the lags, not a power of two, another radius.
    let points = 4 * lags + 3;
    let radius = 1e-13_f64.powf(1.0 / points as f64);
    let stack = Stack::new(tyre);
    let mut transfer = vec![Complex64::ZERO; case.elements * points];
    for k in 0..points {
        let zeta = Complex64::from_polar(radius, -2.0 * PI * k as f64 / points as f64);
        let s = (Complex64::new(1.5, 0.0) - 2.0 * zeta + 0.5 * zeta * zeta) / time_step;
        let at = stack.at(s);
        for n in -elements / 2..=0 {
            let mut sum = Complex64::ZERO;
            for p in -ALIASES..=ALIASES {
                let kx = 2.0 * PI * (n + p * elements) as f64 / CIRCUMFERENCE;
                let half = 0.5 * kx * element;
                let along = if half.abs() < 1e-12 { 1.0 } else { half.sin() / half };
                for term in 0..LATERAL_TERMS {
                    let ky = (2 * term + 1) as f64 * PI / width;
                    // The mean of sin(ky y) over the centred strip, integrated.
                    let (from, to) = (0.5 * (width - CONTACT_WIDTH), 0.5 * (width + CONTACT_WIDTH));
                    let mean = ((ky * from).cos() - (ky * to).cos()) / (ky * CONTACT_WIDTH);
                    sum += at.normal(kx, ky).surface * (along * along / CIRCUMFERENCE * 2.0 / width * mean * mean);
                }
            }
            for column in [n.rem_euclid(elements), (-n).rem_euclid(elements)] {
                transfer[column as usize * points + k] = sum;
            }
        }
    }
    let (in_time, in_space) = (transforms::inverse(points), transforms::inverse(case.elements));
    transfer.chunks_exact_mut(points).for_each(|row| in_time.process(row));
    let mut weights = vec![0.0; lags * case.elements];
    for (p, row) in weights.chunks_exact_mut(case.elements).enumerate() {
        let scale = radius.powi(-(p as i32)) / points as f64;
        let mut ring: Vec<Complex64> =
            (0..case.elements).map(|n| Complex64::new(transfer[n * points + p].re * scale, 0.0)).collect();
        in_space.process(&mut ring);
        row.iter_mut().zip(ring).for_each(|(weight, value)| *weight = value.re);
    }
    weights
}

/// Largest violations: (tension, penetration, complementarity), relative to the peaks.
fn residuals(results: &Results, case: &Case, tyre: &Tyre, heights: &dyn Fn(i64) -> Vec<f64>) -> [f64; 3] {
    let n = case.elements;
    let element = CIRCUMFERENCE / n as f64;
    let radius = CIRCUMFERENCE / (2.0 * PI);
    let (rows, columns, patch) = results.patch();
    let first = results.elements();
    let time = results.array("time.npy");
    let weights = known_weights(tyre, case, rows);
    // Forces by tyre element.
    let mut forces = vec![0.0; rows * n];
    for (step, row) in patch.chunks_exact(columns).enumerate() {
        for (column, force) in row.iter().enumerate() {
            forces[step * n + (first[step] + column as i64).rem_euclid(n as i64) as usize] = *force;
        }
    }
    let mut worst = [0.0_f64; 3];
    let (mut peak_force, mut peak_displacement) = (0.0_f64, 0.0_f64);
    for step in 0..rows {
        let axle = case.start + SPEED * time[step];
        let indentation = case.indentation * (time[step] / case.ramp).min(1.0);
        for column in 0..columns {
            let e = first[step] + column as i64;
            let at = |past: usize| {
                let row = &forces[past * n..(past + 1) * n];
                let lag = &weights[(step - past) * n..(step - past + 1) * n];
                let touched = row.iter().enumerate().filter(|(_, force)| **force != 0.0);
                touched.map(|(j, force)| force * lag[(e - j as i64).rem_euclid(n as i64) as usize]).sum::<f64>()
            };
            let old: f64 = (0..step).map(at).sum();
            let x = e as f64 * element - axle;
            let slice = heights(e);
            let peak = slice.iter().fold(f64::MIN, |a, &b| a.max(b));
            let penetration = indentation - (radius - (radius * radius - x * x).sqrt()) + peak - old;
            let displacement = at(step);
            let force = patch[step * columns + column];
            // A slice that yields by c feels y - G0 F + c F; the rest of y moves stones and rubber alike.
            let compliance = case.law.compliance(element);
            let rest = compliance.map_or(0.0, |compliance| displacement - compliance * force);
            let local_penetration = penetration - rest;
            let required = if local_penetration <= 0.0 {
                penetration
            } else {
                rest + slice.iter().map(|z| (local_penetration - (peak - z)).max(0.0)).sum::<f64>() / slice.len() as f64
            };
            worst[0] = worst[0].max(-force);
            worst[1] = worst[1].max(required - displacement);
            worst[2] = worst[2].max((force * (displacement - required)).abs());
            peak_force = peak_force.max(force);
            peak_displacement = peak_displacement.max(required);
        }
    }
    assert!(peak_force > 50.0 && peak_displacement > 1e-4, "there was hardly any contact");
    [worst[0] / peak_force, worst[1] / peak_displacement, worst[2] / (peak_force * peak_displacement)]
}

fn assert_met(name: &str, residuals: [f64; 3]) {
    println!(
        "{name}: tension {:.1e}, penetration {:.1e}, complementarity {:.1e}",
        residuals[0], residuals[1], residuals[2]
    );
    assert!(residuals.iter().all(|&residual| residual <= 1e-9), "{name}: {residuals:?}");
}

fn text(case: &Case, road: &str) -> String {
    let rolling = format!(
        "speed_kmh = 80.0\nwarm_up = 0.0\nduration = 0.2\nstart = {:?}\naxle = {{ indentation = {:?}, ramp = {:?} }}",
        case.start, case.indentation, case.ramp
    );
    let cells = if case.flat { "cells_across = 1\ncells_along = 1\n" } else { "" };
    let coupling = match case.law {
        Explicit => "slice_coupling = \"explicit\"".to_owned(),
        Local(kappa) => format!("slice_coupling = \"local\"\nlocal_compliance = {kappa:e}"),
    };
    let numerics = format!("substeps = {}\nmemory = 0.25", case.substeps);
    scene_text(
        case.elements,
        road,
        &rolling,
        &numerics,
        &format!("[contact]\n{cells}slice_tolerance = 0.0\n{coupling}"),
    )
}

#[test]
fn conditions_hold_on_a_rough_grid() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.npy");
    let (rows, columns) = (300, 6);
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let heights: Vec<f64> = (0..rows * columns).map(|_| random.random_range(-1.2e-3..1.2e-3)).collect();
    write_grid(&path, columns, &heights);
    // G0_ii is 6e-7 m/N with N = 64 and q = 1: compliances on both sides of it.
    for (elements, substeps, law) in [
        (64, 1, Explicit),
        (64, 3, Explicit),
        (96, 1, Explicit),
        (64, 1, Local(5.5e-10)),
        (64, 3, Local(5.5e-10)),
        (96, 2, Local(2e-8)),
    ] {
        let case = Case { elements, substeps, start: 0.7, indentation: 0.012, ramp: 0.04, flat: false, law };
        let text = text(&case, &grid_road(&path, elements, columns));
        let results = run(&text);
        results.assert_sound("grid");
        let slice = |e: i64| heights[e as usize * columns..(e as usize + 1) * columns].to_vec();
        let name = format!("grid, N = {elements}, q = {substeps}, {law:?}");
        assert_met(&name, residuals(&results, &case, &scene(&text).scene.tyre, &slice));
    }
}

#[test]
fn conditions_hold_on_a_made_road() {
    for (substeps, flat, law) in
        [(2, false, Explicit), (1, true, Explicit), (2, false, Local(5.5e-10)), (1, true, Local(5.5e-10))]
    {
        let case = Case { elements: 64, substeps, start: 0.0, indentation: 0.012, ramp: 0.04, flat, law };
        let text = text(&case, "kind = \"made\"\nseed = 4");
        let results = run(&text);
        results.assert_sound("made road");
        let loaded = scene(&text);
        let element = CIRCUMFERENCE / case.elements as f64;
        let cells = flat.then_some(1);
        let lattice = Lattice::choose(&loaded.scene.road, element, CONTACT_WIDTH, cells, cells).unwrap();
        // The road once again, all of it at once.
        let mut road = RoadSurface::open(&loaded.scene.road, lattice, Limits::default()).unwrap();
        let (first, rows) = (-40, 300);
        let mut heights = vec![0.0; rows * lattice.cells()];
        road.heights(first, rows, &mut heights).unwrap();
        let slice = |e: i64| {
            let row = (e - first) as usize;
            heights[row * lattice.cells()..(row + 1) * lattice.cells()].to_vec()
        };
        assert_met(&format!("made road, flat {flat}, {law:?}"), residuals(&results, &case, &loaded.scene.tyre, &slice));
    }
}

#[test]
fn a_wrong_force_would_be_noticed() {
    // The check itself: a slightly wrong indentation breaks the conditions by a wide margin.
    let case =
        Case { elements: 64, substeps: 1, start: 0.0, indentation: 0.012, ramp: 0.04, flat: true, law: Explicit };
    let text = text(&case, "kind = \"smooth\"");
    let results = run(&text);
    let tyre = scene(&text).scene.tyre;
    assert_met("smooth", residuals(&results, &case, &tyre, &|_| vec![0.0]));
    let wrong = Case { indentation: 0.012 * (1.0 + 1e-6), ..case };
    assert!(residuals(&results, &wrong, &tyre, &|_| vec![0.0])[1] > 1e-7);
}

/// A run on a measured road: no search given up, residuals as the run itself reports them.
fn assert_measured(name: &str, road: &str, rolling: &str) {
    let results = run(&scene_text(128, road, rolling, "memory = 0.25", ""));
    results.assert_sound(name);
    let contact = &results.report.summary.contact;
    let fallbacks = results.summary()["cost"]["counters"]["fallbacks"].clone();
    println!(
        "{name}: {} steps, least-index fallbacks {fallbacks}, tension {:.1e}, penetration {:.1e}, complementarity \
         {:.1e}",
        results.report.summary.outcome.steps, contact.tension, contact.penetration, contact.complementarity
    );
}

const MEASURED: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.25\naxle = { load = 3400.0, tolerance = 0.2 }";

#[test]
fn no_search_is_given_up_on_the_captif_profile() {
    let path = reference(CHIP_SEAL);
    for lateral in ["extruded", "isotropic"] {
        let end = if lateral == "extruded" { "at_end = \"mirror\"" } else { "" };
        let road = format!("kind = \"profile\"\nfile = '{}'\nlateral = \"{lateral}\"\n{end}", path.display());
        assert_measured(&format!("CAPTIF station 10, {lateral}"), &road, MEASURED);
    }
}

#[test]
fn no_search_is_given_up_on_the_belgian_block() {
    let road = format!("kind = \"opencrg\"\nfile = '{}'\nlongest_wavelength = 1.0", reference(COBBLES).display());
    assert_measured("belgian block", &road, MEASURED);
}
