//! Velocities for unit force by wavenumber, and from them those at a point which stands relative to the axle, for unit
//! force at each place of the window.
//!
//! With x_c the position of column c, T_c(w) = sum_n exp(i kx_n (x - x_c)) Y_n(w - n Omega), n = -N/2...N/2 with half
//! of either end: the interpolation between the elements that has no wave shorter than two of them. One transform of
//! length N for every bin and substep; only as many values are stored as the window has columns.
//!
//! Beside the patch levels are those of the elements that pass to 0.04 dB (`bdf2`, N = 256, flat stones, segments of 1
//! s). In its middle the road holds the tread: velocities are the residual of contributions that nearly cancel, some 26
//! dB less, and forces blurred by the window cancel less: up to 7 dB too much from 80 to 315 Hz, where the tyre
//! resonates, 0.1 dB above.
//!
//! With rotation, there is a second table, of the waves that run in the other direction (`both_directions`).

use std::f64::consts::PI;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::FftPlanner;

use super::both_directions::BothDirections;
use super::layout::SegmentLayout;
use super::tangential_forces::TangentialForces;
use super::transfer::{Part, TransferKind, Transfers, TyreResponse, VibrationField};

/// s H_n(s) by wavenumber |n| = 0..=N/2, channel of a step and bin of the material frame.
pub struct VelocityTable {
    field: VibrationField,
    layout: SegmentLayout,
    values: BothDirections<Vec<Complex64>>,
}

impl VelocityTable {
    /// Table of a field; `None` where the response does not have it.
    pub fn new(
        layout: &SegmentLayout,
        response: &TyreResponse<'_>,
        kind: TransferKind,
        field: VibrationField,
    ) -> Option<Self> {
        Self::resolved(layout, &[(1.0, *response)], kind, field)
    }

    /// The same for forces that are resolved across: by component the share of its motion that is observed, and the
    /// tyre's response to it.
    pub fn resolved(
        layout: &SegmentLayout,
        responses: &[(f64, TyreResponse<'_>)],
        kind: TransferKind,
        field: VibrationField,
    ) -> Option<Self> {
        let transfers = Transfers::new(layout, kind);
        let (width, stages, bins) = (layout.channels() * layout.bins(), layout.stages(), layout.bins());
        let of_part = |part: Part| {
            let mut values = vec![Complex64::ZERO; (layout.elements / 2 + 1) * width];
            let rows = values.par_chunks_mut(width).enumerate();
            let of_wavenumber = |(n, row): (usize, &mut [Complex64])| {
                if let ([(1.0, response)], 1) = (responses, layout.components()) {
                    return transfers.velocities(response, n, field, part, row);
                }
                let mut unit = vec![Complex64::ZERO; stages * bins];
                responses.iter().enumerate().all(|(component, (share, response))| {
                    let there = transfers.velocities(response, n, field, part, &mut unit);
                    for (stage, unit) in unit.chunks_exact(bins).enumerate() {
                        let first = (stage * layout.components() + component) * bins;
                        row[first..first + bins].iter_mut().zip(unit).for_each(|(value, unit)| *value = share * unit);
                    }
                    there
                })
            };
            let complete = rows.map(of_wavenumber).reduce(|| true, |a, b| a && b);
            complete.then_some(values)
        };
        let even = of_part(Part::Even)?;
        let turns = responses.iter().any(|(_, response)| response.turns());
        let odd = if turns { Some(of_part(Part::Odd)?) } else { None };
        Some(Self { field, layout: *layout, values: BothDirections::of_parts(even, odd) })
    }

    /// Adds tangential forces, whose components follow those of the normal ones, for a rule of one stage.
    pub(crate) fn with_tangential(mut self, tangential: &TangentialForces) -> Self {
        let Self { field, layout, values: BothDirections { forwards, backwards } } = &mut self;
        let width = layout.channels() * layout.bins();
        let backwards = backwards.get_or_insert_with(|| forwards.clone());
        let rows = forwards.par_chunks_mut(width).zip(backwards.par_chunks_mut(width)).enumerate();
        rows.for_each(|(n, (forwards, backwards))| tangential.put(layout, *field, n, [forwards, backwards]));
        self
    }

    pub(super) fn field(&self) -> VibrationField {
        self.field
    }

    /// Values by wavenumber |n|, channel and bin.
    pub(super) fn values(&self) -> &BothDirections<Vec<Complex64>> {
        &self.values
    }

    /// Range of a channel's bins at a wavenumber, or a distance, 0..=N/2.
    fn bins_of(&self, channel: usize, n: usize) -> Range<usize> {
        let (channels, bins) = (self.layout.channels(), self.layout.bins());
        let first = (n * channels + channel) * bins;
        first..first + bins
    }

    /// Y_n of a channel's force at a bin of the material frame \[m/(N s)\]; wavenumber and bin of either sign.
    pub(super) fn at(&self, channel: usize, wavenumber: i64, material_bin: i64) -> Complex64 {
        let row = self.bins_of(channel, wavenumber.unsigned_abs() as usize).start;
        let value = self.values.of(wavenumber, material_bin)[row + material_bin.unsigned_abs() as usize];
        let value = if material_bin < 0 { value.conj() } else { value };
        let sign = match wavenumber {
            // Radial motion of a tyre that turns also twists it.
            0 if self.values.differ() => 1.0,
            n => n.signum() as f64,
        };
        match self.field {
            VibrationField::Tread | VibrationField::Belt => value,
            VibrationField::Tangential => Complex64::i() * value * sign,
        }
    }

    /// Turns the wavenumbers n into distances of d = 0..=N/2 elements, T_d = sum_n exp(2 pi i n d/N) Y_n, in place. A
    /// normal velocity is even in d, a tangential one odd; for a tyre that turns T_-d takes the backward waves' place.
    pub(super) fn turn_to_distances(&mut self) {
        let (elements, bins) = (self.layout.elements, self.layout.bins());
        let transform = FftPlanner::<f64>::new().plan_fft_inverse(elements);
        let mut row = vec![Complex64::ZERO; elements];
        let mut scratch = vec![Complex64::ZERO; transform.get_inplace_scratch_len()];
        let channels = 0..self.layout.channels();
        for (channel, bin) in channels.flat_map(|channel| (0..bins).map(move |bin| (channel, bin))) {
            row.fill(Complex64::ZERO);
            for index in 0..self.layout.wavenumbers() {
                let n = self.layout.wavenumber(index);
                row[n.rem_euclid(elements as i64) as usize] +=
                    self.layout.share(index) * self.at(channel, n, bin as i64);
            }
            transform.process_with_scratch(&mut row, &mut scratch);
            for (distance, value) in row[..=elements / 2].iter().enumerate() {
                let first = self.bins_of(channel, distance).start;
                self.values.forwards[first + bin] = *value;
                if let Some(behind) = &mut self.values.backwards {
                    behind[first + bin] = row[(elements - distance) % elements];
                }
            }
        }
    }

    /// T_d of a channel's force at the bins of the material frame as a factor and the values that it multiplies, after
    /// [`Self::turn_to_distances`].
    pub(super) fn over_distance(&self, channel: usize, distance: i64) -> (f64, &[Complex64]) {
        let elements = self.layout.elements;
        let ahead = distance.rem_euclid(elements as i64) as usize;
        let nearest = ahead.min(elements - ahead);
        let bins = self.bins_of(channel, nearest);
        match &self.values.backwards {
            Some(behind) if ahead > nearest => (1.0, &behind[bins]),
            Some(_) => (1.0, &self.values.forwards[bins]),
            None => {
                let behind = self.field == VibrationField::Tangential && ahead > nearest;
                (if behind { -1.0 } else { 1.0 }, &self.values.forwards[bins])
            }
        }
    }

    /// Memory \[bytes\] of a table; `turns` for a tyre that turns.
    pub fn bytes(layout: &SegmentLayout, turns: bool) -> f64 {
        let one = 16.0 * (layout.elements as f64 / 2.0 + 1.0) * (layout.channels() * layout.bins()) as f64;
        if turns { 2.0 * one } else { one }
    }

    /// Velocity at a position from the axle \[m\] for unit force at each place, by bin of the non-rotating frame.
    pub(in crate::response) fn at_position(&self, position: f64) -> impl FnMut(usize, &mut [Complex64]) + '_ {
        let layout = self.layout;
        let SegmentLayout { elements, columns, .. } = layout;
        let substeps = layout.substeps();
        let transform = FftPlanner::<f64>::new().plan_fft_forward(elements);
        let mut row = vec![Complex64::ZERO; elements];
        let mut scratch = vec![Complex64::ZERO; transform.get_inplace_scratch_len()];
        let element = layout.circumference / elements as f64;
        move |bin, out| {
            let channels = 0..layout.channels();
            for (channel, phase) in channels.flat_map(|channel| (0..substeps).map(move |phase| (channel, phase))) {
                let distance = position - layout.first_position + element * phase as f64 / substeps as f64;
                row.fill(Complex64::ZERO);
                for index in 0..layout.wavenumbers() {
                    let n = layout.wavenumber(index);
                    let turn = Complex64::from_polar(1.0, 2.0 * PI * n as f64 * distance / layout.circumference);
                    let velocity = self.at(channel, n, layout.material_bin(bin, n));
                    row[n.rem_euclid(elements as i64) as usize] += layout.share(index) * turn * velocity;
                }
                transform.process_with_scratch(&mut row, &mut scratch);
                let delay = layout.delay(bin, phase);
                for (column, value) in row[..columns].iter().enumerate() {
                    out[(channel * columns + column) * substeps + phase] = delay * value;
                }
            }
        }
    }
}
