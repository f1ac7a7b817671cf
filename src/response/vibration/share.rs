//! A part of the bins with its sums: the work of one thread at a time.
//!
//! For every base bin kappa, every substep p of the window and every channel of a step, one transform of length N over
//! the columns gives A_p(n). Up to a phase that is the same for all channels, so that no power sees it, the bins k that
//! share kappa have
//!
//! ```text
//! F_n(k) = sum_p exp(2 pi i n p/(N q)) exp(-2 pi i k l_p/K) A_p(n),
//! ```
//!
//! conj A_p(-n) in place of A_p(n) for k = m K/q - kappa, l_p being the first step at substep p.

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex64;
use rustfft::Fft;

use super::layout::{SegmentLayout, SharedBin};
use super::products;
use super::resolved::ResolvedQuantities;
use crate::storage::state::evolving;

#[derive(Clone)]
pub(super) struct Share {
    pub(super) bases: Range<usize>,
    layout: SegmentLayout,
    transform: Arc<dyn Fft<f64>>,
    /// Transfers of resolved forces; `None` where products of the forces are stored.
    quantities: Option<Arc<ResolvedQuantities>>,
    /// Sums over the segments of the stages' products, |F_n|^2 for one stage, by base bin, shared bin and wavenumber:
    /// see [`products`]; for resolved forces the quantities of [`ResolvedQuantities`].
    pub(super) powers: Vec<f64>,
    /// By point: velocity at the point for unit force at each place, by base bin, shared bin and place.
    pub(super) point_transfers: Vec<Vec<Complex64>>,
    /// By point: sums of |v|^2 by base bin and shared bin.
    pub(super) point_powers: Vec<Vec<f64>>,
    /// A_p(n) by channel and substep.
    waves: Vec<Complex64>,
    /// F_n(k) by channel.
    row: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

evolving!(Share: powers, point_powers);

impl Share {
    pub(super) fn new(
        layout: SegmentLayout,
        bases: Range<usize>,
        transform: Arc<dyn Fft<f64>>,
        quantities: Option<Arc<ResolvedQuantities>>,
    ) -> Self {
        let shared = bases.len() * layout.most_shared();
        Self {
            powers: vec![0.0; shared * layout.row()],
            point_transfers: Vec::new(),
            point_powers: Vec::new(),
            waves: vec![Complex64::ZERO; layout.channels() * layout.substeps() * layout.elements],
            row: vec![Complex64::ZERO; layout.channels() * layout.wavenumbers()],
            scratch: vec![Complex64::ZERO; transform.get_inplace_scratch_len()],
            transform,
            quantities,
            bases,
            layout,
        }
    }

    /// Adds a point: `transfers(bin, out)` writes the velocities at it for unit force by place.
    pub(super) fn add_point(&mut self, mut transfers: impl FnMut(usize, &mut [Complex64])) {
        let (shared, places) = (self.layout.most_shared(), self.layout.places());
        let mut table = vec![Complex64::ZERO; self.bases.len() * shared * places];
        for (row, base) in self.bases.clone().enumerate() {
            for (slot, SharedBin { bin, .. }) in self.layout.shared_bins(base).enumerate() {
                transfers(bin, &mut table[(row * shared + slot) * places..][..places]);
            }
        }
        self.point_transfers.push(table);
        self.point_powers.push(vec![0.0; self.bases.len() * shared]);
    }

    /// Adds a segment: `spectra(place, base)` is the transform of a place at a base bin.
    pub(super) fn add(&mut self, spectra: impl Fn(usize, usize) -> Complex64 + Copy) {
        for base in self.bases.clone() {
            let first = self.first_row(base);
            let width = self.layout.row();
            let mut powers = std::mem::take(&mut self.powers);
            let keeper = self.keeper();
            self.waves_at(
                base,
                |place| spectra(place, base),
                |slot, bin, row| keeper.add(bin, row, &mut powers[(first + slot) * width..][..width]),
            );
            self.powers = powers;
            for point in 0..self.point_powers.len() {
                for (slot, shared) in self.layout.shared_bins(base).enumerate() {
                    let value = self.at_point(point, base, slot, shared.conjugate, |place| spectra(place, base));
                    self.point_powers[point][first + slot] += value.norm_sqr();
                }
            }
        }
    }

    pub(super) fn keeper(&self) -> Keeper {
        Keeper { layout: self.layout, quantities: self.quantities.clone() }
    }

    /// Index of the first row of a base bin.
    pub(super) fn first_row(&self, base: usize) -> usize {
        (base - self.bases.start) * self.layout.most_shared()
    }

    /// Velocity of a point for given transforms of the places.
    pub(super) fn at_point(
        &self,
        point: usize,
        base: usize,
        slot: usize,
        conjugate: bool,
        place: impl Fn(usize) -> Complex64,
    ) -> Complex64 {
        let places = self.layout.places();
        let transfers = &self.point_transfers[point][(self.first_row(base) + slot) * places..][..places];
        transfers.iter().enumerate().fold(Complex64::ZERO, |sum, (index, transfer)| {
            let value = place(index);
            sum + transfer * if conjugate { value.conj() } else { value }
        })
    }

    /// Computes F_n(k) of all bins that share a base bin, for given transforms of the places, and calls `visit(slot,
    /// bin, row)` with the row by channel and wavenumber.
    pub(super) fn waves_at(
        &mut self,
        base: usize,
        place: impl Fn(usize) -> Complex64,
        mut visit: impl FnMut(usize, usize, &[Complex64]),
    ) {
        let Self { layout, waves, row, scratch, transform, .. } = self;
        let SegmentLayout { elements, columns, .. } = *layout;
        let substeps = layout.substeps();
        // 1. Transforms over the columns, for each channel and substep.
        for (index, wave) in waves.chunks_exact_mut(elements).enumerate() {
            let (channel, phase) = (index / substeps, index % substeps);
            wave.fill(Complex64::ZERO);
            for (column, entry) in wave[..columns].iter_mut().enumerate() {
                *entry = place((channel * columns + column) * substeps + phase);
            }
            transform.process_with_scratch(wave, scratch);
        }
        // 2. Sum over the substeps, for each bin that shares the base bin.
        let half = elements / 2;
        for (slot, SharedBin { bin, conjugate }) in layout.shared_bins(base).enumerate() {
            row.fill(Complex64::ZERO);
            for (index, wave) in waves.chunks_exact(elements).enumerate() {
                let (channel, phase) = (index / substeps, index % substeps);
                let row = &mut row[channel * (elements + 1)..][..elements + 1];
                let delay = layout.delay(bin, phase);
                // exp(2 pi i n p/(N q)), n = -N/2...
                let turn = Complex64::from_polar(1.0, 2.0 * PI * phase as f64 / (elements * substeps) as f64);
                let mut factor = delay * Complex64::from_polar(1.0, -PI * phase as f64 / substeps as f64);
                for (index, entry) in row.iter_mut().enumerate() {
                    let value = if conjugate {
                        wave[(elements + half - index) % elements].conj()
                    } else {
                        wave[(index + half) % elements]
                    };
                    *entry += factor * value;
                    if substeps > 1 {
                        factor *= turn;
                    }
                }
            }
            visit(slot, bin, row);
        }
    }
}

/// Quantities stored of the forces' waves: mean products of the stages' forces, or the motion of resolved ones.
pub(super) struct Keeper {
    layout: SegmentLayout,
    quantities: Option<Arc<ResolvedQuantities>>,
}

impl Keeper {
    /// Adds the stored quantities of F_n at a bin, given by channel and wavenumber.
    pub(super) fn add(&self, bin: usize, row: &[Complex64], sums: &mut [f64]) {
        let (width, stages) = (self.layout.wavenumbers(), self.layout.stages());
        match &self.quantities {
            None => products::add(sums, width, stages, |a| row[a].norm_sqr(), |a, b| row[a] * row[b].conj()),
            Some(quantities) => quantities.add(&self.layout, bin, row, sums),
        }
    }

    /// Adds the change of the sums over so many segments if D is taken off the forces of each: from sum |X|^2 to
    /// sum |X - D|^2 = sum |X|^2 - 2 Re(conj D sum X) + S |D|^2, and likewise for every form quadratic in the forces.
    pub(super) fn correct(&self, bin: usize, [offset, row]: [&[Complex64]; 2], segments: f64, sums: &mut [f64]) {
        let (width, stages) = (self.layout.wavenumbers(), self.layout.stages());
        let Some(quantities) = &self.quantities else {
            let cross = |a: usize, b: usize| {
                segments * offset[a] * offset[b].conj() - offset[a] * row[b].conj() - row[a] * offset[b].conj()
            };
            return products::add(sums, width, stages, |a| change(segments, offset[a], row[a]), cross);
        };
        // 2 Re(conj D X) = (|X + D|^2 - |X - D|^2)/2.
        let mut part = vec![0.0; sums.len()];
        for (factor, forward, of_row) in [(segments, 1.0, 0.0), (-0.5, 1.0, 1.0), (0.5, -1.0, 1.0)] {
            let forces: Vec<Complex64> =
                offset.iter().zip(row).map(|(offset, row)| forward * offset + of_row * row).collect();
            part.fill(0.0);
            quantities.add(&self.layout, bin, &forces, &mut part);
            sums.iter_mut().zip(&part).for_each(|(sum, part)| *sum += factor * part);
        }
    }

    /// Number of a bin's values, the first ones, that are squares, and so not negative.
    pub(super) fn squares(&self) -> usize {
        match &self.quantities {
            None => self.layout.stages() * self.layout.wavenumbers(),
            Some(quantities) if quantities.is_velocity() => self.layout.row(),
            Some(_) => 0,
        }
    }
}

/// Change of sum |X|^2 over so many segments if `offset` is taken off each X; `sum` is sum X.
pub(super) fn change(segments: f64, offset: Complex64, sum: Complex64) -> f64 {
    segments * offset.norm_sqr() - 2.0 * (offset.conj() * sum).re
}
