//! Pressures of forces on cells against sums over the tread written out, and against those of the mirrored tyre.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::{Complex32, Complex64};

use super::model::PressureModel;
use super::surface::SurfaceGreen;
use super::tests::{AROUND, across, green as even_green, moving_wave};
use super::transfer::PressureTransfers;
use crate::numeric::double;
use crate::radiation::draft;
use crate::radiation::{MeshResolution, ParityBlock, RadiatingBody, TransferGrid, TransferProblem};
use crate::response::LateralForces;
use crate::response::vibration::{Across, SegmentLayout, TransferKind};
use crate::scene::{AirMotion, Sides, TimeRule, Tyre};
use crate::test_models::{CIRCUMFERENCE, plate_tyre};
use crate::tyre::influence::{CellGrid, SurfaceWaves, TractionWaves, traction_shape};

const ELEMENTS: usize = 32;
const COLUMNS: usize = 5;
const ACROSS: usize = 4;
/// Number of lateral waves in the model.
const COMPONENTS: usize = 5;

fn layout() -> SegmentLayout {
    SegmentLayout {
        elements: ELEMENTS,
        advance: 1.into(),
        revolutions: 2,
        columns: COLUMNS,
        across: Across::Resolved { components: COMPONENTS, values: 0 },
        rule: TimeRule::Bdf2,
        time_step: 0.09 / ELEMENTS as f64,
        phase: 0,
        first_position: -0.13,
        circumference: CIRCUMFERENCE,
    }
}

fn model(tyre: &Tyre, air: AirMotion) -> PressureModel {
    let first = CellGrid::new(tyre, ELEMENTS, ACROSS).waves().first_lateral_number();
    let waves = SurfaceWaves::of(tyre, AROUND / 2, (first..first + COMPONENTS).collect(), 3000.0, 1e-6);
    PressureModel {
        layout: layout(),
        waves: Arc::new(waves),
        scale: 1.0,
        tangential: None,
        contact_width: tyre.contact_width,
        density: 1.2,
        air,
        highest: 150.0,
        delays: vec![0.0],
        strips: None,
    }
}

fn with_tangential(tyre: &Tyre, air: AirMotion) -> PressureModel {
    let model = model(tyre, air);
    let waves = TractionWaves::new(tyre, AROUND / 2, &model.waves.lateral, [3000.0, 1e-6]);
    let across = Across::Resolved { components: 3 * COMPONENTS, values: 0 };
    PressureModel { tangential: Some(Arc::new(waves)), layout: SegmentLayout { across, ..model.layout }, ..model }
}

/// Pressures by bin for a unit force along, across or inwards on the cell j of a column.
fn pressures(
    model: &PressureModel,
    tyre: &Tyre,
    green: SurfaceGreen,
    (column, j): (usize, usize),
    component: usize,
) -> Vec<Complex64> {
    let grid = CellGrid::new(tyre, ELEMENTS, ACROSS);
    let has_tangential = model.tangential.is_some();
    let lateral = LateralForces::new(&grid, model.waves.lateral.clone());
    let mut lateral = lateral.with_tangential(&grid, has_tangential);
    let (mut cells, mut tangential) = (vec![0.0; COLUMNS * ACROSS], vec![[0.0; 2]; COLUMNS * ACROSS]);
    match component {
        2 => cells[column * ACROSS + j] = 1.0,
        _ => tangential[column * ACROSS + j][component] = 1.0,
    }
    let forces = lateral.of_all(&cells, Some(&tangential), COLUMNS);
    let places: Vec<Complex32> = forces.iter().map(|&force| Complex32::from(force as f32)).collect();
    let block = (0..model.bins()).flat_map(|_| places.clone()).collect();
    let transfers = PressureTransfers { model: model.clone(), greens: vec![green].into() };
    transfers.pressures(0..1, &[block]).of_block(0, 0).map(double).collect()
}

/// A smooth G that is not even across.
fn green(x: f64, y: f64) -> Complex64 {
    let turn = TAU * x / CIRCUMFERENCE;
    even_green(x, y) + Complex64::new(6.0 * y * turn.cos(), 8.0 * y - 300.0 * y * y * y)
}

/// G, or for `side` -1 that of the mirrored receiver.
fn surface_green(half_width: f64, side: f64) -> SurfaceGreen {
    let length = CIRCUMFERENCE / AROUND as f64;
    let points: Vec<f64> = across(half_width, 4).into_iter().map(|[y, _]| y).collect();
    let part = |sign: f64| {
        let points = points.clone();
        points.into_iter().flat_map(move |y| {
            let value = move |x: f64| 0.5 * (green(x, side * y) + sign * green(x, -side * y));
            (0..AROUND).map(move |cell| value((cell as f64 + 0.5) * length))
        })
    };
    let values = part(1.0).chain(part(-1.0)).map(|value| Complex32::new(value.re as f32, value.im as f32)).collect();
    let (frequencies, values) = (vec![75.0], vec![values]);
    SurfaceGreen { frequencies, around: AROUND, values, across: points, rings: 0, half_width, under_patch: None }
}

#[test]
fn a_force_on_a_cell_sounds_as_the_moving_tread() {
    for (sides, air) in [
        (Sides::Supported, AirMotion::Axle),
        (Sides::Guided, AirMotion::Axle),
        (Sides::Supported, AirMotion::Road),
        (Sides::Guided, AirMotion::Road),
    ] {
        let tyre = Tyre { sides, ..plate_tyre() };
        let all = with_tangential(&tyre, air);
        let model = model(&tyre, air);
        let (layout, waves) = (layout(), &model.waves);
        let grid = CellGrid::new(&tyre, ELEMENTS, ACROSS);
        let half_width = 0.5 * tyre.width;
        let length = CIRCUMFERENCE / AROUND as f64;
        let fine = across(half_width, 24);
        let places = [(0, 0, 3, 2), (4, 3, 9, 2), (2, 1, 7, 2), (1, 0, 7, 0), (3, 2, 5, 0), (1, 0, 7, 1), (4, 3, 9, 1)];
        for (column, j, bin, component) in places {
            let angular = layout.angular_frequency(bin);
            let x_c = layout.first_position + CIRCUMFERENCE / ELEMENTS as f64 * column as f64;
            let mut values = vec![Complex64::ZERO; COMPONENTS];
            let mut expected = Complex64::ZERO;
            let turning = TAU * layout.revolutions as f64 * layout.resolution();
            for n in -15_i64..=15 {
                let material = TAU * layout.material_bin(bin, n) as f64 * layout.resolution();
                let seen = TransferKind::Rule.symbol(layout.rule, material, layout.time_step).im / TAU;
                waves.at(n, seen, &mut values);
                if component < 2 {
                    let tangential = all.tangential.as_ref().unwrap();
                    let of_number = |index: usize| tangential.at(n, seen, index)[component];
                    values.iter_mut().enumerate().for_each(|(index, value)| *value = of_number(index));
                }
                let kx = waves.waves.kx(n);
                let sinc = |x: f64| if x.abs() < 1e-9 { 1.0 } else { x.sin() / x };
                let force = Complex64::from_polar(sinc(0.5 * kx * CIRCUMFERENCE / ELEMENTS as f64), -kx * x_c);
                for (&m, compliance) in waves.lateral.iter().zip(&values) {
                    let ky = waves.waves.ky(m);
                    let norm = if m == 0 { 1.0 } else { 2.0 } / tyre.width;
                    // The wave from the tyre's right side on.
                    let shape = |y: f64| match sides {
                        Sides::Guided => (ky * (half_width + y)).cos(),
                        Sides::Supported => (ky * (half_width + y)).sin(),
                    };
                    let driven = traction_shape(&grid, component, m, j);
                    let of_wave = norm * driven * compliance * force / CIRCUMFERENCE;
                    for cell in 0..AROUND {
                        let middle = (cell as f64 + 0.5) * length;
                        let wave = moving_wave(air, [angular, turning], n, cell);
                        for &[y, weight] in &fine {
                            for y in [y, -y] {
                                let outward = -Complex64::i() * of_wave * wave * shape(y);
                                let area = weight * length;
                                expected += Complex64::i() * angular * 1.2 * green(middle, y) * outward * area;
                            }
                        }
                    }
                }
            }
            for model in [&all, &model].into_iter().take(if component < 2 { 1 } else { 2 }) {
                let green = surface_green(half_width, 1.0);
                let found = pressures(model, &tyre, green, (column, j), component)[bin];
                let error = (found - expected).norm() / expected.norm();
                let place = format!("{sides:?}, {air:?}, column {column}, cell {j}, component {component}");
                assert!(error < 1e-5, "{place}: {found} {expected}");
            }
        }
    }
}

#[test]
fn a_tyre_from_its_other_side_sounds_as_its_mirror() {
    for sides in [Sides::Supported, Sides::Guided] {
        let tyre = Tyre { sides, ..plate_tyre() };
        let model = model(&tyre, AirMotion::Road);
        let from = |side: f64, j: usize| pressures(&model, &tyre, surface_green(0.5 * tyre.width, side), (1, j), 2);
        for j in 0..ACROSS {
            let (left, right, mirrored) = (from(1.0, j), from(-1.0, j), from(-1.0, ACROSS - 1 - j));
            let largest = left.iter().fold(0.0_f64, |a, b| a.max(b.norm()));
            let apart = |a: &[Complex64], b: &[Complex64]| {
                a.iter().zip(b).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).norm())) / largest
            };
            assert!(apart(&left, &mirrored) < 1e-6, "{sides:?}, cell {j}: {:e}", apart(&left, &mirrored));
            assert!(apart(&left, &right) > 1e-3, "{sides:?}, cell {j}: odd waves are not heard");
        }
    }
}

#[test]
fn both_sides_of_a_tread_sound_separately() {
    // The odd parts of a receiver to the left and one to the right are opposite; the even part is that of one side
    // alone.
    let body = RadiatingBody::standing_tyre(0.3103, 0.176, 0.02, 0.054).unwrap();
    let receivers = [[0.2, 1.0, 0.4], [0.2, -1.0, 0.4]];
    let problem = |blocks| TransferProblem {
        body: &body,
        receivers: &receivers,
        grid: TransferGrid { around: 128, across: 4 },
        flank: None,
        resolution: MeshResolution::of(5.0),
        blocks,
        memory_limit: 1 << 30,
    };
    let wavenumber = TAU * 300.0 / 343.2;
    let (even, both) = (problem(&ParityBlock::EVEN_ACROSS), problem(&ParityBlock::ALL));
    let full = |problem: &TransferProblem<'_>| problem.solve(wavenumber).unwrap().0;
    for transfers in [[full(&even), full(&both)], [&even, &both].map(|p| draft::transfers_at(p, wavenumber))] {
        let [even, both] = transfers.map(|transfers| {
            transfers.into_iter().map(|transfer| SurfaceGreen::of(&body, [(300.0, transfer)])).collect::<Vec<_>>()
        });
        let count = 4 * 128;
        let largest = even[0].values[0].iter().fold(0.0_f32, |a, b| a.max(b.norm()));
        for (even, both) in even.iter().zip(&both) {
            assert_eq!((even.values[0].len(), both.values[0].len()), (count, 2 * count));
            let error = even.values[0].iter().zip(&both.values[0]).fold(0.0_f32, |e, (a, b)| e.max((a - b).norm()));
            assert!(error < 1e-5 * largest, "{error}");
        }
        let [left, right] = [0, 1].map(|receiver: usize| &both[receiver].values[0][count..]);
        let odd = left.iter().fold(0.0_f32, |a, b| a.max(b.norm()));
        let sum = left.iter().zip(right).fold(0.0_f32, |worst, (a, b)| worst.max((a + b).norm()));
        assert!(odd > 0.02 * largest && sum < 1e-4 * largest, "{odd} {sum} of {largest}");
    }
}
