//! Record of every step: streamed arrays, and the little that spectra and plots need. Memory does not grow with
//! the number of steps.

use std::f64::consts::TAU;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::counters::{Counter, Meter, Stage};
use crate::numeric::RunningMoments;
use crate::plan::{Plan, SEGMENT};
use crate::response::{PowerSpectrum, SpectrumAccumulator, SpectrumState};
use crate::results::ResultsError;
use crate::results::arrays::{ArrayPlace, WrittenArrays};
use crate::results::npy::{NpyWriter, Row};
use crate::results::summary::{AxleMotion, RollingResistance};
use crate::run::cell_record::{CellRecordState, CellRecorder};
use crate::run::error::RunError;
use crate::run::rolling_resistance::{PowerRecorder, ResistanceState};
use crate::run::sound::{SoundRecorder, SoundState};
use crate::run::vibration::{RecorderState, VibrationRecorder};
use crate::scene::{Axle, Scene, TimeRule};
use crate::storage::state::{StateError, restore_part};

/// The arrays of a run.
struct Arrays {
    time: NpyWriter<f64>,
    total_force: NpyWriter<f64>,
    patch_force: NpyWriter<f64>,
    patch_element: NpyWriter<i64>,
    /// Heights of an axle that moves.
    axle: Option<NpyWriter<f64>>,
}

impl Arrays {
    /// Begins the arrays, or goes on with them.
    fn open(place: &ArrayPlace<'_>, columns: usize, moves: bool) -> Result<Self, ResultsError> {
        Ok(Self {
            time: place.open("time.npy", Row::Scalar)?,
            total_force: place.open("total_force.npy", Row::Scalar)?,
            patch_force: place.open("patch_force.npy", Row::Columns(columns))?,
            patch_element: place.open("patch_element.npy", Row::Scalar)?,
            axle: if moves { Some(place.open("axle.npy", Row::Scalar)?) } else { None },
        })
    }
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
    /// Indentation of the rigid tyre \[m\].
    pub indentation: f64,
}

/// Tells whether the axle's motion is a result.
fn moves(scene: &Scene) -> bool {
    matches!(scene.rolling.axle, Axle::Mass { .. })
}

/// The recorder.
pub struct Record {
    arrays: Option<Arrays>,
    warm_up: u64,
    shown: Range<u64>,
    /// Steps that are drawn: time, first element, forces row by row.
    pub drawn: Drawn,
    /// Total force after the warm-up \[N\].
    force: RunningMoments,
    /// Indentation after the warm-up \[m\], of an axle that moves.
    indentation: Option<RunningMoments>,
    /// Where spectra or plots want it and the run is long enough.
    spectrum: Option<SpectrumAccumulator>,
    /// Power put into the tyre, where the tread law has one.
    pub power: Option<PowerRecorder>,
    /// Where the contact is one of cells.
    pub cells: Option<CellRecorder>,
    /// Where vibration is wanted.
    pub vibration: Option<VibrationRecorder>,
    /// Recorder of the sound, with receivers.
    pub sound: Option<SoundRecorder>,
    sum_of_lengths: f64,
    /// The rule whose mean force of a step is recorded, and the step \[s\].
    recording: (TimeRule, f64),
}

/// The steps of the force map.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Drawn {
    /// Time \[s\].
    pub time: Vec<f64>,
    /// Element number of the first column.
    pub first_element: Vec<i64>,
    /// Forces, row by row \[N\].
    pub force: Vec<f64>,
}

/// State of a [`Record`].
#[derive(Deserialize, Serialize)]
pub(crate) struct RecordState {
    force: RunningMoments,
    indentation: Option<RunningMoments>,
    sum_of_lengths: f64,
    drawn: Drawn,
    spectrum: Option<SpectrumState>,
    power: Option<ResistanceState>,
    cells: Option<CellRecordState>,
    vibration: Option<RecorderState>,
    sound: Option<SoundState>,
}

impl Record {
    /// A recorder into a folder, of a run that begins or goes on. `shown` are the steps to draw.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub fn new(
        place: &ArrayPlace<'_>,
        scene: &Scene,
        plan: &Plan,
        columns: usize,
        shown: Range<u64>,
    ) -> Result<Self, RunError> {
        let outputs = &scene.outputs;
        let shown = if outputs.plots { shown.start..shown.end.min(plan.steps) } else { 0..0 };
        let rows_shown = shown.end.saturating_sub(shown.start) as usize;
        Ok(Self {
            arrays: if outputs.arrays { Some(Arrays::open(place, columns, moves(scene))?) } else { None },
            shown,
            drawn: Drawn {
                time: Vec::with_capacity(rows_shown),
                first_element: Vec::with_capacity(rows_shown),
                force: Vec::with_capacity(rows_shown * columns),
            },
            ..Self::in_memory(scene, plan, outputs.spectra || outputs.plots)
        })
    }

    /// A recorder that writes and draws nothing; with the spectrum of the force where that is wanted.
    pub fn in_memory(scene: &Scene, plan: &Plan, spectrum: bool) -> Self {
        let counted = (plan.steps - plan.warm_up_steps) as usize;
        let accumulator = || SpectrumAccumulator::new(counted, plan.time_step, Some(SEGMENT)).ok();
        Self {
            arrays: None,
            warm_up: plan.warm_up_steps,
            shown: 0..0,
            drawn: Drawn::default(),
            force: RunningMoments::default(),
            indentation: moves(scene).then(RunningMoments::default),
            spectrum: spectrum.then(accumulator).flatten(),
            power: None,
            cells: None,
            vibration: None,
            sound: None,
            sum_of_lengths: 0.0,
            recording: (scene.numerics.time_rule, plan.time_step),
        }
    }

    /// Records a step.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub fn push(&mut self, step: StepRecord<'_>, meter: &mut Meter) -> Result<(), RunError> {
        if let Some(arrays) = &mut self.arrays {
            meter.time_in_step(Stage::Output, || {
                arrays.time.push(&[step.time])?;
                arrays.total_force.push(&[step.total_force])?;
                arrays.patch_force.push(step.forces)?;
                arrays.patch_element.push(&[step.first_element])?;
                arrays.axle.as_mut().map_or(Ok(()), |axle| axle.push(&[step.indentation]))
            })?;
        }
        if self.shown.contains(&step.step) {
            self.drawn.time.push(step.time);
            self.drawn.first_element.push(step.first_element);
            self.drawn.force.extend_from_slice(step.forces);
        }
        if step.step >= self.warm_up {
            self.force.push(step.total_force);
            if let Some(indentation) = &mut self.indentation {
                indentation.push(step.indentation);
            }
            self.sum_of_lengths += step.contact_length;
            if let Some(spectrum) = &mut self.spectrum {
                spectrum.push(step.total_force);
            }
        }
        Ok(())
    }

    /// Brings all rows so far to the disk; how far each array has come.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub fn sync(&mut self, meter: &mut Meter) -> Result<WrittenArrays, ResultsError> {
        meter.time(Stage::Output, || {
            let mut written = WrittenArrays::default();
            if let Some(cells) = &mut self.cells {
                cells.sync(&mut written)?;
            }
            if let Some(Arrays { time, total_force, patch_force, patch_element, axle }) = &mut self.arrays {
                written.sync(time)?;
                written.sync(total_force)?;
                written.sync(patch_force)?;
                written.sync(patch_element)?;
                axle.as_mut().map_or(Ok(()), |axle| written.sync(axle))?;
            }
            Ok(written)
        })
    }

    /// Completes the arrays.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub fn finish(&mut self, meter: &mut Meter) -> Result<(), RunError> {
        if let Some(cells) = &mut self.cells {
            let written = meter.time(Stage::Output, || cells.finish())?;
            meter.count(Counter::BytesWritten, written);
        }
        let Some(arrays) = self.arrays.take() else { return Ok(()) };
        let written = arrays.time.bytes()
            + arrays.total_force.bytes()
            + arrays.patch_force.bytes()
            + arrays.patch_element.bytes()
            + arrays.axle.as_ref().map_or(0, NpyWriter::bytes);
        meter.time(Stage::Output, || {
            arrays.time.finish()?;
            arrays.total_force.finish()?;
            arrays.patch_force.finish()?;
            arrays.patch_element.finish()?;
            arrays.axle.map_or(Ok(0), NpyWriter::finish)
        })?;
        meter.count(Counter::BytesWritten, written);
        Ok(())
    }

    /// Takes the state down, the arrays' rows excepted.
    pub(crate) fn save(&self) -> RecordState {
        RecordState {
            force: self.force.clone(),
            indentation: self.indentation.clone(),
            sum_of_lengths: self.sum_of_lengths,
            drawn: self.drawn.clone(),
            spectrum: self.spectrum.as_ref().map(SpectrumAccumulator::save),
            power: self.power.as_ref().map(PowerRecorder::save),
            cells: self.cells.as_ref().map(CellRecorder::save),
            vibration: self.vibration.as_ref().map(VibrationRecorder::save),
            sound: self.sound.as_ref().map(SoundRecorder::save),
        }
    }

    /// Goes on from the state of a recorder of the same run.
    ///
    /// # Errors
    /// [`StateError`].
    pub(crate) fn restore(&mut self, state: RecordState) -> Result<(), StateError> {
        let RecordState { force, indentation, sum_of_lengths, drawn, spectrum, power, cells, vibration, sound } = state;
        (self.force, self.sum_of_lengths) = (force, sum_of_lengths);
        restore_part(&mut self.indentation, indentation, |here, saved| {
            *here = saved;
            Ok(())
        })?;
        if drawn.first_element.len() != drawn.time.len() {
            return Err(StateError::Value);
        }
        // In the room that is there for all rows.
        self.drawn.time.extend(drawn.time);
        self.drawn.first_element.extend(drawn.first_element);
        self.drawn.force.extend(drawn.force);
        restore_part(&mut self.spectrum, spectrum, SpectrumAccumulator::restore)?;
        restore_part(&mut self.power, power, PowerRecorder::restore)?;
        restore_part(&mut self.cells, cells, CellRecorder::restore)?;
        restore_part(&mut self.vibration, vibration, VibrationRecorder::restore)?;
        restore_part(&mut self.sound, sound, SoundRecorder::restore)
    }

    /// The averaged spectrum of the force after the warm-up, of a run that has reached its end; what the mean over a
    /// step takes off is put back.
    pub fn spectrum(&self) -> Option<PowerSpectrum> {
        let (rule, time_step) = self.recording;
        let spectrum = self.spectrum.clone().and_then(|spectrum| spectrum.finish().ok())?;
        Some(spectrum.without(|frequency| rule.mean_response(TAU * frequency * time_step)))
    }

    /// Tells whether the run is too short for a spectrum that was wanted.
    pub fn lacks_spectrum(&self) -> bool {
        self.spectrum.is_none()
    }

    /// Mean force \[N\] after the warm-up, if there was any step.
    pub fn mean_force(&self) -> Option<f64> {
        self.force.mean()
    }

    /// Rolling resistance after the warm-up, where the tread law has one.
    pub fn rolling_resistance(&self) -> Option<RollingResistance> {
        self.power.as_ref()?.resistance(self.mean_force())
    }

    /// Motion of an axle that moves, after the warm-up.
    pub fn axle_motion(&self) -> Option<AxleMotion> {
        let indentation = self.indentation.as_ref()?;
        let (mean, variance) = indentation.mean().zip(indentation.variance())?;
        Some(AxleMotion { mean, rms_variation: variance.sqrt() })
    }

    /// Root mean square of the force less its mean \[N\].
    pub fn rms_force_variation(&self) -> Option<f64> {
        self.force.variance().map(f64::sqrt)
    }

    /// Mean length of the contact \[m\].
    pub fn mean_contact_length(&self) -> Option<f64> {
        let counted = self.force.count();
        (counted > 0).then(|| self.sum_of_lengths / counted as f64)
    }
}
