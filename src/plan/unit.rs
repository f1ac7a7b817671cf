//! Units of work, and the cost of each on one core.

use serde::{Deserialize, Serialize};

use crate::counters::Stage;

/// A unit of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Unit {
    /// A fit of the influence functions, in fits of 512 elements to 1e-5.
    Fit,
    /// A pole read, checked, and made ready.
    Pole,
    /// An evaluation of the layered compliance.
    Evaluation,
    /// A pair of elements in the static solution.
    StaticPair,
    /// A multiply-add of drawing a random texture.
    TextureMultiplyAdd,
    /// A height resampled from a measured road.
    ResampledHeight,
    /// A slice's cell under springs.
    SpringCell,
    /// A pair of a slice's cells on a half-space.
    HalfSpacePair,
    /// A multiply-add of the direct history.
    DirectMultiplyAdd,
    /// A multiply-add of the recursion by poles.
    PoleMultiplyAdd,
    /// A multiply-add of the transforms between elements and wavenumbers.
    TransformMultiplyAdd,
    /// A column of the window over a level slice.
    LevelColumn,
    /// A column of the window over a rough slice.
    RoughColumn,
    /// A point in contact on a smooth road, in a step.
    SmoothPoint,
    /// A point in contact on a rough road, in a step.
    RoughPoint,
    /// A multiply-add of the search.
    SearchMultiplyAdd,
    /// A multiply-add of the transforms of forces to wavenumbers and frequencies.
    VibrationMultiplyAdd,
    /// A pole at a frequency, for velocities.
    VibrationPole,
    /// A residue of the tangential displacement fitted.
    TangentialPole,
    /// A real operation of the factorisation of boundary elements.
    RadiationOperation,
    /// An evaluation of the acoustic kernel.
    RadiationKernel,
    /// A real multiply-add of the products that make pressures at receivers from forces.
    TransferMultiplyAdd,
    /// A multiply-add of the transforms of forces and pressures over time.
    SoundMultiplyAdd,
    /// A sample of a passage, put together and its level read.
    PassedSample,
    /// A byte of a result array.
    OutputByte,
    /// A plot.
    Plot,
}

impl Unit {
    /// Returns the seconds of one core of an AMD EPYC with AVX-512, release build (measured): what plans are checked
    /// with where nothing was measured.
    pub(crate) const fn typical(self) -> f64 {
        match self {
            Self::Fit => 0.49,
            Self::Pole => 5e-6,
            Self::Evaluation => 7e-8,
            Self::StaticPair => 8e-7,
            Self::TextureMultiplyAdd => 7e-11,
            Self::ResampledHeight => 1e-8,
            Self::SpringCell => 2.7e-8,
            Self::HalfSpacePair => 3.2e-9,
            Self::DirectMultiplyAdd | Self::SearchMultiplyAdd => 1e-10,
            Self::PoleMultiplyAdd => 7e-11,
            Self::TransformMultiplyAdd => 1.2e-10,
            Self::LevelColumn => 8e-9,
            Self::RoughColumn => 2e-8,
            Self::SmoothPoint => 5e-8,
            Self::RoughPoint => 1.25e-7,
            Self::VibrationMultiplyAdd => 4e-10,
            Self::VibrationPole => 1.6e-9,
            Self::TangentialPole => 8e-5,
            Self::RadiationOperation => 5e-11,
            Self::RadiationKernel => 6e-9,
            Self::TransferMultiplyAdd => 1e-10,
            Self::SoundMultiplyAdd => 3e-10,
            Self::PassedSample => 2.2e-6,
            Self::OutputByte => 1.2e-9,
            Self::Plot => 2e-3,
        }
    }
}

/// Costs of work on a machine, relative to the [typical](Unit::typical) cost of its units.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct UnitCosts {
    /// By [`Stage`].
    pub stages: [f64; Stage::ALL.len()],
    /// Time of each step that belongs to no stage \[s\].
    pub step: f64,
    /// True if they were measured on this machine.
    pub measured: bool,
}

impl Default for UnitCosts {
    fn default() -> Self {
        Self { stages: [1.0; Stage::ALL.len()], step: 9e-7, measured: false }
    }
}

impl UnitCosts {
    /// Returns the seconds of a unit in a stage.
    pub(crate) fn of(&self, stage: Stage, unit: Unit) -> f64 {
        self.stages[stage as usize] * unit.typical()
    }
}
