//! What is kept of every step: streamed arrays, and the little that spectra and plots need.

use std::ops::Range;

use super::error::RunError;
use crate::meter::{Counter, Meter, Stage};
use crate::results::folder::ResultsFolder;
use crate::results::npy::{NpyWriter, Row};
use crate::scene::Outputs;

/// The four arrays of a run.
struct Arrays {
    time: NpyWriter<f64>,
    total_force: NpyWriter<f64>,
    patch_force: NpyWriter<f64>,
    patch_element: NpyWriter<i64>,
}

/// One step, as it is recorded.
#[derive(Clone, Copy, Debug)]
pub struct StepRecord<'a> {
    /// Step number.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Sum of the forces \[N\].
    pub total_force: f64,
    /// Element number e of the window's first column.
    pub first_element: i64,
    /// Forces by column \[N\].
    pub forces: &'a [f64],
    /// Length of the contact \[m\].
    pub contact_length: f64,
}

/// The recorder.
pub struct Record {
    arrays: Option<Arrays>,
    warm_up: u64,
    shown: Range<u64>,
    /// Total force after the warm-up \[N\], where spectra or plots want it.
    pub force: Vec<f64>,
    /// Steps that are drawn: time, first element, forces row by row.
    pub drawn: Drawn,
    keep_force: bool,
    sum: f64,
    sum_of_squares: f64,
    sum_of_lengths: f64,
    counted: u64,
}

/// The steps of the force map.
#[derive(Clone, Debug, Default)]
pub struct Drawn {
    /// Time \[s\].
    pub time: Vec<f64>,
    /// Element number of the first column.
    pub first_element: Vec<i64>,
    /// Forces, row by row \[N\].
    pub force: Vec<f64>,
}

impl Record {
    /// A recorder into a folder. `shown` are the steps to draw.
    pub fn new(
        folder: &ResultsFolder,
        outputs: &Outputs,
        columns: usize,
        warm_up: u64,
        shown: Range<u64>,
    ) -> Result<Self, RunError> {
        let arrays = if outputs.arrays {
            Some(Arrays {
                time: NpyWriter::create(&folder.path("time.npy"), Row::Scalar)?,
                total_force: NpyWriter::create(&folder.path("total_force.npy"), Row::Scalar)?,
                patch_force: NpyWriter::create(&folder.path("patch_force.npy"), Row::Columns(columns))?,
                patch_element: NpyWriter::create(&folder.path("patch_element.npy"), Row::Scalar)?,
            })
        } else {
            None
        };
        Ok(Self {
            arrays,
            warm_up,
            shown: if outputs.plots { shown } else { 0..0 },
            force: Vec::new(),
            drawn: Drawn::default(),
            keep_force: outputs.spectra || outputs.plots,
            sum: 0.0,
            sum_of_squares: 0.0,
            sum_of_lengths: 0.0,
            counted: 0,
        })
    }

    /// Records a step.
    pub fn push(&mut self, step: StepRecord<'_>, meter: &mut Meter) -> Result<(), RunError> {
        if let Some(arrays) = &mut self.arrays {
            meter.time(Stage::Output, || {
                arrays.time.push(&[step.time])?;
                arrays.total_force.push(&[step.total_force])?;
                arrays.patch_force.push(step.forces)?;
                arrays.patch_element.push(&[step.first_element])
            })?;
        }
        if self.shown.contains(&step.step) {
            self.drawn.time.push(step.time);
            self.drawn.first_element.push(step.first_element);
            self.drawn.force.extend_from_slice(step.forces);
        }
        if step.step >= self.warm_up {
            if self.keep_force {
                self.force.push(step.total_force);
            }
            self.sum += step.total_force;
            self.sum_of_squares += step.total_force * step.total_force;
            self.sum_of_lengths += step.contact_length;
            self.counted += 1;
        }
        Ok(())
    }

    /// Completes the arrays.
    pub fn finish(&mut self, meter: &mut Meter) -> Result<(), RunError> {
        let Some(arrays) = self.arrays.take() else { return Ok(()) };
        let written = arrays.time.bytes()
            + arrays.total_force.bytes()
            + arrays.patch_force.bytes()
            + arrays.patch_element.bytes();
        meter.time(Stage::Output, || {
            arrays.time.finish()?;
            arrays.total_force.finish()?;
            arrays.patch_force.finish()?;
            arrays.patch_element.finish()
        })?;
        meter.count(Counter::BytesWritten, written);
        Ok(())
    }

    /// Mean force \[N\] after the warm-up, if there was any step.
    pub fn mean_force(&self) -> Option<f64> {
        (self.counted > 0).then(|| self.sum / self.counted as f64)
    }

    /// Root mean square of the force less its mean \[N\].
    pub fn rms_force_variation(&self) -> Option<f64> {
        let mean = self.mean_force()?;
        let variance = match self.force.len() {
            0 => self.sum_of_squares / self.counted as f64 - mean * mean,
            // Two passes where the force is kept: no cancellation on a smooth road.
            _ => self.force.iter().map(|force| (force - mean).powi(2)).sum::<f64>() / self.counted as f64,
        };
        Some(variance.max(0.0).sqrt())
    }

    /// Mean length of the contact \[m\].
    pub fn mean_contact_length(&self) -> Option<f64> {
        (self.counted > 0).then(|| self.sum_of_lengths / self.counted as f64)
    }
}
