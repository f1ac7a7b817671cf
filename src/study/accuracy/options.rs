//! Options of a study.

use serde::Serialize;

use crate::scene::Scene;

/// Runs of a study beside the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sweep {
    /// The scene's settings, and every other setting of the knobs of its discretisation, against a reference whose
    /// uncertainty comes from one run half as fine: minutes.
    Outline,
    /// The presets, the scene's settings, every knob, laws and transfer paths of the sound.
    Knobs,
    /// The presets, and each with one setting turned.
    Neighbours,
    /// The presets alone.
    Nothing,
}

/// Options of a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyOptions {
    /// Highest frequency compared \[Hz\].
    pub highest: f64,
    /// Time compared \[s\].
    pub duration: f64,
    /// Combinations rolled.
    pub runs: usize,
    /// Runs beside the reference.
    pub sweep: Sweep,
    /// Elements of the reference; default: twice the scene's, or a quarter more than the finest preset's where the
    /// presets are rolled.
    pub elements: Option<usize>,
    /// Steps per element of the reference; default: 48 steps in a period of `highest`, 24 for an outline.
    pub substeps: Option<usize>,
}

impl StudyOptions {
    /// Highest frequency compared where a scene has none \[Hz\].
    pub(crate) const HIGHEST: f64 = 1000.0;
    /// Time compared unless asked for \[s\].
    pub(crate) const DURATION: f64 = 1.0;
    /// Combinations that a whole study rolls unless asked for.
    pub(crate) const RUNS: usize = 12;

    /// The presets and the main knobs.
    pub fn outline(scene: &Scene) -> Self {
        Self { runs: 0, sweep: Sweep::Outline, ..Self::whole(scene) }
    }

    /// Every knob, alone and jointly.
    pub fn whole(scene: &Scene) -> Self {
        Self {
            highest: scene.numerics.fmax.unwrap_or(Self::HIGHEST),
            duration: scene.rolling.duration.min(Self::DURATION),
            runs: Self::RUNS,
            sweep: Sweep::Knobs,
            elements: None,
            substeps: None,
        }
    }
}
