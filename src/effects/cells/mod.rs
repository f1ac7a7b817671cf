//! Results of contact over cells in addition to those of every run: force by row across, area and pressure over time,
//! pictures of the patch, and the forces of the cells themselves at chosen instants.

use super::channel::{Channel, Read, RowShape};
use super::effect::{Effect, RunStart};
use super::error::RunError;
use super::observer::{EffectObserver, End, Found, Observer, Step};
use super::section::{Figure, PageSection, ReportError, pictures};
use super::stored::Stored;
use crate::contact::footprint::add_to_cells;
use crate::counters::{Job, Meter, Stage};
use crate::numeric::{RunningMoments, largest_or_zero};
use crate::plan::Plan;
use crate::results::files::ResultFiles;
use crate::results::summary::CellsSummary;
use crate::scene::Zone;
use crate::storage::state::{StateError, StateStream};

pub(crate) struct CellsEffect;

static CHANNELS: [Channel; 5] = [
    Channel::new("row_force", "N", "contact force of each row of cells across", Read::Fill(sum_rows))
        .rows(RowShape::Across)
        .only(over_cells),
    Channel::new(
        "contact_area",
        "m^2",
        "area of the cells, or of their sub-cells, that carry force",
        Read::Number(area),
    )
    .only(over_cells),
    Channel::new("peak_pressure", "Pa", "largest pressure on a cell or sub-cell", Read::Number(peak_pressure))
        .only(over_cells),
    Channel::new("cells", "N", "contact force of each cell in the window, at chosen instants", Read::Single(frame))
        .rows(RowShape::Points)
        .at_instants(has_frames),
    Channel::new("cells_time", "s", "time of those instants", Read::Number(|step| step.time)).at_instants(has_frames),
];

fn over_cells(plan: &Plan) -> bool {
    plan.decisions.zone == Zone::Cells
}

fn has_frames(plan: &Plan) -> bool {
    over_cells(plan) && plan.scene.outputs.cells_every.is_some()
}

fn sum_rows(step: &Step<'_>, rows: &mut [f64]) {
    for cells in step.footprint.mean().chunks_exact(rows.len()) {
        rows.iter_mut().zip(cells).for_each(|(row, force)| *row += force);
    }
}

fn frame(step: &Step<'_>, out: &mut [f32]) {
    out.iter_mut().zip(step.footprint.mean()).for_each(|(out, &force)| *out = force as f32);
}

/// Area of the face of a cell, or of a sub-cell \[m^2\].
fn face(step: &Step<'_>) -> f64 {
    let (all, touching) = (step.footprint.mean().len(), step.footprint.touching_forces().len());
    step.point_size[0] * step.point_size[1] * all as f64 / touching as f64
}

/// Area of the cells that carry force \[m^2\].
fn area(step: &Step<'_>) -> f64 {
    let touched = step.footprint.touching_forces().iter().filter(|&&force| force > 0.0).count();
    touched as f64 * face(step)
}

/// Largest pressure on a cell \[Pa\].
fn peak_pressure(step: &Step<'_>) -> f64 {
    largest_or_zero(step.footprint.touching_forces()) / face(step)
}

impl Effect for CellsEffect {
    fn name(&self) -> &'static str {
        "cells"
    }

    fn channels(&self) -> &'static [Channel] {
        &CHANNELS
    }

    fn figures(&self, stored: &Stored) -> Vec<Figure> {
        let cells = stored.summary.outcome.cells;
        let figures = [
            Figure::of("contact area", "cm2", cells.map(|cells| 1e4 * cells.mean_area)),
            Figure::of("mean pressure", "kPa", cells.map(|cells| 1e-3 * cells.mean_pressure)),
            Figure::of("peak pressure, mean", "kPa", cells.map(|cells| 1e-3 * cells.mean_peak_pressure)),
        ];
        figures.into_iter().flatten().collect()
    }

    fn sections(&self, stored: &Stored, _: &[Stored]) -> Result<Vec<PageSection>, ReportError> {
        let named = [
            ["cells_pressure.svg", "Pressure of every cell at the last instant that was written."],
            ["cells_mean_pressure.svg", "Mean pressure of every cell."],
            ["cells_road.svg", "The road under the cells at that instant."],
        ];
        Ok(vec![PageSection { heading: "Contact", blocks: pictures(stored, &named)? }])
    }

    fn begin(&self, begin: &mut RunStart<'_>, _: &mut Job<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError> {
        let RunStart { plan, contact, .. } = *begin;
        if !over_cells(plan) {
            return Ok(None);
        }
        let (shape, size) = (contact.shape, contact.point_size);
        let sum = vec![0.0; shape.points()];
        Ok(Some(Box::new(CellObserver { across: shape.across, size, moments: Default::default(), sum })))
    }
}

pub(crate) struct CellObserver {
    across: usize,
    /// Length and width of a cell \[m\].
    size: [f64; 2],
    /// After the warm-up: contact area \[m^2\], mean pressure on it and peak pressure \[Pa\].
    moments: [RunningMoments; 3],
    /// Sum over the steps after the warm-up of the forces, cell by cell of the window \[N\].
    sum: Vec<f64>,
}

impl Observer for CellObserver {
    fn observe(&mut self, step: &Step<'_>, meter: &mut Meter) -> Result<(), RunError> {
        if step.counts {
            meter.time_in_step(Stage::Output, || {
                let (area, footprint) = (area(step), step.footprint);
                let total: f64 = footprint.column_mean().iter().sum();
                let pressure = if area > 0.0 { total / area } else { 0.0 };
                let values = [area, pressure, peak_pressure(step)];
                self.moments.iter_mut().zip(values).for_each(|(moments, value)| moments.push(value));
                self.sum.iter_mut().zip(footprint.mean()).for_each(|(sum, force)| *sum += force);
            });
        }
        Ok(())
    }
}

impl EffectObserver for CellObserver {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.moments, &mut self.sum])
    }

    fn report(&self, _: &End<'_>, found: &mut Found) {
        let [area, pressure, peak] = self.moments.each_ref().map(RunningMoments::mean);
        found.outcome.cells = area.zip(pressure).zip(peak).map(|((mean_area, mean_pressure), mean_peak_pressure)| {
            CellsSummary { across: self.across, mean_area, mean_pressure, mean_peak_pressure }
        });
    }

    fn write(&self, end: &End<'_>, files: &dyn ResultFiles, _: &mut Found, _: &mut Meter) -> Result<(), RunError> {
        if end.loaded.scene.outputs.plots { self.draw(end, files) } else { Ok(()) }
    }
}

impl CellObserver {
    /// Draws the patch: mean pressure, the pressure of the last step, and the road under it.
    fn draw(&self, end: &End<'_>, files: &dyn ResultFiles) -> Result<(), RunError> {
        let geometry = end.geometry;
        let first = geometry.first_element(end.steps.saturating_sub(1));
        let sub_cells = end.plan.decisions.sub_cells;
        let mut heights = vec![f64::NAN; self.sum.len()];
        for (element, heights) in (first..).zip(heights.chunks_exact_mut(self.across)) {
            if let Some(known) = end.road.heights(element) {
                heights.fill(0.0);
                add_to_cells(known, [sub_cells, self.across], 1.0 / (sub_cells * sub_cells) as f64, heights);
            }
        }
        let counted = self.moments[0].count() as f64;
        let scaled = |values: &[f64], scale: f64| -> Vec<f64> { values.iter().map(|value| scale * value).collect() };
        let pressure = 1e-3 / (self.size[0] * self.size[1]);
        let mean = scaled(&self.sum, pressure / counted.max(1.0));
        let last = scaled(end.footprint.mean(), pressure);
        for (named, values) in [
            (["cells_mean_pressure.svg", "Mean pressure", "Pressure [kPa]"], mean),
            (["cells_pressure.svg", "Pressure at the end", "Pressure [kPa]"], last),
            (["cells_road.svg", "Road under the patch", "Height [mm]"], scaled(&heights, 1e3)),
        ] {
            end.draw_points(files, named, (&values, self.across), self.size)?;
        }
        Ok(())
    }
}
