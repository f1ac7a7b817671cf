//! Patch forces, taken step by step, to mean powers by bin and wavenumber: memory does not grow with the record.
//!
//! 1. Two hops of forces are buffered as they come, by column of the window: relative to the axle the window stands
//!    still but for its substeps. The stages of a Runge-Kutta rule are further columns.
//! 2. When a segment is complete, the mean pattern of the first segment is taken off (it stands relative to the axle:
//!    4000 N at 0 Hz beside some newtons of vibration, which the side lobes of a window would leak into them), each
//!    place is weighted and transformed over time.
//! 3. `share` transforms each bin over the columns and adds |F_n(k)|^2, for several stages their products, see
//!    `products`.
//! 4. At the end the mean pattern of the whole record is known, m, and with d = m - m_0 the powers of the lowest bins
//!    are brought from |X|^2 to |X - d W|^2: the sums of X that this takes are stored there by place. In the higher
//!    bins the window's transform W has fallen by 1e-4 and d^2 |W|^2 is nothing.
//!
//! Cost of a segment: q C real transforms of length K/q, K/2 complex ones of length N, and K N/2 squares; for s stages
//! s times the transforms and s^2 times the squares and their memory.
//!
//! Forces that are resolved across have a transform for each component, and the motion that they cause is found in
//! step 3: [`super::resolved`].

use std::sync::Arc;

use num_complex::Complex64;
use rayon::prelude::*;
use realfft::{RealFftPlanner, RealToComplex};
use rustfft::FftPlanner;

use super::elements::ElementVelocities;
use super::layout::SegmentLayout;
use super::resolved::ResolvedQuantities;
use super::share::{Share, change};
use super::velocity_table::VelocityTable;
use crate::storage::state::{Evolving, StateError, StateStream, ensure};

const LOWEST: usize = 8;
/// Parts into which the bins are divided: enough for the threads of a desktop computer, and the same for any number of
/// threads, so that results do not depend on it.
const SHARES: usize = 16;

/// Sums over all segments so far, and the forces of the segment in progress.
pub struct VibrationAccumulator {
    layout: SegmentLayout,
    transform: Arc<dyn RealToComplex<f64>>,
    /// Forces \[N\] of two hops: steps x channels x columns.
    forces: Vec<f64>,
    /// Power that the contact forces put into the tyre, by step \[W\].
    powers: Vec<f64>,
    /// Steps in [`Self::forces`].
    filled: usize,
    segments: u64,
    /// Mean pattern of the first segment, by place \[N\].
    reference: Vec<f64>,
    /// Sum of the squared window times the forces, by place.
    weighted: Vec<f64>,
    /// Sum of the squared window times that power.
    weighted_power: f64,
    /// Sums of the transforms at the lowest base bins: base x places.
    lowest: Vec<Complex64>,
    shares: Vec<Share>,
    elements: Option<ElementVelocities>,
    /// Transforms over time: places x base bins.
    spectra: Vec<Complex64>,
    series: Vec<f64>,
    scratch: Vec<Complex64>,
}

impl VibrationAccumulator {
    /// An empty accumulator. Points are added by [`Self::add_points`], before the first step.
    pub fn new(layout: SegmentLayout) -> Self {
        Self::keeping(layout, None)
    }

    /// An accumulator of forces that are resolved across, which keeps these `quantities` of them.
    pub fn resolved(layout: SegmentLayout, quantities: ResolvedQuantities) -> Self {
        Self::keeping(layout, Some(Arc::new(quantities)))
    }

    fn keeping(layout: SegmentLayout, quantities: Option<Arc<ResolvedQuantities>>) -> Self {
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(layout.base_length());
        let over_columns = FftPlanner::<f64>::new().plan_fft_forward(layout.elements);
        let (places, bases) = (layout.places(), layout.base_bins());
        let shares = (0..SHARES)
            .map(|share| bases * share / SHARES..bases * (share + 1) / SHARES)
            .filter(|bases| !bases.is_empty())
            .map(|bases| Share::new(layout, bases, over_columns.clone(), quantities.clone()))
            .collect();
        Self {
            forces: vec![0.0; layout.length() * layout.width()],
            powers: vec![0.0; layout.length()],
            filled: 0,
            segments: 0,
            reference: vec![0.0; places],
            weighted: vec![0.0; places],
            weighted_power: 0.0,
            lowest: vec![Complex64::ZERO; LOWEST.min(bases) * places],
            shares,
            elements: None,
            spectra: vec![Complex64::ZERO; places * bases],
            series: transform.make_input_vec(),
            scratch: transform.make_scratch_vec(),
            transform,
            layout,
        }
    }

    /// Adds points, at positions from the axle \[m\], at which the velocities of a table's field are computed, in their
    /// order.
    pub fn add_points(&mut self, table: &VelocityTable, positions: &[f64]) {
        for &position in positions {
            let mut transfers = table.at_position(position);
            self.shares.iter_mut().for_each(|share| share.add_point(&mut transfers));
        }
    }

    /// Sets the elements whose velocities are computed.
    pub fn set_elements(&mut self, elements: ElementVelocities) {
        self.elements = Some(elements);
    }

    /// Memory \[bytes\] of an accumulator with that many points.
    pub fn bytes(layout: &SegmentLayout, points: usize) -> f64 {
        let (bins, places) = (layout.bins() as f64, layout.places() as f64);
        let forces = layout.length() as f64 * (layout.width() as f64 + 1.0);
        let spectra = 2.0 * places * layout.base_bins() as f64;
        8.0 * (forces + spectra + bins * layout.row() as f64 + points as f64 * bins * (2.0 * places + 1.0))
    }

    /// Sizes of the segments.
    pub fn layout(&self) -> &SegmentLayout {
        &self.layout
    }

    /// Number of complete segments.
    pub fn segments(&self) -> u64 {
        self.segments
    }

    /// True if the next step completes a segment.
    pub fn completes_next(&self) -> bool {
        self.filled + 1 == self.layout.length()
    }

    /// Takes a step: its forces, channel after channel by column of the window \[N\], and the power that they put in
    /// \[W\]. True if it completed a segment.
    pub fn push(&mut self, forces: &[f64], power: f64) -> bool {
        let width = self.layout.width();
        self.forces[self.filled * width..][..width].copy_from_slice(forces);
        self.powers[self.filled] = power;
        self.filled += 1;
        let complete = self.filled == self.layout.length();
        if complete {
            self.close();
        }
        complete
    }

    /// Adds the complete segment to the sums and moves the forces on by a hop.
    fn close(&mut self) {
        let layout = self.layout;
        let (width, substeps, bases) = (layout.width(), layout.substeps(), layout.base_bins());
        // 1. The first segment's mean pattern off, weighted, transformed over time.
        for place in 0..layout.places() {
            let (column, phase) = (place / substeps, place % substeps);
            let steps = || (layout.first_step(phase)..layout.length()).step_by(substeps);
            if self.segments == 0 {
                let sum: f64 = steps().map(|step| self.forces[step * width + column]).sum();
                self.reference[place] = sum / layout.base_length() as f64;
            }
            let mut weighted = 0.0;
            for (entry, step) in self.series.iter_mut().zip(steps()) {
                let (weight, force) = (layout.weight(step), self.forces[step * width + column]);
                weighted += weight * weight * force;
                *entry = weight * (force - self.reference[place]);
            }
            self.weighted[place] += weighted;
            let spectrum = &mut self.spectra[place * bases..][..bases];
            // The only error is a wrong length; both have the planned length.
            let _ = self.transform.process_with_scratch(&mut self.series, spectrum, &mut self.scratch);
            for (base, sums) in self.lowest.chunks_exact_mut(layout.places()).enumerate() {
                sums[place] += spectrum[base];
            }
        }
        // 2. Over the columns, bin by bin, and for single elements.
        let powers = self.powers.iter().enumerate();
        self.weighted_power += powers.map(|(step, power)| layout.weight(step).powi(2) * power).sum::<f64>();
        let spectra = &self.spectra;
        self.shares.par_iter_mut().for_each(|share| share.add(|place, base| spectra[place * bases + base]));
        if let Some(elements) = &mut self.elements {
            let (forces, reference) = (&self.forces, &self.reference);
            elements.add(|step, column| forces[step * width + column] - reference[layout.place(step, column)]);
        }
        self.segments += 1;
        // 3. The second half of the segment is the first of the next.
        self.forces.copy_within(layout.hop() * width.., 0);
        self.powers.copy_within(layout.hop().., 0);
        self.filled = layout.length() - layout.hop();
    }

    /// Mean of the segments so far; `None` before the first one.
    pub fn finish(&self) -> Option<PatchSpectra> {
        if self.segments == 0 {
            return None;
        }
        let layout = self.layout;
        let hop = layout.hop() as f64;
        let segments = self.segments as f64;
        // A place occurs in each q-th step of a segment.
        let steps = segments * hop / layout.substeps() as f64;
        // 1. The mean pattern of the whole record.
        let mean: Vec<f64> = self.weighted.iter().map(|sum| sum / steps).collect();
        let scale = 1.0 / (segments * hop * layout.length() as f64);
        let mut spectra = PatchSpectra {
            powers: vec![0.0; layout.bins() * layout.row()],
            points: vec![vec![0.0; layout.bins()]; self.shares[0].point_powers.len()],
            elements: self.elements.as_ref().map_or_else(Vec::new, |elements| {
                elements.finish(|step, column| {
                    let place = layout.place(step, column);
                    mean[place] - self.reference[place]
                })
            }),
            mean_pattern: Vec::new(),
            mean_power: self.weighted_power / (segments * hop),
            segments: self.segments,
            layout,
        };
        // 2. Powers, corrected in the lowest bins for the difference from the first segment's mean pattern.
        let windows = self.window_transforms();
        for share in &self.shares {
            // The sums themselves are not changed: results may be read before a run's end.
            let mut share = share.clone();
            for base in share.bases.clone() {
                spectra.take(&share, base);
                if base < LOWEST {
                    let places = layout.places();
                    let offset: Vec<Complex64> = (0..places)
                        .map(|place| windows[place % layout.substeps()][base] * (mean[place] - self.reference[place]))
                        .collect();
                    spectra.correct(&mut share, base, &offset, &self.lowest[base * places..][..places], segments);
                }
            }
        }
        let keeper = self.shares[0].keeper();
        let squares = keeper.squares();
        let at_points = spectra.points.iter_mut().chain(&mut spectra.elements).flatten();
        let (powers, crosses): (Vec<_>, Vec<_>) =
            spectra.powers.chunks_exact_mut(layout.row()).map(|row| row.split_at_mut(squares)).unzip();
        for power in powers.into_iter().flatten().chain(at_points) {
            *power = scale * power.max(0.0);
        }
        for product in crosses.into_iter().flatten() {
            *product *= scale;
        }
        // The mean pattern is periodic with the substeps: lines at multiples of K/q bins.
        let mut share = self.shares[0].clone();
        let whole = layout.base_length() as f64;
        share.waves_at(
            0,
            |place| (mean[place] * whole).into(),
            |_, bin, row| {
                let square = (layout.length() as f64).powi(2);
                let mut lines = vec![0.0; layout.row()];
                keeper.add(bin, row, &mut lines);
                lines.iter_mut().for_each(|line| *line /= square);
                spectra.mean_pattern.push((bin, lines));
            },
        );
        Some(spectra)
    }

    /// Transform of the window at the steps of each substep.
    fn window_transforms(&self) -> Vec<Vec<Complex64>> {
        let layout = self.layout;
        let transform = |phase: usize| {
            let steps = (layout.first_step(phase)..layout.length()).step_by(layout.substeps());
            let mut series: Vec<f64> = steps.map(|step| layout.weight(step)).collect();
            let mut spectrum = self.transform.make_output_vec();
            // The only error is a wrong length; both have the planned length.
            let _ = self.transform.process(&mut series, &mut spectrum);
            spectrum
        };
        (0..layout.substeps()).map(transform).collect()
    }
}

/// All sums, and the segment in progress.
impl Evolving for VibrationAccumulator {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.filled, &mut self.segments, &mut self.weighted_power])?;
        let (filled, width) = (self.filled, self.layout.width());
        ensure(filled < self.layout.length())?;
        state.list(&mut self.forces[..filled * width])?;
        state.list(&mut self.powers[..filled])?;
        state.all([&mut self.reference, &mut self.weighted, &mut self.lowest])?;
        state.all([&mut self.shares, &mut self.elements])
    }
}

/// Mean powers of the patch forces, in the non-rotating frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchSpectra {
    /// Sizes of the segments.
    pub layout: SegmentLayout,
    /// Number of segments averaged.
    pub segments: u64,
    /// Mean of |F_n(k)|^2 \[N^2\], bins 0..=K/2 x wavenumbers -N/2..=N/2, the mean pattern taken off; a bin counts
    /// [`SegmentLayout::sides`] times, a wavenumber [`SegmentLayout::share`]. For several stages a bin has a row of
    /// wavenumbers for |F_i|^2 of each stage, then two for each pair of stages i < j: real and imaginary part of the
    /// mean of F_i conj F_j. For resolved forces a bin has instead a row for each quantity of [`ResolvedQuantities`].
    pub powers: Vec<f64>,
    /// The same of the mean pattern: numbers of its bins, with their rows.
    pub mean_pattern: Vec<(usize, Vec<f64>)>,
    /// By point: |v|^2 \[m^2/s^2\], bins 0..=K/2.
    pub points: Vec<Vec<f64>>,
    /// By element selected: |v|^2 \[m^2/s^2\] without the mean pattern's lines, bins 0..=K/2 of the material frame.
    pub elements: Vec<Vec<f64>>,
    /// Mean power that the forces put into the tyre \[W\].
    pub mean_power: f64,
}

impl PatchSpectra {
    /// Values of a bin, as in [`Self::powers`].
    pub fn row(&self, bin: usize) -> &[f64] {
        let width = self.layout.row();
        &self.powers[bin * width..][..width]
    }

    fn row_mut(&mut self, bin: usize) -> &mut [f64] {
        let width = self.layout.row();
        &mut self.powers[bin * width..][..width]
    }

    /// Copies a share's sums at a base bin.
    fn take(&mut self, share: &Share, base: usize) {
        let (first, width) = (share.first_row(base), self.layout.row());
        for (slot, shared) in self.layout.shared_bins(base).enumerate() {
            self.row_mut(shared.bin).copy_from_slice(&share.powers[(first + slot) * width..][..width]);
            for (powers, sums) in self.points.iter_mut().zip(&share.point_powers) {
                powers[shared.bin] = sums[first + slot];
            }
        }
    }

    /// Takes an offset off the forces of every segment.
    fn correct(&mut self, share: &mut Share, base: usize, offset: &[Complex64], sums: &[Complex64], segments: f64) {
        let keeper = share.keeper();
        let mut offsets: Vec<Vec<Complex64>> = Vec::new();
        share.waves_at(base, |place| offset[place], |_, _, row| offsets.push(row.to_vec()));
        share.waves_at(
            base,
            |place| sums[place],
            |slot, bin, row| keeper.correct(bin, [&offsets[slot], row], segments, self.row_mut(bin)),
        );
        for point in 0..self.points.len() {
            for (slot, shared) in self.layout.shared_bins(base).enumerate() {
                let at =
                    |values: &[Complex64]| share.at_point(point, base, slot, shared.conjugate, |place| values[place]);
                self.points[point][shared.bin] += change(segments, at(offset), at(sums));
            }
        }
    }
}
