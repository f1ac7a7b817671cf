//! The pressure at receivers for unit force at each place of the contact window.

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use rustfft::FftPlanner;

use super::surface::{SurfaceGreen, WaveIntegrals};
use crate::numeric::{sinc, single};
use crate::response::vibration::{SegmentLayout, TransferKind};
use crate::scene::AirMotion;
use crate::tyre::influence::SurfaceWaves;

/// Receivers whose transfers are made together: they share the tyre's waves.
const TOGETHER: usize = 16;
/// Part of the highest frequency over which the transfers fall to zero, so that they ring for a short time only.
const TAPER: f64 = 0.05;

/// What transfers are made of beside G.
#[derive(Clone, Copy, Debug)]
pub struct PressureModel<'a> {
    /// Segments in which forces are transformed; whole revolutions.
    pub layout: SegmentLayout,
    /// The tyre.
    pub waves: &'a SurfaceWaves,
    /// Factor of all compliances; 1 unless a bedding's carcass is scaled.
    pub scale: f64,
    /// Width b of the contact strip \[m\].
    pub contact_width: f64,
    /// Density of the air \[kg/m^3\].
    pub density: f64,
    /// What the air moves with.
    pub air: AirMotion,
    /// Highest frequency \[Hz\].
    pub highest: f64,
    /// By receiver, what is left of the propagation delay r0/c when whole time steps are taken off \[s\].
    pub delays: &'a [f64],
}

impl PressureModel<'_> {
    /// Bins 0..=highest of a segment that are radiated.
    pub fn bins(&self) -> usize {
        let last = (self.highest / self.layout.resolution()).floor() as usize;
        last.min(self.layout.length() / 2) + 1
    }

    /// Pressure at a bin for unit amplitude of the forces' component n at each stage, receiver by receiver: the waves'
    /// parts of G summed over m. Rows are n = -most..=most.
    fn components(&self, bin: usize, integrals: &[WaveIntegrals], delays: &[f64], out: &mut [Vec<Complex64>]) {
        let Self { layout, waves, .. } = self;
        let tyre = waves.waves;
        let lateral = waves.lateral.len();
        let frequency = bin as f64 * layout.resolution();
        let angular = std::f64::consts::TAU * frequency;
        // p = i w rho Int G v dS, v = -i w u: outwards.
        let radiated = angular * self.density * self.taper(frequency) * self.scale;
        // (e_m/B) a_m of each wave's part in the strip's force.
        let strip = |&m: &usize| tyre.lateral_norm(m) * tyre.lateral_share(m, self.contact_width);
        let weights: Vec<f64> = waves.lateral.iter().map(strip).collect();
        let most = integrals[0].most_around().min(layout.elements / 2 - 1) as i64;
        let mut compliance = vec![Complex64::ZERO; lateral];
        let mut shapes = vec![vec![Complex64::ZERO; (2 * integrals[0].most_around() + 1) * lateral]; integrals.len()];
        for (shape, integrals) in shapes.iter_mut().zip(integrals) {
            integrals.at(frequency, shape);
        }
        let late: Vec<Complex64> = delays.iter().map(|delay| Complex64::from_polar(1.0, -angular * delay)).collect();
        for n in -most..=most {
            let material_bin = layout.material_bin(bin, n);
            let material = material_bin as f64 * layout.resolution();
            self.compliances(n, material, &mut compliance);
            for (value, weight) in compliance.iter_mut().zip(&weights) {
                *value *= weight;
            }
            let rate = match self.air {
                AirMotion::Axle => angular,
                AirMotion::WithTread => {
                    angular - std::f64::consts::TAU * n as f64 * layout.revolutions as f64 * layout.resolution()
                }
            };
            let mean = sinc(0.5 * tyre.kx(n) * tyre.circumference / layout.elements as f64);
            let factor = radiated * rate * mean / tyre.circumference;
            let row = (n + integrals[0].most_around() as i64) as usize * lateral;
            for ((out, shape), late) in out.iter_mut().zip(&shapes).zip(&late) {
                let sum: Complex64 = shape[row..row + lateral].iter().zip(&compliance).map(|(g, c)| g * c).sum();
                out[n.rem_euclid(layout.elements as i64) as usize] = late * factor * sum;
            }
        }
    }

    /// C_nm at a frequency of the material, as the run's rule sees it.
    fn compliances(&self, n: i64, frequency: f64, out: &mut [Complex64]) {
        let rule = self.layout.rule;
        let angular = std::f64::consts::TAU * frequency;
        let symbol = TransferKind::Rule.symbol(rule, angular, self.layout.time_step);
        // The waves are known on the imaginary axis, where a multistep rule's s is nearly.
        let seen = if rule.is_multistep() { symbol.im / std::f64::consts::TAU } else { frequency };
        self.waves.at(n, seen, out);
    }

    /// What a unit force at the window's first column is to the component of each index at a bin; the transform over
    /// the elements goes on to the other columns.
    fn acts(
        &self,
        stages: &impl Fn(usize, i64) -> Complex64,
        bin: usize,
        stage: usize,
        phase: usize,
    ) -> Vec<Complex64> {
        let SegmentLayout { elements, substeps, circumference, first_position, .. } = self.layout;
        let first = first_position - circumference * phase as f64 / (elements * substeps) as f64;
        let act = |index: usize| {
            let n = signed(index, elements);
            let turn = -std::f64::consts::TAU * n as f64 * first / circumference;
            Complex64::from_polar(1.0, turn) * stages(stage, self.layout.material_bin(bin, n))
        };
        (0..elements).map(act).collect()
    }

    fn taper(&self, frequency: f64) -> f64 {
        let into = ((frequency / self.highest - (1.0 - TAPER)) / TAPER).clamp(0.0, 1.0);
        0.5 * (1.0 + (std::f64::consts::PI * into).cos())
    }
}

/// Pressures for unit force, receiver by receiver, place by place, bin by bin \[Pa/N\].
#[derive(Clone, Debug)]
pub struct PlaceTransfers {
    /// Receivers.
    pub receivers: usize,
    /// Places: (stage x columns + column) x substeps + substep.
    pub places: usize,
    /// Bins from 0.
    pub bins: usize,
    values: Vec<Complex32>,
}

impl PlaceTransfers {
    /// Bytes of the transfers of so many receivers.
    pub fn bytes(layout: &SegmentLayout, bins: usize, receivers: usize) -> f64 {
        8.0 * (layout.places() * bins * receivers) as f64
    }

    /// For receivers with these G, all of the same cells.
    pub fn new(model: &PressureModel<'_>, greens: &[SurfaceGreen]) -> Self {
        let (layout, bins) = (model.layout, model.bins());
        let (places, elements) = (layout.places(), layout.elements);
        let mut values = vec![Complex32::ZERO; greens.len() * places * bins];
        let transform = FftPlanner::<f64>::new().plan_fft_forward(elements);
        let stages = stage_weights(&layout);
        let groups = greens.chunks(TOGETHER).zip(model.delays.chunks(TOGETHER));
        for (group, (greens, delays)) in groups.enumerate() {
            let waves = model.waves;
            let integrals: Vec<WaveIntegrals> =
                greens.par_iter().map(|green| WaveIntegrals::new(green, waves.waves, &waves.lateral)).collect();
            // By bin, then turned over: a bin is a thread's, a place is what is summed over.
            let mut by_bin = vec![Complex32::ZERO; bins * integrals.len() * places];
            by_bin.par_chunks_mut(integrals.len() * places).enumerate().for_each(|(bin, out)| {
                let mut components = vec![vec![Complex64::ZERO; elements]; integrals.len()];
                model.components(bin, &integrals, delays, &mut components);
                let mut row = vec![Complex64::ZERO; elements];
                let mut scratch = vec![Complex64::ZERO; transform.get_inplace_scratch_len()];
                for (stage, phase) in pairs(layout.stages(), layout.substeps) {
                    let acts = model.acts(&stages, bin, stage, phase);
                    for (components, out) in components.iter().zip(out.chunks_exact_mut(places)) {
                        for ((value, component), act) in row.iter_mut().zip(components).zip(&acts) {
                            *value = component * act;
                        }
                        transform.process_with_scratch(&mut row, &mut scratch);
                        for (column, value) in row[..layout.columns].iter().enumerate() {
                            let place = (stage * layout.columns + column) * layout.substeps + phase;
                            out[place] = single(*value);
                        }
                    }
                }
            });
            for (bin, rows) in by_bin.chunks_exact(integrals.len() * places).enumerate() {
                for (index, value) in rows.iter().enumerate() {
                    let row = group * TOGETHER * places + index;
                    values[row * bins + bin] = *value;
                }
            }
        }
        Self { receivers: greens.len(), places, bins, values }
    }

    /// Some, for tests: by receiver, place and bin.
    #[cfg(test)]
    pub(super) fn of(
        receivers: usize,
        places: usize,
        bins: usize,
        value: impl Fn(usize, usize, usize) -> Complex64,
    ) -> Self {
        let rows =
            pairs(receivers, places).flat_map(|(receiver, place)| (0..bins).map(move |bin| (receiver, place, bin)));
        let values = rows.map(|(receiver, place, bin)| single(value(receiver, place, bin))).collect();
        Self { receivers, places, bins, values }
    }

    /// The transfer from a place to a receiver, bin by bin \[Pa/N\].
    pub fn row(&self, receiver: usize, place: usize) -> &[Complex32] {
        let first = (receiver * self.places + place) * self.bins;
        &self.values[first..first + self.bins]
    }
}

fn pairs(first: usize, second: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..first).flat_map(move |a| (0..second).map(move |b| (a, b)))
}

/// n of an index of a transform of length N.
fn signed(index: usize, elements: usize) -> i64 {
    if 2 * index > elements { index as i64 - elements as i64 } else { index as i64 }
}

/// What the force of a stage counts, turned by the time from the step's end at which it acts, at a bin of the material.
fn stage_weights(layout: &SegmentLayout) -> impl Fn(usize, i64) -> Complex64 + Sync + use<> {
    let stages = layout.actions();
    let step = std::f64::consts::TAU * layout.resolution();
    move |stage, bin| {
        let [weight, time] = stages[stage];
        Complex64::from_polar(weight, -step * bin as f64 * time)
    }
}
