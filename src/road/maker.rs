//! Makes chunks of road: either when they are needed, or in the background, on a thread that the march leaves free,
//! some chunks in advance.
//!
//! One chunk is made at a time, each from the same rows on any thread: same bits, same errors. A chunk's error waits
//! with the chunk until that is taken. The number of chunks made in advance is bounded, and so is their memory.

use std::collections::VecDeque;
use std::mem::replace;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use rayon::Yield;
use thiserror::Error;

use super::error::RoadError;
use super::slices::{SliceBuilder, SliceError, StiffnessCurve};
use super::strip::RoadSlice;
use super::surface::RoadSurface;
use crate::counters::{Meter, Stage};

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
/// Time for which the march sleeps, when there is no task that it could help with, before it looks again.
const SLEEP: Duration = Duration::from_micros(100);

/// Makes one chunk after the other.
pub(crate) struct RoadMaker {
    generator: Place,
    /// Chunks made in the background and not taken yet, in order.
    ready: VecDeque<Chunk>,
}

/// All that is needed to make a chunk.
struct ChunkGenerator {
    surface: RoadSurface,
    form: SliceForm,
    heights: Vec<f64>,
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

/// Where the generator is.
enum Place {
    Here(Box<ChunkGenerator>),
    /// In the background: it is sent back with the chunk.
    Background(Receiver<Made>),
}

/// Generator and chunk as they are sent back, or the panic that ended the work.
type Made = thread::Result<(Box<ChunkGenerator>, Chunk)>;

/// A chunk's slices, or their error, and the instants before the heights, between heights and slices, and at the end.
struct Chunk {
    slices: Result<Vec<RoadSlice>, MakingError>,
    times: [Instant; 3],
}

impl Chunk {
    /// The stages with their begins and durations.
    fn stages(&self) -> [(Stage, Instant, Duration); 2] {
        let [begin, made, end] = self.times;
        [(Stage::Road, begin, made - begin), (Stage::Slices, made, end - made)]
    }
}

impl RoadMaker {
    pub(crate) fn new(surface: RoadSurface, form: SliceForm) -> Self {
        let generator = ChunkGenerator { surface, form, heights: Vec::new() };
        Self { generator: Place::Here(Box::new(generator)), ready: VecDeque::with_capacity(MOST_READY) }
    }

    /// True if another chunk may be begun in the background: collects the previous one if it is finished.
    pub(crate) fn is_free(&mut self) -> bool {
        if let Place::Background(made) = &self.generator {
            let Ok(made) = made.try_recv() else { return false };
            let (generator, chunk) = made.unwrap_or_else(|panic| resume_unwind(panic));
            self.generator = Place::Here(generator);
            self.ready.push_back(chunk);
        }
        self.ready.len() < MOST_READY
    }

    /// Begins a chunk in the background, on a thread of the current pool; does nothing while one is being made.
    pub(crate) fn begin(&mut self, rows: Range<i64>) {
        if matches!(self.generator, Place::Background(_)) {
            return;
        }
        let (sender, made) = sync_channel(1);
        if let Place::Here(mut generator) = replace(&mut self.generator, Place::Background(made)) {
            rayon::spawn(move || {
                let made = catch_unwind(AssertUnwindSafe(|| {
                    let chunk = generator.make(rows);
                    (generator, chunk)
                }));
                // It fails after the end of a run, when there is no receiver.
                let _ = sender.send(made);
            });
        }
    }

    /// Takes the slices of the earliest chunk begun in the background, waiting for it if need be; if there is none,
    /// makes those of `rows` on this thread.
    ///
    /// # Errors
    /// Errors of the road and of its slices.
    pub(crate) fn take(&mut self, rows: Range<i64>, meter: &mut Meter) -> Result<Vec<RoadSlice>, MakingError> {
        let chunk = match (self.ready.pop_front(), &mut self.generator) {
            (Some(chunk), _) => chunk,
            (None, Place::Background(made)) => {
                let (generator, chunk) = meter.time(Stage::RoadWait, || wait(made));
                self.generator = Place::Here(generator);
                chunk
            }
            (None, Place::Here(generator)) => {
                let chunk = generator.make(rows);
                chunk.stages().into_iter().for_each(|(stage, _, time)| meter.add_time(stage, time));
                return chunk.slices;
            }
        };
        chunk.stages().into_iter().for_each(|(stage, begin, time)| meter.add_background_since(stage, begin, time));
        chunk.slices
    }
}

/// Waits for the background work, so that nothing goes on after a run has ended.
impl Drop for RoadMaker {
    fn drop(&mut self) {
        if let Place::Background(made) = &self.generator {
            // The chunk is not needed, so it may also have failed.
            drop(come_back(made));
        }
    }
}

/// Waits for the chunk made in the background, and resumes a panic of it.
fn wait(made: &Receiver<Made>) -> (Box<ChunkGenerator>, Chunk) {
    let made = come_back(made).unwrap_or_else(|| resume_unwind(Box::new("the road could not be made")));
    made.unwrap_or_else(|panic| resume_unwind(panic))
}

/// Waits for the chunk made in the background; `None` if it never comes. The thread meanwhile runs tasks of the pool,
/// perhaps that chunk itself: it may be the only thread that is free.
fn come_back(made: &Receiver<Made>) -> Option<Made> {
    loop {
        let helped = rayon::yield_now() == Some(Yield::Executed);
        match made.recv_timeout(if helped { Duration::ZERO } else { SLEEP }) {
            Ok(made) => return Some(made),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return None,
        }
    }
}

impl ChunkGenerator {
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
    fn chunks_made_behind_are_those_made_here_in_order_and_no_more_than_a_few() {
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
                assert!(matches!(ahead.generator, Place::Background(_)));
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
