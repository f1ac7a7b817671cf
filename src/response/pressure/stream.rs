//! From the forces of each step to pressures over time: overlap-save with whole revolutions.
//!
//! A block holds the last K steps, and the next begins half a block later. Of the K pressures of a block half are used,
//! from three eighths of the block on: a response may last three eighths of a block, and, since transfers end at a
//! highest frequency, may begin an eighth before its force.
//!
//! Complete blocks wait as spectra of their forces until there are many, or until the last one is complete. Then their
//! pressures are computed all at once, one batch of receivers after another. This pass costs most in what the blocks
//! share, the products with G's integrals, so as many wait as memory allows. A pressure has the same bits however many
//! do.

use std::ops::Range;
use std::sync::Arc;

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use super::transfer::{BlockSpectra, PressureSpectra, PressureTransfers};
use crate::numeric::{double, single};
use crate::response::vibration::SegmentLayout;
use crate::storage::state::{Evolving, StateError, StateStream, ensure};

/// Most blocks that wait: with more the checkpoints that hold them take longer than fewer passes save.
const MOST_WAITING: usize = 32;
/// Most receivers whose pressures are in memory together.
const RECEIVERS: usize = 160;

/// From the forces of each step to the pressures at some receivers, sampled at the steps.
pub(crate) struct PressureStream {
    transfers: PressureTransfers,
    forward: Arc<dyn RealToComplex<f64>>,
    backward: Arc<dyn ComplexToReal<f64>>,
    /// Forces of the block so far, step by step \[N\].
    forces: Vec<f64>,
    steps: u64,
    /// Blocks that are still to be completed.
    ahead: u64,
    most_waiting: usize,
    /// Spectra of the complete blocks whose pressures are still to be computed.
    waiting: Vec<BlockSpectra>,
}

/// Pressures over time at some receivers, block by block.
pub(crate) struct BlockPressures<'a> {
    layout: &'a SegmentLayout,
    backward: &'a dyn ComplexToReal<f64>,
    spectra: PressureSpectra,
}

impl PressureStream {
    /// Stream of `steps` steps of forces in windows of the model's layout, whose segments are the blocks, of which at
    /// most `most_waiting` wait. The first step has the layout's substep.
    pub(crate) fn new(transfers: PressureTransfers, steps: u64, most_waiting: usize) -> Self {
        let mut planner = RealFftPlanner::new();
        let layout = &transfers.model.layout;
        Self {
            forward: planner.plan_fft_forward(layout.length()),
            backward: planner.plan_fft_inverse(layout.length()),
            forces: Vec::with_capacity(layout.length() * layout.width()),
            steps: 0,
            ahead: Self::blocks(layout, steps),
            most_waiting,
            waiting: Vec::new(),
            transfers,
        }
    }

    /// Stream of a segment of the steps, which begins with a block of them; all of its blocks wait for
    /// [`Self::into_blocks`].
    pub(crate) fn of_segment(&self) -> Self {
        Self {
            transfers: self.transfers.clone(),
            forward: Arc::clone(&self.forward),
            backward: Arc::clone(&self.backward),
            forces: Vec::new(),
            steps: 0,
            ahead: u64::MAX,
            most_waiting: usize::MAX,
            waiting: Vec::new(),
        }
    }

    /// The complete blocks that wait.
    pub(crate) fn into_blocks(self) -> Vec<BlockSpectra> {
        self.waiting
    }

    /// Takes the next block, which another stream has completed.
    pub(crate) fn append(&mut self, block: BlockSpectra) {
        self.waiting.push(block);
        self.ahead = self.ahead.saturating_sub(1);
    }

    /// Memory \[bytes\] except G for so many receivers, G on `around` cells with `integrals` integrals per wavenumber,
    /// while `waiting` blocks wait.
    pub(crate) fn bytes(
        layout: &SegmentLayout,
        bins: usize,
        waiting: usize,
        receivers: usize,
        [around, integrals]: [usize; 2],
    ) -> f64 {
        // One further block: the spectra are there twice while they are reordered.
        let forces = 8 * layout.length() * layout.width() + 8 * layout.places() * bins * (waiting + 1);
        let (_, most) = Self::batches(receivers);
        forces as f64 + PressureTransfers::work_bytes(layout, bins, waiting, most, [around, integrals])
    }

    /// Number of batches of receivers, and the receivers in the largest.
    pub(crate) fn batches(receivers: usize) -> (usize, usize) {
        let batches = receivers.div_ceil(RECEIVERS).max(1);
        (batches, receivers.div_ceil(batches))
    }

    /// Most blocks of `steps` steps that wait where the memory holds `in_memory` of them.
    pub(crate) fn most_waiting(layout: &SegmentLayout, steps: u64, in_memory: f64) -> usize {
        let useful = MOST_WAITING.min(Self::blocks(layout, steps) as usize);
        (in_memory as usize).min(useful).max(1)
    }

    /// Number of complete blocks in `steps` steps.
    pub(crate) fn blocks(layout: &SegmentLayout, steps: u64) -> u64 {
        let (length, hop) = (layout.length() as u64, layout.hop() as u64);
        steps.checked_sub(length).map_or(0, |more| more / hop + 1)
    }

    /// Number of pressures per receiver that `steps` steps give.
    pub(crate) fn samples(layout: &SegmentLayout, steps: u64) -> u64 {
        Self::blocks(layout, steps) * layout.hop() as u64
    }

    pub(crate) fn first_step(layout: &SegmentLayout) -> u64 {
        (layout.length() * 3 / 8) as u64
    }

    /// Columns of the window of the forces.
    pub(crate) fn columns(&self) -> usize {
        self.layout().columns
    }

    /// Number of Fourier transforms per block.
    pub(crate) fn transforms(&self) -> u64 {
        (self.layout().places() + self.transfers.greens.len()) as u64
    }

    /// Multiply-adds for the pressures of the blocks that wait.
    pub(crate) fn multiply_adds(&self) -> u64 {
        let PressureTransfers { model, greens } = &self.transfers;
        let around = greens.first().map_or(0, |green| green.around);
        let (receivers, integrals) = (greens.len(), model.integrals_of_wave());
        let [shared, each] =
            PressureTransfers::multiply_adds(&model.layout, model.bins(), self.waiting.len(), around, integrals);
        (shared * Self::batches(receivers).0 as f64 + each * receivers as f64) as u64
    }

    /// True if the next step completes a block.
    pub(crate) fn completes_next(&self) -> bool {
        self.forces.len() + self.layout().width() == self.layout().length() * self.layout().width()
    }

    /// Takes the forces of a step \[N\], channel by channel, column by column; true if a block is complete.
    pub(crate) fn push(&mut self, forces: &[f64]) -> bool {
        self.forces.extend_from_slice(forces);
        self.steps += 1;
        let (length, hop, width) = (self.layout().length(), self.layout().hop(), self.layout().width());
        let complete = self.forces.len() == length * width;
        if complete {
            let spectra = self.spectra();
            self.append(spectra);
            self.forces.drain(..hop * width);
        }
        complete
    }

    /// True if the pressures of the blocks that wait are to be computed now.
    pub(crate) fn is_due(&self) -> bool {
        self.waiting.len() >= self.most_waiting || (self.ahead == 0 && !self.waiting.is_empty())
    }

    /// Number of blocks whose pressures are still to be computed, and whether some may be within so many steps.
    pub(crate) fn remaining_blocks(&self, within: usize) -> (u64, bool) {
        let (waiting, width) = (self.waiting.len(), self.layout().width());
        let ends = self.forces.len() / width + within >= self.layout().length();
        let is_last = self.ahead <= 1 || waiting + 1 >= self.most_waiting;
        (self.ahead + waiting as u64, self.ahead > 0 && ends && is_last)
    }

    pub(crate) fn steps(&self) -> u64 {
        self.steps
    }

    /// True if another stream has taken as many steps and has as many blocks that wait, and that are to come.
    pub(crate) fn is_level_with(&self, other: &Self) -> bool {
        let progress = |of: &Self| (of.steps, of.ahead, of.waiting.len(), of.forces.len() / of.layout().width());
        progress(self) == progress(other)
    }

    /// Computes the pressures of the blocks that wait and hands them to `take`, batch by batch of receivers; beside
    /// them those of `other`, a stream that has taken as many steps and has the same receivers. No block waits
    /// afterwards.
    pub(crate) fn receive(
        &mut self,
        mut other: Option<&mut Self>,
        mut take: impl FnMut(Range<usize>, &BlockPressures<'_>, Option<&BlockPressures<'_>>),
    ) {
        let receivers = self.transfers.greens.len();
        let (batches, most) = Self::batches(receivers);
        for batch in 0..batches {
            let some = (batch * most).min(receivers)..((batch + 1) * most).min(receivers);
            let beside = other.as_deref().map(|other| other.pressures_at(some.clone()));
            take(some.clone(), &self.pressures_at(some), beside.as_ref());
        }
        self.waiting.clear();
        if let Some(other) = &mut other {
            other.waiting.clear();
        }
    }

    fn pressures_at(&self, receivers: Range<usize>) -> BlockPressures<'_> {
        let Self { transfers, backward, waiting, .. } = self;
        let spectra = transfers.pressures(receivers, waiting);
        BlockPressures { layout: &transfers.model.layout, backward: &**backward, spectra }
    }

    fn layout(&self) -> &SegmentLayout {
        &self.transfers.model.layout
    }

    /// Spectra of the block that has just been completed.
    fn spectra(&self) -> BlockSpectra {
        let (layout, forward, forces) = (self.layout(), &self.forward, &self.forces);
        let (length, width, places) = (layout.length(), layout.width(), layout.places());
        let bins = self.transfers.model.bins();
        // A block begins half a block after the one before it, which may be within an element.
        let begun = self.steps as usize - length;
        let mut by_place = vec![Complex32::ZERO; places * bins];
        by_place.par_chunks_mut(bins).enumerate().for_each(|(place, out)| {
            let (force, phase) = (place / layout.substeps(), place % layout.substeps());
            let mut series = vec![0.0; length];
            for (step, value) in series.iter_mut().enumerate() {
                if layout.phase_of(begun + step) == phase {
                    *value = forces[step * width + force];
                }
            }
            let mut spectrum = forward.make_output_vec();
            // The only error is a wrong length; both have the planned length.
            let transformed = forward.process(&mut series, &mut spectrum);
            debug_assert!(transformed.is_ok());
            out.iter_mut().zip(&spectrum).for_each(|(out, value)| *out = single(*value));
            // The two real bins, mean and Nyquist frequency, do not radiate.
            out[0] = Complex32::ZERO;
            if 2 * (bins - 1) == length {
                out[bins - 1] = Complex32::ZERO;
            }
        });
        let mut spectra = vec![Complex32::ZERO; places * bins];
        spectra.par_chunks_mut(places).enumerate().for_each(|(bin, out)| {
            let found = by_place.iter().skip(bin).step_by(bins);
            out.iter_mut().zip(found).for_each(|(out, found)| *out = *found);
        });
        spectra
    }

    #[cfg(test)]
    pub(super) fn blocks_that_wait(&self) -> &[BlockSpectra] {
        &self.waiting
    }
}

impl Evolving for PressureStream {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.growing(&mut self.forces)?;
        state.growing(&mut self.waiting)?;
        state.all([&mut self.steps, &mut self.ahead, &mut self.most_waiting])?;
        let (layout, bins) = (self.layout(), self.transfers.model.bins());
        let (count, width) = (self.forces.len(), layout.width());
        ensure(count < layout.length() * width && count.is_multiple_of(width))?;
        ensure((count / width) as u64 <= self.steps)?;
        ensure(self.waiting.iter().all(|spectra| spectra.len() == layout.places() * bins))
    }
}

impl<'a> BlockPressures<'a> {
    #[cfg(test)]
    pub(super) fn new(
        layout: &'a SegmentLayout,
        backward: &'a dyn ComplexToReal<f64>,
        spectra: PressureSpectra,
    ) -> Self {
        Self { layout, backward, spectra }
    }

    /// Gives the pressures at a receiver, by its index in the batch, block after block \[Pa\].
    pub(crate) fn of(&self, receiver: usize, mut take: impl FnMut(&[f64])) {
        let Self { layout, backward, spectra } = self;
        let (length, hop) = (layout.length(), layout.hop());
        let first = PressureStream::first_step(layout) as usize;
        let mut lines = backward.make_input_vec();
        let mut series = backward.make_output_vec();
        let mut scratch = backward.make_scratch_vec();
        for block in 0..spectra.blocks() {
            lines.fill(Complex64::ZERO);
            let found = spectra.of_block(receiver, block);
            lines.iter_mut().zip(found).for_each(|(line, found)| *line = double(found) / length as f64);
            // The only error is a wrong length; all have the planned length.
            let transformed = backward.process_with_scratch(&mut lines, &mut series, &mut scratch);
            debug_assert!(transformed.is_ok());
            take(&series[first..first + hop]);
        }
    }
}
