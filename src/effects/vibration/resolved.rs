//! Power that forces on cells put into all waves that a run carries.

use super::planned::CellSegments;
use crate::contact::cells::CellProduct;
use crate::counters::{Counter, Meter};
use crate::effects::effect::TyreModels;
use crate::plan::Plan;
use crate::response::LateralForces;
use crate::response::vibration::{
    ContactPower, Dissipation, ResolvedPower, ResolvedQuantities, SegmentLayout, VibrationAccumulator,
    resolved_dissipation,
};
use crate::storage::state::evolving;

/// Power of forces on cells, found beside the velocities.
pub(super) struct ResolvedForces {
    /// Forces in all lateral waves that the run carries.
    carried: LateralForces,
    power: VibrationAccumulator,
    /// Instantaneous influence between cells beyond these waves.
    beyond: CellProduct<f64>,
    /// Displacements of the step's instants by the waves alone \[m\].
    displacements: Vec<f64>,
    /// Power put into the waves.
    put_in: ContactPower,
    columns: usize,
}

impl ResolvedForces {
    /// For a prepared run, whose segments begin as `begin`; `None` without waves.
    pub(super) fn new(
        plan: &Plan,
        models: &mut TyreModels,
        segments: &CellSegments,
        begin: &SegmentLayout,
        meter: &mut Meter,
    ) -> Option<Self> {
        let (waves, beyond) = models.waves.take()?;
        let grid = plan.cell_grid();
        let numbers: Vec<usize> = grid.lateral_numbers().take(segments.carried).collect();
        let SegmentLayout { columns, phase, first_position, .. } = *begin;
        let layout = SegmentLayout { columns, phase, first_position, ..segments.power };
        let power = ResolvedPower::new(&layout, &waves, &numbers);
        let count: usize = waves.iter().map(|waves| waves.model.len()).sum();
        let parts = if plan.decisions.tyre.turns() { 2 } else { 1 };
        let evaluations = parts * count * layout.stages() * layout.stages() * layout.bins();
        meter.count(Counter::VibrationEvaluations, evaluations as u64);
        let cells = beyond.columns * beyond.across;
        let beyond = CellProduct::whole(beyond.columns, &beyond);
        Some(Self {
            carried: LateralForces::new(&grid, numbers),
            power: VibrationAccumulator::resolved(layout, ResolvedQuantities::Power(power)),
            displacements: vec![0.0; layout.stages() * cells],
            put_in: ContactPower::new(layout.rule, layout.time_step, cells),
            beyond,
            columns,
        })
    }

    /// Power that a step's forces \[N\] put into the waves \[W\], from the displacements \[m\], cell by cell from
    /// number `first` on.
    pub(super) fn put_in(&mut self, first: i64, forces: &[f64], displacements: &[f64]) -> f64 {
        let cells = forces.len() / self.layout().stages();
        let by_waves = self.displacements.chunks_exact_mut(cells);
        for (by_waves, (forces, all)) in by_waves.zip(forces.chunks_exact(cells).zip(displacements.chunks_exact(cells)))
        {
            self.beyond.displacement(forces, by_waves);
            by_waves.iter_mut().zip(all).for_each(|(by_waves, all)| *by_waves = all - *by_waves);
        }
        self.put_in.push(first, forces, &self.displacements)
    }

    /// Takes a step's forces, cell by cell \[N\], and the power that they put into the waves \[W\]; true if a segment
    /// of the power is complete.
    pub(super) fn push(&mut self, forces: &[f64], power: f64) -> bool {
        self.power.push(self.carried.of(forces, self.columns), power)
    }

    /// True if the next step completes a segment of the power.
    pub(super) fn completes_next(&self) -> bool {
        self.power.completes_next()
    }

    /// Segments of the power.
    pub(super) fn layout(&self) -> &SegmentLayout {
        self.power.layout()
    }

    /// Power put into the waves \[W\], and the dissipated power.
    pub(super) fn power(&self) -> Option<(f64, Dissipation)> {
        let patch = self.power.finish()?;
        Some((patch.mean_power, resolved_dissipation(&patch)))
    }
}

evolving!(ResolvedForces: power, put_in);
