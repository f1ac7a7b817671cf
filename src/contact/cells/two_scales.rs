//! Contact on two scales: cells carry the waves of the tyre and their history, their sub-cells touch the road.
//!
//! With f the forces of sub-cells, P of `interpolation` and c of `creep`:
//!
//! ```text
//! u = P^T (G_c + history) P f + S c,   S = g - P^T g_c P
//! ```
//!
//! - G_c and the history are those of the cells, as without sub-cells;
//! - g and g_c are influences between sub-cells and between cells of a tread without inertia at the rule's first rate:
//!   S is what sub-cells yield beyond what cells carry. It is not cut off. (Influences at rest in their place let the
//!   motion grow: their long waves are compliant, and P^T g_c P is not quite all of them.)
//! - Within an instant, P^T (G_c - g_c) P is replaced by its mean over the places of sub-cells within a cell: of each
//!   wave the share that cells carry ([`carried_share`]) has the tyre's compliance, the rest that without inertia. So
//!   the search has an influence between sub-cells like any other, definite wave by wave.
//!
//! Waves shorter than two cells have no inertia: 8 % of their compliance at 2 kHz for cells of 3.8 mm. Measured against
//! cells as small as the sub-cells (profiles/README.md): within 0.2 dB to 1 kHz.

use std::f64::consts::PI;
use std::ops::Range;

use super::creep::Creep;
use super::instant::InstantCells;
use super::interpolation::{Interpolation, passed};
use super::product::CellProduct;
use super::zone::{CellHistory, Cells, require_row};
use crate::contact::complementarity::SearchCounts;
use crate::contact::error::ContactError;
use crate::contact::footprint::{StageMut, add_to_cells};
use crate::contact::zone::{ContactZone, Instant, Solved};
use crate::counters::Meter;
use crate::numeric::sinc;
use crate::road::strip::RoadStrip;
use crate::scene::Material;
use crate::storage::state::{Evolving, StateError, StateStream, ensure, evolving};
use crate::time_rule::TimeRule;
use crate::tyre::influence::{CellInfluence, carried};

/// Columns on either side of the contact whose sub-cells creep, and again whose displacements by creep count.
const AROUND: usize = 2;

/// Share of a wave's compliance between sub-cells that cells carry, by its phases over a cell along and across.
pub(crate) fn carried_share(sub_cells: usize, phases: [f64; 2]) -> f64 {
    let share = |phase: f64| {
        if phase.abs() >= PI {
            return 0.0;
        }
        let of_cell = sinc(0.5 * phase) * passed(sub_cells, phase) / sinc(0.5 * phase / sub_cells as f64);
        carried(phase) * of_cell * of_cell
    };
    phases.map(share).into_iter().product()
}

/// History of sub-cells: that of their cells, and their creep.
pub(crate) struct TwoScaleHistory {
    cells: Box<dyn CellHistory<1>>,
    between: Interpolation,
    /// g, on parts of the window.
    sub_cells: InstantCells,
    /// g_c.
    cell_product: CellProduct<f64>,
    creep: Creep,
    first_element: i64,
    /// Columns whose sub-cells creep: those in contact and [`AROUND`].
    active: Range<usize>,
    /// Displacements of cells by past forces \[m\].
    of_cells: Vec<f64>,
    /// Forces of cells, P f \[N\].
    forces: Vec<f64>,
    scratch: [Vec<f64>; 2],
    /// c of past forces, and displacements by it.
    single: [Vec<f32>; 2],
}

impl TwoScaleHistory {
    /// History without forces: `cells` is that of the cells, `light` the influences g and g_c.
    pub(crate) fn new(
        cells: Box<dyn CellHistory<1>>,
        between: Interpolation,
        [sub_cells, coarse]: [CellInfluence; 2],
        tread: Option<&Material>,
        rule: TimeRule,
        time_step: f64,
    ) -> Self {
        let [cells_of_window, fine] = [&coarse, &sub_cells].map(|influence| influence.columns * influence.across);
        let zeros = || vec![0.0; cells_of_window];
        Self {
            cells,
            between,
            cell_product: CellProduct::whole(coarse.columns, &coarse),
            sub_cells: InstantCells::new(sub_cells),
            creep: Creep::new(tread, rule, time_step, fine),
            first_element: i64::MIN,
            active: 0..0,
            of_cells: zeros(),
            forces: zeros(),
            scratch: [zeros(), zeros()],
            single: [vec![0.0; fine], vec![0.0; fine]],
        }
    }

    /// Adds S c of past forces, but for the part -P^T g_c P c, which is subtracted from `field`.
    fn add_creep(&mut self, stage: usize, field: &mut [f64], out: &mut [f64]) {
        let Self { between, sub_cells, creep, active, scratch: [_, displacement], forces, single, .. } = self;
        let [c, u] = single;
        let range = between.of_columns(active.clone());
        c.fill(0.0);
        creep.remember(stage, range.clone(), &mut c[range]);
        if active.start == active.end {
            return;
        }
        let (sub_columns, per_cell) = (sub_cells.columns(), between.sub_cells());
        let start = active.start.saturating_sub(AROUND) * per_cell;
        let length = sub_cells.part(((active.end + AROUND) * per_cell).min(sub_columns) - start);
        let start = start.min(sub_columns - length);
        let part = start * sub_cells.across()..(start + length) * sub_cells.across();
        sub_cells.single_displacement(&c[part.clone()], &mut u[part.clone()]);
        out[part.clone()].iter_mut().zip(&u[part]).for_each(|(out, u)| *out += f64::from(*u));
        between.spread(c, forces);
        self.cell_product.displacement(forces, displacement);
        field.iter_mut().zip(&*displacement).for_each(|(field, u)| *field -= u);
    }
}

impl CellHistory<1> for TwoScaleHistory {
    fn add_displacement(&mut self, stage: usize, first_element: i64, out: &mut [[f64; 1]], meter: &mut Meter) {
        let out = out.as_flattened_mut();
        // 1. The window moves on.
        let columns = out.len() / self.between.of_columns(0..1).end;
        let shift = usize::try_from(first_element.saturating_sub(self.first_element)).unwrap_or(usize::MAX);
        let shift = shift.min(columns);
        self.first_element = first_element;
        if shift > 0 {
            self.active = self.active.start.saturating_sub(shift)..self.active.end.saturating_sub(shift);
            self.creep.advance(self.between.of_columns(0..shift).end);
        }
        // 2. Cells.
        self.of_cells.fill(0.0);
        self.cells.add_displacement(stage, first_element, self.of_cells.as_chunks_mut().0, meter);
        // 3. What sub-cells remember.
        let mut field = std::mem::take(&mut self.scratch[0]);
        field.copy_from_slice(&self.of_cells);
        self.add_creep(stage, &mut field, out);
        self.between.add_interpolated(&field, out);
        self.scratch[0] = field;
    }

    fn push(&mut self, stage: usize, first_element: i64, forces: &[[f64; 1]]) -> bool {
        let forces = forces.as_flattened();
        let of_column = self.between.of_columns(0..1).end;
        let columns = forces.len() / of_column;
        let is_touched = |force: &f64| *force > 0.0;
        if let (Some(first), Some(last)) = (forces.iter().position(is_touched), forces.iter().rposition(is_touched)) {
            self.active = (first / of_column).saturating_sub(AROUND)..(last / of_column + 1 + AROUND).min(columns);
            self.creep.forget(self.between.of_columns(0..self.active.start));
            self.creep.forget(self.between.of_columns(self.active.end..columns));
        }
        let range = self.between.of_columns(self.active.clone());
        self.creep.push(stage, range.clone(), &forces[range]);
        self.between.spread(forces, &mut self.forces);
        self.cells.push(stage, first_element, self.forces.as_chunks().0)
    }
}

impl Evolving for TwoScaleHistory {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.value(&mut self.active)?;
        let columns = self.of_cells.len();
        ensure(self.active.start <= self.active.end && self.active.end <= columns)?;
        state.all([&mut self.cells, &mut self.creep, &mut self.first_element])
    }
}

/// The sub-cells of a window.
pub(crate) struct TwoScaleZone {
    /// Cells across.
    across: usize,
    /// Columns of cells beyond either end of the reported part.
    margin: usize,
    /// Depths of the undeformed tread by sub-cell across \[m\].
    crown: Vec<f64>,
    cells: Cells<TwoScaleHistory>,
    /// G_c.
    instant: CellProduct<f64>,
    /// Displacements of cells, and what they are required to be on average \[m\].
    displacement: Vec<f64>,
    required: Vec<f64>,
}

impl TwoScaleZone {
    /// Zone at rest: `searched` is the influence between sub-cells that is searched with, `instant` G_c; others as for
    /// [`super::CellZone::new`].
    pub(crate) fn new(
        [searched, instant]: [CellInfluence; 2],
        crown: Vec<f64>,
        history: TwoScaleHistory,
        tolerance: f64,
        margin: usize,
    ) -> Self {
        let zeros = || vec![0.0; instant.columns * instant.across];
        Self {
            across: instant.across,
            margin,
            crown,
            displacement: zeros(),
            required: zeros(),
            instant: CellProduct::whole(instant.columns, &instant),
            cells: Cells::new(InstantCells::new(searched), instant.columns, Box::new(history), tolerance),
        }
    }
}

impl ContactZone for TwoScaleZone {
    fn solve(
        &mut self,
        at: Instant<'_>,
        road: &RoadStrip,
        mut output: StageMut<'_>,
        meter: &mut Meter,
    ) -> Result<Solved, ContactError> {
        let per_cell = self.cells.history.between.sub_cells();
        let width = self.crown.len();
        let columns = self.displacement.len() / self.across;
        // 1. Contact of the sub-cells.
        let solved = self.cells.solve(&at, road, meter, |column, heights, required, old| {
            // The circle of the tread between three columns is a parabola.
            let middle = column.clamp(1, columns - 2);
            let [before, here, after] = [-1, 0, 1].map(|offset| at.rises[middle.wrapping_add_signed(offset)]);
            let rows = required.chunks_exact_mut(width).zip(old.chunks_exact(width)).zip(heights.chunks_exact(width));
            for (row, ((required, old), heights)) in rows.enumerate() {
                let x = column as f64 - middle as f64 + (row as f64 + 0.5) / per_cell as f64 - 0.5;
                let rise = here + 0.5 * x * (after - before) + 0.5 * x * x * (after - 2.0 * here + before);
                require_row(required, at.indentation - rise, &self.crown, heights, old);
            }
        })?;
        // 2. Displacements of the cells by all forces.
        let TwoScaleHistory { forces, of_cells, .. } = &*self.cells.history;
        self.instant.displacement(forces, &mut self.displacement);
        self.displacement.iter_mut().zip(of_cells).for_each(|(u, old)| *u += old);
        let mean = 1.0 / (per_cell * per_cell) as f64;
        self.required.fill(0.0);
        add_to_cells(&self.cells.required, [per_cell, self.across], mean, &mut self.required);
        // 3. Both are reported.
        let outside = self.margin * self.across;
        let reported = outside..forces.len() - outside;
        output.write(reported, self.across, forces, &self.required, |cell| self.displacement[cell]);
        if let Some(sub_cells) = &mut output.sub_cells {
            let (between, cells) = (&self.cells.history.between, &self.cells);
            let (reported, of_column) = (self.margin..columns - self.margin, between.of_columns(0..1).end);
            let reported = between.of_columns(reported);
            sub_cells.write(reported, of_column, &cells.forces, |sub_cell| cells.displacement(sub_cell));
        }
        Ok(solved)
    }

    fn across(&self) -> usize {
        self.across
    }

    fn sub_cells(&self) -> usize {
        self.cells.history.between.sub_cells()
    }

    fn margin(&self) -> usize {
        self.margin
    }

    fn is_widened(&self) -> bool {
        true
    }

    fn first_weights(&self) -> &[f64] {
        self.cells.first_weights()
    }

    fn search_counts(&self) -> SearchCounts {
        self.cells.search_counts()
    }
}

evolving!(TwoScaleZone: cells);
