//! Units of work, and the cost of each on one core.

use serde::{Deserialize, Serialize};

use crate::counters::Stage;

/// Unit of an amount of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WorkUnit {
    /// Fit of the influence functions, in fits of 512 elements to 1e-5.
    Fit,
    /// A pole: read, checked, and its coefficients computed.
    Pole,
    /// Evaluation of the layered compliance.
    Evaluation,
    /// Pair of elements in the static solution.
    StaticPair,
    /// Multiply-add in the generation of a random texture.
    TextureMultiplyAdd,
    /// Height resampled from a measured road.
    ResampledHeight,
    /// Cell of a slice under springs.
    SpringCell,
    /// Pair of cells of a slice on a half-space.
    HalfSpacePair,
    /// Multiply-add of the direct history.
    DirectMultiplyAdd,
    /// Multiply-add of the recursion by poles.
    PoleMultiplyAdd,
    /// Multiply-add of the transforms between elements and wavenumbers.
    TransformMultiplyAdd,
    /// Column of the window over a level slice.
    LevelColumn,
    /// Column of the window over a rough slice.
    RoughColumn,
    /// Point in contact on a smooth road, per step.
    SmoothPoint,
    /// Point in contact on a rough road, per step.
    RoughPoint,
    /// Multiply-add of the search.
    SearchMultiplyAdd,
    /// Multiply-add of the transforms of forces to wavenumbers and frequencies.
    VibrationMultiplyAdd,
    /// Pole at a frequency, for velocities.
    VibrationPole,
    /// Fit of a residue of the tangential displacement.
    TangentialPole,
    /// Real operation in the factorisation of boundary elements.
    RadiationOperation,
    /// Evaluation of the acoustic kernel.
    RadiationKernel,
    /// Real multiply-add of the products that give pressures at receivers from forces.
    TransferMultiplyAdd,
    /// Multiply-add of the transforms of forces and pressures over time.
    SoundMultiplyAdd,
    /// Sample of a passage: synthesis and level.
    PassedSample,
    /// Byte of a result array.
    OutputByte,
    /// A plot.
    Plot,
}

impl WorkUnit {
    /// Seconds on one core of an AMD EPYC with AVX-512, release build (measured): used by the checks of plans and where
    /// nothing was measured.
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
    /// Factors by [`Stage`].
    pub stages: [f64; Stage::ALL.len()],
    /// Time of each step outside all stages \[s\].
    pub step: f64,
    /// False for the typical costs, true if measured on this machine.
    pub measured: bool,
}

impl Default for UnitCosts {
    fn default() -> Self {
        Self { stages: [1.0; Stage::ALL.len()], step: 9e-7, measured: false }
    }
}

impl UnitCosts {
    /// Seconds of a unit in a stage.
    pub(crate) fn of(&self, stage: Stage, unit: WorkUnit) -> f64 {
        self.stages[stage as usize] * unit.typical()
    }
}
