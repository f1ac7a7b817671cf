//! The history of cells as convolution sums: the reference, for as many waves and lags as can be waited for.
//!
//! By wave,
//!
//! ```text
//! u_a,l = sum_b sum_p W_ab,p F_b,l-p,     sum_p W_ab,p zeta^p = C_ab(Delta(zeta)/dt)
//! ```
//!
//! for any quadrature: W_ab,p is a number, or a matrix over the stages of a step (Lubich & Ostermann 1993, *Math.
//! Comp.* 60, 105). C_ab of a matrix is Lagrange's polynomial through its eigenvalues, which are the rule's rates.
//! C_ab = E + i O at n >= 0, and W = W(E) + i W(O) with real weights each; at rest every pair has one of both alone,
//! normal forces E.

use num_complex::Complex64;
use rayon::prelude::*;
use realfft::RealFftPlanner;

use super::component_transforms::ComponentTransforms;
use super::wave_transform::WaveTransform;
use super::zone::CellHistory;
use crate::counters::{Meter, Stage, Work};
use crate::numeric::in_parallel;
use crate::storage::state::{Evolving, StateError, StateStream};
use crate::time_rule::TimeRule;
use crate::tyre::influence::convolution_quadrature::ContourCircle;
use crate::tyre::influence::{COMPONENTS, CellRow, CellSums, CellSumsAt, CellWave, FaceValues, PAIRS, TractionParts};

/// Part of the influence that is not 0: of displacements `to` by forces `from`.
#[derive(Clone, Copy)]
struct MatrixPart {
    to: usize,
    from: usize,
    is_odd: bool,
}

/// Waves on the whole tyre and the forces of all steps that count, of `C` components.
pub struct DirectCellHistory<const C: usize> {
    transforms: ComponentTransforms<f64, C>,
    stages: usize,
    lags: usize,
    parts: Vec<MatrixPart>,
    /// Weights wave by wave, lag by lag, by stage of the displacement, stage of the force, and part \[m/N\].
    weights: Vec<f64>,
    /// Forces \[N\] of steps modulo the lags, stage by stage, wave by wave.
    forces: Vec<[Complex64; C]>,
    /// Number of this step.
    step: usize,
    sum: Vec<[Complex64; C]>,
}

impl DirectCellHistory<1> {
    /// Past of normal forces at rest, over `lags` lags, lag 0 included.
    pub fn new(
        sums: &CellSums,
        rows: &[CellRow],
        transform: WaveTransform,
        rule: TimeRule,
        time_step: f64,
        lags: usize,
    ) -> Self {
        let kinds: &[bool] = if sums.turns() { &[false, true] } else { &[false] };
        let parts = kinds.iter().map(|&is_odd| MatrixPart { to: 0, from: 0, is_odd }).collect();
        let values = |wave: &CellWave, at: &[CellSumsAt]| {
            let mut faces = Vec::with_capacity(at.len());
            sums.values(wave, at, &mut faces);
            let of = |is_odd: bool| move |faces: &FaceValues| if is_odd { faces.odd[0] } else { faces.driven };
            kinds.iter().map(|&is_odd| faces.iter().map(of(is_odd)).collect()).collect()
        };
        let weights = weights(sums, rows, rule, time_step, lags, values);
        Self::at_rest(transform.into(), rule.stages(), lags, parts, weights)
    }
}

impl DirectCellHistory<COMPONENTS> {
    /// Past of tractions at rest, over `lags` lags, lag 0 included.
    pub(crate) fn of_tractions(
        sums: &CellSums,
        rows: &[CellRow],
        transforms: ComponentTransforms<f64, COMPONENTS>,
        rule: TimeRule,
        time_step: f64,
        lags: usize,
    ) -> Self {
        let kinds: Vec<(usize, bool)> = (0..PAIRS)
            .flat_map(|pair| [(pair, false), (pair, true)])
            .filter(|&(pair, is_odd)| sums.turns() || TractionParts::is_even_at_rest(pair) != is_odd)
            .collect();
        let part =
            |&(pair, is_odd): &(usize, bool)| MatrixPart { to: pair / COMPONENTS, from: pair % COMPONENTS, is_odd };
        let parts = kinds.iter().map(part).collect();
        let values = |wave: &CellWave, at: &[CellSumsAt]| {
            let all: Vec<TractionParts> = at.iter().map(|at| sums.traction_parts(wave, at)).collect();
            let of = |&(pair, is_odd): &(usize, bool)| {
                all.iter().map(|parts| if is_odd { parts.odd[pair] } else { parts.even[pair] }).collect()
            };
            kinds.iter().map(of).collect()
        };
        let weights = weights(sums, rows, rule, time_step, lags, values);
        Self::at_rest(transforms, rule.stages(), lags, parts, weights)
    }
}

impl<const C: usize> DirectCellHistory<C> {
    fn at_rest(
        transforms: ComponentTransforms<f64, C>,
        stages: usize,
        lags: usize,
        parts: Vec<MatrixPart>,
        weights: Vec<f64>,
    ) -> Self {
        let (waves, zero) = (transforms.waves(), [Complex64::ZERO; C]);
        let (forces, sum) = (vec![zero; lags * stages * waves], vec![zero; waves]);
        Self { transforms, stages, lags, parts, weights, forces, step: 0, sum }
    }
}

impl<const C: usize> CellHistory<C> for DirectCellHistory<C> {
    fn add_displacement(&mut self, stage: usize, first_element: i64, out: &mut [[f64; C]], meter: &mut Meter) {
        let Self { transforms, stages, lags, parts, weights, forces, step, sum } = self;
        if stage == 0 {
            let products = weights.len() as u64;
            meter.add_work(Stage::History, Work { multiply_adds: 2 * products, bytes: 8 * 3 * products });
        }
        let (stages, waves) = (*stages, sum.len());
        let last = (*lags - 1).min(*step);
        let of_wave = *lags * stages * stages * parts.len();
        sum.par_iter_mut().enumerate().for_each(|(wave, sum)| {
            let weights = &weights[wave * of_wave..(wave + 1) * of_wave];
            let [mut even, mut odd] = [[Complex64::ZERO; C]; 2];
            for lag in 0..=last {
                let row = (*step - lag) % *lags;
                let known = if lag == 0 { stage } else { stages };
                for earlier in 0..known {
                    let force = &forces[(row * stages + earlier) * waves + wave];
                    let weights = &weights[((lag * stages + stage) * stages + earlier) * parts.len()..];
                    for (part, weight) in parts.iter().zip(weights) {
                        let kind = if part.is_odd { &mut odd } else { &mut even };
                        kind[part.to] += weight * force[part.from];
                    }
                }
            }
            *sum = std::array::from_fn(|component| even[component] + Complex64::i() * odd[component]);
        });
        for (component, spectrum) in transforms.spectra_mut().into_iter().enumerate() {
            spectrum.iter_mut().zip(&*sum).for_each(|(value, sum)| *value = sum[component]);
        }
        transforms.add_inverse(first_element, out);
    }

    fn push(&mut self, stage: usize, first_element: i64, forces: &[[f64; C]]) -> bool {
        let waves = self.sum.len();
        let row = (self.step % self.lags * self.stages + stage) * waves;
        self.transforms.forward(first_element, forces);
        let spectra = self.transforms.spectra();
        for (wave, force) in self.forces[row..row + waves].iter_mut().enumerate() {
            *force = spectra.map(|spectrum| spectrum[wave]);
        }
        self.step += usize::from(stage + 1 == self.stages);
        true
    }
}

impl<const C: usize> Evolving for DirectCellHistory<C> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.step, &mut self.forces])
    }
}

/// Weights of all waves \[m/N\], lags 0 to `lags` - 1; `values` are those of a wave at the rates, part by part \[m/N\].
fn weights(
    sums: &CellSums,
    rows: &[CellRow],
    rule: TimeRule,
    time_step: f64,
    lags: usize,
    values: impl Fn(&CellWave, &[CellSumsAt]) -> Vec<Vec<Complex64>> + Sync,
) -> Vec<f64> {
    let stages = rule.stages();
    let circle = ContourCircle::new(lags);
    let points: Vec<Complex64> = circle.points().collect();
    let rates: Vec<_> = points.iter().map(|&zeta| rule.rates(zeta)).collect();
    let at: Vec<CellSumsAt> =
        rates.iter().flat_map(|rates| rates.all().iter().map(|rate| sums.at(rate / time_step))).collect();
    let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(circle.length);
    let of_wave = |wave: &&CellWave| {
        let parts = values(wave, &at);
        let mut weights = vec![0.0; lags * stages * stages * parts.len()];
        let (mut spectra, mut signal) = (vec![inverse.make_input_vec(); stages * stages], inverse.make_output_vec());
        for (part, values) in parts.iter().enumerate() {
            for (k, ((&zeta, rates), values)) in points.iter().zip(&rates).zip(values.chunks_exact(stages)).enumerate()
            {
                let matrix = matrix_function(rule.symbol_matrix(zeta), rates.all(), values);
                for (place, spectrum) in spectra.iter_mut().enumerate() {
                    spectrum[k] = matrix[place / stages][place % stages];
                }
            }
            for (place, spectrum) in spectra.iter_mut().enumerate() {
                let last = spectrum.len() - 1;
                (spectrum[0].im, spectrum[last].im) = (0.0, 0.0);
                // Planned lengths, and the ends are real: nothing to refuse.
                let _ = inverse.process(spectrum, &mut signal);
                for (lag, &value) in signal.iter().enumerate().take(lags) {
                    weights[(lag * stages * stages + place) * parts.len() + part] = circle.scale(lag) * value;
                }
            }
        }
        weights
    };
    let waves: Vec<&CellWave> = rows.iter().flat_map(|row| &row.waves).collect();
    in_parallel::map(&waves, of_wave).concat()
}

/// f(M) from M's eigenvalues and f at these: sum_i f_i prod_(k != i) (M - mu_k)/(mu_i - mu_k).
fn matrix_function(
    matrix: [[Complex64; 3]; 3],
    eigenvalues: &[Complex64],
    values: &[Complex64],
) -> [[Complex64; 3]; 3] {
    let mut result = [[Complex64::ZERO; 3]; 3];
    for (i, (&eigenvalue, &value)) in eigenvalues.iter().zip(values).enumerate() {
        let mut product = [[Complex64::ZERO; 3]; 3];
        (0..3).for_each(|k| product[k][k] = value);
        for (_, &other) in eigenvalues.iter().enumerate().filter(|(k, _)| *k != i) {
            let mut factor = matrix;
            (0..3).for_each(|k| factor[k][k] -= other);
            let scale = (eigenvalue - other).inv();
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
