//! Spectra of all rules and fields against the same forces stepped through the rule.

use super::*;
use crate::contact::history::{ForceHistory, ModalHistory};
use crate::counters::Meter;
use crate::numeric::Ring;
use crate::time_rule::RungeKutta;
use crate::tyre::poles::{TangentialModel, tangential_model};

/// Displacements of all elements at the ends of the steps over the last of many periods of the same forces, and the
/// mean power put in over it \[W\], by the run's recursion.
fn rolled(layout: &SegmentLayout, forces: &[f64], periods: usize) -> (Vec<Vec<f64>>, f64) {
    let SegmentLayout { elements, rule, .. } = *layout;
    let length = layout.length();
    let mut history = ModalHistory::new(model(), Field::Surface, rule, TIME_STEP, model().elements).unwrap();
    let first_weights = ModalHistory::first_weights(model(), Field::Surface, rule, TIME_STEP).unwrap();
    let instant = Ring::new(elements).elements_of(|n| first_weights[n]).to_vec();
    // More elements on either side: one that enters the window carries no force yet, as in a run.
    let margin = 2 * layout.advance.elements_per_step;
    let mut power = ContactPower::new(rule, TIME_STEP, COLUMNS + 2 * margin);
    let (mut last, mut work) = (Vec::new(), 0.0);
    for step in 0..periods * length {
        let first = layout.advance.elements((layout.phase + step) as i64);
        let mut all = vec![0.0; elements];
        let (mut window, mut wide) = (Vec::new(), Vec::new());
        for row in forces[step % length * layout.width()..][..layout.width()].chunks_exact(COLUMNS) {
            history.displacement(0, &mut all, &mut Meter::default());
            for (column, force) in row.iter().enumerate() {
                for (element, value) in all.iter_mut().enumerate() {
                    let distance = (element as i64 - first - column as i64).rem_euclid(elements as i64);
                    *value += instant[distance as usize] * force;
                }
            }
            history.push(first, row);
            window.extend(
                (-(margin as i64)..(COLUMNS + margin) as i64)
                    .map(|c| all[(first + c).rem_euclid(elements as i64) as usize]),
            );
            wide.extend(vec![0.0; margin].iter().chain(row).chain(&vec![0.0; margin]));
        }
        let put_in = power.push(first - margin as i64, &wide, &window);
        if step >= (periods - 1) * length {
            last.push(all);
            work += put_in;
        }
    }
    (last, work / length as f64)
}

/// One period of a mode under the forces of a Runge-Kutta rule's stages: the states at the ends of the steps.
fn steps_of_mode(method: &RungeKutta, z: Complex64, begin: Complex64, forces: &[Complex64]) -> Vec<Complex64> {
    let (a, stages) = (method.matrix(), method.nodes.len());
    let mut state = begin;
    let step = |forces: &[Complex64]| {
        let mut rates = [Complex64::ZERO; 3];
        for i in 0..stages {
            let base: Complex64 = state + (0..i).map(|k| TIME_STEP * a[i][k] * rates[k]).sum::<Complex64>();
            rates[i] = (z / TIME_STEP * base + forces[i]) / (1.0 - a[i][i] * z);
        }
        state += (0..stages).map(|k| TIME_STEP * a[stages - 1][k] * rates[k]).sum::<Complex64>();
        state
    };
    forces.chunks_exact(stages).map(step).collect()
}

/// Displacements of a field of all elements at the ends of the steps under periodic forces of the stages, mode by mode.
fn periodic(
    layout: &SegmentLayout,
    forces: &[f64],
    field: VibrationField,
    tangential: &TangentialModel,
) -> Vec<Vec<f64>> {
    let SegmentLayout { elements, advance, .. } = *layout;
    let method = layout.rule.runge_kutta().unwrap();
    let (length, stages) = (layout.length(), layout.stages());
    let mut all = vec![vec![0.0; elements]; length];
    for n in 0..=elements / 2 {
        let face = if field == VibrationField::Belt { Field::Bottom } else { Field::Surface };
        let modes = model().modes(n, face).unwrap();
        let (residues, constant) = match field {
            VibrationField::Tangential => (tangential.residues[n].as_slice(), tangential.constants[n]),
            _ => (modes.residues, modes.constant),
        };
        let turn = |element: usize| Complex64::from_polar(1.0, 2.0 * PI * (n * element) as f64 / elements as f64);
        let waves: Vec<Complex64> = forces
            .chunks_exact(COLUMNS)
            .enumerate()
            .map(|(instant, row)| {
                let first = advance.elements((layout.phase + instant / stages) as i64) as usize;
                row.iter().enumerate().map(|(column, force)| force * turn(first + column).conj()).sum()
            })
            .collect();
        let mut displacement: Vec<Complex64> = waves.chunks_exact(stages).map(|w| constant * w[stages - 1]).collect();
        for (index, (&pole, &residue)) in modes.poles.iter().zip(residues).enumerate() {
            let both = [(pole, residue), (pole.conj(), residue.conj())];
            for &(pole, residue) in if index < modes.pairs { &both[..] } else { &both[..1] } {
                let z = pole * TIME_STEP;
                let rest = vec![Complex64::ZERO; waves.len()];
                let decay = steps_of_mode(&method, z, Complex64::ONE, &rest)[length - 1];
                let begin = steps_of_mode(&method, z, Complex64::ZERO, &waves)[length - 1] / (1.0 - decay);
                let states = steps_of_mode(&method, z, begin, &waves);
                displacement.iter_mut().zip(states).for_each(|(sum, state)| *sum += residue * state);
            }
        }
        // The wave and that of -n; the shortest one is both, and zero where the field is odd in n.
        let factor = match field {
            VibrationField::Tangential if 2 * n == elements => Complex64::ZERO,
            VibrationField::Tangential => Complex64::i(),
            _ => Complex64::ONE,
        };
        let twice = if n == 0 || 2 * n == elements { 1.0 } else { 2.0 };
        for (row, value) in all.iter_mut().zip(displacement) {
            for (element, sum) in row.iter_mut().enumerate() {
                *sum += twice * (factor * value * turn(element)).re;
            }
        }
    }
    all
}

/// Plain discrete Fourier transform over time.
fn transformed(series: &[Complex64]) -> Vec<Complex64> {
    let length = series.len();
    let at = |bin: usize| {
        let turn = |step: usize| Complex64::from_polar(1.0, -2.0 * PI * (bin * step % length) as f64 / length as f64);
        series.iter().enumerate().map(|(step, value)| value * turn(step)).sum()
    };
    (0..length).map(at).collect()
}

/// Transforms over a period of the velocities of all elements, by the rule's difference quotient or as the derivative
/// of the interpolated samples: by element, then by bin, negative frequencies last.
fn velocity_transforms(layout: &SegmentLayout, displacement: &[Vec<f64>], kind: TransferKind) -> Vec<Vec<Complex64>> {
    (0..layout.elements)
        .map(|element| {
            let series: Vec<Complex64> = displacement.iter().map(|all| all[element].into()).collect();
            let mut bins = transformed(&series);
            for (bin, value) in bins.iter_mut().enumerate() {
                let signed = layout.material_bin(bin, 0);
                let symbol = kind.symbol(layout.rule, 2.0 * PI * signed as f64 * layout.resolution(), layout.time_step);
                // The last bin of a real signal is real: cos, whose derivative is zero at the samples.
                *value *= if 2 * signed.unsigned_abs() as usize == layout.length() { symbol.re.into() } else { symbol };
            }
            bins
        })
        .collect()
}

/// Compares the spectra everywhere, the maps, and the spectra at points and at elements with those of the displacements
/// under the windowed forces. Returns half of the dissipated power, the mean power of the windowed forces \[W\].
pub(super) fn compare(
    layout: &SegmentLayout,
    plain: &[f64],
    response: &TyreResponse<'_>,
    field: VibrationField,
    displacement: &[Vec<f64>],
) -> f64 {
    let kind = TransferKind::Rule;
    let positions = [layout.first_position, 0.0, 0.1, -0.7, 0.975];
    let mut accumulator = VibrationAccumulator::new(*layout);
    let table = VelocityTable::new(layout, response, kind, field).unwrap();
    accumulator.add_points(&table, &positions);
    let elements = vec![0, 6, 15, 7];
    accumulator.set_elements(ElementVelocities::new(layout, 0, vec![table], elements.clone()));
    for row in plain.chunks_exact(layout.width()) {
        accumulator.push(row, 0.0);
    }
    let patch = accumulator.finish().unwrap();
    let request = SpectraRequest { fields: &[field], kind, maps: true };
    let (fields, dissipation) = field_spectra(&patch, response, &request).unwrap();

    let velocities = velocity_transforms(layout, displacement, kind);
    let length = layout.length() as f64;
    // The accumulator divides by the energy of the window, half the length.
    let scale = 2.0 / (length * length);
    let bins = layout.bins();
    let last = bins - 1;
    let SegmentLayout { rule, advance, revolutions, .. } = *layout;
    let name = format!("{rule:?}, {advance}, r = {revolutions}, {field:?}");

    let material: Vec<f64> = (0..bins)
        .map(|bin| {
            let sum: f64 = velocities.iter().map(|element| element[bin].norm_sqr()).sum();
            layout.sides(bin) * scale * sum / ELEMENTS as f64
        })
        .collect();
    let largest = material.iter().fold(0.0_f64, |a, &b| a.max(b));
    for (bin, exact) in material.iter().enumerate().take(last).skip(1) {
        let error = (fields[0].material.power[bin] - exact).abs() / largest;
        assert!(error < 1e-6, "{name}, material, bin {bin}: {error:e}");
    }

    // The waves exp(2 pi i (n e/N + k l/K)), each once in either map.
    let wave = |n: i64, bin: i64| -> f64 {
        let turn =
            |element: usize| Complex64::from_polar(1.0, -2.0 * PI * (n * element as i64) as f64 / ELEMENTS as f64);
        let of_element = |element: usize| velocities[element][bin.rem_euclid(layout.length() as i64) as usize];
        (0..ELEMENTS).map(|element| turn(element) * of_element(element) / ELEMENTS as f64).sum::<Complex64>().norm_sqr()
    };
    let [of_material, of_road] = fields[0].maps.as_ref().unwrap();
    let largest = of_material.density.iter().fold(0.0_f64, |a, &b| a.max(b)) * of_material.row_width;
    for (bin, index) in (0..last).flat_map(|bin| (0..layout.wavenumbers()).map(move |index| (bin, index))) {
        let n = layout.wavenumber(index);
        let found = |map: &WavenumberMap| map.density[bin * layout.wavenumbers() + index] * map.row_width;
        let exact = 2.0 * scale * layout.share(index) * wave(n, bin as i64);
        let error = (found(of_material) - exact).abs() / largest;
        assert!(bin == 0 || error < 1e-6, "{name}, material map, bin {bin}, n = {n}: {error:e}");
        let material_bin = layout.material_bin(bin, n);
        let exact = layout.sides(bin) * scale * layout.share(index) * wave(n, material_bin);
        let error = (found(of_road) - exact).abs() / largest;
        let ambiguous = 2 * material_bin.unsigned_abs() as usize == layout.length();
        assert!(ambiguous || error < 1e-6, "{name}, map of the road, bin {bin}, n = {n}: {error:e}");
    }

    for (point, &element) in elements.iter().enumerate() {
        let found = element_spectrum(&patch, point);
        let powers: Vec<f64> =
            (0..bins).map(|bin| layout.sides(bin) * scale * velocities[element][bin].norm_sqr()).collect();
        let largest = powers.iter().fold(0.0_f64, |a, &b| a.max(b));
        for (bin, exact) in powers.iter().enumerate().take(last) {
            let error = (found.power[bin] - exact).abs() / largest;
            assert!(error < 1e-6, "{name}, element {element}, bin {bin}: {error:e}");
        }
    }

    // v_n(l), then at fixed places; half of either end of the wavenumbers, the rule's last bin left out on both sides.
    let series = |element: usize| -> Vec<Complex64> {
        let bins: Vec<Complex64> = velocities[element].iter().map(|value| value.conj()).collect();
        transformed(&bins).into_iter().map(|value| value.conj() / length).collect()
    };
    let by_element: Vec<Vec<Complex64>> = (0..ELEMENTS).map(series).collect();
    for (point, position) in positions.iter().enumerate() {
        let at = |step: usize| -> Complex64 {
            let mut sum = Complex64::ZERO;
            for index in 0..layout.wavenumbers() {
                let n = layout.wavenumber(index) as f64;
                let wave: Complex64 = (0..ELEMENTS)
                    .map(|e| {
                        by_element[e][step] * Complex64::from_polar(1.0, -2.0 * PI * n * e as f64 / ELEMENTS as f64)
                    })
                    .sum::<Complex64>()
                    / ELEMENTS as f64;
                let elements_on = (position - layout.first_position) * ELEMENTS as f64 / layout.circumference
                    + (layout.phase + step) as f64 * TIME_STEP / advance.time_of_element(TIME_STEP);
                let turn = Complex64::from_polar(1.0, 2.0 * PI * n * elements_on / ELEMENTS as f64);
                sum += layout.share(index) * wave * turn;
            }
            sum
        };
        let exact = transformed(&(0..layout.length()).map(at).collect::<Vec<_>>());
        let found = point_spectrum(&patch, point);
        let powers: Vec<f64> = (0..bins).map(|bin| layout.sides(bin) * scale * exact[bin].norm_sqr()).collect();
        let largest = powers.iter().fold(0.0_f64, |a, &b| a.max(b));
        for (bin, exact) in powers.iter().enumerate() {
            // The last bin of the material frame has no sign; a wave of some n lies there in these bins.
            let ambiguous = (0..layout.wavenumbers())
                .any(|i| 2 * layout.material_bin(bin, layout.wavenumber(i)).unsigned_abs() as usize == layout.length());
            let error = (found.power[bin] - exact).abs() / largest;
            assert!(ambiguous || error < 1e-6, "{name}, {position} m, bin {bin}: {error:e}");
        }
    }
    0.5 * dissipation.total()
}

/// Cases: substeps and elements per step, revolutions, substep of the first step.
pub(super) const CASES: [(Advance, usize, usize); 7] = [
    (Advance::within(1), 1, 0),
    (Advance::within(1), 3, 0),
    (Advance::within(2), 1, 1),
    (Advance::within(2), 2, 0),
    (Advance::within(3), 1, 2),
    (Advance::over(2), 1, 0),
    (Advance::over(4), 3, 0),
];

#[test]
fn spectra_of_fields_and_points_are_those_of_the_time_domain() {
    for rule in TimeRule::ALL {
        for (advance, revolutions, phase) in CASES {
            let layout = SegmentLayout { rule, ..layout(ELEMENTS, advance, revolutions, phase) };
            let (plain, weighted) = windowed_segment(&layout, 5);
            // Until a creep at 1 Hz has died out.
            let (displacement, power) = rolled(&layout, &weighted, 12_000 / layout.length());
            let dissipated = compare(&layout, &plain, &response(), VibrationField::Tread, &displacement);
            let error = (dissipated / power - 1.0).abs();
            assert!(error < 1e-6, "{rule:?}, {advance}: {power} W put in, error {error:e}");
        }
    }
}

#[test]
fn all_fields_of_rules_with_stages_are_those_of_the_time_domain() {
    let tyre = Scene::from_str(PLATE, "default").unwrap().scene.tyre;
    let top = layout(ELEMENTS, 1, 1, 0).angular_frequency(ELEMENTS / 2);
    let tangential = tangential_model(&tyre, model(), top).unwrap();
    let response = TyreResponse { tangential: Some(&tangential), ..response() };
    for rule in [TimeRule::Sdirk2, TimeRule::Sdirk3] {
        for (advance, revolutions, phase) in CASES {
            let layout = SegmentLayout { rule, ..layout(ELEMENTS, advance, revolutions, phase) };
            let (plain, weighted) = windowed_segment(&layout, 6);
            for field in [VibrationField::Tread, VibrationField::Belt, VibrationField::Tangential] {
                compare(&layout, &plain, &response, field, &periodic(&layout, &weighted, field, &tangential));
            }
        }
    }
}
