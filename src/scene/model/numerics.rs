//! Resolution, tolerances, and what is written.

use serde::{Deserialize, Serialize, Serializer};

use super::{TimeRule, Vibration};

/// Resolution and tolerances.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Numerics {
    /// Highest frequency wanted \[Hz\]: the plan chooses elements and substeps by it where they are not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fmax: Option<f64>,
    /// The row of the plan's table of accuracy against time that what is not given is taken from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<Preset>,
    /// How far third-octave levels up to `fmax` may be off for want of resolution \[dB\]: the cheapest row that keeps
    /// it.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional_decibels")]
    pub accuracy: Option<f64>,
    /// Elements N round the tyre; even.
    pub elements: usize,
    /// Time steps q per element rolled.
    pub substeps: usize,
    /// Time rule; by default `sdirk2`, with a direct history `bdf2`.
    pub time_rule: TimeRule,
    /// How the past is carried along; by default by poles, or as a sum where a `memory` is given.
    pub history: History,
    /// Length of the force history that is kept, `direct` only \[s\].
    pub memory: f64,
    /// Tolerance of the rational models of the influence functions, `modal` only; relative to each one's value, or to
    /// 0.003 of its largest where that is more.
    pub pole_tolerance: f64,
    /// Relative tolerance of the wavenumber sums, of the influence function's static value.
    pub influence_tolerance: f64,
    /// Tolerance of the contact conditions, relative to the largest required displacement.
    pub contact_tolerance: f64,
    /// A fixed number of odd lateral terms m, instead of the tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_terms: Option<usize>,
    /// A fixed largest alias |p|, instead of the tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavenumber_aliases: Option<usize>,
    /// Largest number of cached factorisations; fewer where they would take more than 256 MB.
    pub cached_factors: usize,
    /// Memory that the run may plan to use \[GB\].
    pub memory_limit: f64,
    /// Computing time on one core that the run may plan to use \[h\].
    pub time_limit: f64,
}

impl Numerics {
    /// Fewer elements do not even resolve the patch of a car tyre by two.
    pub const FEWEST_ELEMENTS: usize = 16;

    /// Leaves out what other settings were chosen by: they stay as they are.
    pub fn forget_wishes(&mut self) {
        (self.fmax, self.preset, self.accuracy) = (None, None, None);
    }

    /// `memory_limit` in bytes.
    pub fn memory_bytes(&self) -> u64 {
        (self.memory_limit * 1e9) as u64
    }
}

impl Default for Numerics {
    fn default() -> Self {
        Self {
            fmax: None,
            preset: None,
            accuracy: None,
            elements: 512,
            substeps: 1,
            time_rule: TimeRule::Sdirk2,
            history: History::Modal,
            memory: 0.7,
            pole_tolerance: 1e-5,
            influence_tolerance: 1e-7,
            contact_tolerance: 1e-12,
            lateral_terms: None,
            wavenumber_aliases: None,
            cached_factors: 32,
            memory_limit: 8.0,
            time_limit: 24.0,
        }
    }
}

fn optional_decibels<S: Serializer>(accuracy: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    match accuracy {
        Some(accuracy) => decibels(accuracy, serializer),
        None => serializer.serialize_none(),
    }
}

/// A level difference as it is read, in quotes.
pub(super) fn decibels<S: Serializer>(difference: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&format!("{difference} dB"))
}

/// A named row of the table of accuracy against time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// For trying out: fast, levels within a few decibels.
    Draft,
    /// For results.
    Standard,
    /// To compare others with.
    Reference,
}

impl Preset {
    /// All presets, cheapest first.
    pub const ALL: [Self; 3] = [Self::Draft, Self::Standard, Self::Reference];

    /// The preset's name in a scene.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Standard => "standard",
            Self::Reference => "reference",
        }
    }
}

/// How the displacement left over from past forces is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum History {
    /// The convolution sum over `memory` seconds: the reference.
    Direct,
    /// A recursion per pole of the rational model: the whole past, much faster.
    #[default]
    Modal,
}

/// What is written to the results folder beside `summary.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outputs {
    /// `time.npy`, `total_force.npy`, `patch_force.npy`, `patch_element.npy`.
    pub arrays: bool,
    /// `spectra.csv`.
    pub spectra: bool,
    /// SVG plots.
    pub plots: bool,
    /// Wall time between two checkpoints of an unfinished run \[s\]; 0: only when it is interrupted.
    pub checkpoint_interval: f64,
    /// Vibration of the tyre; none is computed without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vibration: Option<Vibration>,
}

impl Default for Outputs {
    fn default() -> Self {
        Self { arrays: true, spectra: true, plots: true, checkpoint_interval: 60.0, vibration: None }
    }
}
