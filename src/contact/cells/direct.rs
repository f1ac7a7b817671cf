//! The past of cells as convolution sums: the reference, for as many waves and lags as can be waited for.
//!
//! By wave, u_l = sum_p W_p F_(l-p) with sum_p W_p zeta^p = H(Delta(zeta)/dt), for any quadrature: W_p is a number, or
//! a matrix over the stages of a step (Lubich & Ostermann 1993, *Math. Comp.* 60, 105). H of a matrix is Lagrange's
//! polynomial through its eigenvalues, which are the rule's rates. Of a tyre that turns H = E + i O at n >= 0, and W_p
//! = W_p(E) + i W_p(O) with real weights each.

use num_complex::Complex64;
use rayon::prelude::*;
use realfft::RealFftPlanner;

use super::wave_transform::WaveTransform;
use crate::counters::Work;
use crate::numeric::in_parallel;
use crate::storage::state::{Evolving, StateError, StateStream};
use crate::time_rule::TimeRule;
use crate::tyre::influence::convolution_quadrature::Circle;
use crate::tyre::influence::{CellRow, CellSums, CellSumsAt, CellWave, FaceValues};

/// Waves on the whole tyre and the forces of all steps that count.
pub struct DirectPast {
    transform: WaveTransform,
    stages: usize,
    lags: usize,
    /// W_p of each wave: wave by wave, lag by lag, row by row \[m/N\].
    weights: Vec<f64>,
    /// Those of odd parts; empty at rest.
    odd: Vec<f64>,
    /// Forces \[N\] of steps modulo the lags, stage by stage, wave by wave.
    forces: Vec<Complex64>,
    /// Number of this step.
    step: usize,
    sum: Vec<Complex64>,
}

impl DirectPast {
    /// Past at rest, over `lags` lags, lag 0 included.
    pub fn new(
        sums: &CellSums,
        rows: &[CellRow],
        transform: WaveTransform,
        rule: TimeRule,
        time_step: f64,
        lags: usize,
    ) -> Self {
        let (waves, stages) = (transform.waves(), rule.stages());
        let [weights, odd] = weights(sums, rows, rule, time_step, lags);
        let forces = vec![Complex64::ZERO; lags * stages * waves];
        Self { transform, stages, lags, weights, odd, forces, step: 0, sum: vec![Complex64::ZERO; waves] }
    }

    /// Work of a step.
    pub fn work(&self) -> Work {
        let products = (self.weights.len() + self.odd.len()) as u64;
        Work { multiply_adds: 2 * products, bytes: 8 * 3 * products }
    }

    /// Adds the displacements by past forces at a stage of the step \[m\]; stages are taken in their order, the forces
    /// of each pushed before the next.
    pub fn add_displacement(&mut self, stage: usize, first_element: i64, out: &mut [f64]) {
        let Self { transform, stages, lags, weights, odd, forces, step, sum } = self;
        let (stages, waves) = (*stages, sum.len());
        let last = (*lags - 1).min(*step);
        let of_wave = *lags * stages * stages;
        // The sum of a wave with some of its weights.
        let sum_of = |wave: usize, weights: &[f64]| {
            let mut sum = Complex64::ZERO;
            for lag in 0..=last {
                let row = (*step - lag) % *lags;
                let known = if lag == 0 { stage } else { stages };
                for earlier in 0..known {
                    let weight = weights[(lag * stages + stage) * stages + earlier];
                    sum += weight * forces[(row * stages + earlier) * waves + wave];
                }
            }
            sum
        };
        sum.par_iter_mut().enumerate().for_each(|(wave, sum)| {
            let own = wave * of_wave..(wave + 1) * of_wave;
            *sum = sum_of(wave, &weights[own.clone()]);
            if let Some(odd) = odd.get(own) {
                *sum += Complex64::i() * sum_of(wave, odd);
            }
        });
        transform.add_inverse(sum, first_element, out);
    }

    /// Takes the forces of a stage \[N\].
    pub fn push(&mut self, stage: usize, first_element: i64, forces: &[f64]) {
        let waves = self.sum.len();
        let row = (self.step % self.lags * self.stages + stage) * waves;
        self.transform.forward(first_element, forces, &mut self.forces[row..row + waves]);
        self.step += usize::from(stage + 1 == self.stages);
    }
}

impl Evolving for DirectPast {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.step, &mut self.forces])
    }
}

/// W_p of the even and, for a tyre that turns, of the odd parts of all waves, p = 0..`lags` \[m/N\].
fn weights(sums: &CellSums, rows: &[CellRow], rule: TimeRule, time_step: f64, lags: usize) -> [Vec<f64>; 2] {
    let stages = rule.stages();
    let circle = Circle::new(lags);
    let points: Vec<Complex64> = circle.points().collect();
    let rates: Vec<_> = points.iter().filter_map(|&zeta| rule.rates(zeta)).collect();
    let at: Vec<CellSumsAt> =
        rates.iter().flat_map(|rates| rates.all().iter().map(|rate| sums.at(rate / time_step))).collect();
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(circle.length);
    let of_values = |values: &[Complex64]| {
        let mut weights = vec![0.0; lags * stages * stages];
        let mut spectra = vec![inverse.make_input_vec(); stages * stages];
        for (k, ((&zeta, rates), values)) in points.iter().zip(&rates).zip(values.chunks_exact(stages)).enumerate() {
            let matrix = matrix_function(rule.symbol_matrix(zeta), rates.all(), values);
            for (place, spectrum) in spectra.iter_mut().enumerate() {
                spectrum[k] = matrix[place / stages][place % stages];
            }
        }
        let mut signal = inverse.make_output_vec();
        for (place, spectrum) in spectra.iter_mut().enumerate() {
            let last = spectrum.len() - 1;
            (spectrum[0].im, spectrum[last].im) = (0.0, 0.0);
            // Planned lengths, and the ends are real: nothing to refuse.
            let _ = inverse.process(spectrum, &mut signal);
            for (lag, &value) in signal.iter().enumerate().take(lags) {
                weights[lag * stages * stages + place] = circle.scale(lag) * value;
            }
        }
        weights
    };
    let of_wave = |wave: &CellWave| {
        let mut faces = Vec::with_capacity(at.len());
        sums.values(wave, &at, &mut faces);
        let values = |of: fn(&FaceValues) -> Complex64| -> Vec<Complex64> { faces.iter().map(of).collect() };
        let even = of_values(&values(|faces| faces.driven));
        (even, if sums.turns() { of_values(&values(|faces| faces.odd[0])) } else { Vec::new() })
    };
    let waves: Vec<&CellWave> = rows.iter().flat_map(|row| &row.waves).collect();
    let (even, odd): (Vec<_>, Vec<_>) = in_parallel::map(&waves, |wave| of_wave(wave)).into_iter().unzip();
    [even.concat(), odd.concat()]
}

/// f(M) from M's eigenvalues and f at these: sum_i f_i prod_(k != i) (M - mu_k)/(mu_i - mu_k).
fn matrix_function(
    matrix: [[Complex64; 3]; 3],
    eigenvalues: &[Complex64],
    values: &[Complex64],
) -> [[Complex64; 3]; 3] {
    let mut result = [[Complex64::ZERO; 3]; 3];
    for (i, (&own, &value)) in eigenvalues.iter().zip(values).enumerate() {
        let mut product = [[Complex64::ZERO; 3]; 3];
        (0..3).for_each(|k| product[k][k] = value);
        for (_, &other) in eigenvalues.iter().enumerate().filter(|(k, _)| *k != i) {
            let mut factor = matrix;
            (0..3).for_each(|k| factor[k][k] -= other);
            let scale = (own - other).inv();
            product = std::array::from_fn(|row| {
                std::array::from_fn(|column| {
                    (0..3).map(|k| product[row][k] * factor[k][column]).sum::<Complex64>() * scale
                })
            });
        }
        for (result, product) in result.as_flattened_mut().iter_mut().zip(product.as_flattened()) {
            *result += product;
        }
    }
    result
}
