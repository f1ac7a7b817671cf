//! The contact of one instant over all cells of the window.

use super::instant::InstantCells;
use super::search::{CellCounts, CellSearch};
use crate::contact::complementarity::{Residuals, SearchCounts};
use crate::contact::error::ContactError;
use crate::contact::footprint::StageMut;
use crate::contact::tread::TreadSurface;
use crate::contact::zone::{ContactZone, Instant, Solved};
use crate::counters::{Meter, Stage, Work};
use crate::numeric::largest_or_zero;
use crate::road::strip::RoadStrip;
use crate::storage::state::{Evolving, StateError, StateStream, evolving};

/// A history of forces on cells: displacements by those of past steps, in `C` components: 1, normal forces, or 3,
/// tractions.
pub trait CellHistory<const C: usize>: Evolving + Send {
    /// Adds the displacements by past forces at a stage of the coming step \[m\]. Stages are taken in their order, the
    /// forces of each pushed before the next.
    fn add_displacement(&mut self, stage: usize, first_element: i64, out: &mut [[f64; C]], meter: &mut Meter);

    /// Takes the forces of a stage \[N\]; false if they are too far apart to be remembered.
    fn push(&mut self, stage: usize, first_element: i64, forces: &[[f64; C]]) -> bool;
}

/// Contact of the cells of a window, or of their sub-cells, column by column.
pub(super) struct Cells<H: ?Sized> {
    /// Cells of a column.
    of_column: usize,
    pub(super) history: Box<H>,
    search: CellSearch,
    /// Forces of the last instant, then of this one \[N\], and the element that they begin with.
    pub(super) forces: Vec<f64>,
    first_element: i64,
    pub(super) required: Vec<f64>,
    /// Displacements by past forces \[m\].
    old: Vec<f64>,
}

/// Sets required displacements of a row of cells, `indentation` being that of the rigid tyre there \[m\].
pub(super) fn require_row(required: &mut [f64], indentation: f64, crown: &[f64], heights: &[f64], old: &[f64]) {
    let cells = required.iter_mut().zip(old).zip(heights).zip(crown);
    for (((required, old), height), crown) in cells {
        *required = indentation - crown + height - old;
    }
}

impl<H: CellHistory<1> + ?Sized> Cells<H> {
    /// Cells at rest on `columns` columns.
    pub(super) fn new(instant: InstantCells, columns: usize, history: Box<H>, tolerance: f64) -> Self {
        let cells = instant.cells();
        Self {
            of_column: cells / columns,
            history,
            search: CellSearch::new(instant, tolerance),
            forces: vec![0.0; cells],
            first_element: i64::MIN,
            required: vec![0.0; cells],
            old: vec![0.0; cells],
        }
    }

    /// Displacement of a cell by all forces \[m\].
    pub(super) fn displacement(&self, cell: usize) -> f64 {
        self.old[cell] + self.search.displacement()[cell]
    }

    pub(super) fn first_weights(&self) -> &[f64] {
        self.search.cells().free_field()
    }

    pub(super) fn search_counts(&self) -> SearchCounts {
        let CellCounts { iterations, fallbacks, work, .. } = self.search.counts();
        SearchCounts { solves: iterations, fallbacks, work, ..SearchCounts::default() }
    }

    /// Solves for the contact at an instant; `require` sets the required displacements of a column from the heights of
    /// the road and the displacements by past forces there.
    pub(super) fn solve(
        &mut self,
        at: &Instant<'_>,
        road: &RoadStrip,
        meter: &mut Meter,
        mut require: impl FnMut(usize, &[f64], &mut [f64], &[f64]),
    ) -> Result<Solved, ContactError> {
        let Instant { step, stage, first_element, .. } = *at;
        if !road.has_heights() {
            return Err(ContactError::RoadForm);
        }
        let cells = self.forces.len();
        let old = &mut self.old;
        let mut laps = meter.laps();
        old.fill(0.0);
        self.history.add_displacement(stage, first_element, old.as_chunks_mut().0, meter);
        meter.lap(&mut laps, Stage::History);
        let required = self.required.chunks_exact_mut(self.of_column).zip(old.chunks_exact(self.of_column));
        for (column, (element, (required, old))) in (first_element..).zip(required).enumerate() {
            match road.heights(element) {
                Some(heights) => require(column, heights, required, old),
                None => required.fill(f64::NEG_INFINITY),
            }
        }
        meter.add_work(Stage::Penetration, Work { multiply_adds: 4 * cells as u64, bytes: 40 * cells as u64 });
        meter.lap(&mut laps, Stage::Penetration);
        // Cells are material: forces move with them through the window.
        let shift = usize::try_from(first_element.saturating_sub(self.first_element)).unwrap_or(usize::MAX);
        let shift = shift.saturating_mul(self.of_column).min(cells);
        if self.forces[..shift].iter().all(|force| *force <= 0.0) {
            self.search.advance(shift);
        }
        if shift > 0 {
            self.forces.copy_within(shift.., 0);
            self.forces[cells - shift..].fill(0.0);
        }
        self.first_element = first_element;
        self.search.cells_mut().place(first_element);
        let relative = self.search.solve(&self.required, &mut self.forces);
        if self.search.is_unsettled() {
            let points = self.forces.iter().filter(|force| **force > 0.0).count();
            return Err(ContactError::Unsettled { points, step });
        }
        let largest_displacement = largest_or_zero(&self.required);
        let largest_force = largest_or_zero(&self.forces);
        meter.lap(&mut laps, Stage::ActiveSet);
        let is_seen = self.history.push(stage, first_element, self.forces.as_chunks().0);
        meter.lap(&mut laps, Stage::History);
        let is_touched = |column: Option<&[f64]>| column.is_some_and(|cells| cells.iter().any(|&force| force > 0.0));
        let mut columns = self.forces.chunks_exact(self.of_column);
        let is_at_end = is_touched(columns.next()) || is_touched(columns.next_back()) || !is_seen;
        let residuals = Residuals {
            tension: relative.tension * largest_force,
            penetration: relative.penetration * largest_displacement,
            complementarity: relative.complementarity * largest_displacement * largest_force,
        };
        let has_no_nan = self.required.iter().fold(true, |none, required| none & !required.is_nan());
        Ok(Solved { residuals, largest_force, largest_displacement, has_no_nan, is_at_end })
    }
}

impl<H: CellHistory<1> + ?Sized> Evolving for Cells<H> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.history, &mut self.search, &mut self.forces, &mut self.first_element])
    }
}

/// The cells of a window. It may be longer than the one whose forces are reported: what is beyond its ends then counts
/// with their columns.
pub(crate) struct CellZone {
    across: usize,
    /// Columns of the window beyond either end of the reported part.
    margin: usize,
    /// The undeformed tread.
    tread: TreadSurface,
    cells: Cells<dyn CellHistory<1>>,
}

impl CellZone {
    /// Zone at rest, `instant` being the influence between cells at an instant. `tolerance` is how far a cell may be
    /// from where it is required to be, relative to the largest required displacement. The window is longer by
    /// `margin` columns at either end than the reported part.
    pub(crate) fn new(
        instant: InstantCells,
        tread: TreadSurface,
        history: Box<dyn CellHistory<1>>,
        tolerance: f64,
        margin: usize,
    ) -> Self {
        let (across, columns) = (instant.across(), instant.columns());
        Self { across, margin, tread, cells: Cells::new(instant, columns, history, tolerance) }
    }
}

impl ContactZone for CellZone {
    fn solve(
        &mut self,
        at: Instant<'_>,
        road: &RoadStrip,
        mut output: StageMut<'_>,
        meter: &mut Meter,
    ) -> Result<Solved, ContactError> {
        let tread = &self.tread;
        let solved = self.cells.solve(&at, road, meter, |column, heights, required, old| {
            let crown = tread.row(at.first_element + column as i64);
            require_row(required, at.indentation - at.rises[column], crown, heights, old);
        })?;
        let (cells, outside) = (&self.cells, self.margin * self.across);
        let reported = outside..cells.forces.len() - outside;
        output.write(reported, self.across, &cells.forces, &cells.required, |cell| cells.displacement(cell));
        Ok(solved)
    }

    fn across(&self) -> usize {
        self.across
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

evolving!(CellZone: cells);
