//! Influence of tractions compared with its double sum over signed waves.

use std::f64::consts::TAU;

use super::*;
use crate::scene::{DEFAULT, PLATE, Scene, Tyre};
use crate::tyre::influence::CellTruncation;

const ELEMENTS: usize = 16;

fn tyre(text: &str) -> Tyre {
    Scene::from_str(text, "scene").unwrap().scene.tyre
}

fn sums(tyre: &Tyre, across: usize, truncation: CellTruncation) -> CellSums {
    CellSums::new(tyre, CellGrid::new(tyre, ELEMENTS, across), truncation, 1e-8, 8e4)
}

/// Displacement of a cell by forces on another one, `distance` columns behind it: all signed n, term by term.
fn double_sum(sums: &CellSums, s: f64, distance: i64, [j, other]: [usize; 2]) -> [f64; PAIRS] {
    let (grid, waves) = (&sums.grid, sums.grid.waves());
    let at = sums.kernel.at(Complex64::new(s, 0.0));
    let aliases = sums.truncation.aliases.unwrap() as i64;
    let (half, elements) = (ELEMENTS as i64 / 2, ELEMENTS as i64);
    let mut sum = [0.0; PAIRS];
    for n in -half - aliases * elements..half + aliases * elements {
        for m in 0..=sums.truncation.lateral_terms.unwrap() {
            let weight = grid.longitudinal_weight(n) * waves.lateral_norm(m);
            let wave = Complex64::from_polar(weight, TAU * (n * distance) as f64 / ELEMENTS as f64);
            // -N/2 and its aliases stand for both signs.
            let compliance = in_shapes(&at.full(n, m), waves.sides);
            let mirrored = in_shapes(&at.full(-n, m), waves.sides);
            for (pair, sum) in sum.iter_mut().enumerate() {
                let is_mirror = (n + half).rem_euclid(elements) == 0;
                let value = if is_mirror { 0.5 * (compliance[pair] + mirrored[pair]) } else { compliance[pair] };
                let [a, b] = [pair / COMPONENTS, pair % COMPONENTS];
                let shapes = traction_shape(grid, a, m, j) * traction_shape(grid, b, m, other);
                *sum += (wave * value).re * shapes;
            }
        }
    }
    sum
}

#[test]
fn influence_of_tractions_is_the_double_sum_over_signed_waves() {
    let turning = Tyre { angular_velocity: -200.0, ..tyre(DEFAULT) };
    for (name, tyre) in [("plate", tyre(PLATE)), ("curved", tyre(DEFAULT)), ("turning", turning)] {
        for aliases in [0, 1] {
            let (across, columns, s) = (3, 5, 1.5 / 2e-4);
            let sums = sums(&tyre, across, CellTruncation { lateral_terms: Some(5), aliases: Some(aliases) });
            let influence = sums.traction_instant(s, columns);
            let scale = influence.block(7, 7)[2][2];
            let mut cross = 0.0_f64;
            for (a, b) in [(7, 7), (6, 8), (8, 6), (0, 14), (14, 0), (3, 10), (12, 4)] {
                let (distance, cells) = ((a / across) as i64 - (b / across) as i64, [a % across, b % across]);
                let exact = double_sum(&sums, s, distance, cells);
                let found = influence.block(a, b);
                for (pair, (found, exact)) in found.as_flattened().iter().zip(exact).enumerate() {
                    let error = (found - exact).abs() / scale;
                    assert!(error < 1e-9, "{name}, {aliases}: {a} by {b}, pair {pair}: {found:e} {exact:e}");
                    cross = if pair % 4 == 0 { cross } else { cross.max(exact.abs()) };
                }
            }
            assert!(cross > 1e-3 * scale, "{name}: nothing couples");
        }
    }
}

#[test]
fn influence_at_rest_is_reciprocal_and_that_of_cells() {
    for text in [PLATE, DEFAULT] {
        let mut tyre = tyre(text);
        tyre.angular_velocity = 0.0;
        let (across, columns, s) = (4, 6, 1.5 / 2e-4);
        for truncation in [CellTruncation::default(), CellTruncation { lateral_terms: Some(6), aliases: Some(0) }] {
            let sums = sums(&tyre, across, truncation);
            let (influence, normal) = (sums.traction_instant(s, columns), sums.instant(s, columns));
            let scale = influence.block(9, 9)[2][2];
            for (a, b) in [(0, 0), (1, 6), (9, 22), (23, 2), (10, 13)] {
                let (there, back) = (influence.block(a, b), influence.block(b, a));
                for i in 0..COMPONENTS {
                    for j in 0..COMPONENTS {
                        let error = (there[i][j] - back[j][i]).abs();
                        assert!(error < 1e-10 * scale, "{a} {b}, {i} {j}: {} {}", there[i][j], back[j][i]);
                    }
                }
                let along = usize::abs_diff(a / across, b / across);
                let free = normal.toeplitz[along * across + usize::abs_diff(a % across, b % across)];
                let image = normal.hankel[along * (2 * across - 1) + a % across + b % across];
                assert!((there[2][2] - free - image).abs() < 1e-9 * scale, "{} {}", there[2][2], free + image);
            }
        }
    }
}

#[test]
fn the_closed_sum_of_tractions_is_what_longer_ones_tend_to() {
    for text in [PLATE, DEFAULT] {
        let mut tyre = tyre(text);
        tyre.angular_velocity = 0.0;
        let (across, columns, s) = (3, 4, 3.4 / 2e-4);
        let closed = sums(&tyre, across, CellTruncation::default()).traction_instant(s, columns);
        let long = |aliases: usize| {
            let last = (2.0 * tyre.width / tyre.contact_width * across as f64 * aliases as f64).round() as usize;
            let truncation = CellTruncation { lateral_terms: Some(last), aliases: Some(aliases) };
            sums(&tyre, across, truncation).traction_instant(s, columns)
        };
        let difference = |other: &TractionInfluence| {
            let cells = influence_cells(&closed);
            let worst = cells.iter().map(|&(a, b)| {
                let (block, other) = (closed.block(a, b), other.block(a, b));
                let pairs = block.as_flattened().iter().zip(other.as_flattened());
                pairs.fold(0.0_f64, |worst, (entry, other)| worst.max((entry - other).abs()))
            });
            worst.fold(0.0, f64::max) / closed.block(4, 4)[2][2]
        };
        let [first, second] = [difference(&long(20)), difference(&long(60))];
        println!("20 aliases {first:.2e}, 60 aliases {second:.2e}");
        assert!(second < 0.4 * first && second < 5e-3, "{first:.2e} {second:.2e}");
    }
}

fn influence_cells(influence: &TractionInfluence) -> Vec<(usize, usize)> {
    (0..influence.cells()).flat_map(|a| [(a, 4), (a, 0)]).collect()
}

/// The mean lateral motion of a tyre with supported sides rests on the wave that is uniform across.
#[test]
fn without_the_uniform_wave_lateral_motion_is_lost() {
    let of = |terms: usize| sums(&tyre(PLATE), 4, CellTruncation { lateral_terms: Some(terms), aliases: Some(0) });
    let all = of(8).traction_instant(10.0, 3);
    let uniform = double_sum(&of(0), 10.0, 0, [1, 2]);
    let mean = |pair: usize| (0..4).map(|b| all.block(5, 4 + b).as_flattened()[pair]).sum::<f64>();
    assert!(4.0 * uniform[4] > 0.3 * mean(4), "{} of {}", 4.0 * uniform[4], mean(4));
    assert!(uniform[0].abs() + uniform[8].abs() <= 0.0);
}

/// Displacements of the cells across by forces in one wave of a band, with all its rows.
fn of_bin(sums: &CellSums, band: WaveBand, bin: usize, s: f64, shape: impl Fn(usize, usize, usize) -> f64) -> Vec<f64> {
    let (at, across) = (sums.at(Complex64::new(0.2 * s, s)), sums.grid.across);
    let mut sum = vec![0.0; across * COMPONENTS];
    for row in sums.traction_rows(band) {
        let Some(wave) = bin.checked_sub(row.first).and_then(|place| row.waves.get(place)) else { continue };
        let parts = sums.traction_parts(wave, &at);
        for (pair, value) in parts.even.iter().enumerate() {
            let [a, b] = [pair / COMPONENTS, pair % COMPONENTS];
            let driven = |j: usize| ((b + 1) as f64 * (j as f64 + 0.7)).sin() * shape(b, row.m, j);
            let driven: f64 = (0..across).map(driven).sum();
            (0..across).for_each(|j| sum[j * COMPONENTS + a] += value.re * driven * shape(a, row.m, j));
        }
    }
    sum
}

#[test]
fn lateral_numbers_alike_on_cells_are_summed_with_their_signs() {
    // Sides are a whole number of cells away.
    let tyre = Tyre { width: 0.20, contact_width: 0.12, sides: Sides::Supported, ..tyre(PLATE) };
    let sums = CellSums::new(&tyre, CellGrid::new(&tyre, 64, 6), CellTruncation::default(), 1e-8, 8e4);
    let grid = &sums.grid;
    let band = WaveBand { fades_in: Some([20.0, 30.0]), ..WaveBand::WHOLE };
    let folded = WaveBand { folded: true, ..band };
    for bin in [5, 20] {
        let apart = of_bin(&sums, band, bin, 5e3, |component, m, j| traction_shape(grid, component, m, j));
        let together = of_bin(&sums, folded, bin, 5e3, |component, m, j| folded_traction_shape(grid, component, m, j));
        let largest = apart.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        for (place, (apart, together)) in apart.iter().zip(&together).enumerate() {
            assert!((apart - together).abs() < 1e-9 * largest, "{bin}, {place}: {apart:e} {together:e}");
        }
    }
}
