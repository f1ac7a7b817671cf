//! The road ahead of the tyre: heights and slices, made in chunks.

use std::ops::Range;

use super::maker::{MakingError, RoadMaker, SliceForm};
use super::strip::{RoadSlice, RoadStrip};
use super::surface::RoadSurface;
use crate::counters::{Counter, Meter};
use crate::storage::state::{Evolving, StateError, StateStream, ensure};

/// Number of elements whose road is made at a time.
pub(crate) const CHUNK_ROWS: i64 = 512;

/// Longest period of a repeated road for which curves are stored \[elements\].
const LONGEST_PERIOD: i64 = 100_000;

/// Slices as the tyre reaches them. Memory does not grow with the distance rolled; the slices of a road that repeats
/// are made once.
///
/// Only chunks that the tyre has reached are counted, stored and saved, not those made in advance in the background:
/// the result is the same for any number of threads.
pub struct RoadAhead {
    maker: RoadMaker,
    queue: RoadStrip,
    /// First and last element with road under it, for a road that ends.
    elements: Option<(i64, i64)>,
    /// Slices of one period of a road that repeats.
    period: Vec<Option<RoadSlice>>,
    /// The first element made, and the one after the last.
    made: (i64, i64),
    /// The element after the last one made, or begun in the background.
    begun: i64,
    /// The element after the last one that the run will reach.
    reached: i64,
    /// Largest error of the curves taken so far \[m\].
    slice_error: f64,
    /// Elements whose slices were in the queue of a restored road, for [`Self::refill`].
    missing: Range<i64>,
}

impl RoadAhead {
    /// A road of which no slice is made yet; `queue` says where it will begin. `elements` are the first and last one of
    /// a road that ends; `reached` is the one after the last that the run will reach.
    pub fn new(
        surface: RoadSurface,
        form: SliceForm,
        queue: RoadStrip,
        elements: Option<(i64, i64)>,
        reached: i64,
    ) -> Self {
        // Curves that depend on the tread repeat with the tyre, too.
        let repeats = !matches!(form, SliceForm::Voids(..));
        let period = surface.period().filter(|&period| repeats && period <= LONGEST_PERIOD).unwrap_or(0);
        let begun = queue.end();
        let maker = RoadMaker::new(surface, form);
        let (period, made) = (vec![None; period as usize], (begun, begun));
        Self { maker, queue, elements, period, made, begun, reached, slice_error: 0.0, missing: 0..0 }
    }

    /// Makes the slices of elements `first`..`end` available, as far as there is road. One thread makes them when they
    /// are needed; with more threads chunks are made in the background in advance.
    ///
    /// # Errors
    /// Errors of the road and of its slices.
    pub fn reach(&mut self, first: i64, end: i64, meter: &mut Meter) -> Result<(), MakingError> {
        self.queue.forget_before(first);
        if rayon::current_num_threads() > 1 && self.maker.is_free() {
            let rows = self.chunk(self.begun);
            // A whole period is known already: nothing is left to be made in advance.
            let known = !self.period.is_empty() && rows.start >= self.made.0 + self.period.len() as i64;
            if !known && rows.start < rows.end.min(self.reached) {
                self.begun = rows.end;
                self.maker.begin(rows);
            }
        }
        let end = self.elements.map_or(end, |(_, last)| end.min(last + 1));
        while self.queue.end() < end {
            let begin = self.queue.end();
            if let Some(slice) = self.stored_slice(begin) {
                self.queue.extend([slice]);
                continue;
            }
            let rows = self.chunk(begin);
            let slices = self.make(rows.clone(), meter)?;
            meter.count(Counter::Slices, slices.len() as u64);
            self.made.1 = rows.end;
            self.begun = self.begun.max(rows.end);
            self.queue.extend(slices);
        }
        Ok(())
    }

    /// The chunk that begins with an element: no further than the run will reach, and empty past the end of the road.
    fn chunk(&self, begin: i64) -> Range<i64> {
        let whole = begin + CHUNK_ROWS;
        let wanted = if begin < self.reached { whole.min(self.reached) } else { whole };
        begin..self.elements.map_or(wanted, |(_, last)| wanted.min(last + 1))
    }

    /// Takes the slices of a chunk from the maker, and keeps them if the road repeats.
    fn make(&mut self, rows: Range<i64>, meter: &mut Meter) -> Result<Vec<RoadSlice>, MakingError> {
        let begin = rows.start;
        let slices = self.maker.take(rows, meter)?;
        let curves = slices.iter().filter_map(RoadSlice::curve);
        self.slice_error = curves.fold(self.slice_error, |error, curve| error.max(curve.error));
        let period = self.period.len() as i64;
        if period > 0 {
            for (element, slice) in (begin..).zip(&slices) {
                self.period[element.rem_euclid(period) as usize] = Some(slice.clone());
            }
        }
        Ok(slices)
    }

    /// Makes the slices of a restored road: those in the queue and, on a road that repeats, those of its period. They
    /// are not counted, as they have been before.
    ///
    /// # Errors
    /// Errors of the road and of its slices.
    pub(crate) fn refill(&mut self, meter: &mut Meter) -> Result<(), MakingError> {
        let (repeats, missing) = (!self.period.is_empty(), self.missing.clone());
        let (mut begin, stop) = match self.period.len() as i64 {
            0 => (missing.start, missing.end),
            period => (self.made.0, self.made.1.min(self.made.0 + period)),
        };
        while begin < stop {
            let rows = begin..(begin + CHUNK_ROWS).min(stop);
            begin = rows.end;
            let slices = self.make(rows, meter)?;
            if !repeats {
                self.queue.extend(slices);
            }
        }
        while repeats && self.queue.end() < missing.end {
            let Some(slice) = self.stored_slice(self.queue.end()) else { break };
            self.queue.extend([slice]);
        }
        Ok(())
    }

    /// Slice of an element that an earlier pass over the period has made.
    fn stored_slice(&self, element: i64) -> Option<RoadSlice> {
        let period = self.period.len() as i64;
        if period == 0 { None } else { self.period[element.rem_euclid(period) as usize].clone() }
    }

    /// Largest difference of a curve from that of all cells of its slice, over the chunks that the tyre has reached
    /// \[m\].
    pub fn slice_error(&self) -> f64 {
        self.slice_error
    }

    /// The slices made and not yet passed.
    pub fn slices(&self) -> &RoadStrip {
        &self.queue
    }
}

/// Which slices are there, without the slices themselves, which `refill` makes again.
impl Evolving for RoadAhead {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        let (begin, mut first, mut end) = (self.made.0, self.queue.first(), self.queue.end());
        state.same(&begin)?;
        state.all([&mut first, &mut end, &mut self.made.1, &mut self.slice_error])?;
        ensure(begin <= first && first <= end && begin <= self.made.1)?;
        // The run needs no more, and the last chunk may end behind.
        ensure(end.max(self.made.1) <= self.reached.max(begin).saturating_add(CHUNK_ROWS))?;
        if state.is_restoring() {
            self.begun = self.made.1;
            self.queue = RoadStrip::starting_at(first);
            self.missing = first..end;
        }
        Ok(())
    }
}
