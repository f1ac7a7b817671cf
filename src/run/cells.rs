//! Contact over cells, made for a planned scene.

use crate::contact::cells::direct::DirectCellHistory;
use crate::contact::cells::gaps::{GapMap, PLACES, StandingCells};
use crate::contact::cells::history::{RingParts, WaveHistory, first_influences};
use crate::contact::cells::resting::RestingCells;
use crate::contact::cells::wave_transform::{WaveNumber, WaveTransform};
use crate::contact::cells::{CellHistory, CellZone, InstantCells};
use crate::contact::march::March;
use crate::contact::static_contact::StaticContact;
use crate::contact::tread::TreadSurface;
use crate::counters::{Counter, Job, Meter, Stage};
use crate::effects::{RunError, TyreModels};
use crate::plan::Plan;
use crate::plan::models::{band_sums, cell_sums, planned_cell_model, planned_fewer_poles};
use crate::radiation::gap::patch::REACH;
use crate::response::vibration::CarriedWaves;
use crate::road::maker::SliceForm;
use crate::run::friction::FrictionContact;
use crate::run::zone_maker::{Made, Standing, Window, ZoneMaker};
use crate::scene::{Axle, History, LoadedScene, SceneError};
use crate::tyre::influence::{CellInfluence, CellSums, WaveBand, WaveValues};
use crate::tyre::poles::cells::fit_cells;
use crate::tyre::poles::pole_model::PoleModel;
use crate::tyre::tread_pattern::blocks::TreadBlocks;

pub(super) struct CellContact<'a> {
    loaded: &'a LoadedScene,
    plan: &'a Plan,
    sums: CellSums,
    tread: TreadSurface,
    blocks: Option<TreadBlocks>,
    resting: RestingCells,
}

impl ZoneMaker for CellContact<'_> {
    fn at_rest(&mut self) -> Result<(StaticContact, f64), RunError> {
        Ok((self.resting.under(&self.plan.decisions.axle)?, 1.0))
    }

    fn gaps(&self, standing: Standing<'_>) -> Result<Vec<GapMap>, RunError> {
        let plan = self.plan;
        if !plan.scene.opens_voids() {
            return Ok(Vec::new());
        }
        let Standing { surface, elements, start, at_rest, reach } = standing;
        let rate = plan.speed / (0.5 * at_rest.length);
        let reach = reach.max(0.5 * at_rest.length + REACH);
        let mut cells = StandingCells::new(&self.sums, self.tread.clone(), self.blocks.as_ref(), rate, reach);
        let across = self.tread.across();
        let mut found = Vec::new();
        let (places, counted) = (PLACES as u64, plan.steps - plan.warm_up_steps);
        for place in 0..places {
            let step = plan.warm_up_steps + (2 * place + 1) * counted / (2 * places);
            let way = start + step as f64 * plan.time_step * plan.speed;
            let under = (way / plan.element).round() as i64;
            let window = cells.elements(under);
            // Beyond the road's end the tyre meets no road: heights stay 0.
            let (first, end) = elements.map_or((window.start, window.end), |(first, last)| {
                (first.clamp(window.start, window.end), (last + 1).clamp(window.start, window.end))
            });
            let mut heights = vec![0.0; (window.end - window.start) as usize * across];
            let (from, count) = ((first - window.start) as usize * across, (end - first).max(0) as usize);
            surface.heights(first, count, &mut heights[from..from + count * across])?;
            found.push(cells.gap(&plan.decisions.axle, &at_rest, under, &heights)?);
        }
        Ok(found)
    }

    fn make(&self, window: Window<'_>, job: &mut Job<'_>) -> Result<Made, RunError> {
        let plan = self.plan;
        let Window { output_window, margin, columns, at_rest, .. } = window;
        if matches!(plan.scene.rolling.axle, Axle::Mass { .. }) {
            let right = "an axle without a mass";
            let problem = self.loaded.complain("rolling.axle.mass", "cells need an axle without a mass", right);
            return Err(SceneError::from(problem).into());
        }
        let numerics = &plan.scene.numerics;
        let made = |march, models| Made { march, form: SliceForm::Cells, moving: None, local_compliance: None, models };
        if let Some(friction) = plan.scene.friction.as_ref().filter(|_| plan.scene.has_tractions()) {
            let (loaded, sums, tread) = (self.loaded, &self.sums, &self.tread);
            let contact = FrictionContact { loaded, plan, sums, tread, friction };
            return Ok(made(contact.march(at_rest, (output_window, margin), job)?, TyreModels::default()));
        }
        let instant = self.instant(columns, &mut job.meter);
        let followed = plan.decisions.takes_models;
        let waves = match numerics.history {
            History::Direct if !followed => Vec::new(),
            _ => self.carried(columns, job)?,
        };
        let zone = self.zone(instant.clone(), &waves, margin, job);
        let mut models = TyreModels::default();
        if followed {
            let beyond = job.meter.time(Stage::Influence, || self.beyond(instant, &waves));
            models.waves = Some((waves, beyond));
        }
        Ok(made(March::over(Box::new(zone), output_window, numerics.time_rule, plan.time_step), models))
    }
}

impl<'a> CellContact<'a> {
    /// Contact of a planned scene.
    pub(super) fn new(loaded: &'a LoadedScene, plan: &'a Plan) -> Self {
        let grid = plan.cell_grid();
        let crown: Vec<f64> = (0..grid.across).map(|j| plan.crown(grid.from_middle(j))).collect();
        let sums = cell_sums(plan, WaveBand::WHOLE);
        let (tread, blocks) = match plan.tread() {
            Some((map, blocks)) => (TreadSurface::with_pattern(crown, &map), blocks),
            None => (crown.into(), None),
        };
        let resting = RestingCells::new(sums.clone(), tread.clone(), blocks.clone());
        Self { loaded, plan, sums, tread, blocks, resting }
    }

    /// Influence between the cells of a window of `columns` columns within an instant.
    fn instant(&self, columns: usize, meter: &mut Meter) -> CellInfluence {
        let Plan { scene, time_step, .. } = self.plan;
        let rate = scene.numerics.time_rule.first_rate(*time_step);
        meter.time(Stage::Influence, || self.sums.cached_instant(rate, columns))
    }

    /// Cells of a window, initially at rest, longer by `margin` columns at either end than the reported one; the
    /// history is that of the `carried` waves, or of direct sums.
    fn zone(&self, instant: CellInfluence, carried: &[CarriedWaves], margin: usize, job: &mut Job<'_>) -> CellZone {
        let numerics = &self.plan.scene.numerics;
        let history: Box<dyn CellHistory<1>> = match numerics.history {
            History::Direct => Box::new(self.direct(instant.columns, &mut job.meter)),
            History::Modal if self.plan.is_single() => Box::new(self.rings::<f32>(instant.columns, carried, job)),
            History::Modal => Box::new(self.rings::<f64>(instant.columns, carried, job)),
        };
        let tolerance = self.plan.cell_tolerance();
        let instant = InstantCells::on_blocks(instant, self.sums.grid(), self.blocks.as_ref());
        CellZone::new(instant, self.tread.clone(), history, tolerance, margin)
    }

    fn bands(&self, columns: usize) -> Vec<WaveBand> {
        match self.plan.scene.numerics.history {
            History::Direct => vec![WaveBand::WHOLE],
            History::Modal => self.plan.wave_bands(columns),
        }
    }

    /// Waves that carry the history through a window of `columns` columns, ring by ring. Fails if a fit is refused, or
    /// stopped.
    fn carried(&self, columns: usize, job: &mut Job<'_>) -> Result<Vec<CarriedWaves>, RunError> {
        let stop = job.stop;
        let carried = |band: WaveBand| -> Result<CarriedWaves, RunError> {
            let grid = self.plan.grid_of(band);
            let rows = band.rows(&grid, self.plan.cell_truncation());
            let options = self.plan.cell_fit();
            let fit = || fit_cells(&band_sums(self.plan, band, &self.sums), &rows, &options, stop);
            let count = PoleModel::evaluations;
            let model = planned_cell_model(self.loaded, self.plan, (band, &rows), fit, count, job)?;
            Ok(CarriedWaves { ring: grid.elements(), rows, model })
        };
        self.bands(columns).into_iter().map(carried).collect()
    }

    /// Influence between cells within an instant, less that of the waves that carry the history.
    fn beyond(&self, mut all: CellInfluence, carried: &[CarriedWaves]) -> CellInfluence {
        let Plan { scene, time_step, .. } = self.plan;
        let rate = scene.numerics.time_rule.first_rate(*time_step);
        let values: Vec<WaveValues> = carried.iter().map(|waves| waves.model.values(rate)).collect();
        let known = carried.iter().zip(&values).map(|(waves, values)| (waves.ring, waves.rows.as_slice(), values));
        all -= &CellInfluence::of_waves(self.sums.grid(), all.columns, known);
        all
    }

    fn direct(&self, columns: usize, meter: &mut Meter) -> DirectCellHistory<1> {
        let rows = self.sums.waves(WaveBand::WHOLE);
        let transform = WaveTransform::new(self.sums.grid(), columns, &rows);
        let rule = self.plan.scene.numerics.time_rule;
        meter.time(Stage::Influence, || {
            DirectCellHistory::new(&self.sums, &rows, transform, rule, self.plan.time_step, self.plan.lags)
        })
    }

    fn rings<N: WaveNumber>(&self, columns: usize, carried: &[CarriedWaves], job: &mut Job<'_>) -> WaveHistory<N> {
        let numerics = &self.plan.scene.numerics;
        let rings = self.bands(columns).into_iter().zip(carried).map(|(band, CarriedWaves { rows, model, .. })| {
            job.meter.count(Counter::Poles, model.order() as u64);
            let grid = self.plan.grid_of(band);
            let seen = self.plan.seen_columns(band, columns);
            let transform = WaveTransform::new(&grid, seen, rows);
            let (rule, time_step) = (numerics.time_rule, self.plan.time_step);
            let next_instant = band.ring.map(|_| {
                job.meter.time(Stage::Influence, || first_influences(&grid, seen, rows, model, rule, time_step))
            });
            let forgotten_after = self.plan.forgotten_after(band, columns);
            let fewer_poles = planned_fewer_poles(self.plan, (band, rows), model, job);
            RingParts { model, transform, next_instant, forgotten_after, advance: numerics.advance(), fewer_poles }
        });
        WaveHistory::new(rings, numerics.time_rule, self.plan.time_step)
    }
}
