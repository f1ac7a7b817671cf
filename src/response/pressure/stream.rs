//! Forces, step by step, to pressures over time: overlap-save with whole revolutions.
//!
//! A block holds the last K steps, and the next begins half a block later. Of the K pressures that a block gives the
//! half that knows all that came before it is kept, three eighths from its beginning: a response may last three eighths
//! of a block, and, since transfers end at a highest frequency, may begin an eighth before its force.

use std::sync::Arc;

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use serde::{Deserialize, Serialize};

use super::transfer::PlaceTransfers;
use crate::response::vibration::SegmentLayout;
use crate::storage::StateError;

/// From the forces of every step to the pressures at some receivers, sampled at the steps.
pub struct PressureStream {
    layout: SegmentLayout,
    transfers: PlaceTransfers,
    forward: Arc<dyn RealToComplex<f64>>,
    backward: Arc<dyn ComplexToReal<f64>>,
    /// Forces of the block, step by step \[N\].
    forces: Vec<f64>,
    /// Steps taken in so far.
    steps: u64,
    /// Pressures of the block that was completed last, receiver by receiver \[Pa\].
    pressures: Vec<f64>,
}

/// What evolves of a [`PressureStream`].
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct PressureState {
    forces: Vec<f64>,
    steps: u64,
}

impl PressureStream {
    /// Of forces in windows of the layout whose segments are the blocks, which begin with the layout's substep.
    pub fn new(layout: SegmentLayout, transfers: PlaceTransfers) -> Self {
        let mut planner = RealFftPlanner::new();
        Self {
            layout,
            forward: planner.plan_fft_forward(layout.length()),
            backward: planner.plan_fft_inverse(layout.length()),
            forces: Vec::with_capacity(layout.length() * layout.width()),
            steps: 0,
            pressures: vec![0.0; transfers.receivers * layout.hop()],
            transfers,
        }
    }

    /// Bytes beside the transfers.
    pub fn bytes(layout: &SegmentLayout, bins: usize, receivers: usize) -> f64 {
        let spectra = 16 * (layout.places() + receivers) * bins;
        (8 * layout.length() * layout.width() + spectra + 8 * receivers * layout.hop()) as f64
    }

    /// Pressures that so many steps give, per receiver.
    pub fn samples(layout: &SegmentLayout, steps: u64) -> u64 {
        let (length, hop) = (layout.length() as u64, layout.hop() as u64);
        steps.checked_sub(length).map_or(0, |more| (more / hop + 1) * hop)
    }

    /// The step whose pressure is the first.
    pub fn first_step(layout: &SegmentLayout) -> u64 {
        (layout.length() * 3 / 8) as u64
    }

    /// Transforms of a block.
    pub fn transforms(&self) -> u64 {
        (self.transfers.places + self.transfers.receivers) as u64
    }

    /// Multiply-adds of a block.
    pub fn multiply_adds(&self) -> u64 {
        4 * (self.transfers.places * self.transfers.bins * self.transfers.receivers) as u64
    }

    /// Whether the next step completes a block.
    pub fn completes_next(&self) -> bool {
        self.forces.len() + self.layout.width() == self.layout.length() * self.layout.width()
    }

    /// Takes in the forces of a step \[N\], stage by stage, column by column; whether a block is complete, whose
    /// [`Self::pressures`] are there then.
    pub fn push(&mut self, forces: &[f64]) -> bool {
        self.forces.extend_from_slice(forces);
        self.steps += 1;
        let complete = self.forces.len() == self.layout.length() * self.layout.width();
        if complete {
            self.transform();
            self.forces.drain(..self.layout.hop() * self.layout.width());
        }
        complete
    }

    /// Pressures at a receiver in the block that was completed last \[Pa\].
    pub fn pressures(&self, receiver: usize) -> &[f64] {
        let hop = self.layout.hop();
        &self.pressures[receiver * hop..(receiver + 1) * hop]
    }

    fn transform(&mut self) {
        let Self { layout, transfers, forward, backward, forces, pressures, .. } = self;
        let (length, hop, width) = (layout.length(), layout.hop(), layout.width());
        let bins = transfers.bins;
        // A block begins half a block after the one before it, which may be amid an element.
        let begun = self.steps as usize - length;
        let mut spectra = vec![Complex64::ZERO; layout.places() * bins];
        spectra.par_chunks_mut(bins).enumerate().for_each(|(place, out)| {
            let (force, phase) = (place / layout.substeps, place % layout.substeps);
            let mut series = vec![0.0; length];
            for (step, value) in series.iter_mut().enumerate() {
                if layout.phase_of(begun + step) == phase {
                    *value = forces[step * width + force];
                }
            }
            let mut spectrum = forward.make_output_vec();
            // Both are of the planned lengths.
            let transformed = forward.process(&mut series, &mut spectrum);
            debug_assert!(transformed.is_ok());
            out.copy_from_slice(&spectrum[..bins]);
        });
        let receivers = transfers.receivers;
        let mut sums = vec![Complex64::ZERO; bins * receivers];
        sums.par_chunks_mut(receivers).enumerate().for_each(|(bin, sums)| {
            for (place, spectrum) in spectra.chunks_exact(bins).enumerate() {
                add_product(sums, transfers.row(bin, place), spectrum[bin]);
            }
        });
        let first = Self::first_step(layout) as usize;
        pressures.par_chunks_mut(hop).enumerate().for_each(|(receiver, out)| {
            let mut sum = backward.make_input_vec();
            let found = sums.iter().skip(receiver).step_by(receivers);
            sum.iter_mut().zip(found).for_each(|(sum, found)| *sum = *found);
            // The two real lines hold nothing that sounds.
            sum[0] = Complex64::ZERO;
            if let Some(last) = sum.last_mut() {
                *last = Complex64::ZERO;
            }
            let mut series = backward.make_output_vec();
            let transformed = backward.process(&mut sum, &mut series);
            debug_assert!(transformed.is_ok());
            for (out, value) in out.iter_mut().zip(&series[first..]) {
                *out = value / length as f64;
            }
        });
    }

    /// The transfers.
    #[cfg(test)]
    pub(super) fn transfers(&self) -> &PlaceTransfers {
        &self.transfers
    }

    /// Takes the state down.
    pub fn save(&self) -> PressureState {
        PressureState { forces: self.forces.clone(), steps: self.steps }
    }

    /// Goes on from the state of a stream of the same run.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn restore(&mut self, state: PressureState) -> Result<(), StateError> {
        let most = self.layout.length() * self.layout.width();
        if state.forces.len() >= most || !state.forces.len().is_multiple_of(self.layout.width()) {
            return Err(StateError::Value);
        }
        self.forces.clear();
        self.forces.extend(state.forces);
        self.steps = state.steps;
        Ok(())
    }
}

fn add_product(sums: &mut [Complex64], transfers: &[Complex32], force: Complex64) {
    for (sum, transfer) in sums.iter_mut().zip(transfers) {
        let (re, im) = (f64::from(transfer.re), f64::from(transfer.im));
        sum.re += re * force.re - im * force.im;
        sum.im += re * force.im + im * force.re;
    }
}
