//! Makes chunks of road: either when they are needed, or in the background, on a thread that the march leaves free,
//! some chunks in advance.
//!
//! One chunk is made at a time, each from the same rows on any thread: same bits, same errors. A chunk's error waits
//! with the chunk until that is taken. The number of chunks made in advance is bounded, and so is their memory.

use std::collections::VecDeque;
use std::ops::Range;
use std::time::{Duration, Instant};

use thiserror::Error;

use super::error::RoadError;
use super::slices::{SliceBuilder, SliceError, StiffnessCurve};
use super::strip::RoadSlice;
use super::surface::RoadSurface;
use crate::counters::{Meter, Stage};
use crate::numeric::background::{Background, BackgroundTask};

/// Fault that occurs while a road is made.
#[derive(Debug, Error)]
pub enum MakingError {
    /// A fault of the road or its file.
    #[error(transparent)]
    Road(#[from] RoadError),
    /// A fault of its slices.
    #[error(transparent)]
    Slices(#[from] SliceError),
}

/// Most chunks made in advance. A drawn road comes in pieces of some thousand elements (2800 at N = 1024): the march
/// uses up the chunks ready while one is drawn.
const MOST_READY: usize = 8;

/// Makes one chunk after the other.
pub(crate) struct RoadMaker {
    background: Background<Generator>,
    /// True while a chunk is being made in the background.
    is_busy: bool,
    /// Chunks made in the background and not taken yet, in order.
    ready: VecDeque<Chunk>,
}

/// All that is needed to make a chunk.
struct Generator {
    surface: RoadSurface,
    form: SliceForm,
    heights: Vec<f64>,
    /// Elements of the chunk to be made in the background, then that chunk.
    rows: Range<i64>,
    made: Option<Chunk>,
}

/// Form in which the heights under an element are passed on.
pub enum SliceForm {
    /// A stiffness curve.
    Curves(SliceBuilder),
    /// A curve of the heights minus the depths of the tread's voids, cells of all elements round the tyre \[m\].
    Voids(SliceBuilder, Vec<f64>),
    /// A curve that depends on more of the road than the slice itself.
    Strips(Box<dyn StripCurves>),
    /// The heights of the cells as they are.
    Cells,
}

/// Maker of curves that depend on the road beside a slice, too.
pub trait StripCurves: Send + Sync {
    /// Curves of the slices of some elements; that of an element does not depend on the elements asked for before,
    /// after or with it.
    ///
    /// # Errors
    /// Errors of the road and of its slices.
    fn curves(&mut self, surface: &mut RoadSurface, elements: Range<i64>) -> Result<Vec<StiffnessCurve>, MakingError>;
}

/// A chunk's slices, or their error, and the instants before the heights, between heights and slices, and at the end.
struct Chunk {
    slices: Result<Vec<RoadSlice>, MakingError>,
    times: [Instant; 3],
}

impl Chunk {
    fn stages(&self) -> [(Stage, Instant, Duration); 2] {
        let [begin, made, end] = self.times;
        [(Stage::Road, begin, made - begin), (Stage::Slices, made, end - made)]
    }
}

impl RoadMaker {
    pub(crate) fn new(surface: RoadSurface, form: SliceForm) -> Self {
        let generator = Generator { surface, form, heights: Vec::new(), rows: 0..0, made: None };
        let ready = VecDeque::with_capacity(MOST_READY);
        Self { background: Background::in_pool(generator), is_busy: false, ready }
    }

    /// True if another chunk may be begun in the background: collects the previous one if it is finished.
    pub(crate) fn is_free(&mut self) -> bool {
        if self.is_busy && self.background.is_done() {
            self.collect();
        }
        !self.is_busy && self.ready.len() < MOST_READY
    }

    /// Begins a chunk in the background, on a thread of the current pool; does nothing while one is being made.
    pub(crate) fn begin(&mut self, rows: Range<i64>) {
        if !self.is_busy {
            let mut generator = self.background.take();
            generator.rows = rows;
            self.background.begin(generator);
            self.is_busy = true;
        }
    }

    /// Adds the chunk of the background to those that are ready, waiting for it if need be.
    fn collect(&mut self) {
        self.ready.extend(self.background.with(|generator| generator.made.take()));
        self.is_busy = false;
    }

    /// Takes the slices of the earliest chunk begun in the background, waiting for it if need be; if there is none,
    /// makes those of `rows` on this thread.
    ///
    /// # Errors
    /// Errors of the road and of its slices.
    pub(crate) fn take(&mut self, rows: Range<i64>, meter: &mut Meter) -> Result<Vec<RoadSlice>, MakingError> {
        if self.is_busy && self.ready.is_empty() {
            meter.time(Stage::RoadWait, || self.collect());
        }
        let Some(chunk) = self.ready.pop_front() else {
            let chunk = self.background.with(|generator| generator.make(rows));
            chunk.stages().into_iter().for_each(|(stage, _, time)| meter.add_time(stage, time));
            return chunk.slices;
        };
        chunk.stages().into_iter().for_each(|(stage, begin, time)| meter.add_background_since(stage, begin, time));
        chunk.slices
    }
}

impl BackgroundTask for Generator {
    fn carry_out(&mut self, _: bool) {
        self.made = Some(self.make(self.rows.clone()));
    }
}

impl Generator {
    fn make(&mut self, rows: Range<i64>) -> Chunk {
        let begin = Instant::now();
        // Strips read the heights themselves.
        let heights = if let SliceForm::Strips(_) = self.form { Ok(()) } else { self.heights(rows.clone()) };
        let made = Instant::now();
        let slices = heights.map_err(MakingError::from).and_then(|()| self.slices(rows));
        Chunk { slices, times: [begin, made, Instant::now()] }
    }

    fn slices(&mut self, rows: Range<i64>) -> Result<Vec<RoadSlice>, MakingError> {
        let curves = match &mut self.form {
            SliceForm::Curves(builder) => builder.build_rows(&self.heights)?,
            SliceForm::Voids(builder, depths) => {
                let around = (depths.len() / builder.cells()) as i64;
                let first = rows.start.rem_euclid(around) as usize * builder.cells();
                let heights = self.heights.iter_mut().zip(depths.iter().cycle().skip(first));
                heights.for_each(|(height, depth)| *height -= depth);
                builder.build_rows(&self.heights)?
            }
            SliceForm::Strips(strips) => strips.curves(&mut self.surface, rows)?,
            SliceForm::Cells => {
                let rows = self.heights.chunks_exact(self.surface.lattice().cells());
                return Ok(rows.map(|row| RoadSlice::Heights(row.into())).collect());
            }
        };
        Ok(curves.into_iter().map(RoadSlice::Curve).collect())
    }

    fn heights(&mut self, rows: Range<i64>) -> Result<(), RoadError> {
        let count = (rows.end - rows.start) as usize;
        self.heights.resize(count * self.surface.lattice().cells(), 0.0);
        self.surface.heights(rows.start, count, &mut self.heights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::road::{Lattice, Limits};
    use crate::scene::{MadeRoad, Road};

    fn maker(builder_columns: usize) -> RoadMaker {
        let lattice = Lattice { dx: 0.01, along: 1, dy: 0.02, columns: 6 };
        let road = Road::Made(MadeRoad { seed: 2, ..MadeRoad::default() });
        let surface = RoadSurface::open(&road, lattice, Limits::default()).unwrap();
        RoadMaker::new(surface, SliceForm::Curves(SliceBuilder::winkler(builder_columns).unwrap()))
    }

    fn chunk(number: i64) -> Range<i64> {
        100 * number..100 * (number + 1)
    }

    #[test]
    fn chunks_made_in_the_background_are_few_and_in_order() {
        let mut meter = Meter::default();
        let mut here = maker(6);
        let expected: Vec<_> = (0..12).map(|number| here.take(chunk(number), &mut meter).unwrap()).collect();
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (mut ahead, mut begun) = (maker(6), 0);
            pool.install(|| {
                for (number, expected) in expected.iter().enumerate() {
                    while number == 0 && begun < MOST_READY as i64 {
                        if ahead.is_free() {
                            ahead.begin(chunk(begun));
                            begun += 1;
                        }
                        rayon::yield_now();
                    }
                    assert_eq!(&ahead.take(chunk(number as i64), &mut meter).unwrap(), expected);
                }
            });
        }
    }

    #[test]
    fn a_maker_that_is_dropped_waits_for_what_goes_on_behind() {
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut ahead = maker(6);
                assert!(ahead.is_free());
                ahead.begin(chunk(0));
                assert!(ahead.is_busy);
            });
        }
    }

    #[test]
    fn an_error_waits_for_its_chunk_and_is_that_made_here() {
        let mut meter = Meter::default();
        let expected = maker(7).take(chunk(0), &mut meter).unwrap_err().to_string();
        let mut ahead = maker(7);
        ahead.begin(chunk(0));
        while !ahead.is_free() {
            std::thread::yield_now();
        }
        assert_eq!(ahead.take(chunk(0), &mut meter).unwrap_err().to_string(), expected);
    }
}
