//! Figure 3: a rough road.

use crate::plan::Plan;
use crate::road::{RoadDescription, TextureLevel, describe};
use crate::run::RunError;
use crate::run::road::{in_scene, road_limits};
use crate::scene::LoadedScene;
use serde::Serialize;

use super::statement::{Statement, Verdict};

/// A piece of the road and its measures.
#[derive(Clone, Debug, Serialize)]
pub(super) struct RoadFigure {
    /// The road, with a piece to draw.
    #[serde(skip)]
    pub description: RoadDescription,
    /// Root-mean-square height \[m\].
    pub rms: f64,
    /// Mean profile depth \[m\].
    pub mean_profile_depth: Option<f64>,
    /// Third-octave levels of the texture.
    pub levels: Vec<TextureLevel>,
}

impl RoadFigure {
    /// Describes the scene's road.
    ///
    /// # Errors
    /// Errors of the road.
    pub(super) fn of(loaded: &LoadedScene) -> Result<Self, RunError> {
        let scene = &loaded.scene;
        let read = || describe(&scene.road, Plan::new(scene).lattice()?, scene.rolling.speed(), road_limits(scene));
        let description = read().map_err(|error| in_scene(loaded, error))?;
        Ok(Self {
            rms: description.rms,
            mean_profile_depth: description.mean_profile_depth.as_ref().and_then(|depth| depth.mean),
            levels: description.levels.clone(),
            description,
        })
    }

    pub(super) fn statement(&self) -> Statement {
        let depth = self
            .mean_profile_depth
            .map_or(String::new(), |depth| format!("mean profile depth {:.2} mm, ", 1e3 * depth));
        Statement {
            place: "figure 3",
            subject: "a rough road",
            paper: "a measured road in a picture",
            found: format!("{depth}rms height {:.2} mm, {} third octaves", 1e3 * self.rms, self.levels.len()),
            verdict: Verdict::NotComparable,
            why: "the heights of the paper's road are not given; this one is made".to_owned(),
        }
    }
}
