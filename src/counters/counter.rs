//! Exact work counters.

use super::catalogue::catalogue;

catalogue! {
    /// An exact work counter.
    pub enum Counter,
    /// Name of the counter in printed tables.
    title {
        /// Evaluations of the layered compliance at one wavenumber and one s.
        ComplianceEvaluations => "compliance evaluations",
        /// Poles of the rational models, conjugates counted.
        Poles => "poles of the influence functions",
        /// Multiply-adds of the convolution over past forces.
        HistoryMultiplyAdds => "history multiply-adds",
        /// Road slices made.
        Slices => "road slices",
        /// Time steps.
        Steps => "time steps",
        /// Active-set iterations (linear solves).
        Solves => "linear solves",
        /// Factorisations of an active-set matrix.
        Factorisations => "factorisations",
        /// Factorisations of a band of an active-set matrix, whose solutions are corrected iteratively.
        Bands => "factorisations of a band",
        /// Bands whose corrections converged too slowly: the whole matrix was factorised, too.
        Refactorisations => "bands given up for the whole matrix",
        /// Active sets whose factor was cached.
        CacheHits => "factor cache hits",
        /// Active sets whose factor was not cached.
        CacheMisses => "factor cache misses",
        /// Active sets solved with the cached factor of a set that differs by few points.
        Neighbours => "misses that a neighbour's factor served",
        /// Factors dropped from the cache.
        CacheEvictions => "factor cache evictions",
        /// Steps in which the least-index fallback took over.
        Fallbacks => "least-index fallbacks",
        /// Steps in which an outermost candidate of the window carried force: the window may be too short.
        WindowEdgeContacts => "steps with contact at the window's edge",
        /// Fourier transforms of the vibration, over time and over the elements.
        VibrationTransforms => "transforms of the vibration",
        /// Velocities for unit force evaluated, by wavenumber and frequency.
        VibrationEvaluations => "evaluations of the vibration's transfers",
        /// Frequencies at which boundary elements were solved.
        RadiationSolves => "frequencies of the radiation solved",
        /// Evaluations of the acoustic kernel between two nodes.
        RadiationKernels => "kernels of the radiation",
        /// Fourier transforms of the sound, over time.
        SoundTransforms => "transforms of the sound",
        /// Passes over the transfers to all receivers, each for all blocks of the sound that wait.
        SoundPasses => "passes over the sound's transfers",
        /// Bytes written to result arrays.
        BytesWritten => "bytes written",
    }
}

impl Counter {
    /// True for counters of trouble, which are not printed when they are zero.
    pub const fn counts_trouble(self) -> bool {
        matches!(self, Self::Fallbacks | Self::Refactorisations | Self::WindowEdgeContacts)
    }
}
