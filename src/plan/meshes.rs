//! Levels of a finer mesh (`outputs.levels`): the short runs over two meshes that correct those of the run, and the
//! segments that this may be cut into.

use std::sync::Arc;

use super::{MeshCorrections, Plan, PlannedSetting, SEGMENT, Segments};
use crate::contact::geometry::Geometry;
use crate::results::summary::FinerMesh;
use crate::scene::{LoadedScene, MeshLevels, Outputs, Scene, SceneError, Zone};

/// Time over which both meshes are compared, before what they find asks for more \[s\]: in 0.6 s a third octave at
/// 1 kHz has a standard error of 0.4 dB.
const COMPARED: f64 = 0.6;

/// Scenes of the short runs of a scene with all settings decided, over its own mesh and over the finer one, for some
/// seconds after the warm-up; nothing but spectra is wanted of them.
///
/// # Errors
/// Slices; a finer mesh that is not a multiple of the run's.
pub(crate) fn short_scenes(
    loaded: &LoadedScene,
    scene: &Scene,
    levels: &MeshLevels,
    seconds: f64,
) -> Result<[Scene; 2], SceneError> {
    if scene.contact.zone == Zone::Slices {
        let wrong = "levels by slices have no limit for fine meshes";
        let right = "remove it, or contact.zone = \"cells\"";
        return Err(loaded.complain("outputs.levels", wrong, right).into());
    }
    let (elements, fine) = (scene.numerics.elements, levels.fine_elements(scene.numerics.elements));
    if fine < 2 * elements || !fine.is_multiple_of(elements) {
        let wrong = format!("{fine} elements are no multiple of the {elements} of the run");
        let right = format!("{}, or leave it out", 2 * elements);
        return Err(loaded.complain("outputs.levels.elements", wrong, right).into());
    }
    let mut short = scene.clone();
    short.outputs = Outputs { arrays: false, plots: false, ..Outputs::default() };
    short.radiation.audio = false;
    // Whole steps of the coarser mesh, of which the finer one has a multiple.
    let element = scene.tyre.circumference / elements as f64;
    let time_step = scene.numerics.advance().time_step(element, scene.rolling.speed());
    short.rolling.duration = (seconds / time_step).round() * time_step;
    let mut finer = short.clone();
    finer.numerics.elements = fine;
    Ok([short, finer])
}

impl Plan {
    /// The finer mesh, where the scene leaves its elements open.
    pub(crate) fn choice_of_finer_mesh(&self) -> Option<PlannedSetting> {
        let levels = self.scene.outputs.levels.as_ref().filter(|levels| levels.elements.is_none())?;
        let (few, seconds) = (self.scene.numerics.elements, self.compared_at_first());
        let value = levels.fine_elements(few).to_string();
        let reason =
            format!("twice the {few} of the run, whose levels are corrected by {seconds:.2} s of both, or more");
        Some(PlannedSetting { key: "outputs.levels.elements", value, reason })
    }

    /// Time over which the meshes are compared at first \[s\].
    pub(crate) fn compared_at_first(&self) -> f64 {
        let least = self.sound().map_or(0.0, |sound| sound.duration_for(1));
        COMPARED.max(least).min(self.scene.rolling.duration)
    }

    /// The same, whose spectra keep their transforms in lengths that are multiples of `multiple`.
    #[must_use]
    pub(crate) fn keeping_transforms(self, multiple: usize) -> Self {
        Self { kept_transforms: Some(multiple), ..self }
    }

    /// Ends the run after so many seconds that count, fewer than planned.
    pub(crate) fn shorten(&mut self, duration: f64) {
        self.scene.rolling.duration = duration;
        self.steps = self.warm_up_steps + (duration / self.time_step).round().max(1.0) as u64;
        self.shorten_segments();
    }

    /// Takes the corrections that the short runs have found; these are over.
    pub(crate) fn take_corrections(&mut self, corrections: MeshCorrections) {
        let FinerMesh { elements: many, seconds, .. } = corrections.mesh;
        let (few, duration) = (self.scene.numerics.elements, self.scene.rolling.duration);
        self.decisions.notes.push(format!(
            "levels are those of {many} elements: {few} and {many} have rolled the same {seconds:.2} s, {few} roll \
             {duration:.2} s"
        ));
        (self.short_runs, self.corrections) = (Vec::new(), Some(Arc::new(corrections)));
    }

    /// Wish for the levels of a finer mesh whose correction is not found yet.
    pub(crate) fn wanted_levels(&self) -> Option<&MeshLevels> {
        self.scene.outputs.levels.as_ref().filter(|_| self.corrections.is_none())
    }

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
        let least = segments.least(SEGMENT, self.time_step);
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
    fn shorten_segments(&mut self) {
        let Some(segments) = &mut self.segments else { return };
        let (count, counted) = (segments.count as u64, self.steps - self.warm_up_steps);
        let least = segments.least(SEGMENT, self.time_step);
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
        let elements = geometry.advance.elements((number as u64 * segments.steps) as i64);
        plan.scene.rolling.start = Some(geometry.start + elements as f64 * geometry.element);
        plan.scene.receivers.clear();
        let overlap = if number + 1 < segments.count { segments.overlap } else { 0 };
        plan.steps = self.warm_up_steps + segments.steps + overlap;
        plan
    }
}
