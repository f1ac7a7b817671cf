//! Balance of work under friction: the waves of the tyre and slip dissipate what axle and road put in.

use std::f64::consts::TAU;

use num_complex::Complex64;
use tyrewave::Plan;
use tyrewave::internals::{add, edit, march, scene};
use tyrewave::run::Simulation;

use super::friction::{SMOOTH, finite};
use tyrewave::internals::{COMPONENTS, CellGrid, CellSums, CellTruncation, TimeRule, WaveBand, traction_shape};

const ELEMENTS: usize = 64;
const ACROSS: usize = 3;
const LATERAL_TERMS: usize = 5;
const SPEED: f64 = 80.0 / 3.6;
/// Longitudinal and lateral creep, spin \[1/m\].
const CREEP: [f64; 3] = [0.04, 0.03, 0.6];
/// Revolutions before the one that is considered: steps are all alike then.
const REVOLUTIONS: usize = 20;

/// Mean powers of a revolution \[W\].
struct Powers {
    /// Put in by normal forces, by axle and road through tangential ones.
    put_in: f64,
    slip: f64,
    /// Put into the tyre by the forces of all steps.
    into_tyre: f64,
    /// Dissipated by its waves.
    waves: f64,
}

/// Finds what the waves of a tyre dissipate under forces of one revolution that repeats for ever, by step, element,
/// cell and component: the sum of Re conj(F) s C(s) F over waves and frequencies.
fn dissipated(tyre: &tyrewave::scene::Tyre, time_step: f64, forces: &[Vec<[f64; COMPONENTS]>]) -> f64 {
    let grid = CellGrid::new(tyre, ELEMENTS, ACROSS);
    let truncation = CellTruncation { lateral_terms: Some(LATERAL_TERMS), aliases: Some(0) };
    let sums = CellSums::new(tyre, grid.clone(), truncation, 1e-12, 10.0 / time_step);
    let (steps, rows) = (forces.len(), sums.traction_rows(WaveBand::WHOLE));
    let turns: Vec<Complex64> = (0..steps).map(|n| Complex64::cis(-TAU * n as f64 / steps as f64)).collect();
    let per_element = steps / ELEMENTS;
    let mut power = 0.0;
    for bin in 1..=steps / 2 {
        let s = TimeRule::Bdf2.symbol(turns[bin]) / time_step;
        let at = sums.at(s);
        // The frequency and its negative.
        let both = if 2 * bin == steps { 1.0 } else { 2.0 };
        for n in -(ELEMENTS as i64 / 2 - 1)..=ELEMENTS as i64 / 2 {
            let mut waves = [[Complex64::ZERO; COMPONENTS]; ACROSS];
            for (step, forces) in forces.iter().enumerate() {
                for (place, force) in forces.iter().enumerate().filter(|(_, force)| force[2] > 0.0) {
                    let turn = (place / ACROSS * per_element) as i64 * n;
                    let phase = (bin * step) as i64 + turn;
                    let turn = turns[phase.rem_euclid(steps as i64) as usize] / steps as f64;
                    waves[place % ACROSS].iter_mut().zip(force).for_each(|(wave, force)| *wave += turn * force);
                }
            }
            for row in &rows {
                let Some(wave) = (n.unsigned_abs() as usize).checked_sub(row.first).and_then(|n| row.waves.get(n))
                else {
                    continue;
                };
                let force: [Complex64; COMPONENTS] = std::array::from_fn(|c| {
                    (0..ACROSS).map(|j| traction_shape(&grid, c, row.m, j) * waves[j][c]).sum()
                });
                let parts = sums.traction_parts(wave, &at);
                let odd = if wave.is_mirror { Complex64::ZERO } else { Complex64::new(0.0, n.signum() as f64) };
                for (pair, (even, of_odd)) in parts.even.iter().zip(&parts.odd).enumerate() {
                    let moved = (even + odd * of_odd) * force[pair % COMPONENTS];
                    power += both * (force[pair / COMPONENTS].conj() * s * moved).re;
                }
            }
        }
    }
    power
}

/// Rolls on a smooth road with so many steps to an element.
fn powers(substeps: usize) -> Powers {
    let steps = ELEMENTS * substeps;
    let time_step = 1.95 / steps as f64 / SPEED;
    let [longitudinal, lateral, spin] = CREEP;
    let friction = format!(
        "[friction]\nmu = 0.9\n[friction.creep]\nlongitudinal = {longitudinal}\nlateral = {lateral}\nspin = {spin}"
    );
    let duration = |steps: usize| format!("{:?}", steps as f64 * time_step);
    let text = edit(&finite(&friction, SMOOTH), &[("rolling.warm_up", &duration(REVOLUTIONS * steps))]);
    let text = edit(&text, &[("rolling.duration", &duration(steps)), ("numerics.history", "\"modal\"")]);
    let text: Vec<&str> = text.lines().filter(|line| !line.starts_with("memory = ")).collect();
    let text = add(&text.join("\n"), "numerics", "pole_tolerance = 1e-6");
    let loaded = scene(&add(&text, "numerics", &format!("substeps = {substeps}")));
    let plan = Plan::of(&loaded).unwrap();
    let mut run = Simulation::begin(&loaded, &plan, &Default::default()).unwrap();
    let (mut forces, mut slip, mut by_tangential, mut by_creep) = (Vec::new(), 0.0, 0.0, 0.0);
    while let Some(step) = run.step().unwrap() {
        if march(&run).next_step() - 1 < plan.warm_up_steps {
            continue;
        }
        let footprint = march(&run).footprint();
        let part = footprint.tangential().unwrap();
        slip += part.slip_power;
        by_tangential += part.power;
        // The road passes at the creep's velocity.
        let along = longitudinal * part.total[0] + lateral * part.total[1] + spin * part.aligning_moment;
        by_creep -= SPEED * along;
        let mut all = vec![[0.0; COMPONENTS]; ELEMENTS * ACROSS];
        for (point, (&normal, tangential)) in footprint.forces().iter().zip(&part.forces).enumerate() {
            let element = (step.first_element + (point / ACROSS) as i64).rem_euclid(ELEMENTS as i64) as usize;
            let out = &mut all[element * ACROSS + point % ACROSS];
            out.iter_mut().zip([tangential[0], tangential[1], normal]).for_each(|(out, force)| *out += force);
        }
        forces.push(all);
    }
    assert_eq!(forces.len(), steps);
    let into_tyre = run.finish().rolling_resistance.unwrap().power;
    let mean = |sum: f64| sum / steps as f64;
    let waves = dissipated(&loaded.scene.tyre, time_step, &forces);
    Powers { put_in: into_tyre - mean(by_tangential) + mean(by_creep), slip: mean(slip), into_tyre, waves }
}

#[test]
fn what_axle_and_road_put_in_is_dissipated_by_waves_and_slip() {
    for substeps in [1, 2] {
        let Powers { put_in, slip, into_tyre, waves } = powers(substeps);
        println!(
            "{substeps} steps to an element: put in {put_in:.4} W, slip {slip:.4} W, waves {waves:.4} W, balance \
             {:.1e}, tyre {:.1e}",
            (waves + slip) / put_in - 1.0,
            waves / into_tyre - 1.0
        );
        assert!(slip > 0.1 * put_in && waves > 0.1 * put_in, "{slip} {waves} {put_in}");
        assert!((waves / into_tyre - 1.0).abs() < 1e-3, "{waves} {into_tyre}");
        assert!(((waves + slip) / put_in - 1.0).abs() < 1e-3, "{waves} {slip} {put_in}");
    }
}
