//! The history by poles against sums over all past forces.

use std::sync::atomic::AtomicBool;

use super::modal::{TractionHistory, TractionRing};
use super::product::Vector;
use super::wave_group::Stepping;
use crate::contact::cells::CellHistory;
use crate::contact::cells::component_transforms::ComponentTransforms;
use crate::contact::cells::direct::DirectCellHistory;
use crate::contact::cells::wave_transform::WaveNumber;
use crate::counters::Meter;
use crate::scene::{DEFAULT, Sides, Tyre};
use crate::storage::state::SavedState;
use crate::test_models::tyre;
use crate::time_rule::TimeRule;
use crate::tyre::influence::{CellGrid, CellSums, CellTruncation, WaveBand};
use crate::tyre::poles::cells::CellFitOptions;
use crate::tyre::poles::traction_model::TractionModel;
use crate::tyre::poles::tractions::fit_tractions;

const ELEMENTS: usize = 16;
const ACROSS: usize = 4;
const COLUMNS: usize = 12;
const TIME_STEP: f64 = 2e-4;
const STEPS: usize = 70;
const TOLERANCE: f64 = 1e-4;

fn sums(tyre: &Tyre) -> CellSums {
    let truncation = CellTruncation { lateral_terms: Some(3), aliases: Some(1) };
    CellSums::new(tyre, CellGrid::new(tyre, ELEMENTS, ACROSS), truncation, 1e-9, 40.0 / TIME_STEP)
}

fn model(sums: &CellSums, band: WaveBand) -> TractionModel {
    let options = CellFitOptions { top: 8.0 / TIME_STEP, tolerance: TOLERANCE, most_poles: 120 };
    fit_tractions(sums, &sums.traction_rows(band), &options, &AtomicBool::new(false)).unwrap()
}

/// Rolls with forces that come and go, the same for every history; returns the displacements by past forces of all
/// steps.
fn roll(mut step: impl FnMut(i64, &[Vector], &mut [Vector])) -> Vec<Vector> {
    let mut all = Vec::new();
    for number in 0..STEPS {
        let first = (number / 2) as i64;
        let force = |cell: usize| {
            let place = (first as usize * ACROSS + cell) as f64;
            let drive = [0.7, 1.3, 2.9].map(|rate| (rate * place + 0.31 * rate * number as f64).sin());
            if drive[0] > 0.2 { drive } else { [0.0; 3] }
        };
        let forces: Vec<Vector> = (0..COLUMNS * ACROSS).map(force).collect();
        let mut out = vec![[0.0; 3]; COLUMNS * ACROSS];
        step(first, &forces, &mut out);
        all.extend(out);
    }
    all
}

/// Goes on with another history from the state: a part that is missing in it has another value there.
fn resume<P: CellHistory<3>>(history: &mut P, other: &mut P) {
    SavedState::of(history).unwrap().restore(other).unwrap();
    std::mem::swap(history, other);
}

fn by_poles<R: WaveNumber>(sums: &CellSums, model: &TractionModel, rule: TimeRule) -> Vec<Vector> {
    let rows = sums.traction_rows(WaveBand::WHOLE);
    let new = || {
        let transform = ComponentTransforms::of_tractions(sums.grid(), COLUMNS, &rows);
        let stepping =
            Stepping { rule, time_step: TIME_STEP, advance: 2.into(), tolerance: TOLERANCE, forgotten_after: None };
        TractionHistory::<R>::new([TractionRing { model, transform, seen: None, stepping }])
    };
    let (mut history, mut other) = (new(), new());
    roll(|first, forces, out| {
        history.add_displacement(0, first, out, &mut Meter::default());
        history.push(0, first, forces);
        resume(&mut history, &mut other);
    })
}

fn difference(a: &[Vector], b: &[Vector], component: usize) -> f64 {
    let largest = b.iter().fold(0.0_f64, |largest, value| largest.max(value[component].abs()));
    a.iter().zip(b).fold(0.0_f64, |worst, (a, b)| worst.max((a[component] - b[component]).abs())) / largest
}

/// Compares the history by poles of a tyre with sums.
fn hold(name: &str, tyre: &Tyre) {
    let sums = sums(tyre);
    let (model, rows) = (model(&sums, WaveBand::WHOLE), sums.traction_rows(WaveBand::WHOLE));
    let waves = model.len();
    println!("{name}: {waves} waves, {} channels, error {:.1e}", model.order(), model.error());
    assert!(model.error() <= TOLERANCE, "{name}: {:e}", model.error());
    for rule in [TimeRule::Bdf2, TimeRule::Bdf1] {
        let transform = ComponentTransforms::of_tractions(sums.grid(), COLUMNS, &rows);
        let mut direct = DirectCellHistory::of_tractions(&sums, &rows, transform, rule, TIME_STEP, STEPS + 2);
        let exact = roll(|first, forces, out| {
            direct.add_displacement(0, first, out, &mut Meter::default());
            direct.push(0, first, forces);
        });
        let double = by_poles::<f64>(&sums, &model, rule);
        let single = by_poles::<f32>(&sums, &model, rule);
        for component in 0..3 {
            let errors = [&double, &single].map(|found| difference(found, &exact, component));
            println!("  {rule:?}, component {component}: {:.1e}, single precision {:.1e}", errors[0], errors[1]);
            assert!(errors.into_iter().all(|error| error < TOLERANCE), "{name}, {component}: {errors:?}");
        }
    }
}

#[test]
fn the_history_by_poles_is_that_of_sums() {
    hold("flat", &tyre(0.25));
    hold("guided", &Tyre { sides: Sides::Guided, ..tyre(0.25) });
}

/// Rolls with forces on some columns of a window, over a history in bands; returns the displacements of all steps.
fn roll_with_rings(tyre: &Tyre, bands: &[WaveBand], forgotten_after: Option<usize>) -> Vec<Vector> {
    let [elements, columns, seen] = [128, 48, 22];
    let sums = |band: &WaveBand| {
        let grid = CellGrid::new(tyre, elements, ACROSS).on_ring(band.ring);
        CellSums::new(tyre, grid, CellTruncation::default(), 1e-9, 40.0 / TIME_STEP)
    };
    let models: Vec<TractionModel> = bands.iter().map(|band| model(&sums(band), *band)).collect();
    println!("{:?} waves", models.iter().map(TractionModel::len).collect::<Vec<_>>());
    let ring = |(band, model): (&WaveBand, _)| {
        let (is_short, sums) = (band.ring.is_some(), sums(band));
        let columns = if is_short { seen } else { columns };
        let transform = ComponentTransforms::of_tractions(sums.grid(), columns, &sums.traction_rows(*band));
        let forgotten_after = forgotten_after.filter(|_| is_short);
        let stepping = Stepping {
            rule: TimeRule::Bdf2,
            time_step: TIME_STEP,
            advance: 2.into(),
            tolerance: TOLERANCE,
            forgotten_after,
        };
        TractionRing { model, transform, seen: is_short.then_some(ACROSS), stepping }
    };
    let [mut history, mut other] = [(); 2].map(|()| TractionHistory::<f64>::new(bands.iter().zip(&models).map(&ring)));
    let mut all = Vec::new();
    for number in 0..2 * elements {
        let first = (number / 2) as i64;
        let mut out = vec![[0.0; 3]; columns * ACROSS];
        history.add_displacement(0, first, &mut out, &mut Meter::default());
        let force = |cell: usize| {
            let place = (first as usize * ACROSS + cell) as f64;
            let is_touched = (18..28).contains(&(cell / ACROSS));
            if is_touched { [0.7, 1.3, 2.9].map(|rate| 1.0 + (rate * place).sin()) } else { [0.0; 3] }
        };
        let forces: Vec<Vector> = (0..columns * ACROSS).map(force).collect();
        assert!(history.push(0, first, &forces), "forces do not fit");
        resume(&mut history, &mut other);
        // About the contact.
        all.extend_from_slice(&out[14 * ACROSS..32 * ACROSS]);
    }
    all
}

#[test]
fn short_rings_carry_what_waves_of_the_whole_tyre_do() {
    // Sides are whole cells away.
    let mut flat = Tyre { width: 0.12, contact_width: 0.06, ..tyre(0.25) };
    flat.layers.last_mut().unwrap().thickness = 0.05;
    let band = |ring, fades_in, fades_out, folded| WaveBand { ring, fades_in, fades_out, folded };
    let short = |fades_in, fades_out, folded| band(Some(60), fades_in, fades_out, folded);
    let (longer, shorter) = (Some([60.0, 120.0]), Some([120.0, 240.0]));
    let bands = [band(None, None, longer, false), short(longer, shorter, false), short(shorter, None, true)];
    let exact = roll_with_rings(&flat, &[WaveBand::WHOLE], None);
    let found = roll_with_rings(&flat, &bands, Some(56));
    let lasting = roll_with_rings(&flat, &bands, None);
    for component in 0..3 {
        let errors = [&found, &lasting].map(|found| difference(found, &exact, component));
        println!("component {component}: {:.1e}, without forgetting {:.1e}", errors[0], errors[1]);
        assert!(errors[0] < 2e-3, "{component}: {errors:?}");
        assert!(errors[1] > 2.0 * errors[0], "{component}: {errors:?}");
    }
}

#[test]
#[ignore = "minutes: waves of a curved tyre"]
fn the_history_of_a_turning_tyre_by_poles_is_that_of_sums() {
    let curved = crate::scene::Scene::from_str(DEFAULT, "scene").unwrap().scene.tyre;
    hold("curved", &curved);
    hold("turning", &Tyre { angular_velocity: -100.0, ..curved });
}
