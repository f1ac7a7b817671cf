//! Units of work and the cost of each on one core: a typical one, or as measured on this machine and stored beside the
//! fitted models.

use std::fs;
use std::path::PathBuf;

use crate::counters::Stage;
use crate::counters::peak::{instruction_set, processor};
use crate::numeric::digest::sha256;
use crate::storage::input::{self, TABLE_BYTES};
use crate::storage::{Cache, PendingFile};
use serde::{Deserialize, Serialize};

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

/// Costs of work on a machine, relative to the [typical](WorkUnit::typical) cost of its units.
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

/// Name of the record in the cache folder.
const FILE: &str = "calibration.json";

#[derive(Deserialize, Serialize)]
struct Record {
    /// Build of the program and kind of processor.
    machine: String,
    costs: UnitCosts,
}

/// Costs measured before, by this build on this kind of processor; otherwise typical ones.
pub(crate) fn known() -> UnitCosts {
    let read = || {
        let record: Record = serde_json::from_slice(&input::read(&file()?, TABLE_BYTES).ok()?).ok()?;
        (record.machine == machine()).then_some(record.costs)
    };
    read().unwrap_or_default()
}

/// Keeps costs for [`known`]; a failure is ignored, they are measured again.
pub(crate) fn keep(costs: UnitCosts) {
    let record = Record { machine: machine(), costs };
    if let Some(path) = file()
        && let Ok(text) = serde_json::to_string_pretty(&record)
        && path.parent().map_or(Ok(()), fs::create_dir_all).is_ok()
    {
        // Another process may do the same: each has a temporary file until it is complete.
        let _ = PendingFile::create(&path).and_then(|file| file.complete(&text));
    }
}

fn file() -> Option<PathBuf> {
    Cache::open().ok().map(|cache| cache.folder().join(FILE))
}

/// Build (size and time of the program's file) and processor.
fn machine() -> String {
    let program = std::env::current_exe().and_then(fs::metadata).ok();
    let size = program.as_ref().map_or(0, fs::Metadata::len);
    let time = program.and_then(|file| file.modified().ok()).map(|time| format!("{time:?}")).unwrap_or_default();
    let model = processor().unwrap_or_default();
    sha256(&[env!("CARGO_PKG_VERSION"), &size.to_string(), &time, &model, instruction_set()])
}
