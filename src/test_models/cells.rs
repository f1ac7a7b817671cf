//! A tread of the default size by cells, and a road under it.

use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::plate_tyre;
use crate::scene::{Law, Sides};
use crate::tyre::influence::{CellGrid, CellInfluence, CellSums, CellTruncation};

/// Circumference of the tyre \[m\].
const CIRCUMFERENCE: f64 = 1.95;
/// Width of the tyre \[m\].
const TYRE_WIDTH: f64 = 0.136;
/// Width of the strip of cells \[m\].
const STRIP_WIDTH: f64 = 0.111;
/// Shear modulus of the tread \[Pa\], its Poisson's ratio and its density \[kg/m^3\].
const TREAD: [f64; 3] = [3.7e6, 0.49, 1000.0];

/// Influence between the cells of a window, `elements` round the tyre, within one time step \[s\]; the tread is so deep
/// that it acts on all waves as a half-space.
pub fn instant_cells(columns: usize, across: usize, elements: usize, time_step: f64) -> CellInfluence {
    let [shear, poisson, density] = TREAD;
    let mut tyre = plate_tyre();
    tyre.layers.drain(..tyre.layers.len() - 1);
    let tread = &mut tyre.layers[0];
    tread.thickness = 1.0;
    let material = &mut tread.material;
    (material.law, material.modulus) = (Law::Elastic, 2.0 * shear * (1.0 + poisson));
    (material.poisson, material.density) = (poisson, density);
    (tyre.circumference, tyre.width, tyre.contact_width) = (CIRCUMFERENCE, TYRE_WIDTH, STRIP_WIDTH);
    tyre.sides = Sides::Guided;
    let rate = 3.41 / time_step;
    let grid = CellGrid::new(&tyre, elements, across);
    CellSums::new(&tyre, grid, CellTruncation::default(), 1e-8, rate).instant(rate, columns)
}

/// [`instant_cells`] of a made-up tyre that turns: waves of even part E have the odd part `skew` sin(k dx) E.
#[cfg(test)]
pub(crate) fn turning_cells(
    columns: usize,
    across: usize,
    elements: usize,
    time_step: f64,
    skew: f64,
) -> CellInfluence {
    let CellInfluence { mut toeplitz, mut hankel, .. } = instant_cells(columns + 1, across, elements, time_step);
    let odd = |each: usize, values: &mut Vec<f64>| -> Vec<f64> {
        let value = |place: usize| values[place];
        // sin(k dx) is the difference of two neighbours; at distance 0 they are the same.
        let at = |place: usize| if place < each { 0.0 } else { value(place + each) - value(place - each) };
        let odd = (0..columns * each).map(|place| 0.5 * skew * at(place)).collect();
        values.truncate(columns * each);
        odd
    };
    let odd = crate::tyre::influence::OddInfluence {
        toeplitz: odd(across, &mut toeplitz),
        hankel: odd(2 * across - 1, &mut hankel),
    };
    CellInfluence { columns, across, toeplitz, hankel, odd: Some(odd) }
}

/// A road of random waves under a round tyre.
pub struct RoughRoad {
    /// Wavenumbers along and across \[rad/m\], amplitude \[m\], phase \[rad\].
    waves: Vec<[f64; 4]>,
}

impl RoughRoad {
    /// 300 waves of lengths from 4 mm to 0.1 m in random directions, 0.3 mm rms in all; the same for the same seed.
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

    /// Required displacements \[m\] of a window that has moved on by `moved` columns, column by column; about a quarter
    /// of the cells touch.
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
