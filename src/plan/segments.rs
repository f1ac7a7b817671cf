//! Segments of a run (`outputs.levels.segments`): equal pieces of its road, each after a warm-up of its own.

/// Segments that a run is rolled in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segments {
    pub count: usize,
    /// Steps of each after its warm-up.
    pub steps: u64,
    /// Unit of `steps`, so that all segments begin with an element and a block of the sound.
    pub(super) unit: u64,
    /// Steps beyond its own that a segment takes to complete its last block of the sound; the last one takes none.
    pub(super) overlap: u64,
}

impl Segments {
    /// Steps of all segments, with warm-ups of so many steps.
    pub(crate) fn rolled(&self, warm_up: u64) -> u64 {
        self.count as u64 * (warm_up + self.steps + self.overlap) - self.overlap
    }

    /// Fewest steps of a segment that lasts so many seconds at least.
    pub(super) fn least(&self, seconds: f64, time_step: f64) -> u64 {
        ((seconds / time_step).ceil() as u64).next_multiple_of(self.unit)
    }
}
