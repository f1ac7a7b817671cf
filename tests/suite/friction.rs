//! Contact over cells with friction: whole runs against a calculation written apart, limits and hard cases.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use rayon::prelude::*;
use tyrewave::Plan;
use tyrewave::internals::{SavedState, TangentialPart, add, choices, edit, march, march_mut, scene, scene_text};
use tyrewave::run::Simulation;
use tyrewave::scene::{LoadedScene, Tyre};
use tyrewave::tyre::Stack;

use crate::common::run;

const ELEMENTS: usize = 64;
const ACROSS: usize = 3;
const LATERAL_TERMS: usize = 5;
const LAGS: usize = 150;
const STEPS: usize = 130;
const SPEED: f64 = 80.0 / 3.6;
const INDENTATION: f64 = 0.014;

/// A scene whose sums are finite: `friction` holds the keys of the table.
pub(super) fn finite(friction: &str, road: &str) -> String {
    let time_step = 1.95 / ELEMENTS as f64 / SPEED;
    let rolling = format!(
        "speed_kmh = 80.0\nwarm_up = 0.0\nduration = {:?}\naxle = {{ indentation = {INDENTATION} }}",
        (STEPS as f64 + 0.5) * time_step
    );
    let numerics = format!(
        "time_rule = \"bdf2\"\nhistory = \"direct\"\nmemory = {:?}\ninfluence_tolerance = 1e-12",
        (LAGS as f64 - 0.5) * time_step
    );
    let more = format!("[contact]\nzone = \"cells\"\ncells_across = {ACROSS}\n{friction}");
    let text = scene_text(ELEMENTS, road, &rolling, &numerics, &more);
    edit(&text, &[("numerics.lateral_terms", &LATERAL_TERMS.to_string()), ("numerics.wavenumber_aliases", "0")])
}

pub(super) const SMOOTH: &str = "kind = \"smooth\"";
const CREEP: [f64; 4] = [0.02, 0.03, 0.6, 0.02];
const MU: f64 = 0.9;

fn with_creep() -> String {
    let [longitudinal, lateral, spin, ramp] = CREEP;
    format!(
        "[friction]\nmu = {MU}\n[friction.creep]\nlongitudinal = {longitudinal}\nlateral = {lateral}\nspin = {spin}\n\
         ramp = {ramp}"
    )
}

/// Total normal, longitudinal and lateral force, moment and slip power of each step.
pub(super) fn totals(loaded: &LoadedScene) -> Vec<[f64; 5]> {
    let plan = Plan::of(loaded).unwrap();
    let mut run = Simulation::begin(loaded, &plan, &Default::default()).unwrap();
    let mut all = Vec::new();
    while let Some(step) = run.step().unwrap() {
        let part = march(&run).footprint().tangential().cloned().unwrap_or_default();
        all.push([step.total_force, part.total[0], part.total[1], part.aligning_moment, part.slip_power]);
    }
    all
}

/// Mistake of a calculation written apart.
#[derive(Clone, Copy, PartialEq)]
enum Mistake {
    None,
    NoUniformWave,
    OtherSignAlong,
}

/// Weights of the convolution in space: by lag, distance along round the tyre, cells across, 3 x 3.
struct Apart {
    weights: Vec<[[f64; 3]; 3]>,
}

impl Apart {
    fn new(tyre: &Tyre, time_step: f64, mistake: Mistake) -> Self {
        let (length, pitch) = (tyre.circumference / ELEMENTS as f64, tyre.contact_width / ACROSS as f64);
        let points = 512;
        let radius = 1e-12_f64.powf(1.0 / points as f64);
        let stacks: Vec<_> = (0..points)
            .map(|k| {
                let zeta = Complex64::from_polar(radius, -TAU * k as f64 / points as f64);
                Stack::new(tyre).at((1.5 - 2.0 * zeta + 0.5 * zeta * zeta) / time_step)
            })
            .collect();
        let turns: Vec<Complex64> =
            (0..points).map(|k| Complex64::from_polar(1.0, TAU * k as f64 / points as f64)).collect();
        let sinc = |x: f64| if x == 0.0 { 1.0 } else { x.sin() / x };
        let y = |j: usize| 0.5 * (tyre.width - tyre.contact_width) + (j as f64 + 0.5) * pitch;
        let zero = [[0.0; 3]; 3];
        let mut weights = vec![zero; LAGS * ELEMENTS * ACROSS * ACROSS];
        let half = ELEMENTS as i64 / 2;
        for m in 0..=LATERAL_TERMS {
            if m == 0 && mistake == Mistake::NoUniformWave {
                continue;
            }
            let ky = PI * m as f64 / tyre.width;
            let shape = |component: usize, j: usize| {
                let share = sinc(0.5 * ky * pitch);
                share * if component == 1 { (ky * y(j)).cos() } else { (ky * y(j)).sin() }
            };
            let norm = if m == 0 { 1.0 } else { 2.0 } / tyre.width;
            // n and -n are conjugate: the compliance is that of real functions of s.
            for n in 0..=half {
                let kx = TAU * n as f64 / tyre.circumference;
                // Real factors of pairs: even ones of cos, odd ones of -sin of the distance.
                let mut lags = vec![[[0.0; 3]; 3]; LAGS];
                let values: Vec<[[Complex64; 3]; 3]> = stacks
                    .iter()
                    .map(|at| {
                        // C_xz = -i (kx/k) C_Lz, and C_yz likewise.
                        let full = at.full(kx, ky).0;
                        let (xx, yy, zz, xy) = (full[0][0], full[1][1], full[2][2], full[0][1]);
                        let turned = if mistake == Mistake::OtherSignAlong { -1.0 } else { 1.0 };
                        // Coefficients of i where they are odd. z points into the tyre here.
                        let (xz, yz) = (full[0][2] * Complex64::i() * turned, full[1][2] * Complex64::i());
                        [[xx, xy, xz], [-xy, yy, yz], [-xz, yz, zz]]
                    })
                    .collect();
                for (lag, out) in lags.iter_mut().enumerate() {
                    for (place, out) in out.as_flattened_mut().iter_mut().enumerate() {
                        let sum: f64 = values
                            .iter()
                            .enumerate()
                            .map(|(p, value)| (value[place / 3][place % 3] * turns[p * lag % points]).re)
                            .sum();
                        *out = sum / points as f64 * radius.powi(-(lag as i32));
                    }
                }
                let sides = if n == 0 || n == half { 1.0 } else { 2.0 };
                let weight = sides * sinc(0.5 * kx * length).powi(2) / tyre.circumference * norm;
                for (lag, value) in lags.iter().enumerate() {
                    for distance in 0..ELEMENTS {
                        let phase = TAU * (n as usize * distance % ELEMENTS) as f64 / ELEMENTS as f64;
                        let (even, odd) = (phase.cos(), -phase.sin());
                        for place in 0..ACROSS * ACROSS {
                            let (j, other) = (place / ACROSS, place % ACROSS);
                            let out = &mut weights[(lag * ELEMENTS + distance) * ACROSS * ACROSS + place];
                            for a in 0..3 {
                                for b in 0..3 {
                                    let is_odd = (a == 0) != (b == 0);
                                    let wave = match is_odd {
                                        true if n == 0 || n == half => 0.0,
                                        true => odd,
                                        false => even,
                                    };
                                    out[a][b] += weight * wave * value[a][b] * shape(a, j) * shape(b, other);
                                }
                            }
                        }
                    }
                }
            }
        }
        Self { weights }
    }

    /// Influence between cells (i, j) round the tyre.
    fn block(&self, lag: usize, [i, j]: [i64; 2], [from, other]: [i64; 2]) -> &[[f64; 3]; 3] {
        let distance = (i - from).rem_euclid(ELEMENTS as i64) as usize;
        &self.weights[((lag * ELEMENTS + distance) * ACROSS + j as usize) * ACROSS + other as usize]
    }

    /// Steps over a smooth road, forces to within a part of the largest one: totals of each step.
    fn roll(&self, tyre: &Tyre, time_step: f64, mu: f64, tolerance: f64) -> Vec<[f64; 5]> {
        const REACH: i64 = 6;
        let (length, pitch) = (tyre.circumference / ELEMENTS as f64, tyre.contact_width / ACROSS as f64);
        let radius = tyre.circumference / TAU;
        let [xi, alpha, phi, ramp] = CREEP;
        type Cells = Vec<([i64; 2], [f64; 3])>;
        let mut past: Vec<Cells> = Vec::new();
        let mut displaced: Vec<std::collections::BTreeMap<[i64; 2], [f64; 3]>> = Vec::new();
        let mut all = Vec::new();
        for step in 0..STEPS as i64 {
            let x = |i: i64| (i - step) as f64 * length;
            let y = |j: i64| (j as f64 + 0.5) * pitch - 0.5 * tyre.contact_width;
            let cells: Vec<[i64; 2]> =
                (step - REACH..=step + REACH + 2).flat_map(|i| (0..ACROSS as i64).map(move |j| [i, j])).collect();
            let mut u: Vec<[f64; 3]> = vec![[0.0; 3]; cells.len()];
            for (lag, forces) in past.iter().rev().enumerate().take(LAGS - 1) {
                for (cell, force) in forces {
                    for (at, u) in cells.iter().zip(&mut u) {
                        let block = self.block(lag + 1, *at, *cell);
                        for a in 0..3 {
                            u[a] += (0..3).map(|b| block[a][b] * force[b]).sum::<f64>();
                        }
                    }
                }
            }
            let last = |ago: usize, cell: &[i64; 2]| -> [f64; 3] {
                let there = displaced.len().checked_sub(ago).and_then(|at| displaced[at].get(cell));
                there.copied().unwrap_or([0.0; 3])
            };
            let risen = (step as f64 * time_step / ramp).min(1.0);
            let creep: Vec<[f64; 2]> = cells
                .iter()
                .map(|&[i, j]| [xi - phi * y(j), alpha + phi * x(i)].map(|ratio| risen * SPEED * ratio))
                .collect();
            let velocity = |place: usize, u: &[f64; 3]| -> [f64; 2] {
                let (one, two) = (last(1, &cells[place]), last(2, &cells[place]));
                [0, 1].map(|c| (1.5 * u[c] - 2.0 * one[c] + 0.5 * two[c]) / time_step + creep[place][c])
            };
            let mut forces = vec![[0.0_f64; 3]; cells.len()];
            let diagonal = self.block(0, [0, 1], [0, 1]);
            let within: Vec<Vec<[[f64; 3]; 3]>> =
                cells.iter().map(|from| cells.iter().map(|at| *self.block(0, *at, *from)).collect()).collect();
            let rate = time_step / 1.5 / diagonal[0][0].max(diagonal[1][1]);
            // Cell after cell until nothing changes.
            for _ in 0..4000 {
                let (mut change, mut largest) = (0.0_f64, 1e-300_f64);
                for place in 0..cells.len() {
                    let [i, _] = cells[place];
                    if (i - step).abs() > REACH {
                        continue;
                    }
                    let rise = radius - (radius * radius - x(i) * x(i)).sqrt();
                    let before = forces[place];
                    let z = (before[2] - (u[place][2] - (INDENTATION - rise)) / diagonal[2][2]).max(0.0);
                    let v = velocity(place, &u[place]);
                    let trial = [0, 1].map(|c| before[c] - rate * v[c]);
                    let (bound, size) = (mu * z, trial[0].hypot(trial[1]));
                    let [fx, fy] = if size > bound { trial.map(|t| t * bound / size) } else { trial };
                    forces[place] = [fx, fy, z];
                    let delta = [fx - before[0], fy - before[1], z - before[2]];
                    for (block, u) in within[place].iter().zip(&mut u) {
                        for (u, row) in u.iter_mut().zip(block) {
                            *u += row[0] * delta[0] + row[1] * delta[1] + row[2] * delta[2];
                        }
                    }
                    change = delta.iter().fold(change, |change, delta| change.max(delta.abs()));
                    largest = largest.max(z);
                }
                if change < tolerance * largest {
                    break;
                }
            }
            let mut total = [0.0; 5];
            for place in 0..cells.len() {
                let ([fx, fy, fz], [i, j]) = (forces[place], cells[place]);
                let v = velocity(place, &u[place]);
                let of_cell = [fz, fx, fy, x(i) * fy - y(j) * fx, -fx * v[0] - fy * v[1]];
                total.iter_mut().zip(of_cell).for_each(|(total, value)| *total += value);
            }
            all.push(total);
            displaced.push(cells.iter().copied().zip(u).collect());
            past.push(cells.into_iter().zip(forces).filter(|(_, force)| force[2] > 0.0).collect());
        }
        all
    }
}

/// Largest difference of a total, relative to the largest normal force.
fn difference(a: &[[f64; 5]], b: &[[f64; 5]], which: usize) -> f64 {
    let largest = a.iter().fold(0.0_f64, |largest, total| largest.max(total[0]));
    a.iter().zip(b).fold(0.0_f64, |worst, (a, b)| worst.max((a[which] - b[which]).abs())) / largest
}

#[test]
fn forces_with_friction_are_those_of_a_separate_calculation() {
    let loaded = scene(&finite(&with_creep(), SMOOTH));
    let found = totals(&loaded);
    let tyre = &loaded.scene.tyre;
    let time_step = tyre.circumference / ELEMENTS as f64 / SPEED;
    // With what must not be left out or turned round, too.
    let all = [(Mistake::None, 1e-11), (Mistake::NoUniformWave, 1e-6), (Mistake::OtherSignAlong, 1e-6)];
    let apart = |(mistake, tolerance)| Apart::new(tyre, time_step, mistake).roll(tyre, time_step, MU, tolerance);
    let all: Vec<Vec<[f64; 5]>> = all.into_par_iter().map(apart).collect();
    let [exact, without, turned] = &all[..] else { panic!("three calculations") };
    assert_eq!(found.len().min(STEPS), STEPS);
    let last = exact[STEPS - 1];
    println!("Fz, Fx, Fy, Mz, P at the end: {last:?}, found {:?}", found[STEPS - 1]);
    assert!(last[0] > 500.0 && last[1] < -100.0 && last[2] < -100.0, "{last:?}");
    for (which, name) in ["normal", "longitudinal", "lateral", "moment"].iter().enumerate() {
        let error = difference(exact, &found, which);
        println!("{name}: {error:.1e}");
        assert!(error < 1e-6, "{name}: {error:e} of the largest force");
    }
    let power = exact.iter().fold(0.0_f64, |largest, total| largest.max(total[4]));
    assert!(exact.iter().zip(&found).all(|(a, b)| (a[4] - b[4]).abs() < 1e-6 * power && b[4] >= 0.0));
    let (lateral, longitudinal) = (difference(without, &found, 2), difference(turned, &found, 1));
    println!("without m = 0: {lateral:.1e}, C_xz of other sign: {longitudinal:.1e}");
    assert!(lateral > 1e-3 && longitudinal > 1e-3, "{lateral:e} {longitudinal:e}");
}

#[test]
fn without_friction_forces_are_those_of_cells_to_the_last_bit() {
    let made = "kind = \"made\"\nseed = 3";
    let [with, without] = ["[friction]\nmu = 0.0", ""].map(|friction| totals(&scene(&finite(friction, made))));
    assert!(with.iter().any(|total| total[0] > 100.0));
    assert!(with.iter().zip(&without).all(|(a, b)| a[0].to_bits() == b[0].to_bits()));
    // The friction of the search itself tends to the same.
    let small = totals(&scene(&finite("[friction]\nmu = 1e-12", made)));
    assert!(difference(&small, &without, 0) < 1e-8, "{:e}", difference(&small, &without, 0));
}

#[test]
fn threads_change_no_bit_of_tangential_forces() {
    let text = finite(&with_creep(), "kind = \"made\"\nseed = 3");
    let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| run(&text));
    let (one, two) = (on(1), on(2));
    one.assert_sound("one thread");
    for name in ["total_force", "longitudinal_force", "lateral_force", "aligning_moment", "slip_power"] {
        let file = format!("{name}.npy");
        assert_eq!(std::fs::read(one.path(&file)).unwrap(), std::fs::read(two.path(&file)).unwrap(), "{name}");
    }
    let friction = &one.summary()["outcome"]["friction"];
    assert!(friction["mean_slip_power"].as_f64().unwrap() > 0.0, "{friction}");
    let power = one.array("slip_power.npy");
    assert!(power.iter().all(|power| *power >= 0.0));
}

#[test]
fn large_friction_settles_on_a_rough_road() {
    let made = "kind = \"made\"\nseed = 5";
    for mu in [2.0, 4.0] {
        let friction = format!("[friction]\nmu = {mu}\n[friction.creep]\nlongitudinal = 0.05\nlateral = 0.03");
        let found = totals(&scene(&finite(&friction, made)));
        assert!(found.iter().all(|total| total[4] >= 0.0) && found.iter().any(|total| total[1] < -10.0));
    }
}

#[test]
fn what_friction_cannot_be_with_is_refused_with_its_place() {
    let refusal = |text: &str| {
        let loaded = tyrewave::scene::Scene::from_str(text, "scene.toml");
        loaded.map(|_| String::new()).unwrap_or_else(|error| error.render(false))
    };
    let cells = finite("[friction]\nmu = 0.9", SMOOTH);
    for (text, key, wrong) in [
        (edit(&cells, &[("numerics.time_rule", "\"sdirk2\"")]), "numerics.time_rule", "not stable with friction"),
        (edit(&cells, &[("numerics.time_rule", "\"sdirk3\"")]), "numerics.time_rule", "not stable"),
        (edit(&cells, &[("friction.mu", "-0.1")]), "friction.mu", "-0.1"),
        (add(&cells, "friction", "mu_slow = 1.0"), "friction.mu_slow", "constant coefficient"),
        (finite("[friction]\nlaw = \"falling\"\nmu_slow = 1.0", SMOOTH), "friction.memory_length", "missing"),
        (finite("[friction]", SMOOTH), "friction.mu", "missing"),
        (finite("[adhesion]\nstress = 1e5\nrange = 1e-5", SMOOTH), "adhesion", "friction"),
        (finite("[effects]\nfriction = \"on\"", SMOOTH), "effects.friction", "[friction]"),
        (
            scene_text(
                64,
                SMOOTH,
                "speed_kmh = 80.0\nduration = 0.1\naxle = { load = 3400.0 }",
                "",
                "[friction]\nmu = 1.0",
            ),
            "friction",
            "slice",
        ),
    ] {
        let reported = refusal(&text);
        assert!(
            reported.contains(key) && reported.contains(wrong) && reported.contains("scene.toml:"),
            "{key}: {reported}"
        );
    }
    assert_eq!(refusal(&cells), "");
}

/// Rolls a scene, and on from its state beside it: checks that both are the same to the last bit, and returns the
/// tangential parts of these steps.
pub(super) fn gone_on_from_state(loaded: &LoadedScene) -> Vec<TangentialPart> {
    let plan = Plan::of(loaded).unwrap();
    let begin = || Simulation::begin(loaded, &plan, &Default::default()).unwrap();
    let mut whole = begin();
    for _ in 0..60 {
        whole.step().unwrap().unwrap();
    }
    let state = SavedState::of(march_mut(&mut whole)).unwrap();
    let mut other = begin();
    state.restore(march_mut(&mut other)).unwrap();
    let step = |_| {
        let [original, restored] = [&mut whole, &mut other].map(|run| {
            let total = run.step().unwrap().unwrap().total_force;
            (total.to_bits(), march(run).footprint().tangential().cloned().unwrap())
        });
        assert_eq!(original, restored);
        original.1
    };
    (0..20).map(step).collect()
}

#[test]
fn a_march_with_friction_continues_from_its_state() {
    let falling = "[friction]\nlaw = \"falling\"\nmu_slow = 1.1\nmu_fast = 0.6\nspeed_scale = 0.3\n\
                   memory_length = 1e-4\nspeed_floor = 1e-3\n[friction.creep]\nlongitudinal = 0.05\n\
                   [adhesion]\nstress = 2e4\nrange = 2e-5";
    let parts = gone_on_from_state(&scene(&finite(falling, "kind = \"made\"\nseed = 3")));
    assert!(parts.iter().all(|part| part.bonded > 0));
}

#[test]
fn the_past_by_poles_gives_the_forces_of_sums() {
    let friction = with_creep();
    for (road, bound) in [(SMOOTH, 1e-4), ("kind = \"made\"\nseed = 3", 1e-4)] {
        let direct = finite(&friction, road);
        let modal: Vec<&str> = direct.lines().filter(|line| !line.starts_with("memory = ")).collect();
        let modal = edit(&modal.join("\n"), &[("numerics.history", "\"modal\"")]);
        let modal = add(&modal, "numerics", "pole_tolerance = 1e-5");
        let found = [modal, direct].map(|text| totals(&scene(&text)));
        let errors = [0, 1, 2].map(|which| difference(&found[0], &found[1], which));
        println!("{road:?}: {errors:?}");
        assert!(errors.into_iter().all(|error| error < bound), "{road}: {errors:?}");
    }
}

#[test]
fn presets_take_friction() {
    let rolling = "speed_kmh = 80.0\nduration = 0.01\naxle = { indentation = 0.012 }";
    let more = "[contact]\nzone = \"cells\"\n[friction]\nmu = 0.9";
    let preset = "preset = \"draft\"\nfmax = 500.0";
    let text = scene_text(64, "kind = \"made\"\nseed = 3", rolling, preset, more);
    let others: Vec<&str> = text.lines().filter(|line| !line.starts_with("elements")).collect();
    let text = others.join("\n");
    let plan = Plan::of(&scene(&text)).unwrap();
    let choice = |key: &str| choices(&plan).iter().find(|choice| choice.key == key).map(|choice| choice.value.clone());
    assert_eq!(choice("numerics.time_rule").as_deref(), Some("bdf2"));
    assert_eq!(choice("numerics.history").as_deref(), Some("modal"));
}

/// Rolls for so many steps on a road with a coefficient and creep, under poles; returns the least slip power of a step,
/// and mean forces.
fn rolled(road: &str, mu: f64, [longitudinal, lateral]: [f64; 2], steps: usize) -> (f64, [f64; 3]) {
    let numerics = "time_rule = \"bdf2\"\nhistory = \"modal\"\npole_tolerance = 1e-4\ncontact_tolerance = 1e-5";
    let rolling = format!(
        "speed_kmh = 80.0\nwarm_up = 0.0\nduration = {:?}\naxle = {{ indentation = 0.012, ramp = 0.01 }}",
        (steps as f64 + 0.5) * 1.95 / 128.0 / SPEED
    );
    let more = format!(
        "[contact]\nzone = \"cells\"\ncells_across = 8\n[friction]\nmu = {mu}\n[friction.creep]\n\
         longitudinal = {longitudinal}\nlateral = {lateral}\nramp = 0.02"
    );
    let text = scene_text(128, road, &rolling, numerics, &more);
    let loaded = scene(&edit(&text, &[("numerics.lateral_terms", "24"), ("numerics.wavenumber_aliases", "1")]));
    let plan = Plan::of(&loaded).unwrap();
    let mut run = Simulation::begin(&loaded, &plan, &Default::default()).unwrap();
    let (mut least, mut sums, mut count) = (0.0_f64, [0.0; 3], 0.0);
    while let Some(step) = run.step().unwrap() {
        let part = march(&run).footprint().tangential().unwrap();
        least = least.min(part.slip_power);
        let forces = [step.total_force, part.total[0], part.total[1]];
        sums.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
        count += 1.0;
    }
    assert!(count >= steps as f64);
    (least, sums.map(|sum| sum / count))
}

/// Made roads: dense asphalt, chippings.
const ROADS: [&str; 2] = [
    "kind = \"made\"\nseed = 3",
    "kind = \"made\"\nseed = 3\npower_law = { rms = 0.0012, exponent = 2.0, longest = 0.1, shortest = 0.005 }",
];
/// Driving, braking, cornering at 2 degrees.
const CREEPS: [[f64; 2]; 3] = [[-0.02, 0.0], [0.05, 0.0], [0.02, 0.0349]];

fn every_step_settles(steps: usize) {
    for road in ROADS {
        for creep in CREEPS {
            let (least, mean) = rolled(road, 0.9, creep, steps);
            println!("{road}, {creep:?}: {steps} steps, least slip power {least:e} W, means {mean:?}");
            assert!(least >= 0.0 && mean[0] > 100.0, "{road} {creep:?}: {least:e} {mean:?}");
        }
    }
}

#[test]
fn steps_settle_on_rough_roads() {
    every_step_settles(400);
}

#[test]
#[ignore = "an hour: 600 000 steps"]
fn a_hundred_thousand_steps_settle_on_rough_roads() {
    every_step_settles(100_000);
}

#[test]
fn adhesion_pulls_cells_within_its_range() {
    let of = |adhesion: &str| totals(&scene(&finite(&format!("[friction]\nmu = 0.5\n{adhesion}"), SMOOTH)));
    let (without, with) = (of(""), of("[adhesion]\nstress = 1e5\nrange = 1e-4"));
    let (without, with) = (without[STEPS - 1][0], with[STEPS - 1][0]);
    // A pull on cells that stay pressed is borne by more pressure there; cells beside them are pulled without.
    assert!(with < without && with > 0.5 * without, "{with} {without}");
}

/// Rolls a locked wheel at 0.1 m/s on falling friction, one cell across: totals of each step.
fn locked_wheel(elements: usize, [time_step, seconds]: [f64; 2], history: &str) -> Vec<[f64; 5]> {
    let substeps = (1.95 / elements as f64 / 0.1 / time_step).round();
    let friction = "[friction]\nlaw = \"falling\"\nmu_slow = 1.0\nmu_fast = 0.3\nspeed_scale = 0.1\n\
                    memory_length = 1e-4\nspeed_floor = 1e-3\n[friction.creep]\nlongitudinal = 1.0\nramp = 0.01";
    let numerics = format!("substeps = {substeps}\ntime_rule = \"bdf2\"\n{history}\ncontact_tolerance = 1e-8");
    let rolling = format!(
        "speed_kmh = 0.36\nwarm_up = 0.0\nduration = {seconds:?}\naxle = {{ indentation = 0.014, ramp = 0.01 }}"
    );
    let more = format!("[contact]\nzone = \"cells\"\ncells_across = 1\n{friction}");
    let text = scene_text(elements, SMOOTH, &rolling, &numerics, &more);
    totals(&scene(&edit(&text, &[("numerics.lateral_terms", "1"), ("numerics.wavenumber_aliases", "0")])))
}

#[test]
fn a_locked_wheel_on_falling_friction_sticks_and_slips() {
    // The whole past: where sums over it are cut, the tyre is pushed each time that a change of force is forgotten.
    let found = locked_wheel(64, [2e-4, 0.2], "history = \"direct\"\nmemory = 0.201");
    assert!(found.iter().all(|total| total[4] >= 0.0));
    let late: Vec<f64> = found[found.len() / 2..].iter().map(|total| total[1]).collect();
    let mean = late.iter().sum::<f64>() / late.len() as f64;
    let swing = late.iter().fold(0.0_f64, |swing, force| swing.max((force - mean).abs())) / mean.abs();
    let is_passage = |pair: &&[f64]| pair[0] < mean && pair[1] >= mean;
    let passages = late.windows(2).filter(is_passage).count();
    // Steps in which nothing slips, and such in which something does.
    let sticking = found[found.len() / 2..].iter().filter(|total| total[4] <= 0.0).count();
    println!("{passages} cycles in 0.1 s, {swing:.2} of a mean of {mean:.0} N; all stick in {sticking} steps");
    assert!(mean < -500.0 && swing > 0.2 && (4..=20).contains(&passages), "{mean} {swing} {passages}");
    assert!(sticking > late.len() / 10 && sticking < 9 * late.len() / 10, "{sticking} of {}", late.len());
}

/// Returns the mean period of stick and slip of a locked wheel at 0.1 m/s with steps of so many seconds, and its
/// standard error \[s\].
fn period_of_stick_slip(time_step: f64) -> [f64; 2] {
    let found = locked_wheel(128, [time_step, 3.0], "history = \"modal\"\npole_tolerance = 1e-5");
    let late: Vec<f64> = found[found.len() / 2..].iter().map(|total| total[1]).collect();
    let mean = late.iter().sum::<f64>() / late.len() as f64;
    let passage = |(step, pair): (usize, &[f64])| {
        let [below, above] = [pair[0] - mean, pair[1] - mean];
        (below < 0.0 && above >= 0.0).then(|| step as f64 + below / (below - above))
    };
    let passages: Vec<f64> = late.windows(2).enumerate().filter_map(passage).collect();
    let periods: Vec<f64> = passages.windows(2).map(|pair| (pair[1] - pair[0]) * time_step).collect();
    let count = periods.len() as f64;
    let period = periods.iter().sum::<f64>() / count;
    let variance = periods.iter().map(|one| (one - period).powi(2)).sum::<f64>() / (count - 1.0);
    [period, (variance / count).sqrt()]
}

#[test]
#[ignore = "225 000 steps: a minute"]
fn the_period_of_stick_and_slip_converges_with_the_time_step() {
    let found = [200e-6, 100e-6, 50e-6, 25e-6].map(|time_step| {
        let [period, error] = period_of_stick_slip(time_step);
        println!("steps of {:.0} us: {:.2} ms, standard error {:.2} ms", 1e6 * time_step, 1e3 * period, 1e3 * error);
        period
    });
    let changes = [0, 1, 2].map(|at| found[at] - found[at + 1]);
    let order = (changes[0] / changes[2]).log2() / 2.0;
    println!("order {order:.2}, limit {:.2} ms", 1e3 * (found[3] - changes[2] / (order.exp2() - 1.0)));
    // Cycles are not alike: each period is a mean of some 150 of them.
    assert!((0.5..1.5).contains(&order), "{changes:?}");
    assert!(changes[2].abs() < 0.05 * found[3], "{found:?}");
}

#[test]
fn tables_of_friction_are_written_as_they_are_read() {
    let falling = "[friction]\nlaw = \"falling\"\nmu_slow = 1.0\nmu_fast = 0.3\nspeed_scale = 0.1\n\
                   memory_length = 1e-4\nspeed_floor = 1e-3\n[adhesion]\nstress = 1e5\nrange = 1e-5";
    for keys in [with_creep().as_str(), falling, "[friction]\nmu = 0.0"] {
        let loaded = scene(&finite(keys, SMOOTH));
        assert!(loaded.scene.friction.is_some());
        assert_eq!(scene(&loaded.scene.to_toml().unwrap()).scene, loaded.scene);
    }
}
