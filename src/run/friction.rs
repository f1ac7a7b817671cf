//! Contact over cells with friction, made for a planned scene.

use crate::contact::cells::CellHistory;
use crate::contact::cells::component_transforms::ComponentTransforms;
use crate::contact::cells::direct::DirectCellHistory;
use crate::contact::cells::wave_transform::WaveNumber;
use crate::contact::friction::free_creep::FreeCreep;
use crate::contact::friction::law::CellLaw;
use crate::contact::friction::modal::{TractionHistory, TractionRing};
use crate::contact::friction::search::FrictionSearch;
use crate::contact::friction::wave_group::Stepping;
use crate::contact::friction::zone::{CellMotion, FrictionZone};
use crate::contact::geometry::Geometry;
use crate::contact::march::March;
use crate::contact::static_contact::StaticContact;
use crate::contact::tread::TreadSurface;
use crate::counters::{Counter, Job, Stage};
use crate::effects::RunError;
use crate::plan::Plan;
use crate::plan::models::{band_sums, planned_cell_model};
use crate::scene::{Friction, History, LoadedScene, LongitudinalCreep};
use crate::tyre::influence::{COMPONENTS, CellGrid, CellRow, CellSums, WaveBand};
use crate::tyre::poles::traction_model::TractionModel;
use crate::tyre::poles::tractions::fit_tractions;

/// Waves of a band, with their poles.
struct Carried {
    band: WaveBand,
    grid: CellGrid,
    rows: Vec<CellRow>,
    model: TractionModel,
}

pub(super) struct FrictionContact<'a> {
    /// Scene as loaded.
    pub loaded: &'a LoadedScene,
    /// Plan of the scene.
    pub plan: &'a Plan,
    /// Sums of the influence functions.
    pub sums: &'a CellSums,
    /// Depths of the tread's surface.
    pub tread: &'a TreadSurface,
    /// The scene's `[friction]`.
    pub friction: &'a Friction,
}

impl FrictionContact<'_> {
    /// March of cells with friction, over a window longer by `margin` columns at either end than the reported one;
    /// `at_rest` is the static contact.
    ///
    /// # Errors
    /// A rule without a first rate; a fit that is refused, or stopped.
    pub(super) fn march(
        &self,
        at_rest: StaticContact,
        (output_window, margin): (Geometry, usize),
        job: &mut Job<'_>,
    ) -> Result<March, RunError> {
        let Self { plan, sums, tread, friction, .. } = *self;
        let Plan { scene, time_step, .. } = plan;
        let (grid, rule) = (sums.grid(), scene.numerics.time_rule);
        let rate = rule.first_rate(*time_step);
        let revolution = plan.steps_per_revolution();
        let (given, free) = match friction.creep.longitudinal {
            LongitudinalCreep::Given(creep) => (creep, None),
            LongitudinalCreep::Free => {
                (0.0, Some(FreeCreep::new(at_rest, plan.radius, revolution, plan.warm_up_steps)))
            }
        };
        let rolling = CellMotion {
            geometry: output_window.clone(),
            margin,
            lateral: (0..grid.across).map(|j| grid.from_middle(j)).collect(),
            tread: tread.clone(),
            face: grid.length() * grid.pitch(),
            speed: plan.speed,
            longitudinal: free.as_ref().map_or(given, FreeCreep::creep),
            free,
            creep: friction.creep.clone(),
            rule,
            time_step: *time_step,
        };
        let window = output_window.columns + 2 * margin;
        let columns = window + rolling.ahead(window);
        let influence = job.meter.time(Stage::Influence, || sums.traction_instant(rate, columns));
        let history = self.history(columns, job)?;
        let cells = grid.elements() * grid.across;
        let law = CellLaw::new(friction.coefficient(), scene.adhesion.clone(), *time_step, cells);
        let search = FrictionSearch::new(influence, plan.friction_tolerance());
        Ok(March::over(Box::new(FrictionZone::new(rolling, history, search, law)), output_window, rule, *time_step))
    }

    fn history(&self, columns: usize, job: &mut Job<'_>) -> Result<Box<dyn CellHistory<COMPONENTS>>, RunError> {
        let Self { plan, sums, .. } = *self;
        let (grid, rule, time_step) = (sums.grid(), plan.scene.numerics.time_rule, plan.time_step);
        if plan.scene.numerics.history == History::Direct {
            let rows = sums.traction_rows(WaveBand::WHOLE);
            let transforms = ComponentTransforms::of_tractions(grid, columns, &rows);
            let history = || DirectCellHistory::of_tractions(sums, &rows, transforms, rule, time_step, plan.lags);
            return Ok(Box::new(job.meter.time(Stage::Influence, history)));
        }
        let stop = job.stop;
        let carried = |band: WaveBand| -> Result<Carried, RunError> {
            let grid = plan.grid_of(band);
            let rows = band.traction_rows(&grid, plan.cell_truncation());
            let options = plan.cell_fit();
            let fit = || fit_tractions(&band_sums(plan, band, sums), &rows, &options, stop);
            let count = TractionModel::evaluations;
            let model = planned_cell_model(self.loaded, plan, (band, &rows), fit, count, job)?;
            job.meter.count(Counter::Poles, model.order() as u64);
            Ok(Carried { band, grid, rows, model })
        };
        let carried = plan.wave_bands(columns).into_iter().map(carried).collect::<Result<Vec<_>, _>>()?;
        Ok(job.meter.time(Stage::Influence, || -> Box<dyn CellHistory<COMPONENTS>> {
            if plan.is_single() {
                Box::new(self.waves::<f32>(columns, &carried))
            } else {
                Box::new(self.waves::<f64>(columns, &carried))
            }
        }))
    }

    /// Waves of all rings.
    fn waves<R: WaveNumber>(&self, columns: usize, carried: &[Carried]) -> TractionHistory<R> {
        let Plan { scene, time_step, fit, .. } = self.plan;
        TractionHistory::new(carried.iter().map(|Carried { band, grid, rows, model }| {
            let columns = self.plan.seen_columns(*band, columns);
            let stepping = Stepping {
                rule: scene.numerics.time_rule,
                time_step: *time_step,
                advance: scene.numerics.advance(),
                tolerance: fit.tolerance,
                forgotten_after: self.plan.forgotten_after(*band, columns),
            };
            let transform = ComponentTransforms::of_tractions(grid, columns, rows);
            TractionRing { model, transform, seen: band.ring.map(|_| grid.across), stepping }
        }))
    }
}
