//! Force by order k of the revolution: k V/L in frequency. A segment is one revolution, so that what turns with the
//! tyre falls on whole orders and a window is not needed.

use num_complex::Complex64;
use rustfft::FftPlanner;
use serde::{Deserialize, Serialize};

use crate::results::PlotError;
use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::table::csv;

/// Lowest level that is drawn, below the highest \[dB\].
const DEPTH: f64 = 80.0;

/// Sums over revolutions.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Orders {
    /// Forces of the revolution that goes on \[N\].
    current: Vec<f64>,
    /// Steps of a revolution.
    steps: usize,
    /// Sum of the forces by step of the revolution \[N\].
    sum: Vec<f64>,
    /// Sum of the squared amplitudes by order \[N^2\].
    squares: Vec<f64>,
    /// Revolutions.
    count: u32,
}

/// Force of an order.
pub(super) struct Order {
    order: usize,
    frequency: f64,
    /// Root mean square of all \[N\].
    force: f64,
    /// Root mean square of what comes again in each revolution \[N\].
    repeated: f64,
}

impl Orders {
    /// Makes the sums of revolutions of so many steps.
    pub(super) fn new(steps: usize) -> Self {
        let squares = vec![0.0; steps / 2 + 1];
        Self { current: Vec::with_capacity(steps), steps, sum: vec![0.0; steps], squares, count: 0 }
    }

    /// Returns the steps of a revolution.
    pub(super) fn steps(&self) -> usize {
        self.steps
    }

    /// Takes in a force.
    pub(super) fn push(&mut self, force: f64) {
        self.current.push(force);
        if self.current.len() < self.steps {
            return;
        }
        let squares = transform(&self.current).into_iter().map(|amplitude| amplitude.norm_sqr());
        self.squares.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
        self.sum.iter_mut().zip(&self.current).for_each(|(sum, force)| *sum += force);
        self.count += 1;
        self.current.clear();
    }

    /// Returns the orders, of a tyre of so many revolutions a second; `None` before the first revolution is complete.
    pub(super) fn found(&self, rate: f64) -> Option<Vec<Order>> {
        let count = f64::from(self.count);
        let mean: Vec<f64> = self.sum.iter().map(|sum| sum / count).collect();
        let orders = self.squares.iter().zip(transform(&mean)).enumerate().map(|(order, (square, mean))| {
            // One side of the spectrum; the mean itself has no other.
            let both = if order == 0 || 2 * order == self.steps { 1.0_f64 } else { 2.0 };
            let force = (both * square / count).sqrt();
            Order { order, frequency: order as f64 * rate, force, repeated: both.sqrt() * mean.norm() }
        });
        (self.count > 0).then(|| orders.collect())
    }
}

/// Returns the amplitudes of a revolution at whole orders.
fn transform(forces: &[f64]) -> Vec<Complex64> {
    let mut values: Vec<Complex64> = forces.iter().map(|force| Complex64::new(*force, 0.0)).collect();
    FftPlanner::new().plan_fft_forward(values.len()).process(&mut values);
    let scale = 1.0 / values.len() as f64;
    values.truncate(forces.len() / 2 + 1);
    values.iter_mut().for_each(|value| *value *= scale);
    values
}

/// Returns one row for each order.
pub(super) fn to_csv(orders: &[Order]) -> String {
    let header = ["order", "frequency_hz", "force_n", "repeated_force_n"];
    let line = |of: &Order| [of.order as f64, of.frequency, of.force, of.repeated];
    csv(header, orders.iter().map(line))
}

/// Draws the forces over the order.
///
/// # Errors
/// Errors of the picture.
pub(super) fn picture(orders: &[Order], title: &str) -> Result<String, PlotError> {
    // What is above a kilohertz or two is in the table.
    let shown = &orders[1..orders.len().min(1 + orders.len() / 2)];
    let level = |force: f64| 20.0 * force.max(f64::MIN_POSITIVE).log10();
    let highest = shown.iter().map(|of| level(of.force)).fold(-DEPTH, f64::max);
    let lowest = highest - DEPTH;
    let series = |name, value: fn(&Order) -> f64| Series {
        name,
        points: shown.iter().map(|of| (of.order as f64, level(value(of)).max(lowest))).collect(),
    };
    LinePlot {
        title,
        x: Axis::linear("Order of the revolution", 0.0..shown.len() as f64),
        y: Axis::linear("Contact force [dB re 1 N]", lowest..highest + 5.0),
        series: vec![series("all", |of| of.force), series("repeated", |of| of.repeated)],
    }
    .to_svg()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn what_comes_again_is_told_from_what_does_not() {
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
            assert!((of.force - all).abs() < 1e-12 && (of.repeated - repeated).abs() < 1e-12, "{}", of.order);
            assert!((of.frequency - 2.0 * of.order as f64).abs() < 1e-12);
        }
    }
}
