//! Gaps between tread and road under a tyre that stands on it: where air may be.
//!
//! Cells are pressed on the road as it is at a place of the run, without a history, by the compliance at the rate s =
//! V/a of a passage through half the patch: rubber that rolls is that stiff, and layers hardly move by their mass.
//! Cells that lie deeper than the least depth round the tyre at their place across are those of grooves across. These
//! open and close within 0.2 ms: they do not stand still while they sound, and count as closed.

use super::resting::PressedWindow;
use crate::contact::error::ContactError;
use crate::contact::geometry::Geometry;
use crate::contact::static_contact::StaticContact;
use crate::contact::tread::TreadSurface;
use crate::scene::Axle;
use crate::tyre::influence::CellSums;
use crate::tyre::tread_pattern::blocks::TreadBlocks;

/// Places of a run at which gaps are found.
pub(crate) const PLACES: usize = 8;
/// Relative tolerance of the load.
const LOAD_TOLERANCE: f64 = 1e-3;
/// Most indentations that are tried for it.
const TRIED: usize = 40;
/// How far cells may be from where they are required to be, relative to the indentation.
const TOLERANCE: f64 = 1e-5;

/// Gap between tread and road over a window of cells.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GapMap {
    /// Rear end of the first column and width of a column, from the contact's centre on \[m\].
    along: [f64; 2],
    /// Right end of the first cell and width of a cell, from the middle \[m\].
    beside: [f64; 2],
    /// Cells across.
    pub across: usize,
    /// Height of the gap by cell, column by column; 0 where it is closed \[m\].
    pub heights: Vec<f64>,
}

impl GapMap {
    /// Height \[m\] at a place from the contact's centre, x ahead and y to the left; `None` beyond the map.
    pub(crate) fn height(&self, x: f64, y: f64) -> Option<f64> {
        let cell = |from: f64, size: f64, count: usize| {
            ((from / size).floor() as i64).try_into().ok().filter(|cell: &usize| *cell < count)
        };
        let column = cell(x - self.along[0], self.along[1], self.heights.len() / self.across)?;
        let place = cell(y - self.beside[0], self.beside[1], self.across)?;
        Some(self.heights[column * self.across + place])
    }

    /// Ends of the cells across, from the middle \[m\].
    pub(crate) fn ends(&self) -> impl Iterator<Item = f64> {
        (0..=self.across).map(|end| self.beside[0] + end as f64 * self.beside[1])
    }

    /// Part of the cells within `half_length` \[m\] of the contact's centre along that is closed.
    pub(crate) fn closed(&self, half_length: f64) -> f64 {
        let middle = |column: usize| self.along[0] + (column as f64 + 0.5) * self.along[1];
        let columns = self.heights.chunks_exact(self.across).enumerate();
        let within = columns.filter(|(column, _)| middle(*column).abs() < half_length).flat_map(|(_, cells)| cells);
        let (mut closed, mut count) = (0, 0);
        within.for_each(|height| (closed, count) = (closed + usize::from(*height <= 0.0), count + 1));
        f64::from(closed as u32) / f64::from(count.max(1))
    }
}

/// Cells that stand on a road.
pub(crate) struct StandingCells {
    tread: TreadSurface,
    /// Least depth round the tyre by cell across \[m\].
    least: Vec<f64>,
    window: PressedWindow,
    pitch: f64,
}

impl StandingCells {
    /// Cells in a window that reaches so far from the contact's centre \[m\], with the compliance at a rate \[1/s\].
    pub(crate) fn new(
        sums: &CellSums,
        tread: TreadSurface,
        blocks: Option<&TreadBlocks>,
        rate: f64,
        reach: f64,
    ) -> Self {
        let grid = sums.grid();
        let rows = (0..grid.elements() as i64).map(|element| tread.row(element));
        let least = rows.fold(vec![f64::INFINITY; grid.across], |mut least, row| {
            least.iter_mut().zip(row).for_each(|(least, depth)| *least = least.min(*depth));
            least
        });
        let window = PressedWindow::new(sums, blocks, rate, reach, TOLERANCE);
        Self { tread, least, window, pitch: grid.pitch() }
    }

    /// Elements of the window where the axle stands over the element `under`.
    pub(crate) fn elements(&self, under: i64) -> std::ops::Range<i64> {
        let geometry = &self.window.geometry;
        let first = under + geometry.first_element(0);
        first..first + geometry.columns as i64
    }

    /// Gap under an axle over an element of the road, whose heights under the window are given.
    ///
    /// # Errors
    /// [`ContactError::LoadNotReached`].
    pub(crate) fn gap(
        &mut self,
        axle: &Axle,
        at_rest: &StaticContact,
        under: i64,
        heights: &[f64],
    ) -> Result<GapMap, ContactError> {
        let mut indentation = at_rest.indentation;
        let Self { tread, window, .. } = self;
        let mut pressed = |indentation: f64| -> f64 { window.press(tread, under, indentation, heights).iter().sum() };
        let mut force = pressed(indentation);
        // 1. Indentation that carries the load.
        if let Axle::Load { load, .. } | Axle::Mass { load, .. } = *axle {
            let mut stiffness = at_rest.stiffness;
            let mut tried = 1;
            while (force - load).abs() > LOAD_TOLERANCE * load {
                if tried == TRIED {
                    return Err(ContactError::LoadNotReached { load, indentation, force });
                }
                let step = (load - force) / stiffness;
                let next = pressed(indentation + step);
                // The secant, unless contact is only about to begin.
                let secant = (next - force) / step;
                stiffness = if secant > 0.1 * at_rest.stiffness { secant } else { at_rest.stiffness };
                (indentation, force, tried) = (indentation + step, next, tried + 1);
            }
        }
        // 2. Heights of the gap: 0 where cells touch, u - d elsewhere.
        let PressedWindow { search, required, forces, .. } = window;
        let across = tread.across();
        let mut heights = vec![0.0; forces.len()];
        search.cells_mut().displacement(forces, &mut heights);
        heights.iter_mut().zip(&*required).zip(&*forces).for_each(|((u, d), force)| {
            *u = if *force > 0.0 { 0.0 } else { (*u - d).max(0.0) };
        });
        // 3. Grooves across count as closed.
        for (element, heights) in self.elements(under).zip(heights.chunks_exact_mut(across)) {
            let row = heights.iter_mut().zip(self.tread.row(element)).zip(&self.least);
            row.filter(|((_, depth), least)| depth > least).for_each(|((height, _), _)| *height = 0.0);
        }
        let Geometry { element, .. } = self.window.geometry;
        let first = self.window.geometry.position(self.window.geometry.first_element(0), 0) - 0.5 * element;
        let beside = [-0.5 * across as f64 * self.pitch, self.pitch];
        Ok(GapMap { along: [first, element], beside, across, heights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::cells::resting::RestingCells;
    use crate::scene::{DEFAULT, Scene};
    use crate::tyre::influence::{CellGrid, CellTruncation};

    fn sums() -> CellSums {
        let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
        let truncation = CellTruncation { lateral_terms: None, aliases: None };
        CellSums::new(&tyre, CellGrid::new(&tyre, 128, 6), truncation, 1e-6, 0.0)
    }

    #[test]
    fn a_smooth_road_is_touched_by_the_patch_between_rising_ends() {
        let axle = Axle::Load { load: 3400.0, tolerance: 0.1 };
        let tread = TreadSurface::from(vec![0.0; 6]);
        let at_rest = RestingCells::new(sums(), tread.clone(), None).under(&axle).unwrap();
        let mut cells = StandingCells::new(&sums(), tread, None, 0.0, 0.12);
        let count = cells.window.required.len();
        let gap = cells.gap(&axle, &at_rest, 17, &vec![0.0; count]).unwrap();
        // The same contact as at rest: all cells of the patch touch, and no others.
        assert!(gap.closed(0.5 * at_rest.length - 1e-6) > 0.99, "{}", gap.closed(0.5 * at_rest.length));
        let element = 1.95 / 128.0;
        for steps in [5, 6, 7] {
            let x = f64::from(steps) * element;
            let (ahead, behind) = (gap.height(x, 0.0).unwrap(), gap.height(-x, 0.0).unwrap());
            assert!((ahead - behind).abs() < 1e-5 && ahead > 0.0, "{ahead} {behind}");
            // Between the round tyre's rise over the patch, and that over where it would touch without bending.
            let rise = cells.window.geometry.rise(x);
            assert!(ahead < rise, "{x}: {ahead} {rise}");
        }
        assert_eq!((gap.height(0.2, 0.0), gap.height(0.0, 0.07)), (None, None));
        // A road that is higher by the same everywhere leaves the same gaps; pits under single cells stay open.
        let raised = cells.gap(&axle, &at_rest, 17, &vec![2e-3; count]).unwrap();
        assert!((raised.closed(0.03) - gap.closed(0.03)).abs() < 1e-12);
        let mut pits = vec![0.0; count];
        let middle = count / 2 / 6 * 6;
        pits[middle + 3] = -5e-3;
        let pitted = cells.gap(&axle, &at_rest, 17, &pits).unwrap();
        let open: Vec<usize> = (middle - 12..middle + 12).filter(|cell| pitted.heights[*cell] > 0.0).collect();
        assert_eq!(open, [middle + 3]);
        // A groove across is closed, though it touches nothing.
        let element = (middle / 6) as i64 + cells.elements(17).start;
        let mut depths = vec![0.0; 128 * 6];
        depths[element.rem_euclid(128) as usize * 6..][..6].fill(8e-3);
        let map = crate::tyre::tread_pattern::map::TreadMap::of_depths(128, 6, depths);
        let cut = TreadSurface::with_pattern(vec![0.0; 6], &map);
        let mut cells = StandingCells::new(&sums(), cut, None, 0.0, 0.12);
        let closed = cells.gap(&axle, &at_rest, 17, &vec![0.0; count]).unwrap();
        assert!(closed.heights[middle..middle + 6].iter().all(|height| *height <= 0.0));
        assert!(cells.window.forces[middle..middle + 6].iter().all(|force| *force <= 0.0));
        assert!((2e-3..5e-3).contains(&pitted.heights[middle + 3]), "{}", pitted.heights[middle + 3]);
    }
}
