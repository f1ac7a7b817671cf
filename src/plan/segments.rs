//! Segments of a run (`outputs.levels.segments`): equal pieces of its road, each after a warm-up of its own.

use super::{Plan, SEGMENT};
use crate::contact::geometry::Geometry;
use crate::scene::{LoadedScene, SceneError};

/// Segments that a run is rolled in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segments {
    pub count: usize,
    /// Steps of each after its warm-up.
    pub steps: u64,
    /// Unit of `steps`, so that all segments begin with an element and a block of the sound.
    unit: u64,
    /// Steps beyond its own that a segment takes to complete its last block of the sound; the last one takes none.
    overlap: u64,
}

impl Segments {
    /// Steps of all segments, with warm-ups of so many steps.
    pub(crate) fn rolled(&self, warm_up: u64) -> u64 {
        self.count as u64 * (warm_up + self.steps + self.overlap) - self.overlap
    }

    /// Fewest steps of a segment, which lasts no shorter than those of the averaged spectrum.
    fn least(&self, time_step: f64) -> u64 {
        ((SEGMENT / time_step).ceil() as u64).next_multiple_of(self.unit)
    }
}

impl Plan {
    /// Cuts the run into the segments that its scene asks for: whole blocks of its sound, or elements, no longer than
    /// the run was.
    ///
    /// # Errors
    /// Segments that are too short for a spectrum.
    pub(crate) fn cut(&mut self, loaded: &LoadedScene) -> Result<(), SceneError> {
        let count = self.scene.outputs.levels.as_ref().map_or(1, |levels| levels.segments);
        if count == 1 {
            return Ok(());
        }
        let substeps = self.scene.numerics.substeps as u64;
        let blocks = self.sound().map(|sound| sound.path.layout);
        let [hop, overlap] = blocks.map_or([1, 0], |layout| [layout.hop(), layout.length() - layout.hop()]);
        let hop = hop as u64;
        let unit = (1..=substeps).map(|hops| hops * hop).find(|unit| unit.is_multiple_of(substeps)).unwrap_or(hop);
        let counted = self.steps - self.warm_up_steps;
        let segments = Segments { count, steps: counted / count as u64 / unit * unit, unit, overlap: overlap as u64 };
        let least = segments.least(self.time_step);
        if segments.steps < least {
            let (all, one) = (self.scene.rolling.duration, least as f64 * self.time_step);
            let wrong = format!("{count} segments of {all} s are too short for a spectrum: one takes {one:.2} s");
            let right = format!("at most {}, or a longer rolling.duration", (counted / least).max(1));
            return Err(loaded.complain("outputs.levels.segments", wrong, right).into());
        }
        self.segments = Some(segments);
        self.decisions.notes.push(format!(
            "{count} segments of the road are rolled side by side, each after a warm-up of {} s; if the run is \
             interrupted it begins anew",
            self.scene.rolling.warm_up
        ));
        self.shorten((count as u64 * segments.steps) as f64 * self.time_step);
        Ok(())
    }

    /// Brings the run's segments to its number of steps, or little more.
    pub(super) fn shorten_segments(&mut self) {
        let Some(segments) = &mut self.segments else { return };
        let (count, counted) = (segments.count as u64, self.steps - self.warm_up_steps);
        let least = segments.least(self.time_step);
        segments.steps = counted.div_ceil(count).next_multiple_of(segments.unit).max(least);
        self.steps = self.warm_up_steps + count * segments.steps;
        self.scene.rolling.duration = (count * segments.steps) as f64 * self.time_step;
    }

    /// Number of segments, 1 for a run in one piece.
    pub(crate) fn segment_count(&self) -> usize {
        self.segments.map_or(1, |segments| segments.count)
    }

    /// Plan of a segment by its number, for the contact alone, in a run whose elements stand as `geometry` says.
    pub(crate) fn segment(&self, segments: Segments, number: usize, geometry: &Geometry) -> Self {
        let mut plan = Self { segments: None, ..self.clone() };
        let elements = number as u64 * segments.steps / geometry.substeps as u64;
        plan.scene.rolling.start = Some(geometry.start + elements as f64 * geometry.element);
        plan.scene.receivers.clear();
        let overlap = if number + 1 < segments.count { segments.overlap } else { 0 };
        plan.steps = self.warm_up_steps + segments.steps + overlap;
        plan
    }
}
