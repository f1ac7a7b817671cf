//! Levels of a finer mesh (`outputs.levels`): the short runs over two meshes that correct those of the run.

use serde::{Deserialize, Serialize};

use super::front::STATED_FROM;
use super::{Plan, PlannedSetting};
use crate::response::MeshCorrection;
use crate::scene::{LoadedScene, MeshLevels, Outputs, Scene, SceneError, Zone};

/// Time over which both meshes are compared, before what they find asks for more \[s\]: in 0.6 s a third octave at
/// 1 kHz has a standard error of 0.4 dB.
const COMPARED: f64 = 0.6;
/// Factor within which a standard error counts as reached: it is itself an estimate.
const REACHED: f64 = 1.1;

/// Corrections of the levels of all signals of a run.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct MeshCorrections {
    /// That of the total force.
    pub force: MeshCorrection,
    /// Those at the receivers, in their order.
    pub receivers: Vec<MeshCorrection>,
    /// Elements of the run and of the finer mesh.
    pub elements: [usize; 2],
    /// Time over which both were compared \[s\].
    pub seconds: f64,
    /// Standard error wanted \[dB\].
    pub standard_error: f64,
}

impl MeshCorrections {
    /// Time over which the meshes have to be compared, and of the run \[s\], for the standard error wanted up to a
    /// frequency \[Hz\]; at most `longest`.
    pub(crate) fn needed(&self, highest: f64, longest: f64) -> [f64; 2] {
        let all = std::iter::once(&self.force).chain(&self.receivers);
        let each = all.map(|signal| signal.needed(self.standard_error, [STATED_FROM, highest], longest));
        each.fold([0.0; 2], |[short, long], [of_short, of_long]| [short.max(of_short), long.max(of_long)])
    }

    /// Warning if a run of so many seconds misses the standard error wanted up to a frequency \[Hz\].
    pub(crate) fn missed(&self, highest: f64, seconds: f64) -> Option<String> {
        let all = std::iter::once(&self.force).chain(&self.receivers);
        let each = all.filter_map(|signal| signal.largest_error([STATED_FROM, highest], seconds));
        let (band, error) = each.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (error > REACHED * self.standard_error).then(|| {
            format!(
                "outputs.levels.standard_error = {} dB is missed at {} Hz: {error:.2} dB; a longer rolling.duration \
                 lowers it",
                self.standard_error,
                band.nominal_frequency()
            )
        })
    }
}

/// Scenes of the short runs of a scene with all settings decided, over its own mesh and over the finer one, for some
/// seconds after the warm-up; nothing but spectra is wanted of them. `None` without `outputs.levels`.
///
/// # Errors
/// Slices; a finer mesh that is not a multiple of the run's.
pub(crate) fn short_scenes(
    loaded: &LoadedScene,
    scene: &Scene,
    seconds: f64,
) -> Result<Option<[Scene; 2]>, SceneError> {
    let Some(levels) = &scene.outputs.levels else { return Ok(None) };
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
    short.numerics.forget_wishes();
    short.numerics.fmax = scene.numerics.fmax;
    short.outputs = Outputs { arrays: false, plots: false, ..Outputs::default() };
    short.radiation.audio = false;
    // Whole steps of the coarser mesh, of which the finer one has a multiple.
    let time_step = scene.tyre.circumference / (elements * scene.numerics.substeps) as f64 / scene.rolling.speed();
    short.rolling.duration = (seconds / time_step).round() * time_step;
    let mut finer = short.clone();
    finer.numerics.elements = fine;
    Ok(Some([short, finer]))
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

    /// Wish for the levels of a finer mesh whose correction is not found yet.
    pub(crate) fn wanted_levels(&self) -> Option<&MeshLevels> {
        self.scene.outputs.levels.as_ref().filter(|_| self.corrections.is_none())
    }
}
