//! Amplitudes by order k of the revolution: k V/L in frequency. A segment is one revolution, so that what turns with
//! the tyre falls on whole orders and a window is not needed.

use num_complex::Complex64;
use rustfft::FftPlanner;

use crate::storage::state::{Evolving, StateError, StateStream, ensure};

/// Sums over revolutions of a quantity that is sampled at the steps.
#[derive(Clone, Debug)]
pub(crate) struct Orders {
    /// Values of the revolution not yet complete.
    current: Vec<f64>,
    /// Steps per revolution.
    steps: usize,
    /// Sum of the values by step of the revolution.
    sum: Vec<f64>,
    /// Sum of the squared amplitudes by order.
    squares: Vec<f64>,
    /// Complete revolutions.
    count: u32,
}

pub(crate) struct Order {
    /// Number k of the order; 0 is the mean.
    pub order: usize,
    /// Frequency \[Hz\] at the tyre's rotational speed.
    pub frequency: f64,
    /// Root mean square of the order, all revolutions.
    pub all: f64,
    /// Root mean square of the part that repeats in each revolution.
    pub repeated: f64,
}

impl Orders {
    /// Sums for revolutions of `steps` steps.
    pub(crate) fn new(steps: usize) -> Self {
        let squares = vec![0.0; steps / 2 + 1];
        Self { current: Vec::with_capacity(steps), steps, sum: vec![0.0; steps], squares, count: 0 }
    }

    /// Memory \[bytes\] for revolutions of `steps` steps.
    pub(crate) fn bytes(steps: usize) -> f64 {
        20.0 * steps as f64
    }

    /// Takes the next value; the last of a revolution transforms it.
    pub(crate) fn push(&mut self, value: f64) {
        self.current.push(value);
        if self.current.len() < self.steps {
            return;
        }
        let squares = transform(&self.current).into_iter().map(|amplitude| amplitude.norm_sqr());
        self.squares.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
        self.sum.iter_mut().zip(&self.current).for_each(|(sum, value)| *sum += value);
        self.count += 1;
        self.current.clear();
    }

    /// Orders of a tyre that turns `rate` times a second; `None` before the first revolution is complete.
    pub(crate) fn found(&self, rate: f64) -> Option<Vec<Order>> {
        let count = f64::from(self.count);
        let mean: Vec<f64> = self.sum.iter().map(|sum| sum / count).collect();
        let orders = self.squares.iter().zip(transform(&mean)).enumerate().map(|(order, (square, mean))| {
            // Power of both signs of the frequency; the mean and the Nyquist frequency are there once.
            let both = if order == 0 || 2 * order == self.steps { 1.0_f64 } else { 2.0 };
            let all = (both * square / count).sqrt();
            Order { order, frequency: order as f64 * rate, all, repeated: both.sqrt() * mean.norm() }
        });
        (self.count > 0).then(|| orders.collect())
    }
}

impl Evolving for Orders {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.growing(&mut self.current)?;
        ensure(self.current.len() < self.steps)?;
        state.all([&mut self.sum, &mut self.squares, &mut self.count])
    }
}

/// Complex amplitudes of a revolution at the whole orders 0 to half the number of steps.
fn transform(revolution: &[f64]) -> Vec<Complex64> {
    let mut values: Vec<Complex64> = revolution.iter().map(|value| Complex64::new(*value, 0.0)).collect();
    FftPlanner::new().plan_fft_forward(values.len()).process(&mut values);
    let scale = 1.0 / values.len() as f64;
    values.truncate(revolution.len() / 2 + 1);
    values.iter_mut().for_each(|value| *value *= scale);
    values
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn repeated_and_unrepeated_parts_are_separated() {
        let (steps, mut orders) = (48, Orders::new(48));
        assert!(orders.found(1.0).is_none());
        for n in 0..4 * steps {
            let turn = n as f64 / steps as f64;
            // Order 5 of 2 N, and one of 3 N at order 7 that changes its sign each time.
            let sign = if (n / steps) % 2 == 0 { 1.0 } else { -1.0 };
            orders.push(10.0 + 2.0 * (TAU * 5.0 * turn).cos() + sign * 3.0 * (TAU * 7.0 * turn).sin());
        }
        let found = orders.found(2.0).unwrap();
        assert_eq!(found.len(), 25);
        for of in &found {
            let (all, repeated) = match of.order {
                0 => (10.0, 10.0),
                5 => (2.0_f64.sqrt(), 2.0_f64.sqrt()),
                7 => (4.5_f64.sqrt(), 0.0),
                _ => (0.0, 0.0),
            };
            assert!((of.all - all).abs() < 1e-12 && (of.repeated - repeated).abs() < 1e-12, "{}", of.order);
            assert!((of.frequency - 2.0 * of.order as f64).abs() < 1e-12);
        }
    }
}
