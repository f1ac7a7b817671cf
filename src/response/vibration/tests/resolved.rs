//! Forces that are resolved across the strip, against sums written out and against forces that are even across.

use super::*;
use crate::response::LateralForces;
use crate::tyre::influence::{CellGrid, CellSums, CellTruncation, WaveBand};
use crate::tyre::poles::cells::{CellFitOptions, fit_cells};
use crate::tyre::poles::lateral::{LateralFitOptions, fit_lateral};

const ACROSS: usize = 4;
/// All lateral numbers of these tests' waves; the strip's mean sees the odd ones, as the plate's sides are supported.
const CARRIED: [usize; 5] = [1, 2, 3, 4, 5];
const IN_MEAN: [usize; 3] = [1, 3, 5];

fn tyre() -> crate::scene::Tyre {
    Scene::from_str(PLATE, "default").unwrap().scene.tyre
}

fn grid(elements: usize) -> CellGrid {
    CellGrid::new(&tyre(), elements, ACROSS)
}

fn fit_options(elements: usize) -> LateralFitOptions {
    let tyre = tyre();
    LateralFitOptions { fit: FitOptions::new(&tyre, elements, 20.0).with_tolerance(1e-3), aliases: Some(1) }
}

fn models(elements: usize, numbers: &[usize]) -> Vec<RationalModel> {
    fit_lateral(&tyre(), numbers, &fit_options(elements), &Default::default()).unwrap()
}

fn carried(elements: usize) -> CarriedWaves {
    let tyre = tyre();
    let truncation = CellTruncation { lateral_terms: Some(CARRIED.len()), aliases: Some(0) };
    let sums = CellSums::new(&tyre, grid(elements), truncation, 1e-8, 1e5);
    let rows = sums.waves(WaveBand::WHOLE);
    let options = CellFitOptions { top: 1e5, tolerance: 1e-3, most_poles: 160 };
    let model = fit_cells(&sums, &rows, &options, &Default::default()).unwrap();
    CarriedWaves { ring: elements, rows, model }
}

/// The carried waves as if their tyre turned: with odd parts for those that are not their own mirror.
fn turned_waves(waves: &CarriedWaves) -> CarriedWaves {
    let rows = waves.rows.iter().flat_map(|row| row.waves.iter().enumerate());
    let odd = rows.enumerate().flat_map(|(wave, (n, _))| {
        let size = if n == 0 || 2 * n == 14 { 0.0 } else { 0.7 };
        waves.model.wave(wave).residues.iter().map(move |residue| size * residue)
    });
    let mut model = serde_json::to_value(&waves.model).unwrap();
    model["residues"][0][1] = serde_json::to_value(odd.collect::<Vec<_>>()).unwrap();
    let model = serde_json::from_value(model).unwrap();
    CarriedWaves { ring: waves.ring, rows: waves.rows.clone(), model }
}

fn answer(model: &RationalModel) -> TyreResponse<'_> {
    TyreResponse { model, scale: 1.0, spring: 0.0, tangential: None }
}

/// The layout with `components` lateral components and so many values per wavenumber.
fn resolved(layout: SegmentLayout, components: usize, values: usize) -> SegmentLayout {
    SegmentLayout { across: Across::Resolved { components, values }, ..layout }
}

/// Reorders the forces of each step from cell across by column to column by cell.
fn by_cell(layout: &SegmentLayout, forces: &[f64]) -> Vec<f64> {
    let cells = COLUMNS * ACROSS;
    let mut all = vec![0.0; forces.len()];
    for (out, forces) in all.chunks_exact_mut(cells).zip(forces.chunks_exact(cells)) {
        for (place, force) in forces.iter().enumerate() {
            out[place % COLUMNS * ACROSS + place / COLUMNS] = *force;
        }
    }
    assert_eq!(forces.len() % (layout.stages() * cells), 0);
    all
}

#[test]
fn velocities_and_power_are_the_double_sums_over_waves() {
    let elements = 14;
    let (models, waves) = (models(elements, &IN_MEAN), carried(elements));
    double_sums(elements, &models, &waves);
    let turning: Vec<RationalModel> = models.iter().map(turned).collect();
    let waves = turned_waves(&waves);
    assert!(waves.model.turns());
    double_sums(elements, &turning, &waves);
}

fn double_sums(elements: usize, models: &[RationalModel], waves: &CarriedWaves) {
    let grid = grid(elements);
    let shape = |m: usize, j: usize| grid.shape(m, j);
    let over_two = Advance::over(2);
    for (advance, revolutions, phase) in [(1.into(), 2, 0), (2.into(), 1, 1), (over_two, 2, 0)] {
        let even = layout(elements, advance, revolutions, phase);
        let (plain, weighted) = windowed_segment(&resolved(even, ACROSS, 1), 31);
        let (plain, weighted) = (by_cell(&even, &plain), by_cell(&even, &weighted));
        let (of_mean, of_power) = (resolved(even, IN_MEAN.len(), 2), resolved(even, CARRIED.len(), 1));
        let fields = [VibrationField::Tread, VibrationField::Belt];
        let shares = || IN_MEAN.iter().zip(models).map(|(&m, model)| (grid.mean_shape(m), answer(model)));
        let responses: Vec<_> = shares().collect();
        let tables = fields.map(|field| {
            let table = VelocityTable::resolved(&of_mean, &responses, TransferKind::Rule, field).unwrap();
            ResolvedVelocity::of(&table, &of_mean)
        });
        let mut velocities = VibrationAccumulator::resolved(of_mean, ResolvedQuantities::Velocities(tables.into()));
        let power = ResolvedPower::new(&of_power, std::slice::from_ref(waves), &CARRIED);
        let mut power = VibrationAccumulator::resolved(of_power, ResolvedQuantities::Power(power));
        let mut lateral = LateralForces::new(&grid, IN_MEAN.into());
        let mut all = LateralForces::new(&grid, CARRIED.into());
        for row in plain.chunks_exact(COLUMNS * ACROSS) {
            velocities.push(lateral.of(row, COLUMNS), 0.0);
            power.push(all.of(row, COLUMNS), 0.0);
        }
        let spectra = resolved_spectra(&velocities.finish().unwrap(), &fields, true);
        let dissipated = resolved_dissipation(&power.finish().unwrap());

        // F_nm(w') by the definition: over steps, columns and cells, with the elements where they are.
        let length = even.length();
        let force = |n: i64, m: usize, bin: usize| -> Complex64 {
            let mut sum = Complex64::ZERO;
            for (step, row) in weighted.chunks_exact(COLUMNS * ACROSS).enumerate() {
                for (cell, force) in row.iter().enumerate() {
                    let element = advance.elements((phase + step) as i64) as f64 + (cell / ACROSS) as f64;
                    let turns = n as f64 * element / elements as f64 + (bin * step) as f64 / length as f64;
                    let shape = shape(m, cell % ACROSS);
                    sum += shape * force * Complex64::from_polar(1.0, -2.0 * PI * turns);
                }
            }
            sum
        };
        // The accumulator divides by the energy of the window, half the length.
        let scale = 2.0 / (length * length) as f64;
        let mut expected = [vec![0.0; even.bins()], vec![0.0; even.bins()]];
        let mut put_in = 0.0;
        for bin in 0..length {
            let signed = even.material_bin(bin, 0);
            let frequency = 2.0 * PI * signed as f64 * even.resolution();
            let s = TransferKind::Rule.symbol(even.rule, frequency, even.time_step);
            for n in -(elements as i64) / 2..elements as i64 / 2 {
                let index = n.unsigned_abs() as usize;
                for (expected, face) in expected.iter_mut().zip([Field::Surface, Field::Bottom]) {
                    let velocity: Complex64 = IN_MEAN
                        .iter()
                        .zip(models)
                        .map(|(&m, model)| {
                            let compliance = of_wave(&model.modes(index, face).unwrap(), n, s);
                            grid.mean_shape(m) * s * compliance * force(n, m, bin)
                        })
                        .sum();
                    expected[signed.unsigned_abs() as usize] += scale * velocity.norm_sqr();
                }
                for (row, &m) in CARRIED.iter().enumerate() {
                    let compliance = of_wave(&waves.model.wave(row * (elements / 2 + 1) + index), n, s);
                    put_in += scale * (s * compliance).re * force(n, m, bin).norm_sqr();
                }
            }
        }
        for (field, expected) in spectra.iter().zip(&expected) {
            let largest = expected.iter().fold(0.0_f64, |a, &b| a.max(b));
            for (bin, exact) in expected.iter().enumerate().take(even.bins() - 1).skip(1) {
                let error = (field.material.power[bin] - exact).abs() / largest;
                assert!(error < 1e-6, "{:?}, {advance}, bin {bin}: {error:e}", field.field);
            }
            let [material, road] = [&field.material, &field.non_rotating].map(PowerSpectrum::mean_square);
            assert!((material / (road + field.mean_pattern) - 1.0).abs() < 1e-12);
            for map in field.maps.as_ref().unwrap() {
                let sum = map.density.iter().sum::<f64>() * map.row_width;
                assert!((sum / road - 1.0).abs() < 1e-12, "maps hold the vibration");
            }
        }
        assert!((dissipated.total() / put_in - 1.0).abs() < 1e-6, "{} {put_in}", dissipated.total());
    }
}

#[test]
fn forces_that_are_even_across_move_the_tyre_as_slices_do() {
    let elements = 14;
    let (grid, model) = (grid(elements), &models(elements, &[3])[0]);
    let share = grid.mean_shape(3);
    // For one wave a slice takes the square of its mean over the strip.
    let slice = TyreResponse { scale: share * share, ..answer(model) };
    for (rule, substeps, revolutions, phase) in
        [(TimeRule::Bdf2, 1, 1, 0), (TimeRule::Bdf2, 2, 1, 1), (TimeRule::Sdirk2, 1, 1, 0), (TimeRule::Sdirk3, 2, 1, 0)]
    {
        let even = SegmentLayout { rule, ..layout(elements, substeps, revolutions, phase) };
        let across = resolved(even, 1, 1);
        let (field, kind, positions) = (VibrationField::Tread, TransferKind::Rule, [0.3, -0.2]);
        let at_places = |accumulator: &mut VibrationAccumulator, layout: &SegmentLayout, table: VelocityTable| {
            accumulator.add_points(&table, &positions);
            accumulator.set_elements(ElementVelocities::new(layout, 3, vec![table], vec![0, 9]));
        };
        let mut one = VibrationAccumulator::new(even);
        at_places(&mut one, &even, VelocityTable::new(&even, &slice, kind, field).unwrap());
        let table = VelocityTable::resolved(&across, &[(share, answer(model))], kind, field).unwrap();
        let quantities = ResolvedQuantities::Velocities(vec![ResolvedVelocity::of(&table, &across)]);
        let mut other = VibrationAccumulator::resolved(across, quantities);
        at_places(&mut other, &across, table);
        let mut lateral = LateralForces::new(&grid, vec![3]);
        // With a mean that is known only at the end of the record.
        for row in noise(&even, 5 * even.hop() + 1, 20.0, 12).chunks_exact(even.width()) {
            one.push(row, 1.0);
            let cells: Vec<f64> = row.iter().flat_map(|force| [force / ACROSS as f64; ACROSS]).collect();
            other.push(lateral.of(&cells, COLUMNS), 1.0);
        }
        let (one, other) = (one.finish().unwrap(), other.finish().unwrap());
        let request = SpectraRequest { fields: &[field], kind, maps: false };
        let (expected, _) = field_spectra(&one, &slice, &request).unwrap();
        let found = resolved_spectra(&other, &[field], false);
        let same = |what: &str, found: &[f64], expected: &[f64], tolerance: f64| {
            let largest = expected.iter().fold(0.0_f64, |a, &b| a.max(b));
            let error = found.iter().zip(expected).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs())) / largest;
            assert!(error < tolerance, "{rule:?}, q = {substeps}, {what}: {error:e}");
        };
        // Transfers in single precision; at points and elements they are in double.
        same("material", &found[0].material.power, &expected[0].material.power, 1e-6);
        same("varying", &found[0].material_varying.power, &expected[0].material_varying.power, 1e-6);
        same("road", &found[0].non_rotating.power, &expected[0].non_rotating.power, 1e-6);
        for (found, expected) in other.points.iter().zip(&one.points).chain(other.elements.iter().zip(&one.elements)) {
            same("points", found, expected, 1e-11);
        }
    }
}

#[test]
fn a_strip_integrates_as_the_sum_over_its_waves() {
    let elements = 14;
    let tyre = tyre();
    let options = FitOptions::new(&tyre, elements, 20.0).with_tolerance(1e-3);
    let strip = fit(&tyre, &options).unwrap();
    let numbers: Vec<usize> = grid(elements).numbers_in_mean(0.01, 1000);
    let whole = LateralFitOptions { fit: options, aliases: None };
    let models = fit_lateral(&tyre, &numbers, &whole, &Default::default()).unwrap();
    let even = layout(elements, 2, 1, 0);
    for field in [VibrationField::Tread, VibrationField::Belt] {
        let table = VelocityTable::new(&even, &answer(&strip), TransferKind::Rule, field).unwrap();
        let across = resolved(even, numbers.len(), 1);
        let shares = numbers.iter().map(|&m| grid(elements).mean_shape(m));
        let responses: Vec<_> = shares.clone().zip(models.iter().map(answer)).collect();
        let waves = VelocityTable::resolved(&across, &responses, TransferKind::Rule, field).unwrap();
        let largest = (0..even.bins() as i64).map(|bin| table.at(0, 0, bin).norm()).fold(0.0, f64::max);
        let mut worst = 0.0_f64;
        for (n, bin) in (0..=7).flat_map(|n| (1..even.bins() as i64).map(move |bin| (n, bin))) {
            let exact = table.at(0, n, bin);
            let sum: Complex64 = shares.clone().enumerate().map(|(m, share)| share * waves.at(m, n, bin)).sum();
            worst = worst.max((sum - exact).norm() / largest);
        }
        println!("{field:?}, {} numbers: {worst:.1e}", numbers.len());
        assert!(worst < 0.01, "{field:?}: {worst:e}");
    }
}

#[test]
fn a_mean_pattern_adds_nothing_to_the_power_of_the_vibration() {
    // Few enough bins for the mean pattern, which the first segment does not know, to be taken off exactly.
    let elements = 14;
    let waves = carried(elements);
    let of_power = resolved(layout(elements, 1, 1, 0), CARRIED.len(), 1);
    let power = |mean: f64| {
        let power = ResolvedPower::new(&of_power, std::slice::from_ref(&waves), &CARRIED);
        let mut accumulator = VibrationAccumulator::resolved(of_power, ResolvedQuantities::Power(power));
        for row in noise(&of_power, 5 * of_power.hop(), 0.0, 3).chunks_exact(of_power.width()) {
            let row: Vec<f64> =
                row.iter().enumerate().map(|(place, force)| force + mean * (1 + place) as f64).collect();
            accumulator.push(&row, 0.0);
        }
        resolved_dissipation(&accumulator.finish().unwrap())
    };
    let (without, with) = (power(0.0), power(3.0));
    assert!((with.vibration / without.vibration - 1.0).abs() < 1e-9, "{with:?} {without:?}");
    assert!(with.mean_pattern > 100.0 * without.mean_pattern, "{with:?} {without:?}");
}

#[test]
fn resolved_forces_continue_with_the_same_bits_on_any_threads() {
    let model = models(ELEMENTS, &IN_MEAN);
    let waves = carried(ELEMENTS);
    let even = SegmentLayout { rule: TimeRule::Sdirk2, ..layout(ELEMENTS, 2, 1, 0) };
    let (of_mean, of_power) = (resolved(even, IN_MEAN.len(), 1), resolved(even, CARRIED.len(), 1));
    let new = || {
        let responses: Vec<_> =
            IN_MEAN.iter().zip(&model).map(|(&m, model)| (grid(ELEMENTS).mean_shape(m), answer(model))).collect();
        let kind = TransferKind::Rule;
        let table = VelocityTable::resolved(&of_mean, &responses, kind, VibrationField::Belt).unwrap();
        let quantities = ResolvedQuantities::Velocities(vec![ResolvedVelocity::of(&table, &of_mean)]);
        let mut velocities = VibrationAccumulator::resolved(of_mean, quantities);
        velocities.add_points(&table, &[0.2]);
        velocities.set_elements(ElementVelocities::new(&of_mean, 3, vec![table], vec![9]));
        let power = ResolvedPower::new(&of_power, std::slice::from_ref(&waves), &CARRIED);
        [velocities, VibrationAccumulator::resolved(of_power, ResolvedQuantities::Power(power))]
    };
    let records = [of_mean, of_power].map(|layout| noise(&layout, 4 * layout.hop() + 7, 20.0, 2));
    let push = |accumulators: &mut [VibrationAccumulator; 2], from: usize, to: usize| {
        for (accumulator, record) in accumulators.iter_mut().zip(&records) {
            let width = accumulator.layout().width();
            record.chunks_exact(width).take(to).skip(from).for_each(|row| {
                accumulator.push(row, row[0]);
            });
        }
    };
    let bits = |accumulators: &[VibrationAccumulator; 2]| {
        let patches = accumulators.each_ref().map(|accumulator| accumulator.finish().unwrap());
        let all = patches.iter().flat_map(|patch| {
            patch.powers.iter().chain(patch.points.iter().flatten()).chain(patch.elements.iter().flatten())
        });
        all.map(|x| x.to_bits()).collect::<Vec<_>>()
    };
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let whole = pool(1).install(|| {
        let mut whole = new();
        push(&mut whole, 0, usize::MAX);
        bits(&whole)
    });
    for stop in [0, 1, even.hop(), even.length() + 3] {
        let stopped = pool(2).install(|| {
            let (mut first, mut second) = (new(), new());
            push(&mut first, 0, stop);
            SavedState::of(&mut first).unwrap().restore(&mut second).unwrap();
            push(&mut second, stop, usize::MAX);
            bits(&second)
        });
        assert_eq!(whole, stopped, "stopped after {stop}");
    }
}
