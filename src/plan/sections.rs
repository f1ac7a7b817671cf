//! Sections of the road that a run rolls (`outputs.sections`).

use super::Plan;
use crate::scene::{LoadedScene, SceneError};

/// Least length of a section in lengths of the patch: of a shorter one the forces would depend on its neighbours.
const LEAST_PATCHES: f64 = 10.0;

impl Plan {
    /// Refuses sections that are hardly longer than the patch.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] at the key.
    pub(crate) fn check_sections(&self, loaded: &LoadedScene) -> Result<(), SceneError> {
        let (Some(length), patch) = (self.scene.outputs.sections, self.expected().length) else { return Ok(()) };
        let least = LEAST_PATCHES * patch;
        if length >= least {
            return Ok(());
        }
        let wrong = format!("a section of {length} m is hardly longer than the patch, {patch:.2} m");
        Err(loaded.complain("outputs.sections", wrong, format!("at least {least:.2} m, ten patches")).into())
    }
}
