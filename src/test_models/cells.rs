//! A tread of the default size by cells, and a road under it.

use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::numeric::sinc;

/// Circumference of the tyre \[m\].
const CIRCUMFERENCE: f64 = 1.95;
/// Width of the tyre \[m\].
const TYRE_WIDTH: f64 = 0.136;
/// Width of the strip of cells \[m\].
const STRIP_WIDTH: f64 = 0.111;
/// Shear modulus of the tread \[Pa\], its Poisson's ratio and its density \[kg/m^3\].
const TREAD: [f64; 3] = [3.7e6, 0.49, 1000.0];

/// Compliance of an elastic half-space at a rate \[1/s\] and a wavenumber's square.
fn compliance(rate: f64, squared: f64) -> f64 {
    let [mu, nu, density] = TREAD;
    let lambda = 2.0 * mu * nu / (1.0 - 2.0 * nu);
    let inertia = density * rate * rate;
    let alpha = (squared + inertia / (lambda + 2.0 * mu)).sqrt();
    let beta_squared = squared + inertia / mu;
    let rayleigh = (squared + beta_squared).powi(2) - 4.0 * squared * alpha * beta_squared.sqrt();
    alpha * (beta_squared - squared) / (mu * rayleigh)
}

/// T and H of a window of cells, `elements` round the tyre, within one time step \[s\].
pub fn instant_cells(columns: usize, across: usize, elements: usize, time_step: f64) -> [Vec<f64>; 2] {
    let rate = 3.41 / time_step;
    let (dx, dy) = (CIRCUMFERENCE / elements as f64, STRIP_WIDTH / across as f64);
    let (waves_along, waves_across) = (2 * elements, 16 * across);
    let folded = 2 * across - 1;
    let [mut toeplitz, mut hankel] = [vec![0.0; columns * across], vec![0.0; columns * folded]];
    let cosines: Vec<f64> = (0..elements).map(|n| (TAU * n as f64 / elements as f64).cos()).collect();
    let along: Vec<[f64; 2]> = (0..=waves_along)
        .map(|n| {
            let k = TAU * n as f64 / CIRCUMFERENCE;
            [k * k, if n == 0 { 1.0 } else { 2.0 } * sinc(0.5 * k * dx).powi(2)]
        })
        .collect();
    let mut sums = vec![0.0; columns];
    for m in 0..waves_across {
        let k = PI * m as f64 / TYRE_WIDTH;
        let weight = if m == 0 { 0.5 } else { 1.0 } * sinc(0.5 * k * dy).powi(2) / (CIRCUMFERENCE * TYRE_WIDTH);
        sums.fill(0.0);
        for (n, [squared, share]) in along.iter().enumerate() {
            let value = weight * share * compliance(rate, squared + k * k);
            let mut place = 0;
            for sum in &mut sums {
                *sum += value * cosines[place];
                place = (place + n) % elements;
            }
        }
        for (i, sum) in sums.iter().enumerate() {
            for (j, value) in toeplitz[i * across..(i + 1) * across].iter_mut().enumerate() {
                *value += sum * (k * j as f64 * dy).cos();
            }
            for (j, value) in hankel[i * folded..(i + 1) * folded].iter_mut().enumerate() {
                *value += sum * (k * (TYRE_WIDTH - STRIP_WIDTH + (j + 1) as f64 * dy)).cos();
            }
        }
    }
    [toeplitz, hankel]
}

/// A road of random waves under a round tyre.
pub struct RoughRoad {
    /// Wavenumbers along and across, amplitude, phase.
    waves: Vec<[f64; 4]>,
}

impl RoughRoad {
    /// Waves from 4 mm to 0.1 m, 0.3 mm rms.
    pub fn new(seed: u64) -> Self {
        const WAVES: usize = 300;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut wave = || {
            let length = 0.004 * 25.0_f64.powf(random.random());
            let direction = PI * random.random::<f64>();
            let k = TAU / length;
            [k * direction.cos(), k * direction.sin(), length.sqrt(), TAU * random.random::<f64>()]
        };
        let mut waves: Vec<[f64; 4]> = (0..WAVES).map(|_| wave()).collect();
        let power: f64 = waves.iter().map(|wave| 0.5 * wave[2] * wave[2]).sum();
        waves.iter_mut().for_each(|wave| wave[2] *= 3e-4 / power.sqrt());
        Self { waves }
    }

    /// Required displacements of a window that has moved on by so many columns; about a quarter of the cells touch.
    pub fn required(&self, columns: usize, across: usize, elements: usize, moved: usize) -> Vec<f64> {
        let (dx, dy) = (CIRCUMFERENCE / elements as f64, STRIP_WIDTH / across as f64);
        let reach = 0.5 * columns as f64;
        let cell = |n: usize| {
            let (i, j) = (n / across, n % across);
            let (x, y) = ((i + moved) as f64 * dx, j as f64 * dy);
            let height: f64 =
                self.waves.iter().map(|[kx, ky, size, phase]| size * (kx * x + ky * y + phase).cos()).sum();
            let place = (i as f64 + 0.5 - reach) / reach;
            1e-4 + height - 1.8e-3 * place * place
        };
        (0..columns * across).map(cell).collect()
    }
}
