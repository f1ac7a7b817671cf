//! Tests of L D L^T: whole matrices, bands, vectors of any width.

use super::*;
use crate::contact::complementarity::tiles::{add_to_diagonal, assemble_entries};

/// Entry of a positive definite matrix with springs on its diagonal.
fn entry(i: usize, j: usize) -> f64 {
    (-(i.abs_diff(j) as f64) / 3.0).exp() + if i == j { 0.1 * (1 + i % 5) as f64 } else { 0.0 }
}

#[test]
fn factors_make_the_matrix_and_solve() {
    for rows in [1_usize, 2, 4, 7, 8, 9, 31, 33, 64, 100] {
        let mut matrix = Aligned::new(packed_length(rows));
        let matrix = matrix.part(0, packed_length(rows));
        assemble_entries(rows, entry, matrix);
        let mut solver = Ldlt::new(rows);
        solver.factorise(matrix, rows).unwrap();
        let at = |i: usize, j: usize| matrix[LINE * (i / LINE * rows + j) + i % LINE];
        let l = |i: usize, j: usize| if i == j { 1.0 } else { at(i, j) };
        for i in 0..rows {
            for j in 0..=i {
                let product: f64 = (0..=j).map(|k| l(i, k) * at(k, k) * l(j, k)).sum();
                assert!((product - entry(i, j)).abs() < 1e-14, "{rows}: {i}, {j}");
            }
        }
        let stride = rows.next_multiple_of(LINE) + LINE;
        let mut right = vec![f64::NAN; 2 * stride];
        for i in 0..rows {
            right[i] = (0..rows).map(|j| entry(i, j) * (j + 1) as f64).sum();
            right[stride + i] = -2.0 * right[i];
        }
        solver.solve(matrix, &mut right, stride, rows).unwrap();
        for i in 0..rows {
            assert!((right[i] - (i + 1) as f64).abs() < 1e-11, "{rows}: {}", right[i]);
            assert!((right[stride + i] + 2.0 * (i + 1) as f64).abs() < 1e-11, "{rows}");
        }
    }
}

/// Vectors of one number, and of as many as every processor of this machine's kind has.
#[test]
fn processors_with_narrow_vectors_factorise_and_solve_alike() {
    for (rows, band) in [1_usize, 2, 4, 7, 8, 9, 31, 33, 64, 100].into_iter().flat_map(|rows| [(rows, rows), (rows, 1)])
    {
        let padded = rows.next_multiple_of(LINE);
        let solved = |narrow: Option<Narrow>| {
            let (mut matrix, mut right) = (vec![0.0; packed_length(rows)], vec![1.0; padded]);
            assemble_entries(rows, entry, &mut matrix);
            let (mut factors, mut sums) = (vec![0.0; (PANEL + 1) * padded], vec![0.0; LINE * rows]);
            let panels = ByPanels { matrix: &mut matrix, factors: &mut factors, rows, band };
            Narrow::carry_out(narrow, panels).unwrap();
            right[rows..].fill(0.0);
            let steps = Substitutions { factor: &matrix, sums: &mut sums, right: &mut right, rows, band };
            Narrow::carry_out(narrow, steps);
            right
        };
        let expected = solved(None);
        for narrow in [Narrow::One, Narrow::Four] {
            for (found, expected) in solved(Some(narrow)).iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-12, "{rows} rows, {narrow:?}: {found} {expected}");
            }
        }
    }
}

#[test]
fn a_band_is_solved_as_the_whole_matrix_with_zeros_beside_it() {
    for (rows, band) in [4_usize, 8, 9, 31, 33, 64, 100].into_iter().flat_map(|rows| (0..5).map(move |b| (rows, b))) {
        let within = |i: usize, j: usize| if i / LINE - j / LINE <= band { entry(i, j) } else { 0.0 };
        let influence: Vec<f64> = (0..rows).map(|distance| (-(distance as f64) / 3.0).exp()).collect();
        let springs: Vec<f64> = (0..rows).map(|i| 0.1 * (1 + i % 5) as f64).collect();
        let points: Vec<usize> = (0..rows).collect();
        let padded = rows.next_multiple_of(LINE);
        let (mut whole, mut part, mut solver) =
            (vec![0.0; packed_length(rows)], vec![f64::NAN; packed_length(rows)], Ldlt::new(rows));
        assemble_entries(rows, within, &mut whole);
        solver.assemble_band(&points, &influence, &mut part, band);
        add_to_diagonal(&mut part, &springs);
        solver.factorise(&mut whole, rows).unwrap();
        solver.factorise_band(&mut part, rows, band).unwrap();
        let (mut exact, mut found) = (vec![1.0; padded], vec![1.0; padded]);
        solver.solve(&whole, &mut exact, padded, rows).unwrap();
        solver.solve_band(&part, &mut found, padded, rows, band).unwrap();
        for (found, exact) in found.iter().zip(&exact) {
            assert!((found - exact).abs() < 1e-12, "{rows} rows, {band} blocks: {found} {exact}");
        }
    }
}

/// Numbers to a vector, fewer than this processor has.
#[derive(Clone, Copy, Debug)]
enum Narrow {
    One,
    Four,
}

impl Narrow {
    fn carry_out<W: WithSimd>(narrow: Option<Self>, work: W) -> W::Output {
        match narrow {
            Some(Self::One) => work.with_simd(pulp::Scalar::new()),
            #[cfg(target_arch = "x86_64")]
            Some(Self::Four) => match pulp::x86::V3::try_new() {
                Some(simd) => Simd::vectorize(simd, work),
                None => work.with_simd(pulp::Scalar::new()),
            },
            _ => Arch::new().dispatch(work),
        }
    }
}

#[test]
fn points_with_gaps_are_assembled_over_whatever_lay_there() {
    let influence: Vec<f64> = (0..80).map(|distance| entry(0, distance)).collect();
    let runs = [0..20, 21..25, 30..31, 33..58, 60..61, 62..63_usize];
    let points: Vec<usize> = runs.into_iter().flatten().collect();
    let rows = points.len();
    let springs: Vec<f64> = (0..rows).map(|row| 0.01 * row as f64).collect();
    let (mut made, mut expected) = (vec![f64::NAN; packed_length(rows)], vec![f64::NAN; packed_length(rows)]);
    let mut solver = Ldlt::new(rows);
    solver.assemble(&points, &influence, &mut made);
    add_to_diagonal(&mut made, &springs);
    let spring = |i: usize, j: usize| if i == j { springs[i] } else { 0.0 };
    assemble_entries(rows, |i, j| influence[points[i] - points[j]] + spring(i, j), &mut expected);
    solver.factorise(&mut made, rows).unwrap();
    solver.factorise(&mut expected, rows).unwrap();
    for i in 0..rows {
        for j in 0..=i {
            let at = LINE * (i / LINE * rows + j) + i % LINE;
            assert!((made[at] - expected[at]).abs() <= 0.0, "{i}, {j}");
        }
    }
}

#[test]
fn a_singular_matrix_is_named() {
    let mut matrix = vec![0.0; packed_length(2)];
    assemble_entries(2, |_, _| 1.0, &mut matrix);
    assert_eq!(Ldlt::new(2).factorise(&mut matrix, 2), Err(Singular));
}
