//! Channels of a wave that still contribute a block after a force.
//!
//! The displacement by a channel after a given number of steps is sampled on the unit circle, relative to the norm of
//! the wave's matrix there, of its components relative to their largest values. The channels that contribute least go,
//! as long as the sum of all that are left out stays within a part of the tolerance.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::time_rule::TimeRule;
use crate::tyre::influence::{COMPONENTS, PAIRS};
use crate::tyre::poles::traction_model::TractionModel;

/// Samples, and the lowest frequency in parts of the highest.
const SAMPLES: usize = 16;
const LOWEST: f64 = 1e-4;
/// Part of the largest norm below which errors are not relative to it.
const LEAST_SCALE: f64 = 3e-3;
/// Part of the tolerance that may be left out.
const LEFT_OUT: f64 = 0.3;

/// A frequency on the unit circle.
struct Sample {
    /// Displacement of each channel and of its conjugate, of unit residue, after the steps.
    late: Vec<[Complex64; 2]>,
    /// Scale of errors.
    size: f64,
}

/// Adds a channel's residue times its values to a matrix.
fn add(matrix: &mut [Complex64; PAIRS], residues: &[Complex64; PAIRS], [upper, lower]: [Complex64; 2]) {
    for (value, residue) in matrix.iter_mut().zip(residues) {
        *value += residue * upper + residue.conj() * lower;
    }
}

/// Which channels of a wave contribute more than `passed` steps after a force, to within a tolerance.
pub(super) fn late_channels(
    model: &TractionModel,
    wave: usize,
    rule: TimeRule,
    time_step: f64,
    passed: usize,
    tolerance: f64,
) -> Vec<bool> {
    let (poles, pairs, channels) = model.wave(wave);
    let (count, parts) = (poles.len(), if model.turns() { 2 } else { 1 });
    // 1. Residues of the even parts, then of the odd ones, relative to the components' values at rest.
    let residues: Vec<[[Complex64; PAIRS]; 2]> = channels
        .iter()
        .map(|channel| {
            [channel.output, channel.odd]
                .map(|output| std::array::from_fn(|pair| output[pair / COMPONENTS] * channel.input[pair % COMPONENTS]))
        })
        .collect();
    let mut resting = [Complex64::ZERO; PAIRS];
    for (index, (pole, residues)) in poles.iter().zip(&residues).enumerate() {
        let lower = if index < pairs { (-pole.conj()).inv() } else { Complex64::ZERO };
        add(&mut resting, &residues[0], [(-pole).inv(), lower]);
    }
    let root = |component: usize| resting[component * (COMPONENTS + 1)].norm().max(f64::MIN_POSITIVE).sqrt();
    let scales: [f64; PAIRS] = std::array::from_fn(|pair| (root(pair / COMPONENTS) * root(pair % COMPONENTS)).recip());
    let residues: Vec<[[Complex64; PAIRS]; 2]> = residues
        .into_iter()
        .map(|parts| parts.map(|part| std::array::from_fn(|pair| part[pair] * scales[pair])))
        .collect();
    let norm = |matrix: &[Complex64; PAIRS]| matrix.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
    // 2. By sample: displacement by each channel after the steps, and the norm of the whole matrix.
    let sample = |number: usize| {
        let angle = PI * LOWEST.powf(number as f64 / (SAMPLES - 1) as f64);
        let zeta = Complex64::cis(-angle);
        let s = rule.symbol(zeta) / time_step;
        let mut whole = [[Complex64::ZERO; PAIRS]; 2];
        let mut late = Vec::with_capacity(count);
        for (index, (&pole, residues)) in poles.iter().zip(&residues).enumerate() {
            let both = |pole: Complex64| [(s - pole).inv(), after(pole, rule, time_step, passed, zeta)];
            let [upper, late_upper] = both(pole);
            let [lower, late_lower] = if index < pairs { both(pole.conj()) } else { [Complex64::ZERO; 2] };
            whole.iter_mut().zip(residues).take(parts).for_each(|(whole, residue)| add(whole, residue, [upper, lower]));
            late.push([late_upper, late_lower]);
        }
        Sample { late, size: norm(&whole[0]).hypot(norm(&whole[1])) }
    };
    let mut samples: Vec<Sample> = (0..SAMPLES).map(sample).collect();
    let largest = samples.iter().fold(f64::MIN_POSITIVE, |largest, sample| largest.max(sample.size));
    samples.iter_mut().for_each(|sample| sample.size = sample.size.max(LEAST_SCALE * largest));
    let largest_share = |index: usize| {
        let size = norm(&residues[index][0]).hypot(norm(&residues[index][1]));
        let most = |sample: &Sample| {
            let [upper, lower] = sample.late[index];
            size * upper.norm().max(lower.norm()) / sample.size
        };
        samples.iter().map(most).fold(0.0, f64::max)
    };
    // 3. Leave out channels, those with the smallest contributions first, within the tolerance.
    let mut order: Vec<(f64, usize)> = (0..count).map(|index| (largest_share(index), index)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut late = vec![true; count];
    let mut sums = vec![[[Complex64::ZERO; PAIRS]; 2]; SAMPLES];
    for &(_, index) in &order {
        let mut error = 0.0_f64;
        for (sum, sample) in sums.iter_mut().zip(&samples) {
            sum.iter_mut()
                .zip(&residues[index])
                .take(parts)
                .for_each(|(sum, residue)| add(sum, residue, sample.late[index]));
            error = error.max(norm(&sum[0]).hypot(norm(&sum[1])) / sample.size);
        }
        if error > LEFT_OUT * tolerance {
            break;
        }
        late[index] = false;
    }
    late
}

/// Displacement by a pole of unit residue at a frequency, more than `passed` steps after its force.
fn after(pole: Complex64, rule: TimeRule, time_step: f64, passed: usize, zeta: Complex64) -> Complex64 {
    let (g, w) = rule.coefficients(pole, Complex64::ONE, time_step);
    let before = rule.before_last();
    let mut rest = w / (1.0 - g * (zeta - before * zeta * zeta));
    let (mut now, mut last, mut turn) = (w, Complex64::ZERO, Complex64::ONE);
    for _ in 0..=passed {
        rest -= now * turn;
        (now, last) = (g * (now - before * last), now);
        turn *= zeta;
    }
    rest
}
