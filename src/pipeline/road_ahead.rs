//! The road ahead of the tyre: heights and curves, made in chunks.

use super::error::RunError;
use crate::contact::slice_queue::SliceQueue;
use crate::meter::{Counter, Meter, Stage};
use crate::road::RoadSurface;
use crate::road::slices::{SliceBuilder, StiffnessCurve};

/// Rows of road that are made at a time.
const CHUNK_ROWS: usize = 512;
/// Longest period of a repeated road whose curves are kept.
const LONGEST_PERIOD: i64 = 100_000;

/// Slices as the tyre reaches them. Memory does not grow with the way rolled; the curves of a road that repeats are made once.
pub struct RoadAhead {
    surface: RoadSurface,
    builder: SliceBuilder,
    queue: SliceQueue,
    /// First and last element with road under it, for a road that ends.
    elements: Option<(i64, i64)>,
    heights: Vec<f64>,
    /// Curves of one period of a road that repeats.
    period: Vec<Option<StiffnessCurve>>,
}

impl RoadAhead {
    /// Nothing made yet; `queue` says where it will begin.
    pub fn new(surface: RoadSurface, builder: SliceBuilder, queue: SliceQueue, elements: Option<(i64, i64)>) -> Self {
        let period = surface.period().filter(|&period| period <= LONGEST_PERIOD).unwrap_or(0);
        Self { surface, builder, queue, elements, heights: Vec::new(), period: vec![None; period as usize] }
    }

    /// Makes sure that the slices of elements `first`..`end` are there, as far as there is road.
    ///
    /// # Errors
    /// Of the road and of its slices.
    pub fn reach(&mut self, first: i64, end: i64, meter: &mut Meter) -> Result<(), RunError> {
        self.queue.forget_before(first);
        let end = self.elements.map_or(end, |(_, last)| end.min(last + 1));
        while self.queue.end() < end {
            let begin = self.queue.end();
            if let Some(curve) = self.kept(begin) {
                self.queue.extend([curve]);
                continue;
            }
            let rows = match self.elements {
                Some((_, last)) => CHUNK_ROWS.min((last + 1 - begin) as usize),
                None => CHUNK_ROWS,
            };
            let columns = self.surface.lattice().columns;
            self.heights.resize(rows * columns, 0.0);
            meter.time(Stage::Road, || self.surface.heights(begin, rows, &mut self.heights))?;
            let curves = meter.time(Stage::Slices, || self.builder.build_rows(&self.heights))?;
            meter.count(Counter::Slices, rows as u64);
            let period = self.period.len() as i64;
            if period > 0 {
                for (element, curve) in (begin..).zip(&curves) {
                    self.period[element.rem_euclid(period) as usize] = Some(curve.clone());
                }
            }
            self.queue.extend(curves);
        }
        Ok(())
    }

    /// The curve of an element that an earlier pass has made.
    fn kept(&self, element: i64) -> Option<StiffnessCurve> {
        let period = self.period.len() as i64;
        if period == 0 { None } else { self.period[element.rem_euclid(period) as usize].clone() }
    }

    /// The slices.
    pub fn slices(&self) -> &SliceQueue {
        &self.queue
    }
}
