//! Pressures at receivers for unit amplitude of the forces' component of each wavenumber.
//!
//! For each n the sum over m, over the weights of G that the air's motion requires and over the frequencies between
//! which G is interpolated is one product of real matrices: G's integrals, receiver by receiver, with factors that the
//! receivers share, bin by bin. G's integrals are stored for the few frequencies between which is interpolated, and
//! computed when the bins reach them.
//!
//! Rings of a flank that moves count as further shapes beside the tread's m. Each m has an amplitude where forces
//! are resolved across: there is no sum over m, and a product for each pair (n, m).

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use super::model::PressureModel;
use super::surface::{SurfaceGreen, WaveIntegrals};

/// G's integrals at the frequencies about some bins, and the buffers of their products.
pub(super) struct Components {
    integrals: WaveIntegrals,
    strip: Vec<f64>,
    /// Largest |n|.
    most: usize,
    receivers: usize,
    /// Components of the forces across: 1, with all lateral waves, or one for each of them.
    components: usize,
    /// By slot, the index of the frequency that it holds.
    held: Vec<Option<usize>>,
    /// By n from -most, component, slot, m, weight: the real parts by receiver, then the imaginary ones.
    parts: Vec<f32>,
    /// G's integrals at one frequency, receiver by receiver.
    known: Vec<Complex32>,
    /// Pressures at some bins, as in [`Found`].
    found: Vec<f32>,
}

/// Pressures for unit amplitude at some bins.
pub(super) struct Found<'a> {
    /// Number of wavenumbers times components.
    waves: usize,
    /// Twice the number of receivers: real and imaginary parts.
    width: usize,
    bins: usize,
    /// By n from -most, component, bin: the real parts by receiver, then the imaginary ones.
    values: &'a [f32],
}

impl Components {
    /// Buffers for `receivers` receivers whose G has the cells and frequencies of `green`.
    pub(super) fn new(model: &PressureModel, green: &SurfaceGreen, receivers: usize) -> Self {
        let integrals = WaveIntegrals::new(green, model.waves.waves, &model.shapes(), model.weights());
        let most = integrals.most_under(&model.layout);
        let strip = model.strip();
        let held = vec![None; green.frequencies.len().min(4)];
        let parts = vec![0.0; (2 * most + 1) * held.len() * 2 * integrals.of_wave() * receivers];
        let known = vec![Complex32::ZERO; integrals.count() * receivers];
        let components = model.layout.components();
        Self { integrals, strip, most, receivers, components, held, parts, known, found: Vec::new() }
    }

    /// Memory \[bytes\] of one receiver, for G on `around` cells, `integrals` integrals per wavenumber, and
    /// `components` components of `bins` bins at a time.
    pub(super) fn bytes(around: usize, integrals: usize, components: usize, bins: usize) -> usize {
        8 * around * (4 * integrals + integrals + components * bins)
    }

    pub(super) fn most(&self) -> usize {
        self.most
    }

    /// Pressures at bins from `begin` on; `bins` holds for each the frequencies about it, the same for all, and their
    /// weights.
    pub(super) fn at(
        &mut self,
        model: &PressureModel,
        greens: &[SurfaceGreen],
        begin: usize,
        bins: &[(Range<usize>, Vec<f64>)],
    ) -> Found<'_> {
        // 1. G's integrals at the frequencies about these bins.
        for frequency in bins.iter().take(1).flat_map(|(near, _)| near.clone()) {
            self.hold(greens, frequency);
        }
        let Self { integrals, strip, most, receivers, components, held, parts, found, .. } = self;
        let (of_wave, slots, width, components) = (integrals.of_wave(), held.len(), 2 * *receivers, *components);
        // Integrals of each component.
        let each = of_wave / components;
        let terms = 2 * each * slots;
        // Every value is overwritten: resizing avoids clearing the buffer each time.
        found.resize((2 * *most + 1) * components * bins.len() * width, 0.0);
        let parts = parts.par_chunks(components * terms * *receivers);
        found.par_chunks_mut(components * bins.len() * width).zip(parts).enumerate().for_each(|(row, (out, parts))| {
            let n = row as i64 - *most as i64;
            let mean = model.mean_over_element(n);
            let (mut factors, mut flows) = (vec![Complex64::ZERO; of_wave], model.flow_buffer());
            let mut columns = vec![0.0_f32; components * 2 * bins.len() * terms];
            for (index, (near, weights)) in bins.iter().enumerate() {
                model.factors(begin + index, n, mean, strip, &mut flows, &mut factors);
                let of_component = columns.chunks_exact_mut(2 * bins.len() * terms);
                for (columns, factors) in of_component.zip(factors.chunks_exact(each)) {
                    let (real, imaginary) = columns[index * 2 * terms..][..2 * terms].split_at_mut(terms);
                    for (frequency, weight) in near.clone().zip(weights) {
                        let first = frequency % slots * 2 * each;
                        for (index, factor) in factors.iter().enumerate() {
                            let [re, im] = [(weight * factor.re) as f32, (weight * factor.im) as f32];
                            real[first + 2 * index..][..2].copy_from_slice(&[re, -im]);
                            imaginary[first + 2 * index..][..2].copy_from_slice(&[im, re]);
                        }
                    }
                }
            }
            let of_component = columns.chunks_exact(2 * bins.len() * terms).zip(parts.chunks_exact(terms * *receivers));
            for (out, (columns, parts)) in out.chunks_exact_mut(bins.len() * width).zip(of_component) {
                let out = MatMut::from_column_major_slice_mut(out, *receivers, 2 * bins.len());
                let parts = MatRef::from_column_major_slice(parts, *receivers, terms);
                let columns = MatRef::from_column_major_slice(columns, terms, 2 * bins.len());
                matmul(out, Accum::Replace, parts, columns, 1.0_f32, Par::Seq);
            }
        });
        Found { waves: (2 * *most + 1) * components, width, bins: bins.len(), values: found }
    }

    /// Computes G's integrals at a frequency unless their slot holds them already.
    fn hold(&mut self, greens: &[SurfaceGreen], frequency: usize) {
        let Self { integrals, most, receivers, components, held, parts, known, .. } = self;
        let (slot, slots) = (frequency % held.len(), held.len());
        if held[slot] == Some(frequency) {
            return;
        }
        held[slot] = Some(frequency);
        let count = integrals.count();
        let each = known.par_chunks_mut(count).zip(greens);
        each.for_each_init(
            || integrals.buffers(),
            |buffers, (integrals_of_one, green)| integrals.of(green, frequency, buffers, integrals_of_one),
        );
        let (of_wave, width) = (integrals.of_wave(), 2 * *receivers);
        let skipped = integrals.most_around() - *most;
        let each = of_wave / *components;
        parts.par_chunks_mut(slots * of_wave * width).enumerate().for_each(|(row, parts)| {
            for index in 0..of_wave {
                let place = (index / each * slots + slot) * each + index % each;
                let (real, imaginary) = parts[place * width..][..width].split_at_mut(*receivers);
                let known = known.iter().skip((skipped + row) * of_wave + index).step_by(count);
                for ((real, imaginary), known) in real.iter_mut().zip(imaginary).zip(known) {
                    Complex32 { re: *real, im: *imaginary } = *known;
                }
            }
        });
    }
}

impl Found<'_> {
    /// Matrix at the bin of an index. Columns: n by n and component by component; rows: the real parts by receiver,
    /// then the imaginary ones.
    pub(super) fn matrix(&self, index: usize) -> MatRef<'_, f32> {
        let all = MatRef::from_column_major_slice(self.values, self.width * self.bins, self.waves);
        all.subrows(index * self.width, self.width)
    }
}
