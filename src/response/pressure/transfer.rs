//! The pressure at receivers for unit force at each place of the contact window.
//!
//! What all receivers share, the tyre's compliances and how a place acts, is found once for each bin. The rest are
//! products of real matrices in single precision, whose rows are the receivers: over the lateral waves and the
//! frequencies that G is interpolated between, then over the wavenumbers to the window's columns. They are made for the
//! bins between two of G's frequencies at a time.

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use super::components::Components;
use super::surface::{SurfaceGreen, interpolation};
use super::window::Window;
use crate::numeric::sinc;
use crate::response::vibration::{SegmentLayout, TransferKind};
use crate::scene::AirMotion;
use crate::tyre::influence::SurfaceWaves;

/// Most bins whose components are in memory together.
const TOGETHER: usize = 32;
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

    /// (e_m/B) a_m of each wave's part in the strip's force.
    pub(super) fn strip(&self) -> Vec<f64> {
        let tyre = self.waves.waves;
        let part = |&m: &usize| tyre.lateral_norm(m) * tyre.lateral_share(m, self.contact_width);
        self.waves.lateral.iter().map(part).collect()
    }

    /// What makes pressure at a bin of the integrals of G, m by m, for unit amplitude of the forces' component n at each
    /// stage; `strip` is [`Self::strip`].
    pub(super) fn factors(&self, bin: usize, n: i64, strip: &[f64], out: &mut [Complex64]) {
        let Self { layout, waves, .. } = self;
        let tyre = waves.waves;
        let frequency = bin as f64 * layout.resolution();
        let angular = std::f64::consts::TAU * frequency;
        // p = i w rho Int G v dS, v = -i w u: outwards.
        let radiated = angular * self.density * self.taper(frequency) * self.scale;
        self.compliances(n, layout.material_bin(bin, n) as f64 * layout.resolution(), out);
        let rate = match self.air {
            AirMotion::Axle => angular,
            AirMotion::WithTread => {
                angular - std::f64::consts::TAU * n as f64 * layout.revolutions as f64 * layout.resolution()
            }
        };
        let mean = sinc(0.5 * tyre.kx(n) * tyre.circumference / layout.elements as f64);
        let factor = radiated * rate * mean / tyre.circumference;
        out.iter_mut().zip(strip).for_each(|(value, strip)| *value *= factor * strip);
    }

    /// By receiver, what the rest of its delay is at a bin.
    pub(super) fn late(&self, bin: usize) -> impl Iterator<Item = Complex64> {
        let angular = self.layout.angular_frequency(bin);
        self.delays.iter().map(move |delay| Complex64::from_polar(1.0, -angular * delay))
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

    fn taper(&self, frequency: f64) -> f64 {
        let into = ((frequency / self.highest - (1.0 - TAPER)) / TAPER).clamp(0.0, 1.0);
        0.5 * (1.0 + (std::f64::consts::PI * into).cos())
    }
}

/// Pressures for unit force, bin by bin, place by place, receiver by receiver \[Pa/N\].
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

    /// For receivers with these G, all of the same cells and frequencies.
    pub fn new(model: &PressureModel<'_>, greens: &[SurfaceGreen]) -> Self {
        let (places, bins, receivers) = (model.layout.places(), model.bins(), greens.len());
        let mut values = vec![Complex32::ZERO; bins * places * receivers];
        if let Some(first) = greens.first() {
            let mut components = Components::new(model, first, receivers);
            let window = Window::new(&model.layout, components.most());
            let frequency = |bin: usize| bin as f64 * model.layout.resolution();
            let near: Vec<_> = (0..bins).map(|bin| interpolation(&first.frequencies, frequency(bin))).collect();
            let mut rest = values.as_mut_slice();
            let mut begin = 0;
            let alike = near.chunk_by(|(one, _), (next, _)| one == next);
            for group in alike.flat_map(|group| group.chunks(TOGETHER)) {
                let found = components.at(model, greens, begin, group);
                let (here, behind) = rest.split_at_mut(group.len() * places * receivers);
                here.par_chunks_mut(places * receivers).enumerate().for_each(|(index, out)| {
                    window.transfers(model, begin + index, |n| found.of(index, n), out);
                });
                rest = behind;
                begin += group.len();
            }
        }
        Self { receivers, places, bins, values }
    }

    /// Some, for tests: by receiver, place and bin.
    #[cfg(test)]
    pub(super) fn of(
        receivers: usize,
        places: usize,
        bins: usize,
        value: impl Fn(usize, usize, usize) -> Complex64,
    ) -> Self {
        let mut values = Vec::new();
        for bin in 0..bins {
            for place in 0..places {
                values.extend((0..receivers).map(|receiver| crate::numeric::single(value(receiver, place, bin))));
            }
        }
        Self { receivers, places, bins, values }
    }

    /// The transfers from a place to all receivers at a bin \[Pa/N\].
    pub fn row(&self, bin: usize, place: usize) -> &[Complex32] {
        let first = (bin * self.places + place) * self.receivers;
        &self.values[first..first + self.receivers]
    }
}
