//! Contributions of the tread's waves, and of the parts of its circumference, to the pressure at a receiver.
//!
//! For a unit force at the contact's centre the integral over the tread is a sum over wavenumbers n, and also one over
//! pieces of the circumference:
//!
//! ```text
//! p = sum_n p_n,      p_n = sum_m,j f_nmj Int w_j G exp(i kx_n x) cos(ky_m y) dS
//! p = sum_c p_c,      p_c = sum_m g_m(c) sum_n,j f_nmj Int_c w_j exp(i kx_n x) dx
//! ```
//!
//! (rings of a flank that moves add to both as further m) with f_nmj the tyre's response to the force
//! ([`PressureModel`]), w_j the weights that the air's motion requires and g_m(c) the integral of G cos(ky_m y) across
//! the tread at the cell c. The share of a part is Re(p_part conj(p))/|p|^2. Shares add up to one. A part that is not
//! in phase with the whole has a small share or a negative one, and others more than one: they cancel each other.
//!
//! Cost of a frequency: one transform round the tyre for each lateral number.

use num_complex::{Complex32, Complex64};
use rustfft::FftPlanner;

use super::model::PressureModel;
use super::surface::{Shape, SurfaceGreen, WEIGHTS, WaveIntegrals};
use crate::numeric::{SplitRule, double};

/// Largest deviation from one of a running sum of shares that is called enough.
pub(crate) const ENOUGH: f64 = 0.1;

/// Pressure at a receiver for a unit force at the contact's centre, and its contributions \[Pa/N\].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PressureShares {
    /// Pressure, the sum of all contributions; its only delay is the sound's travel time from the contact.
    pub pressure: Complex64,
    /// Contributions by wavenumber n, from -[`Self::most`] on. Positive n run against the rolling direction.
    pub waves: Vec<Complex64>,
    /// Contributions by cell round the tyre; the first cell begins under the axle, the others follow in the rolling
    /// direction.
    pub cells: Vec<Complex64>,
    /// Contributions by part of the tyre, in the order of [`Self::PARTS`].
    pub parts: [Complex64; 3],
}

impl PressureShares {
    /// Names of the parts; shoulders and sides contribute 0 where they are not modelled.
    pub(crate) const PARTS: [&'static str; 3] = ["tread", "shoulders", "sides"];

    /// Pressure at G's frequency of an index; `model` gives the tyre, not the frequency.
    pub(crate) fn at(model: &PressureModel, green: &SurfaceGreen, index: usize) -> Self {
        let frequency = green.frequencies[index];
        let (weights, shapes) = (model.weights(), model.shapes());
        let integrals = WaveIntegrals::new(green, model.waves.waves, &shapes, weights);
        let most = integrals.most_under(&model.layout) as i64;
        let strip = model.strip();
        let (mut flows, around) = (model.flow_buffer(), green.around);
        let mut known = vec![Complex32::ZERO; integrals.count()];
        integrals.of(green, index, &mut integrals.buffers(), &mut known);
        let mut factors = vec![Complex64::ZERO; integrals.of_wave()];
        // By shape, the sum over n of its waves, as coefficients of a transform round the tyre.
        // 1. Sum over wavenumbers, which also gives the sum over parts.
        let mut turning = vec![Complex64::ZERO; shapes.len() * around];
        let mut parts = vec![Complex64::ZERO; shapes.len()];
        let waves: Vec<Complex64> = (-most..=most)
            .map(|n| {
                let seen = [frequency, model.layout.material_frequency(frequency, n)];
                model.factors_at(seen, n, model.mean_over_element(n), &strip, &mut flows, &mut factors);
                let row = (n + integrals.most_around() as i64) as usize;
                for (index, factor) in factors.iter().enumerate() {
                    let turning = &mut turning[index / weights * around..][..around];
                    for (near, share) in (n - 1..).zip(WEIGHTS[index % weights]) {
                        turning[near.rem_euclid(around as i64) as usize] += factor * (share * integrals.mean(near));
                    }
                }
                let known = &known[row * integrals.of_wave()..][..integrals.of_wave()];
                let each = || factors.iter().zip(known).map(|(factor, known)| factor * double(*known));
                for (index, part) in each().enumerate() {
                    parts[index / weights] += part;
                }
                each().sum()
            })
            .collect();
        // 2. Sum over cells: of each shape its motion by cell times G's integral across.
        let transform = FftPlanner::new().plan_fft_inverse(around);
        let mut cells = vec![Complex64::ZERO; around];
        let mut across = vec![Complex64::ZERO; around];
        for (shape, turning) in turning.chunks_exact_mut(around).enumerate() {
            transform.process(turning);
            integrals.across(green, index, shape, &mut across);
            for (cell, (across, motion)) in cells.iter_mut().zip(across.iter().zip(turning)) {
                *cell += across * *motion;
            }
        }
        // 3. Shapes to parts of the tyre.
        let of = |is: fn(&Shape) -> bool| {
            shapes.iter().zip(&parts).filter(|(shape, _)| is(shape)).map(|(_, part)| part).sum::<Complex64>()
        };
        let parts = [
            of(|shape| matches!(shape, Shape::Tread(_))),
            of(|shape| matches!(shape, Shape::Ring { number, .. } if *number < SplitRule::FIRST)),
            of(|shape| matches!(shape, Shape::Ring { number, .. } if *number >= SplitRule::FIRST)),
        ];
        Self { pressure: waves.iter().sum(), waves, cells, parts }
    }

    pub(crate) fn most(&self) -> usize {
        self.waves.len() / 2
    }

    /// Share of each wavenumber, from -[`Self::most`] on.
    pub(crate) fn of_waves(&self) -> Vec<f64> {
        self.waves.iter().map(|&part| self.share(part)).collect()
    }

    pub(crate) fn of_parts(&self) -> [f64; 3] {
        self.parts.map(|part| self.share(part))
    }

    /// Level of each part relative to the whole \[dB\]; minus infinity for a part without contribution.
    pub(crate) fn levels_of_parts(&self) -> [f64; 3] {
        self.parts.map(|part| 20.0 * (part.norm() / self.pressure.norm()).log10())
    }

    /// Share of all waves up to each |n|, from 0 on.
    pub(crate) fn up_to_wave(&self) -> Vec<f64> {
        let (most, shares) = (self.most(), self.of_waves());
        let both = |n: usize| if n == 0 { shares[most] } else { shares[most - n] + shares[most + n] };
        (0..=most).map(both).scan(0.0, running).collect()
    }

    /// Share of everything from the top of the tyre round by the rear and the contact as far as each of `angles` evenly
    /// spaced angles, the last of which is the top again.
    pub(crate) fn up_to_angle(&self, angles: usize) -> Vec<f64> {
        let around = self.cells.len();
        let behind = &self.cells[around / 2..];
        let from_top: Vec<f64> =
            behind.iter().chain(&self.cells[..around / 2]).map(|&part| self.share(part)).scan(0.0, running).collect();
        // The angles do not fall on ends of cells: interpolated linearly.
        let at = |angle: usize| {
            let place = (angle + 1) as f64 / angles as f64 * around as f64;
            let below = place.floor() as usize;
            let value = |cells: usize| cells.checked_sub(1).map_or(0.0, |last| from_top[last.min(around - 1)]);
            value(below) + (place - below as f64) * (value(below + 1) - value(below))
        };
        (0..angles).map(at).collect()
    }

    /// Smallest |n| from which on the share of all waves so far stays within [`ENOUGH`] of one.
    pub(crate) fn enough_waves(&self) -> usize {
        enough(&self.up_to_wave())
    }

    /// The angle to either side of the contact for which the same holds \[degrees\].
    pub(crate) fn enough_angle(&self) -> f64 {
        let (ahead, behind) = self.cells.split_at(self.cells.len() / 2);
        let both = ahead.iter().zip(behind.iter().rev()).map(|(ahead, behind)| self.share(ahead + behind));
        let within: Vec<f64> = both.scan(0.0, running).collect();
        360.0 * (enough(&within) + 1) as f64 / self.cells.len() as f64
    }

    fn share(&self, part: Complex64) -> f64 {
        (part * self.pressure.conj()).re / self.pressure.norm_sqr()
    }
}

/// First index from which on the running sum stays within [`ENOUGH`] of one; the last at most.
fn enough(so_far: &[f64]) -> usize {
    so_far.iter().rposition(|share| (share - 1.0).abs() > ENOUGH).map_or(0, |last| (last + 1).min(so_far.len() - 1))
}

fn running(sum: &mut f64, value: f64) -> Option<f64> {
    *sum += value;
    Some(*sum)
}
