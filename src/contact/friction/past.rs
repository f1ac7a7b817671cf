//! Past of tractions as convolution sums, by wave:
//!
//! ```text
//! u_a,l = sum_b sum_p W_ab,p F_b,l-p,     sum_p W_ab,p zeta^p = C_ab(delta(zeta)/dt)
//! ```
//!
//! for rules of one stage. C_ab = E + i O at n >= 0, and W = W(E) + i W(O) with real weights each; at rest every pair
//! has one of both alone.

use num_complex::Complex64;
use rayon::prelude::*;
use realfft::RealFftPlanner;

use super::product::Vector;
use super::transform::TractionTransform;
use crate::counters::Work;
use crate::numeric::in_parallel;
use crate::storage::state::{Evolving, StateError, StateStream};
use crate::time_rule::TimeRule;
use crate::tyre::influence::convolution_quadrature::Circle;
use crate::tyre::influence::{COMPONENTS, CellRow, CellSums, CellWave, PAIRS, TractionParts};

/// Forces or displacements of a wave.
type WaveVector = [Complex64; COMPONENTS];

/// Waves on the whole tyre and the forces of all steps that count.
pub(crate) struct TractionPast {
    transform: TractionTransform,
    lags: usize,
    /// Parts of pairs that are not 0: pair, and true for the odd part.
    kept: Vec<(usize, bool)>,
    /// Weights wave by wave, lag by lag, part by part \[m/N\].
    weights: Vec<f64>,
    /// Forces \[N\] of steps modulo the lags, wave by wave.
    forces: Vec<WaveVector>,
    /// Number of this step.
    step: usize,
    sum: Vec<WaveVector>,
}

impl TractionPast {
    /// Past of a tyre at rest, over `lags` lags, lag 0 included.
    pub(crate) fn new(
        sums: &CellSums,
        rows: &[CellRow],
        transform: TractionTransform,
        rule: TimeRule,
        time_step: f64,
        lags: usize,
    ) -> Self {
        let kept: Vec<(usize, bool)> = (0..PAIRS)
            .flat_map(|pair| [(pair, false), (pair, true)])
            .filter(|&(pair, is_odd)| sums.turns() || TractionParts::is_even_at_rest(pair) != is_odd)
            .collect();
        let weights = weights(sums, rows, rule, time_step, lags, &kept);
        let waves = transform.waves();
        let zero = [Complex64::ZERO; COMPONENTS];
        Self { transform, lags, kept, weights, forces: vec![zero; lags * waves], step: 0, sum: vec![zero; waves] }
    }

    /// Work of a step.
    pub(crate) fn work(&self) -> Work {
        let products = self.weights.len() as u64;
        Work { multiply_adds: 2 * products, bytes: 24 * products }
    }

    /// Adds the displacements by past forces at the coming step \[m\].
    pub(crate) fn add_displacement(&mut self, first_element: i64, out: &mut [Vector]) {
        let Self { transform, lags, kept, weights, forces, step, sum } = self;
        let (waves, last) = (sum.len(), (*lags - 1).min(*step));
        let of_wave = *lags * kept.len();
        sum.par_iter_mut().enumerate().for_each(|(wave, sum)| {
            let weights = &weights[wave * of_wave..(wave + 1) * of_wave];
            let [mut even, mut odd] = [[Complex64::ZERO; COMPONENTS]; 2];
            for lag in 1..=last {
                let force = &forces[(*step - lag) % *lags * waves + wave];
                for ((pair, is_odd), weight) in kept.iter().zip(&weights[lag * kept.len()..]) {
                    let part = if *is_odd { &mut odd } else { &mut even };
                    part[pair / COMPONENTS] += weight * force[pair % COMPONENTS];
                }
            }
            *sum = std::array::from_fn(|component| even[component] + Complex64::i() * odd[component]);
        });
        for (component, spectrum) in transform.spectra_mut().enumerate() {
            spectrum.iter_mut().zip(&*sum).for_each(|(value, sum)| *value = sum[component]);
        }
        transform.add_inverse(first_element, out);
    }

    /// Takes the forces of the step \[N\].
    pub(crate) fn push(&mut self, first_element: i64, forces: &[Vector]) {
        let waves = self.sum.len();
        let row = self.step % self.lags * waves;
        self.transform.forward(first_element, forces);
        let spectra = self.transform.spectra();
        for (wave, force) in self.forces[row..row + waves].iter_mut().enumerate() {
            *force = spectra.map(|spectrum| spectrum[wave]);
        }
        self.step += 1;
    }
}

impl Evolving for TractionPast {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.step, &mut self.forces])
    }
}

/// Weights of all waves \[m/N\], p = 0..`lags`, of the parts that are kept.
fn weights(
    sums: &CellSums,
    rows: &[CellRow],
    rule: TimeRule,
    time_step: f64,
    lags: usize,
    kept: &[(usize, bool)],
) -> Vec<f64> {
    let circle = Circle::new(lags);
    let at: Vec<_> = circle.points().map(|zeta| sums.at(rule.symbol(zeta) / time_step)).collect();
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(circle.length);
    let of_wave = |wave: &&CellWave| -> Vec<f64> {
        let parts: Vec<TractionParts> = at.iter().map(|at| sums.traction_parts(wave, at)).collect();
        let (mut spectrum, mut signal) = (inverse.make_input_vec(), inverse.make_output_vec());
        let mut weights = vec![0.0; lags * kept.len()];
        for (place, &(pair, is_odd)) in kept.iter().enumerate() {
            for (value, parts) in spectrum.iter_mut().zip(&parts) {
                *value = if is_odd { parts.odd[pair] } else { parts.even[pair] };
            }
            let last = spectrum.len() - 1;
            (spectrum[0].im, spectrum[last].im) = (0.0, 0.0);
            // Planned lengths, and the ends are real: nothing to refuse.
            let _ = inverse.process(&mut spectrum, &mut signal);
            for (lag, value) in signal.iter().enumerate().take(lags) {
                weights[lag * kept.len() + place] = circle.scale(lag) * value;
            }
        }
        weights
    };
    let waves: Vec<&CellWave> = rows.iter().flat_map(|row| &row.waves).collect();
    in_parallel::map(&waves, of_wave).concat()
}
