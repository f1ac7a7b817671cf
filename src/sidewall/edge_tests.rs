use super::*;
use crate::numeric::SplitRule;
use crate::sidewall::{Meridian, Pieces, Relaxation, Sidewall};

/// The sidewall of the reference values, without losses.
fn arc() -> Arc {
    Arc {
        radius: 0.055,
        angle: 1.0,
        pressure: 2.2e5,
        mass: 7.0,
        shear: 8e3,
        hoop: 3.2e4,
        edge_radius: 0.297,
        angular_velocity: 0.0,
        relaxation: Relaxation::default(),
    }
}

fn wave(arc: &Arc, n: f64, s: Complex64) -> Wave<Complex64> {
    Wave { n: n.into(), s, loss: arc.relaxation.at(s) }
}

/// States at the edge, and the integral of u R along the arc as a seventh one, for unit forces at the bead: columns.
fn states(arc: &Arc, points: &[[MeridianPoint; 3]], wave: &Wave<Complex64>) -> [[Complex64; 7]; 3] {
    states_and(arc, points, wave, |point| point.radius)
}

/// As [`states`], with the integral of u times any function.
fn states_and(
    arc: &Arc,
    points: &[[MeridianPoint; 3]],
    wave: &Wave<Complex64>,
    flow: impl Fn(&MeridianPoint) -> f64,
) -> [[Complex64; 7]; 3] {
    let units = Units { states: [1.0; 6], ratios: [[1.0; 6]; 6] };
    let equations = Equations::new(arc, wave);
    let step = arc.length() / points.len() as f64;
    let slope = |point: &MeridianPoint, state: &[Complex64; 7]| -> [Complex64; 7] {
        let system = equations.system(point, &units);
        std::array::from_fn(|row| match system.get(row) {
            Some(row) => row.iter().zip(state).map(|(entry, value)| entry * value).sum(),
            None => state[1] * flow(point),
        })
    };
    let moved = |state: &[Complex64; 7], by: f64, slope: &[Complex64; 7]| -> [Complex64; 7] {
        std::array::from_fn(|row| state[row] + slope[row] * by)
    };
    // Gauss's method of sixth order, its stages by fixed-point iteration.
    let root = 15.0_f64.sqrt();
    let inner = [
        [5.0 / 36.0, 2.0 / 9.0 - root / 15.0, 5.0 / 36.0 - root / 30.0],
        [5.0 / 36.0 + root / 24.0, 2.0 / 9.0, 5.0 / 36.0 - root / 24.0],
        [5.0 / 36.0 + root / 30.0, 2.0 / 9.0 + root / 15.0, 5.0 / 36.0],
    ];
    let weights = [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0];
    std::array::from_fn(|force| {
        let mut state = [Complex64::ZERO; 7];
        state[3 + force] = Complex64::ONE;
        for nodes in points {
            let mut stages = nodes.each_ref().map(|node| slope(node, &state));
            for _ in 0..60 {
                let at: [[Complex64; 7]; 3] = std::array::from_fn(|stage| {
                    let parts = stages.iter().zip(inner[stage]);
                    parts.fold(state, |state, (slope, weight)| moved(&state, step * weight, slope))
                });
                stages = std::array::from_fn(|stage| slope(&nodes[stage], &at[stage]));
            }
            state =
                stages.iter().zip(weights).fold(state, |state, (slope, weight)| moved(&state, step * weight, slope));
        }
        state
    })
}

/// Forces at the bead that move the edge by (t, u, V).
fn forces(states: &[[Complex64; 7]; 3], motion: [Complex64; 3]) -> [Complex64; 3] {
    let matrix: Matrix<Complex64, 3> = std::array::from_fn(|row| std::array::from_fn(|column| states[column][row]));
    let inverse = inverse(&matrix);
    std::array::from_fn(|row| (0..3).map(|column| inverse[row][column] * motion[column]).sum())
}

#[test]
fn the_edge_sweeps_one_volume_for_every_n_and_s() {
    let mut worst = 0.0_f64;
    for hoop in [0.0, 3.2e4] {
        let arc = Arc { hoop, relaxation: Relaxation::of_loss_factor(0.15), ..arc() };
        let meridian = Meridian::new(&arc).unwrap();
        let (edge, points) = (meridian.edge(), meridian.points(1000));
        let (sine, cosine) = edge.angle.sin_cos();
        for n in [0.0, 1.0, 3.0, 10.0, 25.0] {
            for s in [Complex64::ZERO, Complex64::new(0.0, 900.0), Complex64::new(700.0, 2500.0), 1500.0.into()] {
                let states = states(&arc, &points, &wave(&arc, n, s));
                let swept = |motion: [f64; 3]| -> Complex64 {
                    let forces = forces(&states, motion.map(Complex64::from));
                    (0..3).map(|force| states[force][6] * forces[force]).sum::<Complex64>() / arc.edge_radius
                };
                let expected = -edge.pull() / arc.pressure;
                let outward = (swept([cosine, sine, 0.0]) - expected).norm() / expected.abs();
                let turning = swept([0.0, 0.0, 1.0]).norm() / expected.abs();
                worst = worst.max(outward).max(turning);
                assert!(outward < 1e-7 && turning < 1e-7, "E {hoop}, n {n}, s {s}: {outward:.1e}, {turning:.1e}");
            }
        }
    }
    println!("swept volume: {worst:.1e}");
}

#[test]
fn a_uniform_pressure_on_a_held_arc_moves_nothing() {
    // The same by reciprocity, exactly: forces in equilibrium with a pressure are Tt = C/p alone, since ka = p R/C.
    let arc = arc();
    let meridian = Meridian::new(&arc).unwrap();
    let units = Units { states: [1.0; 6], ratios: [[1.0; 6]; 6] };
    for (n, s) in [(0.0, Complex64::new(0.0, 1e5)), (400.0, Complex64::new(1e3, 1e4)), (30.0, Complex64::ZERO)] {
        let equations = Equations::new(&arc, &wave(&arc, n, s));
        for point in meridian.points(16).iter().flatten() {
            let constant = point.radius * point.tension;
            let column = equations.system(point, &units).map(|row| row[3] * (constant / arc.pressure));
            let rest = column.iter().enumerate().map(|(row, entry)| match row {
                4 => (entry - point.radius).norm(),
                _ => entry.norm(),
            });
            assert!(rest.fold(0.0, f64::max) < 1e-14, "n {n}, s {s}");
        }
    }
}

#[test]
fn both_halves_of_the_impedance_are_equal() {
    for speed in [0.0, 98.0, -224.0] {
        let arc = Arc { angular_velocity: speed, ..arc() };
        let meridian = Meridian::new(&arc).unwrap();
        let points = meridian.points(64);
        for (n, s) in [(0.0, Complex64::new(0.0, 600.0)), (3.0, Complex64::new(50.0, 2e3)), (30.0, 800.0.into())] {
            let units = Units::new(&arc, wavenumber(&arc, n, s));
            let step = arc.length() / points.len() as f64;
            let equations = Equations::new(&arc, &wave(&arc, n, s));
            let squarings = squarings(&arc, &points, &wave(&arc, n, s), &units, step);
            let mut compliance = [[Complex64::ZERO; 3]; 3];
            for nodes in &points {
                let [first, middle, last] = nodes.each_ref().map(|point| equations.system(point, &units));
                (compliance, _) =
                    handed_on(&exponential(&expansion(&first, &middle, &last, step), squarings), &compliance);
            }
            let impedance = inverse(&compliance);
            let (sine, cosine) = meridian.edge().angle.sin_cos();
            let scale = |row: usize, column: usize| units.states[3 + row] / units.states[column];
            let entry = |row: usize, column: usize| impedance[row][column] * scale(row, column);
            let upper = entry(0, 2) * cosine + entry(1, 2) * sine;
            let lower = entry(2, 0) * cosine + entry(2, 1) * sine;
            let size = (0..3).map(|k| entry(k, k).norm()).fold(0.0, f64::max);
            assert!((upper - lower).norm() < 1e-7 * size, "{speed}, n {n}: {upper} {lower} of {size:e}");
        }
    }
}

#[test]
fn an_edge_that_moves_across_meets_the_forces_of_the_arc() {
    let mut worst = 0.0_f64;
    for angular_velocity in [0.0, 98.0, -98.0] {
        let arc = Arc { angular_velocity, relaxation: Relaxation::of_loss_factor(0.18), ..arc() };
        let sidewall = Sidewall::new(arc.clone());
        let meridian = Meridian::new(&arc).unwrap();
        let (edge, points) = (meridian.edge(), meridian.points(1000));
        let (sine, cosine) = edge.angle.sin_cos();
        for (n, s) in [(0, Complex64::ZERO), (-2, Complex64::new(0.0, 600.0)), (5, Complex64::new(300.0, 1500.0))] {
            let states = states(&arc, &points, &wave(&arc, n as f64, s));
            // Motions w, q, V and forces along them.
            let directions = [[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]];
            let by = |motion: [f64; 3]| -> [Complex64; 3] {
                let forces = forces(&states, motion.map(Complex64::from));
                let at_edge: [Complex64; 3] =
                    std::array::from_fn(|k| (0..3).map(|bead| states[bead][3 + k] * forces[bead]).sum());
                directions.map(|along| {
                    along.iter().zip(at_edge).map(|(&share, force)| force * share).sum::<Complex64>() / arc.edge_radius
                })
            };
            let [[ww, qw, vw], [wq, qq, vq], [wv, qv, vv]] = directions.map(by);
            let found = sidewall.free_edge(n, s);
            let EdgeImpedance { radial, coupling, circumferential, lateral } = found.guided;
            let size = ww.norm().max(qq.norm()).max(vv.norm());
            for (found, wanted) in [
                (radial, ww),
                (lateral, qq),
                (circumferential, vv),
                (coupling, wv),
                (coupling, vw),
                (found.lateral_circumferential, qv),
                (found.lateral_circumferential, vq),
                (found.radial_lateral, 0.5 * (wq + qw)),
                // The pressure's own, with the losses of the arc.
                (wq - qw, arc.pressure * arc.relaxation.at(s)),
            ] {
                let error = (found - wanted).norm() / size;
                worst = worst.max(error);
                assert!(error < 1e-5, "Omega {angular_velocity}, n {n}, s {s}: {found} for {wanted}, {error:.1e}");
            }
            assert_eq!(found.guided, sidewall.impedance(n, s), "guided edges keep their bits");
        }
    }
    println!("edge that moves across: {worst:.1e}");
}

#[test]
fn a_sidewall_at_rest_is_a_string_and_a_strip_in_shear() {
    // (1/int dz/(R^2 (C + R G)) + C R_b cos a_b)/R_b^3.
    let arc = arc();
    let meridian = Meridian::new(&arc).unwrap();
    let (edge, points) = (meridian.edge(), meridian.points(400));
    let constant = arc.edge_radius * edge.tension;
    let weights = [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0];
    let flexibility = |point: &MeridianPoint| 1.0 / (point.radius.powi(2) * (constant + point.radius * arc.shear));
    let sum: f64 = points.iter().flat_map(|nodes| nodes.iter().zip(weights)).map(|(p, w)| w * flexibility(p)).sum();
    let turned = 1.0 / (sum * arc.length() / points.len() as f64);
    let expected = (turned + constant * arc.edge_radius * edge.angle.cos()) / arc.edge_radius.powi(3);
    let at_rest = wave(&arc, 0.0, Complex64::ZERO);
    let found = edge_impedance(&arc, &edge, &points, &at_rest, &at_rest);
    let off = (found.circumferential.re / expected - 1.0).abs();
    assert!(off < 1e-9 && found.coupling.norm() < 1e-6, "{off:.1e}");
}

#[test]
fn pieces_of_the_swept_volume_are_its_integrals_by_another_way() {
    // A split within a step, and Gauss's method with steps that the jump there hardly touches.
    let rule = SplitRule::new(0.26);
    let mut worst = 0.0_f64;
    for angular_velocity in [0.0, 98.0] {
        let arc = Arc { angular_velocity, relaxation: Relaxation::of_loss_factor(0.18), ..arc() };
        let sidewall = Sidewall::new(arc.clone());
        let meridian = Meridian::new(&arc).unwrap();
        let (edge, points) = (meridian.edge(), meridian.points(3000));
        let (sine, cosine) = edge.angle.sin_cos();
        for (n, s) in [(0, 0.0), (0, 1500.0), (3, 3000.0), (12, 6000.0)].map(|(n, s)| (n, Complex64::new(0.0, s))) {
            let found = sidewall.flow(n, s, &rule, 64);
            let largest = found.iter().flatten().fold(0.0_f64, |largest, flow| largest.max(flow.norm()));
            for (k, found) in found.iter().enumerate() {
                let flow = |point: &MeridianPoint| {
                    let turned = (edge.angle - point.sine.atan2(point.cosine)) / (edge.angle - edge.bead_angle);
                    point.radius * rule.polynomials(turned)[k]
                };
                let states = states_and(&arc, &points, &wave(&arc, n as f64, s), flow);
                for (motion, found) in [[cosine, sine, 0.0], [0.0, 0.0, 1.0]].into_iter().zip(found) {
                    let forces = forces(&states, motion.map(Complex64::from));
                    let wanted: Complex64 = (0..3).map(|force| states[force][6] * forces[force]).sum();
                    worst = worst.max((found - wanted).norm() / largest);
                }
            }
        }
    }
    println!("pieces of the swept volume: {worst:.1e} of the largest");
    assert!(worst < 1e-3, "{worst:.1e}");
}

#[test]
fn pieces_sweep_what_the_whole_does_with_any_steps() {
    let rule = SplitRule::new(0.26);
    let arc = Arc { relaxation: Relaxation::of_loss_factor(0.18), ..arc() };
    let edge = Meridian::new(&arc).unwrap().edge();
    let sidewall = std::sync::Arc::new(Sidewall::new(arc.clone()));
    let pieces = Pieces::new(rule.clone());
    let expected = -arc.edge_radius * edge.pull() / arc.pressure;
    for (s, rough) in [(0.0, 8), (900.0, 16), (12e3, 96)].map(|(s, steps)| (Complex64::new(0.0, s), steps)) {
        let at = sidewall.at(s, 40);
        let produced = at.flows(24, &pieces)[3].backwards;
        let fine = sidewall.flow(27, s, &rule, 512);
        let largest = fine.iter().flatten().fold(0.0_f64, |largest, flow| largest.max(flow.norm()));
        for flows in [sidewall.flow(0, s, &rule, rough), sidewall.flow(27, s, &rule, rough), produced] {
            let [outward, turning] = [0, 1].map(|way| flows.iter().map(|flow| flow[way]).sum::<Complex64>());
            assert!((outward - expected).norm() < 1e-6 * largest, "s {s}: {outward} {expected}");
            assert!(turning.norm() < 1e-6 * largest, "s {s}: {turning}");
        }
        let differences = produced.iter().flatten().zip(fine.iter().flatten()).map(|(a, b)| (a - b).norm());
        let error = differences.fold(0.0, f64::max) / largest;
        println!("s {s}: steps of production {error:.1e} of the largest piece");
        // At the highest of sound, 2 kHz: 0.01 dB.
        assert!(error < 1e-3, "s {s}: {error:.1e}");
        assert_eq!(at.both_ways(27), sidewall.at(s, 40).both_ways(27), "K is the same bits with flows and without");
    }
}
