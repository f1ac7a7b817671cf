//! What is counted.

use serde::Serialize;

/// An exact work counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Counter {
    /// Evaluations of the layered compliance at one wavenumber and one s.
    ComplianceEvaluations,
    /// Poles of the rational models, conjugates counted.
    Poles,
    /// Multiply-adds of the history.
    HistoryMultiplyAdds,
    /// Road slices made.
    Slices,
    /// Time steps.
    Steps,
    /// Active-set iterations (linear solves).
    Solves,
    /// Factorisations of an active-set matrix.
    Factorisations,
    /// Active sets whose factor was cached.
    CacheHits,
    /// Active sets whose factor was not cached.
    CacheMisses,
    /// Active sets solved with the factor of one that differs by few points.
    Neighbours,
    /// Factors dropped from the cache.
    CacheEvictions,
    /// Steps in which the least-index fallback took over.
    Fallbacks,
    /// Steps in which an outermost candidate of the window carried force.
    WindowEdgeContacts,
    /// Transforms of the vibration, over time and over the elements.
    VibrationTransforms,
    /// Velocities for unit force evaluated, by wavenumber and frequency.
    VibrationEvaluations,
    /// Frequencies that boundary elements were solved at.
    RadiationSolves,
    /// Evaluations of the acoustic kernel between two nodes.
    RadiationKernels,
    /// Transforms of the sound, over time.
    SoundTransforms,
    /// Bytes written to result arrays.
    BytesWritten,
}

impl Counter {
    /// All counters in order.
    pub const ALL: [Self; 19] = [
        Self::ComplianceEvaluations,
        Self::Poles,
        Self::HistoryMultiplyAdds,
        Self::Slices,
        Self::Steps,
        Self::Solves,
        Self::Factorisations,
        Self::CacheHits,
        Self::CacheMisses,
        Self::Neighbours,
        Self::CacheEvictions,
        Self::Fallbacks,
        Self::WindowEdgeContacts,
        Self::VibrationTransforms,
        Self::VibrationEvaluations,
        Self::RadiationSolves,
        Self::RadiationKernels,
        Self::SoundTransforms,
        Self::BytesWritten,
    ];
}

impl Counter {
    /// Whether none of it is worth telling.
    pub const fn counts_trouble(self) -> bool {
        matches!(self, Self::Fallbacks | Self::WindowEdgeContacts)
    }
}
