//! Options of a study.

use serde::Serialize;

use crate::scene::Scene;

/// Extent of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sweep {
    /// The scene's settings, and every other value of the knobs, against a coarser reference: minutes.
    Outline,
    /// The presets, the scene's settings, and every knob.
    Knobs,
    /// The presets alone.
    Presets,
}

/// Extent of a study, and how it compares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StudyOptions {
    /// Highest frequency compared \[Hz\].
    pub highest: f64,
    /// Time compared \[s\].
    pub duration: f64,
    /// Its extent.
    pub sweep: Sweep,
    /// Elements of the reference; default: twice the scene's, or a quarter more than the finest preset's where the
    /// presets are rolled.
    pub elements: Option<usize>,
    /// Steps per element of the reference; default: 48 steps in a period of `highest`, 24 for an outline.
    pub substeps: Option<usize>,
}

impl StudyOptions {
    /// Up to the scene's fmax, or 1 kHz; over the scene's duration, at most a second.
    pub fn new(scene: &Scene, sweep: Sweep) -> Self {
        let (highest, duration) = (scene.numerics.fmax.unwrap_or(1000.0), scene.rolling.duration.min(1.0));
        Self { highest, duration, sweep, elements: None, substeps: None }
    }
}
