//! From the spectra of forces to those of the pressures at receivers.
//!
//! Shared parts, the tyre's compliances and the forces' part in each wavenumber, are found once for each bin. The rest
//! are products of real matrices in single precision, whose rows are the receivers: over the integrals of a wavenumber
//! and the frequencies between which G is interpolated, then over the wavenumbers to the blocks of forces. They are
//! computed for the bins between two of G's frequencies at a time, and for many blocks at a time: the first product
//! serves them all, so nothing of the size of places times bins is stored per receiver.

use std::ops::Range;
use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::Complex32;
use rayon::prelude::*;

use super::components::{Components, Found};
use super::model::PressureModel;
use super::surface::{SurfaceGreen, interpolation};
use super::window::{Folded, Window};
use crate::numeric::single;
use crate::response::vibration::SegmentLayout;

const TOGETHER: usize = 32;

/// Ingredients of pressures: the tyre, and G of every receiver.
#[derive(Clone, Debug)]
pub(crate) struct PressureTransfers {
    /// The tyre and its forces.
    pub model: PressureModel,
    /// G by receiver, all of the same cells and frequencies; shared by the transfers of other motions.
    pub greens: Arc<[SurfaceGreen]>,
}

/// Forces of a block at the bins from 0 on, bin by bin, place by place \[N\]. A place is (channel x columns + column) x
/// substeps + substep; channels are the stages, or components across, one after the other.
pub(crate) type BlockSpectra = Vec<Complex32>;

/// Pressures at some receivers in some blocks \[Pa\].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PressureSpectra {
    receivers: usize,
    blocks: usize,
    /// Bin by bin, receiver by receiver, block by block.
    values: Vec<Complex32>,
}

/// Buffers for the work on a bin.
struct Buffers {
    folded: Folded,
    /// By block, n by n: the real parts of all blocks, then the imaginary ones.
    forces: Vec<f32>,
    /// Products of components and forces, by block: the real components by receiver, then the imaginary ones; first
    /// those with the forces' real parts.
    products: Vec<f32>,
    late: Vec<Complex32>,
}

impl PressureTransfers {
    /// Number of real multiply-adds for `blocks` blocks, with G on `around` cells and `integrals` integrals per
    /// wavenumber: those that all receivers share, and those of each.
    pub(crate) fn multiply_adds(
        layout: &SegmentLayout,
        bins: usize,
        blocks: usize,
        around: usize,
        integrals: usize,
    ) -> [f64; 2] {
        let around = around.min(layout.elements);
        let shared = around * layout.places() * blocks;
        let each = around * (16 * integrals + 4 * blocks * layout.components());
        [shared, each].map(|amount| (amount * bins) as f64)
    }

    /// Memory \[bytes\] of so many receivers while the pressures of so many blocks are computed.
    pub(crate) fn work_bytes(
        layout: &SegmentLayout,
        bins: usize,
        blocks: usize,
        receivers: usize,
        [around, integrals]: [usize; 2],
    ) -> f64 {
        let components = Components::bytes(around, integrals, layout.components(), TOGETHER);
        (receivers * (8 * bins * blocks + components)) as f64
    }

    pub(crate) fn pressures(&self, receivers: Range<usize>, blocks: &[BlockSpectra]) -> PressureSpectra {
        let Self { model, greens } = self;
        let greens = &greens[receivers.clone()];
        let (bins, places, count) = (model.bins(), model.layout.places(), blocks.len());
        let mut found = PressureSpectra { receivers: greens.len(), blocks: count, values: Vec::new() };
        let Some(first) = greens.first().filter(|_| count > 0) else { return found };
        found.values.reserve_exact(bins * greens.len() * count);
        // 1. G's integrals, the window's shapes, and for each bin the frequencies between which G is interpolated.
        let mut components = Components::new(model, first, greens.len());
        let window = Window::new(&model.layout, components.most());
        let frequency = |bin: usize| bin as f64 * model.layout.resolution();
        let near: Vec<_> = (0..bins).map(|bin| interpolation(&first.frequencies, frequency(bin))).collect();
        // 2. Groups of bins with the same neighbours: components once for all blocks, then bin by bin.
        let mut begin = 0;
        let alike = near.chunk_by(|(one, _), (next, _)| one == next);
        for group in alike.flat_map(|group| group.chunks(TOGETHER)) {
            let unit = components.at(model, greens, begin, group);
            let each = (begin..begin + group.len()).into_par_iter().map_init(
                || Buffers::new(&window, greens.len(), count),
                |buffers, bin| {
                    let forces = blocks.iter().map(|block| &block[bin * places..(bin + 1) * places]);
                    window.components(model, bin, forces, &mut buffers.folded, &mut buffers.forces);
                    buffers.multiply(&unit, bin - begin);
                    buffers.late.clear();
                    buffers.late.extend(model.late(receivers.clone(), bin).map(single));
                    buffers.pressures(count)
                },
            );
            each.collect::<Vec<_>>().iter().for_each(|pressures| found.values.extend_from_slice(pressures));
            begin += group.len();
        }
        found
    }
}

impl Buffers {
    fn new(window: &Window, receivers: usize, blocks: usize) -> Self {
        Self {
            folded: window.buffers(blocks),
            forces: vec![0.0; window.waves() * 2 * blocks],
            products: vec![0.0; 4 * receivers * blocks],
            late: Vec::with_capacity(receivers),
        }
    }

    /// Multiplies the components of unit forces at the bin of an index by those of the forces.
    fn multiply(&mut self, unit: &Found<'_>, index: usize) {
        let unit = unit.matrix(index);
        let (rows, waves) = (unit.nrows(), unit.ncols());
        let columns = self.forces.len() / waves;
        let products = MatMut::from_column_major_slice_mut(&mut self.products, rows, columns);
        let forces = MatRef::from_column_major_slice(&self.forces, waves, columns);
        matmul(products, Accum::Replace, unit, forces, 1.0_f32, Par::Seq);
    }

    /// Pressures of a bin, receiver by receiver, block by block, with the fractional delays.
    fn pressures(&self, blocks: usize) -> Vec<Complex32> {
        let receivers = self.late.len();
        let (real, imaginary) = self.products.split_at(2 * receivers * blocks);
        let one = |(receiver, late): (usize, &Complex32)| {
            let late = *late;
            (0..blocks).map(move |block| {
                let [re, im] = [0, receivers].map(|part| part + receiver + 2 * receivers * block);
                late * Complex32::new(real[re] - imaginary[im], real[im] + imaginary[re])
            })
        };
        self.late.iter().enumerate().flat_map(one).collect()
    }
}

impl PressureSpectra {
    #[cfg(test)]
    pub(super) fn of(
        [receivers, blocks, bins]: [usize; 3],
        value: impl Fn(usize, usize, usize) -> num_complex::Complex64,
    ) -> Self {
        let mut values = Vec::new();
        for bin in 0..bins {
            for receiver in 0..receivers {
                values.extend((0..blocks).map(|block| single(value(receiver, block, bin))));
            }
        }
        Self { receivers, blocks, values }
    }

    pub(crate) fn blocks(&self) -> usize {
        self.blocks
    }

    /// Pressure at a receiver in a block, bin by bin \[Pa\].
    pub(crate) fn of_block(&self, receiver: usize, block: usize) -> impl Iterator<Item = Complex32> {
        let each = self.receivers * self.blocks;
        self.values.iter().skip(receiver * self.blocks + block).step_by(each.max(1)).copied()
    }
}
