//! Convolution quadrature: time-domain weights that inherit the tyre's passivity.
//!
//! u(t_l) = sum_p w_p F(t_(l-p)) with sum_p w_p zeta^p = H(delta(zeta)/dt) (Lubich 1988, *Numer. Math.* 52, 129 and
//! 413). The weights are causal by construction; for an A-stable rule they are passive where H is. Of a tyre that
//! turns, the even and the odd part of H_n = E_n + i O_n have separate weights: both are real at real s.
//!
//! 1. evaluate H on the circle |zeta| = rho < 1 at K points (the lower half follows by conjugation);
//! 2. inverse FFT, divide by rho^p. With rho^K = eps the values wrapped round from lag p + K are eps times their size,
//!    and rounding errors grow by rho^-p <= eps^-1/2 over the lags p < K/2 that are used.

use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use num_complex::Complex64;
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner};

use super::folded_sum::{InfluenceSum, InfluenceValue};
use super::kernel::Field;
use super::lane_sum::FaceValues;
use crate::time_rule::TimeRule;

/// Size of the values wrapped round, relative to the values: rho^K.
const WRAPPED: f64 = 1e-12;

/// The circle |zeta| = rho on which H is sampled for a number of weights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContourCircle {
    /// Number K of points on the whole circle.
    pub length: usize,
    /// Radius rho.
    pub radius: f64,
}

impl ContourCircle {
    /// For lags 0..`lags`: K at least twice as many, a power of two.
    pub(crate) fn new(lags: usize) -> Self {
        let length = (2 * lags).next_power_of_two().max(16);
        Self { length, radius: WRAPPED.powf(1.0 / length as f64) }
    }

    /// zeta_k for k = 0..=K/2; the lower half follows by conjugation.
    pub(crate) fn points(&self) -> impl Iterator<Item = Complex64> + use<> {
        let Self { length, radius } = *self;
        (0..=length / 2).map(move |k| Complex64::from_polar(radius, -2.0 * PI * k as f64 / length as f64))
    }

    /// Factor from the sum over all points to the weight of a lag: rho^-lag/K.
    pub(crate) fn scale(&self, lag: usize) -> f64 {
        self.radius.powi(-(lag as i32)) / self.length as f64
    }
}

/// Points s_k of a rule on the circle for lags 0..`lags`.
#[derive(Clone, Debug)]
pub(crate) struct Contour {
    /// s_k for k = 0..=K/2 \[1/s\].
    pub points: Vec<Complex64>,
    /// Their circle in the plane of zeta.
    pub circle: ContourCircle,
}

impl Contour {
    /// `time_step` in s.
    pub(crate) fn new(rule: TimeRule, time_step: f64, lags: usize) -> Self {
        let circle = ContourCircle::new(lags);
        Self { points: circle.points().map(|zeta| rule.symbol(zeta) / time_step).collect(), circle }
    }
}

/// Weights of convolution quadrature per wavenumber and lag.
#[derive(Clone, Debug)]
pub struct Weights {
    /// Row n = 0..=N/2, column p = 0..lags: w_(n,p) \[m/N\]; of a tyre that turns, of its even part E_n.
    pub values: Vec<f64>,
    /// Those of the odd part O_n, in the same order; empty at rest.
    pub odd: Vec<f64>,
    /// Number of lags stored, the columns of `values`.
    pub lags: usize,
    /// Static influence Ht_n(0), n = 0..=N/2 \[m/N\].
    pub at_rest: Vec<f64>,
    /// Evaluations of the compliance used.
    pub evaluations: u64,
}

impl Weights {
    /// Sums Ht_n on the contour for n = 0..=N/2 in parallel and transforms each to `lags` weights; `time_step` in s.
    pub fn new(sum: &InfluenceSum, field: Field, rule: TimeRule, time_step: f64, lags: usize) -> Self {
        Self::summed(sum, field, rule, time_step, lags, &AtomicBool::new(false))
    }

    /// As [`Self::new`], but checks `stop` before every wavenumber; `None` if it was set.
    pub fn unless_stopped(
        sum: &InfluenceSum,
        field: Field,
        rule: TimeRule,
        time_step: f64,
        lags: usize,
        stop: &AtomicBool,
    ) -> Option<Self> {
        let weights = Self::summed(sum, field, rule, time_step, lags, stop);
        (!stop.load(Ordering::Relaxed)).then_some(weights)
    }

    /// The weights; rows not yet begun when `stop` is set stay zero.
    fn summed(
        sum: &InfluenceSum,
        field: Field,
        rule: TimeRule,
        time_step: f64,
        lags: usize,
        stop: &AtomicBool,
    ) -> Self {
        // 1. The kernel on the contour, once for all wavenumbers.
        let contour = Contour::new(rule, time_step, lags);
        let at: Vec<_> = sum.at_all(&contour.points);
        let at_rest = sum.at(Complex64::ZERO);
        let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(contour.circle.length);
        let rows = sum.projection().elements / 2 + 1;
        let scale: Vec<f64> = (0..lags).map(|p| contour.circle.scale(p)).collect();
        let mut values = vec![0.0; rows * lags];
        let mut odd = vec![0.0; if sum.turns() { rows * lags } else { 0 }];
        let mut odd_rows: Vec<&mut [f64]> = odd.chunks_mut(lags).collect();
        odd_rows.resize_with(rows, Default::default);
        // 2. Each wavenumber: values on the circle, in lanes where possible, then the inverse transform.
        let (at_rest, evaluations): (Vec<f64>, Vec<u64>) = values
            .par_chunks_mut(lags)
            .zip(odd_rows)
            .enumerate()
            .map_init(
                || (FromCircle::new(&inverse), Vec::new(), Vec::new()),
                |(from_circle, values, faces), (n, (row, odd_row))| {
                    if stop.load(Ordering::Relaxed) {
                        return (0.0, 0);
                    }
                    values.clear();
                    if sum.in_lockstep(field) {
                        faces.clear();
                        sum.faces(n, &at, field, faces);
                        let of_face = |faces: &FaceValues| (faces.driven, faces.odd[0], faces.evaluations);
                        values.extend(faces.iter().map(of_face));
                    } else {
                        let of_value = |value: InfluenceValue| (value.value, value.odd, value.evaluations);
                        values.extend(at.iter().map(|at| of_value(sum.value(n, at, field))));
                    }
                    from_circle.weights(values.iter().map(|value| value.0), &scale, row);
                    if !odd_row.is_empty() {
                        from_circle.weights(values.iter().map(|value| value.1), &scale, odd_row);
                    }
                    let rest = sum.value(n, &at_rest, field);
                    let evaluations: u64 = values.iter().map(|value| value.2).sum();
                    (rest.value.re, evaluations + rest.evaluations)
                },
            )
            .unzip();
        Self { values, odd, lags, evaluations: evaluations.iter().sum(), at_rest }
    }

    /// w_(n,p) for all lags p \[m/N\].
    pub fn of(&self, n: usize) -> &[f64] {
        &self.values[n * self.lags..(n + 1) * self.lags]
    }

    /// Odd part of w_(n,p) for all lags p \[m/N\]; empty at rest.
    pub fn odd_of(&self, n: usize) -> &[f64] {
        self.odd.get(n * self.lags..(n + 1) * self.lags).unwrap_or_default()
    }

    /// Fraction of the static influence that lies beyond the lags stored: since sum_p w_p = H(0), the truncation of the
    /// memory is measured, not estimated.
    pub fn truncated(&self) -> f64 {
        let total: f64 = self.at_rest.iter().sum();
        let stored: f64 = self.values.iter().sum();
        ((total - stored) / total).abs()
    }
}

/// Transform from the values on a circle to weights, with its buffers.
struct FromCircle<'a> {
    inverse: &'a Arc<dyn ComplexToReal<f64>>,
    spectrum: Vec<Complex64>,
    signal: Vec<f64>,
    scratch: Vec<Complex64>,
}

impl<'a> FromCircle<'a> {
    fn new(inverse: &'a Arc<dyn ComplexToReal<f64>>) -> Self {
        let (spectrum, signal) = (inverse.make_input_vec(), inverse.make_output_vec());
        Self { inverse, spectrum, signal, scratch: inverse.make_scratch_vec() }
    }

    /// Weights of a function that is real at real s: `scale` times the inverse transform, lag by lag.
    fn weights(&mut self, values: impl Iterator<Item = Complex64>, scale: &[f64], weights: &mut [f64]) {
        self.spectrum.iter_mut().zip(values).for_each(|(entry, value)| *entry = value);
        // zeta = rho and -rho: real there but for rounding.
        let last = self.spectrum.len() - 1;
        (self.spectrum[0].im, self.spectrum[last].im) = (0.0, 0.0);
        // Lengths match by construction; a mismatch would leave zeros.
        let _ = self.inverse.process_with_scratch(&mut self.spectrum, &mut self.signal, &mut self.scratch);
        for ((weight, &sample), &factor) in weights.iter_mut().zip(&self.signal).zip(scale) {
            *weight = sample * factor;
        }
    }
}
