//! A tyre that turns, whose waves have other frequencies forwards than backwards, against its modes, each stepped
//! in the time domain.

use super::time_domain::{CASES, compare};
use super::*;
use crate::time_rule::RungeKutta;
use crate::tyre::poles::TangentialModel;
use crate::tyre::poles::model::Entry;

/// Fields that a mode moves: driven face, inner face, driven face along.
const FIELDS: [VibrationField; 3] = [VibrationField::Tread, VibrationField::Belt, VibrationField::Tangential];

/// A mode a' = lambda a + F_n of the wave n, alone: its conjugate is a mode of -n. It moves a field by R a, the tread
/// along by i R a.
#[derive(Clone, Copy, Debug)]
struct Mode {
    pole: Complex64,
    residues: [Complex64; 3],
}

/// Modes of n = 0..=N/2, and constants of the part that follows the force at once.
struct TurningRing {
    modes: Vec<Vec<Mode>>,
    constants: Vec<[Complex64; 3]>,
}

impl TurningRing {
    fn new() -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(77);
        let half = ELEMENTS / 2;
        let mut ring = Self { modes: Vec::new(), constants: Vec::new() };
        for n in 0..=half {
            let mut number = |from: f64, to: f64| random.random_range(from..to);
            let mut mode = |frequency: f64| {
                let pole = Complex64::new(-number(40.0, 90.0), frequency);
                Mode { pole, residues: [(); 3].map(|()| Complex64::new(number(-1.0, 1.0), number(-1.0, 1.0))) }
            };
            let upwards = 150.0 + 90.0 * n as f64;
            let mirror = n == 0 || n == half;
            let modes = if mirror {
                // Real motion: pairs, and no part along that is odd in n.
                let mut one = mode(upwards);
                one.residues[2] *= Complex64::i();
                let other = Mode { pole: one.pole.conj(), residues: one.residues.map(|residue| residue.conj()) };
                let along = -other.residues[2];
                let [tread, belt, _] = other.residues;
                let mut creep = mode(0.0);
                creep.residues[..2].iter_mut().for_each(|residue| residue.im = 0.0);
                creep.residues[2].re = 0.0;
                vec![one, Mode { residues: [tread, belt, along], ..other }, creep]
            } else {
                // Forwards, backwards, an overdamped one that turns, and a creep.
                vec![mode(1.3 * upwards), mode(-0.7 * upwards), mode(25.0), mode(0.0)]
            };
            let along = Complex64::new(if mirror { 0.0 } else { number(-2e-3, 2e-3) }, number(-2e-3, 2e-3));
            ring.constants.push([number(0.0, 2e-3).into(), number(0.0, 2e-3).into(), along]);
            ring.modes.push(modes);
        }
        ring
    }

    /// The even and odd parts over the same poles, in the form of a fit.
    fn model(&self) -> (RationalModel, TangentialModel) {
        let mut tangential = TangentialModel::default();
        let entries = self.modes.iter().zip(&self.constants).map(|(modes, constants)| {
            let mirror = modes.len() == 3;
            let mut stored: Vec<(Complex64, [[Complex64; 2]; 3])> = Vec::new();
            for mode in modes.iter().filter(|mode| !mirror || mode.pole.im >= 0.0) {
                let (pole, below) = if mode.pole.im < 0.0 { (mode.pole.conj(), true) } else { (mode.pole, false) };
                let parts = [0, 1, 2].map(|field| {
                    let residue = mode.residues[field];
                    match (mirror, field, below) {
                        // The whole function is even, or, along, the other part.
                        (true, 2, _) => [Complex64::ZERO, residue / Complex64::i()],
                        (true, ..) => [residue, Complex64::ZERO],
                        (false, ..) if pole.im == 0.0 => [residue.re.into(), residue.im.into()],
                        (false, _, false) => [residue / 2.0, residue / (2.0 * Complex64::i())],
                        (false, _, true) => [residue / 2.0, residue / (2.0 * Complex64::i())].map(|part| part.conj()),
                    }
                });
                stored.push((pole, parts));
            }
            // Pairs come first.
            stored.sort_by_key(|(pole, _)| pole.im == 0.0);
            let part = |field: usize, part: usize| stored.iter().map(|(_, parts)| parts[field][part]).collect();
            tangential.residues.push(part(2, 0));
            tangential.odd_residues.push(part(2, 1));
            tangential.constants.push(constants[2].re);
            tangential.odd_constants.push(constants[2].im);
            Entry {
                poles: stored.iter().map(|(pole, _)| *pole).collect(),
                residues: [part(0, 0), part(1, 0)],
                odd: [part(0, 1), part(1, 1)],
                constants: [constants[0].re, constants[1].re],
                ..Entry::default()
            }
        });
        let model = RationalModel::assemble(ELEMENTS, Field::Surface, 1e4, 1e-3, entries);
        (model, tangential)
    }

    /// Displacements by field of all elements at the ends of the steps over the last of many periods of the same
    /// forces, and the mean power that they put in over it \[W\].
    fn rolled(&self, layout: &SegmentLayout, forces: &[f64]) -> ([Vec<Vec<f64>>; 3], f64) {
        let SegmentLayout { rule, advance, .. } = *layout;
        let (length, stages) = (layout.length(), layout.stages());
        // Until a creep of 40/s has died out.
        let periods = 900 / length + 2;
        let mut fields = [(); 3].map(|()| vec![vec![0.0; ELEMENTS]; length * stages]);
        for (n, (modes, constants)) in self.modes.iter().zip(&self.constants).enumerate() {
            let turn = |element: usize| Complex64::from_polar(1.0, 2.0 * PI * (n * element) as f64 / ELEMENTS as f64);
            let wave = |(instant, row): (usize, &[f64])| -> Complex64 {
                let first = advance.elements((layout.phase + instant / stages) as i64) as usize;
                row.iter().enumerate().map(|(column, force)| force * turn(first + column).conj()).sum()
            };
            let waves: Vec<Complex64> = forces.chunks_exact(COLUMNS).enumerate().map(wave).collect();
            let mut motion: Vec<[Complex64; 3]> =
                waves.iter().map(|wave| constants.map(|constant| constant * wave)).collect();
            for mode in modes {
                let states = match rule.runge_kutta() {
                    Some(method) => steps_of_stages(method, mode.pole, &waves, periods),
                    None => steps(rule, mode.pole, &waves, periods),
                };
                for (motion, state) in motion.iter_mut().zip(states) {
                    motion.iter_mut().zip(mode.residues).for_each(|(sum, residue)| *sum += residue * state);
                }
            }
            // The wave and that of -n, its conjugate; for the longest and the shortest it is the same.
            let twice = if n == 0 || 2 * n == ELEMENTS { 1.0 } else { 2.0 };
            for (instant, [tread, belt, along]) in motion.into_iter().enumerate() {
                for (rows, value) in fields.iter_mut().zip([tread, belt, Complex64::i() * along]) {
                    assert!(twice > 1.0 || value.im.abs() < 1e-9, "n = {n}: real forces move it by {value}");
                    for (element, sum) in rows[instant].iter_mut().enumerate() {
                        *sum += twice * (value * turn(element)).re;
                    }
                }
            }
        }
        let power = put_in(layout, forces, &fields[0]);
        // The ends of the steps.
        (fields.map(|rows| rows.into_iter().skip(stages - 1).step_by(stages).collect()), power)
    }
}

/// Mean power that forces put in over a period of displacements \[W\].
fn put_in(layout: &SegmentLayout, forces: &[f64], displacement: &[Vec<f64>]) -> f64 {
    let (length, stages) = (layout.length(), layout.stages());
    // More elements on either side: one that enters the window carries no force yet, as in a run.
    let margin = 2 * layout.advance.elements_per_step;
    let mut power = ContactPower::new(layout.rule, TIME_STEP, COLUMNS + 2 * margin);
    let mut work = 0.0;
    for step in 0..2 * length {
        let first = layout.advance.elements((layout.phase + step) as i64);
        let (mut window, mut wide) = (Vec::new(), Vec::new());
        let rows = forces[step % length * layout.width()..][..layout.width()].chunks_exact(COLUMNS);
        for (stage, row) in rows.enumerate() {
            let all = &displacement[step % length * stages + stage];
            window.extend(
                (-(margin as i64)..(COLUMNS + margin) as i64)
                    .map(|c| all[(first + c).rem_euclid(ELEMENTS as i64) as usize]),
            );
            wide.extend(vec![0.0; margin].iter().chain(row).chain(&vec![0.0; margin]));
        }
        let put_in = power.push(first - margin as i64, &wide, &window);
        work += if step >= length { put_in } else { 0.0 };
    }
    work / length as f64
}

/// States of a' = lambda a + F under a multistep rule, over the last period.
fn steps(rule: TimeRule, pole: Complex64, forces: &[Complex64], periods: usize) -> Vec<Complex64> {
    let (mut one, mut two, mut before) = (Complex64::ZERO, Complex64::ZERO, Complex64::ZERO);
    let z = pole * TIME_STEP;
    let mut step = |force: Complex64| {
        let f = force * TIME_STEP;
        let now = match rule {
            TimeRule::Bdf1 => (one + f) / (1.0 - z),
            TimeRule::Bdf2 => (2.0 * one - 0.5 * two + f) / (1.5 - z),
            _ => (one + 0.5 * (z * one + before + f)) / (1.0 - 0.5 * z),
        };
        (two, one, before) = (one, now, f);
        now
    };
    (0..periods).map(|_| forces.iter().map(|&force| step(force)).collect()).last().unwrap()
}

/// The same under a Runge-Kutta rule, at all stages.
fn steps_of_stages(method: RungeKutta, pole: Complex64, forces: &[Complex64], periods: usize) -> Vec<Complex64> {
    let (a, stages) = (method.matrix(), method.nodes.len());
    let mut state = Complex64::ZERO;
    let mut step = |forces: &[Complex64]| -> Vec<Complex64> {
        let mut rates = [Complex64::ZERO; 3];
        let mut values = Vec::new();
        for i in 0..stages {
            let base: Complex64 = state + (0..i).map(|k| TIME_STEP * a[i][k] * rates[k]).sum::<Complex64>();
            rates[i] = (pole * base + forces[i]) / (1.0 - a[i][i] * pole * TIME_STEP);
            values.push(base + TIME_STEP * a[i][i] * rates[i]);
        }
        state = values[stages - 1];
        values
    };
    (0..periods).map(|_| forces.chunks_exact(stages).flat_map(&mut step).collect()).last().unwrap()
}

#[test]
fn fields_of_a_turning_tyre_are_those_of_the_time_domain() {
    let ring = TurningRing::new();
    let (model, tangential) = ring.model();
    assert!(model.turns());
    let response = TyreResponse { model: &model, scale: 1.0, spring: 0.0, tangential: Some(&tangential) };
    for rule in TimeRule::ALL {
        for (advance, revolutions, phase) in CASES {
            let layout = SegmentLayout { rule, ..layout(ELEMENTS, advance, revolutions, phase) };
            let (plain, weighted) = windowed_segment(&layout, 5);
            let (displacements, power) = ring.rolled(&layout, &weighted);
            for (field, displacement) in FIELDS.into_iter().zip(&displacements) {
                let dissipated = compare(&layout, &plain, &response, field, displacement);
                if field == VibrationField::Tread {
                    let error = (dissipated - power).abs() / power.abs();
                    assert!(error < 1e-6, "{rule:?}, {advance}: {power} W put in, error {error:e}");
                }
            }
        }
    }
}
