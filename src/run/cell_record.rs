//! Record of contact over cells beside that of every run: force by row across, area and pressure against time,
//! pictures of the patch, and the cells themselves at chosen instants.

use ndarray::{Array2, ArrayView2};
use serde::{Deserialize, Serialize};

use crate::contact::footprint::WindowShape;
use crate::contact::march::March;
use crate::numeric::{RunningMoments, largest_or_zero};
use crate::plan::Plan;
use crate::results::ResultsError;
use crate::results::arrays::{ArrayPlace, WrittenArrays};
use crate::results::npy::{NpyWriter, Row};
use crate::results::plots::{PatchMap, PlotError};
use crate::results::summary::CellsSummary;
use crate::road::strip::RoadStrip;
use crate::scene::Zone;
use crate::storage::state::{StateError, fill};

/// The arrays.
struct Arrays {
    row_force: NpyWriter<f64>,
    area: NpyWriter<f64>,
    peak_pressure: NpyWriter<f64>,
    /// Cells at chosen instants, and when.
    frames: Option<(NpyWriter<f32>, NpyWriter<f64>)>,
}

/// The recorder.
pub struct CellRecorder {
    arrays: Option<Arrays>,
    across: usize,
    /// Size of a cell \[m\], and of its face \[m^2\].
    size: [f64; 2],
    face: f64,
    warm_up: u64,
    time_step: f64,
    /// Steps between two frames.
    every: u64,
    rows: Vec<f64>,
    frame: Vec<f32>,
    /// After the warm-up: area \[m^2\], pressure on it and its peak \[Pa\].
    moments: [RunningMoments; 3],
    /// Sum of the forces of the steps that count, cell by cell of the window.
    sum: Vec<f64>,
}

/// State of a [`CellRecorder`], its arrays excepted.
#[derive(Deserialize, Serialize)]
pub(crate) struct CellRecordState {
    moments: [RunningMoments; 3],
    sum: Vec<f64>,
}

impl CellRecorder {
    /// Makes the record of a planned run over windows of so many columns; into a folder where arrays are wanted,
    /// beginning or going on.
    /// `None` where there are no cells.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub fn new(plan: &Plan, march: &March, place: Option<&ArrayPlace<'_>>) -> Result<Option<Self>, ResultsError> {
        if plan.decisions.zone != Zone::Cells {
            return Ok(None);
        }
        let WindowShape { columns, across, .. } = march.footprint().shape();
        let outputs = &plan.scene.outputs;
        let size = [plan.element, plan.scene.tyre.contact_width / across as f64];
        let every = outputs.cells_every.map(|time| (time / plan.time_step).round().max(1.0) as u64);
        let frames = every.filter(|_| outputs.arrays);
        let arrays = match place.filter(|_| outputs.arrays) {
            Some(place) => Some(Arrays {
                row_force: place.open("row_force.npy", Row::Columns(across))?,
                area: place.open("contact_area.npy", Row::Scalar)?,
                peak_pressure: place.open("peak_pressure.npy", Row::Scalar)?,
                frames: match frames {
                    Some(_) => {
                        let open = place.open("cells.npy", Row::Columns(columns * across))?;
                        Some((open, place.open("cells_time.npy", Row::Scalar)?))
                    }
                    None => None,
                },
            }),
            None => None,
        };
        Ok(Some(Self {
            arrays,
            across,
            size,
            face: size[0] * size[1],
            warm_up: plan.warm_up_steps,
            time_step: plan.time_step,
            every: every.unwrap_or(u64::MAX),
            rows: vec![0.0; across],
            frame: vec![0.0; columns * across],
            moments: Default::default(),
            sum: vec![0.0; columns * across],
        }))
    }

    /// Takes in the step that a march has just done.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub fn push(&mut self, step: u64, march: &March) -> Result<(), ResultsError> {
        let footprint = march.footprint();
        let forces = footprint.mean();
        let touched = forces.iter().filter(|&&force| force > 0.0).count();
        let area = touched as f64 * self.face;
        let total: f64 = footprint.column_mean().iter().sum();
        let peak = largest_or_zero(forces) / self.face;
        if let Some(arrays) = &mut self.arrays {
            self.rows.fill(0.0);
            for cells in forces.chunks_exact(self.across) {
                for (row, force) in self.rows.iter_mut().zip(cells) {
                    *row += force;
                }
            }
            arrays.row_force.push(&self.rows)?;
            arrays.area.push(&[area])?;
            arrays.peak_pressure.push(&[peak])?;
            if let Some((frames, times)) = arrays.frames.as_mut().filter(|_| step.is_multiple_of(self.every)) {
                self.frame.iter_mut().zip(forces).for_each(|(frame, &force)| *frame = force as f32);
                frames.push(&self.frame)?;
                times.push(&[step as f64 * self.time_step])?;
            }
        }
        if step >= self.warm_up {
            let pressure = if area > 0.0 { total / area } else { 0.0 };
            for (moments, value) in self.moments.iter_mut().zip([area, pressure, peak]) {
                moments.push(value);
            }
            for (sum, force) in self.sum.iter_mut().zip(forces) {
                *sum += force;
            }
        }
        Ok(())
    }

    /// Figures after the warm-up, if there was any step.
    pub fn summary(&self) -> Option<CellsSummary> {
        let [area, pressure, peak] = self.moments.each_ref().map(RunningMoments::mean);
        Some(CellsSummary {
            across: self.across,
            mean_area: area?,
            mean_pressure: pressure?,
            mean_peak_pressure: peak?,
        })
    }

    /// Pictures of the patch: mean pressure, the pressure of the last step of a march, and the road under it.
    ///
    /// # Errors
    /// [`PlotError`].
    pub fn pictures(
        &self,
        title: &str,
        march: &March,
        road: &RoadStrip,
    ) -> Result<Vec<(&'static str, String)>, PlotError> {
        let geometry = march.geometry();
        let first_position = geometry.first_position();
        let first = geometry.first_element(march.next_step().saturating_sub(1));
        let mut heights = vec![f64::NAN; self.sum.len()];
        for (element, heights) in (first..).zip(heights.chunks_exact_mut(self.across)) {
            if let Some(known) = road.heights(element) {
                heights.copy_from_slice(known);
            }
        }
        let last = march.footprint().mean();
        let counted = self.moments[0].count() as f64;
        let field = |values: &[f64], scale: f64| -> Array2<f64> {
            let shape = (values.len() / self.across, self.across);
            ArrayView2::from_shape(shape, values)
                .map_or_else(|_| Array2::zeros((0, 0)), |view| view.mapv(|v| scale * v))
        };
        let pressure = 1e-3 / self.face;
        let maps = [
            (
                "cells_mean_pressure.svg",
                "Mean pressure",
                "Pressure [kPa]",
                field(&self.sum, pressure / counted.max(1.0)),
            ),
            ("cells_pressure.svg", "Pressure at the end", "Pressure [kPa]", field(last, pressure)),
            ("cells_road.svg", "Road under the patch", "Height [mm]", field(&heights, 1e3)),
        ];
        let of = |(file, what, quantity, values): (&'static str, &str, &str, Array2<f64>)| {
            let title = format!("{what}: {title}");
            let map = PatchMap { title: &title, quantity, values: values.view(), first_position, size: self.size };
            Ok((file, map.to_svg()?))
        };
        maps.into_iter().map(of).collect()
    }

    /// Brings all rows so far to the disk, and adds how far each array has come.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub(crate) fn sync(&mut self, written: &mut WrittenArrays) -> Result<(), ResultsError> {
        let Some(Arrays { row_force, area, peak_pressure, frames }) = &mut self.arrays else { return Ok(()) };
        written.sync(row_force)?;
        written.sync(area)?;
        written.sync(peak_pressure)?;
        let Some((frames, times)) = frames else { return Ok(()) };
        written.sync(frames)?;
        written.sync(times)
    }

    /// Completes the arrays; gives the bytes written.
    ///
    /// # Errors
    /// Errors of the arrays.
    pub fn finish(&mut self) -> Result<u64, ResultsError> {
        let Some(Arrays { row_force, area, peak_pressure, frames }) = self.arrays.take() else { return Ok(0) };
        let mut written = row_force.bytes() + area.bytes() + peak_pressure.bytes();
        row_force.finish()?;
        area.finish()?;
        peak_pressure.finish()?;
        if let Some((frames, times)) = frames {
            written += frames.bytes() + times.bytes();
            frames.finish()?;
            times.finish()?;
        }
        Ok(written)
    }

    /// Takes the state down, the arrays' rows excepted.
    pub(crate) fn save(&self) -> CellRecordState {
        CellRecordState { moments: self.moments.clone(), sum: self.sum.clone() }
    }

    /// Goes on from the state of a recorder of the same run.
    ///
    /// # Errors
    /// [`StateError`].
    pub(crate) fn restore(&mut self, state: CellRecordState) -> Result<(), StateError> {
        self.moments = state.moments;
        fill(&mut self.sum, &state.sum)
    }
}
