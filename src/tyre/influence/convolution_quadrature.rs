//! Convolution quadrature: time-domain weights that inherit the tyre's passivity.
//!
//! u(t_l) = sum_p w_p F(t_(l-p)) with sum_p w_p zeta^p = H(delta(zeta)/dt) (Lubich 1988, *Numer. Math.* 52, 129 and
//! 413). The weights are causal by construction; for an A-stable rule they are passive where H is.
//!
//! 1. evaluate H on the circle |zeta| = rho < 1 at K points (the lower half follows by conjugation);
//! 2. inverse FFT, divide by rho^p. With rho^K = eps the values wrapped round from lag p + K are eps times their size,
//!    and rounding errors grow by rho^-p <= eps^-1/2 over the lags p < K/2 that are used.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicBool, Ordering};

use num_complex::Complex64;
use rayon::prelude::*;
use realfft::RealFftPlanner;

use super::folded_sum::InfluenceSum;
use super::kernel::Field;
use crate::time_rule::TimeRule;

/// Wrap-around relative to itself: rho^K.
const WRAPPED: f64 = 1e-12;

/// The circle |zeta| = rho on which so many weights are sampled.
#[derive(Clone, Copy, Debug)]
pub struct Circle {
    /// K, the points all round.
    pub length: usize,
    /// rho.
    pub radius: f64,
}

impl Circle {
    /// For lags 0..`lags`.
    pub fn new(lags: usize) -> Self {
        let length = (2 * lags).next_power_of_two().max(16);
        Self { length, radius: WRAPPED.powf(1.0 / length as f64) }
    }

    /// zeta_k for k = 0..=K/2.
    pub fn points(&self) -> impl Iterator<Item = Complex64> + use<> {
        let Self { length, radius } = *self;
        (0..=length / 2).map(move |k| Complex64::from_polar(radius, -2.0 * PI * k as f64 / length as f64))
    }

    /// Returns the factor from the sum over all points to the weight of a lag.
    pub fn scale(&self, lag: usize) -> f64 {
        self.radius.powi(-(lag as i32)) / self.length as f64
    }
}

/// The points s_k on the circle for lags 0..`lags`.
#[derive(Clone, Debug)]
pub struct Contour {
    /// s_k for k = 0..=K/2 \[1/s\].
    pub points: Vec<Complex64>,
    /// The circle.
    pub circle: Circle,
}

impl Contour {
    /// The contour for a rule, a time step \[s\] and a number of lags.
    pub fn new(rule: TimeRule, time_step: f64, lags: usize) -> Self {
        let circle = Circle::new(lags);
        Self { points: circle.points().map(|zeta| rule.symbol(zeta) / time_step).collect(), circle }
    }
}

/// Weights per wavenumber, in the order of lags.
#[derive(Clone, Debug)]
pub struct Weights {
    /// Row n = 0..=N/2, column p = 0..lags: w_(n,p) \[m/N\].
    pub values: Vec<f64>,
    /// Number of lags kept.
    pub lags: usize,
    /// Static influence Ht_n(0), n = 0..=N/2 \[m/N\].
    pub at_rest: Vec<f64>,
    /// Evaluations of the compliance that it took.
    pub evaluations: u64,
}

impl Weights {
    /// Sums Ht_n on the contour for n = 0..=N/2 in parallel and transforms each to `lags` weights.
    pub fn new(sum: &InfluenceSum, field: Field, rule: TimeRule, time_step: f64, lags: usize) -> Self {
        Self::summed(sum, field, rule, time_step, lags, &AtomicBool::new(false))
    }

    /// As [`Self::new`], but looks at `stop` before every wavenumber; `None` if it was set.
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

    /// The weights; what comes after `stop` was set stays zero.
    fn summed(
        sum: &InfluenceSum,
        field: Field,
        rule: TimeRule,
        time_step: f64,
        lags: usize,
        stop: &AtomicBool,
    ) -> Self {
        let contour = Contour::new(rule, time_step, lags);
        let at: Vec<_> = sum.at_all(&contour.points);
        let at_rest = sum.at(Complex64::ZERO);
        let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(contour.circle.length);
        let rows = sum.projection().elements / 2 + 1;
        let scale: Vec<f64> = (0..lags).map(|p| contour.circle.scale(p)).collect();
        let mut values = vec![0.0; rows * lags];
        let (at_rest, evaluations): (Vec<f64>, Vec<u64>) = values
            .par_chunks_mut(lags)
            .enumerate()
            .map_init(
                || (inverse.make_input_vec(), inverse.make_output_vec(), inverse.make_scratch_vec(), Vec::new()),
                |(spectrum, signal, scratch, faces), (n, row)| {
                    if stop.load(Ordering::Relaxed) {
                        return (0.0, 0);
                    }
                    let mut evaluations = 0;
                    if sum.in_lockstep(field) {
                        faces.clear();
                        sum.faces(n, &at, field, faces);
                        for (entry, faces) in spectrum.iter_mut().zip(faces.iter()) {
                            *entry = faces.driven;
                            evaluations += faces.evaluations;
                        }
                    } else {
                        for (entry, at) in spectrum.iter_mut().zip(&at) {
                            let value = sum.value(n, at, field);
                            *entry = value.value;
                            evaluations += value.evaluations;
                        }
                    }
                    // The two real points of the circle.
                    spectrum[0].im = 0.0;
                    spectrum[contour.circle.length / 2].im = 0.0;
                    // Lengths match by construction; a mismatch would leave zeros that the weight check below the sum
                    // reveals.
                    let _ = inverse.process_with_scratch(spectrum, signal, scratch);
                    for ((weight, &sample), &factor) in row.iter_mut().zip(signal.iter()).zip(&scale) {
                        *weight = sample * factor;
                    }
                    let rest = sum.value(n, &at_rest, field);
                    (rest.value.re, evaluations + rest.evaluations)
                },
            )
            .unzip();
        Self { values, lags, evaluations: evaluations.iter().sum(), at_rest }
    }

    /// w_(n,p) for all lags p.
    pub fn of(&self, n: usize) -> &[f64] {
        &self.values[n * self.lags..(n + 1) * self.lags]
    }

    /// The part of the static influence that lies beyond the lags kept, relative to the static influence: since
    /// sum_p w_p = H(0), the truncation of the memory is measured, not guessed.
    pub fn truncated(&self) -> f64 {
        let total: f64 = self.at_rest.iter().sum();
        let kept: f64 = self.values.iter().sum();
        ((total - kept) / total).abs()
    }
}
