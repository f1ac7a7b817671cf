//! The pressure at receivers for unit force at each place of the contact window.
//!
//! What all receivers share, the tyre's compliances and how a place acts, is found once for each bin. The rest are
//! products of real matrices in single precision, whose rows are the receivers: over the lateral waves and the
//! frequencies that G is interpolated between, then over the wavenumbers to the window's columns. They are made for the
//! bins between two of G's frequencies at a time.

use num_complex::Complex32;
#[cfg(test)]
use num_complex::Complex64;
use rayon::prelude::*;

use super::components::Components;
use super::model::PressureModel;
use super::surface::{SurfaceGreen, interpolation};
use super::window::Window;
use crate::response::vibration::SegmentLayout;

/// Most bins whose components are in memory together.
const TOGETHER: usize = 32;

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

    /// Real multiply-adds of the products that transfers take, with G on so many cells and so many lateral waves.
    pub fn multiply_adds(layout: &SegmentLayout, bins: usize, receivers: usize, around: usize, lateral: usize) -> f64 {
        let around = around.min(layout.elements);
        let waves = 16 * around * lateral;
        let columns = around * layout.places();
        let folded = 8 * around * layout.stages() * layout.substeps;
        ((waves + columns + folded) * bins * receivers) as f64
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
                let each = here.par_chunks_mut(places * receivers).enumerate();
                each.for_each_init(
                    || window.room(receivers),
                    |room, (index, out)| window.transfers(model, begin + index, |n| found.of(index, n), room, out),
                );
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
