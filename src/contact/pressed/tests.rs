//! The pressed curves against closed forms, a dense solution, and themselves: borders of chunks, threads, units.

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::flat_tread::{FlatTread, line_influence};
use super::press::Press;
use super::strip::PressedRoad;
use super::yielding::Yielding;
use crate::contact::local_compliance::formula::tread_modulus;
use crate::contact::local_compliance::line_law::ElementLine;
use crate::contact::local_compliance::patch::PatchGrid;
use crate::half_space::rough::{Extent, HeightMap, IndentationControl, indent};
use crate::road::maker::StripCurves;
use crate::road::slices::StiffnessCurve;
use crate::road::{Lattice, Limits, RoadSurface};
use crate::scene::{MadeRoad, Road, Tyre};
use crate::test_models::plate_tyre;
use crate::tyre::wave_compliance;

const COARSE: Lattice = Lattice { dx: 1.95 / 128.0, along: 2, dy: 0.02, columns: 6 };

/// A tyre whose tread has this thickness \[m\] and Poisson's ratio.
fn tyre(thickness: f64, poisson: f64) -> Tyre {
    let mut tyre = plate_tyre();
    if let Some(tread) = tyre.layers.last_mut() {
        tread.thickness = thickness;
        tread.material.poisson = poisson;
    }
    tyre
}

fn random_heights(count: usize, highest: f64, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| highest * rng.random::<f64>()).collect()
}

/// A bonded layer at rest, k > 0: 2/(E* k) ((3 - 4 nu) sinh 2q - 2q)/((3 - 4 nu) cosh 2q + 2 q^2 + 5 - 12 nu + 8
/// nu^2), q = k h (K. L. Johnson, Contact Mechanics (1985), section 5.8).
#[test]
fn the_flat_tread_is_a_layer_bonded_to_a_rigid_base() {
    for poisson in [0.3, 0.49, 0.499] {
        let tyre = tyre(0.013, poisson);
        let flat = FlatTread::of(&tyre).unwrap();
        let effective = tread_modulus(&tyre).unwrap();
        let ring = flat.ring(1.0, 0.3, 0.1);
        for n in [1_u32, 5, 20, 80, 300] {
            let k = std::f64::consts::TAU * f64::from(n);
            let (q, kappa) = (0.013 * k, 3.0 - 4.0 * poisson);
            let below = kappa * (2.0 * q).cosh() + 2.0 * q * q + 5.0 - 12.0 * poisson + 8.0 * poisson * poisson;
            let expected = 2.0 / (effective * k) * (kappa * (2.0 * q).sinh() - 2.0 * q) / below;
            let found = wave_compliance(&ring, &[n], 0, &[0.0])[0][2][2];
            assert!((found.re / expected - 1.0).abs() < 1e-6 && found.im.abs() < 1e-12 * expected, "{n}: {found}");
        }
    }
}

#[test]
fn lines_displace_as_their_cells_do() {
    let flat = FlatTread::of(&tyre(0.013, 0.49)).unwrap();
    let cells = flat.influence(COARSE, 5);
    let line = line_influence(&cells, COARSE);
    let (along, across) = (COARSE.along, COARSE.columns);
    for (j, &found) in line.iter().enumerate() {
        let mut sum = 0.0;
        for (a, b) in (0..along * across).flat_map(|a| (0..along * across).map(move |b| (a, b))) {
            let rows = (j * along + a / across).abs_diff(b / across);
            sum += cells.toeplitz[rows * across + (a % across).abs_diff(b % across)];
        }
        let expected = sum / (COARSE.cells() * COARSE.cells()) as f64;
        assert!((found - expected).abs() < 1e-12 * line[0], "{j}: {found:e} {expected:e}");
    }
    assert!(line[0] > 0.0 && line.iter().skip(1).all(|value| value.abs() < line[0]));
}

/// Forces by projected Gauss-Seidel on the dense matrix, in double precision.
fn dense(toeplitz: &[f64], across: usize, required: &[f64]) -> Vec<f64> {
    let influence =
        |a: usize, b: usize| toeplitz[(a / across).abs_diff(b / across) * across + (a % across).abs_diff(b % across)];
    let mut forces = vec![0.0_f64; required.len()];
    for _ in 0..3000 {
        for a in 0..forces.len() {
            let others: f64 = (0..forces.len()).filter(|&b| b != a).map(|b| influence(a, b) * forces[b]).sum();
            forces[a] = ((required[a] - others) / influence(0, 0)).max(0.0);
        }
    }
    forces
}

#[test]
fn forces_and_yielding_are_those_of_the_dense_matrix() {
    let flat = FlatTread::of(&tyre(0.013, 0.49)).unwrap();
    let lattice = Lattice { dx: 0.004, along: 2, dy: 0.002, columns: 8 };
    let elements = 6;
    let heights = random_heights(elements * lattice.cells(), 1e-3, 2);
    let crown: Vec<f64> = (0..8).map(|column| lattice.y(column).powi(2) / 0.2).collect();
    let influence = flat.influence(lattice, elements);
    let line = line_influence(&influence, lattice);
    let mut press = Press::new(&flat, lattice, crown.clone(), elements);
    let found = press.press(&heights, 0..elements);
    let relief: Vec<f64> = heights.chunks(8).flat_map(|row| row.iter().zip(&crown).map(|(z, c)| z - c)).collect();
    let highest = relief.iter().copied().fold(f64::MIN, f64::max);
    for depth in [2e-4, 5e-4, 9e-4] {
        let required: Vec<f64> = relief.iter().map(|z| depth + z - highest).collect();
        let forces = dense(&influence.toeplitz, 8, &required);
        let largest = forces.iter().copied().fold(0.0, f64::max);
        let (exact, _) = press.at_depth(depth);
        assert!(exact.iter().zip(&forces).all(|(a, b)| (a - b).abs() < 2e-3 * largest), "{depth}");
        let sums: Vec<f64> = forces.chunks(lattice.cells()).map(|cells| cells.iter().sum()).collect();
        let mean = sums.iter().sum::<f64>() / sums.len() as f64;
        for (i, slice) in found.iter().enumerate() {
            let peak = relief[i * 16..][..16].iter().copied().fold(f64::MIN, f64::max);
            assert!((slice.peak - peak).abs() < 1e-15);
            let lines: f64 = sums.iter().enumerate().map(|(j, force)| line[i.abs_diff(j)] * force).sum();
            let rise = depth + peak - highest - lines;
            // Between the approaches the curve is a chord, and where p is not concave it lies above the points.
            if sums[i] > 0.3 * mean {
                let bound = slice.error + 0.05 * depth;
                assert!((slice.at(sums[i]) - rise).abs() < bound, "{i} at {depth}: {:e} {rise:e}", slice.at(sums[i]));
            }
        }
    }
}

/// A thick tread is a half-space, but for a constant approach, which does not matter at equal load.
#[test]
fn a_thick_tread_is_pressed_as_indent_says() {
    let lattice = Lattice { dx: 0.002, along: 2, dy: 0.001, columns: 12 };
    let (elements, rows, columns) = (6, 12, 12);
    let flat = FlatTread::of(&tyre(0.06, 0.49)).unwrap();
    let modulus = tread_modulus(&tyre(0.06, 0.49)).unwrap();
    let mut heights = random_heights(rows * columns, 2e-4, 3);
    for (place, height) in heights.iter_mut().enumerate() {
        let at = |number: usize| (number as f64 - 5.5) * 1e-3;
        *height -= (at(place / columns).powi(2) + at(place % columns).powi(2)) / 0.05;
    }
    let mut press = Press::new(&flat, lattice, vec![0.0; columns], elements);
    press.press(&heights, 0..elements);
    let (forces, load) = press.at_depth(8e-4);
    let map = HeightMap { heights, extent: Extent { nx: rows, ny: columns }, dx: 1e-3, dy: 1e-3 };
    let found =
        indent(&map, modulus, IndentationControl::Load(load), crate::half_space::rough::IndentationLimits::default())
            .unwrap();
    let slices = |cells: &[f64]| cells.chunks(2 * columns).map(|cells| cells.iter().sum::<f64>()).collect::<Vec<_>>();
    let expected = slices(&found.pressure.iter().map(|p| p * 1e-6).collect::<Vec<_>>());
    let by_slice = slices(forces);
    for (force, expected) in by_slice.iter().zip(&expected) {
        assert!((force - expected).abs() < 0.02 * load, "{force} {expected} of {load}");
    }
}

#[test]
fn a_level_road_is_flat_and_a_spike_is_held_by_its_cell() {
    let flat = FlatTread::of(&tyre(0.013, 0.49)).unwrap();
    let elements = 9;
    let mut press = Press::new(&flat, COARSE, vec![0.0; 6], elements);
    let mut heights = vec![0.01; elements * COARSE.cells()];
    for slice in press.press(&heights, 2..7) {
        let curve = slice.curve(flat.spring(COARSE));
        // The higher pressure at the edges of a level strip is no texture.
        assert!(slice.yields.iter().all(|&rise| rise < 1e-6), "{slice:?}");
        assert!((curve.final_slope - 1.0).abs() < 1e-9, "{curve:?}");
    }
    heights[4 * COARSE.cells() + 3] = 0.012;
    let found = press.press(&heights, 2..7);
    assert!(found[2].yields.iter().any(|&rise| rise > 5e-4), "{:?}", found[2]);
    assert!((found[2].peak - 0.012).abs() < 1e-15 && (found[0].peak - 0.01).abs() < 1e-15);
}

#[test]
fn a_slice_between_stones_is_held_off() {
    let flat = FlatTread::of(&tyre(0.013, 0.49)).unwrap();
    let lattice = Lattice { dx: 0.002, along: 1, dy: 0.02, columns: 6 };
    let mut heights = vec![0.0; 9 * lattice.cells()];
    heights[4 * lattice.cells()..5 * lattice.cells()].fill(-0.05);
    let found = Press::new(&flat, lattice, vec![0.0; 6], 9).press(&heights, 4..5);
    let spring = flat.spring(lattice);
    assert!((found[0].peak + 0.05).abs() < 1e-15 && found[0].forces.len() == 2, "{found:?}");
    let curve = found[0].curve(spring);
    assert!((curve.final_slope - 0.5).abs() < 1e-12, "{curve:?}");
}

fn surface(lattice: Lattice) -> RoadSurface {
    RoadSurface::open(&Road::Made(MadeRoad { seed: 4, ..MadeRoad::default() }), lattice, Limits::default()).unwrap()
}

fn curves(cached: bool, chunks: &[(i64, i64)]) -> Vec<StiffnessCurve> {
    let crown = (0..6).map(|column| COARSE.y(column).powi(2) / 4.0).collect();
    let road = PressedRoad::new(&tyre(0.013, 0.49), COARSE, crown).unwrap();
    let mut road = if cached { road } else { road.uncached() };
    let mut surface = surface(COARSE);
    chunks.iter().flat_map(|chunk| road.curves(&mut surface, chunk.0..chunk.1).unwrap()).collect()
}

#[test]
fn neither_chunks_nor_threads_nor_the_cache_change_a_bit() {
    let whole = curves(false, &[(-60, 160)]);
    assert_eq!(whole, curves(false, &[(-60, -59), (-59, 40), (40, 160)]));
    assert_eq!(whole[..100], curves(false, &[(100, 160), (-60, 40)])[60..]);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(whole, pool.install(|| curves(false, &[(-60, 160)])));
    }
    assert_eq!(whole, curves(true, &[(-60, 160)]));
    assert_eq!(whole, curves(true, &[(-60, 160)]), "read from the cache");
}

#[test]
fn a_road_that_ends_has_curves_to_its_ends() {
    let file = crate::test_models::reference(crate::test_models::CHIP_SEAL);
    let text = format!("kind = \"profile\"\nfile = '{}'\nlateral = \"extruded\"\nat_end = \"refuse\"", file.display());
    let loaded = crate::test_models::scene(&crate::test_models::with_road(crate::scene::PLATE, &text));
    let mut surface = RoadSurface::open(&loaded.scene.road, COARSE, Limits::default()).unwrap();
    let (first, last) = surface.elements().unwrap();
    let mut road = PressedRoad::new(&tyre(0.013, 0.49), COARSE, vec![0.0; 6]).unwrap().uncached();
    let found = road.curves(&mut surface, first..last + 1).unwrap();
    assert_eq!(found.len() as i64, last + 1 - first);
    assert!(found.iter().all(|curve| curve.peak.is_finite() && curve.final_slope > 0.0));
}

/// Elements with curves in two units have the same pressures.
#[test]
fn no_result_depends_on_the_unit_of_a_curve() {
    let grid = PatchGrid::new(1.95 / 256.0);
    let area = grid.dx * grid.along as f64 * grid.dy * grid.columns as f64;
    let heights = random_heights(4 * grid.elements, 1e-3, 7);
    let slices: Vec<Yielding> = heights
        .chunks(4)
        .map(|h| {
            let points =
                [[2e-3 * area, 0.3 * h[1]], [1e-2 * area, 0.5 * h[1] + 0.2 * h[2]], [5e-2 * area, h[3] + 5e-4]];
            Yielding::above(h[0], &points, 4e-3 / area)
        })
        .collect();
    // E* = 1 here: c = kappa E* is the curves' c times the area.
    let pressures = |c: f64| {
        let curves = slices.iter().map(|slice| slice.curve(c / area)).collect();
        ElementLine::new(grid, curves).pressures(c, 1e-2).unwrap()
    };
    let [one, other] = [2e-3, 2e-2].map(pressures);
    for (one, other) in one.iter().zip(&other) {
        assert!((one - other).abs() < 1e-5 * 1e-2, "{one} {other}");
    }
}

proptest! {
    #[test]
    fn curves_are_convex_and_yield_by_the_least_concave_majorant(
        points in prop::collection::vec((1e-3..1e3_f64, -1e-4..3e-3_f64), 0..25),
        c in 1e-8..1e-4_f64,
    ) {
        let points: Vec<[f64; 2]> = points.into_iter().map(|(force, rise)| [force, rise]).collect();
        let slice = Yielding::above(0.001, &points, 1e-6);
        prop_assert!(slice.forces.windows(2).all(|pair| pair[0] < pair[1]));
        for &[force, rise] in &points {
            let force = force.max(rise / (1e3 * 1e-6));
            prop_assert!(slice.at(force) >= rise - 1e-9, "{} below {rise}", slice.at(force));
            prop_assert!(slice.at(force) - rise <= slice.error + 1e-12);
        }
        let curve = slice.curve(c);
        let (mut last, mut y0, mut s0) = (0.0, 0.0, 0.0);
        for (&y, &s) in curve.penetration.iter().zip(&curve.displacement) {
            let slope = (s - s0) / (y - y0);
            prop_assert!(slope >= last * (1.0 - 1e-6) && slope <= 1.0 + 1e-9, "{slope} after {last}");
            (last, y0, s0) = (slope, y, s);
        }
        prop_assert!(curve.final_slope >= last * (1.0 - 1e-6) && curve.final_slope <= 1.0 + 1e-12);
        for force in [1e-2, 1.0, 30.0, 2e3] {
            let rise = curve.penetration_at(c * force) - c * force;
            prop_assert!((rise - slice.at(force)).abs() <= 1e-9 * (slice.at(force).abs() + c * force) + 1e-15);
        }
    }
}
